//! From a simulation to its figures: the motion in its plane, and its quantities over time.

use crate::{Plane, PublishedData, Quantity};
use hangtime::model::{Declaration, Model};
use hangtime::simulation::{EventKind, Simulation};

use crate::figure::{COLOURS, Motion, Panel, Path, Series};
use crate::quantity;
use crate::sampling::{State, dense, state_at};

/// Ground drawn on either side of the motion, as a share of its horizontal extent.
const GROUND_AROUND: f64 = 0.25;
/// Most impacts that are marked.
const MOST_MARKS: usize = 1_000;
/// About how many instants a time lapse shows where none is published.
const LAPSES: f64 = 12.0;

/// The picture of a simulation in its plane, beside published positions if there are any.
pub(crate) fn picture(
    title: String,
    plane: &Plane,
    model: &dyn Model,
    simulation: &Simulation,
    published: &PublishedData,
) -> Motion {
    let trajectory = &simulation.trajectory;
    let positions = |q: &[f64]| plane.bodies_at(model, q);
    let end = trajectory.time.last().copied().unwrap_or_default();
    let (times, lapse) = lapses(end, published);
    let time_lapse: Vec<Vec<[f64; 2]>> = times
        .iter()
        .filter_map(|&t| state_at(trajectory, t.min(end)))
        .map(|state| positions(&state.q))
        .collect();
    let path: Vec<Vec<[f64; 2]>> = dense(trajectory)
        .iter()
        .map(|state| positions(&state.q))
        .collect();
    let body = |rows: &[Vec<[f64; 2]>], body: usize| rows.iter().map(|row| row[body]).collect();
    let shown = published.points.iter().flat_map(|point| &point.positions);
    let seen = path.iter().flatten().chain(shown);
    let seen = seen.filter(|[y, _]| y.is_finite());
    let (from, to) = seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), [y, _]| {
        (from.min(*y), to.max(*y))
    });
    // Some ground on either side of the motion.
    let around = GROUND_AROUND * (to - from);
    Motion {
        title,
        axes: plane.axes,
        ground: if from <= to {
            (plane.ground)(model, from - around, to + around)
        } else {
            Vec::new()
        },
        paths: plane
            .bodies
            .iter()
            .enumerate()
            .map(|(index, name)| Path {
                name,
                points: body(&path, index),
                time_lapse: body(&time_lapse, index),
            })
            .collect(),
        links: plane.links,
        start: trajectory
            .q
            .first()
            .map(|q| positions(q))
            .unwrap_or_default(),
        impacts: simulation
            .events
            .iter()
            .filter(|event| event.kind == EventKind::Impact)
            .take(MOST_MARKS)
            .flat_map(|event| positions(&event.q))
            .collect(),
        published: published.points.clone(),
        lapse,
    }
}

/// The instants of the time lapse, and what the legend says about them: those that were published, or else evenly
/// spaced ones.
fn lapses(end: f64, published: &PublishedData) -> (Vec<f64>, String) {
    let points = published.points.iter().filter(|point| point.time_lapse);
    let times: Vec<f64> = points.map(|point| point.time).collect();
    if !times.is_empty() {
        let kept = times.into_iter().filter(|&t| t < end).chain([end]);
        return (kept.collect(), ", time lapse".to_owned());
    }
    if !(end.is_finite() && end > 0.0) {
        return (vec![0.0], " at the start".to_owned());
    }
    let interval = round(end / LAPSES);
    if !interval.is_normal() {
        // So short that the numbers between its ends have lost their digits.
        return (vec![0.0, end], " at start and end".to_owned());
    }
    // A quotient that rounding put just below a whole number still counts as that number.
    let count = (end / interval + 1e-9) as usize;
    let times = (0..=count).map(|k| k as f64 * interval).collect();
    (times, format!(" every {interval} s"))
}

/// The nearest of 1, 2 and 5 times a power of ten, by ratio.
fn round(value: f64) -> f64 {
    let power = value.log10().floor() as i32;
    let candidates = [1.0, 2.0, 5.0, 10.0].map(|digit: f64| {
        // Written and read back, so that 0.2 is the double nearest to it.
        format!("{digit}e{power}").parse().unwrap_or(value)
    });
    let ratio = |candidate: &f64| (candidate / value).ln().abs();
    let nearest = candidates
        .into_iter()
        .min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    nearest.unwrap_or(value)
}

/// A panel for every quantity of the scene, in the unit of the published data if there are any: coordinates and
/// velocities, controls, contact forces.
pub(crate) fn panels(
    model: &dyn Model,
    simulation: &Simulation,
    published: &PublishedData,
) -> Vec<Panel> {
    let declaration = model.declaration();
    let states = dense(&simulation.trajectory);
    quantity::all(declaration)
        .into_iter()
        .map(|quantity| {
            let unit = match published.curve(quantity) {
                Some(curve) => curve.unit.to_owned(),
                None => quantity::unit(declaration, quantity),
            };
            let series = series(declaration, quantity, &unit, &states, published);
            panel(model, quantity, &unit, vec![series])
        })
        .collect()
}

/// A panel of one quantity in `unit`, with its bounds.
pub(crate) fn panel(
    model: &dyn Model,
    quantity: Quantity,
    unit: &str,
    series: Vec<Series>,
) -> Panel {
    let declaration = model.declaration();
    Panel {
        title: quantity::title(declaration, quantity),
        label: quantity::label(declaration, quantity, unit),
        bounds: quantity::bounds(model, quantity)
            .into_iter()
            .filter_map(|bound| quantity::converted(declaration, quantity, bound, unit))
            .collect(),
        series,
    }
}

/// The line of one quantity in `unit`, and its published dots.
pub(crate) fn series(
    declaration: &Declaration,
    quantity: Quantity,
    unit: &str,
    states: &[State],
    published: &PublishedData,
) -> Series {
    let value = |state: &State| {
        let value = quantity::converted(declaration, quantity, state.value(quantity)?, unit)?;
        value.is_finite().then_some((state.time, value))
    };
    let dots = published.curve(quantity).map(|curve| &curve.points[..]);
    let dots = dots.unwrap_or_default();
    Series {
        name: None,
        colour: COLOURS[0],
        dashed: false,
        line: states.iter().filter_map(value).collect(),
        dots: match quantity {
            Quantity::Control(_) => middles(dots),
            _ => dots.iter().map(|&[t, value]| (t, value)).collect(),
        },
    }
}

/// The values of a piecewise constant quantity in the middle of their intervals, all of which have the length of the
/// first one.
fn middles(starts: &[[f64; 2]]) -> Vec<(f64, f64)> {
    let half = match starts {
        [first, second, ..] => (second[0] - first[0]) / 2.0,
        _ => 0.0,
    };
    starts.iter().map(|&[t, value]| (t + half, value)).collect()
}

#[cfg(test)]
mod tests {
    use super::{lapses, round};
    use crate::published::PublishedData;

    #[test]
    fn lapses_of_any_horizon_are_few_and_end_within_it() {
        for end in [5e-324, 1e-300, 3e-5, 5.0, 1e300, f64::MAX] {
            let (times, _) = lapses(end, &PublishedData::default());
            assert!((2..30).contains(&times.len()), "{end:e}: {}", times.len());
            assert!(times.iter().all(|&t| t <= end * (1.0 + 1e-9)), "{end:e}");
        }
    }

    #[test]
    fn round_takes_the_nearest_simple_number() {
        assert_eq!(round(0.118), 0.1);
        assert_eq!(round(0.17), 0.2);
        assert_eq!(round(0.42), 0.5);
        assert_eq!(round(0.9), 1.0);
        assert_eq!(round(37.0), 50.0);
    }
}
