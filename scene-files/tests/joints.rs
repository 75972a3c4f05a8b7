//! Motions of scenes with joints against closed forms and against coordinates that need none.

use hangtime::prelude::*;
use hangtime_scene_files::{TextScene, of_text};

fn scene(text: &str) -> TextScene {
    match of_text("scene.hang", text) {
        Ok(scene) => scene,
        Err(error) => panic!("{error}"),
    }
}

const ROD: &str = "
    parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
    coordinates { x: m, z: m }
    lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
    joint rod: x^2 + z^2 == l^2
    outputs { tension: N = -2*l*force(rod) }
    start { x: 1.2, z: -0.9 }
    horizon 5 [s]
";

const ANGLE: &str = "
    parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
    coordinates { phi: rad }
    let p = (l*sin(phi), -l*cos(phi))
    lagrangian m/2*|dot(p)|^2 - m*g*p.z
    outputs { x: m = p.y, z: m = p.z, vx: m/s = dot(p).y, tension: N = m*g*cos(phi) + m*l*dot(phi)^2 }
    start { phi: 0.9272952180016122 }
    horizon 5 [s]
";

#[test]
fn pendulum_as_a_point_on_a_rod_is_that_of_its_angle() -> Result<(), InputError> {
    let (rod, angle) = (scene(ROD), scene(ANGLE));
    let exact = simulate(&angle)
        .method(EventDriven::default())
        .tolerance(1e-13)
        .run()?;
    let by_elements = simulate(&rod).run()?;
    let from_event_to_event = simulate(&rod).method(EventDriven::default()).run()?;
    for run in [by_elements, from_event_to_event] {
        assert!(run.status.is_solved(), "{}", run.status);
        let (own, its) = (run.at(5.0)?, exact.at(5.0)?);
        for (name, other) in [
            ("x", "x"),
            ("z", "z"),
            ("dot(x)", "vx"),
            ("tension", "tension"),
        ] {
            println!(
                "{name}: {} {} {:e}",
                own[name],
                its[other],
                own[name] - its[other]
            );
        }
        println!(
            "estimate {:?} residual {:e} elements {}",
            run.error_estimate, run.residuals.primal, run.counts.elements
        );
        println!("{:?}", run.notes);
        println!("cpu {}", run.seconds.total);
    }
    println!(
        "exact cpu {} elements {}",
        exact.seconds.total, exact.counts.elements
    );
    println!("fesd cpu {}", simulate(&angle).run()?.seconds.total);
    Ok(())
}
