//! A ball bounces on the floor and comes to rest after infinitely many bounces in finite time.

use std::error::Error;

use hangtime::simulation::{EventDriven, EventKind, InitialValueProblem, Simulation, Simulator};

hangtime::model! {
    /// A ball above a floor.
    pub BouncingBall {
        parameters { m: kg = 1, g: m/s^2 = 9.81, e = 0.8, height: m = 1 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        surface floor: z >= 0
        impact floor: restitution e
        start { z: height }
        horizon 5 [s]
    }
}

/// Simulates over the declared horizon, from impact to impact.
pub fn simulate(model: &BouncingBall) -> Result<Simulation, Box<dyn Error>> {
    let problem = InitialValueProblem::of(model, None)?;
    Ok(EventDriven::default().simulate(model, &problem, &mut |_| {})?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let model = BouncingBall::default();
    let simulation = simulate(&model)?;
    let mut impacts = simulation
        .events
        .iter()
        .filter(|event| event.kind == EventKind::Impact);
    for (bounce, event) in impacts.clone().take(10).enumerate() {
        println!(
            "bounce {:2} at {:.9} s, {:7.4} m/s down, {:.4} m/s up",
            bounce + 1,
            event.time,
            event.v_before[0],
            event.v_after[0]
        );
    }
    if let Some(last) = impacts.next_back() {
        let fall = (2.0 * model.height / model.g).sqrt();
        let rest = fall * (1.0 + model.e) / (1.0 - model.e);
        println!(
            "at rest after {:.9} s; the series of all bounces ends at {rest:.9} s",
            last.time
        );
    }
    for note in &simulation.notes {
        println!("note: {note}");
    }
    println!("{}", simulation.status.name());
    Ok(())
}
