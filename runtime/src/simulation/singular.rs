//! Singular configurations of joints on the way of a motion, where it is not unique.
//!
//! With `M = L L'` the smallest singular value of `A = G L^-T = U S V'` vanishes where rows of joints come to depend on each
//! other. Its vectors `u` and `w` go on smoothly if it changes its sign there, so that between two instants it has done so where
//! `u` keeps its direction and `w` turns round, or the other way. They are computed where a pivot of `A A'` is small only, which takes far fewer
//! operations.

use nalgebra::{DMatrix, DVector};

use super::Simulation;
use crate::joints::Joints;
use crate::model::Model;

/// Singular values above this share of the largest one are not followed.
const SMALL: f64 = 0.3;
/// Smallest pivot of `A A'`, to its largest entry, above which the rows are far from depending on each other.
const NEAR: f64 = 0.1;
/// Least cosine between vectors that are the same ones.
const SAME: f64 = 0.5;

/// The smallest singular value at an instant, as a share of the largest, and its vectors.
struct Smallest {
    time: f64,
    share: f64,
    left: DVector<f64>,
    right: DVector<f64>,
}

impl Smallest {
    fn at(model: &dyn Model, joints: &mut Joints<'_>, x: &[f64], time: f64) -> Option<Self> {
        let n = model.declaration().coordinates.len();
        joints.evaluate(x);
        let mut mass = vec![0.0; n * n];
        model.mass_matrix(x, &mut mass);
        let lower = DMatrix::from_row_slice(n, n, &mass).cholesky()?.l();
        let rows = DMatrix::from_row_slice(joints.count(), n, joints.gradients());
        let scaled = lower.solve_lower_triangular(&rows.transpose())?.transpose();
        let found = scaled.try_svd(true, true, f64::EPSILON, 1000)?;
        let (left, right) = (found.u?, found.v_t?);
        let least = found.singular_values.imin();
        let share = found.singular_values[least] / found.singular_values.max();
        share.is_finite().then(|| Self {
            time,
            share,
            left: left.column(least).into_owned(),
            right: right.row(least).transpose(),
        })
    }

    /// When it has passed zero since `before`, if it has.
    fn passed(&self, before: &Self) -> Option<f64> {
        let (u, w) = (self.left.dot(&before.left), self.right.dot(&before.right));
        let same = u.abs() > SAME && w.abs() > SAME;
        if !same || u * w > 0.0 || self.share.max(before.share) > SMALL {
            return None;
        }
        let sum = before.share + self.share;
        let part = if sum > 0.0 { before.share / sum } else { 0.0 };
        Some(before.time + part * (self.time - before.time))
    }
}

/// The first singular configuration on the way of a run, if there is one: its time, and the row that depends most on the
/// others there. `input` is that of an instant of its trajectory.
pub(super) fn first(
    model: &dyn Model,
    run: &Simulation,
    mut input: impl FnMut(usize) -> Vec<f64>,
) -> Option<(f64, usize)> {
    let mut joints = Joints::of(model)?;
    if joints.count() == 0 {
        return None;
    }
    let mut before: Option<Smallest> = None;
    let mut was_near = false;
    for k in 0..run.trajectory.time.len() {
        let x = input(k);
        let near = joints.least_pivot(&x) < NEAR;
        if !near && !was_near {
            before = None;
            continue;
        }
        let mut at =
            |k: usize, x: &[f64]| Smallest::at(model, &mut joints, x, run.trajectory.time[k]);
        if near && !was_near && k > 0 {
            before = at(k - 1, &input(k - 1));
        }
        was_near = near;
        let now = at(k, &x);
        let time = now.as_ref().zip(before.as_ref());
        if let Some((time, now)) = time
            .and_then(|(now, before)| now.passed(before))
            .zip(now.as_ref())
        {
            let place = now.left.iamax();
            return Some((time, joints.held()[place]));
        }
        before = now;
    }
    None
}
