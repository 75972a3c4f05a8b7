//! The error of a run on a grid that was asked for, by a run on another one.
//!
//! The sum of the errors of the elements knows nothing of what the motion makes of them: bounces multiply them, and a
//! switch that was missed changes everything after it. The distance to a run on a coarser grid contains both, and for a
//! scheme of order `p` it is about `2^p` times the error.

use super::driver::Driver;
use super::settings::Fesd;
use super::stepping::{self, SUSPECT_ESTIMATE};
use crate::model::Model;
use crate::rk::ButcherTableau;
use crate::simulation::agreement::{Comparison, Spent};
use crate::simulation::watch::Watch;
use crate::simulation::{InitialValueProblem, Simulation, SimulationStatus};

/// Simulates on the grid of the `settings`; the error estimate is the distance to a run on half as many elements or, where
/// that fails, twice as many.
pub(super) fn estimated(
    settings: &Fesd,
    tableau: &ButcherTableau,
    (model, problem): (&dyn Model, &InitialValueProblem),
    watch: &mut Watch<'_>,
) -> Simulation {
    let mut spent = Spent::default();
    let mut other = |grid: Fesd, watch: &mut Watch<'_>| {
        watch.restart(false);
        let driver = Driver::new(&grid, tableau, model, problem).forgetful();
        let run = stepping::run(driver, watch);
        spent.add(&run);
        run
    };
    let failed = |run: &Simulation| {
        !run.status.is_solved() && !matches!(run.status, SimulationStatus::Interrupted(_))
    };
    let coarse = coarser(settings).map(|grid| other(grid, watch));
    let compared = match coarse {
        Some(run) if !failed(&run) => run,
        _ => other(finer(settings), watch),
    };
    if matches!(compared.status, SimulationStatus::Interrupted(_)) {
        return spent.charge(compared);
    }
    watch.restart(true);
    let mut run = stepping::run(Driver::new(settings, tableau, model, problem), watch);
    spent.add(&run);
    if run.status.is_solved() && compared.status.is_solved() {
        let said = run.error_estimate.map(stepping::suspicion);
        let promise = f64::INFINITY;
        let apart = Comparison::of(&compared, &mut run, (model, problem), promise).error;
        run.notes.retain(|note| Some(note) != said.as_ref());
        if apart > SUSPECT_ESTIMATE {
            run.notes.push(stepping::suspicion(apart));
        }
    }
    spent.charge(run)
}

/// Half as many elements, by fewer steps or else by fewer elements of each; none where there is one element.
fn coarser(settings: &Fesd) -> Option<Fesd> {
    let steps = settings.steps.unwrap_or(Fesd::DEFAULT_STEPS);
    let (steps, elements) = match (steps, settings.elements) {
        (1, 1) => return None,
        (1, elements) => (1, elements.div_ceil(2)),
        (steps, elements) => (steps.div_ceil(2), elements),
    };
    Some(settings.clone().with_grid(steps, elements))
}

/// Twice as many elements.
fn finer(settings: &Fesd) -> Fesd {
    let steps = settings.steps.unwrap_or(Fesd::DEFAULT_STEPS);
    let mut grid = settings.clone().with_grid(steps, 2 * settings.elements);
    grid.most_elements = 2 * settings.most_elements;
    grid
}
