//! Contact sequences made from others.

use super::sequence::{At, Place, Sequence, Switch};
use crate::simulation::ContactMode;

/// A contact between two flights that is shorter than this many intervals is deleted at the start.
const SHORT_CONTACT: f64 = 1.5;

/// A flight that is shorter than this many intervals is deleted at the start.
const SHORT_FLIGHT: f64 = 0.6;

/// Sticking, or slipping in one direction, that is shorter than this many intervals is deleted at the start.
const SHORT_SLIDING: f64 = 0.6;

/// An impact less than this many intervals from the end of one may be meant there: two elements of the relaxed motion.
const NEAR_AN_END: f64 = 0.15;

/// With one switch, or none, in the place of those of a contact from `first` to `last`.
pub(in crate::ocp) fn without(given: &Sequence, first: usize, last: usize) -> Sequence {
    let mut sequence = given.clone();
    let contact = given.switches[first].contact;
    let (from, to) = (given.switches[first], given.switches[last]);
    let before = given.mode_before(first, contact);
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
            (ContactMode::Slip(_), ContactMode::Stick) => ContactMode::Stick,
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
        let removed = given.switches.len() - sequence.switches.len();
        let closes = false;
        (last + 1 - removed, Switch { closes, ..to })
    };
    sequence.switches.insert(place, merged);
    sequence
}

/// Without touches; `None` if there are none.
pub(in crate::ocp) fn untouched(given: &Sequence) -> Option<Sequence> {
    let mut sequence = given.clone();
    sequence.switches.retain(|switch| !switch.touches());
    (sequence.switches.len() < given.switches.len()).then_some(sequence)
}

/// Up to its last impact, which ends the motion; `None` without impacts.
pub(in crate::ocp) fn ending(given: &Sequence, intervals: usize) -> Option<Sequence> {
    let mut sequence = given.clone();
    let last = sequence.switches.iter().rposition(|s| s.closes)?;
    sequence.switches.truncate(last + 1);
    let first = sequence.switches.iter().rposition(|s| !s.accompanies)?;
    let impact = sequence.switches.split_off(first);
    for switch in impact.into_iter().filter(|switch| switch.closes) {
        sequence.switches.push(switch.at(At::end_of(intervals)));
    }
    Some(sequence)
}

/// With the impacts near interval ends at these: there alone they may have to be, as where the goal leaves them no other time.
/// `None` if there are none.
pub(in crate::ocp) fn at_interval_ends(given: &Sequence, intervals: usize) -> Option<Sequence> {
    let mut sequence = given.clone();
    let (mut any, mut leader) = (false, false);
    for switch in &mut sequence.switches {
        let end = switch.time.round();
        let distance = (switch.time - end).abs();
        leader = if switch.accompanies {
            leader
        } else {
            let inside = switch.place == Place::Inside && end >= 1.0 && end < intervals as f64;
            switch.closes && inside && distance < NEAR_AN_END
        };
        if leader {
            *switch = switch.at(At::end_of(end as usize));
            any = true;
        }
    }
    any.then_some(sequence)
}

/// With touches in the place of contacts that are too short to be meant as such; `None` if there are none.
pub(in crate::ocp) fn touching(given: &Sequence) -> Option<Sequence> {
    touching_for_less_than(given, SHORT_CONTACT, |_| true)
}

/// With touches in the place of contacts that last less than `limit` intervals, of some contacts; `None` if there are none.
pub(in crate::ocp) fn touching_for_less_than(
    given: &Sequence,
    limit: f64,
    concerned: impl Fn(usize) -> bool,
) -> Option<Sequence> {
    let mut sequence = given.clone();
    let mut openings = Vec::new();
    for (i, j) in given.neighbours() {
        let (first, second) = (&given.switches[i], &given.switches[j]);
        let short = first.stays() && second.opens() && second.time - first.time < limit;
        if short && concerned(first.contact) {
            sequence.switches[i].mode = ContactMode::Open;
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

/// With touches at the edge in the place of contacts that end there within less than `limit` intervals after their impact.
pub(in crate::ocp) fn touching_at_edges(mut sequence: Sequence, limit: f64) -> Sequence {
    let ending = |sequence: &Sequence| {
        let mut pairs = sequence.neighbours();
        pairs.find(|&pair| lasts_at_edge(sequence, pair).is_some_and(|lasts| lasts < limit))
    };
    while let Some(pair) = ending(&sequence) {
        sequence = touching_at_edge(&sequence, pair);
    }
    sequence
}

/// How many intervals a contact lasts between two switches, if it closes with the first and ends at an edge with the second.
pub(in crate::ocp) fn lasts_at_edge(sequence: &Sequence, (i, j): (usize, usize)) -> Option<f64> {
    let switches = &sequence.switches;
    let passes = Sequence::companions(switches, j).iter().all(|s| s.passes);
    let ends = switches[i].stays() && Sequence::ends_at_edge(switches, j) && passes;
    ends.then(|| switches[j].time - switches[i].time)
}

/// With a touch at the edge in the place of a contact that [lasts](lasts_at_edge) between two switches.
pub(in crate::ocp) fn touching_at_edge(given: &Sequence, (i, j): (usize, usize)) -> Sequence {
    let mut sequence = given.clone();
    let landing = &given.switches[i];
    let passages = Sequence::companions(&given.switches, j);
    sequence.switches.drain(j..=j + passages.len());
    sequence.switches[i].mode = ContactMode::Open;
    let after = i + 1 + Sequence::companions(&given.switches, i).len();
    let passages = passages.iter().map(|passage| passage.at(landing.place()));
    sequence.switches.splice(after..after, passages);
    sequence
}

/// Without contacts and flights too short to be meant, and without changes of sliding that do not last: shortest
/// contacts first.
pub(in crate::ocp) fn tidied(mut sequence: Sequence) -> Sequence {
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
                |&(i, j): &(usize, usize)| sequence.switches[j].time - sequence.switches[i].time;
            let shortest = sequence
                .neighbours()
                .filter(|&(i, j)| kind(&sequence.switches[i], &sequence.switches[j]))
                .min_by(|a, b| duration(a).total_cmp(&duration(b)));
            match shortest {
                Some(pair) if duration(&pair) < limit => {
                    sequence = without(&sequence, pair.0, pair.1)
                }
                _ => break,
            }
        }
    }
    sequence
}

/// With every opening, and every slip, at a jump of the controls inside the interval before it: controls that do
/// not jump let go of a contact where its force vanishes or leaves the friction cone, which may be on either side
/// of the node.
pub(in crate::ocp) fn without_jumps(mut sequence: Sequence) -> Sequence {
    let switches = &sequence.switches;
    let taking = (0..switches.len()).map(|index| Sequence::takes_over(switches, index));
    let taking: Vec<bool> = taking.collect();
    for (switch, takes) in sequence.switches.iter_mut().zip(taking) {
        if switch.place == Place::Start && (!switch.closes || takes) {
            switch.interval -= 1;
            switch.place = Place::Inside;
        }
    }
    sequence
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Pieces;
    use crate::simulation::Direction;

    const FORWARD: ContactMode = ContactMode::Slip(Direction::Forward);
    const BACKWARD: ContactMode = ContactMode::Slip(Direction::Backward);

    fn switch(closes: bool, mode: ContactMode, time: f64) -> Switch {
        Switch::inside(0, closes, mode, time)
    }

    fn sequence(initially: ContactMode, switches: &[Switch]) -> Sequence {
        Sequence {
            initially: vec![initially],
            pieces: Pieces::default(),
            switches: switches.to_vec(),
        }
    }

    #[test]
    fn short_contact_and_short_flight_are_deleted_and_long_ones_stay() {
        let closing = switch(true, ContactMode::Frictionless, 1.5);
        for (opening, left) in [(2.9, 0), (3.1, 2)] {
            let contact = sequence(
                ContactMode::Open,
                &[closing, switch(false, ContactMode::Open, opening)],
            );
            assert_eq!(tidied(contact).switches.len(), left, "{opening}");
        }
        for (landing, left) in [(2.0, 0), (2.2, 2)] {
            let flight = [
                switch(false, ContactMode::Open, 1.5),
                switch(true, ContactMode::Frictionless, landing),
            ];
            let flight = sequence(ContactMode::Frictionless, &flight);
            assert_eq!(tidied(flight).switches.len(), left, "{landing}");
        }
    }

    #[test]
    fn stick_of_no_duration_between_two_slips_becomes_one_reversal() {
        let stops = switch(false, ContactMode::Stick, 1.5);
        let turns = switch(false, BACKWARD, 1.6);
        let tidied = tidied(sequence(FORWARD, &[stops, turns]));
        assert_eq!(tidied.switches, [switch(false, BACKWARD, 1.6)]);
    }

    #[test]
    fn landing_and_the_end_of_its_slip_become_a_landing_that_sticks() {
        let landing = switch(true, FORWARD, 1.5);
        let stops = switch(false, ContactMode::Stick, 1.7);
        let both = sequence(ContactMode::Open, &[landing, stops]);
        let merged = without(&both, 0, 1);
        assert_eq!(merged.switches, [switch(true, ContactMode::Stick, 1.5)]);
        // An impact that sticks stays one where the contact slips in the end.
        let landing = switch(true, ContactMode::Stick, 1.5);
        let slips = switch(false, BACKWARD, 1.7);
        let merged = without(&sequence(ContactMode::Open, &[landing, slips]), 0, 1);
        let expected = Switch {
            mode: BACKWARD,
            ..landing
        };
        assert_eq!(merged.switches, [expected]);
    }

    #[test]
    fn touches_are_removed_and_short_contacts_become_touches() {
        let touch = switch(true, ContactMode::Open, 0.5);
        let contact = [
            switch(true, ContactMode::Frictionless, 1.2),
            switch(false, ContactMode::Open, 1.9),
        ];
        let all = sequence(ContactMode::Open, &[touch, contact[0], contact[1]]);
        assert_eq!(untouched(&all), Some(sequence(ContactMode::Open, &contact)));
        assert_eq!(untouched(&sequence(ContactMode::Open, &contact)), None);
        let touched = Switch {
            mode: ContactMode::Open,
            ..contact[0]
        };
        assert_eq!(
            touching(&all),
            Some(sequence(ContactMode::Open, &[touch, touched]))
        );
        assert_eq!(touching(&sequence(ContactMode::Open, &[touch])), None);
    }

    #[test]
    fn contact_that_ends_at_an_edge_at_once_is_a_touch_there() {
        let landing = switch(true, ContactMode::Frictionless, 1.5);
        let (end, passage) = (
            switch(false, ContactMode::Open, 1.6),
            Switch::passage(1, 1.6),
        );
        let passage = Switch {
            accompanies: true,
            ..passage
        };
        let mut ending = sequence(ContactMode::Open, &[landing, end, passage]);
        ending.initially.push(ContactMode::Open);
        let touching = touching_at_edges(ending.clone(), 0.2);
        assert!(touching.switches[0].touches() && touching.switches[0].impulse == landing.mode);
        assert_eq!(
            touching.switches[1],
            Switch {
                time: 1.5,
                ..passage
            }
        );
        assert_eq!(touching.switches.len(), 2);
        assert_eq!(touching_at_edges(ending.clone(), 0.05), ending);
        // A contact that lets go is none that ends at an edge.
        ending.switches.pop();
        assert_eq!(touching_at_edges(ending.clone(), 0.2), ending);
    }

    #[test]
    fn motion_that_ends_with_its_last_impact_has_nothing_after_it() {
        let closing = switch(true, ContactMode::Frictionless, 1.5);
        let opening = switch(false, ContactMode::Open, 2.5);
        let ended = ending(&sequence(ContactMode::Open, &[closing, opening]), 4);
        let last = closing.at(At::end_of(4));
        assert_eq!(ended, Some(sequence(ContactMode::Open, &[last])));
        assert_eq!(
            ending(&sequence(ContactMode::Frictionless, &[opening]), 4),
            None
        );
    }

    #[test]
    fn opening_at_a_jump_is_moved_before_it_where_controls_do_not_jump() {
        let opening = switch(false, ContactMode::Open, 2.0).at(At::end_of(2));
        let moved = without_jumps(sequence(ContactMode::Frictionless, &[opening]));
        let expected = Switch {
            place: Place::Inside,
            interval: 1,
            ..opening
        };
        assert_eq!(moved.switches, [expected]);
        // What takes over from it moves with it.
        let closing = Switch {
            contact: 1,
            closes: true,
            mode: ContactMode::Frictionless,
            accompanies: true,
            ..opening
        };
        let moved = without_jumps(sequence(ContactMode::Frictionless, &[opening, closing]));
        assert!(Sequence::takes_over(&moved.switches, 1), "{moved:?}");
        assert_eq!(moved.switches[1].interval, 1);
    }
}
