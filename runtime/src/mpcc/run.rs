//! One rule from start to certificate: relaxed runs and crossover.

use super::branch::Attempt;
use super::crossover::{FINAL, PAUSED, cross_over};
use super::elastic::elastic;
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
        RelaxationRule::Elastic => Box::new(nlp::Monotone {
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
) -> Result<Ended, InputError> {
    if rule == RelaxationRule::Elastic {
        return elastic(problem, settings, watch);
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
    };
    let first = finish(problem, settings, rule, paused.clone(), end, watch);
    let near = first.solution.status.is_solved() && first.solution.objective <= limit;
    if near || watch.stop.is_some() {
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
    let (before, after) = (&first.solution, &second.solution);
    let better = before.status.is_solved()
        && (!after.status.is_solved() || before.objective < after.objective);
    Ok(Ended {
        resumed: true,
        ..if better { first } else { second }
    })
}

/// A run of the relaxed problem.
pub(crate) fn relax(
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

/// Where a relaxed run ended and how it crosses over from there.
#[derive(Clone, Copy)]
pub(crate) struct End {
    sigma: f64,
    attempts: &'static [Attempt],
}

impl End {
    /// The end of the last run of a rule.
    pub(crate) fn last(sigma: f64) -> Self {
        Self {
            sigma,
            attempts: &FINAL,
        }
    }
}

/// Share of the relaxation from which a product is binding.
pub(crate) const BINDING: f64 = 0.9;

/// What a rule came to.
pub(crate) struct Ended {
    pub(crate) solution: Solution,
    /// The choice of sides at an exact point; empty elsewhere.
    pub(crate) vanishes: Vec<bool>,
    /// Whether the run went on after a first crossover that failed or ended far off.
    pub(crate) resumed: bool,
}

/// Crossover and certificate of a relaxed run.
pub(crate) fn finish(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    rule: RelaxationRule,
    relaxed: nlp::Solution,
    end: End,
    watch: &mut Watch<'_>,
) -> Ended {
    let sigma = end.sigma;
    let near = matches!(
        relaxed.status,
        nlp::Status::Solved | nlp::Status::Acceptable
    ) || (relaxed.status != nlp::Status::Interrupted
        && relaxed.residuals.primal <= 1e-4
        && sigma <= 1e-2);
    let exact = if settings.crossover && near {
        cross_over(problem, settings, &relaxed, end.attempts, watch)
    } else {
        None
    };
    let status = match (relaxed.status, watch.stop) {
        // a pause is no end
        (nlp::Status::Solved, Some(reason)) if settings.crossover => Status::Failed(reason),
        (nlp::Status::Solved, _) => Status::Relaxed,
        (nlp::Status::Infeasible, _) => Status::Infeasible,
        (status, _) => Status::Failed(status),
    };
    let mut solution = Solution {
        status,
        objective: relaxed.objective,
        x: relaxed.x,
        multipliers: relaxed.multipliers,
        multipliers_lower: relaxed.multipliers_lower,
        multipliers_upper: relaxed.multipliers_upper,
        residuals: Residuals {
            primal: relaxed.residuals.primal,
            dual: relaxed.residuals.dual,
            complementarity: 0.0,
        },
        certificate: None,
        rule,
        relaxation_parameter: sigma,
        iterations: watch.iterations,
        crossover_iterations: watch.crossover_iterations,
        certificate_iterations: watch.certificate_iterations,
        repairs: 0,
        neighbours: 0,
        factorizations: watch.factorizations,
        history: relaxed.history,
        violations: relaxed.violations,
    };
    let vanishes = match exact {
        Some(exact) => {
            solution.repairs = exact.repairs;
            exact.describe(problem, &mut solution)
        }
        None => {
            name_pairs(problem, settings, &mut solution);
            Vec::new()
        }
    };
    Ended {
        solution,
        vanishes,
        resumed: false,
    }
}

/// Measures complementarity at a relaxed point, and adds the pairs that violate it to the violations.
fn name_pairs(problem: &dyn Mpcc, settings: &Settings, solution: &mut Solution) {
    let infeasible = solution.status == Status::Infeasible;
    for (k, &(i, j)) in problem.complementarities().iter().enumerate() {
        let (a, b) = (solution.x[i], solution.x[j]);
        let amount = a.min(b);
        solution.residuals.complementarity = solution.residuals.complementarity.max(amount);
        // at an infeasible point the pairs at their relaxation are to blame
        let binding = !infeasible || a * b >= BINDING * solution.relaxation_parameter;
        if binding && a * b > 10.0 * settings.final_relaxation {
            solution.violations.push(Violation {
                name: problem.complementarity_name(k),
                amount,
            });
        }
    }
    let violations = &mut solution.violations;
    violations.sort_by(|a, b| b.amount.total_cmp(&a.amount));
    violations.truncate(10);
}
