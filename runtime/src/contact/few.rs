//! Few contacts: all choices of their states, each a linear system.
//!
//! In the plane Coulomb's law is piecewise linear, so that every contact is in one of a few linear states. This finds every
//! solution that is determined, missing ones (Painleve's paradox) and several included, and is the oracle of what does not enumerate.

use super::active_set::{Equations, forces_of};
use super::problem::{Problem, Tangent};
use super::state::ContactState;
use crate::linalg::small_system;

/// Largest number of binary decisions that are tried: `2^12` linear systems take some milliseconds.
pub(super) const MOST_DECISIONS: usize = 12;

/// Which of several solutions comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// Fewest closed contacts first, then fewest sliding ones.
    Contacts,
    /// Those without friction first that others keep from sliding, then those that stick; what may rest does.
    Frictions,
}

/// The choices of a problem.
pub(super) struct Few<'a> {
    problem: &'a Problem<'a>,
    order: Order,
    tangents: Vec<Option<Tangent>>,
    /// The states that each contact may have.
    choices: Vec<Vec<ContactState>>,
}

impl<'a> Few<'a> {
    pub(super) fn new(problem: &'a Problem<'a>, order: Order) -> Self {
        use ContactState::{Frictionless, Held, Open, Stick};
        let tangents = problem.tangents();
        let alone = problem.cones.len() == 1;
        let states = |(i, tangent): (usize, &Option<Tangent>)| {
            let states = match (tangent, order) {
                (None, _) => vec![Open, Frictionless],
                (Some(_), Order::Contacts) => vec![
                    Open,
                    Stick,
                    ContactState::slip(1.0),
                    ContactState::slip(-1.0),
                ],
                (Some(tangent), Order::Frictions) => {
                    // Where it slides by itself is the likelier way.
                    let sense = problem.offsets[tangent.line];
                    let slips = [sense, -sense].map(ContactState::slip);
                    let held = (!alone).then_some(Held(None));
                    [Open]
                        .into_iter()
                        .chain(held)
                        .chain([Stick])
                        .chain(slips)
                        .collect()
                }
            };
            let opens = i < problem.surfaces;
            states
                .into_iter()
                .filter(|state| opens || !state.is_open())
                .collect()
        };
        let choices = tangents.iter().enumerate().map(states).collect();
        Self {
            problem,
            order,
            tangents,
            choices,
        }
    }

    /// Number of binary decisions, rounded up.
    pub(super) fn decisions(&self) -> usize {
        let choices = self.choices.iter().map(|states| states.len() as f64);
        choices.map(f64::log2).sum::<f64>().ceil() as usize
    }

    /// Leaves those contacts only the closed states, or the open one, of which it is `known`.
    pub(super) fn with_known(mut self, known: &[Option<bool>]) -> Self {
        for (states, known) in self.choices.iter_mut().zip(known) {
            states.retain(|state| known.is_none_or(|closed| closed != state.is_open()));
        }
        self
    }

    /// The combinations of states, in their order.
    fn combinations(&self) -> Vec<Vec<ContactState>> {
        let mut combinations = vec![Vec::new()];
        for states in self.choices.iter().rev() {
            // The first contact varies fastest.
            let shorter = std::mem::take(&mut combinations);
            for rest in &shorter {
                for &state in states {
                    let mut longer = Vec::with_capacity(self.choices.len());
                    longer.push(state);
                    longer.extend_from_slice(rest);
                    combinations.push(longer);
                }
            }
        }
        let count = |states: &[ContactState], what: fn(ContactState) -> bool| {
            states.iter().filter(|&&state| what(state)).count()
        };
        combinations.sort_by_cached_key(|states| {
            let closed = count(states, |state| !state.is_open());
            match self.order {
                Order::Contacts => (closed, count(states, ContactState::slips)),
                Order::Frictions => (self.rank(states), closed),
            }
        });
        combinations
    }

    /// Place of the frictions of some states among all of them; contacts that are open need none. Where sliding has a lower coefficient
    /// of its own, what may rest does.
    fn rank(&self, states: &[ContactState]) -> usize {
        let breaks = self.problem.breaks();
        let (mut rank, mut digit, mut slides) = (0, 1, 0);
        for cone in self.problem.cones {
            let choices = &self.choices[cone.normal];
            let state = states[cone.normal];
            let mut closed = choices.iter().filter(|choice| !choice.is_open());
            rank += digit * closed.position(|choice| *choice == state).unwrap_or(0);
            digit *= choices.len();
            slides += usize::from(state.slips());
        }
        rank + if breaks { slides * digit } else { 0 }
    }

    /// The forces of all choices in their order, with what they contradict the law by.
    pub(super) fn attempts(&self) -> impl Iterator<Item = (Vec<f64>, f64)> {
        let combinations = self.combinations().into_iter();
        combinations.filter_map(|states| self.attempt(&states))
    }

    /// The forces of the contacts in `states`, and what they contradict the law by, as a motion; `None` if there are none.
    fn attempt(&self, states: &[ContactState]) -> Option<(Vec<f64>, f64)> {
        let problem = self.problem;
        let Equations {
            unknown,
            mut matrix,
            mut right,
        } = Equations::of(problem, &self.tangents, states);
        small_system::solve(&mut matrix, &mut right)?;
        let mut worst = 0.0_f64;
        for (&line, force) in unknown.iter().zip(&mut right) {
            if line < problem.normals() {
                worst = worst.max(-*force);
                // Not a number stays what it is.
                *force = if *force < 0.0 { 0.0 } else { *force };
            }
        }
        let forces = forces_of(problem, &self.tangents, states, (&unknown, &right));
        let lines = 0..problem.lines();
        let motion: Vec<f64> = lines.map(|line| problem.motion(line, &forces).0).collect();
        // Not a number where one of them is none.
        let mut numbers: f64 = forces.iter().sum();
        for (i, &state) in states.iter().enumerate() {
            let contradicts = match (state, self.tangents[i]) {
                (ContactState::Open, _) => -motion[i],
                (_, None) => 0.0,
                (ContactState::Slip(direction), Some(tangent)) => {
                    -direction.sign() * motion[tangent.line]
                }
                (ContactState::Held(_), Some(tangent)) => motion[tangent.line].abs(),
                (_, Some(tangent)) => forces[tangent.line].abs() - tangent.friction * forces[i],
            };
            numbers += contradicts;
            worst = worst.max(contradicts);
        }
        if numbers.is_nan() {
            return None;
        }
        Some((forces, worst))
    }
}

#[cfg(test)]
mod tests {
    use super::super::problem::Cone;
    use super::*;
    use crate::random_cases::same_in_every_run;
    use proptest::prelude::*;

    /// Forces of all solutions, for contacts the last of which have these coefficients of friction.
    fn every(matrix: &[f64], offsets: &[f64], friction: &[f64]) -> Vec<Vec<f64>> {
        let normals = offsets.len() - friction.len();
        let first = normals - friction.len();
        let cone = |(k, &friction): (usize, &f64)| Cone {
            normal: first + k,
            friction,
            kinetic: friction,
            across: None,
        };
        let cones: Vec<Cone> = friction.iter().enumerate().map(cone).collect();
        let problem = Problem {
            matrix,
            offsets,
            cones: &cones,
            surfaces: normals,
            in_space: false,
        };
        let zero = 1e-12 * problem.largest_offset();
        let choices = Few::new(&problem, Order::Contacts);
        let attempts = choices.attempts();
        attempts
            .filter(|found| found.1 <= zero)
            .map(|found| found.0)
            .collect()
    }

    #[test]
    fn problem_without_solution_gives_none() {
        assert!(every(&[-1.0], &[-1.0], &[]).is_empty());
        assert!(every(&[1.0], &[f64::NAN], &[]).is_empty());
        // As of friction that pushes into the ground, 1 - mu c < 0: Painleve's paradox in both of its forms.
        assert_eq!(every(&[-1.0], &[1.0], &[]).len(), 2);
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
            let found = every(&matrix, &q, &mu);
            prop_assert!(!found.is_empty());
            for f in found {
                // Condition number below 1e2: eigenvalues between 0.1 and 4.1.
                let small = 1e-11;
                let mut power = 0.0;
                let motion = |line: usize| {
                    let row = matrix[4 * line..4 * line + 4].iter().zip(&f);
                    q[line] + row.map(|(a, f)| a * f).sum::<f64>()
                };
                for i in 0..2 {
                    let (p, s, w_n, w_t) = (f[i], f[2 + i], motion(i), motion(2 + i));
                    prop_assert!(p >= 0.0 && w_n >= -small && (p * w_n).abs() <= small);
                    prop_assert!(s.abs() <= mu[i] * p + small);
                    prop_assert!((s * w_t + mu[i] * p * w_t.abs()).abs() <= small);
                    // Work of the impulses: impulse times mean velocity.
                    power += 0.5 * (p * (w_n + q[i]) + s * (w_t + q[2 + i]));
                }
                prop_assert!(power <= small, "{}", power);
            }
        }
    }
}
