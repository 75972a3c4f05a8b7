//! Switches at the ends of control intervals: local optima that no multiplier points to.
//!
//! Controls jump where intervals end, and the best controls jump where a contact switches as well: at an impact the costate does. So
//! a switch at the end of an interval is often better than one a little before or after it, and a motion with a switch
//! inside an interval, which presses against nothing, is a local optimum that another one a fraction of an interval away betters. Such a
//! motion is tried with the switch at both ends of its interval, and one with a switch at the end of an interval with it at the next
//! ends. The other switches keep their places in the time before it and after it: of two impacts that follow each other, the
//! first one alone often cannot move.

use super::pressure::Pressure;
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::sequence::{Place, Sequence, Signature};
use crate::ocp::motion::trajectory::Trajectory;

/// Sequences with one switch, and what accompanies it, moved to the nearest ends of intervals on both sides, each once.
pub(super) fn at_nodes(pressure: &Pressure) -> Vec<Sequence> {
    let mut known: Vec<Signature> = Vec::new();
    let mut found = Vec::new();
    for (index, switch) in pressure.sequence.switches.iter().enumerate() {
        // Controls that do not jump let go of a contact, or let it slip, where its force says so.
        let waits = pressure.program.shape == ControlShape::Linear && !switch.closes;
        if switch.accompanies || waits {
            continue;
        }
        let before = match switch.place {
            Place::Start => switch.interval.saturating_sub(1),
            _ => switch.interval,
        };
        for node in [before, switch.interval + 1] {
            let moved = if node > 0 && node < pressure.intervals {
                at_node(pressure.sequence, index, node, pressure.intervals)
            } else {
                None
            };
            let Some(moved) = moved else { continue };
            let signature = moved.signature();
            if !known.contains(&signature) {
                known.push(signature);
                found.push(moved);
            }
        }
    }
    found
}

/// With a switch at the start of interval `node`, and those inside intervals before and after it in proportion; `None` where the
/// order of the switches is none.
fn at_node(given: &Sequence, index: usize, node: usize, intervals: usize) -> Option<Sequence> {
    let mut sequence = given.clone();
    let (from, to, last) = (given.switches[index].time, node as f64, intervals as f64);
    let moves = index..=index + Sequence::companions(&given.switches, index).len();
    for (place, switch) in sequence.switches.iter_mut().enumerate() {
        if moves.contains(&place) {
            (switch.interval, switch.place, switch.time) = (node, Place::Start, to);
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

/// The motion of a sequence, with its switches at the times of another one that has the same ones in the same order; as it is, if
/// that has not.
pub(super) fn warped(
    motion: &Trajectory,
    (from, to): (&Sequence, &Sequence),
    intervals: usize,
) -> Trajectory {
    if from.order() != to.order() {
        return motion.clone();
    }
    let interval = motion.horizon / intervals as f64;
    let both = from.switches.iter().zip(&to.switches);
    let instants = both.map(|(a, b)| (a.time * interval, b.time * interval));
    motion.warped(&instants.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Pieces;
    use crate::ocp::motion::control_grid::ControlGrid;
    use crate::ocp::motion::sequence::Switch;
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
    fn impact_at_the_end_of_its_interval_takes_later_ones_along() {
        let moved = at_node(&struck(), 0, 5, 10).expect("ordered");
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
        let moved = at_node(&struck(), 1, 8, 10).expect("ordered");
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
        let moved = at_node(&ending, 1, 9, 10).expect("ordered");
        assert!((moved.switches[0].time - 4.05).abs() < 1e-12);
        assert_eq!(moved.switches[1].interval, 9);
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
        let moved = at_node(&given, 0, 5, 10).expect("ordered");
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
