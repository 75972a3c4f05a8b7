//! Starts that are inside the ground by as much as a number with ten digits is off.

#![allow(clippy::unwrap_used, reason = "test code")]

use hangtime::prelude::*;
use hangtime::simulation::StepFormulation;

hangtime::model! {
    /// A block that slides over a floor, from a height that may be below it.
    pub Sliding {
        parameters { m: kg = 1, g: m/s^2 = 9.81, off: m = 0, e = 0, mu = 0, v: m/s = 1 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface floor: z >= 0
        impact floor: restitution e, friction mu
        start { z: off, dot(y): v }
        horizon 2 [s]
    }
}

#[test]
fn a_start_inside_the_ground_by_what_is_not_refused_moves_as_on_the_ground() {
    for off in [0.0, -1e-15, -5e-14, -1e-13, -1e-12] {
        for (e, mu) in [(0.0, 0.0), (0.5, 0.0), (0.0, 0.2)] {
            let scene = Sliding {
                off,
                e,
                mu,
                ..Sliding::default()
            };
            let deceleration = mu * scene.g;
            let end = if mu > 0.0 { 0.5 / deceleration } else { 2.0 };
            for formulation in [StepFormulation::ActiveSet, StepFormulation::TimeFreezing] {
                let method = Fesd {
                    formulation,
                    ..Fesd::default()
                };
                let run = simulate(&scene).method(method).run().unwrap();
                let event = simulate(&scene)
                    .method(EventDriven::default())
                    .run()
                    .unwrap();
                for run in [run, event] {
                    assert!(run.status.is_solved(), "{off}: {:?}", run.status);
                    let (y, z) = (run["y"].last().unwrap(), run["z"].last().unwrap());
                    assert!((y - end).abs() < 1e-9, "{off}: {y} instead of {end}");
                    assert!(z.abs() <= 1e-12, "{off}: {z}");
                }
            }
        }
    }
}
