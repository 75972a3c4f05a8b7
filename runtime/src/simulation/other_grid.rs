//! The error of a run on the grid that was asked for, by a run on another one.
//!
//! What a method knows of its steps says nothing of what the motion makes of their errors: bounces multiply them, and a
//! switch that was missed changes everything after it. The distance to a run on another grid contains both. It knows
//! nothing of what both runs do wrong alike, such as damping an oscillation to rest, which the errors of the steps know.

use super::agreement::{Comparison, Spent};
use super::watch::Watch;
use super::{InitialValueProblem, Simulation, SimulationStatus};
use crate::model::Model;

/// Estimated error above which a run says so: what a curve in a figure shows.
const SUSPECT: f64 = 1e-3;

/// A method on another grid.
pub(super) struct OtherGrid<M> {
    pub(super) method: M,
    /// What is different, for a note: "half the steps".
    pub(super) words: &'static str,
}

impl<M> OtherGrid<M> {
    /// The grid to compare one of `steps` steps with: half of them, or two for one; `method` is the method on so many.
    pub(super) fn of_steps(steps: usize, method: impl FnOnce(usize) -> M) -> Self {
        let (steps, words) = other_steps(steps);
        Self {
            method: method(steps),
            words,
        }
    }
}

/// Steps of the run that is compared with one of `steps` steps, and in words.
pub(super) fn other_steps(steps: usize) -> (usize, &'static str) {
    match steps {
        0 | 1 => (2, "twice the steps"),
        _ => (steps.div_ceil(2), "half the steps"),
    }
}

/// Runs `simulate` for one of the `others`, the first of them that gets to the horizon, and for the `asked` method, whose
/// `error_estimate` becomes how far they are apart, unless what the method estimates itself is more: for a method of order
/// `p` and half the steps `2^p - 1` times the error. It is infinite where none of the others gets there. Counts are those
/// of all runs; a large estimate is a note, with the `remedy`.
pub(super) fn estimated<M>(
    asked: &M,
    others: impl IntoIterator<Item = OtherGrid<M>>,
    remedy: &str,
    (model, problem): (&dyn Model, &InitialValueProblem),
    watch: &mut Watch<'_>,
    simulate: impl Fn(&M, &mut Watch<'_>) -> Simulation,
) -> Simulation {
    let mut spent = Spent::default();
    let mut compared = None;
    for other in others {
        watch.restart(false);
        let run = simulate(&other.method, watch);
        spent.add(&run);
        if matches!(run.status, SimulationStatus::Interrupted(_)) {
            return spent.charge(run);
        }
        let solved = run.status.is_solved();
        compared = Some((run, other.words));
        if solved {
            break;
        }
    }
    watch.restart(true);
    let mut run = simulate(asked, watch);
    spent.add(&run);
    let Some((other, words)) = compared.filter(|_| run.status.is_solved()) else {
        return spent.charge(run);
    };
    let alone = run.error_estimate.unwrap_or(0.0);
    let apart = if other.status.is_solved() {
        Comparison::of(&other, &mut run, (model, problem), f64::INFINITY).error
    } else {
        f64::INFINITY
    };
    run.error_estimate = Some(apart.max(alone));
    if !other.status.is_solved() {
        let end = other.status.name();
        run.notes.push(format!(
            "nothing is known of the error: with {words} the run ends `{end}`; {remedy}"
        ));
    } else if apart.max(alone) > SUSPECT {
        let by = if apart < alone {
            "the errors of its elements"
        } else {
            words
        };
        run.notes.push(format!(
            "the error is estimated at {:.0e} of the largest values, by {by}; {remedy}",
            apart.max(alone)
        ));
    }
    spent.charge(run)
}
