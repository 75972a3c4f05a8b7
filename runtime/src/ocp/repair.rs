//! Neighbours of a contact sequence: where a solution presses against the sequence it was given.

use super::collocation::{Collocation, Stage};
use super::mode::Mode;
use super::sequence::{Place, Sequence, Switch};
use super::settings::ControlShape;
use crate::nlp;

/// Switches of a contact closer than this many intervals may cancel each other.
const CLOSE: f64 = 1.1;
/// A switch nearer to the end of its interval than this share of it sticks there.
pub(super) const STUCK: f64 = 0.01;
/// A contact shorter than this many intervals may be no more than a touch.
const TOUCH: f64 = 1.5;
/// Where a moved switch is started, as a distance from the end it came through.
pub(super) const ENTRY: f64 = 0.05;
/// Half the length of an inserted contact or flight, in intervals.
pub(super) const INSERTED: f64 = 0.2;
/// Distance from a switch of the same contact within which no other one is inserted, in intervals.
const NEAR: f64 = 0.6;
/// Multipliers above this share of the largest one belong to conditions that matter.
const ACTIVE: f64 = 1e-6;

/// What a solved program says about its sequence.
pub(super) struct Pressure<'a, 'm> {
    pub(super) program: &'a Collocation<'m>,
    pub(super) solution: &'a nlp::Solution,
    /// The sequence with its times.
    pub(super) sequence: &'a Sequence,
    pub(super) intervals: usize,
    /// Gap below which a flight counts as touching.
    pub(super) touching: f64,
}

impl Pressure<'_, '_> {
    fn moved(
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

    pub(super) fn threshold(&self) -> f64 {
        let all = self.solution.multipliers.iter();
        ACTIVE * all.fold(f64::MIN_POSITIVE, |largest, y| largest.max(y.abs()))
    }

    /// Gap of a contact at a stage.
    fn gap(&self, contact: usize, stage: &Stage, x: &[f64]) -> f64 {
        let variables = stage.state.iter().chain(&stage.drive);
        let input: Vec<f64> = variables.map(|&i| x[i]).collect();
        self.program.model.gap(contact, &input)
    }

    /// Sequences that the solution points to, the most promising first: without a pair of switches that
    /// are close to each other, with a switch that sticks to the end of its interval moved through it or
    /// onto it, with an opening at a jump of the controls moved to the side that it presses against.
    pub(super) fn directed(&self) -> Vec<Sequence> {
        let switches = &self.sequence.switches;
        let mut found = Vec::new();
        for (i, j) in self.sequence.neighbours() {
            if switches[j].time - switches[i].time < CLOSE {
                found.extend(self.sequence.without((i, j)).ordered(self.intervals));
            }
        }
        found.extend(self.touches_and_contacts());
        for closes in [false, true] {
            for (index, switch) in switches.iter().enumerate() {
                let own = !switch.accompanies && switch.place == Place::Inside;
                if !own || switch.closes != closes {
                    continue;
                }
                let (k, offset) = (switch.interval, switch.time - switch.interval as f64);
                let (to, time) = if offset < STUCK {
                    (k.checked_sub(1), k as f64 - ENTRY)
                } else if offset > 1.0 - STUCK {
                    (Some(k + 1), (k + 1) as f64 + ENTRY)
                } else {
                    continue;
                };
                found.extend(self.moved(index, to, Place::Inside, time));
                let nearest = switch.time.round();
                found.extend(self.moved(index, Some(nearest as usize), Place::Start, nearest));
            }
        }
        let threshold = self.threshold();
        for (index, switch) in switches.iter().enumerate() {
            if switch.accompanies || switch.place != Place::Start {
                continue;
            }
            let k = switch.interval;
            // What ends at a zero of the motion happens at a jump of the controls by chance only.
            let slips = matches!(
                self.sequence.mode_before(index, switch.contact),
                Mode::Slip(_)
            );
            if switch.closes
                || slips && switch.slides()
                || self.program.shape == ControlShape::Linear
            {
                let time = k as f64 - ENTRY;
                found.extend(self.moved(index, k.checked_sub(1), Place::Inside, time));
                found.extend(self.moved(index, Some(k), Place::Inside, k as f64 + ENTRY));
                continue;
            }
            let phases = &self.program.phases;
            let after = phases.iter().find(|phase| phase.interval == k);
            let pressed = after.is_some_and(|phase| {
                let mut rows = phase.openings.iter().chain(&phase.pulled);
                rows.any(|&(contact, row)| {
                    contact == switch.contact && self.solution.multipliers[row].abs() > threshold
                })
            });
            if pressed {
                found.extend(self.moved(index, Some(k), Place::Inside, k as f64 + ENTRY));
            }
            let before = phases.iter().rev().find(|phase| phase.interval + 1 == k);
            let pressed = before.is_some_and(|phase| {
                if switch.slides() {
                    return self.at_the_edge(phase, switch);
                }
                let slot = phase.closed.iter().position(|&i| i == switch.contact);
                let stage = phase.stages.last();
                slot.zip(stage).is_some_and(|(slot, stage)| {
                    self.solution.multipliers_lower[stage.forces[slot]] > threshold
                })
            });
            if pressed {
                let time = k as f64 - ENTRY;
                found.extend(self.moved(index, k.checked_sub(1), Place::Inside, time));
            }
        }
        found
    }

    /// Whether a contact switches near a time.
    pub(super) fn near(&self, contact: usize, time: f64) -> bool {
        let switches = self.sequence.switches.iter();
        let mut own = switches.filter(|s| s.contact == contact);
        own.any(|switch| (switch.time - time).abs() < NEAR)
    }

    /// Sequences with a touch in the place of a short contact, and with a short contact in the
    /// place of a touch after which nothing pulls the contact open.
    fn touches_and_contacts(&self) -> Vec<Sequence> {
        let switches = &self.sequence.switches;
        let mut found = Vec::new();
        for (i, j) in self.sequence.neighbours() {
            let (first, second) = (&switches[i], &switches[j]);
            if first.stays() && second.opens() && second.time - first.time < TOUCH {
                let mut sequence = self.sequence.clone();
                sequence.switches[i].mode = Mode::Open;
                sequence.switches.remove(j);
                found.extend(sequence.ordered(self.intervals));
            }
        }
        let threshold = self.threshold();
        for (index, switch) in switches.iter().enumerate().filter(|(_, s)| s.touches()) {
            let mut touches = self.program.touches.iter();
            let grazes = touches.any(|(touch, row)| {
                (touch.contact, touch.interval, touch.place)
                    == (switch.contact, switch.interval, switch.place)
                    && self.solution.multipliers[*row].abs() > threshold
            });
            if grazes {
                let mut sequence = self.sequence.clone();
                sequence.switches.remove(index);
                found.extend(sequence.ordered(self.intervals));
            }
            let phases = self.program.phases.iter();
            let pressed = phases
                .flat_map(|phase| &phase.openings)
                .any(|&(contact, row)| {
                    contact == switch.contact && self.solution.multipliers[row].abs() > threshold
                });
            if pressed {
                let mut sequence = self.sequence.clone();
                sequence.switches[index].mode = switch.impulse;
                let time = (switch.time + INSERTED).min(self.intervals as f64 - STUCK);
                sequence.switches.push(Switch {
                    closes: false,
                    mode: Mode::Open,
                    interval: time.floor() as usize,
                    place: Place::Inside,
                    time,
                    ..*switch
                });
                found.extend(sequence.ordered(self.intervals));
            }
        }
        found
    }

    /// The sequence without its last switch: the motion may end before it.
    pub(super) fn shortened(&self) -> Option<Sequence> {
        let mut sequence = self.sequence.clone();
        while sequence.switches.pop()?.accompanies {}
        sequence.ordered(self.intervals)
    }

    /// Sequences with a flight inserted where a contact force is held at 0, and with a contact inserted
    /// where a gap is held at 0: together with the stuck switches of [`directed`](Self::directed) these
    /// are the places where gap and force vanish together. A flight that passes a surface at the gap margin is
    /// none of them.
    pub(super) fn insertions(&self) -> Vec<Sequence> {
        let threshold = self.threshold();
        let mut places: Vec<(usize, bool, Mode, f64)> = Vec::new();
        let contacts = self.sequence.initially.len();
        let tableau = self.program.tableau;
        let x = self.program.program.physical(&self.solution.x);
        let horizon = self.program.horizon_at(&x);
        let solved = self.program.solved(&self.solution.x);
        for (phase, solved) in self.program.phases.iter().zip(&solved) {
            let opens = phase
                .ends_with
                .map(|index| &self.sequence.switches[index])
                .filter(|switch| switch.opens())
                .map(|switch| switch.contact);
            let time = |theta: f64| {
                (solved.start + theta * solved.length) / horizon * self.intervals as f64
            };
            for (m, (stage, c)) in phase.stages.iter().zip(tableau.c()).enumerate() {
                let last = m + 1 == phase.stages.len();
                for (&contact, &force) in phase.closed.iter().zip(&stage.forces) {
                    let exits = last && opens == Some(contact);
                    if !exits && self.solution.multipliers_lower[force] > threshold {
                        places.push((contact, false, phase.modes[contact], time(*c)));
                    }
                }
                for contact in (0..contacts).filter(|i| !phase.closed.contains(i)) {
                    let row = stage.gap_rows[contact];
                    let closes = last && phase.closing.contains(&contact);
                    if !closes
                        && self.solution.multipliers[row].abs() > threshold
                        && self.gap(contact, stage, &x) < self.touching
                    {
                        let seconds = solved.start + c * solved.length;
                        let mode = self.mode_at(contact, (stage, seconds), &x);
                        places.push((contact, true, mode, time(*c)));
                    }
                }
            }
        }
        // Gap and force vanish together at every switch; that is no sign of another one nearby.
        places.retain(|&(contact, .., time)| !self.near(contact, time));
        let mut found: Vec<Sequence> = Vec::new();
        let intervals = self.intervals as f64;
        for (contact, closes, mode, time) in places {
            let mut sequence = self.sequence.clone();
            for (closes, time) in [(closes, time - INSERTED), (!closes, time + INSERTED)] {
                let time = time.clamp(0.0, intervals - STUCK);
                sequence.switches.push(Switch {
                    contact,
                    closes,
                    mode: if closes { mode } else { Mode::Open },
                    impulse: mode,
                    accompanies: false,
                    interval: time.floor() as usize,
                    place: Place::Inside,
                    time,
                });
            }
            if let Some(sequence) = sequence.ordered(self.intervals)
                && !found.iter().any(|s| s.signature() == sequence.signature())
            {
                found.push(sequence);
            }
        }
        found
    }
}
