//! Sequences in other basins: local optima that no multiplier points to.
//!
//! Controls jump where intervals end, and the best controls jump where a contact switches as well: at an impact the costate does. So a switch at
//! the end of an interval is often better than one a little before or after it, and a motion with a switch inside an interval, which presses
//! against nothing, is a local optimum that another one a fraction of an interval away betters. Between two ends a better one may lie as well,
//! with a barrier at each of them; and a motion that does all of it sooner, or later, is no neighbour either.

use super::pressing::Pressing;
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::sequence::{At, Place, Sequence, Signature, Switch};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::settings::Settings;
use crate::simulation::ContactMode;

/// Sequences that a rule makes of a plan.
type Basins = fn(&Pressing) -> Vec<Sequence>;

/// By the rules of the search that are followed, each once; those of the whole motion where it may be the result.
pub(super) fn basins(plan: &Pressing, settings: &Settings, proves: bool) -> Vec<Sequence> {
    let rules: [(&str, Basins, bool); 4] = [
        ("shortened", shortened, false),
        ("sliding-moved", sliding_moved, false),
        ("at-nodes", at_nodes, true),
        ("all-at-once", all_at_once, true),
    ];
    let rules = rules.into_iter();
    let followed =
        rules.filter(|&(name, _, of_whole)| settings.uses(name) && (proves || !of_whole));
    let mut known: Vec<Signature> = Vec::new();
    let mut found: Vec<Sequence> = followed.flat_map(|(_, rule, _)| rule(plan)).collect();
    found.retain(|sequence| {
        let signature = sequence.signature();
        let is_new = !known.contains(&signature);
        known.push(signature);
        is_new
    });
    found
}

/// Without the last switch: the motion may end before it.
fn shortened(plan: &Pressing) -> Vec<Sequence> {
    let mut sequence = plan.sequence.clone();
    while sequence.switches.pop().is_some_and(|last| last.accompanies) {}
    let shorter = sequence.switches.len() < plan.sequence.switches.len();
    let ordered = shorter.then(|| sequence.ordered(plan.intervals));
    ordered.flatten().into_iter().collect()
}

/// With a slip or an opening that begins at a jump of the controls an interval earlier or later: the force of a contact is often as constant as
/// the controls, and seldom lets it go between two jumps, so that no multiplier tells at which of them it should.
fn sliding_moved(plan: &Pressing) -> Vec<Sequence> {
    let mut found = Vec::new();
    for (index, switch) in plan.sequence.switches.iter().enumerate() {
        let sticks = plan.sequence.mode_before(index, switch.contact) == ContactMode::Stick;
        let jumps = switch.place == Place::Start && !switch.accompanies;
        if jumps && (switch.opens() || sticks && switch.slides()) {
            let companions = Sequence::companions(&plan.sequence.switches, index).len();
            let group = index..index + 1 + companions;
            found.extend(by_an_interval(plan.sequence, group, plan.intervals));
        }
    }
    found
}

/// With all switches an interval earlier or later, if there are several.
fn all_at_once(plan: &Pressing) -> Vec<Sequence> {
    match plan.sequence.switches.len() {
        0 | 1 => Vec::new(),
        all => by_an_interval(plan.sequence, 0..all, plan.intervals),
    }
}

/// With these switches an interval earlier, and later. What opens, sticks or slips before the start then does so initially; none is an impact
/// that early, and none ends the motion later.
fn by_an_interval(
    given: &Sequence,
    range: std::ops::Range<usize>,
    intervals: usize,
) -> Vec<Sequence> {
    let earlier = || {
        let mut sequence = given.clone();
        let early = |s: &Switch| (s.interval, s.place) <= (1, Place::Start);
        let own = given.switches[range.clone()].iter();
        let count = own.take_while(|switch| early(switch)).count();
        for switch in sequence.switches.drain(range.start..range.start + count) {
            if switch.closes || switch.passes {
                return None;
            }
            sequence.initially[switch.contact] = switch.mode;
        }
        for switch in &mut sequence.switches[range.start..range.end - count] {
            switch.interval -= 1;
            switch.time -= 1.0;
        }
        sequence.ordered(intervals)
    };
    let mut later = given.clone();
    for switch in &mut later.switches[range.clone()] {
        switch.interval += 1;
        switch.time += 1.0;
    }
    let fits = later.switches[range.end - 1].time < intervals as f64;
    let later = later.ordered(intervals).filter(|_| fits);
    earlier().into_iter().chain(later).collect()
}

/// With one switch, and what accompanies it, at the nearest ends of intervals on both sides, and in the middle of the next intervals, and with a
/// touch and a landing around an end as one landing there.
fn at_nodes(plan: &Pressing) -> Vec<Sequence> {
    let mut found = Vec::new();
    for (index, switch) in plan.sequence.switches.iter().enumerate() {
        // Controls that do not jump let go of a contact, or let it slip, where its force says so.
        let waits = plan.program.shape == ControlShape::Linear && !switch.closes;
        if switch.accompanies || waits {
            continue;
        }
        for to in targets(switch, plan.intervals) {
            found.extend(moved(plan.sequence, index, to, plan.intervals));
        }
    }
    found.extend(landed(plan.sequence, plan.intervals));
    found
}

/// Where a switch is moved to: the nearest ends of intervals, and then the middle of those next to the one that it is in.
fn targets(switch: &Switch, intervals: usize) -> impl Iterator<Item = At> {
    let at_start = switch.place == Place::Start;
    let before = switch.interval - usize::from(at_start && switch.interval > 0);
    let nodes = [before, switch.interval + 1].into_iter();
    let nodes = nodes.filter(move |node| (1..intervals).contains(node));
    let earlier = switch.interval.checked_sub(1);
    let beside = [earlier, Some(switch.interval + usize::from(!at_start))];
    let beside = beside.into_iter().flatten();
    let beside = beside.filter(move |&interval| interval < intervals);
    nodes
        .map(At::end_of)
        .chain(beside.map(|interval| At::inside(interval as f64 + 0.5)))
}

/// With a switch moved to a place, and those inside intervals before and after it in proportion: of two impacts that follow each other, the first
/// one alone often cannot move. Where it comes to or beyond switches at the ends of intervals, these by as many intervals as it has moved. `None`
/// where the order of the switches is none.
fn moved(given: &Sequence, index: usize, to: At, intervals: usize) -> Option<Sequence> {
    let alone = moved_among(given.clone(), index, to, intervals);
    // Of one contact no two happen at one instant.
    let alone = alone.filter(|sequence| {
        let switches = &sequence.switches;
        let mut pairs = sequence.neighbours();
        pairs.all(|(i, j)| switches[i].time < switches[j].time)
    });
    alone.or_else(|| moved_among(made_way(given, index, to), index, to, intervals))
}

/// With the switches at the ends of intervals that one comes to, or beyond, by as many intervals further.
fn made_way(given: &Sequence, index: usize, to: At) -> Sequence {
    let mut sequence = given.clone();
    let companions = Sequence::companions(&given.switches, index).len();
    let way = to.interval.abs_diff(given.switches[index].interval).max(1);
    for (place, switch) in sequence.switches.iter_mut().enumerate() {
        if switch.place != Place::Start {
            continue;
        }
        if place > index + companions && switch.time <= to.time {
            switch.interval += way;
        } else if place < index && switch.time >= to.time && switch.interval > way {
            switch.interval -= way;
        }
        switch.time = switch.interval as f64;
    }
    sequence
}

fn moved_among(given: Sequence, index: usize, to: At, intervals: usize) -> Option<Sequence> {
    let (from, last) = (given.switches[index].time, intervals as f64);
    let companions = Sequence::companions(&given.switches, index).len();
    let mut sequence = given;
    for (place, switch) in sequence.switches.iter_mut().enumerate() {
        if (index..=index + companions).contains(&place) {
            *switch = switch.at(to);
        } else if switch.place == Place::Inside {
            switch.time = if from > 0.0 && switch.time <= from {
                switch.time * to.time / from
            } else {
                last - (last - switch.time) * (last - to.time) / (last - from)
            };
            switch.interval = switch.time as usize;
        }
    }
    sequence.ordered(intervals)
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
            mode: landing.mode,
            ..touch.at(At::end_of(node))
        };
        sequence.switches.remove(j);
        sequence.ordered(intervals)
    };
    given.neighbours().filter_map(land).collect()
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

    fn touch(contact: usize, time: f64) -> Switch {
        Switch::inside(contact, true, ContactMode::Open, time)
    }

    /// Two impacts, the second one on two contacts, in ten intervals.
    fn two_impacts() -> Sequence {
        let companion = Switch {
            accompanies: true,
            ..touch(2, 7.8)
        };
        Sequence {
            initially: vec![ContactMode::Open; 3],
            pieces: Pieces::default(),
            switches: vec![touch(0, 4.5), touch(1, 7.8), companion],
        }
    }

    fn times(sequence: &Sequence) -> Vec<f64> {
        sequence.switches.iter().map(|s| s.time).collect()
    }

    #[test]
    fn switch_goes_to_the_next_ends_of_intervals_and_into_the_next_intervals() {
        let to = |switch: Switch| -> Vec<f64> { targets(&switch, 10).map(|to| to.time).collect() };
        assert_eq!(to(touch(0, 4.5)), [4.0, 5.0, 3.5, 5.5]);
        assert_eq!(to(touch(0, 4.0).at(At::end_of(4))), [3.0, 5.0, 3.5, 4.5]);
        assert_eq!(to(touch(0, 9.5)), [9.0, 8.5]);
        assert_eq!(to(touch(0, 0.5)), [1.0, 1.5]);
    }

    #[test]
    fn impacts_before_and_after_one_that_moves_keep_their_share_of_the_time() {
        let first = moved(&two_impacts(), 0, At::end_of(5), 10).expect("ordered");
        assert_eq!(first.switches[0].place(), At::end_of(5));
        // 2.2 of 5.5 intervals before the end are 2 of 5.
        assert!(times(&first)[1..].iter().all(|t| (t - 8.0).abs() < 1e-12));
        let second = moved(&two_impacts(), 1, At::end_of(8), 10).expect("ordered");
        assert!((times(&second)[0] - 4.5 * 8.0 / 7.8).abs() < 1e-12);
        assert_eq!(times(&second)[1..], [8.0, 8.0]);
        assert!(second.switches[2].accompanies);
    }

    #[test]
    fn switch_that_comes_to_where_its_contact_opens_takes_the_opening_along() {
        let opening = Switch::inside(0, false, ContactMode::Open, 5.0).at(At::end_of(5));
        let landing = Switch::inside(0, true, ContactMode::Frictionless, 4.5);
        let given = Sequence {
            switches: vec![landing, opening],
            ..two_impacts()
        };
        let to = |to: At| times(&moved(&given, 0, to, 10).expect("ordered"));
        assert_eq!(to(At::end_of(5)), [5.0, 6.0]);
        assert_eq!(to(At::inside(5.5)), [5.5, 6.0]);
        // Away from it the opening stays.
        assert_eq!(to(At::inside(3.5)), [3.5, 5.0]);
    }

    #[test]
    fn touch_before_an_end_and_landing_after_it_are_a_landing_there() {
        let at = |time: f64| -> Vec<At> {
            let mut given = two_impacts();
            let landing = Switch::inside(0, true, ContactMode::Frictionless, time);
            given.switches.insert(1, landing);
            let found = landed(&given, 10);
            let own = found.iter().flat_map(|sequence| &sequence.switches);
            let own = own.filter(|switch| switch.contact == 0);
            own.map(Switch::place).collect()
        };
        assert_eq!(at(5.3), [At::end_of(5)]);
        assert!(at(4.8).is_empty() && at(6.2).is_empty());
    }

    #[test]
    fn all_switches_are_shifted_by_an_interval_where_there_is_room_for_them() {
        let mut given = two_impacts();
        let shifted =
            |given: &Sequence, intervals| by_an_interval(given, 0..given.switches.len(), intervals);
        let found = shifted(&given, 10);
        assert_eq!(times(&found[0]), [3.5, 6.8, 6.8]);
        assert_eq!(times(&found[1]), [5.5, 8.8, 8.8]);
        // The second impact is in the last of eight intervals.
        assert_eq!(shifted(&given, 8).len(), 1);
        // What opens at the first end of an interval is open from the start an interval earlier; an impact that early is none.
        let lift = Switch::inside(0, false, ContactMode::Open, 1.0).at(At::end_of(1));
        given.initially[0] = ContactMode::Frictionless;
        given.switches.insert(0, lift);
        let earlier = &shifted(&given, 10)[0];
        assert_eq!(earlier.initially, vec![ContactMode::Open; 3]);
        assert_eq!(times(earlier), [3.5, 6.8, 6.8]);
        // Its motion is sooner as well, what comes before the first impact the faster.
        let motion = Trajectory {
            horizon: 10.0,
            controls: ControlGrid::constant(vec![vec![0.0]; 10]),
            time: vec![0.0, 1.0, 4.5, 4.5, 7.8, 7.8, 10.0],
            states: vec![vec![0.0]; 7],
        };
        let sooner = warped(&motion, (&given, earlier), 10);
        assert!((sooner.time[2] - 3.5).abs() < 1e-12 && (sooner.time[4] - 6.8).abs() < 1e-12);
        given.initially[0] = ContactMode::Open;
        given.switches[0] = touch(0, 1.0).at(At::end_of(1));
        assert_eq!(shifted(&given, 10).len(), 1);
        // That of other switches is left as it is.
        assert_eq!(warped(&motion, (&two_impacts(), &given), 10), motion);
    }
}
