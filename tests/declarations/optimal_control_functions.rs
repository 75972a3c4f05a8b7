//! Costs, constraints, terminal conditions and free initial values that `model!` derives, against dual
//! numbers at run time.

use crate::support::{cases, compare};
use hangtime::model::{Model, OptimalControlDeclaration};
use num_dual::DualNum;
use proptest::prelude::*;

hangtime::model! {
    /// A cart with an arm in mixed units: every statement of optimal control.
    pub Cart {
        parameters {
            m: kg = 2, l: cm = 60, g: m/s^2 = 9.81, omega: 1/s = 2, w: 1/N^2 = 0.1, h: m = 1.5,
            haste: 1/s = 3, target: m = 2,
        }
        coordinates { y: m in -5..=5, theta: deg in -0.5..=-0.1 [rad], z: cm }
        controls    { u: N in -10..=10, torque: N m }
        let tip = (y + l*sin(theta), z - l*cos(theta))
        lagrangian  m/2*|dot((y, z))|^2 + m/4*|dot(tip)|^2 - m*g*z
        forces      { y: u, theta: torque }

        minimize haste*time + 2*integral(w*u^2 + sin(omega*t)*dot(theta)^2/1 [1/s^2])*haste
            - (integral(y*z/1 [m^2])/1 [s] - (tip.y - target)^2/h^2)

        /// Room above the cart.
        constraint ceiling: z + 0.1*tip.y <= h
        constraint power: u*dot(y) >= -5 [W]
        constraint moving: tip.z == h*cos(omega*t)
        finally {
            /// At the target.
            y == target,
            |dot(tip)|^2 <= 1 [m^2/s^2],
            z >= 0.1 [m/s]*time,
            theta == omega*t,
        }
        free  { dot(y) in 0..=3, z in 30..=50 [cm], theta }
        start { z: 40, dot(y): 1 }
    }
}

hangtime::model! {
    /// A running cost and nothing else.
    pub Effort {
        coordinates { q }
        controls { u }
        lagrangian dot(q)^2/2
        forces { q: u }
        minimize integral(u^2)
    }
}

hangtime::model! {
    /// A goal at a given time, which `t` tells.
    pub Appointment {
        parameters { speed: m/s = 2 }
        coordinates { q: m }
        controls { u: N }
        lagrangian 1 [kg]*dot(q)^2/2
        forces { q: u }
        finally { q == speed*t }
        horizon 3 [s]
    }
}

oracle!(Cart, path cart_path, terminal cart_terminal);
oracle!(Effort, path |_: &Effort, x: &[_]| vec![x[2] * x[2]], terminal |_: &Effort, _: &[_]| vec![]);
oracle!(
    Appointment,
    path |_: &Appointment, _: &[_]| vec![],
    terminal |scene: &Appointment, z: &[_]| vec![z[0] - z[2] * scene.speed]
);

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Positions and velocities in SI units: `(y, theta, z)`, their rates, the tip and its rate.
struct State<D> {
    q: [D; 3],
    v: [D; 3],
    tip: [D; 2],
    tip_rate: [D; 2],
}

impl<D: DualNum<Primitive = f64> + Copy> State<D> {
    fn new(scene: &Cart, x: &[D]) -> Self {
        let q = [x[0], x[1] * DEGREE, x[2] * 0.01];
        let v = [x[3], x[4] * DEGREE, x[5] * 0.01];
        let l = scene.l * 0.01;
        let (sin, cos) = q[1].sin_cos();
        Self {
            q,
            v,
            tip: [q[0] + sin * l, q[2] - cos * l],
            tip_rate: [v[0] + cos * v[1] * l, v[2] + sin * v[1] * l],
        }
    }
}

fn cart_path<D: DualNum<Primitive = f64> + Copy>(scene: &Cart, x: &[D]) -> Vec<D> {
    let State { q, v, tip, .. } = State::new(scene, x);
    let (u, t) = (x[6], x[8]);
    let running = (u * u * scene.w + (t * scene.omega).sin() * v[1] * v[1]) * (2.0 * scene.haste)
        - q[0] * q[2];
    vec![
        running,
        -q[2] - tip[0] * 0.1 + scene.h,
        u * v[0] + 5.0,
        tip[1] - (t * scene.omega).cos() * scene.h,
    ]
}

fn cart_terminal<D: DualNum<Primitive = f64> + Copy>(scene: &Cart, z: &[D]) -> Vec<D> {
    let State {
        q, tip, tip_rate, ..
    } = State::new(scene, z);
    let time = z[6];
    let miss = (tip[0] - scene.target) / scene.h;
    vec![
        time * scene.haste + miss * miss,
        q[0] - scene.target,
        -tip_rate[0] * tip_rate[0] - tip_rate[1] * tip_rate[1] + 1.0,
        q[2] - time * 0.1,
        q[1] - time * scene.omega,
    ]
}

macro_rules! property {
    ($name:ident, $scene:ty, $inputs:expr) => {
        proptest! {
            #![proptest_config(cases(96))]
            #[test]
            fn $name(
                x in prop::collection::vec(-1.2..1.2_f64, $inputs),
                weights in prop::collection::vec(-1.0..1.0_f64, 8),
            ) {
                let model = <$scene>::default();
                prop_assert_eq!(model.declaration().inputs(), $inputs);
                if let Err(message) = compare(&model, &x, &weights) {
                    return Err(TestCaseError::fail(message));
                }
            }
        }
    };
}

property!(cart_with_every_statement_agrees_with_dual_numbers, Cart, 9);
property!(running_cost_alone_agrees_with_dual_numbers, Effort, 3);
property!(
    goal_at_a_given_time_agrees_with_dual_numbers,
    Appointment,
    3
);

fn task(model: &dyn Model) -> &OptimalControlDeclaration {
    let task = &model.declaration().optimal_control;
    task.as_ref().expect("the scene declares optimal control")
}

#[test]
fn declaration_carries_the_task_of_optimal_control() {
    let cart = Cart::default();
    let declared = task(&cart);
    assert!(declared.running_cost && declared.final_cost && declared.free_time);
    let constraints = declared.constraints.iter();
    let constraints: Vec<_> = constraints.map(|c| (c.name, c.unit, c.equality)).collect();
    assert_eq!(
        constraints,
        [
            ("ceiling", "m", false),
            ("power", "W", false),
            ("moving", "m", true)
        ]
    );
    assert_eq!(
        declared.constraints[0].documentation,
        "Room above the cart."
    );
    let goals: Vec<_> = declared
        .goals
        .iter()
        .map(|c| (c.name, c.unit, c.equality))
        .collect();
    assert_eq!(
        goals,
        [
            ("y == target", "m", true),
            ("|dot(tip)|^2 <= 1 [m^2/s^2]", "m^2/s^2", false),
            ("z >= 0.1 [m/s]*time", "m", false),
            ("theta == omega*t", "", true),
        ]
    );
    assert_eq!(declared.goals[0].documentation, "At the target.");
    // theta, z and dot(y) of (y, theta, z, dot(y), dot(theta), dot(z)).
    assert_eq!(declared.free_start, [1, 2, 3]);
    let (mut lower, mut upper) = ([f64::NAN; 3], [f64::NAN; 3]);
    cart.free_start_bounds(&mut lower, &mut upper);
    assert_eq!(lower, [f64::NEG_INFINITY, 30.0, 0.0]);
    assert_eq!(upper, [f64::INFINITY, 50.0, 3.0]);
    // The unit behind the upper bound is meant for both.
    let (mut lower, mut upper) = ([f64::NAN; 5], [f64::NAN; 5]);
    cart.bounds(&mut lower, &mut upper);
    // Two roundings of numbers below 1.
    let bounds = [lower[1] * DEGREE + 0.5, upper[1] * DEGREE + 0.1];
    assert!(bounds.iter().all(|error| error.abs() < 1e-15), "{bounds:?}");
}

#[test]
fn what_is_not_declared_is_not_emitted() {
    let names = |model: &dyn Model| -> Vec<&str> {
        let kernels = model.declaration().kernels.iter();
        kernels.map(|kernel| kernel.name).collect()
    };
    let effort = Effort::default();
    assert!(task(&effort).running_cost && !task(&effort).free_time);
    assert!(names(&effort).contains(&"path_hessian"));
    assert!(
        !names(&effort)
            .iter()
            .any(|name| name.starts_with("terminal"))
    );
    // The final time is given where only `t` occurs, and the motion does not depend on it.
    let appointment = Appointment::default();
    assert!(!task(&appointment).free_time && !appointment.declaration().explicit_time);
    assert!(
        !names(&appointment)
            .iter()
            .any(|name| name.starts_with("path"))
    );
    assert!(Cart::default().declaration().explicit_time);
}
