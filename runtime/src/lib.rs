//! Mechanics with impacts: simulation and optimal control of Lagrangian systems with unilateral
//! contacts.
//!
//! ```
//! use hangtime::prelude::*;
//!
//! hangtime::model! {
//!     /// A sledge with a propeller, on a hill with a drop behind it.
//!     pub Sledge {
//!         parameters { m: kg = 100, g: m/s^2 = 9.81 }
//!         coordinates { y: m, z: m }
//!         controls { push: N in -200..=400 }
//!         lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
//!         forces { y: push }
//!         surface snow: z - 1[m]*exp(-(y/2[m])^2) >= 0
//!         impact snow: inelastic
//!         minimize time
//!         finally { y == 8[m] }
//!         start { z: 1[m], dot(y): 1[m/s] }
//!         horizon 2 [s]
//!     }
//! }
//!
//! let sledge = Sledge::default();
//! let ride = simulate(&sledge).run()?;
//! println!("{ride}");
//! assert!(ride.at(1.0)?["z"] >= 0.0);
//!
//! let fastest = solve(&sledge).intervals(8).run()?;
//! println!("{fastest}");
//! assert!(fastest.status.is_solved());
//! # Ok::<(), InputError>(())
//! ```
//!
//! A scene is declared as on paper with [`model!`], which derives everything that the solvers need while compiling.
//! [`simulate`] and [`solve`] take it from there; [`prelude`] holds what a program with a scene of its own needs.
//!
//! # From a declaration to a result
//!
//! | module | what it holds |
//! |---|---|
//! | [`model`](mod@model) | the interface between scenes and solvers, which [`model!`] and texts implement |
//! | [`simulation`] | one trait, [`Simulator`](simulation::Simulator), one result, several methods: finite elements with switch detection, event-driven, and three to compare with |
//! | [`derivative`] | derivatives of a motion, forwards and backwards |
//! | [`ocp`] | optimal control: a search for the contact sequence, collocation with that sequence, a certificate, an independent re-simulation |
//! | [`estimation`] | parameters from measured motions: least squares with exact derivatives through impacts |
//! | [`scene`] | the trait behind that, over what the language derived, compiled or read from a text |
//! | [`rk`] | collocation schemes to rounding error |
//! | [`mpcc`], [`nlp`], [`nl`] | the package `hangtime-solver`: complementarity problems, nonlinear programs, and both from `.nl` files |
//!
//! Each is usable without those above it.

// The macro's output names the crate from outside; the crate's own tests declare scenes as well.
#[cfg(test)]
extern crate self as hangtime;

pub mod baselines {
    //! Methods that exist to be compared with: none of them locates events, so that each shows what that is worth.
    //!
    //! - [`FixedStep`]: Runge-Kutta steps of fixed length that see impacts and switches at their ends only.
    //! - [`Moreau`]: Moreau-Jean time stepping, with impulses over fixed steps.
    //! - [`Smooth`]: contacts as smoothed step functions of numerical time.
    //!
    //! They take scenes and give results as all methods do: `simulate(&scene).method(Moreau::default())`.

    #[doc(inline)]
    pub use crate::simulation::baselines::{FixedStep, Moreau, Smooth};
}
mod contact;
pub mod derivative;
mod enclosure;
pub mod estimation;
mod fesd;
mod front;
mod joints;
mod linalg;
pub mod model;
pub mod ocp;
pub mod prelude;
mod program;
mod progress;
#[cfg(test)]
mod random_cases;
mod refusal;
pub mod rk;
mod run;
pub mod scene;
pub mod simulation;
mod time_freezing;
mod yardstick;

pub use front::simulate::{Simulate, simulate};
pub use front::solve::{Solve, solve};
#[doc = include_str!("model_macro.md")]
pub use hangtime_macros::model;
/// A scene that is declared in a file of its own.
///
/// The file holds what stands inside [`model!`] `{ ... }`, or only the statements; the scene is then called after the
/// file. Its path is counted from the folder of the package's manifest. `hangtime simulate scenes/ball.hang` runs the same
/// file without a compiler.
///
/// ```
/// use hangtime::prelude::*;
///
/// hangtime::model_file!("tests/data/ball.hang");
///
/// let run = simulate(&Ball::default()).run()?;
/// assert!((run.events[0].time - (2.0_f64 / 9.81).sqrt()).abs() < 1e-12);
/// # Ok::<(), InputError>(())
/// ```
///
/// Mistakes are named with the file, line and column.
pub use hangtime_macros::model_file;
#[cfg(target_family = "wasm")]
pub use hangtime_solver::set_clock;
pub use hangtime_solver::{InputError, mpcc, nl, nlp};
pub use progress::{BestMotion, Observer, Progress};
