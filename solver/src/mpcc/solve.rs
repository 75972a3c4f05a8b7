//! The entry points: rules one after the other.

use super::decided::decided_sides;
use super::finish::{BINDING, compare};
use super::moved::start_within_rows;
use super::reprise::reprise;
use super::run::solve_with;
use super::second_round::second_round;
use super::watch::Watch;
use super::{Mpcc, RelaxationRule, Settings, Solution, Status};
use crate::nlp::{self, Fault, InputError, Variant};

/// Solves a mathematical program with complementarity constraints from its own starting point: the rules of
/// [`Settings::rules`] one after the other, until one ends at a certified point; where none does, a second round from where
/// they ended.
///
/// A problem is called infeasible if the rows and bounds are infeasible without its pairs, if the elastic mode and
/// another rule both end at a stationary point of the violation, or if all rules do; where rows do not hold at its starting point, from
/// a point near it as well at which they do, if there is one.
///
/// # Errors
/// [`InputError`] when the input is wrong, among it pairs of a variable with itself or of variables whose
/// lower bound is not zero.
///
/// # Examples
/// The projection of (-1, 1) on the cone `0 <= x_0 _|_ x_1 >= 0` is (0, 1):
///
/// ```
/// use hangtime_solver::mpcc::{self, Mpcc, Settings};
/// use hangtime_solver::nlp::NlpProblem;
///
/// struct Projection;
///
/// impl NlpProblem for Projection {
///     fn variables(&self) -> usize { 2 }
///     fn constraints(&self) -> usize { 0 }
///     fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
///         lower.fill(0.0);
///         upper.fill(f64::INFINITY);
///     }
///     fn constraint_bounds(&self, _: &mut [f64], _: &mut [f64]) {}
///     fn initial_point(&self, x: &mut [f64]) { x.fill(1.0); }
///     fn objective(&mut self, x: &[f64]) -> f64 { (x[0] + 1.0).powi(2) + (x[1] - 1.0).powi(2) }
///     fn gradient(&mut self, x: &[f64], g: &mut [f64]) {
///         g.copy_from_slice(&[2.0 * (x[0] + 1.0), 2.0 * (x[1] - 1.0)]);
///     }
///     fn constraint_values(&mut self, _: &[f64], _: &mut [f64]) {}
///     fn jacobian_pattern(&self) -> Vec<(usize, usize)> { Vec::new() }
///     fn jacobian_values(&mut self, _: &[f64], _: &mut [f64]) {}
///     fn hessian_pattern(&self) -> Vec<(usize, usize)> { vec![(0, 0), (1, 1)] }
///     fn hessian_values(&mut self, _: &[f64], weight: f64, _: &[f64], values: &mut [f64]) {
///         values.fill(2.0 * weight);
///     }
/// }
///
/// impl Mpcc for Projection {
///     fn complementarities(&self) -> &[(usize, usize)] { &[(0, 1)] }
/// }
///
/// let solution = mpcc::solve(&mut Projection, &Settings::default())?;
/// assert!(solution.status.is_solved());
/// assert_eq!(solution.x[0], 0.0);
/// assert!((solution.x[1] - 1.0).abs() < 1e-8);
/// # Ok::<(), hangtime_solver::nlp::InputError>(())
/// ```
pub fn solve(problem: &mut dyn Mpcc, settings: &Settings) -> Result<Solution, InputError> {
    solve_observed(problem, settings, &mut |_| true)
}

/// As [`solve`], with an observer that sees each iteration of all runs, those of crossovers and certificates
/// included, and can stop the solve: then the status is [`Failed`](Status::Failed) with
/// [`nlp::Status::Interrupted`], unless a certified point was known already, which then is the result.
///
/// # Errors
/// As [`solve`].
///
/// # Examples
/// The projection of (-1, 1) on the cone `0 <= x_0 _|_ x_1 >= 0`, stopped after three iterations:
///
/// ```
/// # use hangtime_solver::nlp::NlpProblem;
/// # struct Projection;
/// # impl NlpProblem for Projection {
/// #     fn variables(&self) -> usize { 2 }
/// #     fn constraints(&self) -> usize { 0 }
/// #     fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) { lower.fill(0.0); upper.fill(f64::INFINITY); }
/// #     fn constraint_bounds(&self, _: &mut [f64], _: &mut [f64]) {}
/// #     fn initial_point(&self, x: &mut [f64]) { x.fill(1.0); }
/// #     fn objective(&mut self, x: &[f64]) -> f64 { (x[0] + 1.0).powi(2) + (x[1] - 1.0).powi(2) }
/// #     fn gradient(&mut self, x: &[f64], g: &mut [f64]) { g[0] = 2.0 * (x[0] + 1.0); g[1] = 2.0 * (x[1] - 1.0); }
/// #     fn constraint_values(&mut self, _: &[f64], _: &mut [f64]) {}
/// #     fn jacobian_pattern(&self) -> Vec<(usize, usize)> { Vec::new() }
/// #     fn jacobian_values(&mut self, _: &[f64], _: &mut [f64]) {}
/// #     fn hessian_pattern(&self) -> Vec<(usize, usize)> { vec![(0, 0), (1, 1)] }
/// #     fn hessian_values(&mut self, _: &[f64], weight: f64, _: &[f64], values: &mut [f64]) { values.fill(2.0 * weight); }
/// # }
/// # impl hangtime_solver::mpcc::Mpcc for Projection {
/// #     fn complementarities(&self) -> &[(usize, usize)] { &[(0, 1)] }
/// # }
/// use hangtime_solver::mpcc::{self, Settings, Status};
/// use hangtime_solver::nlp;
///
/// let mut sigma = Vec::new();
/// let mut observer = |info: &nlp::IterationInfo| {
///     sigma.push(info.relaxation_parameter);
///     info.iteration < 3
/// };
/// let solution = mpcc::solve_observed(&mut Projection, &Settings::default(), &mut observer)?;
/// assert_eq!(solution.status, Status::Failed(nlp::Status::Interrupted));
/// assert!(sigma.windows(2).all(|pair| pair[1] <= pair[0]));
/// # Ok::<(), nlp::InputError>(())
/// ```
pub fn solve_observed(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    observer: &mut nlp::Observer<'_>,
) -> Result<Solution, InputError> {
    settings.validate()?;
    check_pairs(problem)?;
    let given = settings.interior_point.objective_unit;
    let unit = given.unwrap_or_else(|| nlp::objective_unit(problem, None, &nlp::Slopes::START));
    let mut measured = Variant {
        objective_unit: unit,
        ..Variant::of(problem)
    };
    let mut settings = settings.clone();
    settings.interior_point.objective_unit = Some(1.0);
    let mut see = |info: &nlp::IterationInfo| observer(&info.times(unit));
    Ok(solve_measured(&mut measured, &settings, &mut see)?.times(unit))
}

/// As [`solve_observed`], with the objective in the unit that it is stated in.
fn solve_measured(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    observer: &mut nlp::Observer<'_>,
) -> Result<Solution, InputError> {
    let mut watch = Watch::new(settings, observer);
    let watch = &mut watch;
    let first = solve_with(problem, settings, settings.rules[0], watch)?;
    let led_astray = first.status == Status::Infeasible && watch.stop.is_none();
    let start = if settings.crossover && led_astray {
        start_within_rows(problem, &settings.interior_point, watch)?
    } else {
        None
    };
    let sides = settings.crossover.then(|| decided_sides(problem)).flatten();
    let is_open = |path: &&Path| match path.change {
        Change::Start => start.is_some(),
        Change::Sides => sides.is_some(),
        Change::None => true,
    };
    let paths: Vec<&Path> = PATHS.iter().filter(is_open).collect();
    let mut first = Some(first);
    let mut best: Option<Solution> = None;
    for (k, path) in paths.iter().enumerate() {
        let begun = if k == 0 && start.is_none() {
            0
        } else {
            watch.used()
        };
        let share = if k + 1 < paths.len() { path.share } else { 1.0 };
        let left = settings.maximum_iterations.saturating_sub(begun);
        let goes_on = watch.limit(begun + (share * left as f64) as usize);
        if k > 0 && !goes_on {
            break;
        }
        let settings = Settings {
            rules: settings.rules.iter().take(path.rules).copied().collect(),
            ..settings.clone()
        };
        let mut variant = Variant::of(&mut *problem);
        let mut known = None;
        match path.change {
            Change::Start => variant.start = start.clone().unwrap_or_default(),
            Change::Sides => variant.fixed = sides.clone().unwrap_or_default(),
            Change::None => known = first.take(),
        }
        let found = solve_stated(&mut variant, &settings, known, watch)?;
        let is_end = is_settled(problem, &found)
            // a point without descent of the violation says nothing of other starts
            && !(path.change == Change::Start && found.status == Status::Infeasible);
        best = Some(match best {
            None => found,
            Some(before) => match (path.change, before.status, found.status) {
                // a problem is infeasible only if it is so from both starts
                (Change::None, Status::Infeasible, Status::Failed(_)) => found,
                (Change::None, Status::Failed(_), Status::Infeasible) => before,
                _ => better(found, before, watch),
            },
        });
        if is_end {
            break;
        }
    }
    // there is a path that changes nothing
    let best = best.ok_or_else(no_rules)?;
    Ok(with_totals(best, watch))
}

/// What a path to a solution changes of the problem as it is stated.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Change {
    /// Its start, for one at which rows and bounds hold, where the first rule ends in a stationary point of the violation.
    Start,
    None,
    /// Sides that linear rows decide, which are fixed at zero: another path may lead to a point that can be certified.
    Sides,
}

/// A path to a solution.
struct Path {
    change: Change,
    /// Most rules that are asked.
    rules: usize,
    /// Part that it may take of the iterations that are left, where another path follows.
    share: f64,
}

/// The paths, in the order in which they are tried. Measured on 392 problems of nosnoc's collection: the start certifies
/// 1.3 % of all, the sides 1.8 %.
const PATHS: [Path; 3] = [
    Path {
        change: Change::Start,
        rules: usize::MAX,
        share: 0.6,
    },
    Path {
        change: Change::None,
        rules: usize::MAX,
        share: 0.6,
    },
    Path {
        change: Change::Sides,
        rules: 2,
        share: 1.0,
    },
];

/// The later of two solutions where it is better, or was interrupted, else the one before, with what all runs took.
fn better(later: Solution, before: Solution, watch: &Watch<'_>) -> Solution {
    let interrupted = watch.stop == Some(nlp::Status::Interrupted);
    if interrupted || compare(&later, &before).is_lt() {
        later
    } else {
        with_totals(before, watch)
    }
}

/// Whether another path to a solution is not worth it.
fn is_settled(problem: &dyn Mpcc, solution: &Solution) -> bool {
    solution.status.is_solved()
        || solution.status == Status::Failed(nlp::Status::Diverging)
        || is_infeasible_without_pairs(problem, solution)
}

/// The rules, of which the first may have been asked before, and what follows on them.
fn solve_stated(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    mut first: Option<Solution>,
    watch: &mut Watch<'_>,
) -> Result<Solution, InputError> {
    let mut best: Option<Solution> = None;
    let mut others: Vec<Solution> = Vec::new();
    let mut infeasible = 0;
    let mut is_shown = false;
    for &rule in &settings.rules {
        let ended = match first.take() {
            Some(first) => first,
            None => solve_with(problem, settings, rule, watch)?,
        };
        if ended.status == Status::Infeasible {
            infeasible += 1;
            is_shown = infeasible == settings.rules.len()
                || infeasible >= 2 && rule == RelaxationRule::Elastic
                || is_infeasible_without_pairs(problem, &ended);
        }
        let finished = watch.stop.is_some()
            || best.as_ref().is_some_and(|best| best.status.is_solved())
            || match ended.status {
                Status::Solved => !(ended.resumed && settings.second_opinion),
                Status::Relaxed => !settings.crossover,
                Status::Infeasible => is_shown,
                _ => false,
            };
        best = Some(match best {
            Some(best) if compare(&best, &ended).is_le() => {
                others.push(ended);
                best
            }
            best => {
                others.extend(best);
                ended
            }
        });
        if finished {
            break;
        }
    }
    if let Some(best) = &mut best
        && settings.crossover
        && watch.stop.is_none()
        && !best.status.is_solved()
        && best.status != Status::Infeasible
    {
        others.sort_by(compare);
        second_round(problem, settings, best, &others, watch)?;
    }
    if let (Some(best), Some(stop), false) = (&mut best, watch.stop, is_shown)
        && best.status == Status::Infeasible
    {
        // cut short before other rules could tell
        best.status = Status::Failed(stop);
    }
    // the list of rules is not empty
    let best = best.ok_or_else(no_rules)?;
    complete(problem, settings, best, watch)
}

fn no_rules() -> InputError {
    InputError::from(Fault::Setting {
        name: "rules",
        value: 0.0,
        range: "a list of at least one rule",
    })
}

/// The best of the rules, relaxed again where it is certified, with the totals of all rules.
fn complete(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    mut solution: Solution,
    watch: &mut Watch<'_>,
) -> Result<Solution, InputError> {
    if solution.status.is_solved() {
        if settings.second_opinion {
            reprise(problem, settings, &mut solution, watch)?;
        }
    } else if watch.stop == Some(nlp::Status::Interrupted) {
        // whoever interrupts has to see it
        solution.status = Status::Failed(nlp::Status::Interrupted);
    }
    Ok(with_totals(solution, watch))
}

/// A solution with what all runs so far took.
fn with_totals(solution: Solution, watch: &Watch<'_>) -> Solution {
    Solution {
        iterations: watch.iterations,
        crossover_iterations: watch.crossover_iterations,
        certificate_iterations: watch.certificate_iterations,
        factorizations: watch.factorizations,
        cpu: watch.cpu,
        ..solution
    }
}

/// Whether no pair had a part in the infeasibility of a point.
fn is_infeasible_without_pairs(problem: &dyn Mpcc, solution: &Solution) -> bool {
    let mut pairs = problem.complementarities().iter();
    solution.status == Status::Infeasible
        && pairs
            .all(|&(i, j)| solution.x[i] * solution.x[j] < BINDING * solution.relaxation_parameter)
}

fn check_pairs(problem: &dyn Mpcc) -> Result<(), InputError> {
    let n = problem.variables();
    let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
    problem.variable_bounds(&mut lower, &mut upper);
    for (index, &(first, second)) in problem.complementarities().iter().enumerate() {
        let fault = if first >= n || second >= n {
            "no such variable; pairs are indices of variables, from 0"
        } else if first == second {
            "a variable cannot be paired with itself; fix it at zero"
        } else if lower[first] != 0.0 || lower[second] != 0.0 {
            "the lower bound of a paired variable must be 0; introduce a slack variable"
        } else {
            continue;
        };
        return Err(InputError::from(Fault::Complementarity {
            index,
            first,
            second,
            fault,
        }));
    }
    Ok(())
}
