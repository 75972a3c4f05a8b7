//! Joints of compiled scenes: the same as those of their texts, and their functions against each other.

use crate::same::assert_all_same;
use hangtime::model::Model;

hangtime::model! {
    /// A pendulum as a point on a rod, which strikes a rough wall.
    pub Rod {
        parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5, mu = 0.3 }
        coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        /// The rod.
        joint rod: x^2 + z^2 == l^2
        surface wall: x >= 0
        impact wall: restitution 0.5, friction mu
        outputs { tension: N = -2*l*force(rod) }
        start { x: 1.2, z: -0.9 }
        horizon 1 [s]
    }
}

hangtime::model! {
    /// A sledge and a wheel whose axle stands still along the blade: more equations than are written out.
    pub Wheel {
        parameters { m: kg = 1, j: kg*m^2 = 0.5, a: m = 0.3, r: m = 0.2 }
        coordinates { x: m, y: m, phi: rad, turn: rad, u: m, v: m }
        lagrangian m/2*(dot(x)^2 + dot(y)^2 + dot(u)^2 + dot(v)^2) + j/2*(dot(phi)^2 + dot(turn)^2)
        joint blade: cos(phi)*dot(y) == sin(phi)*dot(x)
        joint roll: cos(phi)*dot(x) + sin(phi)*dot(y) == r*dot(turn)
        joint axle: (u, v) == (x + a*cos(phi), y + a*sin(phi))
        surface wall: u + v <= 3 [m]
        impact wall: inelastic
        outputs { grip: N = force(roll), pull: N = force(axle).y }
        start { dot(x): 1 [m/s], dot(phi): 2 [1/s] }
        horizon 1 [s]
    }
}

const SOURCE: &str = include_str!("joints.rs");

#[test]
fn compiled_joints_are_those_of_the_text() {
    let compared = assert_all_same(SOURCE, &[&Rod::default(), &Wheel::default()]);
    assert_eq!(compared, 2);
}

#[test]
fn accelerations_and_directions_fulfil_the_rates_of_joints() {
    for model in [&Rod::default() as &dyn Model, &Wheel::default()] {
        let declaration = model.declaration();
        let joints = declaration.joints.expect("joints");
        let (n, rows) = (declaration.coordinates.len(), joints.rows());
        let x: Vec<f64> = (0..2 * n).map(|i| (1.3 + i as f64).sin()).collect();
        let mut acceleration = vec![0.0; n];
        model.free_acceleration(&x, &mut acceleration);
        let values = |x: &[f64]| {
            let mut values = vec![0.0; 2 * rows];
            model.joints(x, &mut values);
            values
        };
        let moved = |time: f64| {
            let step = |i: usize| match i < n {
                true => x[i] + time * (x[n + i] + time / 2.0 * acceleration[i]),
                false => x[i] + time * acceleration[i - n],
            };
            values(&(0..2 * n).map(step).collect::<Vec<f64>>())
        };
        // Rates stay what they are along the motion, to second order of the central difference.
        let (before, after) = (moved(-1e-5), moved(1e-5));
        for row in rows..2 * rows {
            let rate = (after[row] - before[row]) / 2e-5;
            assert!(
                rate.abs() < 1e-8,
                "{}, row {row}: {rate:e}",
                declaration.name
            );
        }
        // What a contact pushes changes no rate.
        let mut point = vec![0.0; hangtime::model::contact_point::length(n)];
        model.contact(0, &x, &mut point);
        let mut pushed = x.clone();
        let direction = &point[hangtime::model::contact_point::direction(n)..];
        pushed[n..]
            .iter_mut()
            .zip(direction)
            .for_each(|(v, d)| *v += d);
        let (before, after) = (values(&x), values(&pushed));
        for row in rows..2 * rows {
            assert!((after[row] - before[row]).abs() < 1e-13, "row {row}");
        }
    }
}

#[test]
fn second_derivatives_of_joints_are_differences_of_the_first() {
    for model in [&Rod::default() as &dyn Model, &Wheel::default()] {
        let declaration = model.declaration();
        let joints = declaration.joints.expect("joints");
        let (inputs, outputs) = (declaration.inputs(), 2 * joints.rows());
        let x: Vec<f64> = (0..inputs).map(|i| (0.7 + i as f64).sin()).collect();
        let weights: Vec<f64> = (0..outputs).map(|k| (1.0 + k as f64).cos()).collect();
        // The gradient of the weighted sum.
        let gradient = |x: &[f64]| {
            let mut values = vec![0.0; joints.jacobian.entries.len()];
            model.joints_jacobian(x, &mut values);
            let mut gradient = vec![0.0; inputs];
            for (&(row, column), value) in joints.jacobian.entries.iter().zip(values) {
                gradient[column as usize] += weights[row as usize] * value;
            }
            gradient
        };
        let mut hessian = vec![0.0; inputs * inputs];
        let mut values = vec![0.0; joints.hessian.entries.len()];
        model.joints_hessian(&x, &weights, &mut values);
        for (&(i, j), value) in joints.hessian.entries.iter().zip(values) {
            hessian[i as usize * inputs + j as usize] = value;
        }
        for j in 0..inputs {
            let moved = |step: f64| {
                let mut x = x.clone();
                x[j] += step;
                gradient(&x)
            };
            let (before, after) = (moved(-1e-5), moved(1e-5));
            for i in j..inputs {
                // A central difference of numbers of the order of one.
                let slope = (after[i] - before[i]) / 2e-5;
                let off = (slope - hessian[i * inputs + j]).abs();
                assert!(off < 1e-8, "{}, {i}, {j}: {off:e}", declaration.name);
            }
        }
    }
}

#[test]
fn scenes_without_joints_carry_nothing_of_them() {
    let rod = Rod::default();
    let text = rod.text().expect("a text");
    let place = |word: &str| text.find(word).expect(word);
    let text = [
        &text[..place("joint")],
        &text[place("surface")..place("outputs")],
        &text[place("start")..],
    ]
    .concat();
    let free = hangtime_scene_files::of_text("rod.hang", &text).expect("a scene");
    assert!(free.declaration().joints.is_none());
    let kernels = free.declaration().kernels.iter();
    assert!(kernels.clone().all(|kernel| !kernel.name.contains("joint")));
    let acceleration = kernels
        .clone()
        .find(|kernel| kernel.name == "free_acceleration");
    assert_eq!(acceleration.map(|kernel| kernel.operations), Some(1));
}
