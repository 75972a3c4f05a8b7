//! Neighbours of a sequence in which contacts stick or slip elsewhere: where a solution presses against the edge of a
//! friction cone, or against the direction of a slip.

use super::collocation::Phase;
use super::mode::{Mode, is_rough, sliding_velocity, zero_velocity};
use super::repair::{ENTRY, INSERTED, Pressure, STUCK};
use super::sequence::{Place, Sequence, Switch};

impl Pressure<'_, '_> {
    fn presses(&self, row: usize) -> bool {
        self.solution.multipliers[row].abs() > self.threshold()
    }

    /// Whether the last force of a phase presses against the edge of the cone beyond which the switch leads.
    pub(super) fn at_the_edge(&self, phase: &Phase, switch: &Switch) -> bool {
        let last = phase.stages.iter().rev().take(1);
        let mut own = last
            .flat_map(|stage| &stage.tangential)
            .filter(|tangential| tangential.contact == switch.contact)
            .flat_map(|tangential| &tangential.rows);
        own.any(|&(direction, row)| switch.mode == Mode::Slip(direction) && self.presses(row))
    }

    /// The mode in which a contact closes at the state with these variables.
    pub(super) fn mode_at(&self, contact: usize, state: &[usize], x: &[f64]) -> Mode {
        let model = self.program.model;
        if !is_rough(model, contact) {
            return Mode::Frictionless;
        }
        let state: Vec<f64> = state.iter().map(|&i| x[i]).collect();
        let zero = zero_velocity(&state[state.len() / 2..]);
        Mode::closed(true, sliding_velocity(model, contact, &state), zero)
    }

    /// Sequences in which a contact slips where its force is held in the cone, sticks or turns round where its sliding
    /// velocity is held at 0, or does so after an impact.
    pub(super) fn sliding(&self) -> Vec<Sequence> {
        let mut found: Vec<Sequence> = Vec::new();
        let candidates = self
            .beginnings()
            .into_iter()
            .chain(self.inserted_sliding())
            .chain(self.impacts());
        for candidate in candidates {
            if let Some(sequence) = candidate.ordered(self.intervals)
                && !found.iter().any(|s| s.signature() == sequence.signature())
            {
                found.push(sequence);
            }
        }
        found
    }

    fn slide(contact: usize, mode: Mode, place: Place, time: f64) -> Switch {
        Switch {
            contact,
            closes: false,
            mode,
            impulse: mode,
            accompanies: false,
            interval: time.max(0.0).floor() as usize,
            place,
            time,
        }
    }

    /// With another mode right from the start: where the first change of a contact sticks there, and where a contact
    /// that slips from the start would rather stick.
    fn beginnings(&self) -> Vec<Sequence> {
        let mut found = Vec::new();
        for (index, switch) in self.sequence.switches.iter().enumerate() {
            let first = !self.sequence.switches[..index]
                .iter()
                .any(|other| other.contact == switch.contact);
            if first && switch.slides() && !switch.accompanies && switch.time < STUCK {
                let mut sequence = self.sequence.clone();
                sequence.switches.remove(index);
                sequence.initially[switch.contact] = switch.mode;
                found.push(sequence);
            }
        }
        let Some(phase) = self.program.phases.first() else {
            return found;
        };
        for &(contact, _) in phase.pulled.iter().filter(|pulled| self.presses(pulled.1)) {
            for (place, time) in [(Place::Inside, ENTRY), (Place::Start, 1.0)] {
                let mut sequence = self.sequence.clone();
                let mode = sequence.initially[contact];
                sequence.initially[contact] = Mode::Stick;
                let slide = Self::slide(contact, mode, place, time);
                sequence.switches.push(slide);
                found.push(sequence);
            }
        }
        found
    }

    /// With another way of sliding inserted for a while.
    fn inserted_sliding(&self) -> Vec<Sequence> {
        let x = self.program.program.physical(&self.solution.x);
        let horizon = self.program.horizon_at(&x);
        let intervals = self.intervals as f64;
        let solved = self.program.solved(&self.solution.x);
        let mut found = Vec::new();
        let mut insert = |contact: usize, mode: Mode, back: Mode, (place, time): (Place, f64)| {
            let mut sequence = self.sequence.clone();
            let until = (time + INSERTED).min(intervals - STUCK);
            if place == Place::Start && time < STUCK {
                sequence.initially[contact] = mode;
            } else {
                let from = match place {
                    Place::Start => time.round(),
                    Place::Inside => (time - INSERTED).max(0.0),
                };
                let switch = Self::slide(contact, mode, place, from);
                sequence.switches.push(switch);
            }
            let switch = Self::slide(contact, back, Place::Inside, until);
            sequence.switches.push(switch);
            found.push(sequence);
        };
        for (phase, solved) in self.program.phases.iter().zip(&solved) {
            let time = |theta: f64| (solved.start + theta * solved.length) / horizon * intervals;
            // At a jump of the controls the force may leave the cone at once.
            for &(contact, direction, _) in phase.cones.iter().filter(|c| self.presses(c.2)) {
                if phase.index.0 == 0 && !self.near(contact, time(0.0)) {
                    let place = (Place::Start, time(0.0));
                    insert(contact, Mode::Slip(direction), Mode::Stick, place);
                }
            }
            for (stage, c) in phase.stages.iter().zip(self.program.tableau.c()) {
                for tangential in &stage.tangential {
                    let (contact, mode) = (tangential.contact, tangential.mode);
                    let pressed = tangential.rows.iter().find(|(_, row)| self.presses(*row));
                    let Some(&(direction, _)) = pressed else {
                        continue;
                    };
                    if self.near(contact, time(*c)) {
                        continue;
                    }
                    let place = (Place::Inside, time(*c));
                    match mode {
                        Mode::Stick => insert(contact, Mode::Slip(direction), mode, place),
                        _ => {
                            insert(contact, Mode::Stick, mode, place);
                            insert(contact, Mode::Slip(direction.reversed()), mode, place);
                        }
                    }
                }
            }
        }
        found
    }

    /// With another law between the impulses of an impact.
    fn impacts(&self) -> Vec<Sequence> {
        let mut found = Vec::new();
        for (index, tangential) in &self.program.impacts {
            let pressed = tangential.rows.iter().find(|(_, row)| self.presses(*row));
            let Some(&(direction, _)) = pressed else {
                continue;
            };
            let laws = match tangential.mode {
                Mode::Stick => vec![(Mode::Slip(direction), Mode::Slip(direction))],
                _ => vec![
                    (Mode::Stick, Mode::Stick),
                    (Mode::Stick, Mode::Slip(direction.reversed())),
                    (Mode::Stick, Mode::Slip(direction)),
                ],
            };
            for (impulse, mode) in laws {
                let mut sequence = self.sequence.clone();
                let companions = Sequence::companions(&sequence.switches, *index).len();
                let mut struck = sequence.switches[*index..=index + companions].iter_mut();
                if let Some(switch) = struck.find(|s| s.contact == tangential.contact) {
                    switch.impulse = impulse;
                    if !switch.mode.is_open() {
                        switch.mode = mode;
                    }
                } else {
                    let switch = self.sequence.switches[*index];
                    let companion = Switch {
                        contact: tangential.contact,
                        closes: false,
                        mode,
                        impulse,
                        accompanies: true,
                        ..switch
                    };
                    sequence.switches.insert(index + 1, companion);
                }
                // A change that comes later must still be one.
                let mut modes = sequence.initially.clone();
                sequence.switches.retain(|switch| {
                    let before = std::mem::replace(&mut modes[switch.contact], switch.mode);
                    switch.closes || before != switch.mode
                });
                found.push(sequence);
            }
        }
        found
    }
}
