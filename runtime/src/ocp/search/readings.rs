//! From a motion that may be near an optimum to local optima: the contact sequences that it suggests.

use super::attempt::{Attempt, Attempts, Purpose};
use super::replay::simulations;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::edit_sequence::{
    at_interval_ends, ending, tidied, touching, untouched, without_jumps,
};
use crate::ocp::motion::sequence::Sequence;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::Runner;
use crate::ocp::tuning::candidates::SHORT_SWITCHES;
use crate::simulation::InputError;

/// Which of the sequences that a candidate suggests are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::ocp) enum Readings {
    /// All of them: it may be far from any motion.
    All,
    /// Its own, and then the others up to the first that allows a motion: it is near to one.
    Own,
}

/// A sequence to attempt and the motion to start it from.
type Reading<'t> = (Sequence, &'t Trajectory);

/// Attempts the sequences that a candidate suggests. It and the event-driven motion under the same
/// controls may disagree where the motion is sensitive, and short contacts may be meant or not: all are
/// tried, the likely ones first.
pub(in crate::ocp) fn attempt_readings(
    runner: &mut Runner,
    attempts: &mut Attempts,
    candidate: Candidate,
    which: Readings,
) -> Result<(), InputError> {
    let setting = attempts.setting;
    let intervals = setting.problem.intervals;
    let plan = shaped(setting, candidate);
    if which == Readings::Own {
        // What is to be judged is the plan as it is, whatever other readings make of it.
        let own = (&plan.sequence, &plan.trajectory);
        attempt_new(runner, attempts, own, Purpose::Near);
        if attempts.best.is_some() {
            return Ok(());
        }
    }
    let motions = motions(runner, setting, plan)?;
    let (likely, other) = readings(&motions, intervals);
    let count = likely.len();
    for (index, (sequence, guess)) in likely.iter().chain(&other).enumerate() {
        let found = attempts.best.is_some();
        if runner.stopped() || found && (index >= count || which == Readings::Own) {
            break;
        }
        attempt_new(runner, attempts, (sequence, guess), Purpose::Explore);
    }
    Ok(())
}

/// Attempts a sequence about which nothing is claimed, unless it is none or was attempted before.
fn attempt_new(
    runner: &mut Runner,
    attempts: &mut Attempts,
    (sequence, guess): (&Sequence, &Trajectory),
    purpose: Purpose,
) {
    let intervals = attempts.setting.problem.intervals;
    let Some(sequence) = sequence.clone().ordered(intervals) else {
        return;
    };
    if !attempts.was_tried(&sequence) {
        let attempt = Attempt {
            sequence: &sequence,
            guess,
            cuts: &[],
            purpose,
        };
        attempts.attempt(runner, attempt);
    }
}

/// A candidate, and before it the event-driven motion under its controls.
fn motions(
    runner: &Runner,
    setting: Setting,
    candidate: Candidate,
) -> Result<Vec<(Sequence, Trajectory)>, InputError> {
    let trajectory = &candidate.trajectory;
    let replay = simulations(setting, trajectory, runner.settings.replay_tolerance)?.into_iter();
    let replay = replay.map(|replay| (replay.sequence, replay.trajectory));
    let mut motions: Vec<(Sequence, Trajectory)> = replay.collect();
    motions.push((candidate.sequence, candidate.trajectory));
    Ok(motions)
}

/// A candidate with controls of the shape asked for.
fn shaped(setting: Setting, mut candidate: Candidate) -> Candidate {
    if setting.shape == ControlShape::Linear {
        candidate.sequence = without_jumps(candidate.sequence);
        let controls = &candidate.trajectory.controls;
        let intervals = setting.problem.intervals;
        candidate.trajectory.controls = controls.resampled(ControlShape::Linear, intervals);
    }
    candidate
}

/// The sequences that motions suggest, and those with impacts at ends of intervals, or at the end of the motion, which are looked at
/// where nothing else has a solution.
fn readings(
    motions: &[(Sequence, Trajectory)],
    intervals: usize,
) -> (Vec<Reading<'_>>, Vec<Reading<'_>>) {
    let edited = |edit: &dyn Fn(&Sequence) -> Option<Sequence>| -> Vec<Reading<'_>> {
        let readings = motions.iter();
        let readings = readings.filter_map(|(sequence, motion)| Some((edit(sequence)?, motion)));
        readings.collect()
    };
    let tidy = |sequence: &Sequence| tidied(sequence.clone());
    let raw = |sequence: &Sequence| {
        let short = sequence.switches.len() - tidy(sequence).switches.len();
        (short <= SHORT_SWITCHES).then(|| sequence.clone())
    };
    let likely = [
        edited(&|sequence| Some(tidy(sequence))),
        edited(&|sequence| untouched(sequence).map(tidied)),
        edited(&raw),
        edited(&touching),
    ];
    let other = [
        edited(&|sequence| at_interval_ends(&tidy(sequence), intervals)),
        edited(&|sequence| ending(sequence, intervals)),
    ];
    (likely.concat(), other.concat())
}
