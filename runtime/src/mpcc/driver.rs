//! The entry point: rules one after the other, crossover, certificate.

use super::crossover::{Exact, Work, cross_over};
use super::relaxation::{Continuation, Tied, proportional, roll_off};
use super::{Mpcc, RelaxationRule, Residuals, Settings, Solution, Status};
use crate::nlp::{self, BarrierPath, InputError, Products, Violation};

/// Solves a mathematical program with complementarity constraints from its own starting point.
///
/// # Errors
/// [`InputError`] when the input is wrong, among it pairs of a variable with itself or of variables whose
/// lower bound is not zero.
///
/// # Examples
/// The projection of (-1, 1) on the cone `0 <= x_0 _|_ x_1 >= 0` is (0, 1):
///
/// ```
/// use hangtime::mpcc::{self, Mpcc, Settings};
/// use hangtime::nlp::NlpProblem;
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
/// # Ok::<(), hangtime::nlp::InputError>(())
/// ```
pub fn solve(problem: &mut dyn Mpcc, settings: &Settings) -> Result<Solution, InputError> {
    solve_observed(problem, settings, &mut |_| true)
}

/// As [`solve`], with an observer that sees each line of the log of the relaxed runs and can stop them: then the
/// status is [`Failed`](Status::Failed) with [`nlp::Status::Interrupted`].
///
/// # Errors
/// As [`solve`].
pub fn solve_observed(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    observer: &mut nlp::Observer<'_>,
) -> Result<Solution, InputError> {
    settings.validate()?;
    check_pairs(problem)?;
    let mut best: Option<Solution> = None;
    let mut iterations = 0;
    let mut factorizations = 0;
    for &rule in &settings.rules {
        let mut solution = solve_with(problem, settings, rule, &mut *observer)?;
        if solution.status == Status::Failed(nlp::Status::Interrupted) {
            best = None;
        }
        iterations += solution.iterations;
        factorizations += solution.factorizations;
        solution.iterations = iterations;
        solution.factorizations = factorizations;
        let finished = solution.status.is_solved()
            || solution.status == Status::Failed(nlp::Status::Interrupted)
            || (solution.status == Status::Relaxed && !settings.crossover);
        best = Some(match best {
            Some(best) if rank(&best) <= rank(&solution) => Solution {
                iterations,
                factorizations,
                ..best
            },
            _ => solution,
        });
        if finished {
            break;
        }
    }
    // the list of rules is not empty
    best.ok_or(InputError::Setting {
        name: "rules",
        value: 0.0,
        range: "a list of at least one rule",
    })
}

/// As [`solve`], with one thread for each rule, each on its own copy of the problem; of several certified
/// points the one with the least objective is returned.
///
/// Iterations and factorizations of the result are those of all threads.
///
/// # Errors
/// As [`solve`].
///
/// # Examples
/// Minimize `x_0^2 + 2 x_1^2` subject to `x_0 + x_1 = 1`, `0 <= x_0 _|_ x_1 >= 0`: of the two feasible points
/// (1, 0) and (0, 1), both S-stationary, the first is the better one.
///
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
/// use hangtime::mpcc::{self, Mpcc, Settings};
///
/// impl Mpcc for Problem {
///     fn complementarities(&self) -> &[(usize, usize)] { &[(0, 1)] }
/// }
///
/// let solution = mpcc::solve_parallel(&Problem, &Settings::default())?;
/// assert!(solution.status.is_solved());
/// assert!((solution.objective - 1.0).abs() < 1e-8);
/// # Ok::<(), hangtime::nlp::InputError>(())
/// ```
pub fn solve_parallel<P>(problem: &P, settings: &Settings) -> Result<Solution, InputError>
where
    P: Mpcc + Clone + Send,
{
    settings.validate()?;
    check_pairs(problem)?;
    let copies: Vec<(P, RelaxationRule)> = settings
        .rules
        .iter()
        .map(|&rule| (problem.clone(), rule))
        .collect();
    let results: Vec<Result<Solution, InputError>> = std::thread::scope(|scope| {
        let threads: Vec<_> = copies
            .into_iter()
            .map(|(mut copy, rule)| {
                scope.spawn(move || {
                    solve_with(&mut copy as &mut dyn Mpcc, settings, rule, &mut |_| true)
                })
            })
            .collect();
        threads
            .into_iter()
            .filter_map(|thread| thread.join().ok())
            .collect()
    });
    let solutions = results.into_iter().collect::<Result<Vec<_>, _>>()?;
    let iterations = solutions.iter().map(|s| s.iterations).sum();
    let factorizations = solutions.iter().map(|s| s.factorizations).sum();
    solutions
        .into_iter()
        .min_by(|a, b| {
            let key = |s: &Solution| rank(s);
            let (a_rank, a_value) = key(a);
            let (b_rank, b_value) = key(b);
            a_rank
                .cmp(&b_rank)
                .then(a_value.total_cmp(&b_value))
                .then(a.objective.total_cmp(&b.objective))
        })
        .map(|best| Solution {
            iterations,
            factorizations,
            ..best
        })
        .ok_or(InputError::Setting {
            name: "rules",
            value: 0.0,
            range: "a list of at least one rule",
        })
}

/// `sigma` and tolerance at which a relaxed run pauses for a first crossover. Fixed sides are reliable
/// from about `sigma = 1e-4` on; the roll-off rule passes that at `mu = 2e-6`.
const PAUSE_RELAXATION: f64 = 1e-5;
const PAUSE_TOLERANCE: f64 = 2e-5;

/// The smaller the better.
fn rank(solution: &Solution) -> (u8, f64) {
    match solution.status {
        Status::Solved => (0, 0.0),
        Status::Uncertified => (1, 0.0),
        Status::NotStationary => (2, 0.0),
        Status::Relaxed => (3, 0.0),
        Status::Failed(nlp::Status::Acceptable) => (4, 0.0),
        Status::Failed(_) | Status::Infeasible => (
            5,
            solution
                .residuals
                .primal
                .max(solution.residuals.complementarity),
        ),
    }
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
        return Err(InputError::Complementarity {
            index,
            first,
            second,
            fault,
        });
    }
    Ok(())
}

/// A path by a rule from `(mu, sigma)` on.
fn make_path(
    rule: RelaxationRule,
    (mu, sigma): (f64, f64),
    tolerance: f64,
    floor: f64,
) -> Box<dyn BarrierPath> {
    let tied = |rule| Tied {
        mu,
        sigma,
        tolerance,
        floor,
        rule,
    };
    match rule {
        RelaxationRule::RollOff => Box::new(tied(roll_off)),
        RelaxationRule::Proportional => Box::new(tied(proportional)),
        RelaxationRule::Continuation => Box::new(Continuation::new((mu, sigma), tolerance, floor)),
        RelaxationRule::Homotopy => Box::new(nlp::Monotone {
            mu,
            sigma,
            tolerance,
        }),
    }
}

/// One relaxed run by one rule, its crossover and its certificate.
///
/// The run pauses where `sigma` is small enough for a crossover; if that does not end at a certified
/// point near the relaxed objective, the run goes on to the final `sigma` and crosses over again.
fn solve_with(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    rule: RelaxationRule,
    observer: &mut nlp::Observer<'_>,
) -> Result<Solution, InputError> {
    if rule == RelaxationRule::Homotopy {
        return homotopy(problem, settings);
    }
    let interior_point = &settings.interior_point;
    let mut products = Products {
        pairs: problem.complementarities().to_vec(),
        ..Products::default()
    };
    let start = (interior_point.initial_barrier_parameter, 1.0);
    let pauses = settings.crossover
        && settings.final_relaxation < PAUSE_RELAXATION
        && interior_point.tolerance < PAUSE_TOLERANCE;
    if !pauses {
        let mut path = make_path(
            rule,
            start,
            interior_point.tolerance,
            settings.final_relaxation,
        );
        let relaxed = nlp::run(
            problem,
            interior_point,
            &mut products,
            &mut *path,
            None,
            Some(&mut *observer),
        )?;
        return Ok(finish(problem, settings, rule, relaxed, products.sigma));
    }
    let early = nlp::Settings {
        tolerance: PAUSE_TOLERANCE,
        acceptable_tolerance: interior_point.acceptable_tolerance.max(PAUSE_TOLERANCE),
        constraint_tolerance: interior_point.constraint_tolerance.max(PAUSE_TOLERANCE),
        ..interior_point.clone()
    };
    let mut path = make_path(rule, start, early.tolerance, PAUSE_RELAXATION);
    let paused = nlp::run(
        problem,
        &early,
        &mut products,
        &mut *path,
        None,
        Some(&mut *observer),
    )?;
    if paused.status != nlp::Status::Solved {
        return Ok(finish(problem, settings, rule, paused, products.sigma));
    }
    let first = finish(problem, settings, rule, paused.clone(), products.sigma);
    let near = first.objective <= paused.objective + 1e-2 * paused.objective.abs().max(1.0);
    if first.status.is_solved() && near {
        return Ok(first);
    }
    let mut path = make_path(
        rule,
        (paused.barrier_parameter, products.sigma),
        interior_point.tolerance,
        settings.final_relaxation,
    );
    let resumed = nlp::Settings {
        bound_push: 1e-9,
        bound_fraction: 1e-9,
        maximum_iterations: interior_point
            .maximum_iterations
            .saturating_sub(paused.counts.iterations),
        ..interior_point.clone()
    };
    let warm = nlp::WarmStart::from_solution(&paused);
    let mut relaxed = nlp::run(
        problem,
        &resumed,
        &mut products,
        &mut *path,
        Some(&warm),
        Some(&mut *observer),
    )?;
    relaxed.counts.iterations += paused.counts.iterations;
    relaxed.counts.factorizations += paused.counts.factorizations;
    relaxed.history.splice(0..0, paused.history);
    let mut second = finish(problem, settings, rule, relaxed, products.sigma);
    second.iterations += first.crossover_iterations;
    second.crossover_iterations += first.crossover_iterations;
    let better = first.status.is_solved()
        && (!second.status.is_solved() || first.objective < second.objective);
    if better {
        return Ok(Solution {
            iterations: second.iterations,
            factorizations: second.factorizations,
            ..first
        });
    }
    Ok(second)
}

/// Separate solves with `sigma = 1, 0.1, ...` down to the final one, each from the last point.
fn homotopy(problem: &mut dyn Mpcc, settings: &Settings) -> Result<Solution, InputError> {
    let mut products = Products {
        pairs: problem.complementarities().to_vec(),
        ..Products::default()
    };
    let mut sigma: f64 = 1.0;
    let mut last: Option<nlp::Solution> = None;
    let (mut iterations, mut factorizations) = (0, 0);
    loop {
        let mut path = nlp::Monotone {
            mu: settings.interior_point.initial_barrier_parameter,
            sigma,
            tolerance: settings.interior_point.tolerance,
        };
        let mut solution = nlp::run_from_point(
            problem,
            &settings.interior_point,
            &mut products,
            &mut path,
            last.as_ref().map(|s| &s.x[..]),
        )?;
        iterations += solution.counts.iterations;
        factorizations += solution.counts.factorizations;
        solution.counts.iterations = iterations;
        solution.counts.factorizations = factorizations;
        let done = sigma <= settings.final_relaxation;
        // a failed step still gives the next one its start, the last one decides
        if done {
            return Ok(finish(
                problem,
                settings,
                RelaxationRule::Homotopy,
                solution,
                sigma,
            ));
        }
        last = Some(solution);
        sigma = (0.1 * sigma).max(settings.final_relaxation);
        if sigma < 1.5 * settings.final_relaxation {
            sigma = settings.final_relaxation;
        }
    }
}

/// Crossover and certificate of a relaxed run.
fn finish(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    rule: RelaxationRule,
    relaxed: nlp::Solution,
    sigma: f64,
) -> Solution {
    let mut work = Work::default();
    let near = matches!(
        relaxed.status,
        nlp::Status::Solved | nlp::Status::Acceptable
    ) || (relaxed.status != nlp::Status::Interrupted
        && relaxed.residuals.primal <= 1e-4
        && sigma <= 1e-2);
    let exact = if settings.crossover && near {
        cross_over(problem, settings, &relaxed, &mut work)
    } else {
        None
    };
    let iterations = relaxed.counts.iterations + work.iterations;
    let factorizations = relaxed.counts.factorizations + work.factorizations;
    let (status, point, certificate, repairs) = match exact {
        Some(Exact {
            solution,
            certificate,
            repairs,
        }) => {
            let status = match certificate.b_stationary {
                Some(true) => Status::Solved,
                Some(false) => Status::NotStationary,
                None => Status::Uncertified,
            };
            (status, solution, Some(certificate), repairs)
        }
        None => {
            let status = match relaxed.status {
                nlp::Status::Solved => Status::Relaxed,
                nlp::Status::Infeasible => Status::Infeasible,
                status => Status::Failed(status),
            };
            (status, relaxed.clone(), None, 0)
        }
    };
    let mut complementarity: f64 = 0.0;
    let mut violations = point.violations;
    for (k, &(i, j)) in problem.complementarities().iter().enumerate() {
        let amount = point.x[i].min(point.x[j]);
        complementarity = complementarity.max(amount);
        if point.x[i] * point.x[j] > 10.0 * settings.final_relaxation {
            violations.push(Violation {
                name: problem.complementarity_name(k),
                amount,
            });
        }
    }
    violations.sort_by(|a, b| b.amount.total_cmp(&a.amount));
    violations.truncate(10);
    Solution {
        status,
        objective: point.objective,
        multipliers: point.multipliers,
        multipliers_lower: point.multipliers_lower,
        multipliers_upper: point.multipliers_upper,
        residuals: Residuals {
            primal: point.residuals.primal,
            dual: point.residuals.dual,
            complementarity,
        },
        certificate,
        rule,
        relaxation_parameter: sigma,
        iterations,
        crossover_iterations: work.iterations,
        repairs,
        factorizations,
        history: relaxed.history,
        violations,
        x: point.x,
    }
}
