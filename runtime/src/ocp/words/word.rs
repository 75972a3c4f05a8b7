//! The order of contact modes of a motion.

use crate::model::{Model, Pieces};
use crate::ocp::motion::mode::{closed_mode, is_frictional, is_passed};
use crate::ocp::motion::sequence::{At, Sequence, Switch};
use crate::ocp::tuning::equal::INSTANT;
use crate::simulation::ContactMode;

/// What switches at one instant: groups of a leader and those that accompany it.
pub(super) type Instant = Vec<Switch>;

/// The modes of the contacts at the start, and what switches at one instant after the other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Word {
    pub(super) initially: Vec<ContactMode>,
    /// The pieces of edges that act at the start.
    pub(super) pieces: Pieces,
    pub(super) instants: Vec<Instant>,
    /// Whether the last instant, an impact, ends the motion.
    pub(super) ends_with_impact: bool,
}

/// A word with a guess of its times.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Draft {
    pub(super) word: Word,
    /// Of the instants \[s\].
    pub(super) times: Vec<f64>,
    /// Length of the motion \[s\].
    pub(super) horizon: f64,
}

impl Word {
    /// Number of phases.
    pub(super) fn phases(&self) -> usize {
        self.instants.len() + usize::from(!self.ends_with_impact)
    }

    /// Whether a phase begins with a landing after which a contact bounces until it rests.
    pub(super) fn settles(&self, model: &dyn Model, phase: usize) -> bool {
        let begin = phase.checked_sub(1).map(|last| self.instants[last].iter());
        begin.is_some_and(|mut switches| {
            switches.any(|switch| switch.stays() && model.restitution(switch.contact) > 0.0)
        })
    }

    /// Number of contacts that close on the way.
    pub(super) fn closings(&self) -> usize {
        let switches = self.instants.iter().flatten();
        switches
            .filter(|switch| switch.closes && !switch.passes)
            .count()
    }

    /// Modes of the contacts in each phase, and after an impact that ends the motion.
    pub(super) fn modes(&self) -> Vec<Vec<ContactMode>> {
        let mut modes = self.initially.clone();
        let mut all = vec![modes.clone()];
        for switch in &self.instants {
            for switch in switch {
                modes[switch.contact] = switch.mode;
            }
            all.push(modes.clone());
        }
        all
    }

    /// The sequence with its instants at the ends of intervals, so many in each phase; `None` where the order of the switches is none.
    pub(super) fn sequence(&self, counts: &[usize]) -> Option<Sequence> {
        let mut ends = counts.iter().scan(0, |sum, count| {
            *sum += count;
            Some(*sum)
        });
        let mut switches = Vec::new();
        for instant in &self.instants {
            let interval = ends.next()?;
            switches.extend(instant.iter().map(|switch| switch.at(At::end_of(interval))));
        }
        let total = counts.iter().sum();
        self.with_switches(switches).ordered(total)
    }

    /// A sequence with these switches, which may not be in order.
    pub(super) fn with_switches(&self, switches: Vec<Switch>) -> Sequence {
        Sequence {
            initially: self.initially.clone(),
            pieces: self.pieces.clone(),
            switches,
        }
    }
}

impl Draft {
    /// The word of a sequence on intervals of that length \[s\].
    pub(super) fn read(sequence: &Sequence, interval: f64, horizon: f64) -> Self {
        let mut instants: Vec<Instant> = Vec::new();
        let mut times: Vec<f64> = Vec::new();
        for switch in &sequence.switches {
            let time = (switch.time * interval).min(horizon);
            let plain = switch.at(At::end_of(0));
            let last = times.last().copied();
            let joins = last.is_some_and(|last| time - last <= INSTANT * horizon)
                && (switch.accompanies || instants.last().is_some_and(|i| may_join(i, switch)));
            match instants.last_mut().filter(|_| joins) {
                Some(instant) => instant.push(plain),
                None => {
                    instants.push(vec![plain]);
                    times.push(time);
                }
            }
        }
        let at_the_end = |time: &f64| horizon - time <= INSTANT * horizon;
        let closes = |instant: &Instant| instant.iter().any(|switch| switch.closes);
        let ends_with_impact =
            times.last().is_some_and(at_the_end) && instants.last().is_some_and(closes);
        let word = Word {
            initially: sequence.initially.clone(),
            pieces: sequence.pieces.clone(),
            instants,
            ends_with_impact,
        };
        Self {
            word,
            times,
            horizon,
        }
    }

    /// When each phase begins and ends \[s\].
    pub(super) fn phases(&self) -> Vec<(f64, f64)> {
        let mut ends = self.times.clone();
        if !self.word.ends_with_impact {
            ends.push(self.horizon);
        }
        let mut from = 0.0;
        let phases = ends.into_iter().map(|end| {
            let begin = std::mem::replace(&mut from, end);
            (begin, end)
        });
        phases.collect()
    }

    /// Up to an instant, which is left out, or as far as the motion goes.
    pub(super) fn up_to(&self, instant: usize) -> Self {
        let mut shorter = self.clone();
        if instant < self.times.len() {
            shorter.horizon = self.times[instant];
            shorter.times.truncate(instant);
            shorter.word.instants.truncate(instant);
            shorter.word.ends_with_impact = false;
        }
        shorter
    }
}

/// Whether a switch of its own belongs to the instant of others: of another contact, and without an impact.
fn may_join(instant: &Instant, switch: &Switch) -> bool {
    !switch.closes
        && instant
            .iter()
            .all(|other| other.contact != switch.contact && !other.closes)
}

/// How a contact that closes may slide.
pub(super) fn closed_modes(model: &dyn Model, contact: usize) -> Vec<ContactMode> {
    let frictional = is_frictional(model, contact);
    if !frictional {
        return vec![ContactMode::Frictionless];
    }
    let velocities: &[f64] = match is_passed(model, contact) {
        true => &[1.0, -1.0],
        false => &[0.0, 1.0, -1.0],
    };
    let velocities = velocities.iter();
    velocities
        .map(|&velocity| closed_mode(true, velocity, 0.5))
        .collect()
}

/// What switches between two phases with these modes: closings as parts of one impact, or openings by themselves and changes of sliding
/// as parts of one body.
pub(super) fn between(before: &[ContactMode], after: &[ContactMode]) -> Instant {
    let changed = || (0..before.len()).filter(|&i| before[i] != after[i]);
    let switch = |contact: usize, accompanies: bool| {
        let closes = before[contact].is_open();
        Switch {
            accompanies,
            ..Switch::inside(contact, closes, after[contact], 0.0).at(At::end_of(0))
        }
    };
    let closing: Vec<usize> = changed().filter(|&i| before[i].is_open()).collect();
    let (mut opening, mut sliding) = (Vec::new(), Vec::new());
    for contact in changed().filter(|&i| !before[i].is_open()) {
        if after[contact].is_open() {
            opening.push(contact);
        } else {
            sliding.push(contact);
        }
    }
    let mut instant = Vec::new();
    for &contact in &closing {
        instant.push(switch(contact, !instant.is_empty()));
    }
    if closing.is_empty() {
        instant.extend(opening.iter().map(|&contact| switch(contact, false)));
        let slides = sliding.iter().enumerate();
        instant.extend(slides.map(|(index, &contact)| switch(contact, index > 0)));
    } else {
        let others = opening.iter().chain(&sliding);
        instant.extend(others.map(|&contact| switch(contact, true)));
    }
    instant
}

/// A touch of an open contact.
pub(super) fn touch(contact: usize, impulse: ContactMode) -> Instant {
    vec![Switch::touch(contact, impulse, 0.0).at(At::end_of(0))]
}

#[cfg(test)]
mod tests {
    use super::*;

    const ON: ContactMode = ContactMode::Frictionless;
    const OFF: ContactMode = ContactMode::Open;

    fn word(initially: &[ContactMode], modes: &[&[ContactMode]]) -> Word {
        let mut before = initially;
        let instants = modes.iter().map(|after| {
            let instant = between(before, after);
            before = after;
            instant
        });
        Word {
            initially: initially.to_vec(),
            pieces: Pieces::default(),
            instants: instants.collect(),
            ends_with_impact: false,
        }
    }

    #[test]
    fn word_of_a_sequence_is_read_back_with_its_times() {
        let word = word(&[ON, OFF], &[&[OFF, OFF], &[ON, ON], &[OFF, ON]]);
        let sequence = word.sequence(&[2, 3, 2, 4]).expect("an order");
        assert_eq!(
            sequence
                .switches
                .iter()
                .map(|s| s.interval)
                .collect::<Vec<_>>(),
            [2, 5, 5, 7]
        );
        let draft = Draft::read(&sequence, 0.5, 5.5);
        assert_eq!(draft.word, word);
        assert_eq!(draft.times, [1.0, 2.5, 3.5]);
        assert_eq!(
            draft.phases(),
            [(0.0, 1.0), (1.0, 2.5), (2.5, 3.5), (3.5, 5.5)]
        );
        assert_eq!(draft.up_to(1).phases(), [(0.0, 1.0), (1.0, 2.5)]);
    }

    #[test]
    fn contacts_that_close_together_are_one_impact_and_those_that_open_are_not() {
        let impact = between(&[OFF, OFF, ON], &[ON, ON, OFF]);
        assert_eq!(
            impact.iter().map(|s| s.accompanies).collect::<Vec<_>>(),
            [false, true, true]
        );
        let openings = between(&[ON, ON], &[OFF, OFF]);
        assert!(openings.iter().all(|s| !s.accompanies));
    }

    #[test]
    fn word_that_closes_what_is_closed_has_no_sequence() {
        let mut wrong = word(&[OFF], &[&[ON]]);
        wrong.instants.push(wrong.instants[0].clone());
        assert_eq!(wrong.sequence(&[1, 1, 1]), None);
    }
}
