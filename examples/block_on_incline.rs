//! A block slides down a rough incline, stops, and sticks.

use hangtime::prelude::*;

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

fn main() -> Result<(), InputError> {
    let run = simulate(&BlockOnIncline::default()).run()?;
    println!("{run}");
    for event in &run.events {
        let distance = event.q[0].hypot(event.q[1]);
        println!(
            "{} after {distance:.9} m: {}",
            event.kind, event.modes[event.contact]
        );
    }
    Ok(())
}
