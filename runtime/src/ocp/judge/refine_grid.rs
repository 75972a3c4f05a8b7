//! Refinement of the grid: more elements in the intervals over which a plan departs from the motion.
//!
//! The error of an interval is the distance between plan and event-driven simulation at its end, where both start from
//! the same state. What errors grow to until the end is not known beforehand, but the re-simulation shows how much
//! larger than their sum its distance is.

use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::Runner;
use crate::simulation::{EventDriven, simulate_once};

/// Rounds in which the grid is refined.
pub(in crate::ocp) const ROUNDS: usize = 4;

/// Most elements of a phase.
const MOST_ELEMENTS: usize = 64;

/// Largest growth of the number of elements in a round: far from its end the order of the scheme promises too much.
const MOST_GROWTH: f64 = 4.0;

/// Share of the allowed distance that the refined intervals aim for.
const AIM: f64 = 0.5;

/// Divides the elements of the intervals whose errors are too large for a distance within the allowed one, where the
/// re-simulation ends at `distance` from the plan, measured as that is; says whether there are any.
pub(in crate::ocp) fn refine(
    runner: &Runner,
    setting: Setting,
    elements: &mut [usize],
    plan: &Trajectory,
    distance: f64,
) -> bool {
    let intervals = setting.problem.intervals;
    let errors = if setting.model.declaration().explicit_time {
        // A simulation cannot start at another time than 0: all intervals share the distance.
        vec![distance / intervals as f64; intervals]
    } else {
        errors(setting, plan, runner.settings.resimulation_tolerance)
    };
    let sum: f64 = errors.iter().sum();
    let growth = distance / sum;
    let growth = if growth.is_finite() {
        growth.max(1.0)
    } else {
        1.0
    };
    let allowed = AIM * runner.settings.largest_distance / (growth * intervals as f64);
    let order = (2 * setting.tableau.stages() - 1) as f64;
    let mut refined = false;
    for (elements, error) in elements.iter_mut().zip(errors) {
        let wanted = (error / allowed).powf(1.0 / order).ceil();
        let wanted = wanted.clamp(1.0, MOST_GROWTH) as usize;
        let more = (*elements * wanted).min(MOST_ELEMENTS.max(*elements));
        refined |= more > *elements;
        *elements = more;
    }
    refined
}

/// Divides all elements where only the objective departs, by that many times what is let pass; says whether there are any to divide.
pub(in crate::ocp) fn refine_all(setting: Setting, elements: &mut [usize], departure: f64) -> bool {
    let order = (2 * setting.tableau.stages() - 1) as f64;
    let wanted = (departure / AIM).powf(1.0 / order).ceil();
    // A cost that varies faster than the motion converges late: never less than half the length.
    let wanted = wanted.clamp(2.0, MOST_GROWTH) as usize;
    let mut refined = false;
    for elements in elements {
        let more = (*elements * wanted).min(MOST_ELEMENTS.max(*elements));
        refined |= more > *elements;
        *elements = more;
    }
    refined
}

/// The error of each interval.
fn errors(setting: Setting, plan: &Trajectory, tolerance: f64) -> Vec<f64> {
    let Setting { model, problem, .. } = setting;
    let (n, intervals) = (problem.q.len(), problem.intervals);
    let length = plan.horizon / intervals as f64;
    let simulator = EventDriven {
        tolerance,
        output_times: 1,
        ..EventDriven::default()
    };
    (0..intervals)
        .map(|k| {
            let start = plan.at(k as f64 * length, true);
            let end = plan.at((k + 1) as f64 * length, false);
            let controls = plan.controls.signal_of(k, length);
            let motion = problem.initial_value_problem(&start[..2 * n], length, controls);
            // A start that rounding puts below a surface tells nothing about the accuracy.
            let simulation = simulate_once(&simulator, model, &motion);
            let reached = simulation.ok().and_then(|mut s| s.trajectory.q.pop());
            reached.map_or(0.0, |reached| setting.departure(plan, &reached, &end[..n]))
        })
        .collect()
}
