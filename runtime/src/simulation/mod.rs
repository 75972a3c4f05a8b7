//! Simulators: one trait, one result type, several methods.
//!
//! A simulator advances a [`Model`] from an initial state over a horizon and returns a
//! [`Simulation`]: trajectory, events, status, measured residuals and counts. Not converging is a
//! [`SimulationStatus`], not an error; an [`InputError`] means that the input was refused before the
//! first step.

mod accumulation;
mod agreement;
mod along;
pub(crate) mod baselines;
mod changes;
mod event;
mod event_log;
mod explicit_time;
mod fesd;
mod hand_over;
mod hidden_force;
mod impulse;
mod joints;
mod near;
mod order_of_impacts;
mod other_grid;
mod poles;
mod problem;
mod quantity;
mod recorder;
mod result;
mod sentences;
mod shared_load;
mod singular;
mod state;
mod struck_at_start;
mod trajectory;
mod verdict;
mod watch;

pub use crate::InputError;
pub use crate::contact::{ContactMode, Direction};
pub use crate::joints::joint_forces;
pub use crate::run::remarks::Doubts;
pub use event::EventDriven;
pub use fesd::{Fesd, FormulationSize, StepFormulation, step_sizes};
pub use hangtime_solver::nlp::Residuals;
pub use hangtime_solver::{ProblemSize, Seconds};
pub use problem::{ControlSignal, InitialValueProblem};
pub use result::{Counts, Diagnosis, Event, EventKind, Simulation, SimulationStatus};
pub use state::State;
pub use trajectory::Trajectory;

pub(crate) use event::{Ending, simulate_once, simulate_to};
pub(crate) use joints::Closed as ClosedStart;
pub(crate) use quantity::{Quantity, number, per_second};
pub(crate) use recorder::Instant;

use crate::Observer;
use crate::model::Model;
use crate::refusal;

/// A way to simulate a scene.
pub trait Simulator {
    /// Short name, as on the command line.
    fn name(&self) -> &'static str;

    /// Simulates `model` over `problem`.
    ///
    /// `observer` sees the physical time reached after every accepted step, and may stop the run.
    ///
    /// # Errors
    /// [`InputError`] if the problem or the method's settings are refused; every failure after the
    /// first step is a status of the result.
    fn simulate(
        &self,
        model: &dyn Model,
        problem: &InitialValueProblem,
        observer: &mut Observer<'_>,
    ) -> Result<Simulation, InputError>;

    /// Sets the tolerance.
    ///
    /// # Errors
    /// [`InputError`] for a method without one.
    fn set_tolerance(&mut self, _tolerance: f64) -> Result<(), InputError> {
        Err(refusal::unsupported(
            format!("a tolerance of method {}", self.name()),
            "give a number of steps",
        ))
    }

    /// Sets the longest step \[s\].
    ///
    /// # Errors
    /// [`InputError`] for a method whose steps are not its own, and for a time that is none.
    fn set_max_step(&mut self, _seconds: f64) -> Result<(), InputError> {
        Err(refusal::unsupported(
            format!("a longest step of method {}", self.name()),
            "take `fesd` or `event`",
        ))
    }

    /// Sets the number of equal steps.
    ///
    /// # Errors
    /// [`InputError`] for a method that chooses its steps.
    fn set_steps(&mut self, _steps: usize) -> Result<(), InputError> {
        Err(refusal::unsupported(
            format!("a number of steps of method {}", self.name()),
            "give a tolerance",
        ))
    }
}
