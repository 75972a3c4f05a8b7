//! Derivatives to one side, where a motion has none: limits of those of motions nearby, which have them.
//!
//! To each side of a value at which a surface is grazed, or at which two events coincide, the order of events is one, and the end
//! of the motion is a smooth function `x(p)` there. Its derivative at `p + h`, `p + h/2` and `p + h/4` gives the limit for
//! `h -> 0` with an error of `h^3` (Richardson); where these do not agree there is no limit, as at the side of a graze on which
//! the surface is struck, where the derivative grows like `h^(-1/2)`.

use super::gradient::{Gradient, GradientMode, OneSided, Side, differentiate_values};
use super::quantity::Quantity;
use super::{ControlSignal, InitialValueProblem, InputError, Simulation};
use crate::model::Model;

/// Distance of the farthest motion that is looked at, as a share of the value.
const DISTANCE: f64 = 1e-4;
/// Share of a derivative by which two limits of it may differ. Regular ones differ by about the square of the distance.
const AGREE: f64 = 1e-4;
/// Part of the way to the nearest neighbour that the end may move beyond its derivative: the end is a continuous function.
const JUMP: f64 = 4.0;
/// Share of the largest value that is the error of a motion.
const ERROR: f64 = 1e-7;
/// Share of the largest derivative that counts as none where limits are compared.
const NONE: f64 = 1e-9;

/// Simulates a scene from a start.
pub type Simulate<'s> =
    dyn FnMut(&dyn Model, &InitialValueProblem) -> Result<Simulation, InputError> + 's;

/// Adds the derivatives to one side to a `gradient` of the motion `run` of a scene from a start, if it has none from some instant on,
/// by simulating its neighbours.
pub fn add_one_sided(
    gradient: &mut Gradient,
    (model, problem): (&dyn Model, &InitialValueProblem),
    run: &Simulation,
    simulate: &mut Simulate<'_>,
) {
    let Some(end) = end(run).filter(|_| gradient.obstacle.is_some() && run.status.is_solved())
    else {
        return;
    };
    let n = problem.q.len();
    let of: Vec<String> = gradient
        .values
        .iter()
        .map(|known| known.0.clone())
        .collect();
    let mut side = |sense: f64| {
        let columns = gradient.with_respect_to.iter();
        let columns: Vec<Vec<f64>> = columns
            .map(|name| limit((model, problem), &end, (name, sense, &of), simulate))
            .collect();
        let objective = columns.iter().any(|column| column.len() > 2 * n + of.len());
        let row = |i: usize| -> Vec<f64> {
            columns
                .iter()
                .map(|column| column.get(i).copied().unwrap_or(f64::NAN))
                .collect()
        };
        Side {
            q: (0..n).map(row).collect(),
            v: (n..2 * n).map(row).collect(),
            values: (2 * n..)
                .zip(&of)
                .map(|(i, name)| (name.clone(), row(i)))
                .collect(),
            objective: objective.then(|| row(2 * n + of.len())),
        }
    };
    let (below, above) = (side(-1.0), side(1.0));
    let exists = |side: &Side| {
        let mut rows = side.q.iter().chain(&side.v).flatten();
        rows.any(|by| by.is_finite())
    };
    if exists(&below) || exists(&above) {
        gradient.one_sided = Some(Box::new(OneSided { below, above }));
    }
}

/// The last state of a motion.
fn end(run: &Simulation) -> Option<Vec<f64>> {
    let (q, v) = (run.trajectory.q.last()?, run.trajectory.v.last()?);
    Some([&q[..], v].concat())
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

/// The limits of the derivatives of `(q, v)` and of the values `of` at the end, and of the objective, by one quantity; empty where
/// neighbours have none.
fn limit(
    scene: (&dyn Model, &InitialValueProblem),
    end: &[f64],
    (name, sense, of): (&str, f64, &[String]),
    simulate: &mut Simulate<'_>,
) -> Vec<f64> {
    let mut at = |share: f64| neighbour(scene, (name, of), sense * share * DISTANCE, simulate);
    let (Some(far), Some(middle), Some(near)) = (at(1.0), at(0.5), at(0.25)) else {
        return Vec::new();
    };
    let size = largest(&near.by);
    let error = ERROR * largest(end);
    let continuous = end
        .iter()
        .zip(&near.end)
        .all(|(end, near_end)| (near_end - end).abs() <= JUMP * near.distance * size + error);
    if !continuous {
        return Vec::new();
    }
    let values = far.by.iter().zip(&middle.by).zip(&near.by);
    values
        .map(|((far, middle), near)| {
            let (first, second) = (2.0 * middle - far, 2.0 * near - middle);
            let agree = (second - first).abs() <= AGREE * second.abs() + NONE * size;
            if agree {
                (4.0 * second - first) / 3.0
            } else {
                f64::NAN
            }
        })
        .collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}

/// The motion with a quantity that is changed by that share of it.
fn neighbour(
    (model, problem): (&dyn Model, &InitialValueProblem),
    (name, of): (&str, &[String]),
    share: f64,
    simulate: &mut Simulate<'_>,
) -> Option<Neighbour> {
    let (model, problem, distance) = moved(model, problem, name, share)?;
    let run = simulate(&*model, &problem).ok()?;
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
        end: end(&run)?,
        by,
        distance,
    })
}

/// Scene and start with a quantity that is changed by that share of it, or by the share itself where it is 0; and by how much.
fn moved(
    model: &dyn Model,
    problem: &InitialValueProblem,
    name: &str,
    share: f64,
) -> Option<(Box<dyn Model>, InitialValueProblem, f64)> {
    let by = |value: f64| {
        if value == 0.0 {
            share
        } else {
            share * value.abs()
        }
    };
    let (mut scene, mut problem) = (model.boxed(), problem.clone());
    let declaration = model.declaration();
    let mut parameters = declaration.parameters.iter();
    if let Some(index) = parameters.position(|known| known.name == name) {
        let (start, horizon) = (start_of(model), model.horizon());
        let value = model.parameter(index);
        scene.set_parameter(index, value + by(value));
        // What is that of the scene moves with it.
        let (q, v) = start_of(&*scene);
        for (own, (before, after)) in problem.q.iter_mut().zip(start.0.iter().zip(q)) {
            *own = if own == before { after } else { *own };
        }
        for (own, (before, after)) in problem.v.iter_mut().zip(start.1.iter().zip(v)) {
            *own = if own == before { after } else { *own };
        }
        if horizon == Some(problem.horizon) {
            problem.horizon = scene.horizon()?;
        }
        return Some((scene, problem, by(value).abs()));
    }
    let distance = match Quantity::named(declaration, &[], name)? {
        Quantity::Coordinate(k) => add_share(&mut problem.q[k], share),
        Quantity::Velocity(k) => add_share(&mut problem.v[k], share),
        Quantity::Control(k) => {
            let count = declaration.controls.len();
            add_control(&mut problem.controls, k, (count, share))
        }
        _ => return None,
    };
    Some((scene, problem, distance))
}

/// Adds a share of a value to it; how much that is.
fn add_share(value: &mut f64, share: f64) -> f64 {
    let by = if *value == 0.0 {
        share
    } else {
        share * value.abs()
    };
    *value += by;
    by.abs()
}

fn start_of(model: &dyn Model) -> (Vec<f64>, Vec<f64>) {
    let n = model.declaration().coordinates.len();
    let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
    model.start(&mut q, &mut v);
    (q, v)
}

/// Adds a share of the largest value of a control to it at all times; how much that is.
fn add_control(controls: &mut ControlSignal, control: usize, (count, share): (usize, f64)) -> f64 {
    if matches!(controls, ControlSignal::Zero) {
        *controls = ControlSignal::constant(&vec![0.0; count]);
    }
    if let ControlSignal::PiecewiseConstant { values, .. }
    | ControlSignal::PiecewiseLinear { values, .. } = controls
    {
        let largest = values
            .iter()
            .fold(0.0_f64, |most, u| u[control].abs().max(most));
        let by = if largest == 0.0 {
            share
        } else {
            share * largest
        };
        values.iter_mut().for_each(|u| u[control] += by);
        return by.abs();
    }
    share.abs()
}
