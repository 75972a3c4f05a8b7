//! Unilateral contacts with planar Coulomb friction.
//!
//! Normal quantities satisfy `0 <= p_i _|_ w_i >= 0`. A cone adds a tangential line with
//!
//! ```text
//! |s| <= mu p,  s = -mu p sign(w_t) unless w_t = 0
//! ```
//!
//! Each cone slips forward, slips backward or sticks; for a given choice the normals are left with a linear
//! complementarity problem. Contacts that are not coupled are solved apart; of few that are the choices are tried one after
//! the other, many are solved by [`contact`].

use crate::contact::{self, is_in_space, solve_in_space, solve_polyhedral};
use crate::linalg::{dense, lcp};

pub(super) use crate::contact::Cone;

/// Most cones whose choices are tried one after the other.
const MOST_CHOICES: usize = 6;
/// Most lines beside few cones that are left to Lemke's method at first.
const FEW_LINES: usize = 14;
/// Violation of the friction law that is rounding error, relative to the largest force or velocity.
const ROUNDING: f64 = 1e-11;
/// The same where nothing else is left: contacts that are nearly dependent.
const ILL_CONDITIONED: f64 = 1e-7;

/// What a cone does.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Choice {
    /// `s = -mu p sense`.
    Slip(f64),
    /// `w_t = 0`.
    Stick,
    /// `w_t = 0` because other contacts stick: `s = 0`.
    Idle,
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
    if offsets.len() <= 1 {
        return lcp::solve(couplings, offsets, forces);
    }
    if couplings.iter().chain(offsets).any(|v| !v.is_finite()) {
        return Err(lcp::LcpError::NotFinite);
    }
    if is_in_space(cones) {
        return match solve_in_space(couplings, offsets, cones, forces) {
            true => Ok(()),
            false => Err(lcp::LcpError::Ray),
        };
    }
    let (lines, normals) = (offsets.len(), offsets.len() - cones.len());
    let contact = |line: usize| line.checked_sub(normals).map_or(line, |k| cones[k].normal);
    let together = |i: usize, j: usize| {
        contact(i) == contact(j)
            || couplings[i * lines + j] != 0.0
            || couplings[j * lines + i] != 0.0
    };
    let blocks = contact::blocks(lines, together);
    if let [_] = blocks[..] {
        return solve_block(couplings, offsets, cones, forces);
    }
    for block in blocks {
        let entries = block.iter().flat_map(|&row| {
            let columns = block.iter();
            columns.map(move |&column| couplings[row * lines + column])
        });
        let matrix: Vec<f64> = entries.collect();
        let vector: Vec<f64> = block.iter().map(|&line| offsets[line]).collect();
        let cones: Vec<Cone> = (block.iter())
            .filter_map(|line| line.checked_sub(normals))
            .filter_map(|k| {
                let normal = block.iter().position(|&line| line == cones[k].normal)?;
                Some(Cone { normal, ..cones[k] })
            })
            .collect();
        let mut own = vec![0.0; block.len()];
        solve_block(&matrix, &vector, &cones, &mut own)?;
        for (&line, force) in block.iter().zip(own) {
            forces[line] = force;
        }
    }
    Ok(())
}

/// Contacts that are coupled.
fn solve_block(
    couplings: &[f64],
    offsets: &[f64],
    cones: &[Cone],
    forces: &mut [f64],
) -> Result<(), lcp::LcpError> {
    // Where rest and sliding have coefficients of their own, several choices may be consistent, of which rest is right.
    let two = cones.iter().any(|cone| cone.kinetic < cone.friction);
    if !two && (cones.len() > MOST_CHOICES || offsets.len() > FEW_LINES) {
        let problem = contact::Problem {
            matrix: couplings,
            offsets,
            cones,
        };
        if let Some(solution) = contact::solve(&problem, None) {
            forces.copy_from_slice(&solution.forces);
            return Ok(());
        }
    }
    if cones.is_empty() {
        return lcp::solve(couplings, offsets, forces);
    }
    let problem = Problem {
        couplings,
        offsets,
        cones,
        normals: offsets.len() - cones.len(),
    };
    let violation = if cones.len() <= MOST_CHOICES {
        problem.try_choices(forces)
    } else {
        f64::INFINITY
    };
    if violation <= ROUNDING {
        return Ok(());
    }
    if two {
        let least = if violation <= ILL_CONDITIONED {
            Ok(())
        } else {
            Err(lcp::LcpError::Ray)
        };
        return least;
    }
    let mut pivoted = vec![0.0; offsets.len()];
    let outcome = problem.solve_polyhedral(&mut pivoted);
    if outcome.is_ok() {
        forces.copy_from_slice(&pivoted);
    } else if violation <= ILL_CONDITIONED {
        return Ok(());
    }
    outcome
}

struct Problem<'a> {
    couplings: &'a [f64],
    offsets: &'a [f64],
    cones: &'a [Cone],
    /// Number of unilateral lines.
    normals: usize,
}

impl Problem<'_> {
    fn coupling(&self, row: usize, column: usize) -> f64 {
        self.couplings[row * self.offsets.len() + column]
    }

    /// Tries the choices of all cones until one is consistent; writes the forces of the best one and returns
    /// its relative violation. Where several are consistent, contacts press each other; those without
    /// friction come first, then those that stick.
    fn try_choices(&self, forces: &mut [f64]) -> f64 {
        let count = self.cones.len();
        let kinds: usize = if count == 1 { 3 } else { 4 };
        let mut choices = vec![Choice::Stick; count];
        let mut trial = vec![0.0; forces.len()];
        let mut least = f64::INFINITY;
        let mut numbers: Vec<usize> = (0..kinds.pow(count as u32)).collect();
        if self.cones.iter().any(|cone| cone.kinetic < cone.friction) {
            // What may rest does.
            numbers.sort_by_key(|&number| {
                let digits = (0..count as u32).map(|k| number / kinds.pow(k) % kinds);
                digits.filter(|digit| digit + 4 - kinds >= 2).count()
            });
        }
        for number in numbers {
            let mut rest = number;
            for (k, choice) in choices.iter_mut().enumerate() {
                let sense = if self.offsets[self.normals + k] < 0.0 {
                    -1.0
                } else {
                    1.0
                };
                *choice = match rest % kinds + 4 - kinds {
                    0 => Choice::Idle,
                    1 => Choice::Stick,
                    2 => Choice::Slip(sense),
                    _ => Choice::Slip(-sense),
                };
                rest /= kinds;
            }
            let violation = self.attempt(&choices, &mut trial);
            if violation.is_some_and(|violation| violation < least) {
                least = violation.unwrap_or(least);
                forces.copy_from_slice(&trial);
            }
            if least <= ROUNDING {
                break;
            }
        }
        least
    }

    /// Forces for the given choices and by how much they contradict them, relative to the largest force or
    /// velocity; `None` if there are none.
    fn attempt(&self, choices: &[Choice], forces: &mut [f64]) -> Option<f64> {
        let (normals, lines) = (self.normals, self.offsets.len());
        let slope = |k: usize| match choices[k] {
            Choice::Slip(sense) => -sense * self.cones[k].kinetic,
            Choice::Stick | Choice::Idle => 0.0,
        };
        // Coupling of a normal force, with the friction of a slipping contact, to a line.
        let slipping: Vec<Option<usize>> = (0..normals)
            .map(|column| self.cones.iter().position(|cone| cone.normal == column))
            .collect();
        let along = |row: usize, column: usize| {
            let own = self.coupling(row, column);
            slipping[column].map_or(own, |k| own + slope(k) * self.coupling(row, normals + k))
        };
        let sticking: Vec<usize> = (0..choices.len())
            .filter(|&k| choices[k] == Choice::Stick)
            .map(|k| normals + k)
            .collect();
        let mut factors: Vec<f64> = sticking
            .iter()
            .flat_map(|&row| {
                sticking
                    .iter()
                    .map(move |&column| self.coupling(row, column))
            })
            .collect();
        let mut pivots = vec![0; sticking.len()];
        dense::factorize(&mut factors, &mut pivots).ok()?;
        // Sticking friction for no normal force, then for a unit of each.
        let response = |of: &dyn Fn(usize) -> f64| {
            let mut s: Vec<f64> = sticking.iter().map(|&row| -of(row)).collect();
            dense::solve(&factors, &pivots, &mut s);
            s
        };
        let through = |row: usize, s: &[f64]| -> f64 {
            let pairs = sticking.iter().zip(s);
            pairs.map(|(&line, s)| self.coupling(row, line) * s).sum()
        };
        let still = response(&|row| self.offsets[row]);
        let units: Vec<Vec<f64>> = (0..normals)
            .map(|column| response(&|row| along(row, column)))
            .collect();
        let mut matrix = vec![0.0; normals * normals];
        let mut vector = vec![0.0; normals];
        for row in 0..normals {
            vector[row] = self.offsets[row] + through(row, &still);
            for column in 0..normals {
                matrix[row * normals + column] = along(row, column) + through(row, &units[column]);
            }
        }
        let mut p = vec![0.0; normals];
        lcp::solve(&matrix, &vector, &mut p).ok()?;
        forces[..normals].copy_from_slice(&p);
        for (k, cone) in self.cones.iter().enumerate() {
            forces[normals + k] = slope(k) * p[cone.normal];
        }
        for (i, &line) in sticking.iter().enumerate() {
            let by_normals: f64 = units.iter().zip(&p).map(|(unit, p)| unit[i] * p).sum();
            forces[line] = still[i] + by_normals;
        }
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let scale = largest(self.offsets).max(largest(forces)) + f64::MIN_POSITIVE;
        let violations = (0..choices.len()).map(|k| {
            let tangent = normals + k;
            let p = p[self.cones[k].normal];
            let velocity: f64 = self.offsets[tangent]
                + (0..lines)
                    .map(|line| self.coupling(tangent, line) * forces[line])
                    .sum::<f64>();
            match choices[k] {
                Choice::Stick => forces[tangent].abs() - self.cones[k].friction * p,
                Choice::Slip(sense) if p > 0.0 => -sense * velocity,
                Choice::Idle if p > 0.0 => velocity.abs(),
                Choice::Slip(_) | Choice::Idle => 0.0,
            }
        });
        Some(violations.fold(0.0, f64::max) / scale)
    }

    /// All choices at once, by Lemke's method.
    fn solve_polyhedral(&self, forces: &mut [f64]) -> Result<(), lcp::LcpError> {
        let problem = contact::Problem {
            matrix: self.couplings,
            offsets: self.offsets,
            cones: self.cones,
        };
        solve_polyhedral(&problem, forces)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(mu: f64, coupling: [f64; 4], offsets: [f64; 2]) -> [f64; 2] {
        let cone = Cone {
            normal: 0,
            friction: mu,
            kinetic: mu,
            across: None,
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

    #[test]
    fn choices_satisfy_the_law_on_random_contacts_and_agree_with_the_polyhedral_form() {
        use proptest::prelude::*;
        let problem = (
            proptest::collection::vec(-1.0..1.0, 25),
            proptest::collection::vec(-1.0..1.0, 4),
            (0.0..1.5, 0.0..1.5),
        );
        proptest!(crate::random_cases::same_in_every_run(), |((root, q, mu) in problem)| {
            // Two normals and two tangents of a system with five coordinates, well away from dependence.
            let m: Vec<f64> = (0..16)
                .map(|k| {
                    let (i, j) = (k / 4, k % 4);
                    let product: f64 = (0..5).map(|l| root[l * 5 + i] * root[l * 5 + j]).sum();
                    0.2 * product + if i == j { 1.0 } else { 0.0 }
                })
                .collect();
            let cones = [
                Cone { normal: 0, friction: mu.0, kinetic: mu.0, across: None },
                Cone { normal: 1, friction: mu.1, kinetic: mu.1, across: None },
            ];
            let problem = Problem { couplings: &m, offsets: &q, cones: &cones, normals: 2 };
            let mut f = [0.0; 4];
            prop_assert!(problem.try_choices(&mut f) <= ROUNDING);
            // Diagonally dominant couplings: the solution is unique, its condition moderate.
            let w: Vec<f64> = (0..4)
                .map(|i| q[i] + (0..4).map(|j| m[4 * i + j] * f[j]).sum::<f64>())
                .collect();
            for (k, cone) in cones.iter().enumerate() {
                let (p, s, bound) = (f[k], f[2 + k], cone.friction * f[k]);
                prop_assert!(p >= 0.0 && w[k] >= -1e-9 && (p * w[k]).abs() < 1e-9);
                prop_assert!(s.abs() <= bound + 1e-9);
                // s = -mu p sign(w_t) unless w_t = 0
                prop_assert!((s * w[2 + k] + bound * w[2 + k].abs()).abs() < 1e-9);
            }
            let mut pivoted = [0.0; 4];
            if problem.solve_polyhedral(&mut pivoted).is_ok() {
                for (a, b) in f.iter().zip(&pivoted) {
                    prop_assert!((a - b).abs() < 1e-9, "{:?} {:?}", f, pivoted);
                }
            }
        });
    }
}
