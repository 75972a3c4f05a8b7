//! What a gradient costs: `cargo bench --bench gradient` prints, for each scene, the shortest of thirty runs, the shortest of thirty
//! gradients by all its parameters, and their ratio. The derivation of the derivatives, once a scene, is not in it.

use std::time::{Duration, Instant};

use hangtime::model::Model;
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, Simulator, differentiate};
use hangtime_scene_files::of_text;

/// Scenes and their names.
const SCENES: [(&str, &str); 3] = [
    ("a ball that bounces", "
        parameters { m: kg = 1, g: m/s^2 = 9.81, e = 0.8, height: m = 1, v0: m/s = 0.5 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        surface floor: z >= 0
        impact floor: restitution e
        start { z: height, dot(z): v0 }
        horizon 2 [s]
    "),
    ("a ball that rubs on hills", "
        parameters { m: kg = 1, g: m/s^2 = 9.81, a: m = 0.2, w: 1/m = 2, e = 0.5, mu = 0.2 }
        coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        surface hills: z - a*sin(w*x) >= 0
        impact hills: restitution e, friction mu, sliding dot(x) + a*w*cos(w*x)*dot(z)
        start { x: 0 [m], z: 1 [m], dot(x): 1 [m/s] }
        horizon 1.1 [s]
    "),
    ("two links that strike a wall", "
        parameters { m: kg = 1, g: m/s^2 = 9.81, l: m = 0.8, e = 0.5, a0: rad = 1, b0: rad = 0.5 }
        coordinates { a: rad, b: rad }
        lagrangian m/2*l^2*(2*dot(a)^2 + dot(b)^2 + 2*dot(a)*dot(b)*cos(a - b)) + m*g*l*(2*cos(a) + cos(b))
        surface wall: l*sin(a) + l*sin(b) + 0.1[m] >= 0
        impact wall: restitution e
        start { a: a0, b: b0 }
        horizon 1.2 [s]
    "),
];

/// The shortest of many times, which other programs disturb least.
fn shortest(mut work: impl FnMut()) -> Duration {
    let time = |work: &mut dyn FnMut()| {
        let start = Instant::now();
        work();
        start.elapsed()
    };
    (0..30).map(|_| time(&mut work)).min().unwrap_or_default()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("| scene | parameters | run | gradient | ratio |\n|---|---|---|---|---|");
    for (name, text) in SCENES {
        let scene = of_text("scene.hang", text)?;
        let problem = InitialValueProblem::of(&scene, None)?;
        let parameters = scene.declaration().parameters.iter();
        let names: Vec<String> = parameters.map(|p| p.name.to_owned()).collect();
        let method = Fesd::default();
        let run = method.simulate(&scene, &problem, &mut |_| true)?;
        if let Some(obstacle) = differentiate(&scene, &problem, &run, &names)?.obstacle {
            return Err(format!("{name}: no derivative: {obstacle}").into());
        }
        let alone = shortest(|| {
            let _ = method.simulate(&scene, &problem, &mut |_| true);
        });
        let gradient = shortest(|| {
            let _ = differentiate(&scene, &problem, &run, &names);
        });
        let ratio = gradient.as_secs_f64() / alone.as_secs_f64();
        println!(
            "| {name} | {} | {alone:?} | {gradient:?} | {ratio:.2} |",
            names.len()
        );
    }
    Ok(())
}
