//! The order of the ways in which a problem is solved.

use super::active_set::consistent;
use super::basic::reduced;
use super::polyhedral::solve_polyhedral;
use super::problem::{Problem, Solution, Tangent};
use super::state::ContactState;
use crate::yardstick;

/// Multiple of rounding error up to which a solution may contradict the law: its forces are those of linear systems whose
/// condition that multiplies.
const ACCEPTED: f64 = 1e2;
/// A solution whose forces the equations of its states determine, from the states of a `guess` on if there is one.
/// `None` where none is found, which for contacts with friction may mean that there is none.
pub(crate) fn solve(problem: &Problem<'_>, guess: Option<&[ContactState]>) -> Option<Solution> {
    if !problem.is_finite() {
        return None;
    }
    let tangents = problem.tangents();
    let guess = match guess {
        Some(guess) => guess.to_vec(),
        None => pressed(problem, &tangents),
    };
    let found = from(problem, &tangents, guess);
    found.or_else(|| {
        let mut forces = vec![0.0; problem.lines()];
        solve_polyhedral(problem, &mut forces).ok()?;
        from(problem, &tangents, states_of(problem, &tangents, &forces))
    })
}

fn from(
    problem: &Problem<'_>,
    tangents: &[Option<Tangent>],
    guess: Vec<ContactState>,
) -> Option<Solution> {
    let (states, forces) = consistent(problem, tangents, guess)?;
    let solution = reduced(problem, tangents, states, forces)?;
    (violation(problem, tangents, &solution) <= ACCEPTED).then_some(solution)
}

/// All contacts closed that nothing opens by itself; those that slide by themselves slip.
fn pressed(problem: &Problem<'_>, tangents: &[Option<Tangent>]) -> Vec<ContactState> {
    let zero = yardstick::NOTHING * problem.largest_offset();
    let of = |(i, tangent): (usize, &Option<Tangent>)| {
        let normal = problem.offsets[i];
        match tangent {
            _ if normal > zero => ContactState::Open,
            None => ContactState::Frictionless,
            Some(Tangent { line, friction, .. }) => {
                let slip = problem.offsets[*line];
                let inside = slip.abs() <= friction * normal.abs() || slip.abs() <= zero;
                if inside {
                    ContactState::Stick
                } else {
                    ContactState::slip(slip)
                }
            }
        }
    };
    tangents.iter().enumerate().map(of).collect()
}

/// The states that forces tell.
fn states_of(
    problem: &Problem<'_>,
    tangents: &[Option<Tangent>],
    forces: &[f64],
) -> Vec<ContactState> {
    let motions = problem.motions(forces);
    let of = |(i, tangent): (usize, &Option<Tangent>)| {
        let p = forces[i];
        if p <= problem.zero_force(i, motions[i].1) {
            return ContactState::Open;
        }
        let Some(Tangent { line, friction, .. }) = *tangent else {
            return ContactState::Frictionless;
        };
        let s = forces[line];
        let reserve = friction * p - s.abs();
        if reserve > yardstick::NOTHING * friction * p {
            ContactState::Stick
        } else {
            ContactState::slip(-s)
        }
    };
    tangents.iter().enumerate().map(of).collect()
}

/// By how much a solution contradicts the law, in units of what counts as zero.
fn violation(problem: &Problem<'_>, tangents: &[Option<Tangent>], solution: &Solution) -> f64 {
    let motions = problem.motions(&solution.forces);
    let of = |(i, tangent): (usize, &Option<Tangent>)| {
        let (normal, zero) = motions[i];
        let p = solution.forces[i];
        let own = -p / problem.zero_force(i, zero);
        let apart = match solution.states[i] {
            ContactState::Open => -normal / zero,
            _ => normal.abs() / zero,
        };
        let Some(Tangent { line, friction, .. }) = *tangent else {
            return own.max(apart);
        };
        let ((slip, zero), s) = (motions[line], solution.forces[line]);
        let beyond = (s.abs() - friction * p) / problem.zero_force(line, zero);
        let slides = match solution.states[i] {
            ContactState::Stick => slip.abs() / zero,
            ContactState::Slip(direction) => -direction.sign() * slip / zero,
            _ => 0.0,
        };
        own.max(apart).max(beyond).max(slides)
    };
    let worst = tangents.iter().enumerate().map(of);
    worst.fold(0.0, |worst, one| {
        if one.is_nan() {
            f64::INFINITY
        } else {
            worst.max(one)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::super::problem::Cone;
    use super::*;
    use crate::linalg::lcp;
    use crate::random_cases::same_in_every_run;
    use proptest::prelude::*;

    /// `N' N + shift` of a matrix `N` with `rank` rows of which every entry but some are zero.
    fn gram(root: &[f64], order: usize, rank: usize, shift: f64) -> Vec<f64> {
        let entry = |row: usize, column: usize| {
            let value = root[(row * 31 + column * 17) % root.len()];
            if (row + column).is_multiple_of(3) {
                value
            } else {
                0.0
            }
        };
        let product = |i: usize, j: usize| {
            let sum: f64 = (0..rank).map(|row| entry(row, i) * entry(row, j)).sum();
            sum + if i == j { shift } else { 0.0 }
        };
        (0..order * order)
            .map(|k| product(k / order, k % order))
            .collect()
    }

    #[test]
    fn redundant_contacts_leave_forces_that_their_equations_determine() {
        // A beam on 30 points: height and angle.
        let (points, inertia) = (30, 0.1);
        let arm = |i: usize| i as f64 / 29.0 - 0.5;
        let product = |i: usize, j: usize| 1.0 + arm(i) * arm(j) / inertia;
        let entry = |k: usize| {
            let (i, j) = (k / points, k % points);
            product(i, j) / product(j, j)
        };
        let matrix: Vec<f64> = (0..points * points).map(entry).collect();
        let offsets = vec![-9.81; points];
        let problem = Problem {
            matrix: &matrix,
            offsets: &offsets,
            cones: &[],
            surfaces: offsets.len(),
            in_space: false,
        };
        let solution = solve(&problem, None).expect("solvable");
        let loaded = solution
            .states
            .iter()
            .filter(|state| **state != ContactState::Open);
        assert_eq!(loaded.count(), 2);
        let weights = solution.forces.iter().enumerate();
        let weight: f64 = weights.map(|(i, p)| p / product(i, i)).sum();
        assert!((weight - 9.81).abs() < 1e-12);
    }

    proptest! {
        #![proptest_config(same_in_every_run())]
        /// Redundant contacts included: the motion is one, whichever method.
        #[test]
        fn frictionless_contacts_have_the_motion_of_lemkes_method(
            root in proptest::collection::vec(-1.0..1.0_f64, 97),
            q in proptest::collection::vec(-1.0..1.0_f64, 24),
            rank in 6_usize..30,
        ) {
            let matrix = gram(&root, 24, rank, if rank < 12 { 1e-3 } else { 0.0 });
            // Velocities before an impact are those of a motion.
            let offsets: Vec<f64> = matrix
                .chunks_exact(24)
                .map(|row| row.iter().zip(&q).map(|(a, x)| a * x).sum())
                .collect();
            let problem = Problem { matrix: &matrix, offsets: &offsets, cones: &[], surfaces: offsets.len(), in_space: false };
            let solution = solve(&problem, None);
            prop_assert!(solution.is_some());
            let found = solution.expect("found").forces;
            let size = |i: usize| problem.motion(i, &found).1;
            for i in 0..24 {
                let w = problem.motion(i, &found).0;
                // Forces up to 1e3, of which the sums cancel.
                prop_assert!(found[i] >= 0.0 && w >= -1e-10 * size(i) && found[i].min(w) <= 1e-10 * size(i));
            }
            let mut pivoted = vec![0.0; 24];
            if lcp::solve(&matrix, &offsets, &mut pivoted).is_ok() {
                let motions = |forces: &[f64]| -> Vec<f64> {
                    (0..24).map(|line| problem.motion(line, forces).0).collect()
                };
                let (one, other) = (motions(&found), motions(&pivoted));
                // Its pivots lose digits where contacts are nearly dependent; it says how many itself.
                let lost = other.iter().zip(&pivoted).fold(0.0_f64, |most, (w, p)| most.max(w.min(*p).abs()));
                for (line, (one, other)) in one.iter().zip(&other).enumerate() {
                    // A violation e moves the motion by about sqrt(e), as the energy of the difference is e times the forces.
                    prop_assert!((one - other).abs() < 1e-7 + 30.0 * lost.sqrt(), "{line}: {one} {other}");
                }
            }
        }

        /// Switches of a force of one: with couplings of any signs, without symmetry, Lemke's method ends at a solution.
        #[test]
        fn switches_of_any_couplings_are_solved(
            couplings in proptest::collection::vec(-1.0..1.0_f64, 100),
            q in proptest::collection::vec(-2.0..2.0_f64, 10),
        ) {
            let entry = |(row, column): (usize, usize)| match (row < 10, column < 10) {
                (false, false) => couplings[10 * (row - 10) + column - 10],
                _ => f64::from(u8::from(row == column)),
            };
            let matrix: Vec<f64> = (0..400).map(|k| entry((k / 20, k % 20))).collect();
            let offsets: Vec<f64> = [-1.0; 10].into_iter().chain(q).collect();
            let cone = |normal| Cone { normal, friction: 1.0, kinetic: 1.0, across: None };
            let cones: Vec<Cone> = (0..10).map(cone).collect();
            let problem = Problem { matrix: &matrix, offsets: &offsets, cones: &cones, surfaces: 0, in_space: false };
            let mut f = vec![0.0; 20];
            prop_assert!(solve_polyhedral(&problem, &mut f).is_ok());
            for line in 10..20 {
                let w = problem.motion(line, &f).0;
                // Some twenty pivots, of matrices with a condition up to 1e4.
                prop_assert!(f[line].abs() <= 1.0 + 1e-9 && (f[line] * w + w.abs()).abs() <= 1e-9, "{w} {f:?}");
            }
        }

        /// Coupled contacts with friction, well away from dependence: the solution obeys the law to rounding error.
        #[test]
        fn contacts_with_friction_obey_the_law(
            root in proptest::collection::vec(-1.0..1.0_f64, 101),
            q in proptest::collection::vec(-1.0..1.0_f64, 40),
            mu in proptest::collection::vec(0.0..0.8_f64, 20),
        ) {
            let matrix = gram(&root, 40, 30, 1.0);
            let cones: Vec<Cone> = mu
                .iter()
                .enumerate()
                .map(|(normal, &friction)| Cone { normal, friction, kinetic: friction, across: None })
                .collect();
            let problem = Problem { matrix: &matrix, offsets: &q, cones: &cones, surfaces: 20, in_space: false };
            let solution = solve(&problem, None);
            prop_assert!(solution.is_some());
            let f = solution.expect("found").forces;
            for (i, mu) in mu.iter().enumerate() {
                let (p, s) = (f[i], f[20 + i]);
                let (w_n, w_t) = (problem.motion(i, &f).0, problem.motion(20 + i, &f).0);
                // Forces of the order of 1 to 10, matrices with a condition below 100.
                prop_assert!(p >= -1e-13 && w_n >= -1e-12 && (p * w_n).abs() < 1e-11);
                prop_assert!(s.abs() <= mu * p + 1e-12);
                prop_assert!((s * w_t + mu * p * w_t.abs()).abs() < 1e-11);
            }
        }
    }
}
