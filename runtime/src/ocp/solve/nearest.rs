//! What is hardest to meet in a problem without a motion, as simulated motions tell it.

use crate::model::Model;
use crate::ocp::collocation::discretization::{Setting, parabolas};
use crate::ocp::global::guess::guess;
use crate::ocp::misses::Nearest;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::{Problem, bounds};
use crate::ocp::program::units::Units;
use crate::ocp::scale::Scale;
use crate::ocp::search::nearest;
use crate::ocp::settings::{Guess, Settings};
use crate::rk::{ButcherTableau, Scheme};
use crate::simulation::InputError;

/// The simulated motion that comes nearest to the goals of the problem.
pub(super) fn nearest(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
) -> Result<Option<Nearest>, InputError> {
    on_straight(model, problem, settings, |setting, _| {
        nearest::nearest(setting)
    })
}

/// A look at a problem in the units of the straight motion, which is handed over.
pub(super) fn on_straight<T>(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    look: impl FnOnce(Setting, &Trajectory) -> Result<T, InputError>,
) -> Result<T, InputError> {
    let (lower, upper) = bounds(model);
    let bounds = (&lower[..], &upper[..]);
    let straight = guess(model, problem, &Guess::Straight, bounds)?;
    let tableau = ButcherTableau::new(Scheme::RadauIia, settings.stages);
    let tableau = tableau.ok_or_else(|| settings.refuse_stages())?;
    let units = Units::new(model, &Scale::of(model, problem), &straight, bounds);
    let parabolas = parabolas(model, &problem.start());
    let scene = (model, problem);
    let with = (&tableau, &units);
    look(
        Setting::new(scene, settings, with, (bounds, &parabolas)),
        &straight,
    )
}
