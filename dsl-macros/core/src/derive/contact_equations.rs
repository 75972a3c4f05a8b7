//! What is derived of a contact.

use super::explicit::Explicit;
use super::shared::Directed;
use crate::graph::Sym;

/// What belongs to one contact.
#[derive(Default)]
pub(crate) struct ContactEquations {
    /// Gap, normal velocity, and if it is a formula, the contact direction; of dry friction zeros, with the given normal
    /// acceleration in place of the normal velocity.
    pub(crate) rows: Explicit,
    pub(crate) curvature: Sym,
    pub(crate) normal: Vec<Sym>,
    pub(crate) inverse_inertia: InverseInertia,
    /// The contact direction, unless it is among the `rows`.
    pub(crate) direction: Option<Directed>,
    pub(crate) friction: Option<FrictionEquations>,
    /// In space the tangential side along the second sliding velocity.
    pub(crate) across: Option<FrictionEquations>,
    /// Of dry friction: contacts whose forces it follows, those of friction counted behind all normal ones.
    pub(crate) followed: Vec<usize>,
    /// What a unit of the acceleration by each of these forces adds to the given one.
    pub(crate) loads: Vec<Sym>,
    /// Of a switch: whether it does not change the rate of its function, which is only passed then.
    pub(crate) passes: bool,
}

/// `D = n' H n`.
#[derive(Default)]
pub(crate) enum InverseInertia {
    Formula(Sym),
    /// From a linear system at run time: with the mass matrix, or with that of the direction.
    #[default]
    Solved,
}

/// The tangential side of a contact.
#[derive(Default)]
pub(crate) struct FrictionEquations {
    /// Sliding velocity, and if it is a formula, the friction direction.
    pub(crate) rows: Explicit,
    pub(crate) curvature: Sym,
    pub(crate) tangent: Vec<Sym>,
    /// The friction direction, unless it is among the `rows`.
    pub(crate) direction: Option<Directed>,
}

impl ContactEquations {
    /// Whether one of its directions is solved for with the inertia of the scene.
    pub(super) fn shares_inertia(&self) -> bool {
        let sides = self.friction.iter().chain(&self.across);
        let directions = sides.map(|side| &side.direction).chain([&self.direction]);
        directions
            .flatten()
            .any(|direction| matches!(direction, Directed::Columns(_)))
    }
}
