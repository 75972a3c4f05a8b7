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
mod parameter_derivatives;
mod pieces;
pub(crate) mod rounding;
mod space;
mod switching;
pub mod tape;

pub(crate) use control_piece::ControlPiece;
pub(crate) use frame::{Frame, pair_size};
pub(crate) use loads::Loads;
pub(crate) use pieces::{Pieces, edge};
pub(crate) use space::Space;
pub(crate) use switching::terms as switching_terms;

pub use hangtime_dsl::declaration::{
    ConstraintDeclaration, ContactDeclaration, ContactTerms, Declaration, Epigraph, Equation,
    Experiment, FrictionDeclaration, Given, Held, ImpactLaw, JointDeclaration, JointsDeclaration,
    Kernel, Measured, MeasuredQuantity, OptimalControlDeclaration, Over, ParameterDeclaration,
    Picture, Shape, SparsityPattern, Switching, VariableDeclaration,
};
pub use parameter_derivatives::ParameterDerivatives;
pub use tape::{Explicit, Tape};

/// A Lagrangian system with unilateral contacts: the interface between scenes and solvers.
///
/// [`model!`](crate::model!) implements it; a hand-written scene may do so as well. All slices have
/// exactly the length stated; kernels are pure arithmetic and do not allocate.
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A ball above a floor.
/// #     pub Ball {
/// #         parameters { m: kg = 1, g: m/s^2 = 9.81, height: m = 1 }
/// #         coordinates { z: m }
/// #         lagrangian m/2*dot(z)^2 - m*g*z
/// #         surface floor: z >= 0
/// #         impact floor: inelastic
/// #         start { z: height }
/// #         horizon 1 [s]
/// #     }
/// # }
/// let mut ball = Ball::default();
/// ball.set_parameter(2, 0.5);
/// assert_eq!((ball.declaration().parameters[2].name, ball.height), ("height", 0.5));
/// let mut energy = [0.0; 2]; // kinetic, potential
/// ball.energy(&[0.5, 2.0], &mut energy);
/// assert_eq!(energy, [2.0, 9.81 * 0.5]);
/// # Ok::<(), InputError>(())
/// ```
pub trait Model: Send + Sync {
    /// What the scene declares: names, units, sparsity patterns, operation counts.
    fn declaration(&self) -> &'static Declaration;

    /// Value of parameter `index`, in the unit of its declaration.
    fn parameter(&self, index: usize) -> f64;

    /// Sets parameter `index`, in the unit of its declaration.
    fn set_parameter(&mut self, index: usize, value: f64);

    /// The declared initial coordinates `q` and velocities `v`, each of length `n_q`.
    fn start(&self, q: &mut [f64], v: &mut [f64]);

    /// The declared length of a simulation \[s\], if the scene declares one.
    fn horizon(&self) -> Option<f64>;

    /// Functions of parameters without which the scene has no meaning unless they are above zero, such as sizes of shapes: what each is, its
    /// unit, and its value.
    fn positive(&self) -> Vec<(&'static str, &'static str, f64)> {
        Vec::new()
    }

    /// Declared bounds of the coordinates and then the controls; infinite where none is declared.
    /// Both slices have length `n_q + n_u`.
    fn bounds(&self, lower: &mut [f64], upper: &mut [f64]);

    /// Acceleration without contact, `a = M^-1 f`, length `n_q`.
    fn free_acceleration(&self, x: &[f64], a: &mut [f64]);

    /// Jacobian of [`free_acceleration`](Self::free_acceleration) with respect to `x`: the values of
    /// [`Declaration::free_jacobian`], in its order.
    fn free_jacobian(&self, x: &[f64], values: &mut [f64]);

    /// Hessian of `multipliers' a` with respect to `x`: the values of [`Declaration::free_hessian`]
    /// (lower triangle), in its order. `multipliers` has length `n_q`.
    fn free_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]);

    /// Mass matrix `M(q)`, row-major, length `n_q * n_q`.
    fn mass_matrix(&self, x: &[f64], m: &mut [f64]);

    /// Kinetic and potential energy, `(v' dL/dv - L_0, ...)`: length 2. The potential is the part of
    /// `-L` that remains at `v = 0`; the kinetic energy is the rest of `v' dL/dv - L`.
    fn energy(&self, x: &[f64], energy: &mut [f64]);

    /// Gap `g_i(q)` of one contact.
    fn gap(&self, contact: usize, x: &[f64]) -> f64;

    /// The operations of an explicit function, by which its range is bounded where its inputs lie in ranges; `None` where they are not
    /// known. Events of functions that are known so are never missed, and contacts that cannot close are left out of account, in scenes
    /// with many.
    fn tape(&self, _function: Explicit) -> Option<Tape<'_>> {
        None
    }

    /// Everything about one contact that needs no derivative of a force, length
    /// [`contact_point::length`]: see [`contact_point`] for the layout. Of dry friction gap, normal velocity, normal and
    /// direction are 0, and the curvature is `-r`, the given normal acceleration with the other sign.
    fn contact(&self, contact: usize, x: &[f64], point: &mut [f64]);

    /// Jacobian with respect to `x` of the rows `(g, v_n, d_1..d_nq)`: the values of
    /// [`ContactDeclaration::jacobian`], in its order. Of dry friction the second row is `r` instead of `v_n`, here and
    /// in the Hessian.
    fn contact_jacobian(&self, contact: usize, x: &[f64], values: &mut [f64]);

    /// Hessian with respect to `x` of `multipliers' (g, v_n, d_1..d_nq)`: the values of
    /// [`ContactDeclaration::hessian`] (lower triangle), in its order. `multipliers` has length
    /// `2 + n_q`.
    fn contact_hessian(&self, contact: usize, x: &[f64], multipliers: &[f64], values: &mut [f64]);

    /// Coefficient of restitution `e` of one contact, in `0..=1`; 0 for an inelastic one.
    fn restitution(&self, _contact: usize) -> f64 {
        0.0
    }

    /// Coefficient of friction `mu` of one contact, at least 0; 0 for one without friction. Where sliding has another one, it is
    /// that at rest.
    fn friction(&self, _contact: usize) -> f64 {
        0.0
    }

    /// Coefficient of friction of one contact while it slides, at most that at rest.
    fn kinetic_friction(&self, contact: usize) -> f64 {
        self.friction(contact)
    }

    /// The tangential side of a contact in space along its second sliding velocity, laid out as [`tangent_point`].
    fn across(&self, _contact: usize, _x: &[f64], _point: &mut [f64]) {}

    /// Jacobian with respect to `x` of the rows `(v_t, e_1..e_nq)` of [`across`](Self::across): the values of
    /// [`FrictionDeclaration::across`], in its order.
    fn across_jacobian(&self, _contact: usize, _x: &[f64], _values: &mut [f64]) {}

    /// What a unit of the normal or tangential acceleration `r` of each entry of [`ContactDeclaration::loads`] of a dry friction adds to
    /// its given one: `r_dry = D f + sum_i load_i r_i`, which is the bound `f + sum_i c_i lambda_i`, `load_i = c_i D / D_i`.
    fn loads(&self, _contact: usize, _x: &[f64], _loads: &mut [f64]) {}

    /// The factor that the friction direction of one contact carries at `x`, by which friction changes with the sliding velocity
    /// and the place: the tangential force is this times `s / D`. 1 for most contacts. An impact has that of the velocities
    /// before it.
    fn friction_share(&self, _contact: usize, _x: &[f64]) -> f64 {
        1.0
    }

    /// The tangential side of a contact with friction, length [`tangent_point::length`]: see
    /// [`tangent_point`] for the layout. Called for contacts that declare friction only.
    fn tangent(&self, _contact: usize, _x: &[f64], _point: &mut [f64]) {}

    /// Jacobian with respect to `x` of the rows `(v_t, e_1..e_nq)`: the values of
    /// [`FrictionDeclaration::jacobian`], in its order.
    fn tangent_jacobian(&self, _contact: usize, _x: &[f64], _values: &mut [f64]) {}

    /// Hessian with respect to `x` of `multipliers' (v_t, e_1..e_nq)`: the values of
    /// [`FrictionDeclaration::hessian`] (lower triangle), in its order. `multipliers` has length
    /// `1 + n_q`.
    fn tangent_hessian(
        &self,
        _contact: usize,
        _x: &[f64],
        _multipliers: &[f64],
        _values: &mut [f64],
    ) {
    }

    /// Whether an equation of a joint is held; one that follows from others is not, and carries no force. All are at first.
    /// Equations are counted over all joints.
    fn hold_joint_row(&mut self, _row: usize, _held: bool) {}

    /// Whether an equation of a joint is [held](Self::hold_joint_row).
    fn joint_row_held(&self, _row: usize) -> bool {
        true
    }

    /// `(g, w)` of all equations of joints, with 0 for `g` of joints of velocities: twice as many numbers as there are
    /// [equations](JointsDeclaration::rows).
    fn joints(&self, _x: &[f64], _values: &mut [f64]) {}

    /// Jacobian of [`joints`](Self::joints) by `x`: the values of [`JointsDeclaration::jacobian`], in its order.
    fn joints_jacobian(&self, _x: &[f64], _values: &mut [f64]) {}

    /// Hessian of `multipliers' (g, w)` by `x`: the values of [`JointsDeclaration::hessian`] (lower triangle), in its order.
    /// `multipliers` has twice as many numbers as there are equations.
    fn joints_hessian(&self, _x: &[f64], _multipliers: &[f64], _values: &mut [f64]) {}

    /// Forces `lambda` of all equations of joints where nothing is in contact, in `M v' = f + G' lambda`.
    fn joint_forces(&self, _x: &[f64], _forces: &mut [f64]) {}

    /// Path functions at `x`, or `(x, r, s)` if they read [forces](ContactTerms): the running cost if there is one, then the path constraints. Length
    /// [`OptimalControlDeclaration::path_functions`].
    fn path_functions(&self, _x: &[f64], _values: &mut [f64]) {}

    /// Values of [`OptimalControlDeclaration::path_jacobian`], in its order.
    fn path_jacobian(&self, _x: &[f64], _values: &mut [f64]) {}

    /// Values of [`OptimalControlDeclaration::path_hessian`] for the weighted sum of the path functions.
    fn path_hessian(&self, _x: &[f64], _multipliers: &[f64], _values: &mut [f64]) {}

    /// Terminal functions at `z = (q, v, T)`, with what they read of [contacts](ContactTerms) behind that: the final cost if there is one, then the terminal
    /// conditions. Length [`OptimalControlDeclaration::terminal_functions`].
    fn terminal_functions(&self, _z: &[f64], _values: &mut [f64]) {}

    /// Values of [`OptimalControlDeclaration::terminal_jacobian`], in its order.
    fn terminal_jacobian(&self, _z: &[f64], _values: &mut [f64]) {}

    /// Values of [`OptimalControlDeclaration::terminal_hessian`] for the weighted sum of the terminal
    /// functions.
    fn terminal_hessian(&self, _z: &[f64], _multipliers: &[f64], _values: &mut [f64]) {}

    /// Impact functions at `(x, r, s)`: what is added up over all impacts, then the conditions on impacts. Length
    /// [`ContactTerms::impact_functions`].
    fn impact_functions(&self, _x: &[f64], _values: &mut [f64]) {}

    /// Values of [`ContactTerms::impact_jacobian`], in its order.
    fn impact_jacobian(&self, _x: &[f64], _values: &mut [f64]) {}

    /// Values of [`ContactTerms::impact_hessian`] for the weighted sum of the impact functions.
    fn impact_hessian(&self, _x: &[f64], _multipliers: &[f64], _values: &mut [f64]) {}

    /// Bounds of the free initial values, in the order of [`OptimalControlDeclaration::free_start`];
    /// infinite where none is declared.
    fn free_start_bounds(&self, _lower: &mut [f64], _upper: &mut [f64]) {}

    /// The quantities that are recorded along every motion, in order of declaration; none unless the scene declares
    /// `outputs`.
    fn outputs(&self) -> &'static [VariableDeclaration] {
        &[]
    }

    /// Values of [`outputs`](Self::outputs), in their units, where the motion is at `x = (q, v, u, t)`; the physical
    /// time `t` stands there in every scene. `contacts` holds the normal forces of all contacts, then their tangential
    /// forces, and then the same two of the impulses of all impacts until now; its length is `4 n_c`, and behind that stand
    /// the forces of all equations of joints.
    fn output_values(&self, _x: &[f64], _contacts: &[f64], _values: &mut [f64]) {}

    /// How the motion is drawn; `None` unless the scene declares a `picture`.
    fn picture(&self) -> Option<Picture> {
        None
    }

    /// Values of all shapes of the [`picture`](Self::picture), one after the other, where the motion is at
    /// `x = (q, v, u, t)`, the physical time `t` in every scene; `along` is the number along every curve. Length
    /// [`Picture::values`].
    fn picture_values(&self, _x: &[f64], _along: f64, _values: &mut [f64]) {}

    /// The declaration as it may stand in a scene file, without its documentation; none for a scene that was written by
    /// hand.
    fn text(&self) -> Option<&str> {
        None
    }

    /// Derivatives of the functions of the scene by some of its `parameters` (indices, increasing), at their present values.
    /// None where they would have to be compiled, and where they are too large.
    fn parameter_derivatives(
        &self,
        _parameters: &[usize],
    ) -> Option<Box<dyn ParameterDerivatives>> {
        None
    }

    /// Parameters (indices, increasing) that optimal control is to find; none unless the scene declares them.
    fn free_parameters(&self) -> &'static [usize] {
        &[]
    }

    /// The ranges in which the [`free_parameters`](Self::free_parameters) are looked for, in their units.
    fn free_parameter_bounds(&self, _lower: &mut [f64], _upper: &mut [f64]) {}

    /// Measured motions that the scene compares with; none unless its objective is a misfit.
    fn experiments(&self) -> &'static [Experiment] {
        &[]
    }

    /// The scene as it is in one of its [`experiments`](Self::experiments), at the present values of its parameters: with the
    /// start of that. None where it would have to be compiled.
    fn in_experiment(&self, experiment: usize) -> Option<Box<dyn Model>> {
        let known = self.experiments().get(experiment)?;
        (!known.own_start).then(|| self.boxed())
    }

    /// The scene with some of its parameters (indices, increasing) as coordinates without motion behind all others, at their
    /// present values, so that every function is differentiated by them twice: `p'' = 0`, and no contact acts on them. Those
    /// that are free are free at the start, within their ranges. What is [`remembered`](Self::remembered) of the start stands
    /// behind them. None where it would have to be compiled.
    ///
    /// # Errors
    /// Why the scene cannot be so, in one line.
    fn with_held(&self, _parameters: &[usize]) -> Option<Result<Box<dyn Model>, String>> {
        None
    }

    /// The velocities `v`, states of first order among them, right after the function of a contact with
    /// [`Switching::Resets`] has come to be positive at `x`.
    fn reset(&self, _contact: usize, _x: &[f64], _v: &mut [f64]) {}

    /// Components of the start `(q, v)` (indices, increasing) that optimal control is to find and that its functions read, as
    /// `start(...)`; the functions of this scene read the declared start there, and those of [`with_held`](Self::with_held) the one
    /// that is found.
    fn remembered(&self) -> &'static [usize] {
        &[]
    }

    /// Largest values in the objective and in goals, which optimal control has as unknowns: functions of this scene have the values
    /// themselves in their place, with a kink (of a largest value over the motion 0), and those of [`with_held`](Self::with_held)
    /// unknowns.
    fn epigraphs(&self) -> &'static [Epigraph] {
        &[]
    }

    /// The parameters that are coordinates without motion in this scene, see [`with_held`](Self::with_held).
    fn held(&self) -> Option<Held> {
        None
    }

    /// Values of [`Held::given`] where the parameters are as the coordinates in `x` say.
    fn given_values(&self, _x: &[f64], _values: &mut [f64]) {}

    /// Values of [`Held::jacobian`], in its order.
    fn given_jacobian(&self, _x: &[f64], _values: &mut [f64]) {}

    /// Values of [`Held::hessian`] for the weighted sum of the [`given_values`](Self::given_values).
    fn given_hessian(&self, _x: &[f64], _multipliers: &[f64], _values: &mut [f64]) {}

    /// A copy behind a fresh box.
    fn boxed(&self) -> Box<dyn Model>;
}

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

/// Layout of the output of [`Model::contact`].
pub mod contact_point {
    /// Gap `g` [unit of the surface].
    pub const GAP: usize = 0;
    /// Normal velocity `v_n = n' v` (plus the gap's explicit time derivative).
    pub const NORMAL_VELOCITY: usize = 1;
    /// Velocity-dependent part of the normal acceleration, `v' (hess g) v` (plus explicit time
    /// terms): `v_n' = n' v' + CURVATURE`.
    pub const CURVATURE: usize = 2;
    /// Inverse inertia along the normal, `D = n' M^-1 n` [1/kg for a gap in metres].
    pub const INVERSE_INERTIA: usize = 3;
    /// First component of the normal `n = grad g`, `n_q` numbers.
    pub const NORMAL: usize = 4;

    /// First component of the contact direction `d`, `n_q` numbers.
    #[must_use]
    pub const fn direction(coordinates: usize) -> usize {
        NORMAL + coordinates
    }

    /// Length of the whole layout.
    #[must_use]
    pub const fn length(coordinates: usize) -> usize {
        NORMAL + 2 * coordinates
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

/// Layout of the output of [`Model::tangent`].
pub mod tangent_point {
    /// Sliding velocity `v_t = b' v` (plus what the ground moves).
    pub const SLIDING_VELOCITY: usize = 0;
    /// Part of the sliding acceleration that no force changes: `v_t' = b' v' + CURVATURE`.
    pub const CURVATURE: usize = 1;
    /// First component of the tangent `b = d v_t / dv`, `n_q` numbers.
    pub const TANGENT: usize = 2;

    /// First component of the friction direction `e = M^-1 b / D`, `n_q` numbers.
    #[must_use]
    pub const fn direction(coordinates: usize) -> usize {
        TANGENT + coordinates
    }

    /// Length of the whole layout.
    #[must_use]
    pub const fn length(coordinates: usize) -> usize {
        TANGENT + 2 * coordinates
    }
}
