//! What is hardest to meet in a problem without a motion, as simulated motions tell it.

use crate::model::Model;
use crate::ocp::collocation::discretization::{Lengths, Places, Setting, parabolas};
use crate::ocp::global::guess::guess;
use crate::ocp::problem::{Problem, bounds};
use crate::ocp::program::units::Units;
use crate::ocp::search::nearest;
use crate::ocp::settings::{Guess, Settings};
use crate::ocp::solution::Nearest;
use crate::rk::{ButcherTableau, Scheme};
use crate::simulation::InputError;

/// The simulated motion that comes nearest to the goals of the problem.
pub(super) fn nearest(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
) -> Result<Option<Nearest>, InputError> {
    let (lower, upper) = bounds(model);
    let bounds = (&lower[..], &upper[..]);
    let guessed = guess(model, problem, &Guess::Straight, bounds)?;
    let tableau = ButcherTableau::new(Scheme::RadauIia, settings.stages);
    nearest::nearest(Setting {
        model,
        problem,
        tableau: &tableau.ok_or_else(|| settings.refuse_stages())?,
        units: &Units::new(model, &guessed, bounds),
        bounds,
        parabolas: &parabolas(model, &problem.start()),
        places: Places {
            bounds_at_nodes: settings.bounds_at_nodes,
            path: settings.path_points,
        },
        shape: settings.controls,
        lengths: Lengths::Equal,
        kept: 1.0,
    })
}
