//! A double pendulum whose joint has a stop, like a knee.

use hangtime::prelude::*;

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

fn main() -> Result<(), InputError> {
    let run = simulate(&Knee::default()).run()?;
    println!("{run}");
    for event in &run.events {
        let bend = (event.q[0] - event.q[1]).to_degrees();
        println!(
            "{:.9} s: {} at the {}, thigh at {:6.2} degrees, knee bent by {bend:.2} degrees",
            event.time,
            event.kind,
            event.contact_name,
            event.q[0].to_degrees()
        );
    }
    Ok(())
}
