//! The order of the ways in which the forces of contacts that touch are sought.
//!
//! What is not coupled is solved apart. Of few contacts all [choices of their states](super::few) are tried, many are solved by changes
//! of states and by Lemke's method ([`many`](super::many)), and contacts in space by Newton's method on their cones ([`space`](super::space)).
//! Finite elements ask for [one solution](first), the event-driven method for [all that are found](all), since it refuses
//! impacts and balances with several motions.

use super::blocks::blocks;
use super::few::{Few, MOST_DECISIONS, Order};
use super::many;
use super::polyhedral::solve_polyhedral;
use super::problem::{Cone, Problem};
use super::space::solve_in_space;
use super::state::ContactState;
use crate::linalg::lcp::{self, LcpError};
use crate::linalg::products::largest;
use crate::yardstick;

/// Most decisions that are tried for one solution before states are changed, and where nothing else has found one: some hundred
/// systems take a millisecond.
const FEW_CHOICES: usize = 10;
const MOST_CHOICES: usize = 14;
/// Most lines without friction that are left to Lemke's method at first.
const FEW_LINES: usize = 14;
/// Most decisions for which trying all is the fastest way to all solutions.
const FEW_DECISIONS: usize = 5;
/// Violation of the law that is rounding error where one solution is sought, relative to the largest force or offset.
const ROUNDING: f64 = 1e-11;
/// Relative violation of the law that is let pass where nothing else is left: contacts that are nearly dependent.
const ILL_CONDITIONED: f64 = 1e-7;
/// Pivot of a matrix with ones on its diagonal above which forces are as well determined as motions: a contact that is left open
/// although it carries [`yardstick::NOTHING`] of the largest force moves by more than what counts as zero.
const DEFINITE: f64 = 1e-2;
/// One solution: the forces of all lines.
///
/// # Errors
/// [`LcpError::Ray`] where none is found, [`LcpError::NotFinite`] for bad data.
pub(crate) fn first(problem: &Problem<'_>) -> Result<Vec<f64>, LcpError> {
    let mut forces = vec![0.0; problem.lines()];
    if problem.lines() <= 1 {
        lcp::solve(problem.matrix, problem.offsets, &mut forces)?;
        return Ok(forces);
    }
    if !problem.is_finite() {
        return Err(LcpError::NotFinite);
    }
    if problem.is_of_space() {
        let found = solve_in_space(problem.matrix, problem.offsets, problem.cones, &mut forces);
        return if found {
            Ok(forces)
        } else {
            Err(LcpError::Ray)
        };
    }
    let parts = Part::of(problem);
    if let [_] = parts[..] {
        return first_of_block(problem);
    }
    for part in parts {
        put(&mut forces, &part.lines, &first_of_block(&part.problem())?);
    }
    Ok(forces)
}

/// One solution of contacts that are coupled.
fn first_of_block(problem: &Problem<'_>) -> Result<Vec<f64>, LcpError> {
    let smooth = problem.cones.is_empty();
    let choices = Few::new(problem, Order::Frictions);
    let decisions = choices.decisions();
    if decisions > if smooth { FEW_LINES } else { FEW_CHOICES } {
        // Where sliding has a lower coefficient of its own, what may rest does.
        let guess = problem.breaks().then(|| held(problem));
        if let Some(solution) = many::solve(problem, guess.as_deref()) {
            return Ok(solution.forces);
        }
    }
    let mut forces = vec![0.0; problem.lines()];
    if smooth {
        lcp::solve(problem.matrix, problem.offsets, &mut forces)?;
        return Ok(forces);
    }
    let mut least: Option<(Vec<f64>, f64)> = None;
    if decisions <= MOST_CHOICES {
        for (trial, violation) in choices.attempts() {
            let scale = largest(problem.offsets).max(largest(&trial)) + f64::MIN_POSITIVE;
            let violation = violation / scale;
            if violation <= ROUNDING {
                return Ok(trial);
            }
            if least.as_ref().is_none_or(|known| violation < known.1) {
                least = Some((trial, violation));
            }
        }
    }
    let least = least.filter(|known| known.1 <= ILL_CONDITIONED);
    if problem.breaks() {
        return least.map_or(Err(LcpError::Ray), |known| Ok(known.0));
    }
    match (solve_polyhedral(problem, &mut forces), least) {
        (Ok(()), _) => Ok(forces),
        (Err(_), Some((forces, _))) => Ok(forces),
        (Err(error), None) => Err(error),
    }
}

/// The solutions of a problem, block by block: the first is what counts, the others are what it is compared with.
pub(crate) struct Solutions {
    lines: usize,
    /// The lines of each block, and its forces.
    blocks: Vec<(Vec<usize>, Vec<Vec<f64>>)>,
}

impl Solutions {
    /// The solution that counts.
    pub(crate) fn first(&self) -> Vec<f64> {
        let mut whole = vec![0.0; self.lines];
        for (lines, solutions) in &self.blocks {
            if let Some(first) = solutions.first() {
                put(&mut whole, lines, first);
            }
        }
        whole
    }

    /// The others, each different from the `first` in one block.
    pub(crate) fn others<'s>(&'s self, first: &'s [f64]) -> impl Iterator<Item = Vec<f64>> + 's {
        self.blocks.iter().flat_map(move |(lines, solutions)| {
            solutions.iter().skip(1).map(move |other| {
                let mut whole = first.to_vec();
                put(&mut whole, lines, other);
                whole
            })
        })
    }
}

fn put(whole: &mut [f64], lines: &[usize], part: &[f64]) {
    for (&line, &force) in lines.iter().zip(part) {
        whole[line] = force;
    }
}

/// All solutions of few contacts, of others one and those that are found from other states; `None` if there is none. `inertia` are
/// the contacts' `1 / D`. In space one is found.
pub(crate) fn all(problem: &Problem<'_>, inertia: &[f64]) -> Option<Solutions> {
    let lines = problem.lines();
    if problem.is_of_space() {
        let mut forces = vec![0.0; lines];
        let found = solve_in_space(problem.matrix, problem.offsets, problem.cones, &mut forces);
        let blocks = vec![((0..lines).collect(), vec![forces])];
        return found.then_some(Solutions { lines, blocks });
    }
    let zero = yardstick::ROUNDING * problem.largest_offset();
    let blocks = Part::of(problem).into_iter().map(|part| {
        let normals = part.problem().normals();
        let inertia: Vec<f64> = part.lines[..normals].iter().map(|&i| inertia[i]).collect();
        let solutions = all_of_block(&part.problem(), zero, &inertia);
        (!solutions.is_empty()).then_some((part.lines, solutions))
    });
    Some(Solutions {
        lines,
        blocks: blocks.collect::<Option<_>>()?,
    })
}

/// The solutions of one block.
fn all_of_block(problem: &Problem<'_>, zero: f64, inertia: &[f64]) -> Vec<Vec<f64>> {
    let choices = Few::new(problem, Order::Contacts);
    let decisions = choices.decisions();
    let few = decisions <= MOST_DECISIONS;
    let consistent = |(forces, violation): (Vec<f64>, f64)| (violation <= zero).then_some(forces);
    let weakest = (decisions > FEW_DECISIONS)
        .then(|| monotone(problem, inertia))
        .flatten();
    let single = weakest.is_some();
    if few && !single {
        return choices.attempts().filter_map(consistent).collect();
    }
    let mut found = Vec::new();
    for guess in guesses(problem, !single) {
        found.extend(many::solve(problem, guess.as_deref()).map(|solution| solution.forces));
    }
    if !few {
        return found;
    }
    // The very numbers of the choices, among what may be chosen.
    let definite = weakest.is_some_and(|weakest| weakest > DEFINITE);
    let known = found.first().map(|found| known(problem, found, definite));
    let first = known.and_then(|known| {
        let choices = Few::new(problem, Order::Contacts).with_known(&known);
        choices.attempts().find_map(consistent)
    });
    match first {
        Some(first) => vec![first],
        None => choices.attempts().filter_map(consistent).collect(),
    }
}

/// Which contacts are closed, or open, in every solution of a problem with a single motion: those that are away from another
/// state. Only where the matrix is `definite` are forces single as well.
fn known(problem: &Problem<'_>, found: &[f64], definite: bool) -> Vec<Option<bool>> {
    // Where all comes to rest, what is left of the motion is rounding.
    let motion = largest(problem.offsets);
    let force = largest(found).max(motion);
    let of = |(line, p): (usize, &f64)| {
        if *p == 0.0 && problem.motion(line, found).0 > yardstick::NOTHING * motion {
            Some(false)
        } else if definite && *p > yardstick::NOTHING * force {
            Some(true)
        } else {
            None
        }
    };
    found.iter().enumerate().map(of).collect()
}

/// The least pivot of the matrix of a problem without friction, symmetric and positive semidefinite, measured in forces and
/// scaled to a diagonal of ones: then all solutions have the same motion. `None` where it is not.
fn monotone(problem: &Problem<'_>, inertia: &[f64]) -> Option<f64> {
    let m = problem.normals();
    if problem.surfaces < m || !problem.cones.is_empty() {
        return None;
    }
    let entry = |i: usize, j: usize| problem.coupling(i, j) / inertia[j];
    let mut a: Vec<f64> = Vec::with_capacity(m * m);
    for i in 0..m {
        for j in 0..m {
            let (one, other) = (entry(i, j), entry(j, i));
            let size = (entry(i, i) * entry(j, j)).abs().sqrt();
            if (one - other).abs() > yardstick::NOTHING * size || one.is_nan() {
                return None;
            }
            a.push(0.5 * (one + other) / size);
        }
    }
    // Cholesky's method with the diagonal lifted by more than rounding error.
    let mut weakest = f64::INFINITY;
    for k in 0..m {
        let pivot = a[k * m + k] + yardstick::NOTHING;
        if pivot <= 0.0 || pivot.is_nan() {
            return None;
        }
        weakest = weakest.min(pivot);
        for i in k + 1..m {
            let factor = a[i * m + k] / pivot;
            if factor == 0.0 {
                continue;
            }
            for j in k + 1..=i {
                a[i * m + j] -= factor * a[j * m + k];
            }
        }
    }
    Some(weakest)
}

/// The states to begin with: those that the offsets suggest, and where solutions may differ, all open and all sticking. What may rest
/// does where sliding has a lower coefficient of its own, and then those come first.
fn guesses(problem: &Problem<'_>, differ: bool) -> Vec<Option<Vec<ContactState>>> {
    let mut guesses = vec![None];
    if differ {
        guesses.push(Some(vec![ContactState::Open; problem.normals()]));
        guesses.push(Some(held(problem)));
    }
    if problem.breaks() {
        guesses.reverse();
    }
    guesses
}

/// All closed, and all that may sticking.
fn held(problem: &Problem<'_>) -> Vec<ContactState> {
    let mut held = vec![ContactState::Frictionless; problem.normals()];
    for cone in problem.cones {
        held[cone.normal] = ContactState::Stick;
    }
    held
}

/// A block of a problem.
struct Part {
    /// Its lines, by their places in the whole problem: normals, then tangents.
    lines: Vec<usize>,
    matrix: Vec<f64>,
    offsets: Vec<f64>,
    cones: Vec<Cone>,
    surfaces: usize,
}

impl Part {
    /// The blocks of a problem.
    fn of(whole: &Problem<'_>) -> Vec<Self> {
        let (normals, tangents) = (whole.normals(), whole.tangents());
        let lines = |i: usize| {
            [Some(i), tangents[i].map(|tangent| tangent.line)]
                .into_iter()
                .flatten()
        };
        let coupled = |i: usize, j: usize| {
            let mut pairs = lines(i).flat_map(|row| lines(j).map(move |column| (row, column)));
            pairs.any(|(row, column)| whole.coupling(row, column) != 0.0)
        };
        let parts = blocks(normals, coupled).into_iter().map(|contacts| {
            let rubbing = contacts.iter().filter_map(|&i| tangents[i]);
            let own: Vec<usize> = contacts
                .iter()
                .copied()
                .chain(rubbing.map(|tangent| tangent.line))
                .collect();
            let entries = own
                .iter()
                .flat_map(|&row| own.iter().map(move |&column| (row, column)));
            let cones = contacts.iter().enumerate().filter_map(|(normal, &i)| {
                let cone = whole.cones[tangents[i]?.line - normals];
                Some(Cone { normal, ..cone })
            });
            Self {
                matrix: entries
                    .map(|(row, column)| whole.coupling(row, column))
                    .collect(),
                offsets: own.iter().map(|&line| whole.offsets[line]).collect(),
                cones: cones.collect(),
                surfaces: contacts.iter().filter(|&&i| i < whole.surfaces).count(),
                lines: own,
            }
        });
        parts.collect()
    }

    fn problem(&self) -> Problem<'_> {
        Problem {
            matrix: &self.matrix,
            offsets: &self.offsets,
            cones: &self.cones,
            surfaces: self.surfaces,
            in_space: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_cases::same_in_every_run;
    use proptest::prelude::*;

    fn cone(normal: usize, friction: f64) -> Cone {
        Cone {
            normal,
            friction,
            kinetic: friction,
            across: None,
        }
    }

    /// Forces of one contact with friction.
    fn one(mu: f64, matrix: [f64; 4], offsets: [f64; 2]) -> Vec<f64> {
        let problem = Problem {
            matrix: &matrix,
            offsets: &offsets,
            cones: &[cone(0, mu)],
            surfaces: 1,
            in_space: false,
        };
        first(&problem).expect("solvable")
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
    fn friction_that_presses_more_than_the_force_lifts_stops_the_sliding() {
        // Slip adds s = 2 p, which presses: (1 - 1.6) p = 1 has no solution p >= 0. Sticking has:
        // det = 0.01, p = (0.65 + 4) / 0.01, s = (5 + 0.8) / 0.01 < 2 p.
        let forces = one(2.0, [1.0, -0.8, -0.8, 0.65], [-1.0, -5.0]);
        // condition number 300
        assert!((forces[0] - 465.0).abs() < 1e-10 && (forces[1] - 580.0).abs() < 1e-10);
    }

    #[test]
    fn contact_that_breaks_loose_among_many_slides_with_its_lower_coefficient() {
        // Contacts without friction press each other: K = 2 on the diagonal, -0.5 beside it, too many for all choices.
        let normals = 20;
        let lines = normals + 1;
        let mut matrix = vec![0.0; lines * lines];
        for i in 0..normals {
            matrix[i * lines + i] = 2.0;
            if i + 1 < normals {
                matrix[i * lines + i + 1] = -0.5;
                matrix[(i + 1) * lines + i] = -0.5;
            }
        }
        matrix[lines * lines - 1] = 1.0;
        let cone = Cone {
            normal: 7,
            friction: 0.5,
            kinetic: 0.2,
            across: None,
        };
        // Where it would slide with 0.3 friction may hold it, where with 0.9 it may not: p is 0.98 or more.
        for (slip, sticks) in [(0.3, true), (0.9, false)] {
            let mut offsets = vec![-1.0; lines];
            offsets[normals] = slip;
            let problem = Problem {
                matrix: &matrix,
                offsets: &offsets,
                cones: &[cone],
                surfaces: normals,
                in_space: false,
            };
            let forces = first(&problem).expect("solvable");
            for i in 0..normals {
                let w = problem.motion(i, &forces).0;
                assert!(forces[i] > 0.0 && w.abs() < 1e-14, "{i}: {w}");
            }
            let wanted = if sticks { -slip } else { -0.2 * forces[7] };
            // One rounding error.
            assert!((forces[normals] - wanted).abs() < 1e-15, "{forces:?}");
        }
    }

    /// `N' N` of a matrix with `rank` rows, some of its columns 0 in all rows but one.
    fn gram(root: &[f64], m: usize, rank: usize) -> Vec<f64> {
        let of = |row: usize, line: usize| match (row + line) % 3 {
            0 => 0.0,
            _ => root[(row * 13 + line * 7) % root.len()],
        };
        let product = |i: usize, j: usize| (0..rank).map(|row| of(row, i) * of(row, j)).sum();
        (0..m * m).map(|k| product(k / m, k % m)).collect()
    }

    proptest! {
        #![proptest_config(same_in_every_run())]
        /// Ties and redundant contacts included: of what cannot be told apart the first choice is taken, to the bit.
        #[test]
        fn motions_of_contacts_without_friction_are_the_first_of_the_choices(
            root in proptest::collection::vec(-1.0..1.0_f64, 61),
            v in proptest::collection::vec(-2..3_i32, 12),
            rank in 4_usize..12,
            m in 6_usize..10,
        ) {
            let matrix = gram(&root, m, rank);
            // What moves at the start is a motion that some contacts do not see.
            let offsets: Vec<f64> = (0..m)
                .map(|i| (0..m).map(|j| matrix[m * i + j] * f64::from(v[j])).sum())
                .collect();
            let problem = Problem { matrix: &matrix, offsets: &offsets, cones: &[], surfaces: m, in_space: false };
            let zero = yardstick::ROUNDING * problem.largest_offset();
            let choices = Few::new(&problem, Order::Contacts);
            let mut attempts = choices.attempts();
            let chosen = attempts.find(|(_, violation)| *violation <= zero).map(|(forces, _)| forces);
            let found = all_of_block(&problem, zero, &vec![1.0; m]);
            prop_assert_eq!(found.first(), chosen.as_ref());
        }

        /// One to four contacts with friction: what does not try all choices finds a motion that trying them finds, and so does
        /// what ends with the first.
        #[test]
        fn motions_are_among_those_of_the_choices(
            root in proptest::collection::vec(-1.0..1.0_f64, 61),
            q in proptest::collection::vec(-1.0..1.0_f64, 8),
            mu in proptest::collection::vec(0.0..1.0_f64, 4),
            m in 1_usize..5,
        ) {
            let product = |i: usize, j: usize| -> f64 {
                let of = |row: usize, line: usize| root[(row * 13 + line * 7) % root.len()];
                let sum: f64 = (0..8).map(|row| of(row, i) * of(row, j)).sum();
                sum + if i == j { 0.5 } else { 0.0 }
            };
            let lines = 2 * m;
            let matrix: Vec<f64> = (0..lines * lines).map(|k| product(k / lines, k % lines)).collect();
            let offsets: Vec<f64> = q[..m].iter().chain(&q[4..4 + m]).copied().collect();
            let cones: Vec<Cone> = mu[..m].iter().enumerate().map(|(i, &mu)| cone(i, mu)).collect();
            let problem = Problem { matrix: &matrix, offsets: &offsets, cones: &cones, surfaces: m, in_space: false };
            let zero = yardstick::ROUNDING * problem.largest_offset();
            let choices = Few::new(&problem, Order::Contacts);
            let attempts = choices.attempts();
            let every: Vec<Vec<f64>> =
                attempts.filter(|(_, violation)| *violation <= zero).map(|(forces, _)| forces).collect();
            let near = |found: &[f64]| every.iter().any(|known| {
                // Forces up to 1e2 from matrices with a condition up to 1e2.
                known.iter().zip(found).all(|(a, b)| (a - b).abs() < 1e-10)
            });
            for guess in guesses(&problem, true) {
                let found = many::solve(&problem, guess.as_deref());
                prop_assert!(found.map_or(every.is_empty(), |found| near(&found.forces)), "{:?}", every);
            }
            let found = first(&problem);
            prop_assert!(found.is_ok_and(|found| near(&found)), "{:?}", every);
            // Lemke's method may end without one, but not with another.
            let mut pivoted = vec![0.0; lines];
            if solve_polyhedral(&problem, &mut pivoted).is_ok() {
                prop_assert!(near(&pivoted), "{:?} {:?}", pivoted, every);
            }
        }
    }
}
