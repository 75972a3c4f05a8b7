//! The complementarity problem of closed contacts taken apart into blocks that are not coupled: few contacts are solved by
//! enumeration, many by [`contact_law`].

use super::coulomb::{CoulombProblem, CoulombSolution, MOST_DECISIONS, TangentialLaw};
use crate::contact::{self, Cone, Problem, Solution};
use crate::contact::{ContactState, Direction};

/// Most decisions for which enumeration is the faster way.
const FEW_DECISIONS: usize = 5;
/// Share of the largest force or free motion below which a contact of a single solution is too close to another state.
const STRICT: f64 = 1e-9;
/// Pivot of a matrix with ones on its diagonal above which forces are as well determined as motions: a contact that is left open
/// although it carries [`STRICT`] of the largest force moves by more than what counts as zero.
const DEFINITE: f64 = 1e-2;
/// Share of their size up to which the entries of a symmetric matrix may differ, and a pivot of a semidefinite one be negative.
const SYMMETRIC: f64 = 1e-9;

/// The solutions of a problem, block by block: the first is what counts, the others are what it is compared with.
pub(super) struct Blocks {
    blocks: Vec<Block>,
}

struct Block {
    /// Its contacts, by their places in the whole problem.
    contacts: Vec<usize>,
    solutions: Vec<CoulombSolution>,
}

/// The data of a block.
struct Part {
    matrix: Vec<f64>,
    normal: Vec<f64>,
    tangential: Vec<f64>,
    laws: Vec<TangentialLaw>,
    surfaces: usize,
}

impl Part {
    fn of(whole: &CoulombProblem<'_>, contacts: &[usize]) -> Self {
        let m = whole.laws.len();
        let lines: Vec<usize> = (contacts.iter().copied())
            .chain(contacts.iter().map(|&i| m + i))
            .collect();
        let entries = lines.iter().flat_map(|&row| {
            let columns = lines.iter();
            columns.map(move |&column| whole.matrix[2 * m * row + column])
        });
        let of = |values: &[f64]| contacts.iter().map(|&i| values[i]).collect();
        Self {
            matrix: entries.collect(),
            normal: of(whole.normal),
            tangential: of(whole.tangential),
            laws: contacts.iter().map(|&i| whole.laws[i]).collect(),
            surfaces: contacts.iter().filter(|&&i| i < whole.surfaces).count(),
        }
    }

    fn problem(&self) -> CoulombProblem<'_> {
        CoulombProblem {
            matrix: &self.matrix,
            normal: &self.normal,
            tangential: &self.tangential,
            laws: &self.laws,
            surfaces: self.surfaces,
        }
    }
}

impl Blocks {
    /// Solves a problem; `None` if one of its blocks has no solution. `inertia` are the contacts' `1 / D`.
    pub(super) fn solved(whole: &CoulombProblem<'_>, inertia: &[f64]) -> Option<Self> {
        let m = whole.laws.len();
        let coupled = |i: usize, j: usize| {
            let entry = |row: usize, column: usize| whole.matrix[2 * m * row + column] != 0.0;
            entry(i, j) || entry(i, m + j) || entry(m + i, j) || entry(m + i, m + j)
        };
        let zero = whole.zero();
        let blocks = contact::blocks(m, coupled).into_iter().map(|contacts| {
            let part = Part::of(whole, &contacts);
            let inertia: Vec<f64> = contacts.iter().map(|&i| inertia[i]).collect();
            let solutions = solutions(&part.problem(), zero, &inertia);
            (!solutions.is_empty()).then_some(Block {
                contacts,
                solutions,
            })
        });
        Some(Self {
            blocks: blocks.collect::<Option<_>>()?,
        })
    }

    /// The solution that counts.
    pub(super) fn first(&self, contacts: usize) -> CoulombSolution {
        let mut whole = CoulombSolution {
            states: vec![ContactState::Open; contacts],
            p: vec![0.0; contacts],
            s: vec![0.0; contacts],
            normal: vec![0.0; contacts],
            tangential: vec![0.0; contacts],
            across: Vec::new(),
        };
        for block in &self.blocks {
            if let Some(first) = block.solutions.first() {
                put(&mut whole, &block.contacts, first);
            }
        }
        whole
    }

    /// The others, each different from the first in one block.
    pub(super) fn others<'s>(
        &'s self,
        first: &'s CoulombSolution,
    ) -> impl Iterator<Item = CoulombSolution> + 's {
        self.blocks.iter().flat_map(move |block| {
            block.solutions.iter().skip(1).map(move |other| {
                let mut whole = first.clone();
                put(&mut whole, &block.contacts, other);
                whole
            })
        })
    }
}

fn put(whole: &mut CoulombSolution, contacts: &[usize], part: &CoulombSolution) {
    for (slot, &i) in contacts.iter().enumerate() {
        whole.states[i] = part.states[slot];
        whole.p[i] = part.p[slot];
        whole.s[i] = part.s[slot];
        whole.normal[i] = part.normal[slot];
        whole.tangential[i] = part.tangential[slot];
    }
}

/// The solutions of one block: all if it is small, else one, and those that are found from other states.
fn solutions(problem: &CoulombProblem<'_>, zero: f64, inertia: &[f64]) -> Vec<CoulombSolution> {
    let decisions = problem.decisions();
    let few = decisions <= MOST_DECISIONS;
    if decisions <= FEW_DECISIONS {
        return problem.solutions(zero);
    }
    let weakest = monotone(problem, inertia);
    let single = weakest.is_some();
    if few && !single {
        return problem.solutions(zero);
    }
    let lines = Lines::of(problem);
    let mut found = Vec::new();
    for guess in lines.guesses(!single) {
        let solution = contact::solve(&lines.problem(), guess.as_deref());
        found.extend(solution.map(|solution| lines.told(problem, &solution)));
    }
    if few {
        // The very numbers of the enumeration, among what it can choose.
        let definite = weakest.is_some_and(|weakest| weakest > DEFINITE);
        let known = found.first().map(|found| known(problem, found, definite));
        let first = known.and_then(|known| problem.first_without_friction(zero, &known));
        return first.map_or_else(|| problem.solutions(zero), |first| vec![first]);
    }
    found
}

/// Which contacts are closed, or open, in every solution of a problem with a single motion: those that are away from another
/// state. Only where the matrix is `definite` are forces single as well.
fn known(
    problem: &CoulombProblem<'_>,
    found: &CoulombSolution,
    definite: bool,
) -> Vec<Option<bool>> {
    let largest = |values: &[f64]| {
        values
            .iter()
            .fold(0.0_f64, |most, value| most.max(value.abs()))
    };
    // Where all comes to rest, what is left of the motion is rounding.
    let motion = largest(problem.normal);
    let force = largest(&found.p).max(motion);
    let contacts = found.p.iter().zip(&found.normal);
    let of = |(p, w): (&f64, &f64)| {
        if *w > STRICT * motion {
            Some(false)
        } else if definite && *p > STRICT * force {
            Some(true)
        } else {
            None
        }
    };
    contacts.map(of).collect()
}

/// The least pivot of the matrix of a problem without friction, symmetric and positive semidefinite, measured in forces and
/// scaled to a diagonal of ones: then all solutions have the same motion. `None` where it is not.
fn monotone(problem: &CoulombProblem<'_>, inertia: &[f64]) -> Option<f64> {
    let m = problem.laws.len();
    if problem.surfaces < m || problem.laws.iter().any(|law| *law != TangentialLaw::None) {
        return None;
    }
    let entry = |i: usize, j: usize| problem.matrix[2 * m * i + j] / inertia[j];
    let mut a: Vec<f64> = Vec::with_capacity(m * m);
    for i in 0..m {
        for j in 0..m {
            let (one, other) = (entry(i, j), entry(j, i));
            let size = (entry(i, i) * entry(j, j)).abs().sqrt();
            if (one - other).abs() > SYMMETRIC * size || one.is_nan() {
                return None;
            }
            a.push(0.5 * (one + other) / size);
        }
    }
    // Cholesky's method with the diagonal lifted by more than rounding error.
    let mut weakest = f64::INFINITY;
    for k in 0..m {
        let pivot = a[k * m + k] + SYMMETRIC;
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

/// A problem by lines; what slides in a known direction is part of its normal.
struct Lines {
    matrix: Vec<f64>,
    offsets: Vec<f64>,
    cones: Vec<Cone>,
}

impl Lines {
    fn of(problem: &CoulombProblem<'_>) -> Self {
        let m = problem.laws.len();
        let cones: Vec<Cone> = (0..m)
            .filter_map(|normal| match problem.laws[normal] {
                TangentialLaw::Coulomb(_) | TangentialLaw::Breaking { .. } => {
                    let (friction, kinetic) = problem.laws[normal].coefficients();
                    Some(Cone {
                        normal,
                        friction,
                        kinetic,
                        across: None,
                    })
                }
                TangentialLaw::None | TangentialLaw::Sliding(..) => None,
            })
            .collect();
        let lines: Vec<usize> = (0..m)
            .chain(cones.iter().map(|cone| m + cone.normal))
            .collect();
        let entry = |row: usize, column: usize| problem.matrix[2 * m * row + column];
        let slope = |contact: usize| match problem.laws.get(contact) {
            Some(TangentialLaw::Sliding(mu, direction)) => -direction.sign() * mu,
            _ => 0.0,
        };
        let mut matrix = Vec::with_capacity(lines.len() * lines.len());
        for &row in &lines {
            for &column in &lines {
                matrix.push(match slope(column) {
                    0.0 => entry(row, column),
                    slope => entry(row, column) + slope * entry(row, m + column),
                });
            }
        }
        let offset = |&line: &usize| match line.checked_sub(m) {
            None => problem.normal[line],
            Some(contact) => problem.tangential[contact],
        };
        Self {
            matrix,
            offsets: lines.iter().map(offset).collect(),
            cones,
        }
    }

    fn problem(&self) -> Problem<'_> {
        Problem {
            matrix: &self.matrix,
            offsets: &self.offsets,
            cones: &self.cones,
        }
    }

    /// The states to begin with: those that the offsets suggest, and where solutions may differ, all open and all sticking.
    fn guesses(&self, differ: bool) -> Vec<Option<Vec<ContactState>>> {
        let mut guesses = vec![None];
        if differ {
            let normals = self.offsets.len() - self.cones.len();
            let mut held = vec![ContactState::Frictionless; normals];
            for cone in &self.cones {
                held[cone.normal] = ContactState::Stick;
            }
            guesses.push(Some(vec![ContactState::Open; normals]));
            guesses.push(Some(held));
        }
        guesses
    }

    /// A solution in the words of the enumeration.
    fn told(&self, problem: &CoulombProblem<'_>, solution: &Solution) -> CoulombSolution {
        let m = problem.laws.len();
        let mut s = vec![0.0; m];
        for (cone, force) in self.cones.iter().zip(&solution.forces[m..]) {
            s[cone.normal] = *force;
        }
        let p: Vec<f64> = solution.forces[..m].iter().map(|p| p.max(0.0)).collect();
        for i in 0..m {
            if let TangentialLaw::Sliding(mu, direction) = problem.laws[i] {
                s[i] = -direction.sign() * mu * p[i];
            }
        }
        let motion = |row: usize, offset: f64| offset + problem.product(row, &p, &s);
        let tangential: Vec<f64> = (0..m)
            .map(|i| match (problem.laws[i], solution.states[i]) {
                (TangentialLaw::None, _) | (_, ContactState::Stick) => 0.0,
                _ => motion(m + i, problem.tangential[i]),
            })
            .collect();
        let told = |i: usize| match (solution.states[i], problem.laws[i]) {
            (ContactState::Open, _) if i < problem.surfaces => ContactState::Open,
            (ContactState::Stick, _) => ContactState::Stick,
            (ContactState::Slip(sense), _) => ContactState::Slip(sense),
            (_, TangentialLaw::None) => ContactState::Frictionless,
            (_, TangentialLaw::Sliding(_, direction)) => ContactState::Slip(direction),
            (_, _) => ContactState::Slip(Direction::of(tangential[i])),
        };
        let states: Vec<ContactState> = (0..m).map(told).collect();
        let normal = (0..m).map(|i| match states[i] {
            ContactState::Open => motion(i, problem.normal[i]),
            _ => 0.0,
        });
        CoulombSolution {
            normal: normal.collect(),
            across: Vec::new(),
            states,
            p,
            s,
            tangential,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_cases::same_in_every_run;
    use proptest::prelude::*;

    /// Contacts without friction whose matrix is `N' N` of a matrix with `rank` rows, some of its columns 0 in all rows but one.
    fn frictionless(root: &[f64], m: usize, rank: usize) -> Vec<f64> {
        let of = |row: usize, line: usize| match (row + line) % 3 {
            0 => 0.0,
            _ => root[(row * 13 + line * 7) % root.len()],
        };
        let mut matrix = vec![0.0; 4 * m * m];
        for i in 0..m {
            for j in 0..m {
                matrix[2 * m * i + j] = (0..rank).map(|row| of(row, i) * of(row, j)).sum();
            }
        }
        matrix
    }

    proptest! {
        #![proptest_config(same_in_every_run())]
        /// Ties and redundant contacts included: of what cannot be told apart the enumeration's first choice is taken, to the bit.
        #[test]
        fn motions_of_contacts_without_friction_are_the_first_of_the_enumeration(
            root in proptest::collection::vec(-1.0..1.0_f64, 61),
            v in proptest::collection::vec(-2..3_i32, 12),
            rank in 4_usize..12,
            m in 6_usize..10,
        ) {
            let matrix = frictionless(&root, m, rank);
            // What moves at the start is a motion that some contacts do not see.
            let normal: Vec<f64> = (0..m)
                .map(|i| (0..m).map(|j| matrix[2 * m * i + j] * f64::from(v[j])).sum())
                .collect();
            let problem = CoulombProblem {
                matrix: &matrix,
                normal: &normal,
                tangential: &vec![0.0; m],
                laws: &vec![TangentialLaw::None; m],
                surfaces: m,
            };
            let zero = problem.zero();
            let all = problem.solutions(zero);
            let found = solutions(&problem, zero, &vec![1.0; m]);
            prop_assert_eq!(found.first(), all.first());
        }

        /// Up to five contacts with friction, and as many without: what does not enumerate finds a motion that enumeration finds.
        #[test]
        fn motions_are_among_those_of_the_enumeration(
            root in proptest::collection::vec(-1.0..1.0_f64, 61),
            q in proptest::collection::vec(-1.0..1.0_f64, 10),
            mu in proptest::collection::vec(0.0..1.0_f64, 5),
            m in 1_usize..6,
        ) {
            let product = |i: usize, j: usize| -> f64 {
                let of = |row: usize, line: usize| root[(row * 13 + line * 7) % root.len()];
                let sum: f64 = (0..8).map(|row| of(row, i) * of(row, j)).sum();
                sum + if i == j { 0.5 } else { 0.0 }
            };
            let lines = 2 * m;
            let matrix: Vec<f64> = (0..lines * lines).map(|k| product(k / lines, k % lines)).collect();
            let laws: Vec<TangentialLaw> = mu[..m].iter().map(|&mu| TangentialLaw::Coulomb(mu)).collect();
            let problem = CoulombProblem {
                matrix: &matrix,
                normal: &q[..m],
                tangential: &q[5..5 + m],
                laws: &laws,
                surfaces: m,
            };
            let all = problem.solutions(problem.zero());
            let lines = Lines::of(&problem);
            for guess in lines.guesses(true) {
                let Some(solution) = contact::solve(&lines.problem(), guess.as_deref()) else {
                    prop_assert!(all.is_empty());
                    continue;
                };
                let told = lines.told(&problem, &solution);
                let near = all.iter().any(|known| {
                    let pairs = (known.p.iter().zip(&told.p)).chain(known.s.iter().zip(&told.s));
                    // Forces up to 1e2 from matrices with a condition up to 1e2.
                    pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-10)
                });
                prop_assert!(near, "{:?} {:?}", told, all);
            }
        }
    }
}
