//! The complementarity problem of the closed contacts at one instant: of velocities for an impact, of
//! accelerations for a balance of forces.

use super::coulomb::{CoulombProblem, CoulombSolution, TangentialLaw};
use super::dynamics::{Dynamics, dot, largest};
use super::many_contacts::Blocks;
use super::space_problem::{self, SpaceProblem};
use crate::contact::Line;
use crate::model::contact_point;
use crate::simulation::problem::not_unique;

/// Two solutions are one if their changes of the velocity agree to this relative accuracy.
const SAME: f64 = 1e-8;

/// Closed contacts, as last evaluated, with what their normal and sliding velocities (or accelerations) are
/// without contact forces.
pub(in crate::simulation) struct ContactProblem<'a> {
    /// What is solved for, in words.
    pub(in crate::simulation) what: &'static str,
    /// The closed contacts.
    pub(in crate::simulation) contacts: &'a [usize],
    /// `q_n`, one a contact.
    pub(in crate::simulation) normal: &'a [f64],
    /// `q_t`, one a contact; not read for contacts without friction.
    pub(in crate::simulation) tangential: &'a [f64],
    /// The same along the second sliding velocities of contacts in space.
    pub(in crate::simulation) across: &'a [f64],
    /// Tangential law, one a contact.
    pub(in crate::simulation) laws: &'a [TangentialLaw],
}

impl ContactProblem<'_> {
    /// Solves `w = q + A (p, s)` under the laws of normal contact and Coulomb friction, see [`CoulombProblem`].
    /// Several solutions are accepted if they give the same change of velocity.
    pub(in crate::simulation) fn solve(
        &self,
        dynamics: &Dynamics<'_>,
    ) -> Result<CoulombSolution, String> {
        if self.contacts.iter().any(|&i| dynamics.is_in_space(i)) {
            return self.solve_in_space(dynamics);
        }
        let matrix = self.matrix(dynamics);
        let surfaces = self.contacts.iter().filter(|&&i| !dynamics.is_dry(i));
        let problem = CoulombProblem {
            matrix: &matrix,
            normal: self.normal,
            tangential: self.tangential,
            laws: self.laws,
            surfaces: surfaces.count(),
        };
        let inertia = self.contacts.iter().map(|&i| dynamics.point(i));
        let inertia: Vec<f64> = inertia
            .map(|point| 1.0 / point[contact_point::INVERSE_INERTIA])
            .collect();
        let Some(found) = Blocks::solved(&problem, &inertia) else {
            return Err(self.without_solution(dynamics));
        };
        let solution = found.first(self.contacts.len());
        let reference = self.change(dynamics, &solution);
        let tolerance = SAME
            * largest(&reference)
                .max(largest(self.normal))
                .max(largest(self.tangential));
        // Where sliding has a lower coefficient of its own, what may rest does, and comes first.
        let unique = |law: &TangentialLaw| !matches!(law, TangentialLaw::Breaking { .. });
        if !self.laws.iter().all(unique) {
            return Ok(solution);
        }
        for other in found.others(&solution) {
            let apart = self
                .change(dynamics, &other)
                .iter()
                .zip(&reference)
                .any(|(a, b)| (a - b).abs() > tolerance);
            if apart {
                if let Some(why) = self.pushes_apart(dynamics) {
                    return Err(why);
                }
                return Err(format!(
                    "the {} has several solutions with different velocities: {}",
                    self.what,
                    self.jamming(dynamics).unwrap_or_else(|| {
                        "look at the surfaces that meet here and their impact laws, or start from a slightly \
                         different state"
                            .into()
                    })
                ));
            }
        }
        Ok(solution)
    }

    /// The same where some contacts are in space, by the method for cones.
    fn solve_in_space(&self, dynamics: &Dynamics<'_>) -> Result<CoulombSolution, String> {
        let problem = SpaceProblem {
            contacts: self.contacts,
            normal: self.normal,
            tangential: self.tangential,
            across: self.across,
            laws: self.laws,
        };
        let solution = space_problem::solve(&problem, dynamics);
        solution.ok_or_else(|| self.without_solution(dynamics))
    }

    fn without_solution(&self, dynamics: &Dynamics<'_>) -> String {
        format!(
            "the {} has no solution: {}",
            self.what,
            self.jamming(dynamics).unwrap_or_else(|| {
                "the forces of the contacts that touch push each other into the ground; look at their \
                 surfaces and impact laws"
                    .into()
            })
        )
    }

    /// `A = (n, b)' (d, e)`, row-major; entries of contacts without friction are 0.
    fn matrix(&self, dynamics: &Dynamics<'_>) -> Vec<f64> {
        let m = self.contacts.len();
        let mut matrix = vec![0.0; 4 * m * m];
        for (row, &i) in self.contacts.iter().enumerate() {
            for (column, &j) in self.contacts.iter().enumerate() {
                matrix[2 * m * row + column] = dynamics.coupling(Line::normal(i), Line::normal(j));
                let mut set = |row: usize, column: usize, covector: &[f64], direction: &[f64]| {
                    matrix[2 * m * row + column] = dot(covector, direction);
                };
                if dynamics.has_friction(j) {
                    let e = dynamics.friction_direction(j);
                    set(row, m + column, dynamics.normal(i), e);
                }
                if dynamics.has_friction(i) {
                    let b = dynamics.tangent(i);
                    set(m + row, column, b, dynamics.direction(j));
                    if dynamics.has_friction(j) {
                        set(m + row, m + column, b, dynamics.friction_direction(j));
                    }
                }
            }
        }
        matrix
    }

    /// `sum_i d_i p_i + e_i s_i`.
    pub(in crate::simulation) fn change(
        &self,
        dynamics: &Dynamics<'_>,
        solution: &CoulombSolution,
    ) -> Vec<f64> {
        let mut change = vec![0.0; dynamics.n];
        for (slot, &i) in self.contacts.iter().enumerate() {
            for (change, d) in change.iter_mut().zip(dynamics.direction(i)) {
                *change += d * solution.p[slot];
            }
            if solution.s[slot] == 0.0 && solution.across.is_empty() {
                continue;
            }
            if !dynamics.has_friction(i) {
                continue;
            }
            dynamics.push(Line::tangent(i), solution.s[slot], &mut change);
            if dynamics.is_in_space(i) {
                let (force, _) = solution.across(slot);
                dynamics.push(Line::Across { contact: i }, force, &mut change);
            }
        }
        change
    }

    /// Says which switch pushes away from its zero on both sides, if there is one.
    fn pushes_apart(&self, dynamics: &Dynamics<'_>) -> Option<String> {
        let declared = dynamics.model.declaration().contacts;
        let mut contacts = self.contacts.iter().zip(self.laws);
        contacts.find_map(|(&i, law)| {
            let slides = declared[i].switch.is_some() && law.may_stick();
            let gains = slides && dot(dynamics.tangent(i), dynamics.friction_direction(i)) <= 0.0;
            gains.then(|| not_unique(declared[i].name))
        })
    }

    /// Says which contact friction pushes into the ground, if there is one.
    fn jamming(&self, dynamics: &Dynamics<'_>) -> Option<String> {
        self.contacts.iter().zip(self.laws).find_map(|(&i, &law)| {
            let gain = match law {
                TangentialLaw::None => return None,
                TangentialLaw::Coulomb(mu) | TangentialLaw::Breaking { rest: mu, .. } => {
                    dynamics.gain(i, mu).min(dynamics.gain(i, -mu))
                }
                TangentialLaw::Sliding(mu, direction) => dynamics.gain(i, -direction.sign() * mu),
            };
            (gain <= 0.0).then(|| jammed(dynamics, i, gain))
        })
    }
}

/// Painleve's paradox in words: a contact whose [gain](Dynamics::gain) is zero or less.
pub(in crate::simulation) fn jammed(dynamics: &Dynamics<'_>, contact: usize, gain: f64) -> String {
    format!(
        "friction {} of `{}` pushes it into the ground as much as its force lifts it, 1 - mu |n'e| = {gain:.1e} \
         (Painleve); lower the friction or change the geometry",
        dynamics.friction(contact),
        dynamics.model.declaration().contacts[contact].name,
    )
}
