//! Derivatives of a motion.

use std::collections::BTreeMap;

use hangtime::derivative::{Gradient, GradientMode, Side};
use hangtime::model::Model;
use serde_json::Value;

use super::parts::Object;

/// Matrices with a row for each value, and a column for each quantity that it is differentiated by, of a motion of whose trajectory the
/// instants `kept` are written. With an adjoint there are chosen values and the objective only.
pub(super) fn gradient(model: &dyn Model, gradient: &Gradient, kept: &[usize]) -> Object {
    let mechanical = model.declaration().mechanical();
    let outputs = || {
        let outputs = model.outputs().iter().zip(&gradient.outputs);
        let rows = outputs.map(|(output, rows)| {
            let rows = kept.iter().filter_map(|&k| rows.get(k));
            (output.name, rows.collect())
        });
        rows.collect::<BTreeMap<_, Vec<_>>>()
    };
    let values = by_name(gradient.values.iter().map(|(name, row)| (name, row)));
    let forward = gradient.mode == GradientMode::Forward;
    let last = || end(&gradient.q, &gradient.v, mechanical);
    let obstacles = || gradient.obstacles.iter().map(existence).collect::<Vec<_>>();
    let sides = gradient.one_sided.as_deref().map(|sides| {
        // Below the value of the parameter; null where there is none.
        let below = Object::default().with("below", side(&sides.below, mechanical));
        // Above it; null where there is none.
        below.with("above", side(&sides.above, mechanical))
    });
    Object::default()
        // What is differentiated by: the columns.
        .with("with_respect_to", &gradient.with_respect_to)
        // `forward`, or `adjoint`, which has nothing but chosen values and the objective.
        .with("mode", gradient.mode.name())
        // Of chosen values at the end, and of chosen times of events, by name. Only where they were chosen.
        .some("values", values)
        // Of the end of the motion.
        .some("final", forward.then(last))
        // Of the times of events, a row an event.
        .some("event_times", forward.then_some(&gradient.event_times))
        // Of outputs, by name, a row for each row of the trajectory.
        .some("outputs", forward.then(outputs))
        // Of the objective. Only of scenes that declare one that reads nothing of contacts.
        .some("objective", gradient.objective.as_ref())
        // How far derivatives may be off, as a share of the largest change of each value that they tell of. Only where that is known.
        .some("error_estimate", gradient.error_estimate)
        // How far each quantity may go until the motion has another sequence of events, to first order. Only of `forward` derivatives.
        .list("range", &gradient.ranges)
        // `true`, or why there is no derivative by some quantity.
        .with("exists", existence(&gradient.obstacle))
        // By quantity `true`, or why there is no derivative by it. Only where there is none by some of them.
        .some("exists_by", gradient.obstacle.is_some().then(obstacles))
        // Of the end to both sides, only where there are no others; null by other quantities.
        .some("one_sided", sides)
}

/// Derivatives to one side, of the end, the objective and chosen values there; null where there are none. Values that move by `a sqrt(h)`
/// with the distance `h` have infinite ones, and a number `a` in a part of its own.
fn side(side: &Side, mechanical: usize) -> Object {
    let (n, values, roots) = (side.q.len(), side.values.len(), &side.roots);
    let names = side.values.iter().map(|(name, _)| name);
    let of_roots = || {
        Object::default()
            // Of the end of the motion.
            .with("final", end(&roots[..n], &roots[n..2 * n], mechanical))
            // Of the objective.
            .some("objective", roots.get(2 * n + values))
            // Of chosen values at the end, by name.
            .some("values", by_name(names.clone().zip(&roots[2 * n..])))
    };
    let by_name = by_name(side.values.iter().map(|(name, row)| (name, row)));
    Object::default()
        // Of the end of the motion.
        .with("final", end(&side.q, &side.v, mechanical))
        // Of the objective.
        .some("objective", side.objective.as_ref())
        // Of chosen values at the end, by name.
        .some("values", by_name)
        // Numbers `a` of values that move by `a sqrt(h)` with the distance `h`, whose derivatives are infinite and null above; 0 of others.
        .some("square_root", (!roots.is_empty()).then(of_roots))
}

/// Rows by name; none if there are none.
fn by_name<'a>(
    rows: impl Iterator<Item = (&'a String, &'a Vec<f64>)>,
) -> Option<BTreeMap<&'a String, &'a Vec<f64>>> {
    let rows: BTreeMap<_, _> = rows.collect();
    (!rows.is_empty()).then_some(rows)
}

/// Derivatives of coordinates, velocities and states at the end.
fn end(q: &[Vec<f64>], v: &[Vec<f64>], mechanical: usize) -> Object {
    // None where there is no derivative.
    let (velocities, states) = v.split_at(mechanical.min(v.len()));
    Object::default()
        // Of coordinates.
        .with("q", &q[..mechanical.min(q.len())])
        // Of velocities.
        .with("v", velocities)
        // Of states. Only for scenes that declare states.
        .list("states", states)
}

/// `true`, or why there are no derivatives.
pub(super) fn existence(obstacle: &Option<String>) -> Value {
    obstacle.as_deref().map_or(Value::Bool(true), Value::from)
}
