//! The default simulation and the event-driven one agree on random scenes: a small part of the program
//! `cargo bench --bench agreement`, with fixed seeds.

#[path = "../../benches/agreement/draw.rs"]
mod draw;
#[path = "../../benches/agreement/judge.rs"]
mod judge;
#[path = "../../benches/agreement/scenes.rs"]
mod scenes;

use judge::{Verdict, judge};

/// Scenes of each kind.
const SCENES: u64 = 12;
/// Scenes of a kind that may end otherwise than solved; of many at most 5 % do.
const OTHERWISE: usize = 2;

#[test]
fn solved_runs_of_random_scenes_agree() {
    for kind in scenes::shipped().into_iter().chain(scenes::random()) {
        let (mut otherwise, mut compared) = (Vec::new(), 0.0);
        for seed in 0..SCENES {
            match judge(&*kind.scene(seed)) {
                Verdict::Agree(share) => compared += share,
                Verdict::Disagree(difference) => panic!(
                    "{} {seed}: apart by {:.1e}, default off by {:.1e}, event-driven by {:.1e} at {} of the horizon",
                    kind.name,
                    difference.apart,
                    difference.default,
                    difference.event,
                    difference.share
                ),
                Verdict::Ended { default, event } => {
                    let unsolved = if default.is_solved() { event } else { default };
                    assert_ne!(unsolved.status, "panicked", "{} {seed}", kind.name);
                    otherwise.push(format!("{seed} {}: {}", unsolved.status, unsolved.message));
                }
            }
        }
        // Where motions are chaotic the comparison ends early, but it is never empty.
        assert!(compared > 0.0, "{}: nothing compared", kind.name);
        assert!(
            otherwise.len() <= OTHERWISE,
            "{}: {otherwise:#?}",
            kind.name
        );
    }
}
