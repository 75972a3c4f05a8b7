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
    run_after(problem, settings, tied, start, observer, None).map(|(solution, _)| solution)
}

/// A run, and the scale of the objective in it, that goes on counting where the run `earlier` stopped.
pub(super) fn run_after<'o>(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    (products, path): (&mut Products, &mut dyn BarrierPath),
    start: Option<&WarmStart>,
    observer: Option<&'o mut Observer<'o>>,
    earlier: Option<Solution>,
) -> Result<(Solution, f64), InputError> {
    if let Some(start) = start {
        check_warm_start(problem, start)?;
    }
    settings.validate()?;
    let point = start.map(|s| &s.x[..]);
    let formulation = Formulation::new(problem, &products.pairs, point)?;
    let scale = formulation.objective_scale;
    let mut core = Core::new(formulation, settings, observer)?;
    if let Some(earlier) = earlier {
        core.go_on_after(earlier);
    }
    let end = method::run(&mut core, path, start, products)?;
    products.sigma = end.sigma;
    Ok((solution(core, &end, products), scale))
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
