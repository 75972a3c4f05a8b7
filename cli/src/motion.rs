//! From a simulation to its figures: the motion in its plane, and its quantities over time.

use crate::{PublishedData, Quantity};
use hangtime::model::Model;
use hangtime::simulation::{EventKind, Simulation};

use crate::drawing::{Drawing, Placed, frame, zigzag};
use crate::figure::{COLOURS, Motion, Panel, Path, Series};
use crate::quantity;
use crate::sampling::{State, dense, state_at};

/// Width of the coils of a spring, as a share of the width of the picture.
const COILS: f64 = 0.012;
/// Most impacts that are marked.
const MOST_MARKS: usize = 1_000;
/// About how many instants a time lapse shows where none is published.
const LAPSES: f64 = 12.0;

/// The picture of a simulation, beside published positions if there are any.
pub(crate) fn picture(
    title: String,
    drawing: &Drawing<'_>,
    model: &dyn Model,
    simulation: &Simulation,
    published: &PublishedData,
) -> Motion {
    let trajectory = &simulation.trajectory;
    let end = trajectory.time.last().copied().unwrap_or_default();
    let (times, lapse) = lapses(end, published);
    let at = |states: Vec<State>| -> Vec<Placed> {
        states.iter().map(|state| drawing.at(state)).collect()
    };
    let instants = times
        .iter()
        .filter_map(|&t| state_at(model, trajectory, t.min(end)));
    let time_lapse = at(instants.collect());
    let path = at(dense(model, trajectory));
    let shown = published.points.iter().flat_map(|point| &point.positions);
    let extents: Vec<[f64; 2]> = time_lapse
        .iter()
        .flat_map(|placed| placed.extent(&drawing.bodies))
        .collect();
    let places = path.iter().flat_map(|placed| &placed.places);
    let frame = frame(places.chain(&extents).chain(shown));
    let coils = COILS * (frame[0][1] - frame[0][0]);
    let lines = time_lapse.iter().flat_map(|placed| {
        let ends = placed.ends.iter().zip(&drawing.springs);
        ends.map(|(&ends, &spring)| match spring {
            true => zigzag(ends, coils),
            false => ends.to_vec(),
        })
    });
    let bodies = drawing.bodies.iter().enumerate();
    // A body that stands still is not marked where others strike.
    let moves = |index: usize| {
        let mut places = path.windows(2);
        places.any(|pair| pair[0].places[index] != pair[1].places[index])
    };
    let moving: Vec<usize> = (0..drawing.bodies.len()).filter(|&i| moves(i)).collect();
    let events = simulation.events.iter();
    let impacts = events.filter(|event| event.kind == EventKind::Impact);
    Motion {
        title,
        axes: drawing.axes.clone(),
        frame,
        ground: drawing.ground(frame),
        lines: lines.collect(),
        paths: bodies
            .map(|(index, body)| Path {
                name: body.name,
                points: path.iter().map(|placed| placed.places[index]).collect(),
                time_lapse: time_lapse
                    .iter()
                    .map(|placed| placed.places[index])
                    .collect(),
                outlines: time_lapse
                    .iter()
                    .map(|placed| closed(placed.outline(index, body)))
                    .filter(|outline| !outline.is_empty())
                    .collect(),
            })
            .collect(),
        start: path
            .first()
            .map_or_else(Vec::new, |placed| placed.places.clone()),
        impacts: impacts
            .take(MOST_MARKS)
            .flat_map(|event| {
                let placed = drawing.placed(&event.q, &event.v_after, &[], event.time);
                moving.iter().map(move |&index| placed.places[index])
            })
            .collect(),
        published: published.points.clone(),
        lapse,
    }
}

/// An outline that ends where it begins.
fn closed(mut outline: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    outline.extend(outline.first().copied());
    outline
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
    let states = dense(model, &simulation.trajectory);
    quantity::all(model)
        .into_iter()
        .map(|quantity| {
            let unit = match published.curve(quantity) {
                Some(curve) => curve.unit.to_owned(),
                None => quantity::unit(model, quantity),
            };
            let series = series(model, quantity, &unit, &states, published);
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
    Panel {
        title: quantity::title(model, quantity),
        label: quantity::label(model, quantity, unit),
        bounds: quantity::bounds(model, quantity)
            .into_iter()
            .filter_map(|bound| quantity::converted(model, quantity, bound, unit))
            .collect(),
        series,
    }
}

/// The line of one quantity in `unit`, and its published dots.
pub(crate) fn series(
    model: &dyn Model,
    quantity: Quantity,
    unit: &str,
    states: &[State],
    published: &PublishedData,
) -> Series {
    let value = |state: &State| {
        let value = quantity::converted(model, quantity, state.value(quantity)?, unit)?;
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
