//! Event-driven simulation; see [`EventDriven`].
//!
//! `integration` is the loop of steps and events; `dynamics` evaluates the constrained motion of one contact
//! mode, `dop853` integrates it (`error_scale` says how accurately, `forces` what acts), `search` finds where the
//! mode ends, `here` tells `run` of the instant there, `contact_mode` (with `contact_problem`, by the laws of `contact`) what follows, `audit`
//! judges its conditions, `diagnosis` says why a run ends early, `ending` which impacts belong to its end. `accuracy` compares two
//! runs.

mod accuracy;
mod audit;
pub(super) mod contact_mode;
pub(super) mod contact_problem;
mod diagnosis;
pub(super) mod dop853;
pub(super) mod dynamics;
mod ending;
mod error_scale;
mod forces;
pub(super) mod here;
mod integration;
mod search;
mod settings;
mod tableau;

pub(crate) use ending::Ending;
pub use settings::EventDriven;

use integration::Integration;

use super::explicit_time::ExplicitTime;
use super::joints::Closed;
use super::watch::Watch;
use super::{
    InitialValueProblem, InputError, Simulation, Simulator, impulse, order_of_impacts, shared_load,
};
use crate::model::{Model, held};
use crate::refusal;
use crate::{Observer, Progress};

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
        let closed = Closed::of(model, problem)?;
        let (model, problem) = closed.scene();
        check(self, model, problem)?;
        let mut watch = Watch::new(problem, observer);
        let mut result = accuracy::promised(self, (model, problem), &mut watch);
        impulse::record(model, &mut result);
        shared_load::record(model, &mut result);
        order_of_impacts::note(model, &mut result);
        watch.finish(model, &mut result);
        closed.finish(&mut result);
        Ok(result)
    }

    fn set_tolerance(&mut self, tolerance: f64) -> Result<(), InputError> {
        self.tolerance = tolerance;
        Ok(())
    }

    fn set_max_step(&mut self, seconds: f64) -> Result<(), InputError> {
        self.max_step = Some(seconds);
        self.check()
    }
}

/// Simulates once, without the second run that confirms the first: for motions that are judged otherwise.
///
/// # Errors
/// [`InputError`] if the problem or the method's settings are refused.
pub(crate) fn simulate_once(
    settings: &EventDriven,
    model: &dyn Model,
    problem: &InitialValueProblem,
) -> Result<Simulation, InputError> {
    simulate_to(settings, model, problem, None)
}

/// Simulates once a motion whose `ending` may be known.
///
/// # Errors
/// [`InputError`] if the problem or the method's settings are refused.
pub(crate) fn simulate_to(
    settings: &EventDriven,
    model: &dyn Model,
    problem: &InitialValueProblem,
    ending: Option<Ending>,
) -> Result<Simulation, InputError> {
    let closed = Closed::of(model, problem)?;
    let (model, problem) = closed.scene();
    check(settings, model, problem)?;
    let own = held::with_laws(model, &problem.q);
    let model = own.as_deref().unwrap_or(model);
    let mut unseen = |_: &Progress| true;
    let mut watch = Watch::new(problem, &mut unseen);
    let time = ExplicitTime::of(model, problem);
    let mut result = Integration::new(settings, model, problem, time).run(&mut watch, ending);
    impulse::record(model, &mut result);
    watch.finish(model, &mut result);
    closed.finish(&mut result);
    Ok(result)
}

/// The motion with at most the error `promise` and steps of at most `max_step` \[s\], where another method that promises as much fails.
pub(super) fn simulate_instead(
    (promise, max_step): (f64, Option<f64>),
    scene: (&dyn Model, &InitialValueProblem),
    watch: &mut Watch<'_>,
) -> Simulation {
    let settings = EventDriven::default();
    let tolerance = settings.tolerance.min(accuracy::tolerance(promise));
    accuracy::promised(
        &EventDriven {
            tolerance,
            max_step,
            ..settings
        },
        scene,
        watch,
    )
}

/// Simulates to check another method's run, under its observer, which does not see the time.
pub(super) fn simulate_to_check(
    tolerance: f64,
    (model, problem): (&dyn Model, &InitialValueProblem),
    watch: &mut Watch<'_>,
) -> Simulation {
    watch.restart(false);
    let settings = EventDriven {
        tolerance,
        ..EventDriven::default()
    };
    let explicit_time = ExplicitTime::of(model, problem);
    Integration::new(&settings, model, problem, explicit_time).run(watch, None)
}

fn check(
    settings: &EventDriven,
    model: &dyn Model,
    problem: &InitialValueProblem,
) -> Result<(), InputError> {
    settings.check()?;
    problem.check(model)?;
    if settings.output_times > problem.points {
        return Err(refusal::out_of_range(
            "output times",
            settings.output_times as f64,
            "",
            format!(
                "at most {}; raise `points` of the problem in Rust for more",
                problem.points
            ),
        ));
    }
    Ok(())
}
