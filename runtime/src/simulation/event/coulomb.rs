//! Complementarity problems of contacts with Coulomb friction in the plane, solved exactly by enumeration:
//!
//! ```text
//! w_n = q_n + A_nn p + A_nt s,   w_t = q_t + A_tn p + A_tt s
//! 0 <= p _|_ w_n >= 0,   |s| <= mu p,   s w_t = -mu p |w_t|
//! ```
//!
//! In the plane Coulomb's law is piecewise linear, so that every contact is in one of four linear states.
//! Without friction this is the linear complementarity problem `0 <= p _|_ q_n + A_nn p >= 0`. It is the way of few
//! contacts, of which it finds every solution; many are solved by [`contact_law`](crate::contact).

use super::small_system;
use crate::contact::{ContactState, Direction};

/// Largest number of binary decisions that are tried: `2^12` linear systems take some milliseconds.
pub(in crate::simulation) const MOST_DECISIONS: usize = 12;

/// Components below this times the largest of `q` count as zero: the systems are solved to some `1e-15`.
const ZERO: f64 = 1e-12;

/// Tangential law of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::simulation) enum TangentialLaw {
    /// No friction: `s = 0`.
    None,
    /// Coulomb friction with the coefficient `mu`.
    Coulomb(f64),
    /// The same where sliding has a lower coefficient of its own: `s = -mu_k p sign(w_t)`. What may rest does.
    Breaking {
        /// At rest.
        rest: f64,
        /// Of sliding, `mu_k`.
        sliding: f64,
    },
    /// The tangential force of sliding in a known direction, `s = -mu p` or `+mu p`, whatever `w_t`.
    Sliding(f64, Direction),
}

impl TangentialLaw {
    fn states(self) -> &'static [ContactState] {
        use ContactState::{Frictionless, Open, Slip, Stick};
        use Direction::{Backward, Forward};
        match self {
            Self::None => &[Open, Frictionless],
            Self::Coulomb(_) | Self::Breaking { .. } => {
                &[Open, Stick, Slip(Forward), Slip(Backward)]
            }
            Self::Sliding(_, Forward) => &[Open, Slip(Forward)],
            Self::Sliding(_, Backward) => &[Open, Slip(Backward)],
        }
    }

    /// That of a contact which may stick.
    pub(in crate::simulation) fn of_rest(rest: f64, sliding: f64) -> Self {
        if sliding < rest {
            Self::Breaking { rest, sliding }
        } else {
            Self::Coulomb(rest)
        }
    }

    /// Whether the contact may stick.
    pub(in crate::simulation) fn may_stick(self) -> bool {
        matches!(self, Self::Coulomb(_) | Self::Breaking { .. })
    }

    /// The coefficients of rest and of sliding.
    pub(in crate::simulation) fn coefficients(self) -> (f64, f64) {
        match self {
            Self::None => (0.0, 0.0),
            Self::Coulomb(mu) | Self::Sliding(mu, _) => (mu, mu),
            Self::Breaking { rest, sliding } => (rest, sliding),
        }
    }
}

/// A problem of `m = laws.len()` contacts.
#[derive(Debug, Clone)]
pub(in crate::simulation) struct CoulombProblem<'a> {
    /// `A`, row-major of order `2 m`: normal rows and columns first; entries of contacts without friction are 0.
    pub(in crate::simulation) matrix: &'a [f64],
    /// `q_n`.
    pub(in crate::simulation) normal: &'a [f64],
    /// `q_t`; entries of contacts without friction are not read.
    pub(in crate::simulation) tangential: &'a [f64],
    /// Tangential law of each contact.
    pub(in crate::simulation) laws: &'a [TangentialLaw],
    /// Number of contacts that may open; the others, behind them, are dry friction.
    pub(in crate::simulation) surfaces: usize,
}

/// A solution of the problem.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::simulation) struct CoulombSolution {
    /// State of each contact.
    pub(in crate::simulation) states: Vec<ContactState>,
    /// `p`, not negative.
    pub(in crate::simulation) p: Vec<f64>,
    /// `s`.
    pub(in crate::simulation) s: Vec<f64>,
    /// `w_n`, not negative up to rounding, zero where a contact is closed.
    pub(in crate::simulation) normal: Vec<f64>,
    /// `w_t`, zero where a contact sticks; 0 for contacts without friction.
    pub(in crate::simulation) tangential: Vec<f64>,
    /// In space `s` and `w_t` along the second sliding velocity; empty without contacts in space.
    pub(in crate::simulation) across: Vec<(f64, f64)>,
}

impl CoulombSolution {
    /// `s` along the second sliding velocity, and that; 0 in the plane.
    pub(in crate::simulation) fn across(&self, contact: usize) -> (f64, f64) {
        self.across.get(contact).copied().unwrap_or_default()
    }
}

impl CoulombProblem<'_> {
    /// Number of binary decisions, rounded up; at most [`MOST_DECISIONS`] are tried.
    pub(in crate::simulation) fn decisions(&self) -> usize {
        let choices = (0..self.laws.len()).map(|contact| self.states(contact).count() as f64);
        choices.map(f64::log2).sum::<f64>().ceil() as usize
    }

    /// The states that a contact may have.
    fn states(&self, contact: usize) -> impl Iterator<Item = ContactState> + use<> {
        let opens = contact < self.surfaces;
        let states = self.laws[contact].states().iter().copied();
        states.filter(move |state| opens || !state.is_open())
    }

    /// What counts as zero.
    pub(in crate::simulation) fn zero(&self) -> f64 {
        let sizes = self.normal.iter().chain(self.tangential);
        ZERO * sizes.fold(0.0_f64, |s, q| s.max(q.abs()))
    }

    /// All basic solutions: fewest closed contacts first, then fewest sliding ones. Empty if there is none.
    /// Below `zero` a component counts as such.
    pub(in crate::simulation) fn solutions(&self, zero: f64) -> Vec<CoulombSolution> {
        let mut combinations = vec![Vec::new()];
        for contact in (0..self.laws.len()).rev() {
            // The first contact varies fastest.
            let shorter = std::mem::take(&mut combinations);
            for rest in &shorter {
                for state in self.states(contact) {
                    let mut longer = vec![state];
                    longer.extend_from_slice(rest);
                    combinations.push(longer);
                }
            }
        }
        let count = |states: &[ContactState], what: fn(&ContactState) -> bool| {
            states.iter().filter(|state| what(state)).count()
        };
        combinations.sort_by_cached_key(|states| {
            (
                count(states, |state| !state.is_open()),
                count(states, |state| matches!(state, ContactState::Slip(_))),
            )
        });
        combinations
            .into_iter()
            .filter_map(|states| self.basic(states, zero))
            .collect()
    }

    /// The first of the basic solutions of contacts without friction, in the order of [`solutions`](Self::solutions), in which those
    /// that are `known` to be closed, or open, are.
    pub(super) fn first_without_friction(
        &self,
        zero: f64,
        known: &[Option<bool>],
    ) -> Option<CoulombSolution> {
        let m = self.laws.len();
        let fits = |closed: &u32| {
            let mut states = known.iter().enumerate();
            states.all(|(i, known)| known.is_none_or(|known| known == ((closed >> i) & 1 == 1)))
        };
        let mut chosen: Vec<u32> = (0..1 << m).filter(fits).collect();
        chosen.sort_by_key(|closed| closed.count_ones());
        chosen.into_iter().find_map(|closed| {
            let state = |i: usize| match (closed >> i) & 1 {
                0 => ContactState::Open,
                _ => ContactState::Frictionless,
            };
            self.basic((0..m).map(state).collect(), zero)
        })
    }

    /// `row' (p, s)` of the matrix.
    pub(super) fn product(&self, row: usize, p: &[f64], s: &[f64]) -> f64 {
        let m = self.laws.len();
        self.matrix[2 * m * row..2 * m * (row + 1)]
            .iter()
            .zip(p.iter().chain(s))
            .map(|(a, x)| a * x)
            .sum()
    }

    /// `w_n` and `w_t` with these forces, if they obey the laws of the states.
    fn motions(
        &self,
        states: &[ContactState],
        p: &[f64],
        s: &[f64],
        zero: f64,
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let m = self.laws.len();
        let (mut normal, mut tangential) = (vec![0.0; m], vec![0.0; m]);
        for i in 0..m {
            if states[i].is_open() {
                normal[i] = self.normal[i] + self.product(i, p, s);
                if normal[i] < -zero || normal[i].is_nan() {
                    return None;
                }
            }
            if self.laws[i] == TangentialLaw::None || states[i] == ContactState::Stick {
                continue;
            }
            tangential[i] = self.tangential[i] + self.product(m + i, p, s);
            if tangential[i].is_nan() {
                return None;
            }
            if let (true, ContactState::Slip(direction)) = (self.laws[i].may_stick(), states[i])
                && direction.sign() * tangential[i] < -zero
            {
                return None;
            }
        }
        Some((normal, tangential))
    }

    /// The solution with the contacts in `states`, if there is one.
    pub(in crate::simulation) fn basic(
        &self,
        states: Vec<ContactState>,
        zero: f64,
    ) -> Option<CoulombSolution> {
        let m = self.laws.len();
        let coefficient = |i: usize| self.laws[i].coefficients();
        let chosen = |what: fn(&ContactState) -> bool| {
            (0..m).filter(|&i| what(&states[i])).collect::<Vec<usize>>()
        };
        let closed = chosen(|state| !state.is_open());
        let stuck = chosen(|&state| state == ContactState::Stick);
        // Unknowns: p of closed contacts, s of sticking ones; a sliding contact's s is a multiple of p.
        let rows: Vec<usize> = closed
            .iter()
            .copied()
            .chain(stuck.iter().map(|&i| m + i))
            .collect();
        let entry = |row: usize, column: usize| self.matrix[2 * m * row + column];
        let mut square: Vec<f64> = rows
            .iter()
            .flat_map(|&row| {
                let (states, closed, stuck) = (&states, &closed, &stuck);
                closed
                    .iter()
                    .map(move |&j| {
                        let ratio = states[j].force_ratio(coefficient(j));
                        if ratio == 0.0 {
                            entry(row, j)
                        } else {
                            entry(row, j) + ratio * entry(row, m + j)
                        }
                    })
                    .chain(stuck.iter().map(move |&j| entry(row, m + j)))
            })
            .collect();
        let mut right: Vec<f64> = closed
            .iter()
            .map(|&i| -self.normal[i])
            .chain(stuck.iter().map(|&i| -self.tangential[i]))
            .collect();
        small_system::solve(&mut square, &mut right)?;
        let (mut p, mut s) = (vec![0.0; m], vec![0.0; m]);
        for (&i, &value) in closed.iter().zip(&right) {
            if value < -zero || value.is_nan() {
                return None;
            }
            p[i] = value.max(0.0);
            s[i] = states[i].force_ratio(coefficient(i)) * p[i];
        }
        for (&i, &value) in stuck.iter().zip(&right[closed.len()..]) {
            if value.abs() > coefficient(i).0 * p[i] + zero || value.is_nan() {
                return None;
            }
            s[i] = value;
        }
        let (normal, tangential) = self.motions(&states, &p, &s, zero)?;
        Some(CoulombSolution {
            states,
            p,
            s,
            normal,
            tangential,
            across: Vec::new(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_cases::same_in_every_run;
    use proptest::prelude::*;

    fn every(problem: &CoulombProblem<'_>) -> Vec<CoulombSolution> {
        problem.solutions(problem.zero())
    }

    /// The problem without friction.
    fn frictionless(matrix: &[f64], q: &[f64]) -> Vec<CoulombSolution> {
        let m = q.len();
        let mut square = vec![0.0; 4 * m * m];
        for i in 0..m {
            square[2 * m * i..2 * m * i + m].copy_from_slice(&matrix[m * i..m * (i + 1)]);
        }
        every(&CoulombProblem {
            matrix: &square,
            normal: q,
            tangential: &vec![0.0; m],
            laws: &vec![TangentialLaw::None; m],
            surfaces: m,
        })
    }

    /// One contact with friction.
    fn one(matrix: [f64; 4], q: [f64; 2], law: TangentialLaw) -> Vec<CoulombSolution> {
        every(&CoulombProblem {
            matrix: &matrix,
            normal: &q[..1],
            tangential: &q[1..],
            laws: &[law],
            surfaces: 1,
        })
    }

    #[test]
    fn coupled_contacts_of_both_signs_take_the_impulses_of_the_law() {
        // D_12 < 0: the second needs more impulse because the first pushes it in.
        let found = frictionless(&[1.0, -0.5, -0.5, 1.0], &[-1.0, -1.0]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].p, [2.0, 2.0]);
        // D_12 > 0 and unequal speeds: the stronger impact lifts the other contact.
        let found = frictionless(&[1.0, 0.5, 0.5, 1.0], &[-1.0, -0.25]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].p, [1.0, 0.0]);
        assert_eq!(found[0].normal, [0.0, 0.25]);
    }

    #[test]
    fn dependent_normals_give_the_same_velocities_in_every_solution() {
        let found = frictionless(&[1.0, 1.0, 1.0, 1.0], &[-1.0, -1.0]);
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|solution| solution.normal == [0.0, 0.0]));
    }

    #[test]
    fn problem_without_solution_gives_none() {
        assert!(frictionless(&[-1.0], &[-1.0]).is_empty());
        assert!(frictionless(&[1.0], &[f64::NAN]).is_empty());
        assert_eq!(frictionless(&[-1.0], &[1.0]).len(), 2);
    }

    #[test]
    fn no_contact_gives_the_empty_solution() {
        assert_eq!(frictionless(&[], &[]).len(), 1);
    }

    #[test]
    fn contact_sticks_inside_the_cone_and_slips_outside() {
        let identity = [1.0, 0.0, 0.0, 1.0];
        let found = one(identity, [-2.0, 0.5], TangentialLaw::Coulomb(0.5));
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].states, [ContactState::Stick]);
        assert_eq!((found[0].p[0], found[0].s[0]), (2.0, -0.5));
        let found = one(identity, [-2.0, -3.0], TangentialLaw::Coulomb(0.5));
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].states, [ContactState::Slip(Direction::Backward)]);
        assert_eq!((found[0].s[0], found[0].tangential[0]), (1.0, -2.0));
    }

    #[test]
    fn known_sliding_direction_may_be_braked_beyond_zero() {
        // A rate of the sliding velocity, not the velocity: it may have either sign.
        let law = TangentialLaw::Sliding(0.5, Direction::Forward);
        let found = one([1.0, 0.0, 0.0, 1.0], [-2.0, 0.25], law);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].s[0], found[0].tangential[0]), (-1.0, -0.75));
    }

    #[test]
    fn friction_that_pushes_into_the_ground_gives_no_or_two_solutions() {
        // 1 - mu c < 0 with c = 2, mu = 0.75: Painleve's paradox in both of its forms.
        let matrix = [1.0, 2.0, 2.0, 5.0];
        let law = TangentialLaw::Sliding(0.75, Direction::Forward);
        assert!(one(matrix, [-1.0, 0.0], law).is_empty());
        assert_eq!(one(matrix, [1.0, 0.0], law).len(), 2);
    }

    proptest! {
        #![proptest_config(same_in_every_run())]
        /// Positive definite matrices: the problem of an impact always has a solution, and every one found
        /// obeys the laws and takes energy.
        #[test]
        fn impacts_of_two_contacts_are_solved_and_take_energy(
            root in proptest::collection::vec(-1.0..1.0_f64, 16),
            q in proptest::collection::vec(-1.0..1.0_f64, 4),
            mu in proptest::collection::vec(0.0..2.0_f64, 2),
        ) {
            let mut matrix = vec![0.0; 16];
            for i in 0..4 {
                for j in 0..4 {
                    matrix[4 * i + j] = (0..4).map(|k| root[4 * k + i] * root[4 * k + j]).sum::<f64>()
                        + if i == j { 0.1 } else { 0.0 };
                }
            }
            let laws = [TangentialLaw::Coulomb(mu[0]), TangentialLaw::Coulomb(mu[1])];
            let problem = CoulombProblem {
                matrix: &matrix,
                normal: &q[..2],
                tangential: &q[2..],
                laws: &laws,
                surfaces: 2,
            };
            let found = every(&problem);
            prop_assert!(!found.is_empty());
            for solution in found {
                let (p, s) = (&solution.p, &solution.s);
                // Condition number below 1e2: eigenvalues between 0.1 and 4.1.
                let small = 1e-11;
                let mut power = 0.0;
                for i in 0..2 {
                    let w_n = q[i] + problem.product(i, p, s);
                    let w_t = q[2 + i] + problem.product(2 + i, p, s);
                    prop_assert!(p[i] >= 0.0 && w_n >= -small && (p[i] * w_n).abs() <= small);
                    prop_assert!(s[i].abs() <= mu[i] * p[i] + small);
                    prop_assert!((s[i] * w_t + mu[i] * p[i] * w_t.abs()).abs() <= small);
                    // Work of the impulses: impulse times mean velocity.
                    power += 0.5 * (p[i] * (w_n + q[i]) + s[i] * (w_t + q[2 + i]));
                }
                prop_assert!(power <= small, "{}", power);
            }
        }
    }
}
