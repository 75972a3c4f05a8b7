//! The complementarity problem of the closed contacts at one instant: of velocities for an impact, of
//! accelerations for a balance of forces.

use crate::contact::touching::jammed;
use crate::contact::{Balance, Touching, View};
use crate::simulation::sentences::not_unique;

/// Closed contacts, as last evaluated, with what their lines do without contact forces.
pub(in crate::simulation) struct ContactProblem {
    /// What is solved for, in words.
    pub(in crate::simulation) what: &'static str,
    /// The closed contacts, of which some may stick.
    pub(in crate::simulation) touching: Touching,
    /// Velocities or accelerations of the lines without contact forces.
    pub(in crate::simulation) offsets: Vec<f64>,
}

impl ContactProblem {
    /// Solves `w = q + K f` under the laws of normal contact and Coulomb friction.
    /// Several solutions are accepted if they give the same change of velocity.
    pub(in crate::simulation) fn solve(self, view: &View<'_>) -> Result<Balance, String> {
        let Self {
            what,
            touching,
            offsets,
        } = self;
        // Where sliding has a lower coefficient of its own, what may rest does, and comes first.
        let breaks = touching.breaks();
        let jamming = touching.jams(view);
        let jamming = jamming.map(|(contact, gain)| jammed(view, contact, gain));
        let Some((balance, solutions)) = Balance::all(touching, view, &offsets) else {
            return Err(format!(
                "the {what} has no solution: {}",
                jamming.unwrap_or_else(|| {
                    "the forces of the contacts that touch push each other into the ground; look at their \
                     surfaces and impact laws"
                        .into()
                })
            ));
        };
        if !breaks && balance.has_others(view, &offsets, &solutions) {
            let parts = balance.touching.parting(view);
            let parts = parts.map(|i| not_unique(view.model.declaration().contacts[i].name));
            return Err(parts.unwrap_or_else(|| {
                format!(
                    "the {what} has several solutions with different velocities: {}",
                    jamming.unwrap_or_else(|| {
                        "look at the surfaces that meet here and their impact laws, or start from a slightly \
                         different state"
                            .into()
                    })
                )
            }));
        }
        Ok(balance)
    }
}
