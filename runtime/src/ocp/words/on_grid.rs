//! A word on the control grid: in which interval, or at which end of one, each switch is.

use super::off_grid::Timed;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::control_grid::ControlGrid;
use crate::ocp::motion::sequence::{Place, Switch};
use crate::ocp::motion::trajectory::Trajectory;

/// Change of a control, as a share of its range, that is a jump.
const JUMP: f64 = 0.1;
/// Distance from an end of an interval, in intervals, at which a switch is there in any case, and within which it may be on its other
/// side.
const AT_AN_END: f64 = 0.05;
const NEAR_AN_END: f64 = 0.25;

/// How switches are put into intervals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rounding {
    /// Each in the interval in which it is.
    Inside,
    /// At the nearest end where the controls jump there.
    AtJumps,
    /// Those near an end on its other side.
    Over,
    /// Each at the nearest end.
    AtEnds,
}

/// The motion of a word on the grid of the problem, with its switches in intervals in different ways.
pub(in crate::ocp) fn on_grid(setting: Setting, timed: &Timed) -> Vec<Candidate> {
    let intervals = setting.problem.intervals;
    let horizon = timed.motion.trajectory.horizon;
    let end = |k: usize| horizon * k as f64 / intervals as f64;
    let controls = (0..intervals).map(|k| timed.motion.controls(end(k), end(k + 1)));
    let trajectory = Trajectory {
        controls: ControlGrid::constant(controls.collect()),
        ..timed.motion.trajectory.clone()
    };
    let mut found: Vec<Candidate> = Vec::new();
    for rounding in [Rounding::Inside, Rounding::AtJumps, Rounding::Over, Rounding::AtEnds] {
        let places = in_order(places(setting, timed, rounding), intervals);
        let mut switches: Vec<Switch> = Vec::new();
        for (instant, (&time, place)) in
            timed.draft.word.instants.iter().zip(timed.draft.times.iter().zip(places))
        {
            let time = match place {
                (interval, Place::Start) => interval as f64,
                (interval, Place::Inside) => {
                    (time / horizon * intervals as f64).clamp(interval as f64, interval as f64 + 1.0)
                }
            };
            switches.extend(instant.iter().map(|switch| Switch {
                interval: place.0,
                place: place.1,
                time,
                ..*switch
            }));
        }
        let sequence = timed.draft.word.with_switches(switches).ordered(intervals);
        let Some(sequence) = sequence else { continue };
        let known = |other: &Candidate| other.sequence.signature() == sequence.signature();
        if !found.iter().any(known) {
            found.push(Candidate {
                objective: timed.objective,
                trajectory: trajectory.clone(),
                sequence,
            });
        }
    }
    found
}

/// Where each instant is put.
fn places(setting: Setting, timed: &Timed, rounding: Rounding) -> Vec<(usize, Place)> {
    let intervals = setting.problem.intervals;
    let n = setting.problem.q.len();
    let (lower, upper) = setting.bounds;
    let motion = &timed.motion;
    let horizon = motion.trajectory.horizon;
    let count = timed.draft.times.len();
    let jumps = |time: f64| {
        let reach = 1e-3 * horizon;
        let before = motion.controls(time - reach, time);
        let after = motion.controls(time, time + reach);
        let changes = before.iter().zip(&after).enumerate();
        changes.fold(0.0, |most: f64, (k, (a, b))| {
            let range = upper[n + k] - lower[n + k];
            let range = if range.is_finite() { range } else { a.abs().max(b.abs()).max(1.0) };
            most.max((a - b).abs() / range)
        }) > JUMP
    };
    let place = |(index, &time): (usize, &f64)| {
        if timed.draft.word.ends_with_impact && index + 1 == count {
            return (intervals, Place::Start);
        }
        let z = time / horizon * intervals as f64;
        let inside = ((z.max(0.0) as usize).min(intervals - 1), Place::Inside);
        if intervals < 2 {
            return inside;
        }
        let end = (z.round() as usize).clamp(1, intervals - 1);
        let distance = (z - end as f64).abs();
        match rounding {
            Rounding::Over if distance < NEAR_AN_END && z < end as f64 => (end, Place::Inside),
            Rounding::Over if distance < NEAR_AN_END => (end - 1, Place::Inside),
            Rounding::AtJumps if distance <= AT_AN_END || jumps(time) => (end, Place::Start),
            Rounding::AtEnds => (end, Place::Start),
            _ => inside,
        }
    };
    timed.draft.times.iter().enumerate().map(place).collect()
}

/// Places none of which is before the one before it; of two at one end the later one is inside the interval.
fn in_order(places: Vec<(usize, Place)>, intervals: usize) -> Vec<(usize, Place)> {
    let mut all: Vec<(usize, Place)> = Vec::with_capacity(places.len());
    for mut place in places {
        if let Some(&last) = all.last() {
            place = place.max(last);
            if place == last && place.1 == Place::Start && place.0 < intervals {
                place.1 = Place::Inside;
            }
        }
        all.push(place);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_stay_in_order_and_two_at_an_end_are_at_it_and_after_it() {
        use Place::{Inside, Start};
        let given = vec![(3, Start), (3, Start), (2, Inside), (5, Inside)];
        assert_eq!(in_order(given, 8), [(3, Start), (3, Inside), (3, Inside), (5, Inside)]);
    }
}
