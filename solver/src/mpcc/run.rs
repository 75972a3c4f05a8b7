//! One rule from start to certificate: relaxed runs and crossover.

use super::elastic::elastic;
use super::finish::{End, finish, relax};
use super::relaxation::{Continuation, Tied, proportional, roll_off};
use super::watch::Watch;
use super::{Mpcc, RelaxationRule, Settings, Solution};
use crate::nlp::{self, BarrierPath, InputError, Products};

/// `sigma` and tolerance at which a relaxed run pauses for a first crossover. Fixed sides are reliable
/// from about `sigma = 1e-4` on; the roll-off rule passes that at `mu = 2e-6`.
pub(crate) const PAUSE_RELAXATION: f64 = 1e-5;
const PAUSE_TOLERANCE: f64 = 2e-5;

/// Settings of a run up to a pause.
pub(crate) fn paused(interior_point: &nlp::Settings) -> nlp::Settings {
    nlp::Settings {
        tolerance: PAUSE_TOLERANCE,
        acceptable_tolerance: interior_point.acceptable_tolerance.max(PAUSE_TOLERANCE),
        constraint_tolerance: interior_point.constraint_tolerance.max(PAUSE_TOLERANCE),
        ..interior_point.clone()
    }
}

/// A path by a rule from `(mu, sigma)` on.
pub(crate) fn make_path(
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
) -> Result<Solution, InputError> {
    if rule == RelaxationRule::Elastic {
        return elastic(problem, settings, watch);
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
    let (first, floor) = if pauses {
        (paused(interior_point), PAUSE_RELAXATION)
    } else {
        (interior_point.clone(), settings.final_relaxation)
    };
    let mut path = make_path(rule, start, first.tolerance, floor);
    let paused = relax(problem, &first, (&mut products, &mut *path), None, watch)?;
    if !pauses || paused.status != nlp::Status::Solved {
        let end = End::last(products.sigma);
        return Ok(finish(problem, settings, rule, paused, end, watch));
    }
    let limit = paused.objective + 1e-2 * paused.objective.abs().max(1.0);
    let end = End::pause(products.sigma);
    let ended = finish(problem, settings, rule, paused.clone(), end, watch);
    let near = ended.status.is_solved() && ended.objective <= limit;
    if near || watch.stop.is_some() {
        return Ok(ended);
    }
    let second = resume(problem, settings, rule, (paused, products), watch)?;
    let (before, after) = (&ended, &second);
    let better = before.status.is_solved()
        && (!after.status.is_solved() || before.objective < after.objective);
    Ok(Solution {
        resumed: true,
        ..if better { ended } else { second }
    })
}

/// Goes on from a pause to the final `sigma`, and crosses over from there.
fn resume(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    rule: RelaxationRule,
    (paused, mut products): (nlp::Solution, Products),
    watch: &mut Watch<'_>,
) -> Result<Solution, InputError> {
    let interior_point = &settings.interior_point;
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
    let end = End::last(products.sigma);
    Ok(finish(problem, settings, rule, relaxed, end, watch))
}
