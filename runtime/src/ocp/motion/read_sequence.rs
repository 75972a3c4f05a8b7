//! Contact sequences read from motions.

use super::mode::{closed_mode, is_condition, is_frictional, sliding_velocity, zero_velocity};

use super::sequence::{Place, Sequence, Switch};
use super::trajectory::Trajectory;
use crate::model::{Model, Pieces};
use crate::simulation::ContactMode;
use crate::simulation::{Direction, Event, EventKind, Simulation};

/// Events nearer to an interval end than this share of the interval lie on it.
pub(in crate::ocp) const AT_THE_END: f64 = 1e-7;

/// Bounces that end within this many intervals are read as one landing.
pub(in crate::ocp) const COMES_TO_REST: f64 = 0.5;

/// A bounce less than this many intervals before a landing of a plan is its first one, and they last so many at most.
const AT_A_LANDING: f64 = 1e-2;
const MOST_OF_A_LANDING: f64 = 1.0;

/// A simulation under controls on equal intervals.
pub(in crate::ocp) struct Replay<'r> {
    pub(in crate::ocp) model: &'r dyn Model,
    pub(in crate::ocp) simulation: &'r Simulation,
    /// Length of an interval \[s\], and their number.
    pub(in crate::ocp) interval: f64,
    pub(in crate::ocp) intervals: usize,
}

impl Replay<'_> {
    /// The largest velocity of the motion, 1 at most: sliding velocities are measured by it where all are small.
    fn usual_velocity(&self) -> f64 {
        let velocities = self.simulation.trajectory.v.iter().flatten();
        velocities
            .fold(0.0, |largest: f64, v| largest.max(v.abs()))
            .min(1.0)
    }

    /// The sequence of the motion, without passages of edges, with the contacts that are closed at the start.
    pub(in crate::ocp) fn sequence(&self, closed: &[bool]) -> Sequence {
        let last = self.intervals as f64 * (1.0 - AT_THE_END);
        let events = &self.simulation.events;
        let inside = |event: &Event| event.time > 0.0 && event.time / self.interval < last;
        let switches = (0..events.len()).filter(|&index| inside(&events[index]));
        let mut switches: Vec<usize> = switches.collect();
        // A contact that takes over follows the one that opens.
        switches.sort_by(|&a, &b| {
            let (a, b) = (&events[a], &events[b]);
            let contact = |event: &Event| event.kind == EventKind::Contact;
            a.time.total_cmp(&b.time).then(contact(a).cmp(&contact(b)))
        });
        let initially = closed.iter().enumerate().map(|(contact, &closed)| {
            if !closed {
                return ContactMode::Open;
            }
            let mode = self.simulation.initial_modes[contact];
            if !mode.is_open() {
                return mode;
            }
            // One that lands at once is closed from then on; an impact that rounding makes comes before its contact.
            let mut own = events.iter().filter(|event| event.contact == contact);
            let first = own.clone().next().map(|event| event.time);
            let landing = own.rfind(|event| Some(event.time) == first);
            landing.map_or(mode, |event| event.modes[contact])
        });
        let mut sequence = Sequence {
            initially: initially.collect(),
            pieces: Pieces::default(),
            switches: switches
                .into_iter()
                .map(|index| self.switch(index))
                .collect(),
        };
        let ceasing = self.ceasing();
        if !ceasing.is_empty() {
            sequence.switches.extend(ceasing);
            sequence.switches.sort_by(|a, b| a.time.total_cmp(&b.time));
        }
        // A contact that stays closed may report another impact, and one that was only touched an opening.
        let mut modes = sequence.initially.clone();
        sequence.switches.retain(|switch| {
            let before = modes[switch.contact];
            modes[switch.contact] = switch.mode;
            switch.follows(before)
        });
        sequence
    }

    /// The switch that the event with this index is.
    fn switch(&self, index: usize) -> Switch {
        let (model, events) = (self.model, &self.simulation.events);
        let event = &events[index];
        let contact = event.contact;
        let frictional = is_frictional(model, contact);
        let velocity = if frictional {
            let state = [&event.q[..], &event.v_after].concat();
            sliding_velocity(model, contact, &state, event.time)
        } else {
            0.0
        };
        let closes = matches!(event.kind, EventKind::Impact | EventKind::Contact);
        let slides = matches!(
            event.kind,
            EventKind::Stick
                | EventKind::Slip
                | EventKind::Slide
                | EventKind::Switch
                | EventKind::When
        );
        let leads = |other: &Event| {
            let kind = match other.kind {
                EventKind::Impact => true,
                EventKind::Stick
                | EventKind::Slip
                | EventKind::Slide
                | EventKind::Switch
                | EventKind::When => slides,
                EventKind::LiftOff => event.kind == EventKind::Contact,
                EventKind::Contact => false,
            };
            kind && other.time == event.time && other.contact != contact
        };
        let time = event.time / self.interval;
        let (interval, place) = self.placed(time);
        Switch {
            contact,
            closes,
            mode: event.modes[contact],
            impulse: closed_mode(
                frictional,
                velocity,
                zero_velocity(&event.v_after, self.usual_velocity()),
            ),
            passes: false,
            sets: event.kind == EventKind::When,
            accompanies: events[..index].iter().any(leads)
                || event.kind == EventKind::Contact && events[index..].iter().any(leads),
            interval,
            place,
            time,
        }
    }

    /// The interval of a time in units of intervals, and the place in it.
    fn placed(&self, time: f64) -> (usize, Place) {
        let nearest = time.round();
        let at_jump = nearest > 0.0 && (time - nearest).abs() < AT_THE_END;
        let (interval, place) = if at_jump {
            (nearest, Place::Start)
        } else {
            (time.floor(), Place::Inside)
        };
        ((interval as usize).min(self.intervals - 1), place)
    }

    /// Where conditions cease to be true, which is no event.
    fn ceasing(&self) -> Vec<Switch> {
        let motion = &self.simulation.trajectory;
        let mut found = Vec::new();
        for contact in 0..self.model.declaration().contacts.len() {
            if !is_condition(self.model, contact) {
                continue;
            }
            // Friction against minus the function: while the condition is true, it slips backward.
            let below = |k: usize| {
                let state = [&motion.q[k][..], &motion.v[k]].concat();
                sliding_velocity(self.model, contact, &state, motion.time[k])
            };
            for k in 1..motion.time.len() {
                let (before, after, length) =
                    (below(k - 1), below(k), motion.time[k] - motion.time[k - 1]);
                if before >= 0.0 || after < 0.0 || length <= 0.0 {
                    continue;
                }
                let time = motion.time[k - 1] + length * before / (before - after);
                let time = time / self.interval;
                let (interval, place) = self.placed(time);
                let mode = ContactMode::Slip(Direction::Forward);
                found.push(Switch {
                    interval,
                    place,
                    ..Switch::inside(contact, false, mode, time)
                });
            }
        }
        found
    }
}

/// What the contacts do in the elements of a program.
pub(in crate::ocp) struct Elements {
    /// Modes of the contacts in each element.
    pub(in crate::ocp) modes: Vec<Vec<ContactMode>>,
    pub(in crate::ocp) per_interval: usize,
    /// Ends of the elements, in units of intervals.
    pub(in crate::ocp) ends: Vec<f64>,
}

/// Reads the sequence, without passages of edges, from the modes of the contacts in the elements. A contact closes, and stops sliding, at the share
/// `closing` of the first element in which it does; it opens, and begins to slide, at the end of the last element
/// before.
pub(in crate::ocp) fn of_elements(
    initially: Vec<ContactMode>,
    elements: &Elements,
    closing: f64,
) -> Sequence {
    let Elements {
        modes,
        per_interval,
        ends,
    } = elements;
    let mut switches: Vec<Switch> = Vec::new();
    let mut initially = initially;
    // A contact at rest may be pulled into slip at once.
    for (before, now) in initially.iter_mut().zip(modes.iter().flatten()) {
        if let (ContactMode::Stick, ContactMode::Slip(_)) = (*before, *now) {
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
            let released = is.is_open() || was == ContactMode::Stick;
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
                passes: false,
                sets: false,
                accompanies: !closes && !is.is_open() && switches.iter().any(slides),
                interval,
                place: if at_jump { Place::Start } else { Place::Inside },
                time,
            });
        }
        before = now;
    }
    Sequence {
        switches,
        pieces: Pieces::default(),
        initially,
    }
}

/// With bounces that come to rest within so many intervals as one landing, at the first of them: a plan in which an elastic contact closes
/// means all of them.
pub(in crate::ocp) fn landed(sequence: Sequence, model: &dyn Model, within: f64) -> Sequence {
    landed_where(sequence, model, |bounce, rest| {
        rest.time - bounce.time < within
    })
}

/// Bounces in the control interval in which they come to rest as one landing, as a plan has them.
pub(in crate::ocp) fn landed_in_an_interval(sequence: Sequence, model: &dyn Model) -> Sequence {
    landed_where(sequence, model, |bounce, rest| {
        bounce.interval == rest.interval
    })
}

/// Bounces from a landing of a plan on as that landing, which may last as long as the phase after it.
pub(in crate::ocp) fn landed_as(
    plan: &Sequence,
    sequence: Sequence,
    model: &dyn Model,
) -> Sequence {
    let landings = plan.switches.iter().filter(|switch| switch.stays());
    let landings: Vec<&Switch> = landings.collect();
    landed_where(sequence, model, |bounce, rest| {
        let mut own = landings.iter().filter(|l| l.contact == rest.contact);
        own.any(|l| l.time < bounce.time + AT_A_LANDING && rest.time < l.time + MOST_OF_A_LANDING)
    })
}

/// With bounces before a rest as one landing at the first of them, as far as they belong to it.
fn landed_where(
    mut sequence: Sequence,
    model: &dyn Model,
    belongs: impl Fn(&Switch, &Switch) -> bool,
) -> Sequence {
    let switches = &mut sequence.switches;
    let mut landing = 0;
    while landing < switches.len() {
        let rest = switches[landing];
        let Switch { contact, mode, .. } = rest;
        if !switches[landing].stays() || model.restitution(contact) == 0.0 {
            landing += 1;
            continue;
        }
        let own = (0..landing).rev();
        let own = own.filter(|&index| switches[index].contact == contact);
        let bounces =
            own.take_while(|&index| switches[index].touches() && belongs(&switches[index], &rest));
        let bounces: Vec<usize> = bounces.collect();
        let Some((&first, later)) = bounces.split_last() else {
            landing += 1;
            continue;
        };
        switches[first].mode = mode;
        let mut index = 0;
        switches.retain(|_| {
            index += 1;
            index - 1 != landing && !later.contains(&(index - 1))
        });
        landing -= later.len();
    }
    sequence
}

/// As a simulation may see it: contacts that slip no faster than `slowest` rest, and switches of one instant are in
/// the order of the contacts.
pub(in crate::ocp) fn seen(
    given: &Sequence,
    model: &dyn Model,
    motion: &Trajectory,
    slowest: f64,
) -> Sequence {
    let mut sequence = given.clone();
    let length = motion.horizon / motion.controls.intervals() as f64;
    let rests = |contact: usize, from: f64, to: f64| {
        let times = motion.time.iter().zip(&motion.states);
        let mut inside = times.filter(|(time, _)| (from..=to).contains(&(*time / length)));
        inside.all(|(&time, state)| sliding_velocity(model, contact, state, time).abs() <= slowest)
    };
    for (contact, mode) in sequence.initially.iter_mut().enumerate() {
        let mut own = given.switches.iter().filter(|s| s.contact == contact);
        let end = own.next().map_or(f64::INFINITY, |switch| switch.time);
        if matches!(mode, ContactMode::Slip(_)) && rests(contact, 0.0, end) {
            *mode = ContactMode::Stick;
        }
    }
    for (index, switch) in sequence.switches.iter_mut().enumerate() {
        let mut own = given.switches[index + 1..].iter();
        let next = own.find(|s| s.contact == switch.contact);
        let end = next.map_or(f64::INFINITY, |next| next.time);
        // What is seen at a switch itself may belong to the motion before it.
        let start = switch.time + AT_THE_END;
        if matches!(switch.mode, ContactMode::Slip(_)) && rests(switch.contact, start, end) {
            switch.mode = ContactMode::Stick;
        }
    }
    let mut sequence = landed(sequence.consistent(), model, COMES_TO_REST);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::Direction;

    fn elements(modes: &[ContactMode], per_interval: usize) -> Elements {
        let ends = (1..=modes.len()).map(|end| end as f64 / per_interval as f64);
        Elements {
            modes: modes.iter().map(|&mode| vec![mode]).collect(),
            per_interval,
            ends: ends.collect(),
        }
    }

    #[test]
    fn contact_of_elements_closes_inside_one_and_opens_at_the_end_of_one() {
        use ContactMode::{Frictionless, Open};
        // Four elements in two intervals: closed in the second and third one.
        let elements = elements(&[Open, Frictionless, Frictionless, Open], 2);
        let sequence = of_elements(vec![Open], &elements, 0.5);
        let times: Vec<f64> = sequence.switches.iter().map(|s| s.time).collect();
        assert_eq!(times, [0.75, 1.5]);
        let places: Vec<(usize, Place)> = sequence
            .switches
            .iter()
            .map(|s| (s.interval, s.place))
            .collect();
        assert_eq!(places, [(0, Place::Inside), (1, Place::Inside)]);
        assert!(sequence.ordered(2).is_some());
    }

    #[test]
    fn contact_that_opens_between_intervals_opens_at_the_jump_of_the_controls() {
        use ContactMode::{Frictionless, Open};
        let elements = elements(&[Frictionless, Frictionless, Open, Open], 2);
        let sequence = of_elements(vec![Frictionless], &elements, 0.5);
        let opening = sequence.switches[0];
        assert_eq!(
            (opening.time, opening.interval, opening.place),
            (1.0, 1, Place::Start)
        );
    }

    #[test]
    fn contact_at_rest_that_slips_in_the_first_element_slips_from_the_start() {
        let slips = ContactMode::Slip(Direction::Backward);
        let sequence = of_elements(vec![ContactMode::Stick], &elements(&[slips, slips], 1), 0.5);
        assert_eq!(sequence.initially, [slips]);
        assert!(sequence.switches.is_empty());
    }
}
