//! What a gradient costs: `cargo bench --bench gradient` prints, for each scene, the shortest of thirty runs, the shortest of thirty
//! gradients by all its parameters, and their ratio; then the same of one value at the end by a hundred parameters, backwards and
//! forwards. The derivation of the derivatives, once a scene, is not in it.

use std::time::{Duration, Instant};

use hangtime::derivative::{GradientMode, differentiate, differentiate_values};
use hangtime::model::Model;
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, Simulator};
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

/// Parameters of the scenes that are differentiated backwards.
const MANY: usize = 100;

/// Texts of scenes with that many parameters that each do something of their own, their names, and a value at the end.
fn many() -> [(&'static str, String, &'static str); 3] {
    let list = |each: &dyn Fn(usize) -> String, between: &str| {
        let all: Vec<String> = (1..=MANY).map(each).collect();
        all.join(between)
    };
    let amplitudes = |unit: &str| {
        list(
            &|k| format!("a{k}: {unit} = {}", 0.3 / (k * k) as f64),
            ", ",
        )
    };
    let ball = format!(
        "parameters {{ {} }} coordinates {{ z: m }} lagrangian 1[kg]*(dot(z)^2/2 - 9.81[m/s^2]*z)
         forces {{ z: {} }} surface floor: z >= 0 impact floor: restitution 0.6 start {{ z: 1 [m] }} horizon 2 [s]",
        amplitudes("N"),
        list(&|k| format!("a{k}*cos({k}*t/1[s])"), " + "),
    );
    let hills = list(&|k| format!("a{k}*sin({k}*x/1[m])"), " + ");
    let hills = format!(
        "parameters {{ {} }} coordinates {{ x: m, z: m }}
         lagrangian 1[kg]*((dot(x)^2 + dot(z)^2)/2 - 9.81[m/s^2]*z)
         let h = {hills}
         surface hills: z >= h impact hills: restitution 0.6
         start {{ z: 1.5 [m], dot(x): 1 [m/s] }} horizon 1.2 [s]",
        amplitudes("m"),
    );
    let links = 8;
    let angles = |k: usize| list_of(links, &|i| format!("phi{i}"))[k].clone();
    let springs: Vec<String> = (1..=MANY)
        .map(|k| {
            format!(
                "a{k}/2*(sin({}*{k}/20) - {}/1[rad])^2",
                angles(k % links),
                angles((k + 1) % links)
            )
        })
        .collect();
    let chain = format!(
        "parameters {{ {} }} coordinates {{ {} }} lagrangian 1[kg*m^2]/2*({}) - ({})
         surface stop: phi0 + 2[rad] >= 0 impact stop: restitution 0.5
         start {{ phi0: 0.5, dot(phi0): -6 [rad/s] }} horizon 1 [s]",
        amplitudes("J"),
        list_of(links, &|i| format!("phi{i}: rad")).join(", "),
        list_of(links, &|i| format!("dot(phi{i})^2")).join(" + "),
        springs.join(" + "),
    );
    [
        ("a ball under a force with harmonics", ball, "z"),
        ("a ball on hills with harmonics", hills, "x"),
        ("eight wheels with springs between them", chain, "phi1"),
    ]
}

fn list_of(count: usize, each: &dyn Fn(usize) -> String) -> Vec<String> {
    (0..count).map(each).collect()
}

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
    println!("| scene | parameters | run | gradient | ratio |");
    println!("|---|---|---|---|---|");
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
    println!("\n| scene, one value | parameters | run | backwards | ratio | forwards | ratio |");
    println!("|---|---|---|---|---|---|---|");
    for (name, text, value) in many() {
        let scene = of_text("scene.hang", &text)?;
        let problem = InitialValueProblem::of(&scene, None)?;
        let names = ["all".to_owned()];
        let method = Fesd::default();
        let run = method.simulate(&scene, &problem, &mut |_| true)?;
        let of = [value.to_owned()];
        let by = |mode| differentiate_values(&scene, (&problem, &run), &names, (&of, Some(mode)));
        let backwards = by(GradientMode::Adjoint)?;
        if backwards.mode != GradientMode::Adjoint || backwards.obstacle.is_some() {
            return Err(format!("{name}: not backwards: {:?}", backwards.obstacle).into());
        }
        let alone = shortest(|| {
            let _ = method.simulate(&scene, &problem, &mut |_| true);
        });
        let [backwards, forwards] = [GradientMode::Adjoint, GradientMode::Forward].map(|mode| {
            shortest(|| {
                let _ = by(mode);
            })
        });
        let ratio = |time: Duration| time.as_secs_f64() / alone.as_secs_f64();
        println!(
            "| {name} | {MANY} | {alone:?} | {backwards:?} | {:.2} | {forwards:?} | {:.2} |",
            ratio(backwards),
            ratio(forwards)
        );
    }
    Ok(())
}
