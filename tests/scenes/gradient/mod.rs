//! Derivatives of simulated motions by parameters and initial values.

#![expect(clippy::unwrap_used, reason = "a failed step fails the test")]

mod adjoint;
mod closed_forms;
mod conditions;
mod differences;
mod mechanisms;
mod obstacles;
mod ranges;
pub(crate) mod support;
mod texts;
