//! What is tried where no rule ended at a certified point.

use super::crossover::{choose, descend_from, patient_point};
use super::finish::compare;
use super::run::solve_with;
use super::watch::Watch;
use super::{Mpcc, RelaxationRule, Settings, Solution, Status};
use crate::nlp::{self, InputError, Variant};

/// Violation and relaxation up to which a relaxed point shows the sides of an exact one, optimal or not.
const NEAR: f64 = 1e-6;

/// Where no rule ended at a certified point: crossovers with more patience from where they ended, the best first; then from exact points
/// near these and near the point of the problem, found without the objective.
pub(crate) fn second_round(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    best: &mut Solution,
    others: &[Solution],
    watch: &mut Watch<'_>,
) -> Result<(), InputError> {
    let first = best.clone();
    let diverging = Status::Failed(nlp::Status::Diverging);
    if first.status == diverging || others.iter().any(|o| o.status == diverging) {
        // unbounded
        return Ok(());
    }
    let ends = std::iter::once(&first).chain(others);
    // where the violation is stationary there is nothing to start from
    let ends: Vec<&Solution> = ends
        .filter(|end| end.status != Status::Infeasible)
        .collect();
    for &end in &ends {
        let from = end.warm_start(0.0);
        let vanishes = choose(problem, &from);
        try_choice(problem, settings, (end, vanishes, &from), best, watch);
        if best.status.is_solved() || watch.stop.is_some() {
            return Ok(());
        }
    }
    let mut points: Vec<(&Solution, Vec<f64>)> =
        ends.iter().map(|&end| (end, end.x.clone())).collect();
    let mut initial = vec![0.0; first.x.len()];
    problem.initial_point(&mut initial);
    points.push((&first, initial));
    for (end, x) in &points {
        for rule in [RelaxationRule::RollOff, RelaxationRule::Elastic] {
            let Some((vanishes, from)) = nearest(problem, settings, rule, x, watch)? else {
                continue;
            };
            try_choice(problem, settings, (end, vanishes, &from), best, watch);
            if best.status.is_solved() || watch.stop.is_some() {
                return Ok(());
            }
        }
    }
    Ok(())
}

/// Tries a choice of sides, from a start.
fn try_choice(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    (start, vanishes, from): (&Solution, Vec<bool>, &nlp::WarmStart),
    best: &mut Solution,
    watch: &mut Watch<'_>,
) {
    let Some(point) = patient_point(problem, settings, &vanishes, from, false, watch) else {
        return;
    };
    let exact = descend_from(problem, settings, vanishes, point, watch);
    let mut solution = start.clone();
    exact.describe(problem, &mut solution);
    if compare(&solution, best).is_lt() {
        *best = solution;
    }
}

/// A choice of sides that has a point near a given one, and that point.
fn nearest(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    rule: RelaxationRule,
    to: &[f64],
    watch: &mut Watch<'_>,
) -> Result<Option<(Vec<bool>, nlp::WarmStart)>, InputError> {
    let relaxed = Settings {
        crossover: false,
        ..settings.clone()
    };
    let mut near = Variant::nearest(problem, to);
    let relaxed = solve_with(&mut near, &relaxed, rule, watch)?;
    let is_near = relaxed.residuals.primal <= NEAR && relaxed.relaxation_parameter <= NEAR;
    if watch.stop.is_some() || !is_near {
        return Ok(None);
    }
    let from = relaxed.warm_start(0.0);
    let vanishes = choose(&mut near, &from);
    let point = patient_point(&mut near, settings, &vanishes, &from, true, watch);
    Ok(point.map(|point| {
        let from = nlp::WarmStart {
            // those of the distance say nothing about the objective
            multipliers: vec![0.0; point.multipliers.len()],
            multipliers_lower: vec![0.0; point.x.len()],
            multipliers_upper: vec![0.0; point.x.len()],
            ..nlp::WarmStart::from_solution(&point)
        };
        (vanishes, from)
    }))
}
