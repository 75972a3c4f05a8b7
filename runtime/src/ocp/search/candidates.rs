//! From motions that may be near an optimum to local optima: the contact sequences that they suggest.

use hangtime_solver::mpcc::Stationarity;

use super::attempt::{Attempt, Attempts, Local, Purpose};
use super::free_lengths::retimed;
use super::reach::reachable;
use super::repair::{Repaired, is_left, repair};
use super::replay::{simulated, simulations};
use super::stepping::stepping;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::effort::Effort;
use crate::ocp::global::coarse_to_fine::{CoarseToFine, RelaxedMotions};
use crate::ocp::global::start_modes::modes_at_start;
use crate::ocp::global::time_freezing_search;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::edit_sequence::{
    at_interval_ends, ending, opening_at_ends, tidied, touching, untouched, without_jumps,
};
use crate::ocp::motion::mode::{closed_mode, is_frictional};
use crate::ocp::motion::sequence::{Sequence, Signature, Switch};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::Runner;
use crate::ocp::program::units::Units;
use crate::ocp::settings::{Formulation, TimeFreezingSettings};
use crate::ocp::solution::TimeFreezingReport;
use crate::ocp::tuning::candidates::{FAILURES, MOST_STRUCK, SHORT_SWITCHES, STRUCK};
use crate::ocp::tuning::candidates::{RETIMED, STUMBLES};
use crate::ocp::tuning::equal::MOTION;
use crate::simulation::{ContactMode, InputError};

/// Which of the sequences that a candidate suggests are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::ocp) enum Readings {
    /// All of them: it may be far from any motion.
    All,
    /// Up to the first that allows a motion: it is near to one, as a known motion is.
    First,
    /// The same, its own before all others: it is a motion.
    Own,
    /// The same, without a program that asks when switches have to be.
    OwnAsTimed,
}

/// What a search has found.
#[derive(Default)]
pub(in crate::ocp) struct Found<'a> {
    /// The local optima, the best first, with what is proved about their sequences.
    pub(in crate::ocp) optima: Vec<(Local<'a>, Stationarity)>,
    /// The start of a search before this one that came to where this one does, too.
    pub(in crate::ocp) repeats: Option<usize>,
    /// The complementarity problem before the polish, where it was asked for.
    pub(in crate::ocp) time_freezing: Option<TimeFreezingReport>,
}

/// The search on one grid.
pub(in crate::ocp) struct Search<'a, 'e> {
    pub(in crate::ocp) attempts: Attempts<'a, 'e>,
    pub(in crate::ocp) found: Found<'a>,
    /// The relaxed motions that it and the searches before it came through.
    pub(in crate::ocp) relaxed: RelaxedMotions,
    /// What is proved of the known motion that it begins with.
    pub(in crate::ocp) proved: Option<Proved>,
}

/// What is proved of a motion.
#[derive(Debug, Clone, Copy)]
pub(in crate::ocp) struct Proved {
    pub(in crate::ocp) stationarity: Stationarity,
    pub(in crate::ocp) objective: f64,
}

impl Proved {
    /// Whether a local optimum is the same one, which was solved less exactly before.
    fn is_of(&self, local: &Local, sequence: &Signature) -> bool {
        let difference = (local.solution.objective - self.objective).abs();
        local.sequence.signature() == *sequence
            && difference <= MOTION * local.program.program.size_of(self.objective)
    }
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
        let first = self.attempts.is_first();
        if let Some(bouncing) = bouncing(runner, self.attempts.setting, guess)? {
            self.try_candidate(runner, bouncing, Readings::All)?;
        }
        if first && runner.settings.formulation == Formulation::Phases {
            self.try_struck(runner, guess)?;
        }
        match &runner.settings.formulation {
            Formulation::Phases => self.try_relaxed(runner, guess),
            Formulation::TimeFreezing(formulation) => {
                self.try_time_freezing(runner, formulation, guess, simulated)
            }
        }
    }

    /// The same of motions to states that controls can lead to, the one that ends nearest to the goals first, until one leads to a
    /// local optimum.
    pub(in crate::ocp) fn try_reachable(&mut self, runner: &mut Runner) -> Result<(), InputError> {
        for candidate in reachable(runner, self.attempts.setting)? {
            if self.found.optima.is_empty() && !runner.stopped() {
                self.attempts.forget();
                self.try_candidate(runner, candidate, Readings::All)?;
            }
        }
        Ok(())
    }

    /// The same of simulated motions, each in its units.
    pub(in crate::ocp) fn try_simulated(
        &mut self,
        runner: &mut Runner,
        motions: &'a [(Candidate, Units)],
    ) -> Result<(), InputError> {
        for (index, (candidate, units)) in motions.iter().enumerate() {
            self.attempts.setting.units = units;
            let candidate = candidate.clone();
            let readings = if self.found.optima.is_empty() && index < RETIMED {
                Readings::Own
            } else {
                Readings::OwnAsTimed
            };
            self.try_candidate(runner, candidate, readings)?;
        }
        Ok(())
    }

    /// The same of motions like the guess in which a contact that bounces is struck a few times: how often, no simulation under
    /// guessed controls tells.
    fn try_struck(&mut self, runner: &mut Runner, guess: &Trajectory) -> Result<(), InputError> {
        let setting = self.attempts.setting;
        let initially = modes_at_start(setting, guess);
        // Where programs that fail are not left, further ones take too long.
        let explores = runner.effort == Effort::Explore;
        let most = if explores { MOST_STRUCK } else { STRUCK };
        let modes = initially.iter().enumerate();
        let bouncing = modes
            .filter(|(contact, mode)| mode.is_open() && setting.model.restitution(*contact) > 0.0);
        let bouncing: Vec<usize> = bouncing.map(|(contact, _)| contact).collect();
        let mut failures = 0;
        for times in 1..=STRUCK {
            for &contact in &bouncing {
                self.try_struck_at(runner, guess, (&[contact], times), &mut failures)?;
            }
        }
        // To and fro between two of them.
        for (i, &one) in bouncing.iter().enumerate() {
            for &other in &bouncing[i + 1..] {
                for times in 2..=STRUCK {
                    for contacts in [[one, other], [other, one]] {
                        self.try_struck_at(runner, guess, (&contacts, times), &mut failures)?;
                    }
                }
            }
        }
        for &contact in &bouncing {
            for times in STRUCK + 1..=most {
                let before = self.least();
                self.try_struck_at(runner, guess, (&[contact], times), &mut failures)?;
                let least = self.least();
                if least.is_finite() && least >= before {
                    break;
                }
            }
        }
        Ok(())
    }

    /// The same of a motion in which contacts are struck in turn so many times, and of one in which that lifts off what else is in
    /// contact; of neither after so many `failures` that no others of the scene are likely to have a motion.
    fn try_struck_at(
        &mut self,
        runner: &mut Runner,
        guess: &Trajectory,
        (contacts, times): (&[usize], usize),
        failures: &mut usize,
    ) -> Result<(), InputError> {
        if *failures >= FAILURES {
            return Ok(());
        }
        let setting = self.attempts.setting;
        let before = self.found.optima.len();
        let struck = struck_at(setting, guess, contacts, &struck(times));
        let lifting = lifting_others(setting, &struck).filter(|_| times <= STRUCK);
        for candidate in std::iter::once(struck).chain(lifting) {
            self.try_candidate(runner, candidate, Readings::First)?;
        }
        let found = self.found.optima.len() > before || self.found.repeats.is_some();
        *failures = if found { 0 } else { *failures + 1 };
        Ok(())
    }

    /// The same of motions like the guess in which surfaces are left and struck in turn, when a program with intervals of free lengths
    /// says so; of no more of them after so many without a solution.
    pub(in crate::ocp) fn try_stepping(
        &mut self,
        runner: &mut Runner,
        guess: &Trajectory,
    ) -> Result<(), InputError> {
        let mut stumbles = 0;
        for sequence in stepping(self.attempts.setting, guess) {
            if stumbles >= STUMBLES {
                break;
            }
            let before = self.found.optima.len();
            if let Some(mut timed) = retimed(runner, &self.attempts, &sequence, guess) {
                timed.sequence = opening_at_ends(timed.sequence);
                self.try_candidate(runner, timed, Readings::Own)?;
            }
            let found = self.found.optima.len() > before || self.found.repeats.is_some();
            stumbles = if found { 0 } else { stumbles + 1 };
        }
        Ok(())
    }

    /// Objective of the best local optimum so far, infinite without any.
    fn least(&self) -> f64 {
        let best = self.found.optima.first();
        best.map_or(f64::INFINITY, |(local, _)| local.solution.objective)
    }

    /// The same of contact-implicit programs: the best of their motions, or, after other searches, one after the other up to
    /// where one of these was before.
    fn try_relaxed(&mut self, runner: &mut Runner, guess: &Trajectory) -> Result<(), InputError> {
        let first = self.relaxed.are_none();
        let mut left = runner.settings.refined_motions;
        let mut phase = CoarseToFine::new(self.attempts.setting, guess);
        let before = self.found.repeats.take();
        while left > 0 && self.found.repeats.is_none() && !runner.stopped() {
            let failure = runner.take_failure();
            let mut found: Vec<Candidate> = Vec::new();
            while (first || found.is_empty())
                && let Some(candidate) = phase.next(runner, &mut self.relaxed)?
            {
                found.push(candidate);
            }
            runner.restore_failure(failure, !found.is_empty());
            if found.is_empty() {
                break;
            }
            found.sort_by(|a, b| a.objective.total_cmp(&b.objective));
            for candidate in found.into_iter().take(left) {
                left -= 1;
                if !runner.stopped() {
                    self.try_candidate(runner, candidate, Readings::All)?;
                }
            }
        }
        self.found.repeats = self.found.repeats.or(phase.repeats).or(before);
        Ok(())
    }

    /// The same of the program of the time-freezing formulation.
    fn try_time_freezing(
        &mut self,
        runner: &mut Runner,
        formulation: &TimeFreezingSettings,
        guess: &Trajectory,
        simulated: bool,
    ) -> Result<(), InputError> {
        let setting = self.attempts.setting;
        let failure = runner.take_failure();
        let relaxed =
            time_freezing_search::candidate(runner, setting, formulation, guess, simulated)?;
        let (report, candidate) = relaxed.unzip();
        let candidate = candidate.flatten();
        self.found.time_freezing = report.or(self.found.time_freezing.take());
        runner.restore_failure(failure, candidate.is_some());
        match candidate {
            Some(candidate) if !runner.stopped() => {
                self.try_candidate(runner, candidate, Readings::All)
            }
            _ => Ok(()),
        }
    }

    /// Whether a plan lies at an end of the final times that are looked at.
    fn lies_at_an_end(&self, plan: &Local) -> bool {
        let range = self.attempts.setting.final_times();
        range.end_at(plan.trajectory.horizon).is_some()
    }

    /// Adds the local optimum that a candidate leads to, unless it was visited before.
    pub(in crate::ocp) fn try_candidate(
        &mut self,
        runner: &mut Runner,
        candidate: Candidate,
        readings: Readings,
    ) -> Result<(), InputError> {
        if !runner.goes_on("collocation") {
            return Ok(());
        }
        let visits = self.attempts.visits();
        let sequence = candidate.sequence.signature();
        attempt_readings(runner, &mut self.attempts, candidate, readings, visits)?;
        let Some(best) = &self.attempts.best else {
            return Ok(());
        };
        let proved = self.proved.filter(|proved| proved.is_of(best, &sequence));
        let repaired = match proved {
            // A plan at an end of the final times that are looked at is none: they are moved.
            _ if self.lies_at_an_end(best) => Repaired::Best(Stationarity::None),
            Some(proved) if !is_left(runner, &mut self.attempts)? => {
                Repaired::Best(proved.stationarity)
            }
            _ => repair(runner, &mut self.attempts, visits)?,
        };
        let best = self.attempts.best.take();
        let outdone = self.attempts.outdone.take();
        let stationarity = match repaired {
            Repaired::Best(stationarity) => stationarity,
            Repaired::Visited { start } => {
                self.found.repeats = Some(start);
                return Ok(());
            }
        };
        // The one before it is what is left where the re-simulation does not confirm it.
        let outdone = outdone.filter(|_| runner.effort.proves());
        let found = best.map(|best| (best, stationarity)).into_iter();
        let found = found.chain(outdone.map(|outdone| (outdone, Stationarity::None)));
        for (local, stationarity) in found {
            let objective = local.solution.objective;
            let optima = &mut self.found.optima;
            let place = optima.partition_point(|(l, _)| l.solution.objective < objective);
            optima.insert(place, (local, stationarity));
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
    simulated(setting, guess, runner.settings.replay_tolerance)
}

/// When a contact is struck so often, in shares of the final time: with half as much time before the first impact and after the last
/// one as in between, as of a ball that flies from height to height.
fn struck(times: usize) -> Vec<f64> {
    (0..times)
        .map(|i| (i as f64 + 0.5) / times as f64)
        .collect()
}

/// A motion like the guess in which contacts are struck in turn at these shares of the final time.
fn struck_at(
    setting: Setting,
    guess: &Trajectory,
    contacts: &[usize],
    shares: &[f64],
) -> Candidate {
    let intervals = setting.problem.intervals as f64;
    let mut sequence = Sequence::without_switches(modes_at_start(setting, guess));
    let touches = shares.iter().zip(contacts.iter().cycle());
    let touches = touches.map(|(share, &contact)| {
        let impulse = closed_mode(is_frictional(setting.model, contact), 0.0, 0.0);
        Switch::touch(contact, impulse, share * intervals)
    });
    sequence.switches = touches.collect();
    Candidate {
        objective: f64::INFINITY,
        sequence,
        trajectory: guess.clone(),
    }
}

/// The same where the first impact lifts off whatever is in contact at the start, if anything is: a ball that is kicked off the ground.
fn lifting_others(setting: Setting, struck: &Candidate) -> Option<Candidate> {
    let mut candidate = struck.clone();
    let first = *candidate.sequence.switches.first()?;
    let declared = setting.model.declaration().contacts;
    let modes = candidate.sequence.initially.iter().enumerate();
    let lifted = modes.filter(|(other, mode)| {
        *other != first.contact && !mode.is_open() && !declared[*other].dry
    });
    let lifts: Vec<Switch> = lifted
        .map(|(contact, _)| Switch {
            contact,
            closes: false,
            impulse: ContactMode::Open,
            accompanies: true,
            ..first
        })
        .collect();
    if lifts.is_empty() {
        return None;
    }
    candidate.sequence.switches.splice(1..1, lifts);
    Some(candidate)
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
    which: Readings,
    visits: usize,
) -> Result<(), InputError> {
    let setting = attempts.setting;
    let intervals = setting.problem.intervals;
    let motions = motions(runner, setting, candidate)?;
    let (mut likely, other) = readings(&motions, intervals);
    let own = match which {
        Readings::All => false,
        Readings::First => runner.effort.proves(),
        Readings::Own | Readings::OwnAsTimed => true,
    };
    if own && let Some((plan, motion)) = motions.last() {
        // What is to be judged is the plan as it is, whatever other readings make of it.
        likely.insert(0, (plan.clone(), motion));
    }
    let count = likely.len();
    for (index, (sequence, guess)) in likely.iter().chain(&other).enumerate() {
        if index >= count && attempts.best.is_some() {
            break;
        }
        let enough = runner.stopped()
            || which != Readings::All && attempts.best.is_some()
            || attempts.visited_from(visits).is_some();
        if !enough {
            attempt_new(runner, attempts, sequence, guess)?;
        }
    }
    if which == Readings::OwnAsTimed {
        return Ok(());
    }
    attempt_retimed(runner, attempts, &likely)
}

/// Attempts a sequence about which nothing is claimed, unless it is none or was attempted before.
fn attempt_new(
    runner: &mut Runner,
    attempts: &mut Attempts,
    sequence: &Sequence,
    guess: &Trajectory,
) -> Result<(), InputError> {
    let intervals = attempts.setting.problem.intervals;
    let Some(sequence) = sequence.clone().ordered(intervals) else {
        return Ok(());
    };
    if !attempts.was_tried(&sequence) {
        let attempt = Attempt {
            sequence: &sequence,
            guess,
            cuts: &[],
            purpose: Purpose::Explore,
        };
        attempts.attempt(runner, attempt)?;
    }
    Ok(())
}

/// Where no reading has a motion, attempts them with their switches when they have to be.
fn attempt_retimed(
    runner: &mut Runner,
    attempts: &mut Attempts,
    readings: &[Reading],
) -> Result<(), InputError> {
    let intervals = attempts.setting.problem.intervals;
    for (sequence, guess) in readings {
        if attempts.best.is_some() || runner.stopped() {
            return Ok(());
        }
        let sequence = sequence.clone().ordered(intervals);
        let sequence = sequence.filter(|sequence| !sequence.switches.is_empty());
        if let Some(sequence) = sequence
            && attempts.is_new_order(&sequence)
            && let Some(motion) = retimed(runner, attempts, &sequence, guess)
        {
            let motion = shaped(attempts.setting, motion);
            attempt_new(runner, attempts, &motion.sequence, &motion.trajectory)?;
            let at_ends = at_interval_ends(&motion.sequence, intervals);
            if let Some(at_ends) = at_ends.filter(|_| attempts.best.is_none()) {
                attempt_new(runner, attempts, &at_ends, &motion.trajectory)?;
            }
        }
    }
    Ok(())
}

/// A candidate with controls of the shape asked for, and before it the event-driven motion under these controls.
fn motions(
    runner: &Runner,
    setting: Setting,
    candidate: Candidate,
) -> Result<Vec<(Sequence, Trajectory)>, InputError> {
    let candidate = shaped(setting, candidate);
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
