//! Simulators: one trait, one result type, several methods.
//!
//! A simulator advances a [`Model`] from an initial state over a horizon and returns a
//! [`Simulation`]: trajectory, events, status, measured residuals and counts. Not converging is a
//! [`SimulationStatus`], not an error; an [`InputError`] means that the input was refused before the
//! first step.

mod contact_mode;
mod event;
mod fesd;
mod fixed;
mod moreau;
mod problem;
mod result;
mod smooth;

pub use contact_mode::{ContactMode, Direction};
pub use event::EventDriven;
pub use fesd::{Fesd, StepFormulation};
pub use fixed::FixedStep;
pub use moreau::Moreau;
pub use problem::{ControlSignal, InitialValueProblem, InputError};
pub use result::{
    Counts, Diagnosis, Event, EventKind, ProblemSize, Residuals, Seconds, Simulation,
    SimulationStatus, Trajectory,
};
pub use smooth::Smooth;

use crate::model::Model;

/// A way to simulate a scene.
pub trait Simulator {
    /// Short name, as on the command line.
    fn name(&self) -> &'static str;

    /// Simulates `model` over `problem`.
    ///
    /// `progress` is called with the physical time reached \[s\] after every accepted step.
    ///
    /// # Errors
    /// [`InputError`] if the problem or the method's settings are refused; every failure after the
    /// first step is a status of the result.
    fn simulate(
        &self,
        model: &dyn Model,
        problem: &InitialValueProblem,
        progress: &mut dyn FnMut(f64),
    ) -> Result<Simulation, InputError>;
}
