//! Derivatives of a motion in contact, put back onto what the contacts hold.
//!
//! Accelerations hold what contacts keep zero up to the error of the motion alone; over a long contact that grows. Each
//! derivative is therefore moved by the least along the directions of the forces:
//!
//! ```text
//! dq -= D (n' D)^-1 (n' dq + g_p)        dv -= C (rho' C)^-1 (rho' dv + v_q dq + v_p)
//! ```

use super::mode::Acceleration;
use super::tangent::{Factors, Matrix, Tangent};
use crate::contact::Line;
use crate::model::contact_point;

/// Moves derivatives of `(q, v)` onto the gaps and velocities that the contacts hold, where the `acceleration` was last evaluated.
pub(super) fn project(acceleration: &Acceleration<'_>, tangent: &mut Tangent) {
    let lines = acceleration.lines.iter();
    // The normals are the first of what is held.
    let normals = lines
        .clone()
        .take_while(|line| matches!(line, Line::Normal { .. }));
    let gap = |line: &Line| acceleration.point(line.contact(), contact_point::GAP).1;
    move_along(
        acceleration,
        &normals.map(gap).collect::<Vec<_>>(),
        0,
        tangent,
    );
    let velocities = lines.map(|&line| acceleration.velocity(line).1);
    let velocities: Vec<&[f64]> = velocities.collect();
    move_along(acceleration, &velocities, acceleration.n, tangent);
}

/// Moves the rows from `first` on, along the forces of the first lines, so that what has the derivatives `held` does not change.
fn move_along(
    acceleration: &Acceleration<'_>,
    held: &[&[f64]],
    first: usize,
    tangent: &mut Tangent,
) {
    let mut left = Matrix::zeros(held.len(), tangent.all.columns);
    for (i, by) in held.iter().enumerate() {
        left.row_mut(i).copy_from_slice(&tangent.of(by));
    }
    let coupling = acceleration.couplings(&acceleration.lines[..held.len()]);
    if let Some(factors) = Factors::of(coupling) {
        let forces = factors.solve_all(left);
        acceleration.push_rows(&forces, -1.0, (&mut tangent.all, first));
    }
}
