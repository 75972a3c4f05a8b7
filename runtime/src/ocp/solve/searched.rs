//! Which search looks for a motion.

use super::{freezing, known, words};
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
    match (&settings.formulation, &settings.guess) {
        (Formulation::TimeFreezing(formulation), _) => {
            freezing::solve(model, problem, settings, formulation, observer)
        }
        (Formulation::Phases, Guess::Previous(previous)) => {
            known::solve(model, problem, settings, previous, observer)
        }
        (Formulation::Phases, _) => words::solve(model, problem, settings, observer),
    }
}
