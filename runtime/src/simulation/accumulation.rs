//! Conditions that come true ever faster, infinitely often before some instant (Zeno's paradox): what follows is not declared.
//!
//! A surface ends its bounces at rest; a condition that sets something says nothing of what is after the last of infinitely many.

use super::{Diagnosis, Event, EventKind, SimulationStatus};

/// Instants that are looked at: three pairs of times between them, as conditions may take turns.
const INSTANTS: usize = 7;
/// Share of a pair of times by which the next one has to be shorter.
const SHORTER: f64 = 1e-3;
/// Share of the horizon that all of them take at most: what is longer may still go on in another way.
const SHORT: f64 = 1e-5;

/// The status of a run to `horizon` whose conditions come true ever faster; `None` where they do not.
pub(super) fn of(events: &[Event], horizon: f64) -> Option<SimulationStatus> {
    let last = events.last().filter(|last| last.kind == EventKind::When)?;
    let mut times: Vec<f64> = Vec::with_capacity(INSTANTS);
    for event in events
        .iter()
        .rev()
        .filter(|event| event.kind == EventKind::When)
    {
        if times.last() != Some(&event.time) {
            times.push(event.time);
        }
        if times.len() == INSTANTS {
            break;
        }
    }
    let &[newest, .., oldest] = &times[..] else {
        return None;
    };
    // From the latest pair to the first.
    let pairs: Vec<f64> = times
        .windows(3)
        .step_by(2)
        .map(|of| of[0] - of[2])
        .collect();
    let shortens = pairs.windows(2).all(|of| of[0] < (1.0 - SHORTER) * of[1]);
    if times.len() < INSTANTS || newest - oldest > SHORT * horizon || !shortens {
        return None;
    }
    let (time, name) = (newest, last.contact_name);
    Some(SimulationStatus::EventLimit(Diagnosis {
        time,
        step: 0,
        contact: Some(last.contact),
        message: format!(
            "`{name}` comes true ever faster, infinitely often before about t = {time} s (Zeno), and nothing says what follows: declare \
             a `surface` with `restitution`, which comes to rest, or let the condition set what ends it"
        ),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether conditions that come true at these times accumulate in a run of 1 s.
    fn accumulate(times: impl IntoIterator<Item = f64>) -> bool {
        let event = |time| Event {
            time,
            kind: EventKind::When,
            contact: 0,
            contact_name: "z <= 0",
            modes: Vec::new(),
            q: Vec::new(),
            v_before: Vec::new(),
            v_after: Vec::new(),
            contact_impulse: Vec::new(),
            friction_impulse: Vec::new(),
        };
        of(&times.into_iter().map(event).collect::<Vec<_>>(), 1.0).is_some()
    }

    #[test]
    fn bounces_accumulate_once_they_are_short_and_a_clock_never_does() {
        let bounces = |count: i32| (0..count).map(|k| 0.4 * (1.0 - 0.5_f64.powi(k)));
        assert!(!accumulate(bounces(12)) && accumulate(bounces(30)));
        // Two that take turns, one of them slower than the other.
        let turns = |k: i32| {
            0.5 * (1.0 - 0.7_f64.powi(k))
                - if k % 2 == 0 {
                    0.1 * 0.7_f64.powi(k)
                } else {
                    0.0
                }
        };
        assert!(accumulate((0..60).map(turns)));
        assert!(!accumulate((0..60).map(|k| 0.3 + 1e-7 * f64::from(k))));
        assert!(!accumulate([0.3; 60]));
    }
}
