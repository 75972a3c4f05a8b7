//! Simulation by finite elements with switch detection, in active-set form.
//!
//! Every element is solved in a fixed contact mode by Newton's method. Sign conditions are checked along
//! its dense output; the first violation makes the element lengths unknown and a switch condition the
//! additional equation:
//!
//! - a gap closes: `g_i = 0` at the end of the element;
//! - a contact force vanishes: `r_i = 0` at the end of the element (the *exit condition*; the published
//!   method lacks it and leaves the take-off undetermined by up to `c_1 h / 2`);
//! - the friction of a sticking contact reaches its bound: `mu_i r_i - |s_i| = 0`, an exit condition as well;
//! - a contact that slides comes to rest: `v_t,i = 0`.
//!
//! `driver` is the state of a run (`present`: where it is) and `stepping` its loop, with lengths by `error_control`;
//! `detection` looks for switches by bounds (`crate::enclosure`), `location` finds where they are, `mode_change` carries them
//! out (what happens at an instant is told by `run`), `standstill` is rest between switches.
//!
//! Without a named number of steps the run promises an accuracy and checks it (`accuracy`).
//!
//! Elements between two switches of one step have equal length (step equilibration, exact). Impacts follow
//! Moreau's law for all touching contacts at once, with Newton's restitution and Coulomb friction between
//! impulses; in the time-freezing system they take numerical time only.
//!
//! A grid that was asked for has its error measured by another one (`estimate`). The formulation `TimeFreezing` does all
//! this with elements in numerical time.

mod accuracy;
mod detection;
mod diagnosis;
mod driver;
mod error_control;
mod estimate;
mod hidden_force;
mod location;
mod mode_change;
mod present;
mod settings;
mod size;
mod standstill;
mod stepping;
mod stop;
mod switch;

pub use settings::{Fesd, StepFormulation};
pub use size::{FormulationSize, step_sizes};

use super::hand_over::{self, Other};
use super::joints::Closed;
use super::watch::Watch;
use super::{
    InitialValueProblem, InputError, Simulation, SimulationStatus, Simulator, event, impulse,
    order_of_impacts, shared_load,
};
use crate::Observer;
use crate::model::Model;
use crate::yardstick;

const OTHER: Other = Other {
    failed: "finite elements",
    takes_over: "the event-driven method",
};

/// Whether a run may have ended for a reason of its elements, or of the impacts that it joins. A gap that leaps has none of it, but is asked for again as well:
/// the event-driven method sees it too.
fn may_be_its_own(status: &SimulationStatus) -> bool {
    use SimulationStatus::{AmbiguousContact, Inaccurate, NotFinite, StepFailed, StepLimit};
    matches!(
        status,
        AmbiguousContact(_) | Inaccurate(_) | NotFinite(_) | StepFailed(_) | StepLimit(_)
    )
}

impl Simulator for Fesd {
    fn name(&self) -> &'static str {
        "fesd"
    }

    fn simulate(
        &self,
        model: &dyn Model,
        problem: &InitialValueProblem,
        observer: &mut Observer<'_>,
    ) -> Result<Simulation, InputError> {
        let tableau = self.tableau()?;
        let closed = Closed::of(model, problem)?;
        let (model, problem) = closed.scene();
        if self.formulation != StepFormulation::ActiveSet {
            let formulation = "the time-freezing formulation";
            let remedy = "use the active-set formulation";
            InitialValueProblem::check_resets(model, formulation, remedy)?;
            InitialValueProblem::check_friction(model, formulation, remedy)?;
        }
        let mut watch = Watch::new(problem, observer);
        let mut result = match self.promise() {
            Some(promise) => {
                let run = accuracy::promised(self, promise, &tableau, (model, problem), &mut watch);
                let named = run.counts.elements >= self.most_elements;
                let asked = self.hands_over && self.formulation == StepFormulation::ActiveSet;
                if named || !asked {
                    run
                } else {
                    hand_over::unless_solved(run, may_be_its_own, &OTHER, &mut watch, |watch| {
                        event::simulate_instead((promise, self.max_step), (model, problem), watch)
                    })
                }
            }
            None if self.steps.is_none() => {
                let promise = self.tolerance.unwrap_or(yardstick::PROMISE);
                accuracy::compared(self, promise, &tableau, (model, problem), &mut watch)
            }
            None => estimate::estimated(self, &tableau, (model, problem), &mut watch),
        };
        impulse::record(model, &mut result);
        shared_load::record(model, &mut result);
        order_of_impacts::note(model, &mut result);
        watch.finish(model, &mut result);
        closed.finish(&mut result);
        Ok(result)
    }

    fn set_tolerance(&mut self, tolerance: f64) -> Result<(), InputError> {
        self.tolerance = Some(tolerance);
        Ok(())
    }

    fn set_max_step(&mut self, seconds: f64) -> Result<(), InputError> {
        self.max_step = Some(seconds);
        self.tableau().map(|_| ())
    }

    fn set_steps(&mut self, steps: usize) -> Result<(), InputError> {
        self.steps = Some(steps);
        Ok(())
    }
}
