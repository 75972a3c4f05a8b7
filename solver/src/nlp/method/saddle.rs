//! Starts that are maxima or saddle points.
//!
//! Newton's method stays at a stationary point that it starts from, whatever the curvature there; so it does where a
//! symmetric start leaves a variable no reason to move either way. Such a run ends where it began, though the Newton matrix
//! without shifts shows negative curvature, and another one from beside that point leaves it.

use super::state::{End, Outcome, State};
use crate::nlp::Status;
use crate::nlp::program::formulation::Formulation;

/// How far the end may be from the start, relative to its size, to count as the same point.
const SAME: f64 = 1e-6;

/// Curvature of the scaled problem, whose gradients are at most 100, that is told from rounding.
const CURVATURE: f64 = 1e-6;

/// How far beside the first start the second one lies, relative to its size.
const BESIDE: f64 = 1e-2;

/// Whether a run was solved where it began, at a point with a direction of negative curvature.
pub(super) fn stays(state: &mut State<'_, '_, '_, '_>, outcome: &Outcome) -> bool {
    let shifted = state.core.iterations == 0 || state.info.hessian_shift > 0.0;
    if outcome.status != Status::Solved || !state.problem.products.is_empty() || !shifted {
        return false;
    }
    let start = &state.core.formulation.start;
    let mut variables = start.iter().zip(&state.point.iterate.v);
    if variables.any(|(start, end)| (end - start).abs() > SAME * start.abs().max(1.0)) {
        return false;
    }
    let core = &mut *state.core;
    core.kkt
        .evaluate_hessian(&mut core.formulation, &state.problem, &state.point.iterate);
    if !core.kkt.is_finite() {
        return false;
    }
    core.kkt
        .assemble(&state.problem, &state.point.iterate, state.mu, false);
    // dependent rows would count as curvature
    let dual_shift = 1e-8 * state.mu.powf(0.25);
    let inertia = core.kkt.factor(CURVATURE, dual_shift);
    inertia.is_ok_and(|inertia| inertia.negative > core.kkt.rows())
}

/// Moves the start to a point beside it, every variable by an amount of its own, the same in every run.
pub(super) fn perturb(formulation: &mut Formulation<'_>) {
    const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;
    let bounds = formulation.lower.iter().zip(&formulation.upper);
    for (i, (x, (&lower, &upper))) in formulation.start.iter_mut().zip(bounds).enumerate() {
        // between 0.5 and 1 on either side
        let part = ((i + 1) as f64 * GOLDEN_RATIO).fract() - 0.5;
        let step = BESIDE * x.abs().max(1.0) * (part + 0.5_f64.copysign(part));
        *x = (*x + step).max(lower).min(upper);
    }
}

/// Whether the end of the run from beside a start is to be preferred: a solution with a smaller objective, a sign that
/// there is no least one, or the wish to stop.
pub(super) fn is_better(other: &End, end: &End) -> bool {
    match other.outcome.status {
        Status::Solved => !other.outcome.left && other.objective < end.objective,
        Status::Diverging | Status::Interrupted | Status::TimeLimit => true,
        _ => false,
    }
}
