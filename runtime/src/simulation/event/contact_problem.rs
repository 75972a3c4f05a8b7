//! The complementarity problem of the closed contacts at one instant: of velocities for an impact, of
//! accelerations for a balance of forces.

use crate::contact::touching::jammed;
use crate::contact::{Balance, Touching, View, dot};
use crate::simulation::problem::not_unique;

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
            return Err(pushes_apart(&balance.touching, view).unwrap_or_else(|| {
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

/// Says which switch pushes away from its zero on both sides, if there is one.
fn pushes_apart(touching: &Touching, view: &View<'_>) -> Option<String> {
    let mut contacts = touching.contacts.iter().enumerate();
    contacts.find_map(|(slot, &i)| {
        let slides = view.switch_of(i).is_some() && touching.tangent(slot).is_some();
        let gains = slides && dot(view.tangent(i), view.friction_direction(i)) <= 0.0;
        gains.then(|| not_unique(view.model.declaration().contacts[i].name))
    })
}
