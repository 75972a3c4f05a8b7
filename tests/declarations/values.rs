//! Values of declared functions against their formulas, written in Rust.

use hangtime::model::{Function, Model, Shape, contact_point};
use hangtime::scene::TextScene;

/// A scene of this folder.
macro_rules! scene {
    ($name:literal) => {
        read(include_str!(concat!("scenes/", $name, ".hang")))
    };
}

fn read(text: &str) -> TextScene {
    hangtime_scene_files::of_text("scene.hang", text).unwrap_or_else(|error| panic!("{error}"))
}

/// Compares numbers up to a handful of roundings of the largest.
fn assert_close(found: &[f64], wanted: &[f64]) {
    assert_eq!(found.len(), wanted.len());
    let size = wanted
        .iter()
        .fold(1.0, |size: f64, value| size.max(value.abs()));
    for (place, (a, b)) in found.iter().zip(wanted).enumerate() {
        assert!(
            (a - b).abs() <= 1e-14 * size,
            "value {place}: {a} against {b}"
        );
    }
}

/// Coordinates, velocities, control and time of the scene `shown`.
const AT: [f64; 8] = [0.7, 0.4, 50.0, 1.5, -0.3, 20.0, 1.2, 2.5];

#[test]
fn outputs_are_their_formulas_in_their_units() {
    let wheel = scene!("shown");
    let units: Vec<_> = wheel.outputs().iter().map(|o| (o.name, o.unit)).collect();
    let wanted = [
        ("speed", "km/h"),
        ("power", "W"),
        ("weight", "N"),
        ("push", "kN"),
        ("lost", "W"),
        ("elapsed", "min"),
        ("limit", "N"),
        ("far", "cm"),
        ("hit", "kN s"),
    ];
    assert_eq!(units, wanted);
    assert_eq!(wheel.outputs()[0].documentation, "How fast its centre is.");
    let mut values = [f64::NAN; 9];
    // Normal forces of both contacts, their friction forces, and the same of impulses.
    let contacts = [300.0, 50.0, -7.0, 0.0, 400.0, 20.0, -60.0, 0.0];
    wheel.output_values(&AT, &contacts, &mut values);
    let power = 1.2 * 20.0_f64.to_radians();
    let speed = 3.6 * 1.5_f64.hypot(-0.3);
    let (weight, lost, elapsed) = (2.0 * 9.81, 7.0 * 1.5, 2.5 / 60.0);
    let wanted = [speed, power, weight, 0.4, lost, elapsed, 3.0, 50.0, 0.5];
    assert_close(&values, &wanted);
    // By name in a constraint, in the unit of that.
    let mut path = [f64::NAN; 2];
    wheel.values(Function::Path, &AT[..7], &mut path);
    assert_close(&path, &[power * power, 5.0 - power]);
}

#[test]
fn picture_is_its_formulas_in_the_unit_of_the_coordinates() {
    let wheel = scene!("shown");
    let picture = wheel.picture().expect("declared");
    let said = (picture.unit, picture.axes, picture.ground);
    assert_eq!(said, ("m", ("y", "z"), None));
    let shapes = [
        Shape::Circle("wheel"),
        Shape::Rectangle("board"),
        Shape::Polygon("flag", 3),
        Shape::Point("hub"),
        Shape::Spring,
        Shape::Link,
        Shape::Curve("hill"),
        Shape::Arc("arc"),
    ];
    assert_eq!(picture.shapes, shapes);
    let mut values = vec![f64::NAN; picture.values()];
    wheel.picture_values(&AT, 0.9, &mut values);
    let (y, z, a, r) = (0.7, 0.4, 50.0_f64.to_radians(), 0.3);
    let (board, (sine, cosine)) = (y + 1.5_f64.hypot(-0.3), 0.9_f64.sin_cos());
    let arc = [0.2, std::f64::consts::PI, r * cosine, 2.0 + r * sine];
    let wanted = [
        &[y, z, a, r][..],
        &[board, z, 0.0, r, 2.0 * r],
        &[0.0, 2.5, -a, 0.0, 0.0, r, 0.0, 0.0, r],
        &[y, z, 0.0],
        &[0.0, 0.0, y, z],
        &[y, z, board, z],
        &[0.9, -0.2 * 0.9],
        &arc,
    ];
    assert_close(&values, &wanted.concat());
}

#[test]
fn functions_of_forces_are_those_of_accelerations_over_inverse_inertias() {
    let rod = scene!("forces");
    // (y, z, a, s, their velocities, u, t), then r and s of hill, wall and rail.
    let x = [
        0.3, -0.7, 0.9, 0.2, -0.4, 0.8, 0.5, -0.6, 0.7, 0.35, 0.6, -0.8, 0.45, 0.9, -0.25, 0.75,
    ];
    let sizes = (rod.declaration().inputs(), rod.declaration().path_inputs());
    assert_eq!(sizes, (10, 16));
    let over = |first: usize| {
        [0, 1, 2].map(|contact| {
            let mut point = [f64::NAN; contact_point::length(4)];
            rod.contact(contact, &x[..10], &mut point);
            x[first + contact] / point[contact_point::INVERSE_INERTIA]
        })
    };
    let (force, rub) = (over(10), over(13));
    let (y, a, u, t) = (x[0], x[2].to_radians(), x[8], x[9]);
    let push = force[0] - 2.0 * force[1];
    let cost = push * push * (1.0 + a.sin()) + rub[2] * rub[0] * t.cos();
    let [mut path, mut impact, mut terminal] = [vec![0.0; 2], vec![0.0; 3], vec![0.0; 4]];
    rod.values(Function::Path, &x, &mut path);
    assert_close(&path, &[cost, u - push]);

    let summed = force[0].powi(2) * y * (t / 9.0).exp();
    let limit = 3.0 - force[1] - rub[0] * (y / 0.2).sin();
    rod.values(Function::Impact, &x, &mut impact);
    assert_close(&impact, &[summed, force[1], limit]);

    // (q, v, T), two sums, r and s; the ground is where it is at the final time.
    let z = [&x[..8], &[t, 0.3, 0.4], &x[10..]].concat();
    assert_eq!(z.len(), rod.declaration().terminal_inputs());
    let cost = 0.3 + force[1] * force[0] * t;
    rod.values(Function::Terminal, &z, &mut terminal);
    assert_close(&terminal, &[cost, 3.0 - rub[0] - y, 9.0 - 0.3, 0.4 - 1.0]);
}

#[test]
fn functions_of_optimal_control_are_their_formulas_in_si_units() {
    let cart = scene!("cart");
    // (y, theta, z), their velocities, u, torque, t.
    let x: [f64; 9] = [0.4, -20.0, 35.0, 0.6, 15.0, -40.0, 3.0, 0.2, 0.9];
    let (y, z, l, haste, h) = (x[0], 0.01 * x[2], 0.6, 3.0, 1.5);
    let (sine, cosine) = x[1].to_radians().sin_cos();
    let turns = x[4].to_radians();
    let tip = [y + l * sine, z - l * cosine];
    let tip_rate = [x[3] + l * cosine * turns, 0.01 * x[5] + l * sine * turns];
    let (wave, t) = (2.0 * x[8], x[8]);
    let effort = 0.1 * x[6] * x[6] + wave.sin() * turns * turns;
    let mut path = [f64::NAN; 4];
    cart.values(Function::Path, &x, &mut path);
    let ceiling = h - z - 0.1 * tip[0];
    let moving = tip[1] - h * wave.cos();
    let wanted = [
        2.0 * effort * haste - y * z,
        ceiling,
        x[6] * x[3] + 5.0,
        moving,
    ];
    assert_close(&path, &wanted);

    let mut terminal = [f64::NAN; 5];
    cart.values(Function::Terminal, &[&x[..6], &[t]].concat(), &mut terminal);
    let miss = (tip[0] - 2.0) / h;
    let slow = 1.0 - tip_rate[0].powi(2) - tip_rate[1].powi(2);
    let turned = x[1].to_radians() - wave;
    let wanted = [haste * t + miss * miss, y - 2.0, slow, z - 0.1 * t, turned];
    assert_close(&terminal, &wanted);

    // The unit behind the upper bound is meant for both.
    let (mut lower, mut upper) = ([f64::NAN; 5], [f64::NAN; 5]);
    cart.bounds(&mut lower, &mut upper);
    let bounds = [lower[1].to_radians(), upper[1].to_radians(), upper[3]];
    assert_close(&bounds, &[-0.5, -0.1, 10.0]);
    let (mut lower, mut upper) = ([f64::NAN; 3], [f64::NAN; 3]);
    cart.free_start_bounds(&mut lower, &mut upper);
    assert_eq!(lower, [f64::NEG_INFINITY, 30.0, 0.0]);
    assert_eq!(upper, [f64::INFINITY, 50.0, 3.0]);
}
