//! Elements in which polynomials through the nodes of a collocation scheme follow a re-simulation.
//!
//! Where a fast state settles after a jump of the controls these are short at the start of an interval, and become longer away from it.

use super::dense::{Dense, Step};
use crate::ocp::collocation::bounds::Bounds;
use crate::ocp::collocation::dense_motion::DenseMotion;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::control_grid::Mesh;
use crate::yardstick;

/// Share of the difference that is none by which such polynomials may be off: the nodes of a plan are off as well. Chosen.
const AIM: f64 = 0.25;

/// Most elements of a phase, as many as of equal ones, and the shortest that is halved, a share of the phase: of a layer of a ten
/// thousandth. Chosen.
const MOST_ELEMENTS: usize = 64;
const SHORTEST: f64 = 1e-5;

/// A re-simulation and the bounds that are looked at along it.
pub(super) struct Follower<'f> {
    pub(super) setting: Setting<'f>,
    pub(super) bounds: &'f Bounds<'f>,
    pub(super) dense: &'f Dense<'f>,
    pub(super) steps: &'f [Step],
    /// The bounds at which a plan differs from it, and what agrees there.
    pub(super) differ: &'f [(usize, f64)],
}

impl Follower<'_> {
    /// The elements of each interval, so many now, halved where polynomials do not follow the re-simulation at these bounds; all of them in
    /// intervals in which the plan differs, if they do; none where there are too many already.
    pub(super) fn finer(
        &self,
        elements: &[usize],
        plan: &DenseMotion,
        differs: &[bool],
    ) -> Option<Mesh> {
        let mut refined = false;
        let ends = differs.iter().zip(elements).enumerate();
        let ends = ends.map(|(interval, (&differs, &count))| {
            let known = self.setting.ends(interval, count);
            if count >= MOST_ELEMENTS {
                return known;
            }
            let parts = plan.program.phases.iter().zip(&plan.solved);
            let parts = parts.filter(|(phase, _)| phase.interval == interval);
            let parts: Vec<_> = parts.map(|(_, solved)| solved).collect();
            let phases = parts.chunks(count).map(|parts| {
                let last = parts[parts.len() - 1];
                self.at_events((parts[0].start, last.start + last.length))
            });
            let phases: Vec<(f64, f64)> = phases.collect();
            let finer = halved(&known, &|share| {
                let mut phases = phases.iter();
                phases.all(|&phase| self.follows(phase, share))
            });
            refined |= differs || finer.len() > count;
            if finer.len() > count || !differs {
                return finer;
            }
            let is_end = |share: f64| share == 0.0 || known.contains(&share);
            halved(&known, &|(from, to)| !(is_end(from) && is_end(to)))
        });
        let ends = ends.collect();
        refined.then_some(ends)
    }

    /// A phase of the plan from its start to its end, at the events of the re-simulation where these are near.
    fn at_events(&self, (from, to): (f64, f64)) -> (f64, f64) {
        let let_pass = yardstick::PROMISE * self.dense.horizon;
        let near = |time: f64| {
            let near = move |event: &f64| (event - time).abs() <= let_pass;
            self.dense.events().filter(near)
        };
        let (start, end) = (near(from).fold(from, f64::max), near(to).fold(to, f64::min));
        (start, end)
    }

    /// Whether the polynomials through the nodes of a share of a phase follow the re-simulation at those bounds.
    fn follows(&self, (start, end): (f64, f64), (from, to): (f64, f64)) -> bool {
        let (steps, rounding) = (self.steps, yardstick::ROUNDING * self.dense.horizon);
        let at = |theta: f64| {
            let time = start + (from + theta * (to - from)) * (end - start);
            // What begins at an instant, and what ends there.
            let step = match theta == 0.0 {
                true => steps.partition_point(|step| step.to <= time + rounding),
                false => {
                    steps
                        .partition_point(|step| step.from < time - rounding)
                        .max(1)
                        - 1
                }
            };
            self.dense.input(&steps[step.min(steps.len() - 1)], time)
        };
        let tableau = self.setting.tableau;
        let places = [&[0.0], tableau.c()].concat();
        let nodes: Vec<Vec<f64>> = places.iter().map(|&theta| at(theta)).collect();
        places.windows(2).all(|ends| {
            let middle = 0.5 * (ends[0] + ends[1]);
            let real = at(middle);
            let mut followed = vec![0.0; real.len()];
            for (node, weight) in nodes.iter().zip(tableau.values_with_start(middle)) {
                let slots = followed.iter_mut().zip(node);
                slots.for_each(|(slot, value)| *slot += weight * value);
            }
            let [real, followed] = [real, followed].map(|x| self.bounds.values(x));
            let mut differ = self.differ.iter();
            differ.all(|&(k, agrees)| (real[k] - followed[k]).abs() <= AIM * agrees)
        })
    }
}

/// Ends of elements, halved again and again until that is so of each.
fn halved(ends: &[f64], is_fine: &dyn Fn((f64, f64)) -> bool) -> Vec<f64> {
    let mut left: Vec<f64> = ends.iter().rev().copied().collect();
    let (mut halved, mut from) = (Vec::new(), 0.0);
    while let Some(&to) = left.last() {
        let is_last = halved.len() + left.len() >= MOST_ELEMENTS || to - from < SHORTEST;
        if is_last || is_fine((from, to)) {
            halved.extend(left.pop());
            from = to;
        } else {
            left.push(0.5 * (from + to));
        }
    }
    halved
}
