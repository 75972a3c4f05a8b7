//! Impacts of several contacts that follow each other as fast as phases allow: at one instant, or in the other order.

use super::neighbours::Neighbour;
use super::pressure::Pressure;
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::ocp::tuning::neighbours::STUCK;

/// Sequences in which two impacts in a phase's least distance of each other are one, or change places. What an impact of several
/// contacts does is no limit of what their impacts do one after the other, so none of them adjoins.
pub(super) fn simultaneous(pressure: &Pressure) -> Vec<Neighbour> {
    let switches = &pressure.sequence.switches;
    let mut found = Vec::new();
    let leaders: Vec<usize> = (0..switches.len())
        .filter(|&index| !switches[index].accompanies)
        .collect();
    for pair in leaders.windows(2) {
        let (first, second) = (&switches[pair[0]], &switches[pair[1]]);
        let close = second.time - first.time < STUCK && first.place == second.place;
        if close && first.closes && second.closes && first.interval == second.interval {
            let sequences = [
                merged(pressure.sequence, pair),
                swapped(pressure.sequence, pair),
            ];
            let sequences = sequences.into_iter().flatten();
            let ordered = sequences.filter_map(|sequence| sequence.ordered(pressure.intervals));
            found.extend(ordered.map(|sequence| Neighbour {
                sequence,
                adjoins: false,
            }));
        }
    }
    found
}

/// With two neighbouring impacts at the instant of the first one; `None` where a contact takes part in both in a way that no single
/// impact has.
fn merged(given: &Sequence, pair: &[usize]) -> Option<Sequence> {
    let (first, second) = instants(given, pair);
    let mut all = first.to_vec();
    for switch in second {
        let before = all.iter().position(|other| other.contact == switch.contact);
        match before {
            None => all.push(Switch {
                accompanies: true,
                time: first[0].time,
                ..*switch
            }),
            // What the contact does after the second impact is what it does after both.
            Some(index) if all[index].closes && !switch.closes => {
                all[index].mode = switch.mode;
                all[index].impulse = switch.impulse;
            }
            Some(index) if all[index].slides() && !switch.closes => all[index].mode = switch.mode,
            Some(_) => return None,
        }
    }
    Some(replaced(given, pair, all))
}

/// With two neighbouring impacts in the other order; `None` where a contact takes part in both.
fn swapped(given: &Sequence, pair: &[usize]) -> Option<Sequence> {
    let (first, second) = instants(given, pair);
    let shared = first
        .iter()
        .any(|one| second.iter().any(|other| other.contact == one.contact));
    if shared {
        return None;
    }
    let at = |switches: &[Switch], time: f64| -> Vec<Switch> {
        let switches = switches.iter();
        switches.map(|&switch| Switch { time, ..switch }).collect()
    };
    let (early, late) = (first[0].time, second[0].time);
    let all = [at(second, early), at(first, late)].concat();
    Some(replaced(given, pair, all))
}

/// The switches of two instants that follow each other.
fn instants<'s>(given: &'s Sequence, pair: &[usize]) -> (&'s [Switch], &'s [Switch]) {
    let all = &given.switches;
    let end = pair[1] + 1 + Sequence::companions(all, pair[1]).len();
    (&all[pair[0]..pair[1]], &all[pair[1]..end])
}

/// With others in the place of the switches of both instants.
fn replaced(given: &Sequence, pair: &[usize], switches: Vec<Switch>) -> Sequence {
    let mut sequence = given.clone();
    let end = pair[1] + 1 + Sequence::companions(&given.switches, pair[1]).len();
    sequence.switches.splice(pair[0]..end, switches);
    sequence
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Pieces;
    use crate::simulation::{ContactMode, Direction};

    const SLIPS: ContactMode = ContactMode::Slip(Direction::Forward);

    fn along(switch: Switch) -> Switch {
        Switch {
            accompanies: true,
            ..switch
        }
    }

    /// Two fingers meet a box one after the other; the first impact lifts it off the floor, at the second one the first finger stops slipping.
    fn pinched() -> Sequence {
        Sequence {
            initially: vec![
                ContactMode::Open,
                ContactMode::Open,
                ContactMode::Frictionless,
            ],
            pieces: Pieces::default(),
            switches: vec![
                Switch::inside(0, true, SLIPS, 1.5),
                along(Switch::inside(2, false, ContactMode::Open, 1.5)),
                Switch::inside(1, true, ContactMode::Stick, 1.502),
                along(Switch::inside(0, false, ContactMode::Stick, 1.502)),
            ],
        }
    }

    #[test]
    fn impacts_at_one_instant_leave_every_contact_as_the_last_of_them_does() {
        let merged = merged(&pinched(), &[0, 2]).and_then(|merged| merged.ordered(3));
        let expected = vec![
            Switch::inside(0, true, ContactMode::Stick, 1.5),
            along(Switch::inside(2, false, ContactMode::Open, 1.5)),
            along(Switch::inside(1, true, ContactMode::Stick, 1.5)),
        ];
        assert_eq!(merged.map(|merged| merged.switches), Some(expected));
    }

    #[test]
    fn impacts_change_places_unless_a_contact_takes_part_in_both() {
        let given = pinched();
        assert_eq!(swapped(&given, &[0, 2]), None);
        let mut apart = given.clone();
        apart.switches.pop();
        let other = swapped(&apart, &[0, 2]).and_then(|other| other.ordered(3));
        let expected = vec![
            Switch::inside(1, true, ContactMode::Stick, 1.5),
            Switch::inside(0, true, SLIPS, 1.502),
            along(Switch::inside(2, false, ContactMode::Open, 1.502)),
        ];
        assert_eq!(other.map(|other| other.switches), Some(expected));
    }

    #[test]
    fn contact_that_closes_twice_takes_part_in_no_single_impact() {
        let mut twice = pinched();
        twice.switches[2] = Switch::inside(0, true, SLIPS, 1.502);
        assert_eq!(merged(&twice, &[0, 2]), None);
    }
}
