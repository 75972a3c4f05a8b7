//! Entry points.

use super::method::barrier::Monotone;
use super::objective_unit::measured;
use super::rescaled::rescaled;
use super::run::{Start, run_after};
use super::second_round::second_round;
use super::{
    InputError, IterationInfo, NlpProblem, Observer, Products, Settings, Solution, WarmStart,
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
    let in_unit = measured(problem, settings, start.map(|start| &start.x[..]));
    let first = run_after(
        problem,
        &in_unit,
        (none, &mut path),
        Start::of(start),
        Some(&mut see),
        None,
    )?;
    let first = rescaled(problem, settings, &mut see, first);
    // a start with multipliers was chosen with care
    if start.is_some() || !settings.persistent {
        return Ok(first);
    }
    Ok(second_round(problem, settings, &mut see, first))
}
