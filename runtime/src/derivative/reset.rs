//! Conditions that come true: how velocities that are set change with those before and with where and when that happens.
//!
//! With the velocities `r(x, p)` right after, at `x = (q, v, u, t)`, the derivatives at the instant that moves by `tau'` are
//!
//! ```text
//! dv+ = r_q dq + r_v dv + (r_t + r_u u') tau' + r_p
//! ```

use super::mode::Acceleration;
use super::tangent::{Matrix, Tangent};

/// The derivatives of the velocities that a condition leaves.
fn derivatives(acceleration: &Acceleration<'_>, condition: usize, x: &[f64]) -> Matrix {
    let mut by = Matrix::zeros(acceleration.n, acceleration.columns);
    acceleration.derivatives.reset(condition, x, &mut by.values);
    by
}

/// Sets what a condition asks for, in the input vector `x` and in the derivatives at an instant that moves along.
pub(super) fn set(
    acceleration: &Acceleration<'_>,
    condition: usize,
    (x, moved): (&mut [f64], &mut Tangent),
) {
    let n = acceleration.n;
    let by = derivatives(acceleration, condition, x);
    let mut velocities = x[n..2 * n].to_vec();
    acceleration.model.reset(condition, x, &mut velocities);
    x[n..2 * n].copy_from_slice(&velocities);
    let before = moved.clone();
    for k in 0..n {
        moved
            .all
            .row_mut(n + k)
            .copy_from_slice(&before.of(by.row(k)));
    }
}

/// The input vector before conditions that come `late` set anything: as `x_after` behind them, and as `x` where they set something, which
/// nothing else may do.
pub(super) fn before(
    acceleration: &Acceleration<'_>,
    late: &[usize],
    (x, x_after): (&[f64], &[f64]),
) -> Vec<f64> {
    let n = acceleration.n;
    let mut before = x_after.to_vec();
    for &condition in late {
        let by = derivatives(acceleration, condition, x);
        for k in 0..n {
            let keeps = |(column, by): (usize, &f64)| *by == f64::from(u8::from(column == n + k));
            if !by.row(k).iter().enumerate().all(keeps) {
                before[n + k] = x[n + k];
            }
        }
    }
    before
}
