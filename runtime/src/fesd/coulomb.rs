//! Unilateral contacts with planar Coulomb friction as one linear complementarity problem.
//!
//! Normal quantities satisfy `0 <= p_i _|_ w_i >= 0`. A cone adds a tangential line with
//!
//! ```text
//! s = b_+ - b_-    0 <= b_+ _|_  w_t + l >= 0    0 <= b_- _|_ -w_t + l >= 0
//!                  0 <= l   _|_  mu p - b_+ - b_- >= 0
//! ```
//!
//! that is `|s| <= mu p`, and `s = -mu p sign(w_t)` where `w_t != 0`. In the plane this polyhedral form is
//! exact. Source: Stewart, Trinkle, An implicit time-stepping scheme for rigid body dynamics, 1996.

use crate::linalg::lcp;

/// Friction of one contact: the line of its normal and its coefficient.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cone {
    pub(super) normal: usize,
    pub(super) friction: f64,
}

/// Solves `w = M f + q` with the laws above for the lines; writes the forces `f`.
///
/// Lines that are the tangent of a cone come last, in the order of `cones`; all others are unilateral.
/// `couplings` is `M`, row-major.
pub(super) fn solve(
    couplings: &[f64],
    offsets: &[f64],
    cones: &[Cone],
    forces: &mut [f64],
) -> Result<(), lcp::LcpError> {
    if cones.is_empty() {
        return lcp::solve(couplings, offsets, forces);
    }
    let lines = offsets.len();
    let normals = lines - cones.len();
    let size = normals + 3 * cones.len();
    let mut matrix = vec![0.0; size * size];
    let mut vector = vec![0.0; size];
    // Lines that a variable of the problem acts on, with its sign: b_- acts against b_+.
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
            vector[i] += row_sign * offsets[row];
            for column in 0..lines {
                for (j, column_sign) in variables(column) {
                    matrix[i * size + j] +=
                        row_sign * column_sign * couplings[row * lines + column];
                }
            }
        }
    }
    for (k, cone) in cones.iter().enumerate() {
        let first = normals + 3 * k;
        let bound = first + 2;
        matrix[first * size + bound] = 1.0;
        matrix[(first + 1) * size + bound] = 1.0;
        matrix[bound * size + cone.normal] = cone.friction;
        matrix[bound * size + first] = -1.0;
        matrix[bound * size + first + 1] = -1.0;
    }
    let mut z = vec![0.0; size];
    lcp::solve(&matrix, &vector, &mut z)?;
    forces[..normals].copy_from_slice(&z[..normals]);
    for (k, friction) in forces[normals..].iter_mut().enumerate() {
        let first = normals + 3 * k;
        *friction = z[first] - z[first + 1];
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(mu: f64, coupling: [f64; 4], offsets: [f64; 2]) -> [f64; 2] {
        let cone = Cone {
            normal: 0,
            friction: mu,
        };
        let mut forces = [0.0; 2];
        solve(&coupling, &offsets, &[cone], &mut forces).expect("solvable");
        forces
    }

    #[test]
    fn steep_fall_sticks_and_flat_fall_slips() {
        // v = (-3, 1): p = 3 stops the fall, s = -1 the sliding, inside the cone.
        assert_eq!(one(0.5, [1.0, 0.0, 0.0, 1.0], [-3.0, 1.0]), [3.0, -1.0]);
        // v_t = 2 > mu p: the cone is reached, s = -mu p.
        assert_eq!(one(0.5, [1.0, 0.0, 0.0, 1.0], [-3.0, 2.0]), [3.0, -1.5]);
        assert_eq!(one(0.5, [1.0, 0.0, 0.0, 1.0], [-3.0, -2.0]), [3.0, 1.5]);
    }

    #[test]
    fn coupled_slip_presses_harder_or_less() {
        // s = -p/2: (1 - c/2) p = 3
        for c in [0.4, -0.4] {
            let forces = one(0.5, [1.0, c, c, 1.0], [-3.0, 9.0]);
            let p = 3.0 / (1.0 - 0.5 * c);
            assert!((forces[0] - p).abs() < 1e-14 && (forces[1] + 0.5 * p).abs() < 1e-14);
        }
    }

    #[test]
    fn separating_contact_takes_neither_force_nor_friction() {
        assert_eq!(one(0.5, [1.0, 0.3, 0.3, 1.0], [1.0, 2.0]), [0.0, 0.0]);
    }

    #[test]
    fn friction_that_presses_more_than_the_force_lifts_stops_the_sliding() {
        // Slip adds s = 2 p, which presses: (1 - 1.6) p = 1 has no solution p >= 0. Sticking has:
        // det = 0.01, p = (0.65 + 4) / 0.01, s = (5 + 0.8) / 0.01 < 2 p.
        let forces = one(2.0, [1.0, -0.8, -0.8, 0.65], [-1.0, -5.0]);
        // condition number 300
        assert!((forces[0] - 465.0).abs() < 1e-10 && (forces[1] - 580.0).abs() < 1e-10);
    }
}
