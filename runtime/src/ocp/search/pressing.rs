//! A solved plan, and where it presses against its sequence.

use hangtime_solver::nlp;

use super::attempt::{Attempts, Local};
use crate::ocp::collocation::layout::{Phase, SolvedPhase, Stage};
use crate::ocp::collocation::limits::touching_gap;
use crate::ocp::collocation::program::Collocation;
use crate::ocp::motion::mode::{closed_mode, is_frictional, sliding_velocity, zero_velocity};
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::ocp::program::units::Units;
use crate::ocp::settings::Settings;
use crate::ocp::tuning::neighbours::{DISTANT, LEFT, NEAR, NOTHING};
use crate::simulation::ContactMode;

/// What a solved program says about its sequence.
pub(super) struct Pressing<'a, 'm> {
    pub(super) program: &'a Collocation<'m>,
    pub(super) sequence: &'a Sequence,
    /// Distance of each row from the nearest of its bounds.
    pub(super) slacks: &'a [f64],
    pub(super) intervals: usize,
    /// Half the length of an inserted phase, in intervals.
    pub(super) inserted: f64,
    /// The values of all variables, and the length of the motion \[s\].
    pub(super) x: Vec<f64>,
    pub(super) horizon: f64,
    pub(super) solved: Vec<SolvedPhase>,
    solution: &'a nlp::Solution,
    units: &'a Units,
    /// The largest multiplier of a row; infinite where all are errors.
    largest: f64,
    /// [`DISTANT`], or 0 where every multiplier counts.
    distant: f64,
    /// Gap below which a flight counts as touching, by its share of each contact.
    touching: f64,
}

impl<'a, 'm> Pressing<'a, 'm> {
    pub(super) fn new(
        best: &'a Local<'m>,
        attempts: &Attempts<'a, '_>,
        settings: &Settings,
        inserted: f64,
    ) -> Self {
        let multipliers = best.solution.multipliers.iter();
        let largest = multipliers.fold(f64::MIN_POSITIVE, |largest, y| largest.max(y.abs()));
        let counts = largest > NOTHING * settings.tolerance;
        let x = best.program.program.physical(&best.solution.x);
        Self {
            program: &best.program,
            sequence: &best.sequence,
            slacks: &best.slacks,
            intervals: attempts.setting.problem.intervals,
            inserted,
            horizon: best.program.horizon_at(&x),
            x,
            solved: best.program.solved(&best.solution.x),
            solution: &best.solution,
            units: attempts.setting.units,
            largest: if counts { largest } else { f64::INFINITY },
            // Where motions are looked for, sequences that nothing presses for are worth a try.
            distant: if attempts.setting.units.is_exact {
                DISTANT
            } else {
                0.0
            },
            touching: touching_gap(settings),
        }
    }

    pub(super) fn switches(&self) -> &[Switch] {
        &self.sequence.switches
    }

    /// The sequence with other switches.
    pub(super) fn with(&self, edit: impl FnOnce(&mut Vec<Switch>)) -> Sequence {
        let mut sequence = self.sequence.clone();
        edit(&mut sequence.switches);
        sequence
    }

    /// The end of the motion, in intervals.
    pub(super) fn end(&self) -> f64 {
        self.intervals as f64
    }

    /// The elements of the phases, with their numbers.
    pub(super) fn elements(&self) -> impl Iterator<Item = (&Phase, &SolvedPhase)> {
        self.program.phases.iter().zip(&self.solved)
    }

    /// When a share of an element is over, in intervals.
    pub(super) fn time(&self, solved: &SolvedPhase, share: f64) -> f64 {
        (solved.start + share * solved.length) / self.horizon * self.end()
    }

    /// Whether the solution presses against a bound of a row.
    pub(super) fn presses(&self, row: usize) -> bool {
        self.is_active(self.solution.multipliers[row].abs(), self.slacks[row])
    }

    /// Whether the solution presses against the lower bound of a variable.
    pub(super) fn is_held(&self, variable: usize) -> bool {
        let multiplier = self.solution.multipliers_lower[variable];
        let program = &self.program.program;
        let lower = program.bounds(variable).0 / program.unit(variable);
        self.is_active(multiplier, self.solution.x[variable] - lower)
    }

    fn is_active(&self, multiplier: f64, distance: f64) -> bool {
        multiplier > self.largest * LEFT.max(self.distant * distance)
    }

    /// Whether the force of a contact presses against 0 at a stage.
    pub(super) fn lets_go(&self, phase: &Phase, stage: Option<&Stage>, contact: usize) -> bool {
        let slot = phase.closed.iter().position(|&closed| closed == contact);
        let force = slot.and_then(|slot| Some(stage?.forces[slot]));
        force.is_some_and(|force| self.is_held(force))
    }

    /// Whether a contact switches near a time.
    pub(super) fn near(&self, contact: usize, time: f64) -> bool {
        let switches = self.sequence.switches.iter();
        let mut own = switches.filter(|s| s.contact == contact);
        own.any(|switch| (switch.time - time).abs() < NEAR)
    }

    /// Whether a contact that is struck is open again right after it.
    pub(super) fn bounces(&self, contact: usize) -> bool {
        self.program.model.restitution(contact) > 0.0
    }

    /// Gap of a contact at a stage.
    pub(super) fn gap(&self, contact: usize, stage: &Stage) -> f64 {
        let variables = stage.state.iter().chain(&stage.drive);
        let input: Vec<f64> = variables.map(|&i| self.x[i]).collect();
        self.program.model.gap(contact, &input)
    }

    /// Whether a contact counts as touching at a stage.
    pub(super) fn touches(&self, contact: usize, stage: &Stage) -> bool {
        self.gap(contact, stage) < self.touching * self.units.share_of_gap(contact)
    }

    /// The mode in which a contact closes at a stage, at a time \[s\].
    pub(super) fn mode_at(&self, contact: usize, stage: &Stage, time: f64) -> ContactMode {
        let model = self.program.model;
        if !is_frictional(model, contact) {
            return ContactMode::Frictionless;
        }
        let state: Vec<f64> = stage.state.iter().map(|&i| self.x[i]).collect();
        let zero = zero_velocity(&state[state.len() / 2..], self.units.slow());
        let velocity = sliding_velocity(model, contact, &state, time);
        closed_mode(true, velocity, zero)
    }

    /// The last stage of the motion.
    pub(super) fn last_stage(&self) -> Option<(&Phase, &Stage)> {
        let last = self.program.phases.last()?;
        Some((last, last.stages.last()?))
    }

    /// The elements before and after the place of the switch with this index.
    pub(super) fn around(&self, index: usize) -> (Option<usize>, Option<usize>) {
        let switch = &self.sequence.switches[index];
        let phases = &self.program.phases;
        let ended = phases.iter().position(|p| p.ends_with == Some(index));
        let inside = ended.map(|ended| (Some(ended), Some(ended + 1)));
        inside.unwrap_or_else(|| {
            let before = phases.iter().rposition(|p| p.interval < switch.interval);
            let after = phases.iter().position(|p| p.interval == switch.interval);
            (before, after)
        })
    }
}
