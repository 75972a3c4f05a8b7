//! Derivatives of simulated motions by parameters and initial values.

mod closed_forms;
mod cost;
mod differences;
mod obstacles;
mod support;
