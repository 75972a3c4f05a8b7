//! One rule from start to certificate: relaxed runs, crossover, neighbours.

use super::branch::Attempt;
use super::crossover::{Exact, FINAL, PAUSED, cross_over};
use super::elastic::Elastic;
use super::relaxation::{Continuation, Tied, proportional, roll_off};
use super::watch::{Purpose, Watch};
use super::{Mpcc, RelaxationRule, Residuals, Settings, Solution, Status};
use crate::nlp::{self, BarrierPath, InputError, NlpProblem, Products, Violation};

/// `sigma` and tolerance at which a relaxed run pauses for a first crossover. Fixed sides are reliable
/// from about `sigma = 1e-4` on; the roll-off rule passes that at `mu = 2e-6`.
const PAUSE_RELAXATION: f64 = 1e-5;
const PAUSE_TOLERANCE: f64 = 2e-5;

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
        RelaxationRule::Homotopy | RelaxationRule::Elastic => Box::new(nlp::Monotone {
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
pub(crate) fn solve_with(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    rule: RelaxationRule,
    watch: &mut Watch<'_>,
) -> Result<Solution, InputError> {
    match rule {
        RelaxationRule::Homotopy => return homotopy(problem, settings, watch),
        RelaxationRule::Elastic => return elastic(problem, settings, watch),
        _ => {}
    }
    let interior_point = &settings.interior_point;
    let last = |products: &Products| End::last(products.sigma);
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
        let relaxed = relax(
            problem,
            interior_point,
            (&mut products, &mut *path),
            None,
            watch,
        )?;
        let end = last(&products);
        return Ok(finish(problem, settings, rule, relaxed, end, watch));
    }
    let early = nlp::Settings {
        tolerance: PAUSE_TOLERANCE,
        acceptable_tolerance: interior_point.acceptable_tolerance.max(PAUSE_TOLERANCE),
        constraint_tolerance: interior_point.constraint_tolerance.max(PAUSE_TOLERANCE),
        ..interior_point.clone()
    };
    let mut path = make_path(rule, start, early.tolerance, PAUSE_RELAXATION);
    let paused = relax(problem, &early, (&mut products, &mut *path), None, watch)?;
    if paused.status != nlp::Status::Solved {
        let end = last(&products);
        return Ok(finish(problem, settings, rule, paused, end, watch));
    }
    let limit = paused.objective + 1e-2 * paused.objective.abs().max(1.0);
    let end = End {
        sigma: products.sigma,
        attempts: &PAUSED,
        limit,
    };
    let first = finish(problem, settings, rule, paused.clone(), end, watch);
    if first.status.is_solved() && first.objective <= limit || watch.stop.is_some() {
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
    let mut relaxed = relax(
        problem,
        &resumed,
        (&mut products, &mut *path),
        Some(&warm),
        watch,
    )?;
    relaxed.history.splice(0..0, paused.history);
    let end = last(&products);
    let second = finish(problem, settings, rule, relaxed, end, watch);
    let better = first.status.is_solved()
        && (!second.status.is_solved() || first.objective < second.objective);
    Ok(if better { first } else { second })
}

/// A run of the relaxed problem.
fn relax(
    problem: &mut dyn NlpProblem,
    settings: &nlp::Settings,
    (products, path): (&mut Products, &mut dyn BarrierPath),
    start: Option<&nlp::WarmStart>,
    watch: &mut Watch<'_>,
) -> Result<nlp::Solution, InputError> {
    watch.run(
        Purpose::Relaxed,
        settings,
        &mut |_| true,
        |settings, observer| nlp::run(problem, settings, products, path, start, Some(observer)),
    )
}

/// Separate solves with `sigma = 1, 0.1, ...` down to the final one, each from the last point.
fn homotopy(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    watch: &mut Watch<'_>,
) -> Result<Solution, InputError> {
    let mut products = Products {
        pairs: problem.complementarities().to_vec(),
        ..Products::default()
    };
    let mut sigma: f64 = 1.0;
    let mut last: Option<nlp::Solution> = None;
    loop {
        let mut path = nlp::Monotone {
            mu: settings.interior_point.initial_barrier_parameter,
            sigma,
            tolerance: settings.interior_point.tolerance,
        };
        let point = last.as_ref().map(|s| &s.x[..]);
        let solution = watch.run(
            Purpose::Relaxed,
            &settings.interior_point,
            &mut |_| true,
            |settings, observer| {
                nlp::run_from_point(
                    problem,
                    settings,
                    &mut products,
                    &mut path,
                    point,
                    Some(observer),
                )
            },
        )?;
        // a failed step still gives the next one its start, the last one decides
        if sigma <= settings.final_relaxation || watch.stop.is_some() {
            let (rule, end) = (RelaxationRule::Homotopy, End::last(sigma));
            return Ok(finish(problem, settings, rule, solution, end, watch));
        }
        last = Some(solution);
        sigma = (0.1 * sigma).max(settings.final_relaxation);
        if sigma < 1.5 * settings.final_relaxation {
            sigma = settings.final_relaxation;
        }
    }
}

/// Fraction of the last slack above which a slack counts as unchanged, and how many unchanged ones in a row show
/// infeasibility: where the pairs can be met, a tenfold weight makes the slack vanish or shrink in proportion.
const STUCK: f64 = 0.9;
const STUCK_PROGRAMS: usize = 3;

/// Elastic programs with `sigma = 1, 0.1, ...`, each warm from the one before, until the slack is at most the final
/// relaxation. A slack that stays as it is while its weight grows is one of local infeasibility.
fn elastic(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    watch: &mut Watch<'_>,
) -> Result<Solution, InputError> {
    let (n, m) = (problem.variables(), problem.constraints());
    let pairs = problem.complementarities().to_vec();
    let mut program = Elastic::new(problem);
    let mut interior_point = settings.interior_point.clone();
    let tolerance = interior_point.tolerance;
    let mut warm: Option<nlp::WarmStart> = None;
    let mut iterations = 0;
    let mut history = Vec::new();
    // slack of the last program, and how many in a row left it as it was
    let (mut last, mut stuck) = (f64::INFINITY, 0);
    let mut accurate = false;
    let (mut solution, slack) = loop {
        let sigma = program.sigma;
        interior_point.tolerance = if accurate {
            tolerance
        } else {
            tolerance.max(1e-2 * sigma)
        };
        let mut path = nlp::Monotone {
            mu: warm
                .as_ref()
                .map_or(interior_point.initial_barrier_parameter, |w| {
                    w.barrier_parameter
                }),
            sigma: 0.0,
            tolerance: interior_point.tolerance,
        };
        interior_point.maximum_iterations = settings
            .interior_point
            .maximum_iterations
            .saturating_sub(iterations);
        let mut none = Products::default();
        let mut solution = relax(
            &mut program,
            &interior_point,
            (&mut none, &mut path),
            warm.as_ref(),
            watch,
        )?;
        iterations += solution.counts.iterations;
        history.append(&mut solution.history);
        let slack = sigma * solution.x[n];
        let solved = solution.status == nlp::Status::Solved;
        let exact = solved && slack <= settings.final_relaxation;
        stuck = if slack > STUCK * last { stuck + 1 } else { 0 };
        last = slack;
        let infeasible = solved && !exact && stuck >= STUCK_PROGRAMS;
        let goes_on = solved || solution.status == nlp::Status::Acceptable;
        if infeasible
            || !goes_on
            || sigma <= settings.final_relaxation
            || (exact && interior_point.tolerance <= tolerance)
        {
            if solved && !exact {
                solution.status = nlp::Status::Infeasible;
            }
            break (solution, slack);
        }
        // once the slack has vanished only accuracy is missing
        accurate = exact;
        let next = if exact {
            sigma
        } else {
            (0.1 * sigma).max(settings.final_relaxation)
        };
        let mut start = nlp::WarmStart {
            barrier_parameter: solution.barrier_parameter.max(1e-2 * next).min(0.1),
            ..nlp::WarmStart::from_solution(&solution)
        };
        // the slack in its new unit
        start.x[n] = slack / next;
        (interior_point.bound_push, interior_point.bound_fraction) = (1e-9, 1e-9);
        program.sigma = next;
        warm = Some(start);
    };
    // the multipliers of the products become part of those of the paired variables
    for (&(i, j), r) in pairs.iter().zip(&solution.multipliers[m..]) {
        solution.multipliers_lower[i] -= r * solution.x[j];
        solution.multipliers_lower[j] -= r * solution.x[i];
    }
    solution.objective -= solution.x[n];
    solution.x.truncate(n);
    solution.multipliers.truncate(m);
    solution.multipliers_lower.truncate(n);
    solution.multipliers_upper.truncate(n);
    solution.history = history;
    let (rule, end) = (
        RelaxationRule::Elastic,
        End::last(slack.max(settings.final_relaxation)),
    );
    Ok(finish(problem, settings, rule, solution, end, watch))
}

/// Where a relaxed run ended and how it crosses over from there.
#[derive(Clone, Copy)]
struct End {
    sigma: f64,
    attempts: &'static [Attempt],
    /// Objective up to which neighbouring choices are tried.
    limit: f64,
}

impl End {
    /// The end of the last run of a rule.
    fn last(sigma: f64) -> Self {
        Self {
            sigma,
            attempts: &FINAL,
            limit: f64::INFINITY,
        }
    }
}

/// Share of the relaxation from which a product is binding.
pub(crate) const BINDING: f64 = 0.9;

/// Crossover and certificate of a relaxed run.
fn finish(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    rule: RelaxationRule,
    relaxed: nlp::Solution,
    end: End,
    watch: &mut Watch<'_>,
) -> Solution {
    let sigma = end.sigma;
    let near = matches!(
        relaxed.status,
        nlp::Status::Solved | nlp::Status::Acceptable
    ) || (relaxed.status != nlp::Status::Interrupted
        && relaxed.residuals.primal <= 1e-4
        && sigma <= 1e-2);
    let exact = if settings.crossover && near {
        cross_over(
            problem,
            settings,
            &relaxed,
            (end.attempts, end.limit),
            watch,
        )
    } else {
        None
    };
    let (status, point, certificate, (repairs, neighbours)) = match exact {
        Some(Exact {
            solution,
            certificate,
            repairs,
            neighbours,
        }) => {
            let status = match certificate.b_stationary {
                Some(true) => Status::Solved,
                Some(false) => Status::NotStationary,
                None => Status::Uncertified,
            };
            (status, solution, Some(certificate), (repairs, neighbours))
        }
        None => {
            let status = match (relaxed.status, watch.stop) {
                // a pause is no end
                (nlp::Status::Solved, Some(reason)) if settings.crossover => Status::Failed(reason),
                (nlp::Status::Solved, _) => Status::Relaxed,
                (nlp::Status::Infeasible, _) => Status::Infeasible,
                (status, _) => Status::Failed(status),
            };
            (status, relaxed.clone(), None, (0, 0))
        }
    };
    let mut complementarity: f64 = 0.0;
    let mut violations = point.violations;
    for (k, &(i, j)) in problem.complementarities().iter().enumerate() {
        let amount = point.x[i].min(point.x[j]);
        complementarity = complementarity.max(amount);
        // at an infeasible point the pairs at their relaxation are to blame
        let binding =
            relaxed.status != nlp::Status::Infeasible || point.x[i] * point.x[j] >= BINDING * sigma;
        if binding && point.x[i] * point.x[j] > 10.0 * settings.final_relaxation {
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
        iterations: watch.iterations,
        crossover_iterations: watch.crossover_iterations,
        certificate_iterations: watch.certificate_iterations,
        repairs,
        neighbours,
        factorizations: watch.factorizations,
        history: relaxed.history,
        violations,
        x: point.x,
    }
}
