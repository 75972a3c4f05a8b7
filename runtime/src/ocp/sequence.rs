//! Which contact closes and opens when: the contact sequence of a motion.

use crate::simulation::{Event, EventKind, Simulation};

/// Events nearer to an interval end than this share of the interval lie on it.
const AT_THE_END: f64 = 1e-7;
/// A contact between two flights that is shorter than this many intervals is deleted at the start.
const SHORT_CONTACT: f64 = 1.5;
/// A flight that is shorter than this many intervals is deleted at the start.
const SHORT_FLIGHT: f64 = 0.6;

/// Where in the grid of the controls a switch happens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Place {
    /// At the jump of the controls at the start of the interval; in the interval after the last one, an impact that
    /// ends the motion.
    Start,
    /// Inside the interval.
    Inside,
}

/// A contact closes, opens, or is touched: an impact after which it is open again, because it bounces or because it is
/// pulled away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Switch {
    pub(super) contact: usize,
    pub(super) closes: bool,
    /// Whether a closing is no more than a touch.
    pub(super) touches: bool,
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
pub(super) type Signature = Vec<(usize, bool, bool, usize, Place)>;

impl Switch {
    /// Whether the contact is closed afterwards.
    pub(super) fn stays(&self) -> bool {
        self.closes && !self.touches
    }
}

/// Whether an impact is followed by flight: the contact does not open later, and carries no force until the next event.
fn touches(simulation: &Simulation, index: usize) -> bool {
    let event = &simulation.events[index];
    let own = |other: &&Event| other.contact == event.contact;
    let next = simulation.events[index + 1..].iter().find(own);
    let until = next.map_or(f64::INFINITY, |next| next.time);
    if event.kind != EventKind::Impact
        || next.is_some_and(|next| next.kind == EventKind::LiftOff && next.time > event.time)
    {
        return false;
    }
    let trajectory = &simulation.trajectory;
    let mut forces = trajectory.time.iter().zip(&trajectory.contact_force);
    !forces.any(|(&time, forces)| time > event.time && time < until && forces[event.contact] > 0.0)
}

impl Sequence {
    /// Reads the sequence from a simulation with control intervals of length `interval`.
    pub(super) fn read(
        initially: Vec<bool>,
        simulation: &Simulation,
        interval: f64,
        intervals: usize,
    ) -> Self {
        let last = intervals as f64 * (1.0 - AT_THE_END);
        let switching = |kind| {
            matches!(
                kind,
                EventKind::Impact | EventKind::Contact | EventKind::LiftOff
            )
        };
        let switches = simulation
            .events
            .iter()
            .enumerate()
            .filter(|(_, event)| event.time > 0.0 && event.time / interval < last)
            .filter(|(_, event)| switching(event.kind))
            .map(|(index, event)| {
                let touches = touches(simulation, index);
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
                    touches,
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
        // A contact that stays closed may report another impact, and one that was only touched an opening.
        let mut closed = sequence.initially.clone();
        sequence.switches.retain(|switch| {
            let changes = closed[switch.contact] != switch.closes;
            closed[switch.contact] = switch.stays();
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
                    touches: false,
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

    /// With every opening at a jump of the controls inside the interval before it: controls that do not jump let go
    /// of a contact where its force vanishes, which may be on either side of the node.
    pub(super) fn without_jumps(mut self) -> Self {
        for switch in &mut self.switches {
            if switch.place == Place::Start && !switch.closes {
                switch.interval -= 1;
                switch.place = Place::Inside;
            }
        }
        self
    }

    /// What tells it apart from others.
    pub(super) fn signature(&self) -> Signature {
        let switches = self.switches.iter();
        switches
            .map(|s| (s.contact, s.closes, s.touches, s.interval, s.place))
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
            let ends =
                switch.interval == intervals && switch.place == Place::Start && switch.closes;
            if closed[switch.contact] == switch.closes
                || switch.interval >= intervals && !ends
                || switch.place == Place::Start && switch.interval == 0
            {
                return None;
            }
            closed[switch.contact] = switch.stays();
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

    /// Without touches; `None` if there are none.
    pub(super) fn untouched(&self) -> Option<Self> {
        let mut sequence = self.clone();
        sequence.switches.retain(|switch| !switch.touches);
        (sequence.switches.len() < self.switches.len()).then_some(sequence)
    }

    /// Up to its last impact, which ends the motion; `None` without impacts.
    pub(super) fn ending(&self, intervals: usize) -> Option<Self> {
        let mut sequence = self.clone();
        let last = sequence.switches.iter().rposition(|s| s.closes)?;
        sequence.switches.truncate(last + 1);
        let switch = sequence.switches.last_mut()?;
        switch.interval = intervals;
        switch.place = Place::Start;
        switch.time = intervals as f64;
        Some(sequence)
    }

    /// With touches in the place of contacts that are too short to be meant as such; `None` if there are none.
    pub(super) fn touching(&self) -> Option<Self> {
        let mut sequence = self.clone();
        let mut openings = Vec::new();
        for (i, j) in self.neighbours() {
            let (first, second) = (&self.switches[i], &self.switches[j]);
            if first.stays() && !second.closes && second.time - first.time < SHORT_CONTACT {
                sequence.switches[i].touches = true;
                openings.push(j);
            }
        }
        if openings.is_empty() {
            return None;
        }
        let mut index = 0;
        sequence.switches.retain(|_| {
            index += 1;
            !openings.contains(&(index - 1))
        });
        Some(sequence)
    }

    /// Without contacts and flights too short to be meant: shortest contacts first.
    pub(super) fn tidied(mut self) -> Self {
        for (closes, limit) in [(true, SHORT_CONTACT), (false, SHORT_FLIGHT)] {
            loop {
                let duration =
                    |&(i, j): &(usize, usize)| self.switches[j].time - self.switches[i].time;
                let shortest = self
                    .neighbours()
                    .filter(|&(i, j)| {
                        let (first, second) = (&self.switches[i], &self.switches[j]);
                        first.stays() == closes
                            && second.stays() != closes
                            && !first.touches
                            && !second.touches
                    })
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
