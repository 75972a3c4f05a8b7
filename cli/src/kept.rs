//! What a scene declares for optimal control and a simulation does not keep: constraints, conditions at the end, bounds.

use hangtime::model::{ConstraintDeclaration, Function, Model};
use hangtime::simulation::Simulation;

use crate::table::number;

/// Relative change of a state whose effect on a condition counts as none: far above the error of a simulation, far below
/// what a picture shows.
const NEGLIGIBLE: f64 = 1e-7;

/// A note for each condition that the motion does not keep by itself, and in a scene without an objective, where nothing
/// else says what they are for, for each condition.
pub(crate) fn notes(model: &dyn Model, simulation: &Simulation) -> Vec<String> {
    let mut notes = Vec::new();
    let inputs = inputs(simulation, model);
    if inputs.is_empty() {
        return notes;
    }
    if let Some(task) = &model.declaration().optimal_control {
        let has_objective = task.running_cost || task.final_cost;
        let known = !task.contacts.path;
        for (i, declared) in task.constraints.iter().enumerate() {
            let function = |x: &[f64]| {
                let mut values = vec![0.0; task.path_functions()];
                model.values(Function::Path, x, &mut values);
                values[usize::from(task.running_cost) + i]
            };
            let worst = known.then(|| worst(&inputs, declared, function));
            notes.extend(constraint_note(declared, worst, has_objective));
        }
        let known = !task.contacts.terminal && task.contacts.sums == 0;
        for (i, declared) in task.goals.iter().enumerate().filter(|_| !has_objective) {
            let function = |z: &[f64]| {
                let mut values = vec![0.0; task.terminal_functions()];
                model.values(Function::Terminal, z, &mut values);
                values[usize::from(task.final_cost) + i]
            };
            let end = known.then(|| end(simulation, model)).flatten();
            let missed = end.map(|end| worst(&[end], declared, function).0);
            notes.push(goal_note(declared, missed));
        }
    }
    notes.extend(bounds(model, simulation));
    notes
}

/// `(q, v, u[, t])` at the instants of the trajectory.
fn inputs(simulation: &Simulation, model: &dyn Model) -> Vec<Vec<f64>> {
    let trajectory = &simulation.trajectory;
    let length = model.declaration().inputs();
    let at = |k: usize| {
        let mut x = [&trajectory.q[k][..], &trajectory.v[k], &trajectory.u[k]].concat();
        x.push(trajectory.time[k]);
        x.truncate(length);
        x
    };
    (0..trajectory.time.len()).map(at).collect()
}

/// `(q, v, T)` at the end.
fn end(simulation: &Simulation, model: &dyn Model) -> Option<Vec<f64>> {
    let last = inputs(simulation, model).pop()?;
    let mut z = last[..2 * model.declaration().coordinates.len()].to_vec();
    z.extend(simulation.trajectory.time.last());
    Some(z)
}

/// By how much a condition is violated at most, and at which of the points; 0 where it is kept up to rounding.
fn worst(
    points: &[Vec<f64>],
    declared: &ConstraintDeclaration,
    function: impl Fn(&[f64]) -> f64,
) -> (f64, usize) {
    let mut worst = (0.0, 0);
    for (k, x) in points.iter().enumerate() {
        let value = function(x);
        let violation = if declared.equality {
            value.abs()
        } else {
            -value
        };
        if violation > worst.0 && violation > effect(x, value, &function) {
            worst = (violation, k);
        }
    }
    worst
}

/// How much a value changes with negligible changes of what it depends on.
fn effect(x: &[f64], value: f64, function: impl Fn(&[f64]) -> f64) -> f64 {
    let mut moved = x.to_vec();
    let mut sum = 0.0;
    for i in 0..x.len() {
        moved[i] = x[i] * (1.0 + NEGLIGIBLE);
        sum += (function(&moved) - value).abs();
        moved[i] = x[i];
    }
    sum
}

fn constraint_note(
    declared: &ConstraintDeclaration,
    worst: Option<(f64, usize)>,
    has_objective: bool,
) -> Option<String> {
    let name = declared.name;
    let unused = format!("a simulation does not use `constraint {name}`, which is for `solve`");
    match worst {
        Some((violation, _)) if violation > 0.0 => Some(format!(
            "{unused}: this motion violates it by up to {}",
            quantity(violation, declared.unit)
        )),
        _ if has_objective => None,
        Some(_) => Some(format!("{unused}; this motion keeps it by itself")),
        None => Some(unused),
    }
}

fn goal_note(declared: &ConstraintDeclaration, missed: Option<f64>) -> String {
    let unused = format!(
        "a simulation does not use `finally {{ {} }}`, which is for `solve`",
        declared.name
    );
    match missed {
        Some(missed) if missed > 0.0 => {
            format!(
                "{unused}: this motion misses it by {}",
                quantity(missed, declared.unit)
            )
        }
        Some(_) => format!("{unused}; this motion ends there by itself"),
        None => unused,
    }
}

/// Coordinates that leave their bounds.
fn bounds(model: &dyn Model, simulation: &Simulation) -> Vec<String> {
    let declaration = model.declaration();
    let length = declaration.coordinates.len() + declaration.controls.len();
    let (mut lower, mut upper) = (vec![0.0; length], vec![0.0; length]);
    model.bounds(&mut lower, &mut upper);
    let mut notes = Vec::new();
    for (i, coordinate) in declaration.coordinates.iter().enumerate() {
        let beyond = simulation.trajectory.q.iter().map(|q| {
            let room = NEGLIGIBLE * q[i].abs();
            let beyond = (lower[i] - q[i]).max(q[i] - upper[i]);
            if beyond > room { beyond } else { 0.0 }
        });
        let most = beyond.fold(0.0, f64::max);
        if most > 0.0 {
            notes.push(format!(
                "a simulation does not keep the bounds of `{}`, which are for `solve`: this motion leaves them by up to {}; \
                 what holds a motion back is a `surface`",
                coordinate.name,
                quantity(most, coordinate.unit)
            ));
        }
    }
    notes
}

fn quantity(value: f64, unit: &str) -> String {
    let value = number(format!("{value:.2e}").parse().unwrap_or(value));
    format!("{value} {unit}").trim_end().to_owned()
}
