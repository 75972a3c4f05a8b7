//! Derivatives of random motions against differences of motions.

use hangtime::derivative::{Gradient, GradientMode};
use hangtime::prelude::*;
use hangtime_scene_files::TextScene;

use super::support::{TOLERANCE, assert_close, scene};
use super::texts::{BELT, HILLS, HUMP, LINKS, NET};
use crate::random::Random;

/// Step of a parameter, relative to it.
const STEP: f64 = 2e-4;
/// What differences of fourth order leave, relative to 1 or to the largest derivative.
const CLOSE: f64 = 1e-6;

/// Kinds of scenes: each a text, the range of each of its parameters, and which of them are asked for.
struct Kind {
    text: &'static str,
    ranges: &'static [(&'static str, f64, f64)],
}

const KINDS: [Kind; 7] = [
    // A ball on hills with friction.
    Kind {
        text: HILLS,
        ranges: &[
            ("a", 0.05, 0.3),
            ("w", 1.0, 3.0),
            ("e", 0.3, 0.9),
            ("mu", 0.05, 0.4),
            ("u0", 0.5, 3.0),
            ("height", 0.6, 1.5),
        ],
    },
    // Two links that strike a wall.
    Kind {
        text: LINKS,
        ranges: &[
            ("m", 0.5, 2.0),
            ("l", 0.5, 1.2),
            ("e", 0.2, 0.9),
            ("a0", 0.4, 1.3),
            ("b0", 0.2, 1.0),
            ("wall", -0.3, 0.1),
        ],
    },
    // A block on a belt, held by a spring: it sticks, slips and sticks again.
    Kind {
        text: BELT,
        ranges: &[
            ("m", 0.7, 2.0),
            ("k", 15.0, 40.0),
            ("mu", 0.1, 0.4),
            ("belt", 0.1, 0.6),
            ("x0", -0.3, 0.3),
        ],
    },
    // A body that slides over a hump, leaves it and lands.
    Kind {
        text: HUMP,
        ranges: &[
            ("a", 0.3, 0.7),
            ("s", 0.7, 1.2),
            ("u0", 4.0, 6.0),
            ("c", 0.0, 0.4),
            ("g", 8.0, 11.0),
        ],
    },
    // A ball between a floor and a net that throws it back. It arrives at more than 1 m/s: near a graze differences of this step are off.
    Kind {
        text: NET,
        ranges: &[
            ("v0", 3.2, 5.0),
            ("top", 0.2, 0.45),
            ("share", 0.3, 0.9),
            ("e", 0.4, 0.9),
            ("c", 0.0, 0.4),
        ],
    },
    // A ball that is struck at the start.
    Kind {
        text: "
            parameters { g: m/s^2 = 9.81, e = 0.5, mu = 0.2, w0: m/s = 1, u0: m/s = 2 }
            coordinates { x: m, z: m }
            lagrangian 1[kg]*((dot(x)^2 + dot(z)^2)/2 - g*z)
            surface floor: z >= 0
            impact floor: restitution e, friction mu, sliding dot(x)
            start { dot(x): u0, dot(z): -w0 }
            horizon 0.4 [s]
        ",
        ranges: &[
            ("e", 0.3, 0.9),
            ("mu", 0.1, 0.9),
            ("w0", 0.8, 1.5),
            ("u0", 1.0, 3.0),
        ],
    },
    // A rod, as a joint, that strikes a wall and rubs on it.
    Kind {
        text: "
            parameters { g: m/s^2 = 9.7, l: m = 0.8, a0: rad = 1.1, w0: rad/s = 0.3, e = 0.6, mu = 0.1, wall: m = -0.2 }
            coordinates { x: m, z: m }
            lagrangian 1.2[kg]*((dot(x)^2 + dot(z)^2)/2 - g*z)
            joint rod: x^2 + z^2 == l^2
            surface stop: x - wall >= 0
            impact stop: restitution e, friction mu, sliding dot(z)
            start { x: l*sin(a0), z: -l*cos(a0), dot(x): l*cos(a0)*w0, dot(z): l*sin(a0)*w0 }
            horizon 1.4 [s]
        ",
        ranges: &[
            ("l", 0.6, 1.0),
            ("a0", 0.8, 1.3),
            ("e", 0.3, 0.8),
            ("mu", 0.05, 0.2),
            ("wall", -0.3, 0.1),
        ],
    },
];

/// What happens at which contacts.
type Kinds = Vec<(EventKind, usize)>;

/// The end of a motion with the times of its events, and their kinds and contacts.
fn end(scene: &TextScene) -> Option<(Vec<f64>, Kinds)> {
    let run = simulate(scene)
        .method(EventDriven::default())
        .tolerance(TOLERANCE)
        .run()
        .ok()?;
    if !run.status.is_solved() {
        return None;
    }
    let last = run.trajectory.time.len() - 1;
    let events = run.events.iter();
    let kinds = events.map(|event| (event.kind, event.contact)).collect();
    let mut values = [&run.trajectory.q[last][..], &run.trajectory.v[last]].concat();
    values.extend(run.events.iter().map(|event| event.time));
    Some((values, kinds))
}

/// Differences of fourth order of the end and of the event times by a parameter, over steps of this share of it; none where the
/// sequence of events differs.
fn differences(scene: &TextScene, parameter: usize, step: f64) -> Option<Vec<f64>> {
    let value = scene.parameter(parameter);
    let step = step * value.abs().max(0.1);
    let at = |steps: f64| {
        let mut scene = scene.clone();
        scene.set_parameter(parameter, value + steps * step);
        end(&scene)
    };
    let ends = [at(-2.0)?, at(-1.0)?, at(1.0)?, at(2.0)?];
    if ends.iter().any(|(_, kinds)| *kinds != ends[0].1) {
        return None;
    }
    let rows = 0..ends[0].0.len();
    let difference = |i: usize| {
        let f = |k: usize| ends[k].0[i];
        (f(0) - 8.0 * f(1) + 8.0 * f(2) - f(3)) / (12.0 * step)
    };
    Some(rows.map(difference).collect())
}

/// Whether derivatives of what a scene records and of its last event were carried backwards, which are to be the same; those of a motion with fewer
/// digits have to be as near as they say.
#[track_caller]
fn same(scene: &TextScene, names: &[&str], [fine, coarse]: [&Gradient; 2], events: usize) -> bool {
    let outputs = scene.outputs().iter().map(|output| output.name.to_owned());
    let mut of: Vec<String> = outputs.collect();
    of.extend((events > 0).then(|| format!("event_times[{}]", events - 1)));
    let by = |mode| {
        let run = simulate(scene).tolerance(TOLERANCE).gradient_mode(mode);
        let run = run.gradient_of(of.iter().map(String::as_str));
        run.gradient(names.iter().copied()).unwrap().1
    };
    let (forward, backward) = (by(GradientMode::Forward), by(GradientMode::Adjoint));
    for ((of, forward), (_, backward)) in forward.values.iter().zip(&backward.values) {
        let largest = forward.iter().fold(0.0_f64, |most, by| most.max(by.abs()));
        for (forward, backward) in forward.iter().zip(backward) {
            // The same sums in another order.
            assert_close(forward / largest, backward / largest, 1e-12, of);
        }
    }
    let error = coarse.error_estimate.expect("it is known");
    let sizes: Vec<f64> = (names.iter())
        .map(|name| scene.parameter(super::support::parameter(scene, name)))
        .collect();
    for (fine, coarse) in fine
        .q
        .iter()
        .chain(&fine.v)
        .zip(coarse.q.iter().chain(&coarse.v))
    {
        let terms = |of: &[f64]| -> Vec<f64> {
            of.iter().zip(&sizes).map(|(by, size)| by * size).collect()
        };
        let (fine, coarse) = (terms(fine), terms(coarse));
        let size: f64 = fine.iter().map(|term| term.abs()).sum();
        for (fine, coarse) in fine.iter().zip(&coarse) {
            let off = (fine - coarse).abs();
            assert!(
                off <= 10.0 * error * size + 1e-12,
                "{off:e} of {size:e}, and not {error:e}"
            );
        }
    }
    of.is_empty() || backward.mode == GradientMode::Adjoint && backward.ranges.is_empty()
}

#[test]
fn random_motions_have_the_derivatives_that_differences_show() {
    let scenes = std::env::var("HANGTIME_GRADIENTS").ok();
    let scenes: usize = scenes.and_then(|count| count.parse().ok()).unwrap_or(40);
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut compared, mut existing, mut refined, mut backwards) = (0, 0, 0, 0);
    for number in 0..scenes {
        let kind = &KINDS[number % KINDS.len()];
        let settings: Vec<(&str, f64)> = kind
            .ranges
            .iter()
            .map(|&(name, low, high)| (name, random.within(low, high)))
            .collect();
        let scene = scene(kind.text, &settings);
        let names: Vec<&str> = settings.iter().map(|(name, _)| *name).collect();
        for event_driven in [false, true] {
            let run = simulate(&scene).tolerance(TOLERANCE);
            let run = if event_driven {
                run.method(EventDriven::default()).tolerance(TOLERANCE)
            } else {
                run
            };
            let (run, gradient) = run.gradient(names.iter().copied()).unwrap();
            if gradient.obstacle.is_some() {
                println!("{number} {settings:?}: {:?}", gradient.obstacle);
                continue;
            }
            existing += 1;
            if !event_driven {
                let coarse = simulate(&scene).gradient(names.iter().copied());
                let both = [&gradient, &coarse.unwrap().1];
                backwards += usize::from(same(&scene, &names, both, run.events.len()));
            }
            for (k, name) in names.iter().enumerate() {
                let parameter = super::support::parameter(&scene, name);
                let Some(mut right) = differences(&scene, parameter, STEP) else {
                    continue;
                };
                let column: Vec<f64> = (gradient
                    .q
                    .iter()
                    .chain(&gradient.v)
                    .chain(&gradient.event_times))
                .map(|row| row[k])
                .collect();
                if column.len() != right.len() {
                    continue;
                }
                compared += 1;
                let largest = right
                    .iter()
                    .fold(1.0_f64, |most, value| most.max(value.abs()));
                let mut pairs = column.iter().zip(&right);
                if pairs.any(|(found, right)| (found - right).abs() > CLOSE * largest) {
                    // Near a graze or a lift-off differences converge late; to the derivative all the same.
                    right = differences(&scene, parameter, 0.25 * STEP).unwrap_or(right);
                    refined += 1;
                }
                for (i, (found, right)) in column.iter().zip(&right).enumerate() {
                    let what = format!("scene {number} {settings:?}, row {i} by {name}\n{run}");
                    assert_close(found / largest, right / largest, CLOSE, &what);
                }
            }
        }
    }
    println!(
        "{scenes} scenes, {existing} motions with derivatives, {compared} compared, {refined} by shorter steps"
    );
    assert!(
        existing >= 2 * scenes * 8 / 10,
        "{existing} of {}",
        2 * scenes
    );
    assert!(backwards >= scenes * 7 / 10, "{backwards} backwards");
    assert!(
        compared >= 3 * scenes,
        "{compared} compared of {scenes} scenes"
    );
}

/// A row of masses that depend on each other's places, held by springs, whose first strikes a wall and rubs on it.
fn row(count: usize) -> String {
    let all = |term: &dyn Fn(usize) -> String| -> String {
        let terms: Vec<String> = (1..=count).map(term).collect();
        terms.join(" + ")
    };
    let coordinates: Vec<String> = (1..=count).map(|i| format!("q{i}: m")).collect();
    let next = |i: usize| i % count + 1;
    let kinetic = all(&|i| {
        format!(
            "m/2*(1 + b/10*sin(q{0}/1[m]))*dot(q{i})^2 + m*b/20*dot(q{i})*dot(q{0})",
            next(i)
        )
    });
    let springs = all(&|i| format!("k/2*(q{i} - q{})^2 + k/20*q{i}^2", next(i)));
    format!(
        "parameters {{ m: kg = 1, k: N/m = 5, b = 0.6, e = 0.5, mu = 0.2, v0: m/s = 1.3 }}
         coordinates {{ {} }}
         lagrangian {kinetic} - ({springs})
         surface wall: 0.2[m] + q1 + b/5*sin(q2/1[m])*1[m] >= 0
         impact wall: restitution e, friction mu, sliding dot(q2) + b*dot(q3)
         start {{ q1: 0.1[m], q2: 0.05[m]*b, dot(q1): -v0, dot(q3): v0/2 }}
         horizon 1 [s]",
        coordinates.join(", ")
    )
}

#[test]
fn motions_of_many_coordinates_have_the_derivatives_that_differences_show() {
    // Accelerations are simplified formulas up to four coordinates, eliminations up to eight, and loops above.
    for count in [4, 6, 9] {
        let scene = scene(&row(count), &[]);
        let names = ["m", "k", "b", "e", "mu", "v0"];
        let run = simulate(&scene).tolerance(TOLERANCE);
        let (run, gradient) = run.gradient(names).unwrap();
        assert_eq!(gradient.obstacle, None, "{run}");
        assert!(!run.events.is_empty());
        for (k, name) in names.iter().enumerate() {
            let parameter = super::support::parameter(&scene, name);
            let right = differences(&scene, parameter, STEP).unwrap();
            let column = gradient
                .q
                .iter()
                .chain(&gradient.v)
                .chain(&gradient.event_times);
            for (i, (found, right)) in column.map(|row| row[k]).zip(&right).enumerate() {
                assert_close(
                    found,
                    *right,
                    CLOSE,
                    &format!("{count} coordinates, row {i} by {name}"),
                );
            }
        }
    }
}

/// Two bodies that fall side by side and land at once, one of them on a rough floor, with a spring between them.
const SIDE_BY_SIDE: &str = "
    parameters { m: kg = 2, k: N/m = 9, e1 = 0.8, e2 = 0.5, mu = 0.1, h: m = 1, u: m/s = 1, apart: m = 0, later: m = 0 }
    coordinates { x: m, a: m, b: m }
    lagrangian 1[kg]/2*(dot(x)^2 + dot(a)^2) + m/2*dot(b)^2 - 9.81[m/s^2]*(1[kg]*a + m*b) - k/2*(a - b)^2
    surface rough: a >= 0
    surface smooth: b - later >= 0
    impact rough: restitution e1, friction mu, sliding dot(x)
    impact smooth: restitution e2
    start { a: h, b: h + apart, dot(x): u }
    horizon 0.7 [s]
";

#[test]
fn random_landings_at_once_have_the_derivatives_that_differences_to_both_sides_show() {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let ranges = [
        ("m", 0.5, 3.0),
        ("k", 2.0, 30.0),
        ("e1", 0.5, 0.9),
        ("e2", 0.5, 0.9),
        ("mu", 0.02, 0.1),
        ("h", 0.7, 1.2),
        ("u", 2.0, 3.0),
    ];
    let mut compared = 0;
    for number in 0..10 {
        let drawn = ranges.map(|(name, low, high)| (name, random.within(low, high)));
        let known = scene(SIDE_BY_SIDE, &drawn);
        let names = ["h", "apart", "later", "e1", "m"];
        for (run, gradient) in super::support::by_both(&known, &names) {
            assert_eq!(gradient.obstacle, None, "{number} {drawn:?}\n{run}");
            let (middle, _) = end(&known).unwrap();
            for (k, name) in names.iter().enumerate() {
                let column: Vec<f64> = gradient.q.iter().map(|row| row[k]).collect();
                for sense in [-1.0, 1.0] {
                    // The error of second order to one side is about a thousandth of the square of the step over the scale of a bounce.
                    let step = sense * 2e-5;
                    let at = |steps: f64| {
                        let mut beside = known.clone();
                        let parameter = super::support::parameter(&known, name);
                        beside.set_parameter(parameter, known.parameter(parameter) + steps * step);
                        end(&beside).unwrap().0
                    };
                    let (one, two) = (at(1.0), at(2.0));
                    for (i, found) in column.iter().enumerate() {
                        let right = (4.0 * one[i] - two[i] - 3.0 * middle[i]) / (2.0 * step);
                        compared += 1;
                        assert_close(*found, right, 1e-6, &format!("{number} row {i} by {name}"));
                    }
                }
            }
        }
    }
    assert_eq!(compared, 10 * 2 * 5 * 2 * 3);
}
