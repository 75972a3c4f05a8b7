//! A block slides down a rough incline, stops, and sticks.

use std::error::Error;

use hangtime::model::Model;
use hangtime::simulation::{Fesd, InitialValueProblem, Simulation, Simulator};

hangtime::model! {
    /// A block on an incline with Coulomb friction.
    pub BlockOnIncline {
        parameters { m: kg = 2, g: m/s^2 = 9.81, incline: deg = 15, mu = 0.5, speed: m/s = 3 }
        coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        surface ramp: x*sin(incline) + z*cos(incline) >= 0
        impact ramp: inelastic, friction mu
        start { dot(x): speed*cos(incline), dot(z): -speed*sin(incline) }
        horizon 3 [s]
    }
}

/// Simulates over the declared horizon.
pub fn simulate(model: &BlockOnIncline) -> Result<Simulation, Box<dyn Error>> {
    let problem = InitialValueProblem::of(model, None)?;
    Ok(Fesd::default().simulate(model, &problem, &mut |_| {})?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let model = BlockOnIncline::default();
    let simulation = simulate(&model)?;
    for event in &simulation.events {
        let contact = model.declaration().contacts[event.contact].name;
        let distance = event.q[0].hypot(event.q[1]);
        println!(
            "{:.9} s: {} on the {contact} after {distance:.9} m",
            event.time,
            event.kind.name()
        );
    }
    println!("{}", simulation.status.name());
    Ok(())
}
