//! Event-driven simulation; see [`EventDriven`].
//!
//! `integration` is the loop of steps and events; `dynamics` evaluates the constrained motion of one contact
//! mode, `dop853` integrates it (`error_scale` says how accurately), `search` and `locate` find where the mode ends,
//! `impact` and `contact_mode` (with `contact_problem` and `coulomb`) what follows, `audit` measures the signs.

mod audit;
mod cluster;
pub(super) mod contact_mode;
pub(super) mod contact_problem;
mod contact_state;
pub(super) mod coulomb;
pub(super) mod dop853;
pub(super) mod dynamics;
mod error_scale;
pub(super) mod impact;
mod integration;
mod locate;
mod remarks;
mod search;
mod settings;
mod small_system;
mod tableau;
pub(in crate::simulation) mod velocity_jump;

pub use settings::EventDriven;

use super::{InitialValueProblem, InputError, Simulation, Simulator};
use crate::Observer;
use crate::model::Model;

impl Simulator for EventDriven {
    fn name(&self) -> &'static str {
        "event"
    }

    fn simulate(
        &self,
        model: &dyn Model,
        problem: &InitialValueProblem,
        observer: &mut Observer<'_>,
    ) -> Result<Simulation, InputError> {
        self.check()?;
        problem.check(model)?;
        if self.output_times > problem.points {
            return Err(InputError::out_of_range(
                "output times",
                self.output_times as f64,
                "",
                format!(
                    "at most {}; raise `points` of the problem for more",
                    problem.points
                ),
            ));
        }
        Ok(integration::Integration::new(self, model, problem).run(observer))
    }

    fn set_tolerance(&mut self, tolerance: f64) -> Result<(), InputError> {
        self.tolerance = tolerance;
        Ok(())
    }
}
