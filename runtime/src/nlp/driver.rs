//! Entry points: from the user's problem to the loop and back.

use super::barrier::{BarrierPath, Monotone};
use super::barrier_problem::BarrierProblem;
use super::formulation::Formulation;
use super::iterate::Iterate;
use super::scaling::interior;
use super::solution::diagnose;
use super::solver::{Core, Loop, Observer, Outcome};
use super::{InputError, NlpProblem, Residuals, Settings, Solution, Status};

/// A point with multipliers to start from, for instance those of an earlier [`Solution`].
#[derive(Debug, Clone, PartialEq)]
pub struct WarmStart {
    /// The point, length `n`.
    pub x: Vec<f64>,
    /// Multipliers of the constraints, length `m`.
    pub multipliers: Vec<f64>,
    /// Multipliers of the lower bounds, length `n`.
    pub multipliers_lower: Vec<f64>,
    /// Multipliers of the upper bounds, length `n`.
    pub multipliers_upper: Vec<f64>,
    /// First barrier parameter; the nearer the point, the smaller.
    pub barrier_parameter: f64,
}

impl WarmStart {
    /// Everything from a solution, with its barrier parameter.
    pub fn from_solution(solution: &Solution) -> Self {
        Self {
            x: solution.x.clone(),
            multipliers: solution.multipliers.clone(),
            multipliers_lower: solution.multipliers_lower.clone(),
            multipliers_upper: solution.multipliers_upper.clone(),
            barrier_parameter: solution.barrier_parameter,
        }
    }
}

/// Product constraints `x_i x_j <= sigma` that a run carries along, and what became of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Products {
    pub(crate) pairs: Vec<(usize, usize)>,
    /// Multiplier of each product, in the order of the pairs; 0 where a variable is fixed. On entry of
    /// a warm start those to begin with.
    pub(crate) multipliers: Vec<f64>,
    /// `sigma` at the end.
    pub(crate) sigma: f64,
}

/// Solves a nonlinear program from its own starting point.
///
/// The method is the primal-dual interior point method with a filter line search of Waechter and
/// Biegler (Mathematical Programming 106, 2006): barrier problems
/// `min f(x) - mu sum log(x - x_l) - ...` are solved by Newton's method with inertia correction,
/// second-order correction and a restoration phase, while `mu` goes to zero.
///
/// # Errors
/// [`InputError`] when the input is wrong; whatever happens after the first iteration is a
/// [`Status`] of the solution.
///
/// # Examples
/// Minimize `(x_0 - 2)^2 + x_1^2` subject to `x_0 + x_1 = 1`, `x_0 <= 0.75`:
///
/// ```
/// use hangtime::nlp::{self, NlpProblem, Settings};
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
/// # Ok::<(), hangtime::nlp::InputError>(())
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
/// # use hangtime::nlp::NlpProblem;
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
/// use hangtime::nlp::{self, Settings, WarmStart};
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
    run(
        problem,
        settings,
        &mut Products::default(),
        &mut path,
        start,
        observer,
    )
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
    if let Some(start) = start {
        check_warm_start(problem, start)?;
    }
    settings.validate()?;
    let point = start.map(|s| &s.x[..]);
    let formulation = Formulation::new(problem, settings, &products.pairs, point)?;
    let mut core = Core::new(formulation, settings, observer)?;
    let main = BarrierProblem::main(&core.formulation);
    let mut main_loop = Loop::new(&mut core, main, path, false);
    first_point(&mut main_loop);
    if !main_loop.evaluate_iterate() {
        let what = not_finite(&main_loop);
        return Err(InputError::NotFiniteAtStart { what });
    }
    first_multipliers(&mut main_loop, start, products);
    main_loop.start_filter();
    let outcome = main_loop.run(None);
    let (iterate, mu, sigma) = (main_loop.iterate, main_loop.mu, main_loop.sigma);
    products.sigma = sigma;
    Ok(solution(core, &iterate, products, &outcome, mu))
}

fn check_warm_start(problem: &dyn NlpProblem, start: &WarmStart) -> Result<(), InputError> {
    let (n, m) = (problem.variables(), problem.constraints());
    for (what, expected, found) in [
        ("the constraint multipliers", m, start.multipliers.len()),
        ("the lower multipliers", n, start.multipliers_lower.len()),
        ("the upper multipliers", n, start.multipliers_upper.len()),
    ] {
        if expected != found {
            return Err(InputError::WarmStart {
                what,
                expected,
                found,
            });
        }
    }
    Ok(())
}

/// Point inside the bounds, slacks from the constraint values.
fn first_point(main: &mut Loop<'_, '_, '_, '_>) {
    let (push, fraction) = (
        main.core.settings.bound_push,
        main.core.settings.bound_fraction,
    );
    let n = main.problem.n;
    for i in 0..n {
        let (lower, upper) = (main.problem.lower[i], main.problem.upper[i]);
        main.iterate.v[i] = interior(main.core.formulation.start[i], lower, upper, push, fraction);
    }
    // residuals with zero slacks are the constraint values
    main.evaluate_iterate();
    for (k, slack) in main.problem.slacks.iter().enumerate() {
        let i = n + k;
        let residual = main.values.residual[slack.row];
        main.iterate.v[i] = if slack.row < main.problem.m {
            let value = if residual.is_finite() { residual } else { 0.0 };
            interior(
                value,
                main.problem.lower[i],
                main.problem.upper[i],
                push,
                fraction,
            )
        } else {
            (-residual).max(0.1 * main.sigma)
        };
    }
}

/// What is not finite at the first point, by name.
fn not_finite(main: &Loop<'_, '_, '_, '_>) -> String {
    let rows = &main.core.formulation.rows;
    match main.values.residual.iter().position(|r| !r.is_finite()) {
        Some(row) if row < rows.len() => main.core.formulation.problem().constraint_name(rows[row]),
        _ => String::from("the objective"),
    }
}

fn first_multipliers(
    main: &mut Loop<'_, '_, '_, '_>,
    start: Option<&WarmStart>,
    products: &Products,
) {
    let n = main.problem.n;
    for i in 0..main.problem.variables() {
        let (lower, upper) = (main.problem.lower[i], main.problem.upper[i]);
        if lower.is_finite() {
            main.iterate.z_lower[i] = 1.0;
        }
        if upper.is_finite() {
            main.iterate.z_upper[i] = 1.0;
        }
    }
    for (k, slack) in main.problem.slacks.iter().enumerate() {
        if slack.row >= main.problem.m {
            main.iterate.z_lower[n + k] = main.mu / main.iterate.v[n + k];
        }
    }
    main.evaluate_first_derivatives();
    match start {
        None => {
            main.safeguard();
            main.estimate_multipliers();
        }
        Some(start) => {
            let scale = main.core.formulation.objective_scale;
            let mu = main.mu;
            for i in 0..n {
                let user = main.core.formulation.variables[i];
                let v = main.iterate.v[i];
                if main.problem.lower[i].is_finite() {
                    let z = scale * start.multipliers_lower[user];
                    main.iterate.z_lower[i] = z.max(1e-2 * mu / (v - main.problem.lower[i]));
                }
                if main.problem.upper[i].is_finite() {
                    let z = scale * start.multipliers_upper[user];
                    main.iterate.z_upper[i] = z.max(1e-2 * mu / (main.problem.upper[i] - v));
                }
            }
            warm_products(main, start, products);
            for row in 0..main.problem.m {
                let user = main.core.formulation.rows[row];
                main.iterate.y[row] =
                    scale * start.multipliers[user] / main.core.formulation.row_scales[row];
            }
            for (k, slack) in main.problem.slacks.iter().enumerate() {
                if slack.row >= main.problem.m {
                    continue;
                }
                let i = n + k;
                // the row's multiplier is the difference of the slack's bound multipliers
                let y = slack.sign * main.iterate.y[slack.row];
                let v = main.iterate.v[i];
                if main.problem.lower[i].is_finite() {
                    let floor = 1e-2 * mu / (v - main.problem.lower[i]);
                    main.iterate.z_lower[i] = y.max(floor);
                }
                if main.problem.upper[i].is_finite() {
                    let floor = 1e-2 * mu / (main.problem.upper[i] - v);
                    main.iterate.z_upper[i] = (-y).max(floor);
                }
            }
            main.safeguard();
        }
    }
}

/// Multipliers of products, and what remains of the bound multipliers of their variables.
fn warm_products(main: &mut Loop<'_, '_, '_, '_>, start: &WarmStart, products: &Products) {
    let (n, m) = (main.problem.n, main.problem.m);
    if products.multipliers.len() != products.pairs.len() {
        return;
    }
    let scale = main.core.formulation.objective_scale;
    let mut is_free = vec![None; start.x.len()];
    for (i, &user) in main.core.formulation.variables.iter().enumerate() {
        is_free[user] = Some(i);
    }
    let mut lower: Vec<f64> = main
        .core
        .formulation
        .variables
        .iter()
        .map(|&user| scale * start.multipliers_lower[user])
        .collect();
    let mut row = m;
    for (&(a, b), r) in products.pairs.iter().zip(&products.multipliers) {
        if let (Some(i), Some(j)) = (is_free[a], is_free[b]) {
            main.iterate.y[row] = scale * r;
            lower[i] += scale * r * start.x[b];
            lower[j] += scale * r * start.x[a];
            row += 1;
        }
    }
    for (k, slack) in main.problem.slacks.iter().enumerate() {
        if slack.row >= m {
            main.iterate.z_lower[n + k] = main.iterate.y[slack.row];
        }
    }
    for &(i, j) in &main.problem.products {
        for k in [i, j] {
            let distance = main.iterate.v[k] - main.problem.lower[k];
            main.iterate.z_lower[k] = lower[k].max(1e-2 * main.mu / distance);
        }
    }
}

/// The result in the user's variables and units.
fn solution(
    mut core: Core<'_, '_>,
    iterate: &Iterate,
    products: &mut Products,
    outcome: &Outcome,
    mu: f64,
) -> Solution {
    let n_user = core.formulation.problem().variables();
    let m_user = core.formulation.problem().constraints();
    let n = core.formulation.variables.len();
    let m = core.formulation.rows.len();
    let scale = core.formulation.objective_scale;
    let x = core.formulation.full_point(&iterate.v[..n]).to_vec();
    let mut multipliers = vec![0.0; m_user];
    for (row, &user) in core.formulation.rows.iter().enumerate() {
        multipliers[user] = iterate.y[row] * core.formulation.row_scales[row] / scale;
    }
    let mut multipliers_lower = vec![0.0; n_user];
    let mut multipliers_upper = vec![0.0; n_user];
    for (i, &user) in core.formulation.variables.iter().enumerate() {
        multipliers_lower[user] = iterate.z_lower[i] / scale;
        multipliers_upper[user] = iterate.z_upper[i] / scale;
    }
    let mut of_products = vec![0.0; products.pairs.len()];
    let mut product = 0;
    let mut is_free = vec![false; n_user];
    for &i in &core.formulation.variables {
        is_free[i] = true;
    }
    for (k, &(i, j)) in products.pairs.iter().enumerate() {
        if is_free[i] && is_free[j] {
            let r = iterate.y[m + product] / scale;
            of_products[k] = r;
            multipliers_lower[i] -= r * x[j];
            multipliers_lower[j] -= r * x[i];
            product += 1;
        }
    }
    products.multipliers = of_products;

    // optimality of the original problem; fixed variables have the multiplier that balances them
    let point = core.formulation.unscaled(&iterate.v[..n]);
    let objective = point.objective;
    let (mut dual, c) = (point.gradient.to_vec(), point.constraints.to_vec());
    for (&(row, column), value) in point.pattern.iter().zip(point.jacobian) {
        dual[column] += value * multipliers[row];
    }
    let mut residuals = Residuals {
        scaled_error: outcome.error,
        ..Residuals::default()
    };
    for i in 0..n_user {
        if is_free[i] {
            let residual = dual[i] - multipliers_lower[i] + multipliers_upper[i];
            residuals.dual = residuals.dual.max(residual.abs());
        } else {
            multipliers_lower[i] = dual[i].max(0.0);
            multipliers_upper[i] = (-dual[i]).max(0.0);
        }
    }
    let (primal, complementarity, violations) = diagnose(
        core.formulation.problem(),
        &x,
        &c,
        (&multipliers, &multipliers_lower, &multipliers_upper),
        core.settings.constraint_tolerance,
    );
    residuals.primal = primal;
    residuals.complementarity = complementarity;
    let mut counts = core.formulation.counts;
    counts.iterations = core.iterations;
    counts.restoration_iterations = core.restoration_iterations;
    counts.factorizations = core.kkt.factorizations;
    let seconds = core.seconds();
    Solution {
        status: match outcome.status {
            Status::Solved if outcome.left => Status::RestorationFailed,
            status => status,
        },
        objective,
        multipliers,
        multipliers_lower,
        multipliers_upper,
        barrier_parameter: mu,
        residuals,
        counts,
        linear_seconds: core.kkt.seconds,
        seconds,
        history: core.history,
        violations,
        x,
    }
}
