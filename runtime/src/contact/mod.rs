//! The laws of contact, for every method that asks.
//!
//! # What a law reads
//!
//! A [`View`] holds contacts as the model gives them at one point: gaps `g_i`, normals `n_i = dg_i/dq`, contact directions `d_i` with
//! `n_i' d_i = 1`, tangents `b_i` and friction directions `e_i` (in space two of each), the acceleration `a` without contact forces, and
//! the coefficients of friction. Each simulator fills one. A force acts on a [`Line`]; what it does to the velocity, or the
//! acceleration, of another one is an entry of the Delassus matrix, in units of accelerations whatever the masses are:
//!
//! ```text
//! K_nn = n_i' d_j    K_nt = n_i' e_j    K_tn = b_i' d_j    K_tt = b_i' e_j        lambda_i = r_i / D_i
//! ```
//!
//! # Coulomb's law
//!
//! The lines of contacts that touch ([`touching`]) are their normals, then the tangents of those that may stick, each of which has
//! a [`Cone`]; what slides already acts along `d_i -+ mu_i e_i` on its normal:
//!
//! ```text
//! w = q + K f
//! normal i:              0 <= f_i  _|_  w_i >= 0
//! cone (i, t, mu):       |f_t| <= mu f_i,   f_t |w_t| = -mu f_i w_t
//! ```
//!
//! For accelerations `q` is that of the lines without contact forces, for impacts their velocity and what restitution adds
//! ([`impact`]: Moreau's law, in which Newton's restitution and Coulomb's friction hold between impulses and velocities
//! after it), for Moreau's time stepping that at the end of a step without contacts. Dry friction is a contact whose normal force
//! is given: its normal line moves by its own force less the given one. A switch of what acts is dry friction in another
//! direction.
//!
//! In the plane this is piecewise linear: each contact is [open, closed, sticks or slips](ContactState), and with the states
//! known it is a linear system. [`law`] is the order of ways to a solution:
//!
//! - `blocks` takes apart what is not coupled.
//! - `few` tries all states of few contacts, which finds every solution: none, or several, is Painleve's paradox.
//! - `active_set` changes the states of many until they are consistent: those that are not all at once, as long as that
//!   makes them fewer, and one at a time otherwise, which ends for certain where `K` is that of frictionless contacts.
//! - `polyhedral` is Lemke's method for the whole, which begins anew where the changes do not end.
//! - `basic` takes the forces from contacts that others make redundant: their motion is one, and what is left are forces
//!   that the linear system of the states determines. What is found is accepted by its residual alone, at the level of rounding
//!   error of the sums that it consists of.
//! - `space` is a semismooth Newton method for cones of contacts in space, with a proximal term where they depend on each other.
//!
//! # After an instant
//!
//! [`Decision`] reads from a balance of accelerations what each contact does next: it carries a force, or leaves with an
//! acceleration; it sticks inside of its cone, or slips with an acceleration. Where both sides of a condition vanish it says so. Contacts
//! whose velocity others hold need no force of their own ([`shares::is_free`]); in space all share the load, and let go where none of their
//! [`shares`] obeys the laws of all. Impacts that follow too fast to be told apart, or that a scene wants in sequence, are a [`cluster`]; those of
//! others may pass an [`edge`] by.
//!
//! # What stays twice on purpose
//!
//! Finite elements and the event-driven method check each other, so they share the laws and not the way to them:
//!
//! - integration, and the steps that end at a switch, with the memory of the equations of a mode; which function falls first on dense
//!   output is found for both by `enclosure`;
//! - what counts as zero: sizes of terms for finite elements, ways and moments of a motion for the event-driven method, which
//!   follow from how each integrates and are arguments here; both are measured by the `extent` of the motion;
//! - the choice where accelerations decide nothing: finite elements solve the same problem one derivative higher, the event-driven
//!   method looks at what follows a moment later;
//! - how many solutions are asked for: the event-driven method and Moreau's time stepping want all. Finite elements take the first, in
//!   which what may rest does, and ask for all where friction may push a contact into the ground or a switch may slide. All refuse several motions.
//!
//! Sources: Moreau, *Unilateral contact and dry friction in finite freedom dynamics* (1988); Kostreva, *Block pivot methods for
//! solving the complementarity problem* (1978); Judice, Pires, *A block principal pivoting algorithm for large-scale strictly
//! monotone linear complementarity problems* (1994); Alart, Curnier, *A mixed formulation for frictional contact problems prone to
//! Newton like solution methods* (1991).

mod active_set;
mod balance;
mod basic;
mod blocks;
pub(crate) mod cluster;
mod contact_mode;
pub(crate) mod edge;
mod extent;
mod few;
pub(crate) mod impact;
pub(crate) mod law;
mod line;
mod many;
mod mode_error;
mod polyhedral;
mod problem;
mod rest;
pub(crate) mod shares;
mod space;
mod state;
pub(crate) mod touching;
mod view;

pub(crate) use balance::{Balance, Decision, Vanished, sliding};
pub use contact_mode::{ContactMode, Direction};
pub(crate) use extent::Extent;
pub(crate) use line::{Line, stuck, tangents, unbiased_lines};
pub(crate) use mode_error::ModeError;
pub(crate) use problem::{Cone, Problem};
pub(crate) use rest::Rest;
pub(crate) use state::{ActiveContact, ContactState, find, force_count};
pub(crate) use touching::Touching;
pub(crate) use view::{View, sum_of_sizes};
