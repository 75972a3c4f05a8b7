//! How large the programs of a problem are, before any is solved.

use super::collocation::discretization::{Setting, parabolas};
use super::collocation::transcribe::transcribe;
use super::global::guess::guess;
use super::global::start_modes::modes_at_start;
use super::global::time_freezing::TimeFreezing;
use super::joined::joined;
use super::motion::candidate::Candidate;
use super::motion::passages::with_passages;
use super::motion::sequence::Sequence;
use super::problem::{Problem, bounds};
use super::program::units::Units;
use super::scale::Scale;
use super::search::replay::simulated;
use super::settings::{Formulation, Settings, TimeFreezingSettings};
use super::struck::after_impact;
use super::unknown::with_unknowns;
use crate::model::Model;
use crate::rk::{ButcherTableau, Scheme};
use crate::simulation::{FormulationSize, InputError, ProblemSize};

/// The size of the program that [`solve`](super::solve) makes of a problem under `settings`: the collocation with the contact
/// sequence of the ride without controls, or the program of the time-freezing formulation.
///
/// # Errors
/// [`InputError`] if problem or settings are refused.
///
/// # Examples
/// ```
/// use hangtime::ocp::{Problem, Settings, program_size};
/// # hangtime::model! {
/// #     /// A cart that is pushed.
/// #     pub Cart {
/// #         parameters { m: kg = 2 }
/// #         coordinates { y: m }
/// #         controls { u: N in -1..=1 }
/// #         lagrangian m/2*dot(y)^2
/// #         forces { y: u }
/// #         minimize time
/// #         finally { y == 1[m] }
/// #     }
/// # }
/// let cart = Cart::default();
/// let own = program_size(&cart, &Problem::of(&cart, 4), &Settings::default())?;
/// // Four stages with (y, v) in each interval, its control, and the final time.
/// assert_eq!(own.size.variables, 4 * (4 * 2 + 1) + 1);
/// # Ok::<(), hangtime::InputError>(())
/// ```
pub fn program_size(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
) -> Result<FormulationSize, InputError> {
    settings.check()?;
    let unknown = with_unknowns(model, problem, settings)?;
    let (model, problem) = match &unknown {
        Some(unknown) => (&unknown.model as &dyn Model, &unknown.problem),
        None => (model, problem),
    };
    let known = joined(model, problem)?;
    let (model, problem) = match &known {
        Some(known) => (&*known.model, &known.problem),
        None => (model, problem),
    };
    let struck = after_impact(model, problem);
    let problem = struck.as_ref().map_or(problem, |known| &known.problem);
    problem.check(model)?;
    match &settings.formulation {
        Formulation::Phases => phases(model, problem, settings),
        Formulation::TimeFreezing(settings) => time_freezing(model, problem, settings),
    }
}

fn time_freezing(
    model: &dyn Model,
    problem: &Problem,
    settings: &TimeFreezingSettings,
) -> Result<FormulationSize, InputError> {
    let program = TimeFreezing::new(model, problem, settings)?;
    Ok(FormulationSize {
        formulation: "optimal control, time-freezing program".to_owned(),
        discretization: format!(
            "{}, {} stages, {} intervals x {} elements",
            settings.scheme.name(),
            settings.stages,
            problem.intervals,
            settings.elements_of(model)
        ),
        size: ProblemSize::of(&program),
    })
}

fn phases(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
) -> Result<FormulationSize, InputError> {
    let (lower, upper) = bounds(model);
    let bounds = (&lower[..], &upper[..]);
    let guessed = guess(model, problem, &settings.guess, bounds)?;
    let units = Units::new(model, &Scale::of(model, problem), &guessed, bounds);
    let Some(tableau) = ButcherTableau::new(Scheme::RadauIia, settings.stages) else {
        return Err(settings.refuse_stages());
    };
    let parabolas = parabolas(model, &problem.start());
    let scene = (model, problem);
    let setting = Setting::new(scene, settings, (&tableau, &units), (bounds, &parabolas));
    let ridden = simulated(setting, &guessed, settings.replay_tolerance)?;
    let sequence = Sequence::without_switches(modes_at_start(setting, &guessed));
    let sequence = with_passages(model, sequence, &guessed, false);
    let candidate = ridden.unwrap_or(Candidate {
        objective: f64::INFINITY,
        sequence,
        trajectory: guessed,
    });
    let (sequence, motion) = (&candidate.sequence, &candidate.trajectory);
    let elements = vec![settings.elements; problem.intervals];
    let fine = transcribe(setting, sequence, motion, &[], &elements);
    Ok(FormulationSize {
        formulation: "optimal control, collocation".to_owned(),
        discretization: format!(
            "{}, {} stages, {} intervals x {} elements, {} contact switches as in the ride",
            Scheme::RadauIia.name(),
            settings.stages,
            problem.intervals,
            settings.elements,
            sequence.switches.len()
        ),
        size: ProblemSize::of(&fine.program),
    })
}
