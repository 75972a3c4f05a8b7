//! Runs on a grid that was asked for, with their error.

use super::driver::Driver;
use super::settings::Fesd;
use super::stepping;
use crate::model::Model;
use crate::rk::ButcherTableau;
use crate::simulation::other_grid::{self, Judge, OtherGrid, other_steps};
use crate::simulation::watch::Watch;
use crate::simulation::{InitialValueProblem, Simulation};

/// Simulates on the grid of the `settings`; the error estimate is the distance to a run on half as many elements or, where
/// that fails, twice as many.
pub(super) fn estimated(
    settings: &Fesd,
    tableau: &ButcherTableau,
    (model, problem): (&dyn Model, &InitialValueProblem),
    watch: &mut Watch<'_>,
) -> Simulation {
    let judge = Judge {
        remedy: "take more steps, or leave the number of steps to the error control",
        locates: true,
    };
    let others = coarser(settings).into_iter().chain([finer(settings)]);
    let run = |grid: &Fesd, watch: &mut Watch<'_>| {
        let driver = Driver::new(grid, tableau, model, problem);
        stepping::run(driver, watch)
    };
    other_grid::estimated(settings, others, &judge, (model, problem), watch, run)
}

/// Half as many elements, by fewer steps or else by fewer elements of each; `None` where there is one element.
fn coarser(settings: &Fesd) -> Option<OtherGrid<Fesd>> {
    let steps = settings.steps.unwrap_or(Fesd::DEFAULT_STEPS);
    let (steps, elements, words) = match (steps, settings.elements) {
        (1, 1) => return None,
        (1, elements) => (1, elements.div_ceil(2), "half the elements"),
        (steps, elements) => {
            let (steps, words) = other_steps(steps);
            (steps, elements, words)
        }
    };
    Some(OtherGrid {
        method: settings.clone().with_grid(steps, elements),
        words,
    })
}

/// Twice as many elements.
fn finer(settings: &Fesd) -> OtherGrid<Fesd> {
    let steps = settings.steps.unwrap_or(Fesd::DEFAULT_STEPS);
    let mut grid = settings.clone().with_grid(steps, 2 * settings.elements);
    grid.most_elements = 2 * settings.most_elements;
    OtherGrid {
        method: grid,
        words: "twice the elements",
    }
}
