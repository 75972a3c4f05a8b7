//! Which contact closes and opens when: the contact sequence of a motion.

use crate::simulation::{Event, EventKind};

/// Events nearer to an interval end than this share of the interval lie on it.
const AT_THE_END: f64 = 1e-7;
/// A contact between two flights that is shorter than this many intervals is deleted at the start.
const SHORT_CONTACT: f64 = 1.5;
/// A flight that is shorter than this many intervals is deleted at the start.
const SHORT_FLIGHT: f64 = 0.6;

/// Where in the grid of the controls a switch happens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Place {
    /// At the jump of the controls at the start of the interval.
    Start,
    /// Inside the interval.
    Inside,
}

/// A contact closes or opens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Switch {
    pub(super) contact: usize,
    pub(super) closes: bool,
    pub(super) interval: usize,
    pub(super) place: Place,
    /// When, in units of intervals; a guess until solved.
    pub(super) time: f64,
}

/// The contacts closed at the start, and the switches in order of time.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sequence {
    pub(super) initially: Vec<bool>,
    pub(super) switches: Vec<Switch>,
}

/// What tells two sequences apart, whatever the times.
pub(super) type Signature = Vec<(usize, bool, usize, Place)>;

impl Sequence {
    /// Reads the sequence from the events of a simulation with control intervals of length `interval`.
    pub(super) fn read(
        initially: Vec<bool>,
        events: &[Event],
        interval: f64,
        intervals: usize,
    ) -> Self {
        let last = intervals as f64 * (1.0 - AT_THE_END);
        let switches = events
            .iter()
            .filter(|event| event.time > 0.0 && event.time / interval < last)
            .map(|event| {
                let time = event.time / interval;
                let closes = event.kind != EventKind::LiftOff;
                let nearest = time.round();
                let at_jump = nearest > 0.0 && (time - nearest).abs() < AT_THE_END;
                let (index, place) = if at_jump {
                    (nearest, Place::Start)
                } else {
                    (time.floor(), Place::Inside)
                };
                Switch {
                    contact: event.contact,
                    closes,
                    interval: (index as usize).min(intervals - 1),
                    place,
                    time,
                }
            })
            .collect();
        let mut sequence = Self {
            initially,
            switches,
        };
        // A contact that stays closed may report another impact.
        let mut closed = sequence.initially.clone();
        sequence.switches.retain(|switch| {
            let changes = closed[switch.contact] != switch.closes;
            closed[switch.contact] = switch.closes;
            changes
        });
        sequence
    }

    /// Reads the sequence from the contacts that are closed in each of `per_interval` elements of every
    /// control interval; the elements end at `ends`, in units of intervals. A contact closes at the share `closing`
    /// of the first element in which it is closed, and opens at the end of the last one.
    pub(super) fn of_elements(
        initially: Vec<bool>,
        closed: &[Vec<bool>],
        (per_interval, ends): (usize, &[f64]),
        closing: f64,
    ) -> Self {
        let mut switches = Vec::new();
        let mut before = &initially;
        for (element, now) in closed.iter().enumerate() {
            for (contact, (&was, &is)) in before.iter().zip(now).enumerate() {
                if was == is {
                    continue;
                }
                let start = element.checked_sub(1).map_or(0.0, |before| ends[before]);
                let shift = if is { closing } else { 0.0 };
                let interval = element / per_interval;
                let at_jump = !is && element % per_interval == 0 && element > 0;
                switches.push(Switch {
                    contact,
                    closes: is,
                    interval,
                    place: if at_jump { Place::Start } else { Place::Inside },
                    time: start + shift * (ends[element] - start),
                });
            }
            before = now;
        }
        Self {
            switches,
            initially,
        }
    }

    /// What tells it apart from others.
    pub(super) fn signature(&self) -> Signature {
        let switches = self.switches.iter();
        switches
            .map(|s| (s.contact, s.closes, s.interval, s.place))
            .collect()
    }

    /// Sorts the switches; `None` if a contact would close twice or open twice, or switches outside the
    /// `intervals`.
    pub(super) fn ordered(mut self, intervals: usize) -> Option<Self> {
        let key = |s: &Switch| (s.interval, s.place);
        self.switches
            .sort_by(|a, b| key(a).cmp(&key(b)).then(a.time.total_cmp(&b.time)));
        let mut closed = self.initially.clone();
        for switch in &self.switches {
            if closed[switch.contact] == switch.closes
                || switch.interval >= intervals
                || switch.place == Place::Start && switch.interval == 0
            {
                return None;
            }
            closed[switch.contact] = switch.closes;
        }
        Some(self)
    }

    /// Indices of neighbouring switches of the same contact, `(first, second)`.
    pub(super) fn neighbours(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.switches.len()).filter_map(|i| {
            let contact = self.switches[i].contact;
            let next = (i + 1..self.switches.len()).find(|&j| self.switches[j].contact == contact);
            next.map(|j| (i, j))
        })
    }

    /// Without two neighbouring switches of a contact.
    pub(super) fn without(&self, (i, j): (usize, usize)) -> Self {
        let mut sequence = self.clone();
        sequence.switches.remove(j);
        sequence.switches.remove(i);
        sequence
    }

    /// Without contacts and flights too short to be meant: shortest contacts first.
    pub(super) fn tidied(mut self) -> Self {
        for (closes, limit) in [(true, SHORT_CONTACT), (false, SHORT_FLIGHT)] {
            loop {
                let duration =
                    |&(i, j): &(usize, usize)| self.switches[j].time - self.switches[i].time;
                let shortest = self
                    .neighbours()
                    .filter(|pair| self.switches[pair.0].closes == closes)
                    .min_by(|a, b| duration(a).total_cmp(&duration(b)));
                match shortest {
                    Some(pair) if duration(&pair) < limit => self = self.without(pair),
                    _ => break,
                }
            }
        }
        self
    }
}
