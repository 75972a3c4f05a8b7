//! A ball bounces in a box without losing energy.

use std::error::Error;

use hangtime::model::Model;
use hangtime::simulation::{EventDriven, EventKind, InitialValueProblem, Simulation, Simulator};

hangtime::model! {
    /// A ball between a floor, a ceiling and two walls.
    pub ElasticBallInBox {
        parameters { m: kg = 1, g: m/s^2 = 9.81, width: m = 2, height: m = 1.5, speed: m/s = 3 }
        coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        surface floor: z >= 0
        surface ceiling: height - z >= 0
        surface left: x >= 0
        surface right: width - x >= 0
        impact floor, ceiling, left, right: restitution 1
        start { x: width/4, z: height/2, dot(x): speed, dot(z): speed }
        horizon 30 [s]
    }
}

/// Simulates over the declared horizon, from impact to impact.
pub fn simulate(model: &ElasticBallInBox) -> Result<Simulation, Box<dyn Error>> {
    let problem = InitialValueProblem::of(model, None)?;
    Ok(EventDriven::default().simulate(model, &problem, &mut |_| {})?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let model = ElasticBallInBox::default();
    let simulation = simulate(&model)?;
    for (index, contact) in model.declaration().contacts.iter().enumerate() {
        let hits = simulation
            .events
            .iter()
            .filter(|event| event.kind == EventKind::Impact && event.contact == index);
        println!("{:3} impacts on the {}", hits.count(), contact.name);
    }
    let energy = |q: &[f64], v: &[f64]| {
        let mut energy = [0.0; 2];
        model.energy(&[q[0], q[1], v[0], v[1]], &mut energy);
        energy[0] + energy[1]
    };
    let trajectory = &simulation.trajectory;
    let energies: Vec<f64> = trajectory
        .q
        .iter()
        .zip(&trajectory.v)
        .map(|(q, v)| energy(q, v))
        .collect();
    let largest = energies.iter().map(|e| (e - energies[0]).abs());
    println!(
        "energy {:.6} J, largest change {:.1e} J",
        energies[0],
        largest.fold(0.0, f64::max)
    );
    println!("{}", simulation.status.name());
    Ok(())
}
