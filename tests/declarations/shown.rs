//! What is recorded and drawn of a motion, against the formulas written in Rust.

use hangtime::model::{Model, Shape};

hangtime::model! {
    /// A wheel on a slope, with a spring and a motor.
    pub Wheel {
        parameters { m: kg = 2, r: cm = 30, g: m/s^2 = 9.81, k: N/m = 5, slope = 0.2 }
        coordinates { y: m, z: m, a: deg }
        controls { u: N m in -3..=3 }
        let p = (y, z)
        lagrangian m/2*|dot(p)|^2 + m*r^2/4*dot(a)^2 - m*g*z - k/2*y^2
        forces { a: u }
        surface ground: z + slope*y >= r
        surface wall: y <= 4 [m]
        impact ground: inelastic, friction 0.3, sliding dot(y - slope*z + r*a)
        impact wall: restitution 0.5
        outputs {
            /// How fast its centre is.
            speed: km/h = |dot(p)|,
            power: W = u*dot(a),
            weight = m*g,
            push: kN = force(ground) + 2*force(wall),
            lost: W = -friction_force(ground)*dot(y),
            elapsed: min = t,
            limit: N = 3,
            far: cm = max(|y| - z/2, min(y, z, r), 3 [cm]),
            hit: kN s = impulse(ground) + 2*impulse(wall) - friction_impulse(ground),
        }
        constraint slow: power <= 5 [W]
        minimize integral(power^2)/1 [W^2] + time
        finally { y == 1 [m], dot(a) <= 2 [deg/s] }
        picture {
            circle wheel at p radius min(r, 1 [m]) angle a,
            rectangle board at (y + speed*1[s], z) size (r, 2*r),
            polygon flag at (0, t*1[m/s]) corners ((0, 0), (r, 0), (0, r)) angle -a,
            point hub at p,
            spring (0, 0) to hub,
            link wheel to board,
            curve hill: (w, -slope*max(w, -w - 1 [cm])) over w,
            curve arc: (r*cos(s), m*1[m/kg] + r*sin(s)) over s in slope..=pi,
        }
        start { z: 0.5 }
    }
}

hangtime::model! {
    /// The same task with its outputs written out.
    pub WrittenOut {
        parameters { m: kg = 2, r: cm = 30, g: m/s^2 = 9.81, k: N/m = 5, slope = 0.2 }
        coordinates { y: m, z: m, a: deg }
        controls { u: N m in -3..=3 }
        let p = (y, z)
        lagrangian m/2*|dot(p)|^2 + m*r^2/4*dot(a)^2 - m*g*z - k/2*y^2
        forces { a: u }
        surface ground: z + slope*y >= r
        surface wall: y <= 4 [m]
        impact ground: inelastic, friction 0.3, sliding dot(y - slope*z + r*a)
        impact wall: restitution 0.5
        constraint slow: u*dot(a) <= 5 [W]
        minimize integral((u*dot(a))^2)/1 [W^2] + time
        finally { y == 1 [m], dot(a) <= 2 [deg/s] }
        start { z: 0.5 }
    }
}

/// Coordinates, velocities, control and time.
const AT: [f64; 8] = [0.7, 0.4, 50.0, 1.5, -0.3, 20.0, 1.2, 2.5];

fn assert_close(found: &[f64], wanted: &[f64]) {
    assert_eq!(found.len(), wanted.len());
    for (place, (a, b)) in found.iter().zip(wanted).enumerate() {
        // A handful of roundings.
        let close = (a - b).abs() <= 1e-14 * (1.0 + b.abs());
        assert!(close, "value {place}: {a} against {b}");
    }
}

#[test]
fn outputs_are_their_formulas_in_their_units() {
    let wheel = Wheel::default();
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
    assert_close(
        &values,
        &[
            speed,
            power,
            2.0 * 9.81,
            0.4,
            7.0 * 1.5,
            2.5 / 60.0,
            3.0,
            50.0,
            0.5,
        ],
    );
}

#[test]
fn outputs_used_by_name_are_what_they_stand_for() {
    let (wheel, other) = (Wheel::default(), WrittenOut::default());
    let (declared, written) = (wheel.declaration(), other.declaration());
    // Neither is a function of time: what is recorded at a time changes no dynamics.
    assert!(!declared.explicit_time);
    let inputs = declared.inputs();
    assert_eq!(inputs, written.inputs());
    let tasks = [declared, written].map(|declared| format!("{:?}", declared.optimal_control));
    assert_eq!(tasks[0], tasks[1]);
    let task = declared.optimal_control.unwrap();
    let values = |model: &dyn Model| {
        let mut values = vec![0.0; task.path_functions() + task.path_jacobian.entries.len()];
        let (functions, jacobian) = values.split_at_mut(task.path_functions());
        model.path_functions(&AT[..inputs], functions);
        model.path_jacobian(&AT[..inputs], jacobian);
        values
    };
    assert_close(&values(&wheel), &values(&other));
}

#[test]
fn picture_is_its_formulas_in_the_unit_of_the_coordinates() {
    let wheel = Wheel::default();
    let picture = wheel.picture().unwrap();
    assert_eq!(
        (picture.unit, picture.axes, picture.ground),
        ("m", ("y", "z"), None)
    );
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
    let board = y + 1.5_f64.hypot(-0.3);
    let wanted = [
        &[y, z, a, r][..],
        &[board, z, 0.0, r, 2.0 * r],
        &[0.0, 2.5, -a, 0.0, 0.0, r, 0.0, 0.0, r],
        &[y, z, 0.0],
        &[0.0, 0.0, y, z],
        &[y, z, board, z],
        &[0.9, -0.2 * 0.9],
        &[
            0.2,
            std::f64::consts::PI,
            r * 0.9_f64.cos(),
            2.0 + r * 0.9_f64.sin(),
        ],
    ];
    assert_close(&values, &wanted.concat());
}

#[test]
fn scene_that_declares_neither_outputs_nor_a_picture_has_no_kernel_for_them() {
    let kernels = |model: &dyn Model| -> Vec<&str> {
        let kernels = model.declaration().kernels.iter();
        kernels.map(|kernel| kernel.name).collect()
    };
    let (with, without) = (Wheel::default(), WrittenOut::default());
    let mut all = kernels(&without);
    assert!(!all.contains(&"outputs") && !all.contains(&"picture"));
    all.extend(["outputs", "picture"]);
    assert_eq!(kernels(&with), all);
    assert!(without.outputs().is_empty() && without.picture().is_none());
}
