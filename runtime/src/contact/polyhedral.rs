//! All choices at once, by Lemke's method on the polyhedral form
//!
//! ```text
//! s = b_+ - b_-    0 <= b_+ _|_  w_t + l >= 0    0 <= b_- _|_ -w_t + l >= 0
//!                  0 <= l   _|_  mu p - b_+ - b_- >= 0
//! ```
//!
//! In the plane it is exact. Where all bounds `mu p` are given, as of switches, those of the last rows are no part of the covering vector: forces
//! then stay bounded along every ray, so that there is none but the first, whatever the signs and the symmetry of the couplings.
//!
//! Sources: Stewart, Trinkle, An implicit time-stepping scheme for rigid body dynamics, 1996; Cao, Ferris, A pivotal method for affine variational
//! inequalities, 1996.

use super::problem::Problem;
use crate::linalg::lcp;

/// Solves a problem; writes the forces.
///
/// # Errors
/// Those of Lemke's method.
pub(crate) fn solve_polyhedral(
    problem: &Problem<'_>,
    forces: &mut [f64],
) -> Result<(), lcp::LcpError> {
    if problem.cones.is_empty() {
        return lcp::solve(problem.matrix, problem.offsets, forces);
    }
    let (normals, lines) = (problem.normals(), problem.lines());
    let size = normals + 3 * problem.cones.len();
    let mut matrix = vec![0.0; size * size];
    let mut vector = vec![0.0; size];
    // Variables of the problem that act on a line, with their signs: b_- acts against b_+.
    let variables = |line: usize| -> [(usize, f64); 2] {
        match line.checked_sub(normals) {
            None => [(line, 1.0), (line, 0.0)],
            Some(cone) => {
                let first = normals + 3 * cone;
                [(first, 1.0), (first + 1, -1.0)]
            }
        }
    };
    for row in 0..lines {
        for (i, row_sign) in variables(row) {
            vector[i] += row_sign * problem.offsets[row];
            for column in 0..lines {
                for (j, column_sign) in variables(column) {
                    matrix[i * size + j] += row_sign * column_sign * problem.coupling(row, column);
                }
            }
        }
    }
    for (k, cone) in problem.cones.iter().enumerate() {
        let first = normals + 3 * k;
        let bound = first + 2;
        matrix[first * size + bound] = 1.0;
        matrix[(first + 1) * size + bound] = 1.0;
        matrix[bound * size + cone.normal] = cone.friction;
        matrix[bound * size + first] = -1.0;
        matrix[bound * size + first + 1] = -1.0;
    }
    let mut z = vec![0.0; size];
    let given = problem
        .cones
        .iter()
        .all(|cone| cone.normal >= problem.surfaces);
    let is_bound = |row: usize| row >= normals && (row - normals) % 3 == 2;
    let cover = |row: usize| if given && is_bound(row) { 0.0 } else { 1.0 };
    lcp::lemke((&matrix, &vector), cover, &mut z)?;
    forces[..normals].copy_from_slice(&z[..normals]);
    for (k, friction) in forces[normals..].iter_mut().enumerate() {
        let first = normals + 3 * k;
        *friction = z[first] - z[first + 1];
    }
    Ok(())
}
