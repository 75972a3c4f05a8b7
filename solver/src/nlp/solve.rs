//! Entry points: from the user's problem to the loop and back.

use super::method::barrier::{BarrierPath, Monotone};
use super::method::{self, Core};
use super::program::formulation::Formulation;
use super::rescaled::rescaled;
use super::result::solution;
use super::{
    Fault, InputError, IterationInfo, NlpProblem, Observer, Products, Settings, Solution, WarmStart,
};

/// Solves a nonlinear program from its own starting point.
///
/// The method is the primal-dual interior point method with a filter line search of Waechter and
/// Biegler (Mathematical Programming 106, 2006): barrier problems
/// `min f(x) - mu sum log(x - x_l) - ...` are solved by Newton's method with inertia correction,
/// second-order correction and a restoration phase, while `mu` goes to zero.
///
/// # Errors
/// [`InputError`] when the input is wrong; whatever happens after the first iteration is a
/// [`Status`](super::Status) of the solution.
///
/// # Examples
/// Minimize `(x_0 - 2)^2 + x_1^2` subject to `x_0 + x_1 = 1`, `x_0 <= 0.75`:
///
/// ```
/// use hangtime_solver::nlp::{self, NlpProblem, Settings};
///
/// struct Problem;
///
/// impl NlpProblem for Problem {
///     fn variables(&self) -> usize { 2 }
///     fn constraints(&self) -> usize { 1 }
///     fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
///         lower.fill(f64::NEG_INFINITY);
///         upper.copy_from_slice(&[0.75, f64::INFINITY]);
///     }
///     fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
///         lower[0] = 1.0;
///         upper[0] = 1.0;
///     }
///     fn initial_point(&self, x: &mut [f64]) { x.fill(0.0); }
///     fn objective(&mut self, x: &[f64]) -> f64 { (x[0] - 2.0).powi(2) + x[1] * x[1] }
///     fn gradient(&mut self, x: &[f64], g: &mut [f64]) {
///         g.copy_from_slice(&[2.0 * (x[0] - 2.0), 2.0 * x[1]]);
///     }
///     fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) { c[0] = x[0] + x[1]; }
///     fn jacobian_pattern(&self) -> Vec<(usize, usize)> { vec![(0, 0), (0, 1)] }
///     fn jacobian_values(&mut self, _: &[f64], values: &mut [f64]) { values.fill(1.0); }
///     fn hessian_pattern(&self) -> Vec<(usize, usize)> { vec![(0, 0), (1, 1)] }
///     fn hessian_values(&mut self, _: &[f64], weight: f64, _: &[f64], values: &mut [f64]) {
///         values.fill(2.0 * weight);
///     }
/// }
///
/// let solution = nlp::solve(&mut Problem, &Settings::default())?;
/// assert!(solution.status.is_solved());
/// assert!((solution.x[0] - 0.75).abs() < 1e-6);
/// # Ok::<(), hangtime_solver::nlp::InputError>(())
/// ```
pub fn solve(problem: &mut dyn NlpProblem, settings: &Settings) -> Result<Solution, InputError> {
    solve_from(problem, settings, None, None)
}

/// As [`solve`], from a point with multipliers, with an observer that sees each line of the log and can
/// stop the run.
///
/// A warm start keeps multipliers and barrier parameter; the point is pushed off its bounds by
/// [`Settings::bound_push`], so a small value there belongs to it.
///
/// # Errors
/// As [`solve`].
///
/// # Examples
/// ```
/// # use hangtime_solver::nlp::NlpProblem;
/// # #[derive(Clone)]
/// # struct Problem;
/// # impl NlpProblem for Problem {
/// #     fn variables(&self) -> usize { 2 }
/// #     fn constraints(&self) -> usize { 1 }
/// #     fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) { lower.fill(0.0); upper.fill(f64::INFINITY); }
/// #     fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) { lower[0] = 1.0; upper[0] = 1.0; }
/// #     fn initial_point(&self, x: &mut [f64]) { x.fill(0.5); }
/// #     fn objective(&mut self, x: &[f64]) -> f64 { x[0] * x[0] + 2.0 * x[1] * x[1] }
/// #     fn gradient(&mut self, x: &[f64], g: &mut [f64]) { g[0] = 2.0 * x[0]; g[1] = 4.0 * x[1]; }
/// #     fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) { c[0] = x[0] + x[1]; }
/// #     fn jacobian_pattern(&self) -> Vec<(usize, usize)> { vec![(0, 0), (0, 1)] }
/// #     fn jacobian_values(&mut self, _: &[f64], values: &mut [f64]) { values.fill(1.0); }
/// #     fn hessian_pattern(&self) -> Vec<(usize, usize)> { vec![(0, 0), (1, 1)] }
/// #     fn hessian_values(&mut self, _: &[f64], weight: f64, _: &[f64], values: &mut [f64]) {
/// #         values[0] = 2.0 * weight;
/// #         values[1] = 4.0 * weight;
/// #     }
/// # }
/// use hangtime_solver::nlp::{self, Settings, WarmStart};
///
/// let first = nlp::solve(&mut Problem, &Settings::default())?;
/// let mut settings = Settings::default();
/// settings.bound_push = 1e-9;
/// settings.bound_fraction = 1e-9;
/// let mut lines = 0;
/// let mut observer = |info: &nlp::IterationInfo| {
///     lines += 1;
///     info.iteration < 100
/// };
/// let start = WarmStart::from_solution(&first);
/// let again = nlp::solve_from(&mut Problem, &settings, Some(&start), Some(&mut observer))?;
/// assert!(again.status.is_solved());
/// assert!(again.counts.iterations <= first.counts.iterations);
/// assert_eq!(lines, again.history.len());
/// # Ok::<(), nlp::InputError>(())
/// ```
pub fn solve_from<'o>(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    start: Option<&WarmStart>,
    observer: Option<&'o mut Observer<'o>>,
) -> Result<Solution, InputError> {
    let mut path = Monotone {
        mu: start.map_or(settings.initial_barrier_parameter, |s| s.barrier_parameter),
        sigma: 0.0,
        tolerance: settings.tolerance,
    };
    let mut observer = observer;
    let mut see = |info: &IterationInfo| match &mut observer {
        Some(observer) => observer(info),
        None => true,
    };
    let none = &mut Products::default();
    let first = run_after(
        problem,
        settings,
        (none, &mut path),
        start,
        Some(&mut see),
        None,
    )?;
    Ok(rescaled(problem, settings, &mut see, first))
}

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
