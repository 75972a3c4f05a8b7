//! Everything that `model!` derives, against dual numbers of the same Lagrangian at run time.

#![allow(deprecated, reason = "warned of: a floor that nothing touches")]

use crate::support::{cases, compare};
use hangtime::model::Model;
use num_dual::DualNum;
use proptest::prelude::*;

hangtime::model! {
    /// A ski jumper, seen as a point mass.
    pub SkiJump {
        parameters {
            /// Mass of the jumper.
            m: kg = 80,
            g: m/s^2 = 9.81,
            /// Where the jumper starts.
            start_y: m = 10.2759,
        }
        coordinates { y: m, z: m }
        fn jump(y) = -0.0001524 [1/m^3]*y^4 - 0.002149 [1/m^2]*y^3 + 0.4162 [1/m]*y^2 - 9.154*y + 99.15 [m]
        let p = (y, z)
        lagrangian m/2*|dot(p)|^2 - m*g*z
        /// The table.
        surface table: z >= jump(y)
        /// The hill below it.
        surface slope: z >= 45 [m] - y/2
        impact table, slope: inelastic
        start { y: start_y, z: jump(start_y) }
        horizon 5 [s]
    }
}

hangtime::model! {
    /// Bike and rider: two point masses on a massless link, on a track.
    pub PumpTrack {
        parameters  { m_b: kg = 15, m_r: kg = 75, g: m/s^2 = 9.81, a: m = 0.2, k: 1/m = 2 }
        coordinates { y: m, s: m, l: m in 0.27803..=0.59559 }        // s: height above the track, l: link length
        controls    { u: N in -108.25..=376.875 }

        fn track(y) = a * (1 - cos(k*y))
        let bike  = (y, track(y) + s)
        let rider = (y, track(y) + s + l)

        lagrangian  m_b/2*|dot(bike)|^2 + m_r/2*|dot(rider)|^2 - m_b*g*bike.z - m_r*g*rider.z
        forces      { l: u }                                          // generalized force on a coordinate
        surface ground: s >= 0
        impact  ground: inelastic, along (-diff(track)(y), 1, 0)
    }
}

hangtime::model! {
    /// A double pendulum in other units than SI, with a motor, a wall and a moving support.
    pub DoublePendulum {
        parameters {
            m_1: kg = 1.3, m_2: g = 700, l_1: cm = 80, l_2: m = 0.6, g: m/s^2 = 9.81,
            damping: N m s/rad = 0.1, shake: m = 0.05, omega: 1/s = 3, wall: m = 1.1,
        }
        coordinates { a: rad, b: deg }
        controls { torque: N m }
        let support = (0, shake*sin(omega*t))
        let p_1 = support + l_1*(sin(a), -cos(a))
        let p_2 = p_1 + l_2*(sin(a + b), -cos(a + b))
        lagrangian m_1/2*|dot(p_1)|^2 + m_2/2*|dot(p_2)|^2 - m_1*g*p_1.z - m_2*g*p_2.z
        forces { b: torque - damping*dot(b), a: -damping*dot(a) }
        surface post: p_2.y <= wall
        surface floor: p_2.z >= -1.2 [m] + 0.1 [1/m]*p_2.y^2
        impact post, floor: inelastic
        start { b: 90 }
    }
}

hangtime::model! {
    /// Five links in relative angles over a wavy floor, the joints with springs, the last one driven.
    pub Chain {
        parameters {
            m: kg = 0.9, l: m = 0.5, g: m/s^2 = 9.81, k: N m = 2, mu: 1/m = 1.7, tilt: 1 = 0.3,
        }
        coordinates { q1, q2, q3, q4, q5 }
        controls { u: N m }
        fn tip(angle) = l*(sin(angle), -cos(angle))
        let a2 = q1 + q2
        let a3 = a2 + q3
        let a4 = a3 + q4
        let a5 = a4 + q5
        let p1 = tip(q1)
        let p2 = p1 + tip(a2)
        let p3 = p2 + tip(a3)
        let p4 = p3 + tip(a4)
        let p5 = p4 + tip(a5)
        fn kinetic(p) = m/2*|dot(p)|^2
        lagrangian kinetic(p1) + kinetic(p2) + kinetic(p3) + kinetic(p4) + kinetic(p5)
            - m*g*(p1.z + p2.z + p3.z + p4.z + p5.z) - k/2*(q2^2 + q3^2 + q4^2 + q5^2)
        forces { q5: u, q1: -0.1 [N m s]*dot(q1) }
        surface floor: p5.z >= -3 [m] + 0.1 [m]*sin(mu*p5.y)
        surface ceiling: p3.z <= 1.6 [m] + tilt*p3.y
        impact floor: inelastic
        impact ceiling: inelastic, along (1, -1, sin(q2), 0, 2)
    }
}

hangtime::model! {
    /// Every function of the language once.
    pub Functions {
        parameters { c = 1.5, e = 2.3 }
        coordinates { x, y, z }
        fn f(s) = sqrt(1 + s^2) + tanh(s)*exp(-s/3) + atan(s) + cbrt(3 + s)
        let p = (x, y + f(x), z*cosh(x/2))
        lagrangian |dot(p)|^2/2 + c*dot(z)^2*(2 + sin(x*y)) - ln(4 + x^2 + y) - atan2(y, 3 + x) - (4 + z)^e
            - diff(diff(f))(z)*tan(x/4) - asin(y/5)*acos(z/5) - sinh(x)*(3 + y)^1.5
        forces { x: cross((x, y), (y, dot(x))), y: dot(p, (1, dot(y), z)) }
        surface wall: 5 + x - y^2 + sin(z) >= 0
        impact wall: inelastic
    }
}

hangtime::model! {
    /// A heavy top: rotations and moments of inertia as matrices, a joint stop and a driven spin.
    pub Top {
        parameters { m: kg = 0.4, l: m = 0.3, i_1: kg m^2 = 0.05, i_3: kg m^2 = 0.02, g: m/s^2 = 9.81 }
        coordinates { psi: rad, theta: rad, phi: rad }
        controls { u: N m }
        let r = rotation_z(psi)*rotation_x(theta)*rotation_z(phi)
        let w = transpose(r)*dot(r)
        let spin = (w[2][1], w[0][2], w[1][0])
        let tip = r*(0, 0, l)
        lagrangian spin . (diagonal(i_1, i_1, i_3)*spin)/2 - m*g*tip.z
        forces { phi: u }
        surface stop: tip.z >= 0.1*l
        impact stop: inelastic
    }
}

hangtime::model! {
    /// The same top by the formulas of a textbook.
    pub TopOfTextbooks {
        parameters { m: kg = 0.4, l: m = 0.3, i_1: kg m^2 = 0.05, i_3: kg m^2 = 0.02, g: m/s^2 = 9.81 }
        coordinates { psi: rad, theta: rad, phi: rad }
        controls { u: N m }
        lagrangian i_1/2*(dot(theta)^2 + dot(psi)^2*sin(theta)^2)
            + i_3/2*(dot(phi) + dot(psi)*cos(theta))^2 - m*g*l*cos(theta)
        forces { phi: u }
    }
}

hangtime::model! {
    /// A box on a turntable, with matrices written out, products of matrices and other units than SI.
    pub Turntable {
        parameters { m: kg = 1.5, k: N/cm = 0.2, j: kg m^2 = 0.3, tilt: deg = 20 }
        coordinates { a: deg, x: cm, y: cm }
        let skew = ((1, 0.2), (-0.1, 1))
        let turn = rotation(a)*skew - ((0, sin(tilt)/10), (0, 0))
        let p = turn*(x, y)
        lagrangian m/2*|dot(p)|^2 + j/2*dot(a)^2 - k/2*(x, y) . (transpose(skew)*(skew*(x, y)))
        surface wall: p.y + 0.2*p.z <= 30 [cm]
        impact wall: inelastic
    }
}

oracle!(SkiJump);
oracle!(Top);
oracle!(Turntable);
oracle!(DoublePendulum);
oracle!(Functions);
oracle!(PumpTrack, along pump_direction);
impl crate::support::Oracle for Chain {
    fn lagrangian_of<D: DualNum<Primitive = f64> + Copy>(&self, q: &[D], v: &[D], t: D) -> D {
        self.lagrangian(q, v, t)
    }
    fn forces_of<D: DualNum<Primitive = f64> + Copy>(
        &self,
        q: &[D],
        v: &[D],
        u: &[D],
        t: D,
    ) -> Vec<D> {
        self.generalized_forces(q, v, u, t).to_vec()
    }
    fn gap_of<D: DualNum<Primitive = f64> + Copy>(&self, contact: usize, q: &[D], t: D) -> D {
        self.gaps(q, t)[contact]
    }
    fn along_of<D: DualNum<Primitive = f64> + Copy>(
        &self,
        contact: usize,
        q: &[D],
    ) -> Option<Vec<D>> {
        (contact == 1).then(|| {
            vec![
                D::from(1.0),
                D::from(-1.0),
                q[1].sin(),
                D::from(0.0),
                D::from(2.0),
            ]
        })
    }
}

fn pump_direction<D: DualNum<Primitive = f64> + Copy>(scene: &PumpTrack, q: &[D]) -> Vec<D> {
    let slope = (q[0] * scene.k).sin() * (scene.a * scene.k);
    vec![-slope, D::from(1.0), D::from(0.0)]
}

/// Inputs of a scene and weights, all moderate.
fn point(inputs: usize) -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
    (
        prop::collection::vec(-1.2..1.2_f64, inputs),
        prop::collection::vec(-1.0..1.0_f64, 8),
    )
}

macro_rules! property {
    ($name:ident, $scene:ty, $inputs:expr, $cases:expr) => {
        proptest! {
            #![proptest_config(cases($cases))]
            #[test]
            fn $name((x, weights) in point($inputs)) {
                let model = <$scene>::default();
                prop_assert_eq!(model.declaration().inputs(), $inputs);
                if let Err(message) = compare(&model, &x, &weights) {
                    return Err(TestCaseError::fail(message));
                }
            }
        }
    };
}

property!(ski_jump_agrees_with_dual_numbers, SkiJump, 4, 128);
property!(pump_track_agrees_with_dual_numbers, PumpTrack, 7, 128);
property!(
    double_pendulum_agrees_with_dual_numbers,
    DoublePendulum,
    6,
    128
);
property!(chain_of_five_agrees_with_dual_numbers, Chain, 11, 24);
property!(every_function_agrees_with_dual_numbers, Functions, 6, 128);
property!(turntable_agrees_with_dual_numbers, Turntable, 6, 64);

#[test]
fn top_by_matrices_agrees_with_dual_numbers_and_with_a_textbook() {
    let (top, known) = (Top::default(), TopOfTextbooks::default());
    let weights = [0.3, -0.7, 0.4, 0.9, -0.2];
    for theta in [0.4, 1.1, -0.9, 2.2] {
        let x = [0.7, theta, -1.3, 0.8, -0.6, 2.5, 0.35];
        assert_eq!(compare(&top, &x, &weights), Ok(()));
        let (mut a, mut b) = ([0.0; 3], [0.0; 3]);
        top.free_acceleration(&x, &mut a);
        known.free_acceleration(&x, &mut b);
        for (a, b) in a.iter().zip(b) {
            // Both are tens of roundings of numbers up to 1e3.
            assert!((a - b).abs() < 1e-11 * (1.0 + b.abs()), "{a} {b}");
        }
    }
}

#[test]
fn pump_track_takes_no_more_operations_than_hand_derived_code() {
    let count = |name: &str| {
        let pump = PumpTrack::default();
        let kernels = pump.declaration().kernels.iter();
        kernels
            .filter(|kernel| kernel.name == name)
            .map(|kernel| kernel.operations)
            .sum::<usize>()
    };
    // The counts are deterministic. Hand-derived equations in a code generator take 26 for the value
    // and 63 for all three, of which the derivation must not exceed 30 and 40 more.
    let counts = ["free_acceleration", "free_jacobian", "free_hessian"].map(count);
    assert_eq!(counts, [13, 18, 18]);
}

#[test]
fn pump_track_equations_read_as_a_person_would_write_them() {
    let pump = PumpTrack::default();
    let right = |left: &str| {
        let equations = pump.declaration().equations.iter();
        equations
            .filter(|equation| equation.left == left)
            .map(|equation| equation.right)
            .collect::<String>()
    };
    assert_eq!(
        right("kinetic energy"),
        "m_b*(y'^2 + (s' + a*k*y'*sin(k*y))^2)/2 + m_r*(y'^2 + (s' + a*k*y'*sin(k*y) + l')^2)/2"
    );
    assert_eq!(right("y''"), "0");
    assert_eq!(right("s''"), "-g - a*k^2*cos(k*y)*y'^2 - u/m_b");
    assert_eq!(right("l''"), "u/m_r + u/m_b");
    assert_eq!(right("gap(ground)'"), "s'");
    assert_eq!(right("d(ground, y)"), "-a*k*sin(k*y)");
    assert_eq!(right("D(ground)"), "1/m_b + a^2*k^2*sin(k*y)^2/(m_b + m_r)");
}

#[test]
fn declaration_carries_units_documentation_and_bounds() {
    let jump = SkiJump::default();
    let declaration = jump.declaration();
    assert_eq!(
        declaration.documentation,
        "A ski jumper, seen as a point mass."
    );
    assert_eq!(
        declaration.parameters[0].documentation,
        "Mass of the jumper."
    );
    let positive: Vec<bool> = declaration.parameters.iter().map(|p| p.positive).collect();
    assert_eq!(positive, [true, false, false]);
    assert_eq!(declaration.contacts[0].unit, "m");
    assert_eq!(declaration.contacts[0].documentation, "The table.");
    let (mut q, mut v) = ([f64::NAN; 2], [f64::NAN; 2]);
    jump.start(&mut q, &mut v);
    assert_eq!((q[0], v), (10.2759, [0.0; 2]));
    // At rest on the table, wherever the start is.
    assert!(jump.gap(0, &[q[0], q[1], 0.0, 0.0]).abs() < 1e-13);
    assert_eq!(jump.horizon(), Some(5.0));

    let pump = PumpTrack::default();
    let (mut lower, mut upper) = ([0.0; 4], [0.0; 4]);
    pump.bounds(&mut lower, &mut upper);
    assert_eq!(
        lower,
        [f64::NEG_INFINITY, f64::NEG_INFINITY, 0.27803, -108.25]
    );
    assert_eq!(upper, [f64::INFINITY, f64::INFINITY, 0.59559, 376.875]);
    assert_eq!(pump.horizon(), None);

    let mut pendulum = DoublePendulum::default();
    let index = pendulum
        .declaration()
        .parameters
        .iter()
        .position(|p| p.name == "l_1")
        .unwrap();
    pendulum.set_parameter(index, 55.0);
    assert_eq!((pendulum.l_1, pendulum.parameter(index)), (55.0, 55.0));
    assert_eq!(pendulum, DoublePendulum::default().with_l_1(55.0));
    assert!(pendulum.declaration().explicit_time);
}
