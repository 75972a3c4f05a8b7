//! The first point and its multipliers.

use super::safeguard::safeguard;
use super::state::State;
use crate::nlp::program::scaling::interior;
use crate::nlp::{Products, WarmStart};

/// Point inside the bounds, slacks from the constraint values.
pub(super) fn first_point(state: &mut State<'_, '_, '_, '_>) {
    let (push, fraction) = (
        state.core.settings.bound_push,
        state.core.settings.bound_fraction,
    );
    let n = state.problem.n;
    for i in 0..n {
        let (lower, upper) = (state.problem.lower[i], state.problem.upper[i]);
        state.point.iterate.v[i] = interior(
            state.core.formulation.start[i],
            lower,
            upper,
            push,
            fraction,
        );
    }
    // residuals with zero slacks are the constraint values
    state.evaluate_iterate();
    for (k, slack) in state.problem.slacks.iter().enumerate() {
        let i = n + k;
        let residual = state.point.values.residual[slack.row];
        state.point.iterate.v[i] = if slack.row < state.problem.m {
            let value = if residual.is_finite() { residual } else { 0.0 };
            interior(
                value,
                state.problem.lower[i],
                state.problem.upper[i],
                push,
                fraction,
            )
        } else {
            (-residual).max(0.1 * state.sigma)
        };
    }
}

/// What is not finite at the first point, by name.
pub(super) fn not_finite(state: &State<'_, '_, '_, '_>) -> String {
    let rows = &state.core.formulation.rows;
    match state
        .point
        .values
        .residual
        .iter()
        .position(|r| !r.is_finite())
    {
        Some(row) if row < rows.len() => {
            state.core.formulation.problem().constraint_name(rows[row])
        }
        _ => String::from("the objective"),
    }
}

pub(super) fn first_multipliers(
    state: &mut State<'_, '_, '_, '_>,
    start: Option<&WarmStart>,
    products: &Products,
) {
    let n = state.problem.n;
    for i in 0..state.problem.variables() {
        let (lower, upper) = (state.problem.lower[i], state.problem.upper[i]);
        if lower.is_finite() {
            state.point.iterate.z_lower[i] = 1.0;
        }
        if upper.is_finite() {
            state.point.iterate.z_upper[i] = 1.0;
        }
    }
    for (k, slack) in state.problem.slacks.iter().enumerate() {
        if slack.row >= state.problem.m {
            state.point.iterate.z_lower[n + k] = state.mu / state.point.iterate.v[n + k];
        }
    }
    state.evaluate_first_derivatives();
    match start {
        None => {
            safeguard(state);
            state.estimate_multipliers();
        }
        Some(start) => {
            let scale = state.core.formulation.objective_scale;
            let mu = state.mu;
            for i in 0..n {
                let user = state.core.formulation.variables[i];
                let v = state.point.iterate.v[i];
                if state.problem.lower[i].is_finite() {
                    let z = scale * start.multipliers_lower[user];
                    state.point.iterate.z_lower[i] =
                        z.max(1e-2 * mu / (v - state.problem.lower[i]));
                }
                if state.problem.upper[i].is_finite() {
                    let z = scale * start.multipliers_upper[user];
                    state.point.iterate.z_upper[i] =
                        z.max(1e-2 * mu / (state.problem.upper[i] - v));
                }
            }
            warm_products(state, start, products);
            for row in 0..state.problem.m {
                let user = state.core.formulation.rows[row];
                state.point.iterate.y[row] =
                    scale * start.multipliers[user] / state.core.formulation.row_scales[row];
            }
            for (k, slack) in state.problem.slacks.iter().enumerate() {
                if slack.row >= state.problem.m {
                    continue;
                }
                let i = n + k;
                // the row's multiplier is the difference of the slack's bound multipliers
                let y = slack.sign * state.point.iterate.y[slack.row];
                let v = state.point.iterate.v[i];
                if state.problem.lower[i].is_finite() {
                    let floor = 1e-2 * mu / (v - state.problem.lower[i]);
                    state.point.iterate.z_lower[i] = y.max(floor);
                }
                if state.problem.upper[i].is_finite() {
                    let floor = 1e-2 * mu / (state.problem.upper[i] - v);
                    state.point.iterate.z_upper[i] = (-y).max(floor);
                }
            }
            safeguard(state);
        }
    }
}

/// Multipliers of products, and what remains of the bound multipliers of their variables.
fn warm_products(state: &mut State<'_, '_, '_, '_>, start: &WarmStart, products: &Products) {
    let (n, m) = (state.problem.n, state.problem.m);
    if products.multipliers.len() != products.pairs.len() {
        return;
    }
    let scale = state.core.formulation.objective_scale;
    let mut is_free = vec![None; start.x.len()];
    for (i, &user) in state.core.formulation.variables.iter().enumerate() {
        is_free[user] = Some(i);
    }
    let mut lower: Vec<f64> = state
        .core
        .formulation
        .variables
        .iter()
        .map(|&user| scale * start.multipliers_lower[user])
        .collect();
    let mut row = m;
    for (&(a, b), r) in products.pairs.iter().zip(&products.multipliers) {
        if let (Some(i), Some(j)) = (is_free[a], is_free[b]) {
            state.point.iterate.y[row] = scale * r;
            lower[i] += scale * r * start.x[b];
            lower[j] += scale * r * start.x[a];
            row += 1;
        }
    }
    for (k, slack) in state.problem.slacks.iter().enumerate() {
        if slack.row >= m {
            state.point.iterate.z_lower[n + k] = state.point.iterate.y[slack.row];
        }
    }
    for &(i, j) in &state.problem.products {
        for k in [i, j] {
            let distance = state.point.iterate.v[k] - state.problem.lower[k];
            state.point.iterate.z_lower[k] = lower[k].max(1e-2 * state.mu / distance);
        }
    }
}
