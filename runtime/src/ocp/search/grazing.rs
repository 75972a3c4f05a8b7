//! Flights that a surface holds back: the motion passes it as near as the plan may come, and would go deeper.
//!
//! Where it went deeper it would strike. The blow of a depth `d` is of the order of `sqrt(d)`, so that no multiplier says whether a motion
//! with it is better: one that touches the surface there is tried, and one in which the contact lasts.

use super::pressure::Pressure;
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::simulation::ContactMode;

/// Relative decrease of the objective for which the gap below which a flight counts as touching has to be given up: less than that is no
/// more than the price of the margin.
const WORTH: f64 = 1e-7;

/// With a touch, and with a contact, where a gap between the stages presses against its margin; what presses at stages are insertions.
pub(super) fn grazing(pressure: &Pressure) -> Vec<Sequence> {
    let x = pressure.program.program.physical(&pressure.solution.x);
    let horizon = pressure.program.horizon_at(&x);
    let solved = pressure.program.solved(&pressure.solution.x);
    let mut found = Vec::new();
    for (phase, solved) in pressure.program.phases.iter().zip(&solved) {
        let Some(last) = phase.stages.last() else {
            continue;
        };
        let passed = phase.passed.iter().copied();
        let held = passed.filter(|&(contact, _, row)| holds_back(pressure, contact, row));
        for (contact, share, _) in held {
            let seconds = solved.start + share * solved.length;
            let time = seconds / horizon * pressure.intervals as f64;
            let mode = pressure.mode_at(contact, last, seconds, &x);
            let struck = (contact, mode);
            let half = pressure.inserted;
            let sequences = striking(pressure.sequence, struck, (time, half), pressure.intervals);
            found.extend(sequences);
        }
    }
    found
}

/// Whether the row of a gap costs more than its margin does.
fn holds_back(pressure: &Pressure, contact: usize, row: usize) -> bool {
    let program = &pressure.program.program;
    let unit = program.objective_unit() / program.row_unit(row);
    let slope = pressure.solution.multipliers[row].abs() * unit;
    let touching = pressure.touching * pressure.units.share_of_gap(contact);
    let size = program.size_of(pressure.solution.objective);
    pressure.presses(row) && slope * touching > WORTH * size
}

/// A sequence with a touch at a time in intervals, and with a contact that lasts for `half` an interval's share before and after it.
fn striking(
    given: &Sequence,
    (contact, mode): (usize, ContactMode),
    (time, half): (f64, f64),
    intervals: usize,
) -> impl Iterator<Item = Sequence> {
    let touch = Switch::touch(contact, mode, time);
    let landing = Switch::inside(contact, true, mode, (time - half).max(0.0));
    let opening = Switch::inside(contact, false, ContactMode::Open, time + half);
    let both = [vec![touch], vec![landing, opening]];
    both.into_iter().filter_map(move |inserted| {
        let mut sequence = given.clone();
        sequence.switches.extend(inserted);
        sequence.ordered(intervals)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Pieces;

    #[test]
    fn flight_that_is_held_back_is_tried_with_a_touch_and_with_a_contact_between_its_other_switches()
     {
        let free = ContactMode::Frictionless;
        let given = Sequence {
            initially: vec![free, ContactMode::Open],
            pieces: Pieces::default(),
            switches: vec![
                Switch::inside(0, false, ContactMode::Open, 1.5),
                Switch::inside(0, true, free, 4.5),
            ],
        };
        let found: Vec<Sequence> = striking(&given, (0, free), (3.25, 0.25), 6).collect();
        let kinds = |sequence: &Sequence| -> Vec<(f64, bool, bool)> {
            let switches = sequence.switches.iter();
            switches.map(|s| (s.time, s.touches(), s.stays())).collect()
        };
        let (off, on) = ((1.5, false, false), (4.5, false, true));
        assert_eq!(kinds(&found[0]), [off, (3.25, true, false), on]);
        assert_eq!(
            kinds(&found[1]),
            [off, (3.0, false, true), (3.5, false, false), on]
        );
        assert_eq!(found[0].switches[1].impulse, free);
        // There is no time left for a contact that would last beyond the end.
        let late: Vec<Sequence> = striking(&given, (1, free), (5.9, 0.2), 6).collect();
        assert_eq!(late.len(), 1);
    }
}
