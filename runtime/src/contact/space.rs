//! Contacts some of which slide along two directions: Coulomb's law with its cone, by a semismooth Newton method.
//!
//! With `w = K f + q` and `z = f - rho w` the law of all contacts is `F(f) = f - P(z) = 0`, where `P` takes a normal force to
//! `max(z_n, 0)` and a tangential one to the nearest point of the disc (the interval) of radius `mu max(z_n, 0)`. `F` is semismooth,
//! and its residual certifies a solution, wherever that comes from: nothing is enumerated. Where Newton's method ends nowhere it
//! begins anew from projected iterations.
//!
//! Sources: Alart, Curnier, *A mixed formulation for frictional contact problems prone to Newton like solution methods* (1991);
//! Acary, Bremond, Huber, *On solving contact problems with Coulomb friction: formulations and numerical comparisons* (2018).

use super::problem::Cone;
use crate::linalg::dense;
use crate::yardstick;

/// Most steps of Newton's method from one start.
const STEPS: usize = 60;
/// Most halvings of one step.
const HALVINGS: usize = 8;
/// Sweeps of projected iteration between two starts, and how often.
const SWEEPS: usize = 200;
const STARTS: usize = 4;
/// How far contacts that depend on each other yield, as a share of their own coupling: at first, in the end, and from one to the next.
const SOFTEST: f64 = 0.1;
const HARDEST: f64 = 1e-8;
const HARDENS: f64 = 0.1;
/// Most steps of the proximal point method; each leaves the last of these shares of the error of independent contacts.
const PROXIMAL_STEPS: usize = 8;
/// Residual below which forces are a solution, relative to the largest force: rounding error of well-conditioned couplings.
const CERTIFIED: f64 = 1e-11;

/// The problem by lines: normals first, then a tangent a cone, then the second tangents of those that have one.
struct Problem<'a> {
    matrix: &'a [f64],
    offsets: &'a [f64],
    /// Of each line the inverse of its coupling to itself, the same for both tangents of a contact.
    rho: Vec<f64>,
    cones: &'a [Cone],
    normals: usize,
    /// Weight of the proximal term, in couplings of lines to themselves, and the forces around which it is.
    proximal: f64,
    centre: Vec<f64>,
}

/// Writes forces that obey the law; whether they were found.
///
/// What slides with a lower coefficient than it rests with has the cone of rest at first. Where one slides in that solution, the one that
/// is the fastest for its coupling has the cone of sliding from then on: what may rest does.
pub(crate) fn solve_in_space(
    matrix: &[f64],
    offsets: &[f64],
    cones: &[Cone],
    forces: &mut [f64],
) -> bool {
    let mut cones = cones.to_vec();
    loop {
        if !solve_with(matrix, offsets, &cones, forces) {
            return false;
        }
        let problem = Problem::new(matrix, offsets, &cones);
        let Some(fastest) = problem.breaks_loose(forces) else {
            return true;
        };
        cones[fastest].friction = cones[fastest].kinetic;
    }
}

/// Solves with the coefficients `friction` of all cones.
fn solve_with(matrix: &[f64], offsets: &[f64], cones: &[Cone], forces: &mut [f64]) -> bool {
    let mut problem = Problem::new(matrix, offsets, cones);
    let (mut factors, mut pivots) = (matrix.to_vec(), vec![0; offsets.len()]);
    if !dense::factorize_independent(&mut factors, &mut pivots)
        && let Some(found) = problem.compliant()
    {
        forces.copy_from_slice(&found);
        return true;
    }
    let mut start = vec![0.0; offsets.len()];
    for _ in 0..STARTS {
        let mut trial = start.clone();
        problem.newton(&mut trial);
        if problem.is_solved(&trial) {
            forces.copy_from_slice(&trial);
            return true;
        }
        problem.sweep(&mut start);
    }
    false
}

impl<'a> Problem<'a> {
    fn new(matrix: &'a [f64], offsets: &'a [f64], cones: &'a [Cone]) -> Self {
        let lines = offsets.len();
        let across = cones.iter().filter(|cone| cone.across.is_some()).count();
        let normals = lines - cones.len() - across;
        let own = |line: usize| matrix[line * lines + line].abs();
        let inverse = |own: f64| if own > 0.0 { 1.0 / own } else { 1.0 };
        let mut rho: Vec<f64> = (0..lines).map(|line| inverse(own(line))).collect();
        for (k, cone) in cones.iter().enumerate() {
            if let Some(across) = cone.across {
                let both = inverse(own(normals + k).max(own(across)));
                (rho[normals + k], rho[across]) = (both, both);
            }
        }
        Self {
            matrix,
            offsets,
            rho,
            cones,
            normals,
            proximal: 0.0,
            centre: vec![0.0; lines],
        }
    }

    fn lines(&self) -> usize {
        self.offsets.len()
    }

    /// `z = f - rho (K f + q)`, less the proximal term.
    fn proposed(&self, forces: &[f64]) -> Vec<f64> {
        let rows = self.matrix.chunks_exact(self.lines());
        let lines = rows.zip(self.offsets).zip(&self.rho).zip(forces);
        lines
            .map(|(((row, q), rho), own)| {
                let w: f64 = q + row.iter().zip(forces).map(|(k, f)| k * f).sum::<f64>();
                own - rho * w
            })
            .zip(forces.iter().zip(&self.centre))
            .map(|(z, (own, centre))| z - self.proximal * (own - centre))
            .collect()
    }

    /// The tangential lines of a cone, the first one twice where there is no second.
    fn tangents(&self, k: usize) -> (usize, Option<usize>) {
        (self.normals + k, self.cones[k].across)
    }

    /// `P(z)`.
    fn projected(&self, z: &[f64]) -> Vec<f64> {
        let mut nearest = z.to_vec();
        for value in &mut nearest[..self.normals] {
            *value = value.max(0.0);
        }
        for (k, cone) in self.cones.iter().enumerate() {
            let bound = cone.friction * nearest[cone.normal];
            let (first, second) = self.tangents(k);
            let size = second.map_or(z[first].abs(), |second| z[first].hypot(z[second]));
            if size > bound {
                for line in [Some(first), second].into_iter().flatten() {
                    nearest[line] = z[line] * (bound / size);
                }
            }
        }
        nearest
    }

    /// `F(f)`, and its largest component relative to the largest force that offsets ask for.
    fn residual(&self, forces: &[f64]) -> (Vec<f64>, f64) {
        let nearest = self.projected(&self.proposed(forces));
        let residual: Vec<f64> = forces.iter().zip(nearest).map(|(f, p)| f - p).collect();
        let asked = self.offsets.iter().zip(&self.rho).map(|(q, rho)| q * rho);
        let largest = |most: f64, value: f64| {
            if value.abs() <= most {
                most
            } else {
                value.abs()
            }
        };
        let scale = forces.iter().copied().chain(asked).fold(0.0, largest);
        let size = residual.iter().copied().fold(0.0, largest);
        let relative = if size == 0.0 { 0.0 } else { size / scale };
        (residual, relative)
    }

    /// The cone with a lower coefficient for sliding that slides the fastest, measured in forces.
    fn breaks_loose(&self, forces: &[f64]) -> Option<usize> {
        let breaking = self.cones.iter().enumerate();
        let breaking = breaking.filter(|(_, cone)| cone.kinetic < cone.friction);
        let z = self.proposed(forces);
        let speed = |k: usize| {
            let (first, second) = self.tangents(k);
            let along = forces[first] - z[first];
            second.map_or(along.abs(), |second| {
                along.hypot(forces[second] - z[second])
            })
        };
        let scale = forces.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
        let speeds = breaking.map(|(k, _)| (k, speed(k)));
        let sliding = speeds.filter(|(_, speed)| *speed > yardstick::NOTHING * scale);
        sliding
            .max_by(|one, other| one.1.total_cmp(&other.1))
            .map(|(k, _)| k)
    }

    fn is_solved(&self, forces: &[f64]) -> bool {
        self.residual(forces).1 <= CERTIFIED
    }

    /// Forces of contacts that depend on each other: those of contacts that yield, each by a share of its own coupling, in the limit of ever
    /// harder ones. Of all forces with the same motion these are the smallest that the cones allow.
    fn compliant(&mut self) -> Option<Vec<f64>> {
        let mut forces = vec![0.0; self.lines()];
        let mut weight = SOFTEST;
        while weight >= HARDEST {
            self.proximal = weight;
            self.newton(&mut forces);
            weight *= HARDENS;
        }
        // What they have yielded is taken out by the proximal point method.
        let weight = self.proximal;
        for _ in 0..PROXIMAL_STEPS {
            self.proximal = 0.0;
            let solved = self.is_solved(&forces);
            if solved {
                self.centre.fill(0.0);
                return Some(forces);
            }
            self.proximal = weight;
            self.centre.copy_from_slice(&forces);
            self.newton(&mut forces);
        }
        self.proximal = 0.0;
        self.centre.fill(0.0);
        None
    }

    /// Newton's method with a step that halves where the residual does not fall; ends where it falls no further.
    fn newton(&self, forces: &mut [f64]) {
        let (mut residual, mut size) = self.residual(forces);
        for _ in 0..STEPS {
            if size == 0.0 {
                return;
            }
            let mut matrix = self.jacobian(forces);
            let mut pivots = vec![0; self.lines()];
            if dense::factorize(&mut matrix, &mut pivots).is_err() {
                return;
            }
            let mut step = residual.clone();
            dense::solve(&matrix, &pivots, &mut step);
            let mut share = 1.0;
            let mut best: Option<(Vec<f64>, Vec<f64>, f64)> = None;
            for _ in 0..HALVINGS {
                let pairs = forces.iter().zip(&step);
                let trial: Vec<f64> = pairs.map(|(f, s)| f - share * s).collect();
                let (left, relative) = self.residual(&trial);
                let better = best.as_ref().is_none_or(|known| relative < known.2);
                if relative.is_finite() && better {
                    best = Some((trial, left, relative));
                }
                if relative < size {
                    break;
                }
                share *= 0.5;
            }
            let Some((trial, left, relative)) = best else {
                return;
            };
            // At rounding error nothing falls any further.
            if size <= CERTIFIED && relative >= size {
                return;
            }
            forces.copy_from_slice(&trial);
            (residual, size) = (left, relative);
        }
    }

    /// An element of the generalized Jacobian of `F`.
    fn jacobian(&self, forces: &[f64]) -> Vec<f64> {
        let lines = self.lines();
        let z = self.proposed(forces);
        // Row `i` of `dz`.
        let rate = |line: usize, column: usize| {
            let own = f64::from(u8::from(line == column));
            (1.0 - self.proximal) * own - self.rho[line] * self.matrix[line * lines + column]
        };
        let mut matrix = vec![0.0; lines * lines];
        let mut set = |row: usize, weights: &[(usize, f64)]| {
            for column in 0..lines {
                let projected: f64 = weights
                    .iter()
                    .map(|&(line, w)| w * rate(line, column))
                    .sum();
                let own = f64::from(u8::from(row == column));
                matrix[row * lines + column] = own - projected;
            }
        };
        for (line, &proposed) in z[..self.normals].iter().enumerate() {
            if proposed > 0.0 {
                set(line, &[(line, 1.0)]);
            } else {
                set(line, &[]);
            }
        }
        for (k, cone) in self.cones.iter().enumerate() {
            let (first, second) = self.tangents(k);
            let presses = z[cone.normal] > 0.0;
            let bound = cone.friction * z[cone.normal].max(0.0);
            let size = second.map_or(z[first].abs(), |second| z[first].hypot(z[second]));
            let own: Vec<usize> = [Some(first), second].into_iter().flatten().collect();
            for &line in &own {
                if size <= bound {
                    set(line, &[(line, 1.0)]);
                    continue;
                }
                let mut weights = Vec::with_capacity(3);
                if presses {
                    weights.push((cone.normal, cone.friction * z[line] / size));
                }
                for &other in &own {
                    let same = f64::from(u8::from(line == other));
                    let turned = same - z[line] * z[other] / (size * size);
                    weights.push((other, bound / size * turned));
                }
                set(line, &weights);
            }
        }
        matrix
    }

    /// Projected iterations, line by line with what the lines before have become.
    fn sweep(&self, forces: &mut [f64]) {
        for _ in 0..SWEEPS {
            for line in 0..self.normals {
                forces[line] = self.projected(&self.proposed(forces))[line];
                let Some(k) = self.cones.iter().position(|cone| cone.normal == line) else {
                    continue;
                };
                let nearest = self.projected(&self.proposed(forces));
                let (first, second) = self.tangents(k);
                for line in [Some(first), second].into_iter().flatten() {
                    forces[line] = nearest[line];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(mu: f64, matrix: &[f64; 9], offsets: &[f64; 3]) -> [f64; 3] {
        let cones = [Cone {
            normal: 0,
            friction: mu,
            kinetic: mu,
            across: Some(2),
        }];
        let mut forces = [0.0; 3];
        assert!(solve_in_space(matrix, offsets, &cones, &mut forces));
        forces
    }

    #[test]
    fn oblique_fall_sticks_inside_of_the_cone_and_slips_against_its_velocity_outside() {
        let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        // The sliding (0.9, 1.2) is of size 1.5, below mu p = 1.6.
        assert_eq!(one(0.4, &identity, &[-4.0, 0.9, 1.2]), [4.0, -0.9, -1.2]);
        // And above mu p = 1: against (3, 4)/5.
        let forces = one(0.25, &identity, &[-4.0, 0.9, 1.2]);
        for (force, wanted) in forces.iter().zip([4.0, -0.6, -0.8]) {
            assert!((force - wanted).abs() < 1e-14, "{forces:?}");
        }
        assert_eq!(one(0.4, &identity, &[1.0, 0.9, 1.2]), [0.0, 0.0, 0.0]);
    }

    #[test]
    fn what_may_rest_does_and_what_slides_has_the_coefficient_of_sliding() {
        let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let cones = [Cone {
            normal: 0,
            friction: 0.4,
            kinetic: 0.25,
            across: Some(2),
        }];
        // A pull of size 1.5 lies between the friction of sliding, 1, and that of rest, 1.6; one of size 1.7 above both.
        for (along, across, wanted) in [
            (0.9, 1.2, [4.0, -0.9, -1.2]),
            (1.02, 1.36, [4.0, -0.6, -0.8]),
        ] {
            let mut forces = [0.0; 3];
            let offsets = [-4.0, along, across];
            assert!(solve_in_space(&identity, &offsets, &cones, &mut forces));
            for (force, wanted) in forces.iter().zip(wanted) {
                assert!((force - wanted).abs() < 1e-14, "{forces:?}");
            }
        }
    }

    #[test]
    fn coupled_contacts_obey_the_law_of_the_cone() {
        use proptest::prelude::*;
        let problem = (
            proptest::collection::vec(-1.0..1.0_f64, 48),
            proptest::collection::vec(-1.0..1.0_f64, 6),
            (0.0..1.5_f64, 0.0..1.5_f64),
            // The coefficient of sliding as a share of that of rest.
            (0.3..1.3_f64),
        );
        proptest!(crate::random_cases::same_in_every_run(), |((root, q, mu, share) in problem)| {
            // Two contacts of a system with eight coordinates, well away from dependence.
            let m: Vec<f64> = (0..36)
                .map(|k| {
                    let (i, j) = (k / 6, k % 6);
                    let product: f64 = (0..8).map(|l| root[l * 6 + i] * root[l * 6 + j]).sum();
                    0.2 * product + if i == j { 1.0 } else { 0.0 }
                })
                .collect();
            let cone = |normal: usize, friction: f64| Cone {
                normal,
                friction,
                kinetic: friction * share.min(1.0),
                across: Some(4 + normal),
            };
            let cones = [cone(0, mu.0), cone(1, mu.1)];
            let mut f = [0.0; 6];
            prop_assert!(solve_in_space(&m, &q, &cones, &mut f));
            let w: Vec<f64> = (0..6)
                .map(|i| q[i] + (0..6).map(|j| m[6 * i + j] * f[j]).sum::<f64>())
                .collect();
            // The couplings have a moderate condition; the residual is certified to 1e-11.
            for (k, cone) in cones.iter().enumerate() {
                let (p, s, slip) = (f[k], [f[2 + k], f[4 + k]], [w[2 + k], w[4 + k]]);
                prop_assert!(p >= -1e-9 && w[k] >= -1e-9 && (p * w[k]).abs() < 1e-9);
                prop_assert!(s[0].hypot(s[1]) <= cone.friction * p + 1e-9);
                let speed = slip[0].hypot(slip[1]);
                let bound = cone.kinetic * p;
                // s |w_t| = -mu p w_t
                for (s, slip) in s.iter().zip(slip) {
                    prop_assert!((s * speed + bound * slip).abs() < 1e-9, "{:?} {:?}", f, w);
                }
            }
        });
    }
}
