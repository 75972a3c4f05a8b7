//! Events that no step may pass over: random motions of freely turning and swinging bodies against their closed forms.

use std::f64::consts::{PI, TAU};

use hangtime::prelude::*;
use hangtime::simulation::{EventDriven, Simulation};
use hangtime_scene_files::TextScene;

use super::both::scene;
use super::random::Random;

/// How deep or how high a function goes beyond its zero that may be missed: a share of its size, beside which runs have errors.
const GRAZES: f64 = 1e-7;

fn run(scene: &TextScene, event_driven: bool) -> Simulation {
    let run = simulate(scene);
    let run = if event_driven {
        run.method(EventDriven::default()).run()
    } else {
        run.run()
    };
    run.expect("a problem")
}

/// Zeros of `f` up to `end` at which it rises, by samples `apart` and the extremes between them; none where it only just touches zero
/// somewhere, as a share of `size`.
fn rises(f: impl Fn(f64) -> f64, end: f64, apart: f64, size: f64) -> Option<Vec<f64>> {
    let count = (end / apart).ceil() as usize;
    let at = |k: usize| end * k as f64 / count as f64;
    let mut places = vec![0.0];
    for k in 1..=count {
        if k < count {
            let [a, b, c] = [k - 1, k, k + 1].map(|k| f(at(k)));
            if (b - a) * (c - b) < 0.0 {
                // The parabola through three places, twice.
                let mut middle = at(k);
                for step in [at(1), 1e-2 * at(1)] {
                    let [a, b, c] = [-step, 0.0, step].map(|by| f(middle + by));
                    middle -= 0.5 * step * (c - a) / (c - 2.0 * b + a);
                }
                if f(middle).abs() < GRAZES * size {
                    return None;
                }
                places.push(middle.clamp(at(k - 1), at(k + 1)));
            }
        }
        places.push(at(k));
    }
    places.sort_by(f64::total_cmp);
    let mut found = Vec::new();
    for pair in places.windows(2) {
        let (mut a, mut b) = (pair[0], pair[1]);
        if f(a) < 0.0 && f(b) >= 0.0 {
            for _ in 0..60 {
                let middle = 0.5 * (a + b);
                if f(middle) < 0.0 {
                    a = middle
                } else {
                    b = middle
                }
            }
            found.push(b);
        }
    }
    let ends = [0.0, end].map(&f);
    let touches = ends.iter().any(|value| value.abs() < GRAZES * size);
    (!touches).then_some(found)
}

/// A scene with its condition as a function of time: how often it comes true, and when.
struct Counted {
    text: String,
    function: Box<dyn Fn(f64) -> f64>,
    end: f64,
    /// The shortest time in which the function does something.
    moment: f64,
    size: f64,
}

/// How far a threshold is from the greatest value of a wave: anything down to a few roundings above what may be missed.
fn margin(random: &mut Random) -> f64 {
    let sign = if random.number() < 0.5 { 1.0 } else { -1.0 };
    sign * 10_f64.powf(random.within(-6.5, 0.0))
}

fn counted(kind: usize, random: &mut Random) -> Counted {
    let end = 10_f64.powf(random.within(0.0, 2.0));
    let periods = 10_f64.powf(random.within(0.0, 2.0));
    let w = TAU * periods / end;
    match kind {
        // One wave of a wheel that turns.
        0 => {
            let c = 1.0 - margin(random).abs();
            Counted {
                text: format!(
                    "coordinates {{ a: rad }} states {{ n }} lagrangian 1[kg m^2]/2*dot(a)^2
                    when sin(a) >= {c} {{ n = n + 1 }} start {{ dot(a): {w} [rad/s] }} horizon {end} [s]"
                ),
                function: Box::new(move |t| (w * t).sin() - c),
                end,
                moment: 1.0 / w,
                size: 1.0,
            }
        }
        // Two oscillators whose product is asked for.
        1 => {
            let (v, c) = (w * random.within(0.1, 1.0), 1.0 - margin(random));
            Counted {
                text: format!(
                    "coordinates {{ x: m, y: m }} states {{ n }}
                    lagrangian 1[kg]/2*(dot(x)^2 + dot(y)^2) - {}[N/m]/2*x^2 - {}[N/m]/2*y^2
                    when x*y >= {c} [m^2] {{ n = n + 1 }} start {{ x: 1, dot(y): {v} }} horizon {end} [s]",
                    w * w,
                    v * v
                ),
                function: Box::new(move |t| (w * t).cos() * (v * t).sin() - c),
                end,
                moment: 1.0 / (w + v),
                size: 1.0,
            }
        }
        // A polynomial of a swing that is looked at with the time.
        2 => {
            let (drift, c) = (random.within(0.0, 1.0) / end, margin(random));
            Counted {
                text: format!(
                    "coordinates {{ x: m }} states {{ n }} lagrangian 1[kg]/2*dot(x)^2 - {}[N/m]/2*x^2
                    when 4*(x/1[m])^3 - 3*x/1[m] + {drift}*t/1[s] >= {c} + 1 {{ n = n + 1 }}
                    start {{ dot(x): {w} }} horizon {end} [s]",
                    w * w
                ),
                function: Box::new(move |t| {
                    let x = (w * t).sin();
                    4.0 * x.powi(3) - 3.0 * x + drift * t - c - 1.0
                }),
                end,
                moment: 1.0 / (3.0 * w),
                size: 1.0,
            }
        }
        // Three waves of angles that turn freely.
        _ => {
            let (v, u) = (w * random.within(0.1, 1.0), w * random.within(0.1, 1.0));
            let c = 2.4 - 2.0 * margin(random).abs();
            Counted {
                text: format!(
                    "states {{ a: rad, b: rad, c: rad, n }} rates {{ a: {w} [rad/s], b: {v} [rad/s], c: {u} [rad/s] }}
                    when sin(a) + sin(b)*cos(c) + 0.5*cos(a - c) >= {c} {{ n = n + 1 }} horizon {end} [s]"
                ),
                function: Box::new(move |t| {
                    let (a, b, d) = (w * t, v * t, u * t);
                    a.sin() + b.sin() * d.cos() + 0.5 * (a - d).cos() - c
                }),
                end,
                moment: 1.0 / (2.0 * (w + v + u)),
                size: 2.5,
            }
        }
    }
}

/// How many of some random conditions are counted wrongly by a run that says it is solved, and how many are not solved.
fn counts(seed: u64, count: usize) -> (Vec<String>, usize) {
    let mut random = Random(seed);
    let (mut wrong, mut stopped) = (Vec::new(), 0);
    for k in 0..count {
        let Counted {
            text,
            function,
            end,
            moment,
            size,
        } = counted(k % 4, &mut random);
        let event_driven = (k / 4) % 2 == 1;
        let Some(times) = rises(function, end, 0.02 * moment, size) else {
            continue;
        };
        let motion = run(&scene(&text), event_driven);
        if !motion.status.is_solved() {
            stopped += 1;
            continue;
        }
        let n = motion.trajectory.v.last().and_then(|v| v.last()).copied();
        if n != Some(times.len() as f64) {
            let method = if event_driven {
                "event-driven"
            } else {
                "default"
            };
            wrong.push(format!("{n:?} of {} by {method}: {text}", times.len()));
        }
    }
    (wrong, stopped)
}

#[test]
fn conditions_of_random_motions_come_true_as_often_as_their_closed_forms_say() {
    let (wrong, stopped) = counts(0x5eed_0001, 48);
    assert!(wrong.is_empty(), "{}: {}", wrong.len(), wrong.join("\n"));
    assert!(stopped <= 4, "{stopped}");
}

#[test]
#[ignore = "long"]
fn conditions_of_thousands_of_random_motions() {
    let (wrong, stopped) = counts(0x5eed_1001, 4000);
    assert!(wrong.is_empty(), "{}: {}", wrong.len(), wrong.join("\n"));
    assert!(stopped <= 40, "{stopped}");
}

/// How often the first touch of a rod that is thrown up turning is wrong in a run that says it is solved.
fn first_touches(seed: u64, count: usize) -> Vec<String> {
    let mut random = Random(seed);
    let mut wrong = Vec::new();
    for k in 0..count {
        let (l, z, g) = (random.within(0.2, 1.0), random.within(0.6, 1.5), 9.81);
        let (v, w) = (random.within(0.0, 30.0), random.within(5.0, 300.0));
        let phase = random.within(0.0, TAU);
        let end = 10_f64
            .powf(random.within(0.0, 2.0))
            .max((v + (v * v + 2.0 * g * z).sqrt()) / g);
        let text = format!(
            "parameters {{ m: kg = 1, l: m = {l}, g: m/s^2 = {g} }} coordinates {{ z: m, phi: rad }}
            lagrangian m/2*dot(z)^2 + m*l^2/24*dot(phi)^2 - m*g*z
            surface a: z + l/2*sin(phi) >= 0 surface b: z - l/2*sin(phi) >= 0 impact a, b: inelastic
            start {{ z: {z}, phi: {phase}, dot(phi): {w}, dot(z): {v} }} horizon {end} [s]"
        );
        let height = |t: f64| z + v * t - 0.5 * g * t * t - 0.5 * l * (w * t + phase).sin().abs();
        let Some(times) = rises(|t| -height(t), end, 0.02 / w, 1.0) else {
            continue;
        };
        let event_driven = k % 2 == 1;
        let motion = run(&scene(&text), event_driven);
        let touch = motion.events.first().map(|event| event.time);
        let exact = times.first().copied();
        let right = match (touch, exact) {
            (Some(touch), Some(exact)) => (touch - exact).abs() < 1e-8 * exact,
            (touch, exact) => touch.is_none() == exact.is_none(),
        };
        if !right && motion.status.is_solved() {
            wrong.push(format!("{touch:?} for {exact:?}, {event_driven}: {text}"));
        }
    }
    wrong
}

#[test]
fn rods_that_spin_touch_the_floor_first_when_their_closed_forms_say() {
    let wrong = first_touches(0x5eed_0002, 24);
    assert!(wrong.is_empty(), "{}: {}", wrong.len(), wrong.join("\n"));
}

#[test]
#[ignore = "long"]
fn thousands_of_rods_that_spin() {
    let wrong = first_touches(0x5eed_1002, 2000);
    assert!(wrong.is_empty(), "{}: {}", wrong.len(), wrong.join("\n"));
}

/// The angle at which a rod that stands on its end in the air touches: `rises` itself against a known sine.
#[test]
fn rises_of_a_sine_are_where_they_are() {
    let times = rises(|t| (3.0 * t).sin() - 0.5, 10.0, 0.01, 1.0).expect("no touch");
    assert_eq!(times.len(), 5);
    for (k, time) in times.iter().enumerate() {
        assert!((time - (PI / 6.0 + TAU * k as f64) / 3.0).abs() < 1e-14);
    }
    // One that goes 1e-5 below its threshold and one that goes 1e-9.
    let touching = |by: f64| rises(move |t| (3.0 * t).sin() - 1.0 + by, 10.0, 0.01, 1.0);
    assert_eq!(touching(1e-5).map(|times| times.len()), Some(5));
    assert_eq!(touching(1e-9), None);
}
