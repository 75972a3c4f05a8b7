//! The search over contact sequences: attempts, cuts, repair.

use super::attempt::{Purpose, Tried, Verdict};
use super::collocation::{Collocation, Cut, Setting};
use super::cuts::Limits;
use super::global::Relaxed;
use super::path::Path;
use super::previous::Previous;
use super::progress::Watch;
use super::repair::Pressure;
use super::sequence::Sequence;
use super::settings::{ControlShape, Formulation, Guess, Settings};
use super::solution::{Counts, Solution, Stationarity, Status, TimeFreezingReport};
use crate::nlp;
use crate::rk::ButcherTableau;
use crate::simulation::{InputError, SimulationStatus};

/// Gap below which a flight counts as touching, relative to the gap margin.
const TOUCHING: f64 = 0.1;
/// Most switches of short contacts and flights for which a sequence is tried with them, too.
const SHORT_SWITCHES: usize = 2;

/// A solved program of a sequence.
pub(super) struct Local<'a> {
    pub(super) program: Collocation<'a>,
    pub(super) solution: nlp::Solution,
    pub(super) path: Path,
    pub(super) sequence: Sequence,
    pub(super) cuts: Vec<Cut>,
}

/// The search over contact sequences.
pub(super) struct Search<'a, 's> {
    pub(super) setting: Setting<'a>,
    /// Schemes of growing order; the first one serves the search.
    pub(super) tableaus: &'a [ButcherTableau],
    /// Finite elements of a phase in each interval; more where errors ask for them.
    pub(super) elements: Vec<usize>,
    pub(super) settings: &'s Settings,
    pub(super) watch: Watch<'s>,
    /// Most programs, those of coarser grids included.
    pub(super) most_programs: usize,
    pub(super) counts: Counts,
    /// Whether sequences in other basins are tried; on a coarser grid they were.
    pub(super) explores: bool,
    pub(super) time_freezing: Option<TimeFreezingReport>,
    pub(super) tried: Vec<Tried>,
    pub(super) best: Option<Local<'a>>,
    /// Why the program that came nearest to a solution failed, and its worst rows.
    pub(super) failure: Option<(nlp::Status, Vec<nlp::Violation>)>,
    /// Why the last program that failed did.
    pub(super) last_failure: Option<nlp::Status>,
}

impl<'a> Search<'a, '_> {
    /// Solves from a guess, which may be the motion on a coarser grid.
    pub(super) fn run(
        &mut self,
        guess: &Path,
        coarser: Option<&Previous>,
    ) -> Result<Solution, InputError> {
        let mut found: Vec<(Local<'a>, Stationarity)> = Vec::new();
        let settings = self.settings;
        let mut known = Vec::new();
        if coarser.is_some() {
            known.extend(self.on_this_grid(guess)?);
        }
        let previous = match &settings.guess {
            Guess::Previous(previous) => Some(&**previous),
            _ => coarser,
        };
        let intervals = self.setting.problem.intervals;
        known.extend(previous.map(|previous| previous.relaxed(guess, intervals)));
        for relaxed in known {
            if found.is_empty() && !self.watch.stopped {
                self.attempt_and_repair(relaxed, coarser.is_some(), &mut found)?;
            }
        }
        // Without a previous motion, or too far from it: search.
        if found.is_empty() {
            self.search_from(guess, &mut found)?;
        }
        // The ride without controls obeys the dynamics, which is what other guesses may be too far from.
        if found.is_empty() && !matches!(settings.guess, Guess::Ride) && !self.watch.stopped {
            let Setting {
                model,
                problem,
                bounds,
                ..
            } = self.setting;
            let ride = Path::guess(model, problem, &Guess::Ride, bounds)?;
            self.search_from(&ride, &mut found)?;
        }
        // The best that the re-simulation confirms, or else the best.
        let mut result: Option<Solution> = None;
        for (local, stationarity) in found {
            let solution = self.refine(local, stationarity)?;
            let confirmed = solution.status != Status::Unconfirmed;
            if confirmed || result.is_none() {
                result = Some(solution);
            }
            if confirmed {
                break;
            }
        }
        Ok(match result {
            Some(solution) => solution,
            None => self.failed(),
        })
    }

    /// Adds the local optima that the motions of the global phase lead to.
    fn search_from(
        &mut self,
        guess: &Path,
        found: &mut Vec<(Local<'a>, Stationarity)>,
    ) -> Result<(), InputError> {
        if self.watch.stopped {
            return Ok(());
        }
        let settings = self.settings;
        let known = self.failure.take();
        let relaxed = match &settings.formulation {
            Formulation::Phases => self.global(guess)?,
            Formulation::TimeFreezing(formulation) => self.time_freezing(formulation)?,
        };
        let bouncing = self.bouncing(guess)?;
        if known.is_some() || !relaxed.is_empty() {
            // Rows of the programs of contact sequences say more than those of relaxed ones.
            self.failure = known;
        }
        let relaxed = relaxed.into_iter().take(settings.refined_motions);
        for global in bouncing.into_iter().chain(relaxed) {
            if self.watch.stopped {
                break;
            }
            self.attempt_and_repair(global, false, found)?;
        }
        Ok(())
    }

    /// The motion under the guessed controls, where a contact bounces: the global phase knows no bounce.
    fn bouncing(&self, guess: &Path) -> Result<Option<Relaxed>, InputError> {
        let model = self.setting.model;
        let mut contacts = 0..model.declaration().contacts.len();
        if contacts.all(|contact| model.restitution(contact) == 0.0) {
            return Ok(None);
        }
        let replay = self.simulate(guess, self.settings.replay_tolerance)?;
        if replay.status != SimulationStatus::Solved {
            return Ok(None);
        }
        let (horizon, controls) = (guess.horizon, guess.controls.clone());
        Ok(Some(Relaxed {
            objective: f64::INFINITY,
            sequence: self.read(&replay, guess),
            path: Path::of_simulation(model, &replay, horizon, controls),
        }))
    }

    /// Adds the local optimum that a relaxed motion leads to, the best first; of one that is known to be near, by the
    /// first sequence that allows a motion.
    fn attempt_and_repair(
        &mut self,
        global: Relaxed,
        near: bool,
        found: &mut Vec<(Local<'a>, Stationarity)>,
    ) -> Result<(), InputError> {
        self.read_and_attempt(global, near)?;
        let stationarity = self.repair()?;
        if let Some(best) = self.best.take() {
            let objective = best.solution.objective;
            let place = found.partition_point(|(l, _)| l.solution.objective < objective);
            found.insert(place, (best, stationarity));
        }
        Ok(())
    }

    /// Attempts the sequences that a relaxed motion suggests. It and the event-driven motion under the same
    /// controls may disagree where the motion is sensitive, and short contacts may be meant or not: all are
    /// candidates, the likely ones first.
    fn read_and_attempt(&mut self, mut global: Relaxed, near: bool) -> Result<(), InputError> {
        if self.setting.shape == ControlShape::Linear {
            global.sequence = global.sequence.without_jumps();
            let intervals = self.setting.problem.intervals;
            global.path.controls =
                (global.path.controls).resampled(ControlShape::Linear, intervals);
        }
        let replay = self.simulate(&global.path, self.settings.replay_tolerance)?;
        let mut candidates = vec![(global.sequence, global.path)];
        if replay.status == SimulationStatus::Solved {
            let path = &candidates[0].1;
            let simulated = Path::of_simulation(
                self.setting.model,
                &replay,
                path.horizon,
                path.controls.clone(),
            );
            candidates.insert(0, (self.read(&replay, path), simulated));
        }
        let tidied = candidates
            .iter()
            .map(|(sequence, path)| (sequence.clone().tidied(), path));
        let untouched = candidates
            .iter()
            .filter_map(|(sequence, path)| Some((sequence.untouched()?.tidied(), path)));
        let raw = candidates.iter().filter(|(sequence, _)| {
            let short = sequence.switches.len() - sequence.clone().tidied().switches.len();
            short <= SHORT_SWITCHES
        });
        let raw = raw.map(|(sequence, path)| (sequence.clone(), path));
        let touching = candidates
            .iter()
            .filter_map(|(sequence, path)| Some((sequence.touching()?, path)));
        let likely: Vec<(Sequence, &Path)> =
            tidied.chain(untouched).chain(raw).chain(touching).collect();
        // The motion may end with its last impact; that is looked at where nothing else has a solution.
        let intervals = self.setting.problem.intervals;
        let ending = candidates
            .iter()
            .filter_map(|(sequence, path)| Some((sequence.ending(intervals)?, path)));
        let count = likely.len();
        for (index, (sequence, path)) in likely.into_iter().chain(ending).enumerate() {
            if index >= count && self.best.is_some() {
                break;
            }
            let Some(sequence) = sequence.ordered(self.setting.problem.intervals) else {
                continue;
            };
            let enough = self.watch.stopped || near && self.best.is_some();
            if !enough && !self.was_tried(&sequence) {
                self.attempt(&sequence, path, &[], Purpose::Explore)?;
            }
        }
        Ok(())
    }

    /// What the motion has to keep between the stages.
    pub(super) fn limits(&self) -> Limits<'a> {
        Limits {
            gap: TOUCHING * self.settings.gap_margin,
            margin: self.settings.gap_margin,
            bound: self.settings.tolerance,
            units: self.setting.units,
            bounds: self.setting.bounds,
            problem: self.setting.problem,
            places: self.setting.places,
        }
    }

    /// Keeps why a program failed, if it came nearer to a solution than those before.
    pub(super) fn note_failure(&mut self, status: nlp::Status, violations: Vec<nlp::Violation>) {
        self.last_failure = Some(status);
        let worst =
            |violations: &[nlp::Violation]| violations.first().map_or(0.0, |row| row.amount);
        let nearer = |(_, before): &(_, Vec<nlp::Violation>)| worst(&violations) < worst(before);
        if self.failure.as_ref().is_none_or(nearer) {
            self.failure = Some((status, violations));
        }
    }

    /// Follows improving neighbours until there is none; says what was proved.
    fn repair(&mut self) -> Result<Stationarity, InputError> {
        let intervals = self.setting.problem.intervals;
        loop {
            let Some(best) = self.best.take() else {
                return Ok(Stationarity::None);
            };
            let pressure = Pressure {
                program: &best.program,
                solution: &best.solution,
                sequence: &best.sequence,
                intervals,
                touching: TOUCHING * self.settings.gap_margin,
            };
            let directed = pressure.directed();
            let inserted = pressure.insertions().into_iter().chain(pressure.sliding());
            let neighbours: Vec<Sequence> = directed.into_iter().chain(inserted).collect();
            // No neighbours, but often in another basin: nothing is claimed about them.
            let explored = pressure.shortened().into_iter().chain(pressure.shifted());
            let explored: Vec<Sequence> = explored.collect();
            let (path, cuts) = (best.path.clone(), best.cuts.clone());
            self.best = Some(best);
            let stationarity = if neighbours.is_empty() {
                Stationarity::S
            } else {
                Stationarity::B
            };
            let mut improved = false;
            let mut undecided = false;
            for neighbour in neighbours {
                if let Some(verdict) = self.known(&neighbour) {
                    undecided |= verdict == Verdict::Undecided;
                    continue;
                }
                if self.watch.stopped || self.counts.programs >= self.most_programs {
                    return Ok(Stationarity::None);
                }
                match self.attempt(&neighbour, &path, &cuts, Purpose::Compare)? {
                    Verdict::Better => {
                        improved = true;
                        break;
                    }
                    Verdict::NotBetter(_) => {}
                    Verdict::Undecided => undecided = true,
                }
            }
            for sequence in explored {
                if improved
                    || !self.explores
                    || self.watch.stopped
                    || self.counts.programs >= self.most_programs
                {
                    break;
                }
                if !self.was_tried(&sequence) {
                    let verdict = self.attempt(&sequence, &path, &cuts, Purpose::Explore)?;
                    improved = verdict == Verdict::Better;
                }
            }
            if !improved {
                return Ok(if undecided {
                    Stationarity::None
                } else {
                    stationarity
                });
            }
            self.counts.repairs += 1;
        }
    }
}

/// A refusal of the interior point method: the programs here are built to be accepted, except where the
/// model's functions are not finite.
pub(super) fn refused(error: &nlp::InputError) -> InputError {
    InputError::NotFinite {
        what: format!("optimal control: {error}; a number there"),
        value: f64::NAN,
    }
}
