//! What the methods to compare with have in common.

use hangtime_solver::clock::ThreadTime;

use crate::Observer;
use crate::model::Model;
use crate::refusal;
use crate::simulation::event::dynamics::Dynamics;
use crate::simulation::other_grid::{self, Judge, OtherGrid};
use crate::simulation::watch::Watch;
use crate::simulation::{Diagnosis, InitialValueProblem, InputError, Simulation, SimulationStatus};

/// Checks the settings that these methods share.
pub(super) fn check(steps: usize, auxiliary_acceleration: f64) -> Result<(), InputError> {
    let refuse = |what: &str, value: f64, unit: &str, bound: &str| {
        Err(refusal::out_of_range(what, value, unit, bound))
    };
    if steps == 0 {
        return refuse("number of steps", 0.0, "", "at least 1");
    }
    if auxiliary_acceleration <= 0.0 || !auxiliary_acceleration.is_finite() {
        return refuse(
            "auxiliary acceleration",
            auxiliary_acceleration,
            "m/s^2",
            "above 0 and finite",
        );
    }
    Ok(())
}

/// Refuses to go on where a gap at the state that `dynamics` has loaded is not a number: nothing can be closed there.
pub(super) fn check_gaps(
    dynamics: &Dynamics<'_>,
    time: f64,
    step: usize,
) -> Result<(), SimulationStatus> {
    let Some(contact) = (0..dynamics.contacts).find(|&i| !dynamics.gap(i).is_finite()) else {
        return Ok(());
    };
    let name = dynamics.model.declaration().contacts[contact].name;
    Err(SimulationStatus::NotFinite(Diagnosis {
        time,
        step,
        contact: Some(contact),
        message: format!(
            "the gap of `{name}` is not a finite number; check roots, divisions and parameters of the scene"
        ),
    }))
}

/// A run, after those on `others` by which its error is measured, with the CPU time of all; `remedy` is said where the error is large.
pub(super) fn judged<M>(
    (asked, others): (&M, impl IntoIterator<Item = OtherGrid<M>>),
    remedy: &'static str,
    (model, problem): (&dyn Model, &InitialValueProblem),
    observer: &mut Observer<'_>,
    run: impl Fn(&M, &mut Watch<'_>) -> Simulation,
) -> Simulation {
    let clock = ThreadTime::try_now();
    let mut watch = Watch::new(problem, observer);
    let judge = Judge {
        remedy,
        locates: false,
    };
    let scene = (model, problem);
    let mut result = other_grid::estimated(asked, others, &judge, scene, &mut watch, run);
    watch.finish(model, &mut result);
    if let Ok(elapsed) = clock.and_then(|clock| clock.try_elapsed()) {
        result.seconds.total = elapsed.as_secs_f64();
    }
    result
}
