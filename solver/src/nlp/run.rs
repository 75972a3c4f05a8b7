//! One run: from the user's problem to the loop and back.

use super::method::barrier::BarrierPath;
use super::method::{self, Core};
use super::program::formulation::Formulation;
use super::result::solution;
use super::{Fault, InputError, NlpProblem, Observer, Products, Settings, Solution, WarmStart};

/// Solves a nonlinear program with product constraints whose `sigma` the path moves.
pub(crate) fn run<'o>(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    products: &mut Products,
    path: &mut dyn BarrierPath,
    start: Option<&WarmStart>,
    observer: Option<&'o mut Observer<'o>>,
) -> Result<Solution, InputError> {
    let tied = (products, path);
    let start = Start::of(start);
    run_after(problem, settings, tied, start, observer, None).map(|(solution, _)| solution)
}

/// What a solution does not say of its run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ended {
    /// Scale of the objective.
    pub(super) scale: f64,
    /// Whether it gave up where a Newton step is shorter than 1e-8 of the point: the solution but for rounding.
    pub(super) is_close: bool,
}

/// Where a run starts.
#[derive(Debug, Clone, Copy)]
pub(super) enum Start<'s> {
    /// At the point of the problem.
    Own,
    /// At another point.
    Point(&'s [f64]),
    /// At a point with multipliers.
    Warm(&'s WarmStart),
}

impl<'s> Start<'s> {
    pub(super) fn of(start: Option<&'s WarmStart>) -> Self {
        start.map_or(Self::Own, Self::Warm)
    }
}

/// A run that goes on counting where the run `earlier` stopped.
pub(super) fn run_after<'o>(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    (products, path): (&mut Products, &mut dyn BarrierPath),
    start: Start<'_>,
    observer: Option<&'o mut Observer<'o>>,
    earlier: Option<Solution>,
) -> Result<(Solution, Ended), InputError> {
    let (point, start) = match start {
        Start::Own => (None, None),
        Start::Point(x) => (Some(x), None),
        Start::Warm(start) => (Some(&start.x[..]), Some(start)),
    };
    if let Some(start) = start {
        check_warm_start(problem, start)?;
    }
    settings.validate()?;
    let unit = settings.objective_unit.unwrap_or(1.0);
    let formulation = Formulation::new(problem, &products.pairs, point, unit)?;
    let scale = formulation.objective_scale;
    let mut core = Core::new(formulation, settings, observer)?;
    if let Some(earlier) = earlier {
        core.go_on_after(earlier);
    }
    let end = method::run(&mut core, path, start, products)?;
    products.sigma = end.sigma;
    let is_close = core.is_close;
    let ended = Ended { scale, is_close };
    Ok((solution(core, &end, products), ended))
}

/// Steps of the variables from a solution to the end of its central path, where the barrier parameter is zero, to first order, and
/// the factorizations that they took. A variable at a bound with a positive multiplier goes all its distance; where the multiplier
/// vanishes as well, half of it; one that ends inside its bounds stays (El-Bakry, Tapia and Zhang, SIAM Review 36, 1994). `None` where the path is not that of a convex neighbourhood.
pub(crate) fn end_of_path(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    point: &WarmStart,
) -> (Option<Vec<f64>>, usize) {
    let settings = Settings {
        bound_push: f64::MIN_POSITIVE,
        bound_fraction: f64::MIN_POSITIVE,
        ..settings.clone()
    };
    let unit = settings.objective_unit.unwrap_or(1.0);
    let formulation = Formulation::new(problem, &[], Some(&point.x), unit);
    let core = formulation.and_then(|formulation| Core::new(formulation, &settings, None));
    core.map_or((None, 0), |mut core| {
        let steps = method::end_of_path(&mut core, point);
        (steps, core.kkt.factorizations)
    })
}

fn check_warm_start(problem: &dyn NlpProblem, start: &WarmStart) -> Result<(), InputError> {
    let (n, m) = (problem.variables(), problem.constraints());
    for (what, expected, found) in [
        ("the constraint multipliers", m, start.multipliers.len()),
        ("the lower multipliers", n, start.multipliers_lower.len()),
        ("the upper multipliers", n, start.multipliers_upper.len()),
    ] {
        if expected != found {
            return Err(InputError::from(Fault::WarmStart {
                what,
                expected,
                found,
            }));
        }
    }
    Ok(())
}
