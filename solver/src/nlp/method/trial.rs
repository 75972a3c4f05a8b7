//! Trial points.

use super::state::State;
use crate::linalg::norms::norm_one;
use crate::nlp::program::barrier_problem::{BarrierProblem, Values};
use crate::nlp::program::formulation::Formulation;
use crate::nlp::program::iterate::Iterate;

/// Evaluates the point at `alpha` along the direction, or its correction, into `trial`.
pub(super) fn take_trial(state: &mut State<'_, '_, '_, '_>, alpha: f64, corrected: bool) -> bool {
    let direction = if corrected {
        &state.work.correction
    } else {
        &state.work.direction
    };
    trial_point(
        &state.problem,
        &mut state.core.formulation,
        &state.point.iterate,
        &direction.v,
        alpha,
        (state.mu, state.sigma),
        !state.is_restoration,
        &mut state.work.trial,
        &mut state.work.trial_values,
    )
}

/// Point `v + alpha d`, where `raise_slacks` lifts slacks of products to `sigma - x_i x_j`; `false` if a
/// function is not finite there.
#[expect(clippy::too_many_arguments, reason = "the parts of one definition")]
fn trial_point(
    problem: &BarrierProblem,
    formulation: &mut Formulation<'_>,
    iterate: &Iterate,
    d: &[f64],
    alpha: f64,
    (mu, sigma): (f64, f64),
    raise_slacks: bool,
    trial: &mut [f64],
    values: &mut Values,
) -> bool {
    for ((t, v), d) in trial.iter_mut().zip(&iterate.v).zip(d) {
        *t = v + alpha * d;
    }
    if raise_slacks {
        raise_product_slacks(problem, sigma, trial);
    }
    if !problem.evaluate(formulation, trial, sigma, mu, values) {
        return false;
    }
    if raise_slacks {
        reset_range_slacks(problem, trial, values);
    }
    true
}

/// Moves slacks of ranges to the constraint values where these are not much nearer to the bounds.
fn reset_range_slacks(problem: &BarrierProblem, trial: &mut [f64], values: &mut Values) {
    if problem.slacks.len() == problem.products.len() {
        return;
    }
    for (k, slack) in problem.slacks.iter().enumerate() {
        if slack.row >= problem.m {
            continue;
        }
        let i = problem.n + k;
        let value = trial[i] + values.residual[slack.row];
        let kept = |distance: f64, old: f64| distance >= 0.5 * old;
        if kept(value - problem.lower[i], trial[i] - problem.lower[i])
            | !problem.lower[i].is_finite()
            && kept(problem.upper[i] - value, problem.upper[i] - trial[i])
                | !problem.upper[i].is_finite()
        {
            trial[i] = value;
            values.residual[slack.row] = 0.0;
        }
    }
    values.theta = norm_one(&values.residual);
}

/// Lifts slacks of products to `sigma - x_i x_j`.
pub(super) fn raise_product_slacks(problem: &BarrierProblem, sigma: f64, v: &mut [f64]) {
    for (k, slack) in problem.slacks.iter().enumerate() {
        if slack.row >= problem.m && slack.sign > 0.0 {
            let (i, j) = problem.products[slack.row - problem.m];
            let room = sigma - v[i] * v[j];
            let s = &mut v[problem.n + k];
            *s = s.max(room);
        }
    }
}
