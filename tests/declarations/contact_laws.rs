//! What `model!` derives from impact laws with restitution, friction and held coordinates, against dual
//! numbers at run time and against closed forms.

use crate::support::{cases, compare};
use hangtime::model::{ImpactLaw, Model, contact_point, tangent_point};
use num_dual::DualNum;
use proptest::prelude::*;

hangtime::model! {
    /// A point mass that bounces and slides on a hill: the sliding velocity follows by itself.
    pub Hill {
        parameters  { m: kg = 2, g: m/s^2 = 9.81, e = 0.5, mu = 0.3, k: 1/m = 0.7 }
        coordinates { y: m, z: m }
        lagrangian  m/2*|dot((y, z))|^2 - m*g*z
        surface     ground: z >= 0.4 [m]*sin(k*y)
        surface     wall: y <= 3 [m]
        impact      ground: friction mu, restitution e
        impact      wall: restitution e/2
    }
}

hangtime::model! {
    /// A rod that falls on a moving floor, and whose other end slides on a wall with a spring-loaded tip.
    pub Rod {
        parameters {
            m: kg = 1.3, length: cm = 80, g: m/s^2 = 9.81, mu = 0.4, e = 0.7, tip: g = 300,
            k: N/m = 40, shake: m = 0.05, omega: 1/s = 3,
        }
        coordinates { y: m, z: m, theta: deg, s: cm }
        let axis = (sin(theta), -cos(theta))
        let centre = (y, z)
        let lower = centre + length/2*axis
        let upper = centre - (length/2 + s)*axis
        lagrangian m/2*|dot(centre)|^2 + m*length^2/24*dot(theta)^2 + tip/2*|dot(upper)|^2
            - m*g*z - tip*g*upper.z - k/2*s^2
        surface floor: lower.z >= shake*sin(omega*t)
        // A name that makes two kernels equal by name.
        surface jacobian_floor: upper.y <= 1 [m] + 0.1 [1/m]*upper.z^2
        impact floor: restitution e, friction mu, sliding dot(lower.y)
        impact jacobian_floor: inelastic, holding s, theta, friction mu^2,
            sliding dot(upper.z) + 0.2 [1/m]*upper.z*dot(upper.y)
        start { z: 0.5 }
    }
}

hangtime::model! {
    /// Five links, whose directions are solved for at run time.
    pub Chain {
        parameters { m: kg = 0.9, l: m = 0.5, g: m/s^2 = 9.81, mu = 0.6, e = 0.2 }
        coordinates { q1, q2, q3, q4, q5 }
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
            - m*g*(p1.z + p2.z + p3.z + p4.z + p5.z)
        surface floor: p5.z >= -2.3 [m]
        surface wall: p3.y <= 1 [m] + 0.2*p3.z
        impact floor: friction mu, sliding dot(p5.y), restitution e
        impact wall: sliding dot(p3.z) + 0.2*dot(p3.y), holding q1, inelastic, friction 0.1
        start { q5: pi/2 }
    }
}

hangtime::model! {
    /// Bike and rider on a track that pushes along its normal, written out.
    pub PumpAlong {
        parameters  { m_b: kg = 15, m_r: kg = 75, g: m/s^2 = 9.81, a: m = 0.2, k: 1/m = 2 }
        coordinates { y: m, s: m, l: m }
        controls    { u: N }
        fn track(y) = a*(1 - cos(k*y))
        let bike = (y, track(y) + s)
        let rider = (y, track(y) + s + l)
        lagrangian m_b/2*|dot(bike)|^2 + m_r/2*|dot(rider)|^2 - m_b*g*bike.z - m_r*g*rider.z
        forces { l: u }
        surface ground: s >= 0
        impact ground: inelastic, along (-diff(track)(y), 1 + diff(track)(y)^2, 0)
    }
}

hangtime::model! {
    /// The same by holding the link.
    pub PumpHolding {
        parameters  { m_b: kg = 15, m_r: kg = 75, g: m/s^2 = 9.81, a: m = 0.2, k: 1/m = 2 }
        coordinates { y: m, s: m, l: m }
        controls    { u: N }
        fn track(y) = a*(1 - cos(k*y))
        let bike = (y, track(y) + s)
        let rider = (y, track(y) + s + l)
        lagrangian m_b/2*|dot(bike)|^2 + m_r/2*|dot(rider)|^2 - m_b*g*bike.z - m_r*g*rider.z
        forces { l: u }
        surface ground: s >= 0
        impact ground: inelastic, holding l
    }
}

trait Number: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

oracle!(Hill, sliding hill_sliding);
oracle!(Rod, sliding rod_sliding);
oracle!(Chain, sliding chain_sliding);
oracle!(PumpHolding);

/// Along the ground, turned right from its normal `(-h', 1)`.
fn hill_sliding<D: Number>(scene: &Hill, _: usize, q: &[D], v: &[D], _: D) -> Option<D> {
    let slope = (q[0] * scene.k).cos() * (0.4 * scene.k);
    Some(v[0] + slope * v[1])
}

fn rod_sliding<D: Number>(scene: &Rod, contact: usize, q: &[D], v: &[D], _: D) -> Option<D> {
    const RADIAN: f64 = std::f64::consts::PI / 180.0;
    let (theta, omega) = (q[2] * RADIAN, v[2] * RADIAN);
    let (sin, cos) = theta.sin_cos();
    let half = scene.length * 0.01 / 2.0;
    if contact == 0 {
        return Some(v[0] + cos * omega * half);
    }
    let reach = q[3] * 0.01 + half;
    let height = q[1] + reach * cos;
    let sideways = v[0] - reach * cos * omega - sin * v[3] * 0.01;
    let upwards = v[1] - reach * sin * omega + cos * v[3] * 0.01;
    Some(upwards + height * sideways * 0.2)
}

fn chain_sliding<D: Number>(scene: &Chain, contact: usize, q: &[D], v: &[D], _: D) -> Option<D> {
    let (mut angle, mut rate) = (D::from(0.0), D::from(0.0));
    let (mut sideways, mut upwards) = (D::from(0.0), D::from(0.0));
    for (&q, &v) in q.iter().zip(v).take(if contact == 0 { 5 } else { 3 }) {
        angle += q;
        rate += v;
        sideways += angle.cos() * rate * scene.l;
        upwards += angle.sin() * rate * scene.l;
    }
    Some(if contact == 0 {
        sideways
    } else {
        upwards + sideways * 0.2
    })
}

macro_rules! property {
    ($name:ident, $scene:ty, $inputs:expr, $cases:expr) => {
        proptest! {
            #![proptest_config(cases($cases))]
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

property!(
    point_mass_with_derived_sliding_velocity_agrees_with_dual_numbers,
    Hill,
    4,
    128
);
property!(
    rod_with_declared_sliding_velocity_agrees_with_dual_numbers,
    Rod,
    9,
    96
);
property!(chain_with_friction_agrees_with_dual_numbers, Chain, 10, 24);
property!(held_link_agrees_with_dual_numbers, PumpHolding, 7, 128);

/// Values of one contact.
fn contact(model: &dyn Model, x: &[f64]) -> Vec<f64> {
    let mut point = vec![f64::NAN; contact_point::length(model.declaration().coordinates.len())];
    model.contact(0, x, &mut point);
    point
}

#[test]
fn holding_the_link_equals_the_direction_written_out() {
    let (along, holding) = (PumpAlong::default(), PumpHolding::default());
    for x in [
        [0.3, 0.1, 0.4, 2.0, -0.2, 0.1, 30.0],
        [-1.1, 0.0, 0.5, 4.0, 0.3, 0.0, -8.0],
    ] {
        let (a, b) = (contact(&along, &x), contact(&holding, &x));
        for (i, (a, b)) in a.iter().zip(&b).enumerate() {
            if i != contact_point::INVERSE_INERTIA {
                // Values of order 1 after some ten roundings each.
                assert!((a - b).abs() < 1e-14, "{i}: {a} {b}");
            }
        }
        // The locked system is one mass on the curve, whose inverse inertia along s is
        // (1 + h'^2) / (m_b + m_r).
        let slope = 0.4 * (2.0 * x[0]).sin();
        let wanted = (1.0 + slope * slope) / 90.0;
        assert!((b[contact_point::INVERSE_INERTIA] - wanted).abs() < 1e-15);
    }
    let operations = |model: &dyn Model, name: &str| {
        let kernels = model.declaration().kernels.iter();
        kernels
            .filter(|kernel| kernel.name == name)
            .map(|kernel| kernel.operations)
            .sum::<usize>()
    };
    let counts = [
        "contact_ground",
        "contact_jacobian_ground",
        "contact_hessian_ground",
    ]
    .map(|name| (operations(&along, name), operations(&holding, name)));
    // Deterministic; the inverse inertia of the whole system takes two operations more than that of the
    // locked one.
    assert_eq!(counts, [(16, 14), (22, 22), (35, 35)]);
}

#[test]
fn declaration_carries_the_laws() {
    let rod = Rod::default();
    let [floor, post] = rod.declaration().contacts else {
        panic!("two contacts");
    };
    assert_eq!(
        (floor.law, post.law),
        (ImpactLaw::Restitution, ImpactLaw::Inelastic)
    );
    assert_eq!((floor.held, post.held), (&[][..], &[2, 3][..]));
    assert!(floor.friction.is_some() && post.friction.is_some() && !post.custom_direction);
    assert_eq!([0, 1].map(|i| rod.restitution(i)), [0.7, 0.0]);
    assert_eq!([0, 1].map(|i| rod.friction(i)), [0.4, 0.4 * 0.4]);
    let rod = rod.with_e(0.25).with_mu(2.0);
    assert_eq!((rod.restitution(0), rod.friction(1)), (0.25, 4.0));
    // The wall of the hill has restitution and no friction.
    let hill = Hill::default();
    assert!(hill.declaration().contacts[1].friction.is_none());
    assert_eq!(
        [0, 1].map(|i| (hill.restitution(i), hill.friction(i))),
        [(0.5, 0.3), (0.25, 0.0)]
    );
    // What is not declared is not emitted.
    let kernels = PumpHolding::default().declaration().kernels;
    assert!(
        kernels
            .iter()
            .all(|kernel| !kernel.name.starts_with("tangent"))
    );
}

#[test]
fn sliding_velocity_of_a_point_mass_is_as_large_as_its_velocity_along_the_ground() {
    let hill = Hill::default();
    let (y, speed) = (0.8, 3.0);
    let slope = 0.4 * hill.k * (hill.k * y).cos();
    let scale = slope.hypot(1.0);
    // Along the ground, to the right.
    let x = [y, 1.0, speed / scale, speed * slope / scale];
    let mut point = [f64::NAN; tangent_point::length(2)];
    hill.tangent(0, &x, &mut point);
    // Scaled like the gap, whose gradient has the length `scale`.
    assert!((point[tangent_point::SLIDING_VELOCITY] - speed * scale).abs() < 1e-14);
    assert!(contact(&hill, &x)[contact_point::NORMAL_VELOCITY].abs() < 1e-15);
}

#[test]
fn time_freezing_systems_read_as_a_person_would_write_them() {
    let right = |model: &dyn Model, left: &str| {
        let equations = model.declaration().equations.iter();
        let found: Vec<&str> = equations
            .filter(|equation| equation.left == left)
            .map(|equation| equation.right)
            .collect();
        found.join("; ")
    };
    let pump = PumpHolding::default();
    assert_eq!(
        right(&pump, "f_free"),
        "(y', s', l', 0, -g - a*k^2*cos(k*y)*y'^2 - u/m_b, u/m_r + u/m_b, 1)"
    );
    assert_eq!(
        right(&pump, "f_aux(ground)"),
        "(0, 0, 0, -a_bar*a*k*sin(k*y)/(a^2*k^2*sin(k*y)^2 + 1), a_bar, 0, 0)"
    );
    assert_eq!(
        right(&pump, "frozen(ground)"),
        "gap(ground) < 0 and gap(ground)' < 0"
    );
    let hill = Hill::default();
    assert_eq!(right(&hill, "gap(ground)"), "z - 0.4*sin(k*y)");
    assert_eq!(right(&hill, "slip(ground)"), "y' + 0.4*k*z'*cos(k*y)");
    assert_eq!(
        right(&hill, "frozen(wall)"),
        "gap(wall) < 0, which goes on by gap(wall)' while q rests"
    );
    assert_eq!(right(&hill, "f_aux(wall)"), "(0, 0, -a_bar, 0, 0)");
    assert_eq!(
        right(&hill, "f_aux(wall) opening"),
        "restitution(wall)^2*f_aux(wall) where gap(wall)' > 0"
    );
    assert_eq!(
        right(&hill, "f_aux(ground, slip > 0)"),
        "(0, 0, -a_bar*(mu + 0.4*k*cos(k*y))/(0.16*k^2*cos(k*y)^2 + 1), a_bar*(1 - 0.4*mu*k*cos(k*y))/(0.16*k^2*cos(k*y)^2 + 1), 0)"
    );
    // What would fill several lines is put together from what stands above it.
    let chain = Chain::default();
    assert_eq!(
        right(&chain, "e(wall)"),
        "H b/D, b = d slip/dv, H = M^-1 with q1 locked, D = n' H n"
    );
    assert_eq!(
        right(&chain, "f_aux(wall, slip > 0)"),
        "(0, a_bar*(d(wall) - friction(wall)*e(wall)), 0)"
    );
}
