//! A double pendulum whose joint has a stop, like a knee.

use std::error::Error;

use hangtime::model::Model;
use hangtime::simulation::{Fesd, InitialValueProblem, Simulation, Simulator};

hangtime::model! {
    /// Thigh and shank: two point masses, angles from below, and a knee that does not bend forwards.
    pub Knee {
        parameters {
            m_1: kg = 7, m_2: kg = 4, l_1: m = 0.42, l_2: m = 0.44, g: m/s^2 = 9.81,
            /// Most that the shank runs ahead of the thigh.
            limit: deg = 2,
        }
        coordinates { thigh, shank }
        let knee = (l_1*sin(thigh), -l_1*cos(thigh))
        let foot = (knee.y + l_2*sin(shank), knee.z - l_2*cos(shank))
        lagrangian m_1/2*|dot(knee)|^2 + m_2/2*|dot(foot)|^2 - m_1*g*knee.z - m_2*g*foot.z
        surface stop: thigh + limit - shank >= 0
        impact stop: inelastic
        start { thigh: -60 [deg], shank: -100 [deg] }
        horizon 2 [s]
    }
}

/// Simulates over the declared horizon.
pub fn simulate(model: &Knee) -> Result<Simulation, Box<dyn Error>> {
    let problem = InitialValueProblem::of(model, None)?;
    Ok(Fesd::default().simulate(model, &problem, &mut |_| {})?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let model = Knee::default();
    let simulation = simulate(&model)?;
    for event in &simulation.events {
        let contact = model.declaration().contacts[event.contact].name;
        let bend = (event.q[0] - event.q[1]).to_degrees();
        println!(
            "{:.9} s: {} at the {contact}, thigh at {:6.2} degrees, knee bent by {bend:.2} degrees",
            event.time,
            event.kind.name(),
            event.q[0].to_degrees()
        );
    }
    println!("{}", simulation.status.name());
    Ok(())
}
