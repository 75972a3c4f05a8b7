//! The complementarity problem of the closed contacts at one instant: of velocities for an impact, of
//! accelerations for a balance of forces.

use super::dynamics::largest;
use crate::contact::{Balance, Line, Touching, View, dot};
use crate::simulation::problem::not_unique;

/// Two solutions are one if their changes of the velocity agree to this relative accuracy.
const SAME: f64 = 1e-8;

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
        let jamming = jamming(&touching, view);
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
        let change = |forces: &[f64]| {
            let mut change = vec![0.0; view.n];
            balance.push(view, forces, &mut change);
            change
        };
        let reference = change(&balance.forces);
        let tolerance = SAME * largest(&reference).max(largest(&offsets));
        let differs = |other: Vec<f64>| {
            let other = change(&other);
            let mut pairs = other.iter().zip(&reference);
            pairs.any(|(a, b)| (a - b).abs() > tolerance)
        };
        if !breaks && solutions.others(&balance.forces).any(differs) {
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

/// Says which contact friction pushes into the ground, if there is one.
fn jamming(touching: &Touching, view: &View<'_>) -> Option<String> {
    let mut contacts = touching.contacts.iter().zip(&touching.lines).enumerate();
    contacts.find_map(|(slot, (&i, &line))| {
        let mu = view.friction(i);
        let gain = match (touching.tangent(slot), line) {
            (Some(_), _) => view.gain(i, mu).min(view.gain(i, -mu)),
            (None, Line::Normal { slope, .. }) if slope != 0.0 => view.gain(i, slope),
            (None, _) => return None,
        };
        (gain <= 0.0).then(|| jammed(view, i, gain))
    })
}

/// Painleve's paradox in words: a contact whose [gain](crate::contact::View::gain) is zero or less.
pub(in crate::simulation) fn jammed(view: &View<'_>, contact: usize, gain: f64) -> String {
    format!(
        "friction {} of `{}` pushes it into the ground as much as its force lifts it, 1 - mu |n'e| = {gain:.1e} \
         (Painleve); lower the friction or change the geometry",
        view.friction(contact),
        view.model.declaration().contacts[contact].name,
    )
}
