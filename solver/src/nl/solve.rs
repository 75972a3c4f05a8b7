//! The entry point: the method that fits the program, and its result in the terms of the file.

use crate::clock::{Instant, ThreadTime};
use crate::linalg::norms::norm_inf;

use super::program::Program;
use super::second_order::{Stationary, second_order};
use super::solution::{Solution, Status, Work};
use crate::mpcc::{self, Mpcc, Stationarity, StationarityType};
use crate::nlp::{self, InputError, NlpProblem as _, Residuals, Violation, WarmStart};

/// What the caller may choose; change fields of [`Options::default`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// Bound of the optimality error, relative to the scale of the program at its start; default 1e-8, in (0, 1).
    pub tolerance: f64,
    /// Bound of the violation of a solution in the units of the file; default 1e-6, > 0.
    pub constraint_tolerance: f64,
    /// Most interior point iterations; default those of [`nlp`] and [`mpcc`].
    pub maximum_iterations: Option<usize>,
    /// Most seconds of wall-clock time; default infinite.
    pub maximum_seconds: f64,
    /// Ends the solve from outside, within a step too; default never.
    pub interrupt: nlp::Interrupt,
    /// Points to start from, that of the file and others beside it, of which the best end is kept; default 1.
    pub starts: usize,
    /// Whether multipliers in the file are started from; default true.
    pub warm: bool,
}

impl Default for Options {
    fn default() -> Self {
        let settings = nlp::Settings::default();
        Self {
            tolerance: settings.tolerance,
            constraint_tolerance: settings.constraint_tolerance,
            maximum_iterations: None,
            maximum_seconds: f64::INFINITY,
            interrupt: nlp::Interrupt::default(),
            starts: 1,
            warm: true,
        }
    }
}

/// Solves a program with the default settings of [`mpcc`], or of [`nlp`] where nothing is complementary, in at most
/// `seconds` of wall-clock time. The observer sees each iteration and can stop the run.
///
/// # Errors
/// [`InputError`] where a lower bound exceeds its upper bound, or a function is not finite at the starting point.
pub fn solve(
    program: &mut Program,
    seconds: f64,
    observer: &mut nlp::Observer<'_>,
) -> Result<Solution, InputError> {
    let options = Options {
        maximum_seconds: seconds,
        warm: false,
        ..Options::default()
    };
    solve_with(program, &options, observer)
}

/// Solves a program as the options say. Where the file gives multipliers and nothing is complementary, the solve starts from them near
/// the point that the file gives, and once more without them if that leads to no solution.
///
/// # Errors
/// As [`solve`], and where an option is out of its range.
pub fn solve_with(
    program: &mut Program,
    options: &Options,
    observer: &mut nlp::Observer<'_>,
) -> Result<Solution, InputError> {
    let (start, began) = (ThreadTime::now(), Instant::now());
    let mut best = solve_once(program, options, observer)?;
    let own = program.file_start().to_vec();
    for k in 1..options.starts {
        let left = options.maximum_seconds - began.elapsed().as_secs_f64();
        if left <= 0.0 || best.status == Status::Interrupted {
            break;
        }
        let options = Options {
            maximum_seconds: left,
            warm: false,
            ..options.clone()
        };
        program.start_at(&beside(&own, k));
        // functions need not have values there
        let Ok(mut other) = solve_once(program, &options, observer) else {
            continue;
        };
        other.work.iterations += best.work.iterations;
        other.work.factorizations += best.work.factorizations;
        other.work.crossover_iterations += best.work.crossover_iterations;
        let stopped = matches!(other.status, Status::Interrupted | Status::TimeLimit);
        if is_better(program, &other, &best) {
            best = other;
        } else {
            best.work = other.work;
        }
        if stopped {
            break;
        }
    }
    program.start_at(&own);
    best.work.seconds = start.elapsed().as_secs_f64();
    Ok(best)
}

/// Whether an end is better than another: solved, or with a better objective.
fn is_better(program: &Program, a: &Solution, b: &Solution) -> bool {
    let gain = program.sense() * (b.objective - a.objective);
    match (a.status.is_solved(), b.status.is_solved()) {
        (true, true) => gain > 0.0,
        (solved, _) => solved,
    }
}

/// The start of number `k`: every variable moved by up to its size, or 1 where that is less, the same in every run.
fn beside(own: &[f64], k: usize) -> Vec<f64> {
    /// Fractional parts of multiples of these spread evenly (golden ratio and square root of 2).
    const STRIDES: [f64; 2] = [0.618_033_988_749_894_9, 0.414_213_562_373_095_03];
    let moved = own.iter().enumerate().map(|(i, x)| {
        let spread = (STRIDES[0] * (i + 1) as f64 + STRIDES[1] * k as f64).fract();
        x + (2.0 * spread - 1.0) * x.abs().max(1.0) * (1 + k / 8) as f64
    });
    moved.collect()
}

/// Why a program is called unbounded by a ray.
const WITHOUT_BOUND: &str = "the objective improves without bound along a ray of feasible points";

fn solve_once(
    program: &mut Program,
    options: &Options,
    observer: &mut nlp::Observer<'_>,
) -> Result<Solution, InputError> {
    let began = Instant::now();
    let end = run(program, options, observer)?;
    let left = options.maximum_seconds - began.elapsed().as_secs_f64();
    Ok(end.or_unbounded(program, left).in_file(program))
}

/// A run of the method that fits the program.
fn run(
    program: &mut Program,
    options: &Options,
    observer: &mut nlp::Observer<'_>,
) -> Result<End, InputError> {
    if !program.complementarities().is_empty() {
        let mut settings = mpcc::Settings::default();
        settings.interior_point.tolerance = options.tolerance;
        settings.interior_point.constraint_tolerance = options.constraint_tolerance;
        settings.interior_point.maximum_seconds = options.maximum_seconds;
        settings.interior_point.interrupt = options.interrupt.clone();
        if let Some(most) = options.maximum_iterations {
            settings.maximum_iterations = most;
        }
        let solution = mpcc::solve_observed(program, &settings, observer)?;
        return Ok(End::of_complementary(solution));
    }
    let defaults = nlp::Settings::default();
    let settings = nlp::Settings {
        tolerance: options.tolerance,
        constraint_tolerance: options.constraint_tolerance,
        maximum_seconds: options.maximum_seconds,
        interrupt: options.interrupt.clone(),
        maximum_iterations: options
            .maximum_iterations
            .unwrap_or(defaults.maximum_iterations),
        ..defaults
    };
    let mut solution = None;
    if options.warm
        && let Some(start) = warm_start(program, options.tolerance)
    {
        let near = nlp::Settings {
            bound_push: start.1,
            bound_fraction: start.1,
            ..settings.clone()
        };
        let mut see = |info: &nlp::IterationInfo| observer(info);
        let warm = nlp::solve_from(program, &near, Some(&start.0), Some(&mut see))?;
        if warm.status.is_solved() || warm.status == nlp::Status::Interrupted {
            solution = Some(warm);
        }
    }
    let solution = match solution {
        Some(solution) => solution,
        None => {
            let mut see = |info: &nlp::IterationInfo| observer(info);
            nlp::solve_from(program, &settings, None, Some(&mut see))?
        }
    };
    Ok(End::of_nonlinear(solution))
}

/// Range of the first barrier parameter of a warm start, and its part of the square of what the optimality conditions leave: what
/// Newton's method leaves of that, with a margin for neighbours that have the same active bounds.
const WARM_BARRIER: [f64; 2] = [1e-9, 1e-5];
const WARM_SHARE: f64 = 1e-4;

/// The multipliers of the file with its point, and the distance to keep from bounds; `None` where the file gives no multipliers.
/// Those of bounds that are not given balance the gradient of the Lagrangian. The first barrier parameter follows from what the
/// optimality conditions leave.
fn warm_start(program: &mut Program, tolerance: f64) -> Option<(WarmStart, f64)> {
    let duals = program.duals.clone();
    let present = |of: &[(usize, f64)]| of.iter().any(|pair| pair.1 != 0.0);
    if !(present(&duals.rows) || present(&duals.lower) || present(&duals.upper)) {
        return None;
    }
    let (n, m) = (program.variables(), program.constraints());
    let mut x = vec![0.0; n];
    program.initial_point(&mut x);
    let mut of_rows = vec![0.0; program.file_rows];
    for (row, y) in duals.rows {
        of_rows[row] = y;
    }
    let sense = program.sense();
    let rows = program.vertical.rows.iter();
    let y: Vec<f64> = rows.map(|row| -sense * of_rows[row.of]).collect();
    let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
    program.variable_bounds(&mut lower, &mut upper);
    let mut left = vec![0.0; n];
    program.gradient(&x, &mut left);
    let slope = norm_inf(&left).max(f64::MIN_POSITIVE);
    let pattern = program.jacobian_pattern();
    let mut values = vec![0.0; pattern.len()];
    program.jacobian_values(&x, &mut values);
    for (&(row, column), value) in pattern.iter().zip(&values) {
        left[column] += value * y[row];
    }
    let (mut z_lower, mut z_upper) = (vec![0.0; n], vec![0.0; n]);
    let mut error: f64 = 0.0;
    for i in 0..n {
        x[i] = x[i].clamp(lower[i], upper[i]);
        let (below, above) = (x[i] - lower[i], upper[i] - x[i]);
        if left[i] > 0.0 && below.is_finite() {
            z_lower[i] = left[i];
        } else if left[i] < 0.0 && above.is_finite() {
            z_upper[i] = -left[i];
        }
        let rest = left[i] - z_lower[i] + z_upper[i];
        let [z, w, rest] = [z_lower[i], z_upper[i], rest.abs()].map(|z| z / slope);
        error = error.max(rest).max(z.min(below)).max(w.min(above));
    }
    for (of, z, sign) in [
        (duals.lower, &mut z_lower, sense),
        (duals.upper, &mut z_upper, -sense),
    ] {
        for (i, value) in of {
            z[i] = (sign * value).max(0.0);
        }
    }
    let mut c = vec![0.0; m];
    program.constraint_values(&x, &mut c);
    let (mut lower, mut upper) = (vec![0.0; m], vec![0.0; m]);
    program.constraint_bounds(&mut lower, &mut upper);
    for (c, (lower, upper)) in c.iter().zip(lower.iter().zip(&upper)) {
        error = error.max(lower - c).max(c - upper);
    }
    let [least, most] = WARM_BARRIER;
    let barrier_parameter =
        (WARM_SHARE * error * error).clamp(least.max(0.1 * tolerance), most.max(tolerance));
    let start = WarmStart::of_point(x, y, (z_lower, z_upper), barrier_parameter);
    // a distance of this size times a multiplier of size 1
    Some((start, barrier_parameter))
}

/// Rates of change of the objective with the bounds of the variables of the file; a variable that is measured downwards has its bounds
/// the other way round.
fn bound_multipliers(program: &Program, lower: &[f64], upper: &[f64]) -> [Vec<f64>; 2] {
    let sense = program.sense();
    let measures = program.vertical.measures.iter().take(program.variables);
    let turned = measures
        .zip(lower.iter().zip(upper))
        .map(|(measure, (lower, upper))| {
            let (lower, upper) = if measure.sign > 0.0 {
                (lower, upper)
            } else {
                (upper, lower)
            };
            (sense * lower, -sense * upper + 0.0)
        });
    let (lower, upper) = turned.unzip();
    [lower, upper]
}

/// Where a run ended, in the variables and rows of the program.
struct End {
    status: Status,
    reason: String,
    stationarity: Stationarity,
    objective: f64,
    x: Vec<f64>,
    multipliers: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    residuals: Residuals,
    violation_stationarity: Option<f64>,
    violations: Vec<Violation>,
    work: Work,
}

impl End {
    fn of_nonlinear(solution: nlp::Solution) -> Self {
        let status = of_run(solution.status);
        Self {
            status,
            reason: solution.status.to_string(),
            stationarity: match status {
                Status::Solved => Stationarity::S,
                _ => Stationarity::None,
            },
            objective: solution.objective,
            x: solution.x,
            multipliers: solution.multipliers,
            lower: solution.multipliers_lower,
            upper: solution.multipliers_upper,
            residuals: solution.residuals,
            violation_stationarity: solution.violation_stationarity,
            violations: solution.violations,
            work: Work {
                iterations: solution.counts.iterations,
                factorizations: solution.counts.factorizations,
                ..Work::default()
            },
        }
    }

    fn of_complementary(solution: mpcc::Solution) -> Self {
        let status = match solution.status {
            mpcc::Status::Solved => Status::Solved,
            mpcc::Status::Uncertified | mpcc::Status::NotStationary => Status::Uncertified,
            mpcc::Status::Relaxed => Status::Relaxed,
            mpcc::Status::Infeasible => Status::Infeasible,
            // the sides of a run without a crossover need not vanish
            mpcc::Status::Failed(nlp::Status::Degenerate) => Status::Failed,
            mpcc::Status::Failed(status) => of_run(status),
        };
        let stationarity = match &solution.certificate {
            Some(certificate) if status == Status::Solved => match certificate.stationarity {
                StationarityType::Strong => Stationarity::S,
                _ => Stationarity::B,
            },
            _ => Stationarity::None,
        };
        Self {
            status,
            reason: solution.status.to_string(),
            stationarity,
            objective: solution.objective,
            x: solution.x,
            multipliers: solution.multipliers,
            lower: solution.multipliers_lower,
            upper: solution.multipliers_upper,
            residuals: solution.residuals,
            violation_stationarity: solution.violation_stationarity,
            violations: solution.violations,
            work: Work {
                iterations: solution.iterations + solution.certificate_iterations,
                crossover_iterations: solution.crossover_iterations,
                factorizations: solution.factorizations,
                ..Work::default()
            },
        }
    }

    /// An end without a solution is one of a program without bound where a ray shows that.
    fn or_unbounded(mut self, program: &mut Program, seconds: f64) -> Self {
        let may_be = matches!(
            self.status,
            Status::Uncertified | Status::Relaxed | Status::IterationLimit | Status::Failed
        );
        let mut start = vec![0.0; self.x.len()];
        program.initial_point(&mut start);
        if may_be && mpcc::falls_along_a_ray(program, (&self.x, &start), seconds) {
            self.status = Status::Unbounded;
            self.reason = WITHOUT_BOUND.into();
            self.violations.clear();
        }
        self
    }

    /// The result in the terms of the file, with what second derivatives say of the point.
    fn in_file(self, program: &mut Program) -> Solution {
        let pairs = program.complementarities().to_vec();
        let second_order = (self.stationarity == Stationarity::S).then(|| {
            let point = Stationary {
                x: &self.x,
                multipliers: &self.multipliers,
                lower: &self.lower,
                upper: &self.upper,
                pairs: &pairs,
            };
            second_order(program, &point)
        });
        Solution {
            status: self.status,
            reason: self.reason,
            stationarity: self.stationarity,
            second_order,
            objective: program.sense() * self.objective,
            x: program.in_file(&self.x),
            multipliers: multipliers(program, &self.multipliers),
            bound_multipliers: bound_multipliers(program, &self.lower, &self.upper),
            residuals: self.residuals,
            violation_stationarity: self.violation_stationarity,
            work: self.work,
            violations: self.violations,
        }
    }
}

fn of_run(status: nlp::Status) -> Status {
    match status {
        nlp::Status::Solved => Status::Solved,
        nlp::Status::Degenerate => Status::Uncertified,
        nlp::Status::Infeasible => Status::Infeasible,
        nlp::Status::Diverging => Status::Unbounded,
        nlp::Status::Interrupted => Status::Interrupted,
        nlp::Status::TimeLimit => Status::TimeLimit,
        nlp::Status::IterationLimit => Status::IterationLimit,
        _ => Status::Failed,
    }
}

/// Rates of change of the objective with the right-hand sides of the rows of the file; 0 for rows that became pairs.
fn multipliers(program: &Program, own: &[f64]) -> Vec<f64> {
    let mut all = vec![0.0; program.file_rows];
    for (row, y) in program.vertical.rows.iter().zip(own) {
        let has_slack = row.function.linear.last();
        if has_slack.is_none_or(|&(variable, _)| variable < program.variables) {
            // the sign turns where `-f` was minimized
            all[row.of] = -program.sense() * y + 0.0;
        }
    }
    all
}
