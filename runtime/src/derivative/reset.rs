//! Conditions that come true: how velocities that are set change with those before and with where and when that happens.
//!
//! With the velocities `r(x, p)` right after, at `x = (q, v, u, t)`, the derivatives at the instant that moves by `tau'` are
//!
//! ```text
//! dv+ = r_q dq + r_v dv + (r_t + r_u u') tau' + r_p
//! ```

use super::mode::Acceleration;
use super::tangent::{Matrix, Tangent};

/// The velocities that a condition sets at `x`: which, and each with its derivatives.
fn set_by(
    acceleration: &Acceleration<'_>,
    condition: usize,
    x: &[f64],
) -> Vec<(usize, f64, Vec<f64>)> {
    let n = acceleration.n;
    let mut by = Matrix::zeros(n, acceleration.columns);
    acceleration.derivatives.reset(condition, x, &mut by.values);
    let mut velocities = x[n..2 * n].to_vec();
    acceleration.model.reset(condition, x, &mut velocities);
    let keeps = |k: usize| {
        let own = |column: usize| f64::from(u8::from(column == n + k));
        let mut row = by.row(k).iter().enumerate();
        velocities[k] == x[n + k] && row.all(|(column, by)| *by == own(column))
    };
    (0..n)
        .filter(|&k| !keeps(k))
        .map(|k| (n + k, velocities[k], by.row(k).to_vec()))
        .collect()
}

/// Sets what conditions ask for, all of them from the input vector `x`, there and in the derivatives at an instant that moves along.
pub(super) fn set(
    acceleration: &Acceleration<'_>,
    conditions: &[usize],
    (x, moved): (&mut [f64], &mut Tangent),
) {
    let (at, before) = (x.to_vec(), moved.clone());
    for &condition in conditions {
        for (place, value, by) in set_by(acceleration, condition, &at) {
            x[place] = value;
            moved.all.row_mut(place).copy_from_slice(&before.of(&by));
        }
    }
}

/// The input vector before conditions that come `late` set anything: as `x_after` behind them, and as `x` where they set something, which
/// nothing else may do.
pub(super) fn before(
    acceleration: &Acceleration<'_>,
    late: &[usize],
    (x, x_after): (&[f64], &[f64]),
) -> Vec<f64> {
    let mut before = x_after.to_vec();
    for &condition in late {
        for (place, _, _) in set_by(acceleration, condition, x) {
            before[place] = x[place];
        }
    }
    before
}
