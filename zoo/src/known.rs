//! The best values that are known.

/// Scene, control intervals, and objective: the least of all confirmed motions seen with one start, the default, and up to
/// 24 starts while the search was developed, or by the time-freezing formulation. A grid that contains another one has at least its value.
const BEST: &str = include_str!("../best.csv");

/// The best value known of a scene on a grid of the controls, whichever way it was found.
#[must_use]
pub fn best(name: &str, intervals: usize) -> Option<f64> {
    let row = format!("{name},{intervals},");
    let value = BEST.lines().find_map(|line| line.strip_prefix(&row))?;
    value.parse().ok()
}
