//! Sweeps of a parameter through changes of the event sequence.

use hangtime::model::Model;
use hangtime::simulation::{EventDriven, Fesd};

use super::{largest, run};

/// Runs `model` at 300 values by the default and event-driven: how many disagree by more than their estimates together,
/// how many are solved by both, and how many sequences of events there are.
fn sweep(model: impl Fn(f64) -> Box<dyn Model>) -> (usize, usize, usize) {
    let (mut disagree, mut solved, mut sequences) = (0, 0, Vec::new());
    for k in 0..300 {
        let model = model(f64::from(k) / 299.0);
        let (elements, _) = run(model.as_ref(), &Fesd::default());
        let (events, _) = run(model.as_ref(), &EventDriven::default());
        if !elements.status.is_solved() || !events.status.is_solved() {
            continue;
        }
        solved += 1;
        let ends = [&elements, &events].map(|run| run.trajectory.q.last().expect("a state"));
        let size = largest(elements.trajectory.q.iter().flatten());
        let estimates = [&elements, &events].map(|run| run.error_estimate.expect("an estimate"));
        let allowed = 10.0 * (estimates[0] + estimates[1]) * size + 1e-11 * size;
        let apart = ends[0].iter().zip(ends[1]).map(|(a, b)| (a - b).abs());
        disagree += usize::from(apart.fold(0.0, f64::max) > allowed);
        let sequence: Vec<_> = elements
            .events
            .iter()
            .map(|e| (e.kind, e.contact))
            .collect();
        if !sequences.contains(&sequence) {
            sequences.push(sequence);
        }
    }
    (disagree, solved, sequences.len())
}

#[test]
fn sweeps_of_a_parameter_through_changes_of_the_event_sequence_agree_at_every_value() {
    let ride = |share: f64| -> Box<dyn Model> {
        Box::new(hangtime_models::PumpTrack {
            // From a ride that turns back to one with several flights.
            speed: 8.0 + 22.0 * share,
            ..hangtime_models::PumpTrack::default()
        })
    };
    let rod = |share: f64| -> Box<dyn Model> {
        Box::new(hangtime_models::FallingRod {
            mu: share,
            ..hangtime_models::FallingRod::default()
        })
    };
    for (name, (disagree, solved, sequences)) in [("ride", sweep(ride)), ("rod", sweep(rod))] {
        assert_eq!((disagree, solved), (0, 300), "{name}");
        assert!(sequences >= 3, "{name}: {sequences} sequences of events");
    }
}
