//! The law of many contacts at one instant, solved without trying all choices.
//!
//! Forces `f` and velocities (or accelerations) `w` of the *lines* of the contacts, their normals first, then the
//! tangents of those with friction that may stick, each of which has a [`Cone`]:
//!
//! ```text
//! w = q + K f
//! normal i:              0 <= f_i  _|_  w_i >= 0
//! cone (i, t, mu):       |f_t| <= mu f_i,   f_t w_t = -mu f_i |w_t|
//! ```
//!
//! In the plane this is piecewise linear: each contact is [open, closed, sticks or slips](ContactState), and with the states
//! known it is a linear system. `blocks` takes apart what is not coupled. `active_set` changes the states until they
//! are consistent: those that are not all at once, as long as that makes them fewer, and one at a time otherwise, which
//! ends for certain where `K` is that of frictionless contacts. `polyhedral` is Lemke's method for the whole,
//! which begins anew where the changes do not end. `basic` takes the forces from contacts that others make redundant: their
//! motion is one, and what is left are forces that the linear system of the states determines. What is found is
//! accepted by its residual alone, at the level of rounding error of the sums that it consists of.
//!
//! Sources: Kostreva, *Block pivot methods for solving the complementarity problem* (1978); Judice, Pires, *A block principal
//! pivoting algorithm for large-scale strictly monotone linear complementarity problems* (1994); Alart, Curnier, *A mixed
//! formulation for frictional contact problems prone to Newton like solution methods* (1991).

mod active_set;
mod basic;
mod blocks;
pub(crate) mod cluster;
mod contact_mode;
mod decision;
mod few;
pub(crate) mod impact;
pub(crate) mod law;
mod line;
mod many;
mod mode_error;
mod polyhedral;
mod problem;
pub(crate) mod sharing;
mod space;
mod state;
pub(crate) mod touching;
mod view;

pub use contact_mode::{ContactMode, Direction};
pub(crate) use decision::{Decision, Vanished, sliding};
pub(crate) use line::{Line, stuck, tangents};
pub(crate) use mode_error::ModeError;
pub(crate) use problem::{Cone, Problem};
pub(crate) use state::{ActiveContact, ContactState, find, force_count};
pub(crate) use touching::{Balance, Touching};
pub(crate) use view::{View, dot, sum_of_sizes};
