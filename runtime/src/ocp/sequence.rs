//! Which contact closes, opens, begins to stick or to slip when: the contact sequence of a motion.

use super::mode::{Mode, after, is_rough, sliding_velocity, zero_velocity};
use super::path::Path;
use crate::model::Model;
use crate::simulation::{Event, EventKind, Simulation};

/// Events nearer to an interval end than this share of the interval lie on it.
const AT_THE_END: f64 = 1e-7;
/// A contact between two flights that is shorter than this many intervals is deleted at the start.
const SHORT_CONTACT: f64 = 1.5;
/// A flight that is shorter than this many intervals is deleted at the start.
const SHORT_FLIGHT: f64 = 0.6;
/// The same for a contact that sticks, or slips in one direction.
const SHORT_SLIDING: f64 = 0.6;

/// Where in the grid of the controls a switch happens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Place {
    /// At the jump of the controls at the start of the interval; in the interval after the last one, an impact that
    /// ends the motion.
    Start,
    /// Inside the interval.
    Inside,
}

/// A contact closes, opens, is touched, or changes from one way of sliding to another. A touch is an impact after which
/// the contact is open again, because it bounces or because it is pulled away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Switch {
    pub(super) contact: usize,
    /// Whether there is an impact: the contact closes or is touched.
    pub(super) closes: bool,
    /// What the contact does afterwards.
    pub(super) mode: Mode,
    /// How it slides right after the impulse that belongs to the switch, if one does: its own, or that of the impact
    /// it accompanies.
    pub(super) impulse: Mode,
    /// Whether the contact switches at the same instant as another one, with the switch before it: both take part in
    /// one impact, or slide as parts of one body.
    pub(super) accompanies: bool,
    pub(super) interval: usize,
    pub(super) place: Place,
    /// When, in units of intervals; a guess until solved.
    pub(super) time: f64,
}

/// The modes of the contacts at the start, and the switches in order of time.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sequence {
    pub(super) initially: Vec<Mode>,
    pub(super) switches: Vec<Switch>,
}

/// What tells two sequences apart, whatever the times.
pub(super) type Signature = (Vec<Mode>, Vec<(usize, Mode, Mode, usize, Place)>);

impl Switch {
    /// Whether the contact closes and is closed afterwards.
    pub(super) fn stays(&self) -> bool {
        self.closes && !self.mode.is_open()
    }

    /// Whether the contact is no more than touched.
    pub(super) fn touches(&self) -> bool {
        self.closes && self.mode.is_open()
    }

    /// Whether the contact opens.
    pub(super) fn opens(&self) -> bool {
        !self.closes && self.mode.is_open()
    }

    /// Whether the contact is closed before and afterwards.
    pub(super) fn slides(&self) -> bool {
        !self.closes && !self.mode.is_open()
    }

    /// Whether the contact may have the mode `before` until then.
    fn follows(&self, before: Mode) -> bool {
        before.is_open() == self.closes && (self.closes || before != self.mode)
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
    /// Reads the sequence from a simulation with control intervals of length `interval` and the contacts that are closed
    /// at the start.
    pub(super) fn read(
        model: &dyn Model,
        closed: &[bool],
        simulation: &Simulation,
        (interval, intervals): (f64, usize),
    ) -> Self {
        let last = intervals as f64 * (1.0 - AT_THE_END);
        let trajectory = &simulation.trajectory;
        let mode_at = |contact: usize, time: f64, slips: Option<bool>| {
            let index = trajectory.time.partition_point(|&t| t <= time);
            after(model, simulation, (contact, index.saturating_sub(1)), slips)
        };
        let switches = simulation
            .events
            .iter()
            .enumerate()
            .filter(|(_, event)| event.time > 0.0 && event.time / interval < last)
            .map(|(index, event)| {
                let contact = event.contact;
                let time = event.time / interval;
                let mode = match event.kind {
                    EventKind::LiftOff => Mode::Open,
                    EventKind::Impact if touches(simulation, index) => Mode::Open,
                    EventKind::Slip => mode_at(contact, event.time, Some(true)),
                    EventKind::Stick => mode_at(contact, event.time, Some(false)),
                    _ => mode_at(contact, event.time, None),
                };
                let rough = is_rough(model, contact);
                let velocity = || {
                    let state = [&event.q[..], &event.v_after].concat();
                    sliding_velocity(model, contact, &state, event.time)
                };
                let impulse = Mode::closed(
                    rough,
                    if rough { velocity() } else { 0.0 },
                    zero_velocity(&event.v_after),
                );
                let closes = matches!(event.kind, EventKind::Impact | EventKind::Contact);
                let slides = matches!(event.kind, EventKind::Stick | EventKind::Slip);
                let leads = |other: &Event| {
                    let kind = match other.kind {
                        EventKind::Impact => closes || rough,
                        EventKind::Stick | EventKind::Slip => slides,
                        _ => false,
                    };
                    kind && other.time == event.time && other.contact != contact
                };
                let nearest = time.round();
                let at_jump = nearest > 0.0 && (time - nearest).abs() < AT_THE_END;
                let (interval, place) = if at_jump {
                    (nearest, Place::Start)
                } else {
                    (time.floor(), Place::Inside)
                };
                Switch {
                    contact,
                    closes,
                    mode,
                    impulse,
                    accompanies: simulation.events[..index].iter().any(leads),
                    interval: (interval as usize).min(intervals - 1),
                    place,
                    time,
                }
            })
            .collect();
        let initially = closed.iter().enumerate().map(|(contact, &closed)| {
            if !closed {
                return Mode::Open;
            }
            // One that lands at once is closed from then on.
            let own = |event: &&Event| event.contact == contact;
            let landing = match simulation.events.iter().find(own) {
                Some(first) if trajectory.contact_force[0][contact] <= 0.0 => first.time,
                _ => 0.0,
            };
            mode_at(contact, landing, None)
        });
        let mut sequence = Self {
            initially: initially.collect(),
            switches,
        };
        // A contact that stays closed may report another impact, and one that was only touched an opening.
        let mut modes = sequence.initially.clone();
        sequence.switches.retain(|switch| {
            let before = modes[switch.contact];
            modes[switch.contact] = switch.mode;
            switch.follows(before)
        });
        sequence
    }

    /// Reads the sequence from the modes of the contacts in each of `per_interval` elements of every control
    /// interval; the elements end at `ends`, in units of intervals. A contact closes, and stops sliding, at the share
    /// `closing` of the first element in which it does; it opens, and begins to slide, at the end of the last element
    /// before.
    pub(super) fn of_elements(
        initially: Vec<Mode>,
        modes: &[Vec<Mode>],
        (per_interval, ends): (usize, &[f64]),
        closing: f64,
    ) -> Self {
        let mut switches: Vec<Switch> = Vec::new();
        let mut initially = initially;
        // A contact at rest may be pulled into slip at once.
        for (before, now) in initially.iter_mut().zip(modes.iter().flatten()) {
            if let (Mode::Stick, Mode::Slip(_)) = (*before, *now) {
                *before = *now;
            }
        }
        let mut before = &initially;
        for (element, now) in modes.iter().enumerate() {
            for (contact, (&was, &is)) in before.iter().zip(now).enumerate() {
                if was == is {
                    continue;
                }
                let start = element.checked_sub(1).map_or(0.0, |before| ends[before]);
                let closes = was.is_open();
                let released = is.is_open() || was == Mode::Stick;
                let shift = if released { 0.0 } else { closing };
                let interval = element / per_interval;
                let at_jump = released && element % per_interval == 0 && element > 0;
                let time = start + shift * (ends[element] - start);
                let slides = |s: &Switch| s.slides() && s.time == time;
                switches.push(Switch {
                    contact,
                    closes,
                    mode: is,
                    impulse: is,
                    accompanies: !closes && !is.is_open() && switches.iter().any(slides),
                    interval,
                    place: if at_jump { Place::Start } else { Place::Inside },
                    time,
                });
            }
            before = now;
        }
        Self {
            switches,
            initially,
        }
    }

    /// With every opening, and every slip, at a jump of the controls inside the interval before it: controls that do
    /// not jump let go of a contact where its force vanishes or leaves the friction cone, which may be on either side
    /// of the node.
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
        let switches = switches.map(|s| {
            let impulse = if s.closes || s.accompanies {
                s.impulse
            } else {
                Mode::Open
            };
            (s.contact, s.mode, impulse, s.interval, s.place)
        });
        (self.initially.clone(), switches.collect())
    }

    /// Sorts the switches; `None` if a contact would close twice, open twice or begin what it does already, or
    /// switches outside the `intervals`.
    pub(super) fn ordered(mut self, intervals: usize) -> Option<Self> {
        let key = |s: &Switch| (s.interval, s.place);
        self.switches
            .sort_by(|a, b| key(a).cmp(&key(b)).then(a.time.total_cmp(&b.time)));
        let mut modes = self.initially.clone();
        let mut leader: Option<Switch> = None;
        for switch in &mut self.switches {
            let ends =
                switch.interval == intervals && switch.place == Place::Start && switch.closes;
            if !switch.follows(modes[switch.contact])
                || switch.interval >= intervals && !ends
                || switch.place == Place::Start && switch.interval == 0
            {
                return None;
            }
            modes[switch.contact] = switch.mode;
            let leads = |s: Switch| {
                (s.closes || s.slides() && switch.slides())
                    && key(&s) == key(switch)
                    && s.time == switch.time
            };
            switch.accompanies &= leader.is_some_and(leads);
            if !switch.accompanies {
                leader = Some(*switch);
            }
        }
        Some(self)
    }

    /// Whether an impact ends the motion.
    pub(super) fn ends_with_impact(&self, intervals: usize) -> bool {
        self.switches.iter().any(|s| s.interval == intervals)
    }

    /// The switches that accompany the one with this index.
    pub(super) fn companions(switches: &[Switch], index: usize) -> &[Switch] {
        let rest = &switches[index + 1..];
        let count = rest.iter().take_while(|switch| switch.accompanies).count();
        &rest[..count]
    }

    /// Mode of a contact before the switch with this index.
    pub(super) fn mode_before(&self, index: usize, contact: usize) -> Mode {
        let mut before = self.switches[..index].iter().rev();
        let last = before.find(|switch| switch.contact == contact);
        last.map_or(self.initially[contact], |switch| switch.mode)
    }

    /// Indices of neighbouring switches of the same contact, `(first, second)`.
    pub(super) fn neighbours(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.switches.len()).filter_map(|i| {
            let contact = self.switches[i].contact;
            let next = (i + 1..self.switches.len()).find(|&j| self.switches[j].contact == contact);
            next.map(|j| (i, j))
        })
    }

    /// As a simulation may see it: contacts that slip no faster than `slowest` rest, and switches of one instant are in
    /// the order of the contacts.
    pub(super) fn seen(&self, model: &dyn Model, path: &Path, slowest: f64) -> Self {
        let mut sequence = self.clone();
        let length = path.horizon / path.controls.intervals() as f64;
        let rests = |contact: usize, from: f64, to: f64| {
            let times = path.time.iter().zip(&path.states);
            let mut inside = times.filter(|(time, _)| (from..=to).contains(&(*time / length)));
            inside.all(|(&time, state)| {
                sliding_velocity(model, contact, state, time).abs() <= slowest
            })
        };
        for (contact, mode) in sequence.initially.iter_mut().enumerate() {
            let mut own = self.switches.iter().filter(|s| s.contact == contact);
            let end = own.next().map_or(f64::INFINITY, |switch| switch.time);
            if matches!(mode, Mode::Slip(_)) && rests(contact, 0.0, end) {
                *mode = Mode::Stick;
            }
        }
        for (index, switch) in sequence.switches.iter_mut().enumerate() {
            let mut own = self.switches[index + 1..].iter();
            let next = own.find(|s| s.contact == switch.contact);
            let end = next.map_or(f64::INFINITY, |next| next.time);
            // What is seen at a switch itself may belong to the motion before it.
            let start = switch.time + AT_THE_END;
            if matches!(switch.mode, Mode::Slip(_)) && rests(switch.contact, start, end) {
                switch.mode = Mode::Stick;
            }
        }
        let mut sequence = sequence.consistent();
        let switches = &mut sequence.switches;
        let mut start = 0;
        for end in 1..=switches.len() {
            if end == switches.len() || switches[end].time > switches[end - 1].time + AT_THE_END {
                switches[start..end].sort_by_key(|switch| switch.contact);
                start = end;
            }
        }
        sequence
    }

    /// Without changes that are none.
    pub(super) fn consistent(mut self) -> Self {
        let mut modes = self.initially.clone();
        self.switches.retain(|switch| {
            let before = std::mem::replace(&mut modes[switch.contact], switch.mode);
            switch.closes || before != switch.mode
        });
        self
    }

    /// With one switch, or none, in the place of those of a contact from `first` to `last`.
    pub(super) fn without(&self, (first, last): (usize, usize)) -> Self {
        let mut sequence = self.clone();
        let contact = self.switches[first].contact;
        let (from, to) = (self.switches[first], self.switches[last]);
        let before = self.mode_before(first, contact);
        let mut index = 0;
        sequence.switches.retain(|switch| {
            index += 1;
            switch.contact != contact || !(first..=last).contains(&(index - 1))
        });
        let both_closed = !before.is_open() && !to.mode.is_open();
        if before == to.mode || !(from.slides() || to.slides() || both_closed) {
            return sequence;
        }
        let (place, merged) = if before.is_open() {
            // A contact that sticks in the end may not have slipped in the impact.
            let impulse = match (to.mode, from.impulse) {
                (Mode::Slip(_), Mode::Stick) => Mode::Stick,
                (mode, _) => mode,
            };
            let mode = to.mode;
            (
                first,
                Switch {
                    mode,
                    impulse,
                    ..from
                },
            )
        } else {
            let removed = self.switches.len() - sequence.switches.len();
            let closes = false;
            (last + 1 - removed, Switch { closes, ..to })
        };
        sequence.switches.insert(place, merged);
        sequence
    }

    /// Without touches; `None` if there are none.
    pub(super) fn untouched(&self) -> Option<Self> {
        let mut sequence = self.clone();
        sequence.switches.retain(|switch| !switch.touches());
        (sequence.switches.len() < self.switches.len()).then_some(sequence)
    }

    /// Up to its last impact, which ends the motion; `None` without impacts.
    pub(super) fn ending(&self, intervals: usize) -> Option<Self> {
        let mut sequence = self.clone();
        let last = sequence.switches.iter().rposition(|s| s.closes)?;
        sequence.switches.truncate(last + 1);
        let first = sequence.switches.iter().rposition(|s| !s.accompanies)?;
        let impact = sequence.switches.split_off(first);
        for switch in impact.into_iter().filter(|switch| switch.closes) {
            sequence.switches.push(Switch {
                interval: intervals,
                place: Place::Start,
                time: intervals as f64,
                ..switch
            });
        }
        Some(sequence)
    }

    /// With touches in the place of contacts that are too short to be meant as such; `None` if there are none.
    pub(super) fn touching(&self) -> Option<Self> {
        let mut sequence = self.clone();
        let mut openings = Vec::new();
        for (i, j) in self.neighbours() {
            let (first, second) = (&self.switches[i], &self.switches[j]);
            if first.stays() && second.opens() && second.time - first.time < SHORT_CONTACT {
                sequence.switches[i].mode = Mode::Open;
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

    /// Without contacts and flights too short to be meant, and without changes of sliding that do not last: shortest
    /// contacts first.
    pub(super) fn tidied(mut self) -> Self {
        let contact = |first: &Switch, second: &Switch| first.stays() && second.opens();
        let flight = |first: &Switch, second: &Switch| first.opens() && second.stays();
        let sliding = |first: &Switch, second: &Switch| {
            !first.mode.is_open() && !second.closes && (first.slides() || second.slides())
        };
        type Pair<'a> = &'a dyn Fn(&Switch, &Switch) -> bool;
        let kinds: [(Pair<'_>, f64); 3] = [
            (&sliding, SHORT_SLIDING),
            (&contact, SHORT_CONTACT),
            (&flight, SHORT_FLIGHT),
        ];
        for (kind, limit) in kinds {
            loop {
                let duration =
                    |&(i, j): &(usize, usize)| self.switches[j].time - self.switches[i].time;
                let shortest = self
                    .neighbours()
                    .filter(|&(i, j)| kind(&self.switches[i], &self.switches[j]))
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
