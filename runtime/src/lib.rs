//! Mechanics with impacts: simulation and optimal control of Lagrangian systems with unilateral
//! contacts.
//!
//! ```text
//! model  ->  time_freezing  ->  dcs  ->  fesd  ->  mpcc  ->  nlp  ->  linalg
//!   \------------------------------->  simulation, ocp
//! ```
//!
//! Arrows point one way: `nlp` knows nothing of time, `linalg` nothing of optimization.

#[doc(hidden)]
#[path = "private.rs"]
pub mod __private;
// The macro's output names the crate from outside; the crate's own tests declare scenes as well.
#[cfg(test)]
extern crate self as hangtime;

mod dcs;
mod fesd;
mod linalg;
pub mod model;
pub mod mpcc;
pub mod nlp;
pub mod ocp;
pub mod rk;
pub mod simulation;
mod time_freezing;

#[doc = include_str!("model_macro.md")]
pub use hangtime_macros::model;
