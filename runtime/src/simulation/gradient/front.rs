//! Derivatives by some quantities, at one place of a motion.

use super::cost::Cost;
use super::matrix::{Matrix, add};
use super::wanted::Wanted;
use crate::model::Model;
use crate::simulation::InitialValueProblem;

/// Derivatives by some quantities, where the walk is.
pub(super) struct Front<'w> {
    pub(super) wanted: &'w Wanted,
    /// Of `(q, v)` at a fixed time.
    pub(super) state: Matrix,
    /// Of the impulses of all impacts so far.
    pub(super) impulses: Matrix,
    /// The objective, if its derivatives are known.
    pub(super) cost: Option<Cost<'w>>,
}

impl<'w> Front<'w> {
    /// At the start of a motion.
    pub(super) fn at_start(
        model: &dyn Model,
        problem: &InitialValueProblem,
        wanted: &'w Wanted,
    ) -> Self {
        let contacts = model.declaration().contacts.len();
        Self {
            wanted,
            state: start(model, problem, wanted),
            impulses: Matrix::zeros(2 * contacts, wanted.count()),
            cost: Cost::of(model, wanted),
        }
    }
}

/// Moves the instant of derivatives of `(q, v)` along a motion with these rates.
pub(super) fn shift(state: &mut Matrix, (v, a): (&[f64], &[f64]), moves: &[f64], sense: f64) {
    for (k, rate) in v.iter().chain(a).enumerate() {
        add(state.row_mut(k), sense * rate, moves);
    }
}

/// Derivatives of the initial `(q, v)`.
pub(super) fn start(model: &dyn Model, problem: &InitialValueProblem, wanted: &Wanted) -> Matrix {
    let n = problem.q.len();
    let mut by_parameters = vec![0.0; 2 * n * wanted.parameters];
    wanted.derivatives.start(&mut by_parameters);
    let mut declared = vec![0.0; 2 * n];
    let (q, v) = declared.split_at_mut(n);
    model.start(q, v);
    let given = problem.q.iter().chain(&problem.v);
    let mut state = Matrix::zeros(2 * n, wanted.count());
    for (i, (given, declared)) in given.zip(&declared).enumerate() {
        for (k, value) in state.row_mut(i).iter_mut().enumerate() {
            *value = wanted.of_start(&by_parameters, i, k, given == declared);
        }
    }
    state
}
