//! Derivatives of a motion in contact, put back onto what the contacts hold.
//!
//! Accelerations hold what contacts keep zero up to the error of the motion alone; over a long contact that grows. Each
//! derivative is therefore moved by the least along the directions of the forces:
//!
//! ```text
//! dq -= D (n' D)^-1 (n' dq + g_p)        dv -= C (rho' C)^-1 (rho' dv + v_q dq + v_p)
//! ```

use super::mode::{Acceleration, Hold, solved};
use super::tangent::{Matrix, Tangent, add};
use crate::linalg::dense;
use crate::model::contact_point;

/// Moves derivatives of `(q, v)` onto the gaps and velocities that the contacts hold, where the `acceleration` was last evaluated.
pub(super) fn project(acceleration: &Acceleration<'_>, tangent: &mut Tangent) {
    let normals = acceleration.holds.iter();
    let normals = normals.filter(|hold| matches!(hold, Hold::Normal { .. }));
    let gap = |hold: Hold| match hold {
        Hold::Normal { contact, .. } | Hold::Tangent { contact } => {
            acceleration.point(contact, contact_point::GAP).1
        }
    };
    let velocity = |hold: Hold| acceleration.velocity(hold).1;
    // The normals are the first of what is held.
    move_along(acceleration, (normals.count(), 0), gap, tangent);
    let all = acceleration.holds.len();
    move_along(acceleration, (all, acceleration.n), velocity, tangent);
}

/// Moves the rows from `first` on, along the first `order` forces, so that what has the derivatives `by` does not change.
fn move_along<'a>(
    acceleration: &'a Acceleration<'_>,
    (order, first): (usize, usize),
    by: impl Fn(Hold) -> &'a [f64],
    tangent: &mut Tangent,
) {
    let coupling = acceleration.coupling();
    let mut matrix = Matrix::zeros(order, order);
    let mut left = Matrix::zeros(order, tangent.all.columns);
    for (i, &hold) in acceleration.holds[..order].iter().enumerate() {
        matrix.row_mut(i).copy_from_slice(&coupling.row(i)[..order]);
        left.row_mut(i).copy_from_slice(&tangent.of(by(hold)));
    }
    let mut pivots = vec![0; order];
    if dense::factorize(&mut matrix.values, &mut pivots).is_err() {
        return;
    }
    let forces = solved(&matrix, &pivots, left);
    for (j, &hold) in acceleration.holds[..order].iter().enumerate() {
        for k in 0..acceleration.n {
            let component = acceleration.direction(hold, k);
            add(tangent.all.row_mut(first + k), -component, forces.row(j));
        }
    }
}
