//! Derivatives to one side, where a motion has none: limits of those of motions nearby, which have them.
//!
//! To each side of a value at which a surface is grazed, or at which two events coincide, the order of events is one, and the end
//! of the motion is a smooth function `x(p)` there. Its derivative at `p + h`, `p + h/2` and `p + h/4` gives the limit for
//! `h -> 0` with an error of `h^3` (Richardson).
//!
//! Where a graze is struck the speed of the impact is a square root of `h`, and so is what it changes: `x = x_0 + a sqrt(h) + b h + ..`.
//! There the derivative is infinite, and `a` is what says how the value moves. Of the derivatives `d_k` at `h/2^k` it is
//!
//! ```text
//! a = 2 sqrt(h) (r d_0 - (1 + r) d_1 + d_2)/(1 - r),  r = 1/sqrt(2)
//! ```
//!
//! without what the two next terms leave; those at half of the distances have to give the same. Where neither do there is no limit.

use super::gradient::{Gradient, GradientMode, differentiate_values};
use super::quantities::By;
use super::sides::{OneSided, Side};
use crate::InputError;
use crate::linalg::products::largest;
use crate::model::Model;
use crate::simulation::{EventDriven, InitialValueProblem, Quantity, Simulation, Simulator as _};
use crate::yardstick;

/// Distance of the farthest motion that is looked at, as a share of the value.
const DISTANCE: f64 = 1e-4;
/// Share of a derivative by which two limits of it may differ. Regular ones differ by about the square of the distance.
const AGREE: f64 = 1e-4;
/// Part of the way to the nearest neighbour that the end may move beyond its derivative: the end is a continuous function.
const JUMP: f64 = 4.0;
/// Tolerance of a neighbour that steps between events have to find: where next to nothing moves, elements may miss theirs.
const TOLERANCE: f64 = 1e-10;
/// Share of the largest value that is the error of a motion.
const ERROR: f64 = 1e-7;
/// Simulates a scene from a start.
pub type Simulate<'s> =
    dyn FnMut(&dyn Model, &InitialValueProblem) -> Result<Simulation, InputError> + 's;

/// Adds the derivatives to one side to a `gradient` of the motion `run` of a scene from a start, by the quantities by which it has none from
/// some instant on, by simulating neighbours.
pub fn add_one_sided(
    gradient: &mut Gradient,
    (model, problem): (&dyn Model, &InitialValueProblem),
    run: &Simulation,
    simulate: &mut Simulate<'_>,
) {
    let ends = ends(run);
    if ends.is_empty() || gradient.obstacle.is_none() || !run.status.is_solved() {
        return;
    }
    let of: Vec<String> = gradient
        .values
        .iter()
        .map(|known| known.0.clone())
        .collect();
    let known = Known {
        rows: rows_of_state(model, &of),
        ends,
        of,
    };
    let mut side = |sense: f64| {
        let columns = gradient.with_respect_to.iter().zip(&gradient.obstacles);
        let columns: Vec<Vec<Limit>> = columns
            .map(|(name, obstacle)| match obstacle {
                Some(_) => limits((model, problem), &known, (name, sense), simulate),
                None => Vec::new(),
            })
            .collect();
        known.side(problem.q.len(), &columns)
    };
    let (below, above) = (side(-1.0), side(1.0));
    let exists = |side: &Side| {
        let mut rows = side.q.iter().chain(&side.v).flatten();
        rows.any(|by| !by.is_nan())
    };
    if exists(&below) || exists(&above) {
        gradient.one_sided = Some(Box::new(OneSided { below, above }));
    }
}

/// What is known of the motion itself.
struct Known {
    /// States `(q, v)` at the end: of two the first is that before an event there.
    ends: Vec<Vec<f64>>,
    /// Names of the chosen values, and the component of `(q, v)` that each is, if it is one.
    of: Vec<String>,
    rows: Vec<Option<usize>>,
}

impl Known {
    /// The limits of all quantities as rows.
    fn side(&self, n: usize, columns: &[Vec<Limit>]) -> Side {
        let row = |i: usize, of: fn(&Limit) -> f64| -> Vec<f64> {
            columns
                .iter()
                .map(|column| column.get(i).map_or(f64::NAN, of))
                .collect()
        };
        let by = |i: usize| row(i, |limit| limit.by);
        let values = 2 * n + self.of.len();
        let objective = columns.iter().any(|column| column.len() > values);
        let rows = values + usize::from(objective);
        let rooted = columns.iter().flatten().any(|limit| limit.root != 0.0);
        let roots = if rooted { rows } else { 0 };
        Side {
            q: (0..n).map(by).collect(),
            v: (n..2 * n).map(by).collect(),
            values: (2 * n..)
                .zip(&self.of)
                .map(|(i, name)| (name.clone(), by(i)))
                .collect(),
            objective: objective.then(|| by(values)),
            roots: (0..roots).map(|i| row(i, |limit| limit.root)).collect(),
        }
    }

    /// Whether the end of a motion goes over into a known one with its distance, for each row of its derivatives: nothing else is known
    /// of those that are no components of the state, which do so where all of these do.
    fn continuous(&self, near: &Neighbour) -> Vec<bool> {
        let size = largest(&near.by);
        let states = near.end.iter().enumerate().map(|(i, value)| {
            let mut ends = self.ends.iter();
            ends.any(|end| {
                // Where a body rests at 0 nothing else tells than the units of the scene.
                let error = ERROR * largest(end).max(yardstick::NOTHING);
                (value - end[i]).abs() <= JUMP * near.distance * size + error
            })
        });
        let states: Vec<bool> = states.collect();
        let all = states.iter().all(|goes_over| *goes_over);
        let of_value = |row: &Option<usize>| row.map_or(all, |row| states[row]);
        let values: Vec<bool> = self.rows.iter().map(of_value).collect();
        let mut rows = [states, values].concat();
        rows.resize(near.by.len(), all);
        rows
    }
}

/// The components of `(q, v)` that values of these names are.
fn rows_of_state(model: &dyn Model, of: &[String]) -> Vec<Option<usize>> {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let row = |name: &String| match Quantity::named(declaration, model.outputs(), name)? {
        Quantity::Coordinate(k) => Some(k),
        Quantity::Velocity(k) => Some(n + k),
        _ => None,
    };
    of.iter().map(row).collect()
}

/// The states of a motion at its last time.
fn ends(run: &Simulation) -> Vec<Vec<f64>> {
    let trajectory = &run.trajectory;
    let Some(&last) = trajectory.time.last() else {
        return Vec::new();
    };
    let first = trajectory
        .time
        .partition_point(|&t| t < last * (1.0 - yardstick::ROUNDING));
    (first..trajectory.time.len())
        .map(|k| [&trajectory.q[k][..], &trajectory.v[k]].concat())
        .collect()
}

/// A derivative to one side.
#[derive(Clone, Copy)]
struct Limit {
    /// Not a number where there is none.
    by: f64,
    /// What the root of the distance is multiplied by; 0 where the derivative is finite.
    root: f64,
}

/// The end of a motion nearby, and its derivatives.
struct Neighbour {
    /// `(q, v)`.
    end: Vec<f64>,
    /// Of these by the quantity, of the chosen values, and of the objective in a scene that declares one.
    by: Vec<f64>,
    /// How far the quantity is away.
    distance: f64,
}

/// The limits of the derivatives of `(q, v)` and of the chosen values at the end, and of the objective, by one quantity; empty where
/// neighbours have none.
fn limits(
    scene: (&dyn Model, &InitialValueProblem),
    known: &Known,
    (name, sense): (&str, f64),
    simulate: &mut Simulate<'_>,
) -> Vec<Limit> {
    let mut at =
        |share: f64| neighbour(scene, (name, &known.of), sense * share * DISTANCE, simulate);
    let (Some(far), Some(middle), Some(near)) = (at(1.0), at(0.5), at(0.25)) else {
        return Vec::new();
    };
    let continuous = known.continuous(&near);
    let size = largest(&near.by);
    let same = |one: f64, other: f64| {
        (other - one).abs() <= AGREE * other.abs() + yardstick::NOTHING * size
    };
    let mut nearest = None;
    let rows = 0..near.by.len();
    rows.map(|i| {
        let none = Limit {
            by: f64::NAN,
            root: 0.0,
        };
        let by = |of: &Neighbour| of.by.get(i).copied().unwrap_or(f64::NAN);
        if !continuous[i] {
            return none;
        }
        let (first, second) = (2.0 * by(&middle) - by(&far), 2.0 * by(&near) - by(&middle));
        if same(first, second) {
            let by = (4.0 * second - first) / 3.0;
            return Limit { by, root: 0.0 };
        }
        let Some(nearest) = nearest.get_or_insert_with(|| at(0.125)).as_ref() else {
            return none;
        };
        let first = root(far.distance, [by(&far), by(&middle), by(&near)]);
        let second = root(middle.distance, [by(&middle), by(&near), by(nearest)]);
        if !same(first, second) || second == 0.0 {
            return none;
        }
        // What is left out of both is as h^(3/2).
        let ratio = std::f64::consts::SQRT_2.powi(3);
        Limit {
            by: f64::INFINITY.copysign(second),
            root: sense * (ratio * second - first) / (ratio - 1.0),
        }
    })
    .collect()
}

/// What the root of the distance is multiplied by in a value with these derivatives at a distance, half of it and a quarter of it.
fn root(distance: f64, [far, middle, near]: [f64; 3]) -> f64 {
    let r = std::f64::consts::FRAC_1_SQRT_2;
    2.0 * distance.sqrt() * (r * far - (1.0 + r) * middle + near) / (1.0 - r)
}

/// The motion with a quantity that is changed by that share of its size.
fn neighbour(
    (model, problem): (&dyn Model, &InitialValueProblem),
    (name, of): (&str, &[String]),
    share: f64,
    simulate: &mut Simulate<'_>,
) -> Option<Neighbour> {
    let quantity = By::named(model, name).ok()?;
    let way = share * quantity.size(model, problem);
    let (model, problem) = quantity.moved(model, problem, way);
    let run = simulate(&*model, &problem).ok();
    let run = run.filter(|run| run.status.is_solved()).or_else(|| {
        let mut other = EventDriven::default();
        other.set_tolerance(TOLERANCE).ok()?;
        other.simulate(&*model, &problem, &mut |_| true).ok()
    })?;
    let of = (of, Some(GradientMode::Forward));
    let by = [name.to_owned()];
    let gradient = differentiate_values(&*model, (&problem, &run), &by, of).ok()?;
    if gradient.obstacle.is_some() {
        return None;
    }
    let rows = gradient.q.iter().chain(&gradient.v);
    let rows = rows.chain(gradient.values.iter().map(|known| &known.1));
    let mut by: Vec<f64> = rows
        .map(|row| row.first().copied().unwrap_or(f64::NAN))
        .collect();
    by.extend(gradient.objective.iter().flatten());
    Some(Neighbour {
        end: ends(&run).pop()?,
        by,
        distance: way.abs(),
    })
}
