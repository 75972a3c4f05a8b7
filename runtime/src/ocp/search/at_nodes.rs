//! Switches at the ends of control intervals and in the next ones: local optima that no multiplier points to.
//!
//! Controls jump where intervals end, and the best controls jump where a contact switches as well: at an impact the costate does. So
//! a switch at the end of an interval is often better than one a little before or after it, and a motion with a switch
//! inside an interval, which presses against nothing, is a local optimum that another one a fraction of an interval away betters. Such a
//! motion is tried with the switch at both ends of its interval, and one with a switch at the end of an interval with it at the next
//! ends. Between these a better one may lie as well, inside the next intervals, with a barrier at the end: there it is tried in the
//! middle; and with all switches an interval earlier or later, since a motion that does all of it sooner, or later, is no neighbour either;
//! what opens, sticks or slips at the first end of an interval does so from the start then.
//! The other switches keep their places in the time before it and after it: of two impacts that follow each other, the
//! first one alone often cannot move.

use super::pressure::Pressure;
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::sequence::{Place, Sequence, Switch};
use crate::ocp::motion::trajectory::Trajectory;

/// Sequences with one switch, and what accompanies it, moved to the nearest ends of intervals on both sides, and into the middle of the
/// next intervals, and with a touch and a landing around an end as one landing there.
pub(super) fn at_nodes(pressure: &Pressure) -> Vec<Sequence> {
    let mut found = Vec::new();
    for (index, switch) in pressure.sequence.switches.iter().enumerate() {
        // Controls that do not jump let go of a contact, or let it slip, where its force says so.
        let waits = pressure.program.shape == ControlShape::Linear && !switch.closes;
        if switch.accompanies || waits {
            continue;
        }
        for to in targets(switch, pressure.intervals) {
            found.extend(moved(pressure.sequence, index, to, pressure.intervals));
        }
    }
    found.extend(landed(pressure.sequence, pressure.intervals));
    found
}

/// Sequences with all switches an interval earlier or later, if there are several.
pub(super) fn all_at_once(pressure: &Pressure) -> Vec<Sequence> {
    if pressure.sequence.switches.len() > 1 {
        shifted(pressure.sequence, pressure.intervals)
    } else {
        Vec::new()
    }
}

/// An interval, the place in it, and the time there, in intervals.
type Target = (usize, Place, f64);

/// Where a switch is moved to: the nearest ends of intervals, and then the middle of those next to the one that it is in.
fn targets(switch: &Switch, intervals: usize) -> impl Iterator<Item = Target> {
    let at_start = switch.place == Place::Start;
    let nodes = [
        switch.interval - usize::from(at_start && switch.interval > 0),
        switch.interval + 1,
    ];
    let nodes = nodes
        .into_iter()
        .filter(move |node| (1..intervals).contains(node));
    let beside = [
        switch.interval.checked_sub(1),
        Some(switch.interval + usize::from(!at_start)),
    ];
    let beside = beside
        .into_iter()
        .flatten()
        .filter(move |&interval| interval < intervals);
    nodes.map(at_node).chain(beside.map(in_the_middle))
}

fn at_node(node: usize) -> Target {
    (node, Place::Start, node as f64)
}

fn in_the_middle(interval: usize) -> Target {
    (interval, Place::Inside, interval as f64 + 0.5)
}

/// With a switch moved to a place, and those inside intervals before and after it in proportion; where it comes to or beyond switches at
/// the ends of intervals, these by as many intervals as it has moved. `None` where the order of the switches is none.
fn moved(given: &Sequence, index: usize, to: Target, intervals: usize) -> Option<Sequence> {
    let alone = moved_among(given.clone(), index, to, intervals);
    // Of one contact no two happen at one instant.
    let alone = alone.filter(|sequence| {
        let switches = &sequence.switches;
        let mut pairs = sequence.neighbours();
        pairs.all(|(i, j)| switches[i].time < switches[j].time)
    });
    alone.or_else(|| moved_among(made_way(given, index, to), index, to, intervals))
}

/// With all switches an interval earlier and later: what leads to them is done that much sooner, or later. A contact that opens, sticks or
/// slips from before the start does so initially.
fn shifted(given: &Sequence, intervals: usize) -> Vec<Sequence> {
    let earlier = begun(given).and_then(|begun| {
        let mut sequence = begun;
        for switch in &mut sequence.switches {
            switch.interval -= 1;
            switch.time -= 1.0;
        }
        sequence.ordered(intervals)
    });
    let mut later = given.clone();
    for switch in &mut later.switches {
        switch.interval += 1;
        switch.time += 1.0;
    }
    let last = later.switches.last();
    let fits = last.is_some_and(|last| last.time < intervals as f64);
    let later = later.ordered(intervals).filter(|_| fits);
    earlier.into_iter().chain(later).collect()
}

/// A sequence as it goes on from the first end of an interval; `None` where that is after an impact.
fn begun(given: &Sequence) -> Option<Sequence> {
    let mut sequence = given.clone();
    let first = |switch: &Switch| (switch.interval, switch.place) <= (1, Place::Start);
    let count = sequence.switches.iter().take_while(|switch| first(switch));
    let count = count.count();
    for switch in sequence.switches.drain(..count) {
        if switch.closes || switch.passes {
            return None;
        }
        sequence.initially[switch.contact] = switch.mode;
    }
    Some(sequence)
}

/// With a touch and a landing of the same contact around the end of an interval, or after a touch there, as one landing at that end, each:
/// where the controls before it would not let the contact stay and those after it do, two blows are made of one.
fn landed(given: &Sequence, intervals: usize) -> Vec<Sequence> {
    let switches = &given.switches;
    let land = |(i, j): (usize, usize)| {
        let (touch, landing) = (switches[i], switches[j]);
        let node = touch.interval + usize::from(touch.place == Place::Inside);
        let after = landing.interval == node && landing.place == Place::Inside;
        let alone = [i, j].map(|index| Sequence::companions(switches, index).is_empty());
        if !(touch.touches() && landing.stays() && after && alone == [true; 2]) {
            return None;
        }
        let mut sequence = given.clone();
        sequence.switches[i] = Switch {
            interval: node,
            place: Place::Start,
            time: node as f64,
            mode: landing.mode,
            ..touch
        };
        sequence.switches.remove(j);
        sequence.ordered(intervals)
    };
    given.neighbours().filter_map(land).collect()
}

/// With the switches at the ends of intervals that one comes to, or beyond, by as many intervals further.
fn made_way(given: &Sequence, index: usize, (interval, _, to): Target) -> Sequence {
    let mut sequence = given.clone();
    let own = &given.switches[index];
    let companions = Sequence::companions(&given.switches, index).len();
    let way = interval.abs_diff(own.interval).max(1);
    for (place, switch) in sequence.switches.iter_mut().enumerate() {
        if switch.place != Place::Start {
            continue;
        }
        if place > index + companions && switch.time <= to {
            switch.interval += way;
        } else if place < index && switch.time >= to && switch.interval > way {
            switch.interval -= way;
        }
        switch.time = switch.interval as f64;
    }
    sequence
}

/// With a switch moved to a place, and those inside intervals before and after it in proportion.
fn moved_among(
    given: Sequence,
    index: usize,
    (interval, at, to): Target,
    intervals: usize,
) -> Option<Sequence> {
    let (from, last) = (given.switches[index].time, intervals as f64);
    let companions = Sequence::companions(&given.switches, index).len();
    let mut sequence = given;
    let moves = index..=index + companions;
    for (place, switch) in sequence.switches.iter_mut().enumerate() {
        if moves.contains(&place) {
            (switch.interval, switch.place, switch.time) = (interval, at, to);
        } else if switch.place == Place::Inside {
            switch.time = if from > 0.0 && switch.time <= from {
                switch.time * to / from
            } else {
                last - (last - switch.time) * (last - to) / (last - from)
            };
            switch.interval = switch.time as usize;
        }
    }
    sequence.ordered(intervals)
}

/// The motion of a sequence, with its switches at the times of another one that has the same ones in the same order, or all but the
/// first ones; as it is, if that has not.
pub(super) fn warped(
    motion: &Trajectory,
    (from, to): (&Sequence, &Sequence),
    intervals: usize,
) -> Trajectory {
    let dropped = from.switches.len().saturating_sub(to.switches.len());
    let last = Sequence {
        initially: to.initially.clone(),
        pieces: to.pieces.clone(),
        switches: from.switches[dropped..].to_vec(),
    };
    let same = last.order() == to.order() && (dropped > 0 || from.initially == to.initially);
    if !same || to.switches.is_empty() {
        return motion.clone();
    }
    let interval = motion.horizon / intervals as f64;
    let both = last.switches.iter().zip(&to.switches);
    let instants = both.map(|(a, b)| (a.time * interval, b.time * interval));
    motion.warped(&instants.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Pieces;
    use crate::ocp::motion::control_grid::ControlGrid;
    use crate::simulation::ContactMode;

    /// Two impacts, the second one on two contacts, in ten intervals.
    fn struck() -> Sequence {
        let touch = |contact, time| Switch::inside(contact, true, ContactMode::Open, time);
        Sequence {
            initially: vec![ContactMode::Open; 3],
            pieces: Pieces::default(),
            switches: vec![
                touch(0, 4.5),
                touch(1, 7.8),
                Switch {
                    accompanies: true,
                    ..touch(2, 7.8)
                },
            ],
        }
    }

    #[test]
    fn switch_goes_to_the_next_ends_of_intervals_and_into_the_next_intervals() {
        let inside = Switch::inside(0, true, ContactMode::Open, 4.5);
        let to = |switch: &Switch| -> Vec<f64> { targets(switch, 10).map(|to| to.2).collect() };
        assert_eq!(to(&inside), [4.0, 5.0, 3.5, 5.5]);
        let at_end = Switch {
            place: Place::Start,
            ..Switch::inside(0, true, ContactMode::Open, 4.0)
        };
        assert_eq!(to(&at_end), [3.0, 5.0, 3.5, 4.5]);
        assert_eq!(
            to(&Switch::inside(0, true, ContactMode::Open, 9.5)),
            [9.0, 8.5]
        );
        assert_eq!(
            to(&Switch::inside(0, true, ContactMode::Open, 0.5)),
            [1.0, 1.5]
        );
    }

    #[test]
    fn impact_at_the_end_of_its_interval_takes_later_ones_along() {
        let moved = moved(&struck(), 0, at_node(5), 10).expect("ordered");
        let first = moved.switches[0];
        assert_eq!(
            (first.interval, first.place, first.time),
            (5, Place::Start, 5.0)
        );
        // 2.2 of 5.5 intervals before the end are 2 of 5.
        for switch in &moved.switches[1..] {
            assert_eq!((switch.interval, switch.place), (8, Place::Inside));
            assert!((switch.time - 8.0).abs() < 1e-12);
        }
    }

    #[test]
    fn simultaneous_impacts_stay_together_and_earlier_ones_keep_their_share() {
        let moved = moved(&struck(), 1, at_node(8), 10).expect("ordered");
        assert!((moved.switches[0].time - 4.5 * 8.0 / 7.8).abs() < 1e-12);
        for switch in &moved.switches[1..] {
            assert_eq!((switch.interval, switch.place), (8, Place::Start));
        }
        assert!(moved.switches[2].accompanies);
    }

    #[test]
    fn impact_that_ends_the_motion_moves_with_all_before_it() {
        let mut ending = struck();
        ending.switches.truncate(1);
        let last = Switch {
            interval: 10,
            place: Place::Start,
            ..Switch::inside(1, true, ContactMode::Open, 10.0)
        };
        ending.switches.push(last);
        let moved = moved(&ending, 1, at_node(9), 10).expect("ordered");
        assert!((moved.switches[0].time - 4.05).abs() < 1e-12);
        assert_eq!(moved.switches[1].interval, 9);
    }

    #[test]
    fn switch_that_comes_to_where_its_contact_opens_takes_the_opening_along() {
        let opening = Switch {
            place: Place::Start,
            ..Switch::inside(0, false, ContactMode::Open, 5.0)
        };
        let landing = Switch::inside(0, true, ContactMode::Frictionless, 4.5);
        let given = Sequence {
            switches: vec![landing, opening],
            ..struck()
        };
        let times = |to: Target| -> Vec<f64> {
            let moved = moved(&given, 0, to, 10).expect("ordered");
            moved.switches.iter().map(|switch| switch.time).collect()
        };
        assert_eq!(times(at_node(5)), [5.0, 6.0]);
        assert_eq!(times(in_the_middle(5)), [5.5, 6.0]);
        // Away from it the opening stays.
        assert_eq!(times(in_the_middle(3)), [3.5, 5.0]);
    }

    #[test]
    fn touch_before_an_end_and_landing_after_it_are_a_landing_there() {
        let landing = |time: f64| Switch::inside(0, true, ContactMode::Frictionless, time);
        let at = |time: f64| -> Vec<(usize, f64)> {
            let mut given = struck();
            given.switches.insert(1, landing(time));
            let found = landed(&given, 10);
            let own = found.iter().flat_map(|sequence| &sequence.switches);
            let own = own.filter(|switch| switch.contact == 0);
            own.map(|switch| (switch.interval, switch.time)).collect()
        };
        assert_eq!(at(5.3), [(5, 5.0)]);
        assert!(at(4.8).is_empty() && at(6.2).is_empty());
        assert!(landed(&struck(), 10).is_empty());
    }

    #[test]
    fn all_switches_are_shifted_by_an_interval_where_there_is_room_for_them() {
        let times = |sequence: &Sequence| -> Vec<f64> {
            sequence.switches.iter().map(|switch| switch.time).collect()
        };
        let found = shifted(&struck(), 10);
        assert_eq!(times(&found[0]), [3.5, 6.8, 6.8]);
        assert_eq!(times(&found[1]), [5.5, 8.8, 8.8]);
        assert_eq!(found[1].switches[1].interval, 8);
        // The second impact is in the last of eight intervals.
        assert_eq!(shifted(&struck(), 8).len(), 1);
    }

    #[test]
    fn what_opens_at_the_first_end_of_an_interval_is_open_from_the_start_an_interval_earlier() {
        let lift = Switch {
            place: Place::Start,
            ..Switch::inside(0, false, ContactMode::Open, 1.0)
        };
        let mut given = struck();
        given.initially[0] = ContactMode::Frictionless;
        given.switches.insert(0, lift);
        let found = shifted(&given, 10);
        assert_eq!(found.len(), 2);
        let earlier = &found[0];
        assert_eq!(earlier.initially, vec![ContactMode::Open; 3]);
        let times: Vec<f64> = earlier.switches.iter().map(|switch| switch.time).collect();
        assert_eq!(times, [3.5, 6.8, 6.8]);
        // Its motion is sooner as well, what comes before the first impact the faster.
        let motion = Trajectory {
            horizon: 10.0,
            controls: ControlGrid::constant(vec![vec![0.0]; 10]),
            time: vec![0.0, 1.0, 4.5, 4.5, 7.8, 7.8, 10.0],
            states: vec![vec![0.0]; 7],
        };
        let sooner = warped(&motion, (&given, earlier), 10);
        assert_eq!(sooner.time[0], 0.0);
        assert!((sooner.time[2] - 3.5).abs() < 1e-12 && (sooner.time[4] - 6.8).abs() < 1e-12);
        // An impact that early is none an interval earlier.
        given.switches[0] = Switch {
            closes: true,
            mode: ContactMode::Open,
            ..lift
        };
        assert!(begun(&given).is_none());
    }

    #[test]
    fn motion_of_other_switches_is_left_as_it_is() {
        let motion = Trajectory {
            horizon: 10.0,
            controls: ControlGrid::constant(vec![vec![0.0]; 10]),
            time: vec![0.0, 4.5, 4.5, 7.8, 7.8, 10.0],
            states: vec![vec![0.0]; 6],
        };
        let given = struck();
        let moved = moved(&given, 0, at_node(5), 10).expect("ordered");
        let at = warped(&motion, (&given, &moved), 10);
        assert_eq!(at.time[..3], [0.0, 5.0, 5.0]);
        assert!((at.time[3] - 8.0).abs() < 1e-12 && at.time[5] == 10.0);
        let other = Sequence {
            switches: Vec::new(),
            ..given.clone()
        };
        assert_eq!(warped(&motion, (&given, &other), 10), motion);
    }
}
