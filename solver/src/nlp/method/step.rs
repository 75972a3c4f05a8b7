//! From an accepted step to the next iterate.

use super::acceptance::{Acceptance, Search};
use super::filter::GAMMA_THETA;
use super::safeguard::safeguard;
use super::state::State;
use super::stop::FARTHEST;
use crate::linalg::norms::norm_inf;

/// Change of the barrier function, relative to its size, that rounding may make, and that steps this short, relative to the
/// point, may make.
const STILL: f64 = 1e-14;
const STILL_BY_SHORT_STEPS: f64 = 1e-11;
const SHORT: f64 = 1e-8;

/// What a step is measured against.
pub(super) struct Before {
    pub(super) theta: f64,
    pub(super) phi: f64,
    /// Scaled error of the optimality conditions.
    pub(super) error: f64,
}

/// Takes over the trial point and updates multipliers, filter and shift.
pub(super) fn accept(state: &mut State<'_, '_, '_, '_>, search: &Search) {
    let alpha = search.alpha;
    let direction = if search.corrected {
        &state.work.correction
    } else {
        &state.work.direction
    };
    state.info.step_norm = norm_inf(&direction.v);
    let alpha_dual = state.longest_dual_step(direction);
    std::mem::swap(&mut state.point.iterate.v, &mut state.work.trial);
    std::mem::swap(&mut state.point.values, &mut state.work.trial_values);
    let m = state.problem.m;
    let (explicit, products) = state.point.iterate.y.split_at_mut(m);
    let (d_explicit, d_products) = direction.y.split_at(m);
    for (y, d) in explicit.iter_mut().zip(d_explicit) {
        *y += alpha * d;
    }
    for (y, d) in products.iter_mut().zip(d_products) {
        *y += alpha_dual * d;
    }
    for (z, d) in state
        .point
        .iterate
        .z_lower
        .iter_mut()
        .zip(&direction.z_lower)
    {
        *z += alpha_dual * d;
    }
    for (z, d) in state
        .point
        .iterate
        .z_upper
        .iter_mut()
        .zip(&direction.z_upper)
    {
        *z += alpha_dual * d;
    }
    safeguard(state);
    state.info.hessian_shift = state.shifts.inertia.delta_w;
    state.info.step_length_primal = alpha;
    state.info.step_length_dual = alpha_dual;
    state.info.trials = search.trials;
    state.info.acceptance = search.acceptance.letter(search.corrected);
    state.progress.stalls = 0;
    if search.acceptance == Acceptance::Tiny {
        state.level.tiny_steps += 1;
    } else {
        state.level.tiny_steps = 0;
    }
    if search.filter_rejected {
        state.globalization.rejections += 1;
        if state.globalization.rejections >= 5 && state.globalization.resets < 5 {
            state.globalization.filter.clear();
            state.globalization.rejections = 0;
            state.globalization.resets += 1;
        }
    } else {
        state.globalization.rejections = 0;
    }
    adapt_shift_floor(state, search);
}

/// Products make flat, curved valleys in which the line search would cut every step; a shift in
/// proportion turns the direction instead.
fn adapt_shift_floor(state: &mut State<'_, '_, '_, '_>, search: &Search) {
    if state.problem.products.is_empty() {
        return;
    }
    if search.alpha < 0.3 * search.alpha_max {
        let shift = state.shifts.floor.max(state.shifts.inertia.delta_w);
        state.shifts.floor = (8.0 * shift).clamp(1e-4, 1e10);
    } else if search.alpha >= search.alpha_max {
        state.shifts.floor /= 3.0;
        if state.shifts.floor < 1e-7 {
            state.shifts.floor = 0.0;
        }
    }
}

/// Six short steps in a row at an infeasible point: the iterates jam at their bounds, and Newton's method
/// for the optimality conditions has lost its way. Product problems jam more easily.
pub(super) fn is_jammed(state: &mut State<'_, '_, '_, '_>, search: &Search) -> bool {
    let short = if state.problem.products.is_empty() {
        0.01
    } else {
        0.05
    };
    if search.alpha < short && state.point.values.theta > 1e-6 {
        state.level.jams += 1;
    } else {
        state.level.jams = 0;
    }
    if state.is_restoration || state.level.jams < 6 {
        return false;
    }
    state.level.jams = 0;
    true
}

/// Length of the direction, relative to the point.
fn relative_step(state: &State<'_, '_, '_, '_>) -> f64 {
    let steps = state.work.direction.v.iter().zip(&state.point.iterate.v);
    steps.fold(0.0, |largest, (d, v)| {
        largest.max(d.abs() / v.abs().max(1.0))
    })
}

/// Fifteen steps in a row that change neither the barrier function nor the violation by more than rounding, nor lower the
/// error: the line search decides on rounding errors.
pub(super) fn stands_still(state: &mut State<'_, '_, '_, '_>, before: &Before) -> bool {
    if state.is_restoration || !state.core.settings.persistent {
        return false;
    }
    let phi = state.barrier_function();
    let theta = state.point.values.theta;
    let resolution = if state.info.step_length_primal * relative_step(state) <= SHORT {
        STILL_BY_SHORT_STEPS
    } else {
        STILL
    };
    let moved = (phi - before.phi).abs() > resolution * before.phi.abs().max(STILL)
        || theta < (1.0 - GAMMA_THETA) * before.theta;
    let lower = before.error < 0.9 * state.progress.least_error;
    if lower {
        state.progress.least_error = before.error;
    }
    if moved || lower {
        state.progress.still_steps = 0;
    } else {
        state.progress.still_steps += 1;
    }
    state.progress.still_steps >= 15
}

/// Fifteen steps at infeasible points far out, or one beyond all sizes, that lowered the objective only: it is unbounded below
/// along directions that leave the violation as it is, and the violation has to be looked at alone.
pub(super) fn is_drifting(state: &mut State<'_, '_, '_, '_>) -> bool {
    let theta = state.point.values.theta;
    let size = norm_inf(&state.point.iterate.v);
    let far = size > 1e8;
    if !far || theta <= 0.9 * state.progress.drift_theta || theta <= state.core.settings.tolerance {
        state.progress.drift_theta = theta;
        state.progress.drift_steps = 0;
        return false;
    }
    state.progress.drift_steps += 1;
    let at_once = size > FARTHEST && state.problem.products.is_empty();
    if state.is_restoration || (state.progress.drift_steps < 15 && !at_once) {
        return false;
    }
    state.progress.drift_steps = 0;
    true
}
