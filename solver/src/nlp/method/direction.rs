//! The Newton direction.

use super::state::State;
use crate::linalg::norms::is_finite;

/// Relative residual of the Newton system up to which its solution is a direction.
const RESIDUAL: f64 = 1e-5;

/// Newton direction with the right inertia and a small residual.
pub(super) fn find_direction(state: &mut State<'_, '_, '_, '_>) -> bool {
    let core = &mut *state.core;
    core.kkt
        .evaluate_hessian(&mut core.formulation, &state.problem, &state.point.iterate);
    if !core.kkt.is_finite() {
        return false;
    }
    let mut floor = state.shifts.floor;
    let mut dual_shift = core.settings.permanent_dual_shift;
    for _ in 0..4 {
        let core = &mut *state.core;
        core.kkt
            .assemble(&state.problem, &state.point.iterate, state.mu, false);
        if !state.shifts.inertia.factorize(
            &mut core.kkt,
            &state.problem,
            &state.point.iterate,
            state.mu,
            floor,
            dual_shift,
        ) {
            return false;
        }
        let residual = core.kkt.direction(
            &state.problem,
            &state.point.iterate,
            &state.point.lagrangian,
            &state.point.values.residual,
            state.mu,
            &mut state.work.direction,
        );
        if residual <= RESIDUAL && is_finite(&state.work.direction.v) {
            return true;
        }
        // as good as singular: shift both blocks
        dual_shift = dual_shift.max(1e-8) * if dual_shift >= 1e-8 { 100.0 } else { 1.0 };
        floor = (100.0 * state.shifts.inertia.delta_w).max(1e-8);
    }
    false
}

/// The Newton step to barrier parameter zero, in place of the one to that of the state; `false` where the Hessian needs a shift, so
/// that the step is not that of the path.
pub(super) fn find_end_of_path(state: &mut State<'_, '_, '_, '_>) -> bool {
    let core = &mut *state.core;
    let (problem, point) = (&state.problem, &state.point);
    core.kkt
        .evaluate_hessian(&mut core.formulation, problem, &point.iterate);
    if !core.kkt.is_finite() {
        return false;
    }
    core.kkt.assemble(problem, &point.iterate, state.mu, false);
    let dual_shift = core.settings.permanent_dual_shift;
    let inertia = &mut state.shifts.inertia;
    if !inertia.factorize(
        &mut core.kkt,
        problem,
        &point.iterate,
        state.mu,
        0.0,
        dual_shift,
    ) || inertia.delta_w > 0.0
    {
        return false;
    }
    let residual = core.kkt.direction(
        problem,
        &point.iterate,
        &point.lagrangian,
        &point.values.residual,
        0.0,
        &mut state.work.direction,
    );
    residual <= RESIDUAL && is_finite(&state.work.direction.v)
}
