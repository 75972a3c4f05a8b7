//! Time a call of what `model!` derives, for the table in BENCHMARKS.md.
//!
//! The protocol is that of the C loop it is compared with: one input changes by 1e-9 a call, the
//! number of calls is doubled until a run takes 0.1 s of CPU time, the fastest of seven runs counts.

use hangtime::model::{Function, Model};
use std::hint::black_box;
use std::time::Instant;

/// Declares a scene and keeps its text, from which its derivation is timed.
macro_rules! scene {
    ($text:ident: $($scene:tt)*) => {
        const $text: &str = stringify!($($scene)*);
        hangtime::model! { $($scene)* }
    };
}

scene! { PUMP:
    /// The pump track.
    pub Pump {
        parameters  { m_b: kg = 15, m_r: kg = 75, g: m/s^2 = 9.81, a: m = 0.2, k: 1/m = 2 }
        coordinates { y: m, s: m, l: m }
        controls    { u: N }
        fn track(y) = a*(1 - cos(k*y))
        let bike = (y, track(y) + s)
        let rider = (y, track(y) + s + l)
        lagrangian m_b/2*|dot(bike)|^2 + m_r/2*|dot(rider)|^2 - m_b*g*bike.z - m_r*g*rider.z
        forces { l: u }
        surface ground: s >= 0
        impact ground: inelastic, along (-diff(track)(y), 1, 0)
    }
}

scene! { BIKE2:
    /// A bicycle with two wheels on a wavy track and a rider on a prismatic link; the contact forces are inputs.
    pub Bike2 {
        parameters {
            g = 9.81, a = 0.6, b = 0.5, r = 0.33, m_f = 11, j_f = 1.2, m_w = 2, j_r = 4, m_r = 75,
            h = 0.2, k = 2,
        }
        coordinates { y, z, theta, l }
        controls { u, rear, front }
        fn track(y) = h - h*cos(k*y)
        let e = (cos(theta), sin(theta))
        let n = (-sin(theta), cos(theta))
        let frame = (y, z)
        let rear_hub = frame - b*e - 0.1*n
        let front_hub = frame + a*e - 0.1*n
        let rider = frame + 0.05*e + l*n
        fn kinetic(m, p) = m/2*|dot(p)|^2
        fn gap(p) = (p.z - track(p.y))/sqrt(1 + diff(track)(p.y)^2) - r
        fn rear_at(s) = gap((s, z) + (rear_hub - frame))
        fn front_at(s) = gap((s, z) + (front_hub - frame))
        fn rear_above(s) = gap((y, s) + (rear_hub - frame))
        fn front_above(s) = gap((y, s) + (front_hub - frame))
        fn rear_leaning(s) = gap(frame - b*(cos(s), sin(s)) - 0.1*(-sin(s), cos(s)))
        fn front_leaning(s) = gap(frame + a*(cos(s), sin(s)) - 0.1*(-sin(s), cos(s)))
        lagrangian kinetic(m_f, frame) + (j_f + j_r)/2*dot(theta)^2 + kinetic(m_r, rider)
            + kinetic(m_w, rear_hub) + kinetic(m_w, front_hub)
            - g*(m_f*frame.z + m_r*rider.z + m_w*(rear_hub.z + front_hub.z))
        forces {
            l: u,
            y: rear*diff(rear_at)(y) + front*diff(front_at)(y),
            z: rear*diff(rear_above)(z) + front*diff(front_above)(z),
            theta: rear*diff(rear_leaning)(theta) + front*diff(front_leaning)(theta),
        }
        surface back: gap(rear_hub) >= 0
        surface fore: gap(front_hub) >= 0
        impact back, fore: inelastic
        start { z: 0.7 }
    }
}

macro_rules! chain {
    ($text:ident, $name:ident, [$($q:ident)*], [$($u:ident)*], [$($force:tt)*], [$($link:tt)*], [$($energy:tt)*]) => {
        scene! { $text:
            /// Uniform rods of unit mass and length in relative angles, a torque at each joint.
            pub $name {
                parameters { g = 9.81 }
                coordinates { $($q,)* }
                controls { $($u,)* }
                fn half(angle) = (sin(angle)/2, -cos(angle)/2)
                fn energy(p, angle) = |dot(p)|^2/2 + dot(angle)^2/24 - g*p.z
                $($link)*
                lagrangian $($energy)*
                forces { $($force)* }
            }
        }
    };
}

chain!(CHAIN3, Chain3, [q1 q2 q3], [u1 u2 u3], [q1: u1, q2: u2, q3: u3], [
    let a2 = q1 + q2 let a3 = a2 + q3
    let p1 = half(q1) let p2 = 2*half(q1) + half(a2) let p3 = 2*half(q1) + 2*half(a2) + half(a3)
], [energy(p1, q1) + energy(p2, a2) + energy(p3, a3)]);

chain!(CHAIN5, Chain5, [q1 q2 q3 q4 q5], [u1 u2 u3 u4 u5],
    [q1: u1, q2: u2, q3: u3, q4: u4, q5: u5], [
    let a2 = q1 + q2 let a3 = a2 + q3 let a4 = a3 + q4 let a5 = a4 + q5
    let e2 = 2*half(q1) let e3 = e2 + 2*half(a2) let e4 = e3 + 2*half(a3) let e5 = e4 + 2*half(a4)
    let p1 = half(q1) let p2 = e2 + half(a2) let p3 = e3 + half(a3) let p4 = e4 + half(a4)
    let p5 = e5 + half(a5)
], [energy(p1, q1) + energy(p2, a2) + energy(p3, a3) + energy(p4, a4) + energy(p5, a5)]);

chain!(CHAIN10, Chain10, [q1 q2 q3 q4 q5 q6 q7 q8 q9 q10], [u1 u2 u3 u4 u5 u6 u7 u8 u9 u10],
    [q1: u1, q2: u2, q3: u3, q4: u4, q5: u5, q6: u6, q7: u7, q8: u8, q9: u9, q10: u10], [
    let a2 = q1 + q2 let a3 = a2 + q3 let a4 = a3 + q4 let a5 = a4 + q5 let a6 = a5 + q6
    let a7 = a6 + q7 let a8 = a7 + q8 let a9 = a8 + q9 let a10 = a9 + q10
    let e2 = 2*half(q1) let e3 = e2 + 2*half(a2) let e4 = e3 + 2*half(a3) let e5 = e4 + 2*half(a4)
    let e6 = e5 + 2*half(a5) let e7 = e6 + 2*half(a6) let e8 = e7 + 2*half(a7)
    let e9 = e8 + 2*half(a8) let e10 = e9 + 2*half(a9)
    let p1 = half(q1) let p2 = e2 + half(a2) let p3 = e3 + half(a3) let p4 = e4 + half(a4)
    let p5 = e5 + half(a5) let p6 = e6 + half(a6) let p7 = e7 + half(a7) let p8 = e8 + half(a8)
    let p9 = e9 + half(a9) let p10 = e10 + half(a10)
], [energy(p1, q1) + energy(p2, a2) + energy(p3, a3) + energy(p4, a4) + energy(p5, a5)
    + energy(p6, a6) + energy(p7, a7) + energy(p8, a8) + energy(p9, a9) + energy(p10, a10)]);

/// CPU time of this thread [s] where the system tells it, wall time elsewhere.
fn now(begin: Instant) -> f64 {
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok())
        .map_or_else(
            || begin.elapsed().as_secs_f64(),
            |nanoseconds| nanoseconds * 1e-9,
        )
}

/// The fastest of seven runs [ns a call].
fn time(x: &mut [f64], mut call: impl FnMut(&[f64])) -> f64 {
    let start = Instant::now();
    let mut run = |calls: u32| {
        let begin = now(start);
        for _ in 0..calls {
            x[0] += 1e-9;
            call(black_box(x));
        }
        now(start) - begin
    };
    let mut calls = 1000;
    while run(calls) < 0.1 {
        calls *= 2;
    }
    let mut times: Vec<f64> = (0..7)
        .map(|_| run(calls) / f64::from(calls) * 1e9)
        .collect();
    times.sort_by(f64::total_cmp);
    times[3]
}

/// CPU time of the derivation [s].
fn derivation(text: &str) -> f64 {
    let start = Instant::now();
    let begin = now(start);
    let tokens = text.parse().expect("the scene is made of tokens");
    black_box(hangtime_dsl::try_expand(tokens).expect("the scene compiles"));
    now(start) - begin
}

/// Times of acceleration, Jacobian and Hessian [ns a call].
fn times(model: &dyn Model) -> [f64; 3] {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let mut x: Vec<f64> = (0..declaration.inputs())
        .map(|i| 0.3 + 0.07 * ((i * 7) % 11) as f64)
        .collect();
    let weights: Vec<f64> = (0..n)
        .map(|i| 0.3 + 0.07 * ((i * 7 + 6) % 11) as f64)
        .collect();
    let mut a = vec![0.0; n];
    let mut jacobian = vec![0.0; declaration.free_jacobian.entries.len()];
    let mut hessian = vec![0.0; declaration.free_hessian.entries.len()];
    [
        time(&mut x, |x| model.free_acceleration(x, black_box(&mut a))),
        time(&mut x, |x| {
            model.jacobian(Function::Motion, x, black_box(&mut jacobian))
        }),
        time(&mut x, |x| {
            model.hessian(Function::Motion, x, &weights, black_box(&mut hessian))
        }),
    ]
}

fn report<M: Model>(name: &str, model: &M, text: &str) {
    let declaration = model.declaration();
    let operations: Vec<String> = declaration
        .kernels
        .iter()
        .filter(|kernel| kernel.name.starts_with("free") || kernel.name.starts_with("motion"))
        .map(|kernel| kernel.operations.to_string())
        .collect();
    let [f, j, h] = times(model);
    // The same text without a compiler.
    let loaded = hangtime_scene_files::of_text("scene.hang", text).expect("the scene is derived");
    let interpreted = times(&loaded).map(|time| format!("{time:.1}"));
    println!(
        "| {name} | {f:.1} | {j:.1} | {h:.1} | {} | {} | {} | {:.3} | {} |",
        operations.join("+"),
        declaration.free_jacobian.entries.len(),
        declaration.free_hessian.entries.len(),
        derivation(text),
        interpreted.join(" | ")
    );
}

fn main() {
    println!(
        "| model | f ns | J ns | H ns | operations | nnz J | nnz H | derivation s | f from text | J from text | H from text |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    report("pump", &Pump::default(), PUMP);
    report("bike2", &Bike2::default(), BIKE2);
    report("chain3", &Chain3::default(), CHAIN3);
    report("chain5", &Chain5::default(), CHAIN5);
    report("chain10", &Chain10::default(), CHAIN10);
}
