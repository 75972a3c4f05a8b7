//! Conditions that come true: how velocities that are set change with those before and with where and when that happens.
//!
//! With the velocities `r(x, p)` right after, at `x = (q, v, u, t)`, the derivatives at the instant that moves by `tau'` are
//!
//! ```text
//! dv+ = r_q dq + r_v dv + (r_t + r_u u') tau' + r_p
//! ```

use super::matrix::Matrix;
use super::wanted::Wanted;
use crate::model::Model;

/// The derivatives of the velocities that a condition leaves.
fn derivatives(model: &dyn Model, wanted: &Wanted, condition: usize, x: &[f64]) -> Matrix {
    let n = model.declaration().coordinates.len();
    let mut by = Matrix::zeros(n, wanted.columns());
    wanted.derivatives.reset(condition, x, &mut by.values);
    by
}

/// Sets what a condition asks for, in the input vector `x` and in the derivatives `moved` of `(q, v)` at an instant that moves by `times`,
/// where controls change at these rates.
pub(super) fn set(
    model: &dyn Model,
    wanted: &Wanted,
    (condition, control_rates): (usize, &[f64]),
    (x, moved): (&mut [f64], &mut Matrix),
    times: &[f64],
) {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let by = derivatives(model, wanted, condition, x);
    let mut velocities = x[n..2 * n].to_vec();
    model.reset(condition, x, &mut velocities);
    x[n..2 * n].copy_from_slice(&velocities);
    let before = moved.clone();
    for k in 0..n {
        let by = by.row(k);
        let controls = by[2 * n..].iter().zip(control_rates);
        let mut rate: f64 = controls.map(|(by, rate)| by * rate).sum();
        if declaration.explicit_time {
            rate += by[wanted.columns() - wanted.parameters - 1];
        }
        for (column, value) in moved.row_mut(n + k).iter_mut().enumerate() {
            *value = wanted.along(by, &before, column) + rate * times[column];
        }
    }
}

/// The input vector before conditions that come `late` set anything: as `x_after` behind them, and as `x` where they set something, which
/// nothing else may do.
pub(super) fn before(
    model: &dyn Model,
    wanted: &Wanted,
    late: &[usize],
    (x, x_after): (&[f64], &[f64]),
) -> Vec<f64> {
    let n = model.declaration().coordinates.len();
    let mut before = x_after.to_vec();
    for &condition in late {
        let by = derivatives(model, wanted, condition, x);
        for k in 0..n {
            let keeps = |(column, by): (usize, &f64)| *by == f64::from(u8::from(column == n + k));
            if !by.row(k).iter().enumerate().all(keeps) {
                before[n + k] = x[n + k];
            }
        }
    }
    before
}
