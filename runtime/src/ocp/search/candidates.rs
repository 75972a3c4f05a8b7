//! From motions that may be near an optimum to local optima: the contact sequences that they suggest.

use hangtime_solver::mpcc::Stationarity;

use super::attempt::{Attempt, Attempts, Local, Purpose};
use super::repair::repair;
use super::replay::{read_replay, simulate};
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::effort::Effort;
use crate::ocp::global::{coarse_to_fine, time_freezing_search};
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::edit_sequence::{ending, tidied, touching, untouched, without_jumps};
use crate::ocp::motion::sequence::Sequence;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::Runner;
use crate::ocp::settings::Formulation;
use crate::ocp::solution::TimeFreezingReport;
use crate::simulation::{InputError, SimulationStatus};

/// Most switches of short contacts and flights for which a sequence is tried with them, too.
const SHORT_SWITCHES: usize = 2;

/// The local optima that a search has found, the best first, with what is proved about their sequences.
#[derive(Default)]
pub(in crate::ocp) struct Found<'a> {
    pub(in crate::ocp) optima: Vec<(Local<'a>, Stationarity)>,
    /// The complementarity problem before the polish, where it was asked for.
    pub(in crate::ocp) time_freezing: Option<TimeFreezingReport>,
}

/// The search on one grid.
pub(in crate::ocp) struct Search<'a, 'e> {
    pub(in crate::ocp) attempts: Attempts<'a, 'e>,
    pub(in crate::ocp) found: Found<'a>,
}

impl<'a> Search<'a, '_> {
    /// Adds the local optima that the motions of the global phase lead to. `simulated` is a guess that is the motion under
    /// its controls.
    pub(in crate::ocp) fn try_guess(
        &mut self,
        runner: &mut Runner,
        guess: &Trajectory,
        simulated: bool,
    ) -> Result<(), InputError> {
        if runner.stopped() {
            return Ok(());
        }
        let setting = self.attempts.setting;
        let known = runner.take_failure();
        let relaxed = match &runner.settings.formulation {
            Formulation::Phases => coarse_to_fine::candidates(runner, setting, guess)?,
            Formulation::TimeFreezing(formulation) => {
                let (report, candidate) = time_freezing_search::candidate(
                    runner,
                    setting,
                    formulation,
                    guess,
                    simulated,
                )?;
                self.found.time_freezing = Some(report);
                candidate.into_iter().collect()
            }
        };
        let bouncing = bouncing(runner, setting, guess)?;
        if known.is_some() || !relaxed.is_empty() {
            // Rows of the programs of contact sequences say more than those of relaxed ones.
            runner.set_failure(known);
        }
        let relaxed = relaxed.into_iter().take(runner.settings.refined_motions);
        for candidate in bouncing.into_iter().chain(relaxed) {
            if runner.stopped() {
                break;
            }
            self.try_candidate(runner, candidate, false)?;
        }
        Ok(())
    }

    /// Whether a plan lies at an end of the final times that are looked at.
    fn lies_at_an_end(&self, plan: &Local) -> bool {
        let range = self.attempts.setting.final_times();
        range.end_at(plan.trajectory.horizon).is_some()
    }

    /// Adds the local optimum that a candidate leads to; of one that is known to be near, by the first sequence that
    /// allows a motion.
    pub(in crate::ocp) fn try_candidate(
        &mut self,
        runner: &mut Runner,
        candidate: Candidate,
        near: bool,
    ) -> Result<(), InputError> {
        attempt_readings(runner, &mut self.attempts, candidate, near)?;
        // A plan at an end of the final times that are looked at is none: they are moved.
        let best = self.attempts.best.as_ref();
        let stationarity = if best.is_some_and(|best| self.lies_at_an_end(best)) {
            Stationarity::None
        } else {
            repair(runner, &mut self.attempts)?
        };
        if let Some(best) = self.attempts.best.take() {
            let objective = best.solution.objective;
            let optima = &mut self.found.optima;
            let place = optima.partition_point(|(l, _)| l.solution.objective < objective);
            optima.insert(place, (best, stationarity));
        }
        Ok(())
    }
}

/// The motion under the guessed controls, where a contact bounces: the global phase knows no bounce.
fn bouncing(
    runner: &Runner,
    setting: Setting,
    guess: &Trajectory,
) -> Result<Option<Candidate>, InputError> {
    let model = setting.model;
    let mut contacts = 0..model.declaration().contacts.len();
    if contacts.all(|contact| model.restitution(contact) == 0.0) {
        return Ok(None);
    }
    let replay = simulate(setting, guess, runner.settings.replay_tolerance)?;
    if replay.status != SimulationStatus::Solved {
        return Ok(None);
    }
    let (horizon, controls) = (guess.horizon, guess.controls.clone());
    Ok(Some(Candidate {
        objective: f64::INFINITY,
        sequence: read_replay(setting, &replay, guess),
        trajectory: Trajectory::of_simulation(model, &replay, horizon, controls),
    }))
}

/// A sequence to attempt and the motion to start it from.
type Reading<'t> = (Sequence, &'t Trajectory);

/// Attempts the sequences that a candidate suggests. It and the event-driven motion under the same
/// controls may disagree where the motion is sensitive, and short contacts may be meant or not: all are
/// tried, the likely ones first.
fn attempt_readings(
    runner: &mut Runner,
    attempts: &mut Attempts,
    candidate: Candidate,
    near: bool,
) -> Result<(), InputError> {
    let setting = attempts.setting;
    let intervals = setting.problem.intervals;
    let motions = motions(runner, setting, candidate)?;
    let (mut likely, ending) = readings(&motions, intervals);
    if near
        && runner.effort == Effort::Certify
        && let Some((plan, motion)) = motions.last()
    {
        // What is to be judged is the plan as it is, whatever other readings make of it.
        likely.insert(0, (plan.clone(), motion));
    }
    let count = likely.len();
    for (index, (sequence, guess)) in likely.into_iter().chain(ending).enumerate() {
        if index >= count && attempts.best.is_some() {
            break;
        }
        let Some(sequence) = sequence.ordered(intervals) else {
            continue;
        };
        let enough = runner.stopped() || near && attempts.best.is_some();
        if !enough && !attempts.was_tried(&sequence) {
            let attempt = Attempt {
                sequence: &sequence,
                guess,
                cuts: &[],
                purpose: Purpose::Explore,
            };
            attempts.attempt(runner, attempt)?;
        }
    }
    Ok(())
}

/// A candidate with controls of the shape asked for, and before it the event-driven motion under these controls.
fn motions(
    runner: &Runner,
    setting: Setting,
    mut candidate: Candidate,
) -> Result<Vec<(Sequence, Trajectory)>, InputError> {
    if setting.shape == ControlShape::Linear {
        candidate.sequence = without_jumps(candidate.sequence);
        let controls = &candidate.trajectory.controls;
        let intervals = setting.problem.intervals;
        candidate.trajectory.controls = controls.resampled(ControlShape::Linear, intervals);
    }
    let trajectory = &candidate.trajectory;
    let replay = simulate(setting, trajectory, runner.settings.replay_tolerance)?;
    let mut motions = Vec::new();
    if replay.status == SimulationStatus::Solved {
        let (horizon, controls) = (trajectory.horizon, trajectory.controls.clone());
        motions.push((
            read_replay(setting, &replay, trajectory),
            Trajectory::of_simulation(setting.model, &replay, horizon, controls),
        ));
    }
    motions.push((candidate.sequence, candidate.trajectory));
    Ok(motions)
}

/// The sequences that motions suggest, and those that end the motion with its last impact, which are looked at where
/// nothing else has a solution.
fn readings(
    motions: &[(Sequence, Trajectory)],
    intervals: usize,
) -> (Vec<Reading<'_>>, Vec<Reading<'_>>) {
    let tidy = motions
        .iter()
        .map(|(sequence, motion)| (tidied(sequence.clone()), motion));
    let untouched = motions
        .iter()
        .filter_map(|(sequence, motion)| Some((tidied(untouched(sequence)?), motion)));
    let raw = motions.iter().filter(|(sequence, _)| {
        let short = sequence.switches.len() - tidied(sequence.clone()).switches.len();
        short <= SHORT_SWITCHES
    });
    let raw = raw.map(|(sequence, motion)| (sequence.clone(), motion));
    let touching = motions
        .iter()
        .filter_map(|(sequence, motion)| Some((touching(sequence)?, motion)));
    let ending = motions
        .iter()
        .filter_map(|(sequence, motion)| Some((ending(sequence, intervals)?, motion)));
    (
        tidy.chain(untouched).chain(raw).chain(touching).collect(),
        ending.collect(),
    )
}
