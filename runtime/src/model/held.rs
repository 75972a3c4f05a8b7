//! Scenes in which parameters are coordinates without motion.

use super::{Function, Given, Model};

/// Number of coordinates that move: all but those that stand for parameters.
pub(crate) fn moving(model: &dyn Model) -> usize {
    let held = model.held().map_or(0, |held| held.count());
    model.declaration().coordinates.len() - held
}

/// Whether a component of `(q, v)` stands for a parameter or for what is remembered of the start.
pub(crate) fn is_held(model: &dyn Model, k: usize) -> bool {
    let n = model.declaration().coordinates.len();
    k % n >= moving(model)
}

/// Which of the values that parameters give is that one.
pub(crate) fn place(model: &dyn Model, given: Given) -> Option<usize> {
    let held = model.held()?;
    held.given.iter().position(|&known| known == given)
}

/// The values that parameters give, where these are as `start = (q, v)` says.
pub(crate) fn given_at(model: &dyn Model, start: &[f64]) -> Vec<f64> {
    let count = model.held().map_or(0, |held| held.given.len());
    let mut values = vec![0.0; count];
    if count > 0 {
        let mut x = start.to_vec();
        x.resize(model.declaration().inputs(), 0.0);
        model.values(Function::Given, &x, &mut values);
    }
    values
}

/// Gives the components of a start `(q, v)` that parameters decide the values that go with those of the parameters in it.
pub(crate) fn complete_start(model: &dyn Model, start: &mut [f64]) {
    let Some(held) = model.held() else { return };
    let values = given_at(model, start);
    for (given, value) in held.given.iter().zip(values) {
        if let Given::Start(k) = *given {
            start[k] = value;
        }
    }
}

/// The scene with the laws of contact that go with the parameters in the start of a motion; `None` where they are its own.
pub(crate) fn with_laws(model: &dyn Model, q: &[f64]) -> Option<Box<dyn Model>> {
    let held = model.held()?;
    let is_law = |given: &Given| matches!(given, Given::Restitution(_) | Given::Friction(_));
    let first = moving(model);
    if !held.given.iter().any(is_law) || q.len() != first + held.count() {
        return None;
    }
    let mut own = model.boxed();
    for (&parameter, &value) in held.parameters.iter().zip(&q[first..]) {
        own.set_parameter(parameter, value);
    }
    Some(own)
}

/// The place among the controls of the first that is a value of each stage, and not of an interval: a largest value.
pub(crate) fn first_of_stages(model: &dyn Model) -> usize {
    let count = model.held().map_or(0, |held| held.at_stages.len());
    model.declaration().controls.len() - count
}

/// The first path constraint that is one of the largest values of an instant, which are unknowns at stages alone: they hold there, and
/// nowhere else.
pub(crate) fn first_at_stages(model: &dyn Model) -> usize {
    let declared = model.declaration().optimal_control;
    let count: usize = model.held().map_or(0, |held| held.at_stages.iter().sum());
    declared.map_or(0, |declared| declared.constraints.len()) - count
}

/// Gives the largest values of an instant in an input vector what they are there.
pub(crate) fn complete_largest(model: &dyn Model, x: &mut [f64]) {
    let (Some(held), declaration) = (model.held(), model.declaration()) else {
        return;
    };
    let Some(declared) = declaration.optimal_control else {
        return;
    };
    let mut values = vec![0.0; declared.path_functions()];
    let all: usize = held.at_stages.iter().sum();
    let mut row = declared.path_functions() - all;
    let first = 2 * declaration.coordinates.len() + first_of_stages(model);
    // Each reads those before it alone.
    for (k, &rows) in held.at_stages.iter().enumerate() {
        x[first + k] = 0.0;
        model.values(Function::Path, x, &mut values);
        let own = values[row..row + rows].iter();
        x[first + k] = own.fold(f64::NEG_INFINITY, |most, value| most.max(-value));
        row += rows;
    }
}
