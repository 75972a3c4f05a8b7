//! From the end of a relaxed run to a result: crossover, certificate, and the names of what is violated.

use super::crossover::cross_over;
use super::watch::{Purpose, Watch};
use super::{Mpcc, RelaxationRule, Residuals, Settings, Solution, Status};
use crate::nlp::{self, BarrierPath, InputError, NlpProblem, Products, Violation};

/// Where a relaxed run ended and how it crosses over from there.
#[derive(Clone, Copy)]
pub(crate) struct End {
    sigma: f64,
    is_last: bool,
}

impl End {
    /// A pause for a first crossover.
    pub(crate) fn pause(sigma: f64) -> Self {
        Self {
            sigma,
            is_last: false,
        }
    }

    /// The end of the last run of a rule.
    pub(crate) fn last(sigma: f64) -> Self {
        Self {
            sigma,
            is_last: true,
        }
    }
}

/// Share of the relaxation from which a product is binding.
pub(crate) const BINDING: f64 = 0.9;

/// Crossover and certificate of a relaxed run.
pub(crate) fn finish(
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
        cross_over(problem, settings, &relaxed, end.is_last, watch)
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
        violation_stationarity: relaxed.violation_stationarity,
        certificate: None,
        rule,
        relaxation_parameter: sigma,
        iterations: watch.iterations,
        crossover_iterations: watch.crossover_iterations,
        certificate_iterations: watch.certificate_iterations,
        resumed: false,
        factorizations: watch.factorizations,
        cpu: watch.cpu,
        history: relaxed.history,
        violations: relaxed.violations,
    };
    match exact {
        Some(exact) => exact.describe(problem, &mut solution),
        None => name_pairs(problem, settings, &mut solution),
    }
    solution
}

/// The better one of two results is less.
pub(crate) fn compare(a: &Solution, b: &Solution) -> std::cmp::Ordering {
    let ((a_rank, a_value), (b_rank, b_value)) = (rank(a), rank(b));
    let by_objective = a.objective.total_cmp(&b.objective);
    a_rank
        .cmp(&b_rank)
        .then(a_value.total_cmp(&b_value))
        .then(by_objective)
}

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
