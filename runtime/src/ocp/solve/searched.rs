//! Which search looks for a motion.

use super::{nested, starts, undriven, words};
use crate::Observer;
use crate::model::Model;
use crate::ocp::problem::Problem;
use crate::ocp::settings::{Formulation, Guess, Settings};
use crate::ocp::solution::Solution;
use crate::simulation::InputError;

/// Looks for a motion in the way that the settings ask for.
pub(super) fn searched(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    let search = matches!(settings.formulation, Formulation::Phases)
        && !matches!(settings.guess, Guess::Previous(_));
    if search && problem.intervals > 1 && model.declaration().controls.is_empty() {
        undriven::solve(model, problem, settings, observer)
    } else if search && settings.searches_words() {
        words::solve(model, problem, settings, observer)
    } else if search {
        nested::solve(model, problem, settings, observer)
    } else {
        starts::solve(model, problem, settings, observer)
    }
}
