//! A ball falls onto a slope, slides down, and stops at a wall.

use std::error::Error;

use hangtime::model::Model;
use hangtime::simulation::{Fesd, InitialValueProblem, Simulation, Simulator};

hangtime::model! {
    /// A ball on a slope with a wall.
    pub BallOnSlope {
        parameters { m: kg = 1, g: m/s^2 = 9.81, tilt = 0.5, wall_x: m = 3 }
        coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        surface slope: z + tilt*x >= 0
        surface wall: wall_x - x >= 0
        impact slope: inelastic
        impact wall: inelastic
        start { z: 1 [m] }
        horizon 2 [s]
    }
}

/// Simulates over the declared horizon.
pub fn simulate(model: &BallOnSlope) -> Result<Simulation, Box<dyn Error>> {
    let problem = InitialValueProblem::of(model, None)?;
    Ok(Fesd::default().simulate(model, &problem, &mut |_| {})?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let model = BallOnSlope {
        tilt: 0.4,
        ..BallOnSlope::default()
    };
    let simulation = simulate(&model)?;
    for event in &simulation.events {
        let contact = model.declaration().contacts[event.contact].name;
        let kind = event.kind.name();
        println!("{:.6} s: {kind} on the {contact}", event.time);
    }
    println!("{}", simulation.status.name());
    Ok(())
}
