//! What a mechanical scene is to the solvers: a Lagrangian system with unilateral contacts.
//!
//! The equations of motion in coordinates `q`, velocities `v` and controls `u` are
//!
//! ```text
//! q' = v
//! v' = a(q, v, u, t) + sum_i d_i(q) r_i          a = M(q)^-1 f(q, v, u, t)
//! 0 <= g_i(q)  _|_  r_i >= 0                     gap and normal contact acceleration
//! ```
//!
//! `n_i = grad g_i` is the contact normal and `d_i = w_i / (n_i' w_i)` the *contact direction*, scaled
//! so that `n_i' d_i = 1`. Unless the scene declares another one, `w_i = M^-1 n_i`. The unknown
//! `r_i` [unit of the gap / s^2] is the normal acceleration that contact `i` provides; the contact
//! force is `lambda_i = r_i / D_i` with `D_i = n_i' M^-1 n_i`. The same direction carries the impulse
//! of an impact, `v+ = v- + sum_i d_i p_i`, and the auxiliary dynamics of the time-freezing
//! reformulation, `v' = a_bar d_i`.
//!
//! A contact with *restitution* turns its normal velocity round at an impact, `v_n+ = -e v_n-`.
//!
//! A contact with *Coulomb friction* carries a tangential force `lambda_t` as well, along
//! `b_i = d v_t / dv` for the sliding velocity `v_t,i = b_i' v - w_i`, where the ground moves at the speed `w_i(q, t)`:
//!
//! ```text
//! v' = ... + e_i s_i        e_i = M^-1 b_i / D_i        |s_i| <= mu_i r_i,  s_i v_t,i = -mu_i r_i |v_t,i|
//! ```
//!
//! so that `s_i = D_i lambda_t,i` is measured like `r_i`. Gap and sliding velocity must be scaled
//! alike: normal and tangential part of one velocity.
//!
//! *Dry friction* without a surface ([`ContactDeclaration::dry`]) is a contact that touches always, without gap, normal and
//! impacts: its normal force is the declared bound `f(q, t)`, so that `r_i = D_i f` is given and `|s_i| <= r_i`. The factor
//! `D_i > 0` is a scale: `e_i = M^-1 b_i / D_i` for any other would be the same friction.
//!
//! A *switch* of what acts ([`Switching`]) is dry friction as well, in another direction.
//!
//! A contact that *holds* coordinates acts on the system in which those are locked: `M^-1` in `w`, `D` and `e`
//! is then the inverse inertia of that system, with zeros in the rows and columns of the held coordinates.
//!
//! *Joints* ([`JointsDeclaration`]) are equations that hold all along the motion. `M^-1` is then what it is of the system in which they do,
//! `M^-1 - M^-1 G' (G M^-1 G')^-1 G M^-1`, in `a`, `w`, `D` and `e` alike, so that whatever acts on a mechanism acts on it as it
//! can move.
//!
//! *States of first order*, `z' = f(q, v, z, u, t)`, are the velocities of coordinates behind those of the mechanism
//! ([`Declaration::states`]): coordinates of unit mass, on which `f` is the force and which no function reads. They are continuous
//! through impacts since no contact direction has entries there.
//!
//! Every kernel reads one *input vector* `x = (q, v, u)`, with the physical time appended if the
//! scene depends on it explicitly ([`Declaration::explicit_time`]).

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
