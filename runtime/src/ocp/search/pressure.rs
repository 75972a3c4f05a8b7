//! Where a solution presses against the sequence it was given.

use hangtime_solver::nlp;

use crate::ocp::collocation::layout::{Phase, Stage};
use crate::ocp::collocation::program::Collocation;
use crate::ocp::motion::mode::{closed_mode, is_frictional, sliding_velocity, zero_velocity};
use crate::ocp::motion::sequence::{Place, Sequence, Switch};
use crate::ocp::program::units::Units;
use crate::ocp::tuning::neighbours::{LEFT, NEAR};
use crate::simulation::ContactMode;

/// What a solved program says about its sequence.
pub(in crate::ocp) struct Pressure<'a, 'm> {
    pub(in crate::ocp) program: &'a Collocation<'m>,
    pub(in crate::ocp) solution: &'a nlp::Solution,
    /// [`DISTANT`](crate::ocp::tuning::neighbours::DISTANT), or 0 where every multiplier counts.
    pub(in crate::ocp) distant: f64,
    /// The largest multiplier of a row; infinite where all are errors.
    pub(in crate::ocp) largest: f64,
    /// Distance of each row from the nearest of its bounds.
    pub(in crate::ocp) slacks: &'a [f64],
    /// The sequence with its times.
    pub(in crate::ocp) sequence: &'a Sequence,
    pub(in crate::ocp) intervals: usize,
    /// Half the length of an inserted contact or flight, in intervals.
    pub(in crate::ocp) inserted: f64,
    /// Gap below which a flight counts as touching, by its share of each contact.
    pub(in crate::ocp) touching: f64,
    pub(in crate::ocp) units: &'a Units,
}

impl Pressure<'_, '_> {
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

    /// Whether a contact switches near a time.
    pub(in crate::ocp) fn near(&self, contact: usize, time: f64) -> bool {
        let switches = self.sequence.switches.iter();
        let mut own = switches.filter(|s| s.contact == contact);
        own.any(|switch| (switch.time - time).abs() < NEAR)
    }

    /// Gap of a contact at a stage.
    pub(super) fn gap(&self, contact: usize, stage: &Stage, x: &[f64]) -> f64 {
        let variables = stage.state.iter().chain(&stage.drive);
        let input: Vec<f64> = variables.map(|&i| x[i]).collect();
        self.program.model.gap(contact, &input)
    }

    /// Whether a contact counts as touching at a stage.
    pub(super) fn touches(&self, contact: usize, stage: &Stage, x: &[f64]) -> bool {
        self.gap(contact, stage, x) < self.touching * self.units.share_of_gap(contact)
    }

    /// The contacts that are open until the end and touch there, and how each would slide.
    pub(super) fn touching_at_the_end(&self) -> Vec<(usize, ContactMode)> {
        let last = self.program.phases.last();
        let Some((phase, stage)) = last.and_then(|phase| Some((phase, phase.stages.last()?)))
        else {
            return Vec::new();
        };
        let x = self.program.program.physical(&self.solution.x);
        let seconds = self.program.horizon_at(&x);
        let open = |i: &usize| {
            !phase.closed.contains(i) && !phase.closing.contains(i) && !phase.pieces.is_idle(*i)
        };
        let touching = (0..stage.gap_rows.len())
            .filter(open)
            .filter(|&contact| self.touches(contact, stage, &x));
        let modes = touching.map(|contact| (contact, self.mode_at(contact, stage, seconds, &x)));
        modes.collect()
    }

    /// Whether the last force of a phase presses against the edge of the cone beyond which the switch leads.
    pub(in crate::ocp) fn at_the_edge(&self, phase: &Phase, switch: &Switch) -> bool {
        let last = phase.stages.iter().rev().take(1);
        let mut own = last
            .flat_map(|stage| &stage.tangential)
            .filter(|tangential| tangential.contact == switch.contact)
            .flat_map(|tangential| &tangential.rows);
        own.any(|&(direction, row)| {
            switch.mode == ContactMode::Slip(direction) && self.presses(row)
        })
    }

    /// The mode in which a contact closes at a stage.
    pub(in crate::ocp) fn mode_at(
        &self,
        contact: usize,
        stage: &Stage,
        time: f64,
        x: &[f64],
    ) -> ContactMode {
        let model = self.program.model;
        if !is_frictional(model, contact) {
            return ContactMode::Frictionless;
        }
        let state: Vec<f64> = stage.state.iter().map(|&i| x[i]).collect();
        let zero = zero_velocity(&state[state.len() / 2..], self.units.slow());
        let velocity = sliding_velocity(model, contact, &state, time);
        closed_mode(true, velocity, zero)
    }

    pub(super) fn moved(
        &self,
        index: usize,
        interval: Option<usize>,
        place: Place,
        time: f64,
    ) -> Option<Sequence> {
        let mut sequence = self.sequence.clone();
        let companions = Sequence::companions(&sequence.switches, index).len();
        for switch in &mut sequence.switches[index..=index + companions] {
            switch.interval = interval?;
            switch.place = place;
            switch.time = time;
        }
        sequence.ordered(self.intervals)
    }
}
