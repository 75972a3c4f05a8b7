//! The error of a run on the grid that was asked for, by runs on others.
//!
//! What a method knows of its steps says nothing of what the motion makes of their errors: bounces multiply them, and a
//! switch that was missed changes everything after it. The distance to a run on another grid contains both. It knows
//! nothing of what both runs do wrong alike, such as damping an oscillation to rest, which the errors of the steps know.
//!
//! A method that locates no switches has errors that depend on where its steps happen to end, so that two runs may agree by
//! chance: it is compared with several, all along the way, and what lies between its steps is looked at.

use super::agreement::{Comparison, Spent, share};
use super::sentences::leaps;
use super::watch::Watch;
use super::{Diagnosis, InitialValueProblem, Simulation, SimulationStatus};
use super::{along, poles};
use crate::model::Model;
use crate::yardstick;

/// Estimated error above which a run that locates nothing is none: the largest values themselves, of which it then says nothing.
const WORTHLESS: f64 = 1.0;
/// Steps of a run that is compared with another one, besides half of them: what steps of one length do not see of an
/// oscillation, because they are some of its periods, twice that length does not see either.
const INCOMMENSURABLE: f64 = 0.618;

/// A method on another grid.
pub(super) struct OtherGrid<M> {
    pub(super) method: M,
    /// What is different, for a note: "half the steps".
    pub(super) words: &'static str,
}

impl<M> OtherGrid<M> {
    /// The grids to compare one of `steps` steps with, that of a method that locates no switches; `method` is the method on so
    /// many.
    pub(super) fn of_steps(steps: usize, method: impl Fn(usize) -> M) -> [Self; 2] {
        let (other, words) = other_steps(steps);
        let fewer = (INCOMMENSURABLE * steps as f64).round() as usize;
        // Few steps are compared with more.
        let fewer = if fewer <= other || fewer >= steps {
            2 * steps + 1
        } else {
            fewer
        };
        [(other, words), (fewer, "another number of steps")].map(|(steps, words)| Self {
            method: method(steps),
            words,
        })
    }
}

/// Steps of the run that is compared with one of `steps` steps, and in words.
pub(super) fn other_steps(steps: usize) -> (usize, &'static str) {
    match steps {
        0 | 1 => (2, "twice the steps"),
        _ => (steps.div_ceil(2), "half the steps"),
    }
}

/// How runs of a method on several grids are judged.
pub(super) struct Judge {
    /// What to do about a large error, for a note.
    pub(super) remedy: &'static str,
    /// Whether the method locates switches: then one other run says enough.
    pub(super) locates: bool,
}

/// Runs `simulate` for `others`, all of them or the first that gets to the horizon, and for the `asked` method, whose
/// `error_estimate` becomes how far they are apart, unless what the method estimates itself is more: for a method of order
/// `p` and half the steps `2^p - 1` times the error. It is infinite where one of the others does not get there, or none. Counts
/// are those of all runs; a large estimate is a note.
pub(super) fn estimated<M>(
    asked: &M,
    others: impl IntoIterator<Item = OtherGrid<M>>,
    judge: &Judge,
    scene: (&dyn Model, &InitialValueProblem),
    watch: &mut Watch<'_>,
    simulate: impl Fn(&M, &mut Watch<'_>) -> Simulation,
) -> Simulation {
    let mut spent = Spent::default();
    let mut compared = Vec::new();
    for other in others {
        watch.restart(false);
        let run = simulate(&other.method, watch);
        spent.add(&run);
        if matches!(run.status, SimulationStatus::Interrupted(_)) {
            return spent.charge(run);
        }
        let solved = run.status.is_solved();
        if judge.locates {
            compared.clear();
        }
        compared.push((run, other.words));
        if judge.locates && solved {
            break;
        }
    }
    watch.restart(true);
    let mut run = simulate(asked, watch);
    spent.add(&run);
    let interrupted = matches!(run.status, SimulationStatus::Interrupted(_));
    if !judge.locates
        && !interrupted
        && let Some(status) = leapt(&run, scene.0)
    {
        run.status = status;
    }
    if !run.status.is_solved() {
        return spent.charge(run);
    }
    let unsolved = compared.iter().find(|(other, _)| !other.status.is_solved());
    if let Some((other, words)) = unsolved {
        let end = other.status.name();
        run.notes.push(format!(
            "nothing is known of the error: with {words} the run ends `{end}`; {}",
            judge.remedy
        ));
        run.error_estimate = Some(f64::INFINITY);
        return spent.charge(run);
    }
    let found = error(&mut run, &compared, judge, scene);
    say(&mut run, found, judge);
    spent.charge(run)
}

/// Says what a run with this `error` is worth, which is known by something `until` a time \[s\].
fn say(run: &mut Simulation, (error, by, until): (f64, &'static str, f64), judge: &Judge) {
    run.error_estimate = Some(error);
    if error > WORTHLESS && !judge.locates {
        run.status = SimulationStatus::Inaccurate(Diagnosis {
            time: until,
            step: 0,
            contact: None,
            message: format!(
                "the error is estimated at {error:.0e} of the largest values, by {by}, so that the run says nothing of the \
                 motion; {}",
                judge.remedy
            ),
        });
    } else if error > yardstick::VISIBLE {
        run.notes.push(format!(
            "the error is estimated at {error:.0e} of the largest values, by {by}; {}",
            judge.remedy
        ));
    }
}

/// The error of a run by the distance to others and by what it knows itself, what says so, and the time \[s\] up to which all
/// have the same events.
fn error(
    run: &mut Simulation,
    others: &[(Simulation, &'static str)],
    judge: &Judge,
    scene: (&dyn Model, &InitialValueProblem),
) -> (f64, &'static str, f64) {
    let own = run.error_estimate.take().unwrap_or(0.0);
    let mut largest = (own, "the errors of its steps");
    let mut take = |error: f64, by: &'static str| {
        if error > largest.0 {
            largest = (error, by);
        }
    };
    let mut until = f64::INFINITY;
    for (other, words) in others {
        run.error_estimate = None;
        let compared = Comparison::of(other, run, scene, yardstick::VISIBLE);
        take(compared.error, words);
        until = until.min(compared.until);
        if !judge.locates {
            take(share(run, scene, &along::apart(other, run)), words);
        }
    }
    if !judge.locates {
        let missed = along::passed_over(run, scene);
        take(share(run, scene, &missed), "contacts between its steps");
    }
    let until = if until.is_finite() { until } else { 0.0 };
    (largest.0, largest.1, until)
}

/// The status of a run that has flown through a surface whose gap changes its sign without passing zero, or through a pole.
fn leapt(run: &Simulation, model: &dyn Model) -> Option<SimulationStatus> {
    let leap = along::leap(run, model).map(|(time, contact)| (time, Some(contact)));
    let pole = poles::first_passed(run, model);
    let earlier = |a: &(f64, Option<usize>), b: &(f64, Option<usize>)| a.0.total_cmp(&b.0);
    let (time, contact) = leap.into_iter().chain(pole).min_by(earlier)?;
    let steps = &run.trajectory.time;
    let message = match contact {
        Some(contact) => leaps(model.declaration().contacts[contact].name),
        None => "an acceleration passes a pole; check divisions of the scene".into(),
    };
    Some(SimulationStatus::NotFinite(Diagnosis {
        time,
        step: steps
            .partition_point(|start| *start < time)
            .saturating_sub(1),
        contact,
        message,
    }))
}
