//! Formulas against the syntax: Lagrangian, forces and gaps of scenes with units, vectors, matrices and every function of the language,
//! and of random ones, have the values of the same formulas in Rust. What is derived of them is compared in `derivation`.

use crate::derivation::run;
use crate::differences::{rates, slopes};
use crate::random_texts::{source, stream};
use hangtime::model::Model;
use hangtime_scene_files::of_text;

/// Random texts.
const RANDOM: u64 = 120;

fn assert_near(text: &str, found: &[f64], wanted: &[f64]) {
    assert_eq!(found.len(), wanted.len(), "{text}");
    for (found, wanted) in found.iter().zip(wanted) {
        // What differences leave of twelve digits.
        let off = 1e-9 * (1.0 + wanted.abs());
        let is_near = (found - wanted).abs() <= off;
        assert!(is_near, "{found} and {wanted} of\n{text}");
    }
}

/// Compares the Lagrangian, the forces and the gaps of a scene at a random input vector.
fn agree(text: &str, wanted: fn(&[f64]) -> Vec<f64>) {
    let model = of_text("scene.hang", text).unwrap_or_else(|error| panic!("{error}"));
    let acting = hangtime_dsl::acting(text, "scene").expect("no mistakes");
    let (declaration, mut random) = (model.declaration(), stream(7));
    let x: Vec<f64> = (0..declaration.inputs())
        .map(|_| random.between(-1.0, 1.0))
        .collect();
    let mut found = run(&acting, |i| model.parameter(i), &x);
    found.extend((0..declaration.contacts.len()).map(|i| model.gap(i, &x)));
    assert_near(text, &found, &wanted(&x));
}

/// The square of a length.
fn square(vector: &[f64]) -> f64 {
    vector.iter().map(|component| component * component).sum()
}

#[test]
fn double_pendulum_in_other_units_has_its_formulas() {
    agree(include_str!("scenes/double-pendulum.hang"), |x| {
        let places = |x: &[f64]| {
            let (a, both, support) = (x[0], x[0] + x[1].to_radians(), 0.05 * (3.0 * x[5]).sin());
            let (y, z) = (0.8 * a.sin(), support - 0.8 * a.cos());
            vec![y, z, y + 0.6 * both.sin(), z - 0.6 * both.cos()]
        };
        let (p, v) = (places(x), rates(2, x, places));
        let kinetic = 1.3 / 2.0 * square(&v[..2]) + 0.7 / 2.0 * square(&v[2..]);
        let torque = x[4] - 0.1 * x[3].to_radians();
        vec![
            kinetic - 9.81 * (1.3 * p[1] + 0.7 * p[3]),
            -0.1 * x[2],
            torque.to_radians(),
            1.1 - p[2],
            p[3] + 1.2 - 0.1 * p[2] * p[2],
        ]
    });
}

#[test]
fn every_function_of_the_language_has_its_values() {
    agree(include_str!("scenes/functions.hang"), |input| {
        let &[x, y, z, x_rate, y_rate, z_rate] = input else {
            panic!("six inputs");
        };
        let f = |s: f64| {
            let root = (1.0 + s * s).sqrt() + (3.0 + s).cbrt();
            root + s.tanh() * (-s / 3.0).exp() + s.atan()
        };
        let slope = |at: f64| slopes(|s| vec![f(at + s)])[0].value;
        let second = slopes(|s| vec![slope(z + s)])[0].value;
        let place = |x: &[f64]| vec![x[0], x[1] + f(x[0]), x[2] * (x[0] / 2.0).cosh()];
        let (p, v) = (place(input), rates(3, input, place));
        let kinetic = square(&v) / 2.0 + 1.5 * z_rate.powi(2) * (2.0 + (x * y).sin());
        let potential = (4.0 + x * x + y).ln()
            + y.atan2(3.0 + x)
            + (4.0 + z).powf(2.3)
            + second * (x / 4.0).tan()
            + (y / 5.0).asin() * (z / 5.0).acos()
            + x.sinh() * (3.0 + y).powf(1.5)
            + square(&p).powf(1.5) / (2.0 + x * x);
        vec![
            kinetic - potential,
            x * x_rate - y * y,
            p[0] + p[1] * y_rate + p[2] * z,
            0.0,
            5.0 + x - y * y + z.sin(),
        ]
    });
}

#[test]
fn top_of_matrices_has_the_energy_of_its_rates() {
    agree(include_str!("scenes/top.hang"), |x| {
        let (sine, cosine) = x[1].sin_cos();
        let (across, along) = (
            square(&[x[4], x[3] * sine]),
            square(&[x[3] * cosine + x[5]]),
        );
        let (kinetic, height) = ((0.05 * across + 0.02 * along) / 2.0, 0.3 * cosine);
        vec![kinetic - 0.4 * 9.81 * height, 0.0, 0.0, x[6], height - 0.03]
    });
}

#[test]
fn box_on_a_turntable_has_the_formulas_of_its_matrices() {
    agree(include_str!("scenes/turntable.hang"), |x| {
        let skewed = |x: &[f64]| [x[1] + 0.2 * x[2], x[2] - 0.1 * x[1]].map(|x| 0.01 * x);
        let place = |x: &[f64]| {
            let ((sine, cosine), [y, z]) = (x[0].to_radians().sin_cos(), skewed(x));
            let off = 0.01 * x[2] * 20_f64.to_radians().sin() / 10.0;
            vec![cosine * y - sine * z - off, sine * y + cosine * z]
        };
        let (p, turns) = (place(x), x[3].to_radians());
        let kinetic = 0.75 * square(&rates(3, x, place)) + 0.15 * turns * turns;
        vec![
            kinetic - 10.0 * square(&skewed(x)),
            0.0,
            0.0,
            0.0,
            0.3 - p[0] - 0.2 * p[1],
        ]
    });
}

#[test]
fn random_formulas_have_their_values() {
    for seed in 0..RANDOM {
        let scene = source(&mut stream(seed));
        let acting = hangtime_dsl::acting(&scene.text, "scene").expect("no mistakes");
        let (n, mut random) = (acting.outputs.len() - 1, stream(7));
        let x: Vec<f64> = (0..=2 * n).map(|_| random.between(-1.0, 1.0)).collect();
        let found = run(&acting, |i| [0.7, 1.3, 2.0][i], &x);
        let mut wanted = vec![(scene.lagrangian)(&x), (scene.force)(&x)];
        wanted.resize(1 + n, 0.0);
        assert_near(&scene.text, &found, &wanted);
    }
}
