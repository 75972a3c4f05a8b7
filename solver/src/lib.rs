#![doc = include_str!("../README.md")]
//!
//! | module | what it holds |
//! |---|---|
//! | [`mpcc`] | complementarity problems: relaxation tied to the barrier, crossover, certificate |
//! | [`nl`] | programs from `.nl` files, which modelling languages write, and `.sol` files for them |
//! | [`nlp`] | an interior point method for nonlinear programs |
//!
//! A program is a file ([`nl::Program`]), or a type that implements [`nlp::NlpProblem`], with [`mpcc::Mpcc`] where variables
//! complement each other.

// Not for users: hangtime times its runs by the same clocks, which are those of the host where there is no system.
#[doc(hidden)]
pub mod clock;
mod input_error;
mod linalg;
pub mod mpcc;
pub mod nl;
pub mod nlp;
#[cfg(test)]
mod polynomials;
mod problem_size;
mod seconds;
mod until;

#[cfg(target_family = "wasm")]
pub use clock::set_clock;
pub use input_error::InputError;
pub use problem_size::ProblemSize;
pub use seconds::Seconds;
