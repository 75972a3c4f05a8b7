//! From the end of a run to the result in the user's variables and units.

use super::method::{Core, End};
use super::program::iterate::Iterate;
use super::solution::{Multipliers, diagnose};
use super::{Counts, Products, Residuals, Solution, Status};

/// The result in the user's variables and units.
pub(super) fn solution(mut core: Core<'_, '_>, end: &End, products: &mut Products) -> Solution {
    let n = core.formulation.variables.len();
    let x = core.formulation.full_point(&end.iterate.v[..n]).to_vec();
    let mut multipliers = user_multipliers(&core, &end.iterate);
    take_products(&core, &end.iterate, &x, products, &mut multipliers);

    // optimality of the original problem; fixed variables have the multiplier that balances them
    let point = core.formulation.unscaled(&end.iterate.v[..n]);
    let objective = point.objective;
    let (mut gradient, c) = (point.gradient.to_vec(), point.constraints.to_vec());
    for (&(row, column), value) in point.pattern.iter().zip(point.jacobian) {
        gradient[column] += value * multipliers.rows[row];
    }
    let dual = balance(&core, &gradient, &mut multipliers);
    let diagnosis = diagnose(
        core.formulation.problem(),
        &x,
        &c,
        &multipliers,
        core.settings.constraint_tolerance,
    );
    let counts = Counts {
        iterations: core.iterations,
        restoration_iterations: core.restoration_iterations,
        factorizations: core.kkt.factorizations,
    };
    Solution {
        status: match end.outcome.status {
            Status::Solved if end.outcome.left => Status::RestorationFailed,
            status => status,
        },
        objective,
        multipliers: multipliers.rows,
        multipliers_lower: multipliers.lower,
        multipliers_upper: multipliers.upper,
        barrier_parameter: end.mu,
        residuals: Residuals {
            primal: diagnosis.primal,
            dual,
            complementarity: diagnosis.complementarity,
        },
        scaled_error: end.outcome.error,
        violation_stationarity: core.violation_stationarity,
        counts,
        cpu: core.cpu(),
        seconds: core.seconds(),
        history: core.history,
        violations: diagnosis.violations,
        x,
    }
}

/// Multipliers without scales, zero where rows and variables have none.
fn user_multipliers(core: &Core<'_, '_>, iterate: &Iterate) -> Multipliers {
    let formulation = &core.formulation;
    let scale = formulation.objective_scale;
    let n = formulation.problem().variables();
    let mut multipliers = Multipliers {
        rows: vec![0.0; formulation.problem().constraints()],
        lower: vec![0.0; n],
        upper: vec![0.0; n],
    };
    for (row, &user) in formulation.rows.iter().enumerate() {
        multipliers.rows[user] = iterate.y[row] * formulation.row_scales[row] / scale;
    }
    for (i, &user) in formulation.variables.iter().enumerate() {
        multipliers.lower[user] = iterate.z_lower[i] / scale;
        multipliers.upper[user] = iterate.z_upper[i] / scale;
    }
    multipliers
}

/// Keeps the multipliers of products, and takes their part of the gradient into those of the lower bounds.
fn take_products(
    core: &Core<'_, '_>,
    iterate: &Iterate,
    x: &[f64],
    products: &mut Products,
    multipliers: &mut Multipliers,
) {
    let formulation = &core.formulation;
    let mut is_free = vec![false; x.len()];
    for &i in &formulation.variables {
        is_free[i] = true;
    }
    products.multipliers = vec![0.0; products.pairs.len()];
    let mut row = formulation.rows.len();
    for (multiplier, &(i, j)) in products.multipliers.iter_mut().zip(&products.pairs) {
        if is_free[i] && is_free[j] {
            let r = iterate.y[row] / formulation.objective_scale;
            *multiplier = r;
            multipliers.lower[i] -= r * x[j];
            multipliers.lower[j] -= r * x[i];
            row += 1;
        }
    }
}

/// Gives fixed variables the multipliers that balance the gradient of objective and rows, and returns what the others leave
/// of it.
fn balance(core: &Core<'_, '_>, gradient: &[f64], multipliers: &mut Multipliers) -> f64 {
    let mut is_free = vec![false; gradient.len()];
    let mut dual: f64 = 0.0;
    for &i in &core.formulation.variables {
        is_free[i] = true;
        let residual = gradient[i] - multipliers.lower[i] + multipliers.upper[i];
        dual = dual.max(residual.abs());
    }
    for (i, _) in is_free.iter().enumerate().filter(|(_, is_free)| !**is_free) {
        multipliers.lower[i] = gradient[i].max(0.0);
        multipliers.upper[i] = (-gradient[i]).max(0.0);
    }
    dual
}
