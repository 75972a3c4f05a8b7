//! Many contacts, joints and switches at once, where the default may hand over to another method or stop with a name.

use hangtime::baselines::Moreau;
use hangtime::prelude::*;
use hangtime::simulation::{EventDriven, Simulation};
use hangtime_cli::Right;
use hangtime_models::hard_scenes;

use super::{run, scene};

pub(super) const SCENES: &[&str] = &[
    "bouncing-carts",
    "carts-between-stops",
    "eight-beads",
    "held-cart",
    "hinged-bar",
    "jammed-carts",
    "parting-carts",
    "tumbling-rod",
    "twisting",
];

/// What `hangtime chart --stability` calls right: a share of the largest coordinate, whatever a run says of itself.
const BOUND: f64 = 1e-4;
/// The values that have no closed form are confirmed to 3e-5 by Moreau-Jean's method with 160,000 steps or more; it is of first
/// order, and has an eighth of them here.
const FIRST_ORDER: f64 = 8.0 * 3e-5 * 2.0;
const STEPS: usize = 20_000;

/// The largest error of coordinates and states at the end, as a share of the largest value.
fn error(run: &Simulation, right: &[f64]) -> f64 {
    let mechanical = run.declaration.mechanical();
    let end = run.trajectory.time.len() - 1;
    let (q, v) = (&run.trajectory.q[end], &run.trajectory.v[end]);
    let is = q[..mechanical].iter().chain(&v[mechanical..]);
    let size = right.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
    let errors = is.zip(right).map(|(is, right)| (is - right).abs());
    errors.fold(0.0, f64::max) / size
}

#[test]
fn default_in_a_crowd_of_contacts_is_right() {
    for name in SCENES {
        let hard = hard_scenes().iter().find(|hard| hard.name == *name);
        let hard = hard.unwrap_or_else(|| panic!("no scene {name}"));
        let model = scene(hard);
        let Right::Formula(formula) = hard.right else {
            panic!("{name}: there is something to compare with");
        };
        let default = simulate(&model)
            .run()
            .expect("a problem that can be simulated");
        let (event, horizon) = run(&model, &EventDriven::default());
        let right = formula(&model, horizon);
        for (method, run) in [("default", &default), ("event-driven", &event)] {
            let error = error(run, &right);
            assert!(run.status.is_solved(), "{name}, {method}: {}", run.status);
            assert!(error <= BOUND, "{name}, {method}: {error:e}");
        }
        // Neither of the two methods that locate switches is what they are compared with.
        if matches!(*name, "eight-beads" | "hinged-bar" | "twisting") {
            continue;
        }
        let steps = Moreau {
            steps: STEPS,
            ..Moreau::default()
        };
        let (moreau, _) = run(&model, &steps);
        let error = error(&moreau, &right);
        assert!(error <= FIRST_ORDER, "{name}, Moreau-Jean: {error:e}");
    }
}
