//! Derivatives of simulated motions by parameters and initial values.

#![expect(clippy::unwrap_used, reason = "a failed step fails the test")]

mod adjoint;
mod differences;
mod mechanisms;
pub(crate) mod support;
mod texts;
