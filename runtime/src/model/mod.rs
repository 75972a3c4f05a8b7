//! What a method knows of a scene: the [`Model`] that the language makes, and what follows from it.

mod control_piece;
mod frame;
pub(crate) mod held;
mod loads;
mod pieces;
pub(crate) mod rounding;
mod space;
mod switching;

pub(crate) use control_piece::ControlPiece;
pub(crate) use frame::{Frame, pair_size};
pub(crate) use loads::Loads;
pub(crate) use pieces::{Pieces, edge};
pub(crate) use space::Space;
pub(crate) use switching::terms as switching_terms;

pub use crate::scene::tape::{self, Explicit, Tape};
pub use crate::scene::{
    Function, Model, ParameterDerivatives, Signature, contact_point, tangent_point,
};
pub use hangtime_dsl::declaration::{
    ConstraintDeclaration, ContactDeclaration, ContactTerms, Declaration, Epigraph, Equation,
    Experiment, FrictionDeclaration, Given, Held, ImpactLaw, JointDeclaration, JointsDeclaration,
    Kernel, Measured, MeasuredQuantity, OptimalControlDeclaration, Over, ParameterDeclaration,
    Picture, Shape, SparsityPattern, Switching, VariableDeclaration,
};

/// Number of contacts that are surfaces; the others, behind them, are dry friction.
pub(crate) fn surfaces(model: &dyn Model) -> usize {
    let contacts = model.declaration().contacts.iter();
    contacts.filter(|contact| !contact.dry).count()
}

/// Number of equations of all joints of a scene.
pub(crate) fn joint_rows(model: &dyn Model) -> usize {
    model.declaration().joints.map_or(0, |joints| joints.rows())
}

/// Coefficient of friction of each contact, 0 where none is declared.
pub(crate) fn friction_coefficients(model: &dyn Model) -> Vec<f64> {
    let contacts = model.declaration().contacts;
    (0..contacts.len())
        .map(|i| contacts[i].friction.map_or(0.0, |_| model.friction(i)))
        .collect()
}

/// Coefficient of friction of each contact while it slides, 0 where none is declared.
pub(crate) fn kinetic_coefficients(model: &dyn Model) -> Vec<f64> {
    let contacts = model.declaration().contacts;
    (0..contacts.len())
        .map(|i| {
            contacts[i]
                .friction
                .map_or(0.0, |_| model.kinetic_friction(i))
        })
        .collect()
}

/// The factor of the friction direction of one contact at `x`, see [`Model::friction_share`].
pub(crate) fn friction_share(model: &dyn Model, contact: usize, x: &[f64]) -> f64 {
    match model.declaration().contacts[contact].friction {
        Some(friction) if friction.share => model.friction_share(contact, x),
        _ => 1.0,
    }
}

/// Whether a velocity contains more than `covector' v`, up to rounding error: that of a ground that moves, which does work
/// on the bodies.
pub(crate) fn contains_ground(velocity: f64, covector: &[f64], v: &[f64]) -> bool {
    const ROUNDING: f64 = 1e-12;
    let terms = || covector.iter().zip(v).map(|(c, v)| c * v);
    let size = terms().fold(velocity.abs(), |size, term| size + term.abs());
    (velocity - terms().sum::<f64>()).abs() > ROUNDING * size
}
