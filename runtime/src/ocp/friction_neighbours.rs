//! Neighbours of a sequence in which contacts stick or slip elsewhere: where a solution presses against the edge of a
//! friction cone, or against the direction of a slip.

use super::collocation::{Phase, Stage};
use super::mode::{Direction, Mode, is_rough, sliding_velocity, zero_velocity};
use super::repair::{ENTRY, INSERTED, Pressure, STUCK};
use super::sequence::{Place, Sequence, Switch};

/// A change of the way of sliding, for a while.
struct Change {
    contact: usize,
    to: Mode,
    back: Mode,
}

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

    /// The mode in which a contact closes at a stage.
    pub(super) fn mode_at(&self, contact: usize, (stage, time): (&Stage, f64), x: &[f64]) -> Mode {
        let model = self.program.model;
        if !is_rough(model, contact) {
            return Mode::Frictionless;
        }
        let state: Vec<f64> = stage.state.iter().map(|&i| x[i]).collect();
        let zero = zero_velocity(&state[state.len() / 2..]);
        let velocity = sliding_velocity(model, contact, &state, time);
        Mode::closed(true, velocity, zero)
    }

    /// Sequences in which a contact slips where its force is held in the cone, sticks or turns round where its sliding
    /// velocity is held at 0, or does so after an impact.
    pub(super) fn sliding(&self) -> Vec<Sequence> {
        let mut found: Vec<Sequence> = Vec::new();
        let candidates = self
            .beginnings()
            .into_iter()
            .chain(self.endings())
            .chain(self.turned())
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
        let switches = &self.sequence.switches;
        let mut found = Vec::new();
        for (index, switch) in switches.iter().enumerate() {
            let first = !switches[..index]
                .iter()
                .any(|s| s.contact == switch.contact);
            if first && switch.slides() && !switch.accompanies && switch.time < STUCK {
                let mut sequence = self.sequence.clone();
                let last = index + Sequence::companions(switches, index).len();
                for member in sequence.switches.drain(index..=last) {
                    sequence.initially[member.contact] = member.mode;
                }
                found.push(sequence);
            }
        }
        let Some(phase) = self.program.phases.first() else {
            return found;
        };
        let pulled: Vec<usize> = phase
            .pulled
            .iter()
            .filter(|pulled| self.presses(pulled.1))
            .map(|pulled| pulled.0)
            .collect();
        for (place, time) in [(Place::Inside, ENTRY), (Place::Start, 1.0)] {
            let mut sequence = self.sequence.clone();
            for (index, &contact) in pulled.iter().enumerate() {
                let mode = std::mem::replace(&mut sequence.initially[contact], Mode::Stick);
                sequence.switches.push(Switch {
                    accompanies: index > 0,
                    ..Self::slide(contact, mode, place, time)
                });
            }
            if !pulled.is_empty() {
                found.push(sequence);
            }
        }
        found
    }

    /// With contacts that come to rest at the end at rest a little before.
    fn endings(&self) -> Option<Sequence> {
        let x = self.program.program.physical(&self.solution.x);
        let phase = self.program.phases.last()?;
        let stage = phase.stages.last()?;
        let end = self.intervals as f64;
        let rests = |contact: &usize| {
            let time = self.program.horizon_at(&x);
            self.mode_at(*contact, (stage, time), &x) == Mode::Stick && !self.near(*contact, end)
        };
        let slipping = stage.tangential.iter().filter(|t| t.mode != Mode::Stick);
        let changes: Vec<Change> = slipping
            .filter(|tangential| rests(&tangential.contact))
            .map(|tangential| Change {
                contact: tangential.contact,
                to: Mode::Stick,
                back: tangential.mode,
            })
            .collect();
        self.inserted(&changes, (Place::Inside, end))
    }

    /// Sequences with a slip that begins at a jump of the controls earlier or later by an interval. The force of a contact
    /// that sticks is as constant as the controls, and seldom lets it go between two jumps, so that no multiplier tells
    /// at which of them it should.
    pub(super) fn shifted(&self) -> Vec<Sequence> {
        let switches = &self.sequence.switches;
        let mut found = Vec::new();
        for (index, switch) in switches.iter().enumerate() {
            let sticks = self.sequence.mode_before(index, switch.contact) == Mode::Stick;
            let jumps = switch.place == Place::Start && !switch.accompanies;
            if !jumps || !sticks || !switch.slides() {
                continue;
            }
            let group = index..=index + Sequence::companions(switches, index).len();
            for interval in [switch.interval - 1, switch.interval + 1] {
                let mut sequence = self.sequence.clone();
                if interval == 0 {
                    for member in sequence.switches.drain(group.clone()) {
                        sequence.initially[member.contact] = member.mode;
                    }
                } else {
                    for member in &mut sequence.switches[group.clone()] {
                        (member.interval, member.time) = (interval, interval as f64);
                    }
                }
                found.extend(sequence.ordered(self.intervals));
            }
        }
        found
    }

    /// With a slip in the place of a stick whose force is held in the cone: a contact that has just come to rest is
    /// pulled on or back.
    fn turned(&self) -> Vec<Sequence> {
        let switches = &self.sequence.switches;
        let mut found = Vec::new();
        for (index, switch) in switches.iter().enumerate() {
            if switch.accompanies || !switch.slides() || switch.mode != Mode::Stick {
                continue;
            }
            let phases = &self.program.phases;
            let after = match switch.place {
                Place::Start => phases.iter().find(|p| p.interval == switch.interval),
                Place::Inside => {
                    let ended = phases.iter().position(|p| p.ends_with == Some(index));
                    ended.and_then(|last| phases.get(last + 1))
                }
            };
            let pressed = after.and_then(|phase| {
                let start = phase.cones.iter().filter(|cone| cone.0 == switch.contact);
                let stages = phase.stages.iter().flat_map(|stage| &stage.tangential);
                let stages = stages.filter(|tangential| tangential.contact == switch.contact);
                start
                    .map(|&(_, direction, row)| (direction, row))
                    .chain(stages.flat_map(|t| t.rows.iter().copied()))
                    .find(|&(_, row)| self.presses(row))
            });
            let Some((direction, _)) = pressed else {
                continue;
            };
            let mut sequence = self.sequence.clone();
            let back = self.sequence.mode_before(index, switch.contact) != Mode::Slip(direction);
            let companions = Sequence::companions(switches, index).len();
            for member in &mut sequence.switches[index..=index + companions] {
                let before = self.sequence.mode_before(index, member.contact);
                member.mode = match before {
                    Mode::Slip(direction) if back => Mode::Slip(direction.reversed()),
                    before => before,
                };
            }
            found.push(sequence.consistent());
        }
        found
    }

    /// With another way of sliding inserted for a while, for all contacts together that press for it.
    fn inserted_sliding(&self) -> Vec<Sequence> {
        let x = self.program.program.physical(&self.solution.x);
        let horizon = self.program.horizon_at(&x);
        let intervals = self.intervals as f64;
        let solved = self.program.solved(&self.solution.x);
        let mut found = Vec::new();
        for (phase, solved) in self.program.phases.iter().zip(&solved) {
            let time = |theta: f64| (solved.start + theta * solved.length) / horizon * intervals;
            // At a jump of the controls the force may leave the cone at once.
            let cones = phase.cones.iter().filter(|cone| self.presses(cone.2));
            let changes: Vec<Change> = cones
                .filter(|cone| phase.index.0 == 0 && !self.near(cone.0, time(0.0)))
                .map(|&(contact, direction, _)| Change {
                    contact,
                    to: Mode::Slip(direction),
                    back: Mode::Stick,
                })
                .collect();
            found.extend(self.inserted(&changes, (Place::Start, time(0.0))));
            for (stage, c) in phase.stages.iter().zip(self.program.tableau.c()) {
                let pressed = stage.tangential.iter().filter_map(|tangential| {
                    let mut rows = tangential.rows.iter();
                    let (direction, _) = rows.find(|(_, row)| self.presses(*row))?;
                    Some((tangential.contact, tangential.mode, *direction))
                });
                let pressed: Vec<(usize, Mode, Direction)> = pressed
                    .filter(|&(contact, ..)| !self.near(contact, time(*c)))
                    .collect();
                for turned in [false, true] {
                    let change = |&(contact, back, direction): &(usize, Mode, Direction)| {
                        let to = match back {
                            Mode::Stick => Mode::Slip(direction),
                            _ if turned => Mode::Slip(direction.reversed()),
                            _ => Mode::Stick,
                        };
                        Change { contact, to, back }
                    };
                    let changes: Vec<Change> = pressed.iter().map(change).collect();
                    found.extend(self.inserted(&changes, (Place::Inside, time(*c))));
                }
            }
        }
        found
    }

    /// The sequence with changes of the way of sliding from a time on, and back a little later unless the motion ends
    /// before.
    fn inserted(&self, changes: &[Change], (place, time): (Place, f64)) -> Option<Sequence> {
        if changes.is_empty() {
            return None;
        }
        let mut sequence = self.sequence.clone();
        let until = time + INSERTED;
        let from = match place {
            Place::Start => time.round(),
            Place::Inside => (time - INSERTED).max(0.0),
        };
        for (index, change) in changes.iter().enumerate() {
            let accompanies = index > 0;
            if place == Place::Start && time < STUCK {
                sequence.initially[change.contact] = change.to;
            } else {
                sequence.switches.push(Switch {
                    accompanies,
                    ..Self::slide(change.contact, change.to, place, from)
                });
            }
            if until < self.intervals as f64 {
                sequence.switches.push(Switch {
                    accompanies,
                    ..Self::slide(change.contact, change.back, Place::Inside, until)
                });
            }
        }
        Some(sequence)
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
                found.push(sequence.consistent());
            }
        }
        found
    }
}
