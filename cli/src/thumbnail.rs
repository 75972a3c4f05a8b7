//! Small pictures of motions for lists of scenes: a few kilobytes of SVG that take the colour of the text around them.

use std::fmt::Write as _;

use hangtime::model::Model;
use hangtime::simulation::Simulation;

use crate::Quantity;
use crate::drawing::{Drawing, Placed, ranges, zigzag};
use crate::figure::{COLOURS, line};
use crate::quantity;
use crate::sampling::{State, state_at};

/// Size of the picture, in its own units.
const SIZE: [f64; 2] = [320.0, 180.0];
/// Free space around what moves.
const MARGIN: f64 = 12.0;
/// Instants of a path.
const PATH: usize = 480;
/// Bodies are drawn at so many of them, evenly over the motion.
const LAPSES: usize = 6;
/// Points nearer than this to the line through their neighbours are left out.
const FLAT: f64 = 0.15;
/// Half the width of the coils of a spring.
const COILS: f64 = 5.0;
/// Radius of a point.
const DOT: f64 = 4.0;

type Point = [f64; 2];

/// The picture of a motion: in its plane, or as curves where nothing is drawn in a plane. `None` if nothing moved.
pub(crate) fn thumbnail(
    drawing: Option<&Drawing<'_>>,
    model: &dyn Model,
    simulation: &Simulation,
) -> Option<String> {
    let trajectory = &simulation.trajectory;
    let (first, last) = (*trajectory.time.first()?, *trajectory.time.last()?);
    if last <= first {
        return None;
    }
    let times = (0..=PATH).map(|k| first + (last - first) * (k as f64 / PATH as f64));
    let states = times.filter_map(|t| state_at(model, trajectory, t));
    let states: Vec<State> = states.collect();
    let drawn = drawing.and_then(|drawing| plane(drawing, &states));
    let inside = drawn.or_else(|| curves(model, &states))?;
    let [width, height] = SIZE;
    Some(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" fill=\"none\" stroke-linejoin=\"round\">\n{inside}</svg>\n"
    ))
}

/// From a plane to the picture: equal scales, the vertical axis upwards.
struct View {
    scale: f64,
    /// The middle of what is shown.
    middle: Point,
}

impl View {
    /// Shows all points; `None` where they have no extent, or no place.
    fn of(points: &[Point]) -> Option<Self> {
        let ranges = ranges(points);
        let scales = [0, 1].map(|axis| {
            let [low, high] = ranges[axis];
            (SIZE[axis] - 2.0 * MARGIN) / (high - low)
        });
        let scale = scales[0].min(scales[1]);
        (scale.is_finite() && scale > 0.0).then(|| Self {
            scale,
            middle: ranges.map(|[low, high]| 0.5 * (low + high)),
        })
    }

    fn place(&self, [across, up]: Point) -> Point {
        let [width, height] = SIZE;
        [
            0.5 * width + self.scale * (across - self.middle[0]),
            0.5 * height - self.scale * (up - self.middle[1]),
        ]
    }

    /// What can be seen: from left to right, from bottom to top.
    fn seen(&self) -> [Point; 2] {
        [0, 1].map(|axis| {
            let half = 0.5 * SIZE[axis] / self.scale;
            [self.middle[axis] - half, self.middle[axis] + half]
        })
    }

    fn places(&self, points: &[Point]) -> Vec<Point> {
        points.iter().map(|&point| self.place(point)).collect()
    }
}

/// Ground, paths, and bodies at some instants.
fn plane(drawing: &Drawing<'_>, states: &[State]) -> Option<String> {
    let placed: Vec<Placed> = states.iter().map(|state| drawing.at(state)).collect();
    let extents = placed
        .iter()
        .flat_map(|placed| placed.extent(&drawing.bodies));
    let extents: Vec<Point> = extents.collect();
    let view = View::of(&extents)?;
    let mut svg = String::new();
    for line in drawing.ground(view.seen()) {
        push_path(
            &mut svg,
            &view.places(&line.points),
            "stroke=\"currentColor\" stroke-opacity=\".55\" stroke-width=\"2\"",
        );
    }
    for index in 0..drawing.bodies.len() {
        let path: Vec<Point> = placed.iter().map(|placed| placed.places[index]).collect();
        let colour = COLOURS[index % COLOURS.len()];
        push_path(
            &mut svg,
            &view.places(&path),
            &format!("stroke=\"{colour}\" stroke-opacity=\".7\" stroke-width=\"1.5\""),
        );
    }
    for lapse in 0..LAPSES {
        let placed = placed.get(lapse * PATH / (LAPSES - 1))?;
        // What comes later stands out.
        let share = (lapse + 1) as f64 / LAPSES as f64;
        for (&ends, &spring) in placed.ends.iter().zip(&drawing.springs) {
            let ends = ends.map(|end| view.place(end));
            let corners = if spring {
                zigzag(ends, COILS)
            } else {
                ends.to_vec()
            };
            push_path(
                &mut svg,
                &corners,
                &format!(
                    "stroke=\"currentColor\" stroke-opacity=\"{:.2}\" stroke-width=\"1.5\"",
                    0.7 * share
                ),
            );
        }
        for (index, body) in drawing.bodies.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let mut outline = view.places(&placed.outline(index, body));
            if outline.is_empty() {
                let [x, y] = view.place(placed.places[index]);
                let _ = writeln!(
                    svg,
                    "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{DOT}\" fill=\"{colour}\" fill-opacity=\"{share:.2}\"/>"
                );
                continue;
            }
            outline.extend(outline.first().copied());
            push_path(
                &mut svg,
                &outline,
                &format!(
                    "fill=\"{colour}\" fill-opacity=\"{:.2}\" stroke=\"{colour}\" stroke-opacity=\"{share:.2}\"",
                    0.4 * share
                ),
            );
        }
    }
    Some(svg)
}

/// Coordinates and states over time, in one range of values.
fn curves(model: &dyn Model, states: &[State]) -> Option<String> {
    let declaration = model.declaration();
    let shown = |quantity: &Quantity| match *quantity {
        Quantity::Coordinate(_) => true,
        Quantity::Velocity(index) => declaration.state(index).is_some(),
        _ => false,
    };
    let quantities: Vec<Quantity> = quantity::all(model).into_iter().filter(shown).collect();
    let line = |&quantity: &Quantity| -> Vec<Point> {
        let points = states
            .iter()
            .filter_map(|state| Some([state.time, state.value(quantity)?]));
        points.collect()
    };
    let lines: Vec<Vec<Point>> = quantities.iter().map(line).collect();
    let values = || lines.iter().flatten().map(|point| point[1]);
    let (low, high) = (
        values().fold(f64::INFINITY, f64::min),
        values().fold(f64::NEG_INFINITY, f64::max),
    );
    let (first, last) = (states.first()?.time, states.last()?.time);
    if !(low.is_finite() && high.is_finite() && high > low) {
        return None;
    }
    let [width, height] = SIZE.map(|size| size - 2.0 * MARGIN);
    let place = |&[time, value]: &Point| {
        [
            MARGIN + width * (time - first) / (last - first),
            MARGIN + height * (high - value) / (high - low),
        ]
    };
    let mut svg = String::new();
    if low < 0.0 && high > 0.0 {
        let axis = [[first, 0.0], [last, 0.0]].map(|point| place(&point));
        push_path(
            &mut svg,
            &axis,
            "stroke=\"currentColor\" stroke-opacity=\".35\"",
        );
    }
    for (index, line) in lines.iter().enumerate() {
        let points: Vec<Point> = line.iter().map(place).collect();
        let colour = COLOURS[index % COLOURS.len()];
        push_path(
            &mut svg,
            &points,
            &format!("stroke=\"{colour}\" stroke-width=\"2\""),
        );
    }
    Some(svg)
}

/// A line through points, without those that it hardly needs.
fn push_path(svg: &mut String, points: &[Point], style: &str) {
    if points.len() < 2 || !points.as_flattened().iter().all(|x| x.is_finite()) {
        return;
    }
    line(svg, simplified(points).into_iter(), style);
}

/// The points that a line needs to be nowhere farther than [`FLAT`] from all (Douglas and Peucker 1973).
fn simplified(points: &[Point]) -> Vec<Point> {
    let mut kept = vec![false; points.len()];
    let mut open = vec![(0, points.len() - 1)];
    while let Some((from, to)) = open.pop() {
        kept[from] = true;
        kept[to] = true;
        let inner = (from + 1..to).map(|k| (distance(points[k], points[from], points[to]), k));
        let farthest = inner.max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((far, k)) = farthest
            && far > FLAT
        {
            open.extend([(from, k), (k, to)]);
        }
    }
    let points = points.iter().zip(kept).filter(|(_, kept)| *kept);
    points.map(|(&point, _)| point).collect()
}

/// How far a point is from the line between two others.
fn distance([x, y]: Point, [x0, y0]: Point, [x1, y1]: Point) -> f64 {
    let [u, v] = [x1 - x0, y1 - y0];
    let square = u * u + v * v;
    let along = if square > 0.0 {
        (((x - x0) * u + (y - y0) * v) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (x - x0 - along * u).hypot(y - y0 - along * v)
}

#[cfg(test)]
mod tests {
    use super::{FLAT, distance, simplified};

    #[test]
    fn line_keeps_its_corners_and_is_nowhere_farther_than_said() {
        let bent: Vec<[f64; 2]> = (0..=100)
            .map(|k| {
                let x = f64::from(k);
                [x, (x - 40.0).abs()]
            })
            .collect();
        assert_eq!(simplified(&bent), [[0.0, 40.0], [40.0, 0.0], [100.0, 60.0]]);
        let wave: Vec<[f64; 2]> = (0..=300)
            .map(|k| [f64::from(k), 50.0 * (f64::from(k) / 20.0).sin()])
            .collect();
        let kept = simplified(&wave);
        assert!(kept.len() < 100, "{}", kept.len());
        for &point in &wave {
            let nearest = kept
                .windows(2)
                .map(|pair| distance(point, pair[0], pair[1]));
            assert!(nearest.fold(f64::INFINITY, f64::min) <= FLAT);
        }
    }
}
