//! A ball bounces on the floor and comes to rest after infinitely many bounces in finite time.

use hangtime::prelude::*;

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

fn main() -> Result<(), InputError> {
    let model = BouncingBall::default();
    // From impact to impact.
    let run = simulate(&model).method(EventDriven::default()).run()?;
    println!("{run}");
    let mut impacts = run.events.iter();
    if let Some(last) = impacts.rfind(|event| event.kind == EventKind::Impact) {
        let fall = (2.0 * model.height / model.g).sqrt();
        let rest = fall * (1.0 + model.e) / (1.0 - model.e);
        println!(
            "at rest after {:.9} s; the series of all bounces ends at {rest:.9} s",
            last.time
        );
    }
    Ok(())
}
