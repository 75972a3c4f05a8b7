//! A ball bounces in a box without losing energy.

use hangtime::prelude::*;

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

fn main() -> Result<(), InputError> {
    let model = ElasticBallInBox::default();
    // From impact to impact.
    let run = simulate(&model).method(EventDriven::default()).run()?;
    println!("{run}");
    for contact in model.declaration().contacts {
        let hits = run
            .events
            .iter()
            .filter(|event| event.kind == EventKind::Impact && event.contact_name == contact.name);
        println!("{:3} impacts on the {}", hits.count(), contact.name);
    }
    let energies: Vec<f64> = (0..=3000)
        .map(|k| {
            let state = run.at(f64::from(k) / 100.0)?;
            let mut energy = [0.0; 2];
            model.energy(&[state.q, state.v].concat(), &mut energy);
            Ok(energy[0] + energy[1])
        })
        .collect::<Result<_, InputError>>()?;
    let largest = energies.iter().map(|e| (e - energies[0]).abs());
    println!(
        "energy {:.6} J, largest change {:.1e} J",
        energies[0],
        largest.fold(0.0, f64::max)
    );
    Ok(())
}
