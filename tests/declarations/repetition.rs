//! Scenes that repeat and are made of parts against scenes written out by hand.

use crate::same::assert_all_same;
use hangtime::model::{Model, contact_point};

hangtime::model! {
    /// Beads that hang from each other.
    pub Beads {
        count n = 3
        part bead(above, m: kg) {
            coordinates { z: m }
            lagrangian += m/2*dot(z)^2 - m*9.81 [m/s^2]*z - 50 [N/m]*(z - above)^2
        }
        parameters { mass[k in 1..=n]: kg = 0.1*k }
        let hook = 0 [m]
        top: bead(hook, mass[1])
        next: bead(top.z, sum(k in 2..=n: mass[k]))
    }
}

hangtime::model! {
    /// Two legs on a chain of masses.
    pub Repeated {
        count n = 2
        part leg(hip, l: m) {
            parameters { m: kg = 2, e = 0.5 }
            coordinates { angle: rad }
            let foot = hip + l*(sin(angle), -cos(angle))
            lagrangian += m/2*|dot(foot)|^2 - m*g*foot.z
            surface sole: foot.z >= 0
            impact sole: restitution e, friction 0.8, sliding dot(foot).y
        }
        parameters { mass[k in 1..=n]: kg = 0.1*k, g: m/s^2 = 9.81 }
        coordinates { x[n]: m }
        lagrangian += sum(k in 1..=n: mass[k]/2*dot(x[k])^2 - mass[k]*g*x[k])
        left: leg((0, x[1]), 0.8 [m])
        legs[k in 2..=n]: leg((0, x[k]), 0.7 [m])
        outputs { height[k in 1..=n] = x[k] }
        start { x[k in 1..=n]: 1 [m] }
    }
}

hangtime::model! {
    /// The same, written out.
    pub ByHand {
        parameters { a: kg = 0.1, b: kg = 0.2, g: m/s^2 = 9.81, c: kg = 2, e = 0.5, d: kg = 2, f = 0.5 }
        coordinates { r: m, s: m, u: rad, v: rad }
        let p = (0, r) + 0.8 [m]*(sin(u), -cos(u))
        let q = (0, s) + 0.7 [m]*(sin(v), -cos(v))
        lagrangian a/2*dot(r)^2 + b/2*dot(s)^2 - a*g*r - b*g*s
            + c/2*|dot(p)|^2 - c*g*p.z + d/2*|dot(q)|^2 - d*g*q.z
        surface one: p.z >= 0
        impact one: restitution e, friction 0.8, sliding dot(p).y
        surface two: q.z >= 0
        impact two: restitution f, friction 0.8, sliding dot(q).y
        start { r: 1 [m], s: 1 [m] }
    }
}

/// Accelerations and contacts at a state.
fn values(model: &dyn Model) -> Vec<f64> {
    let x = [0.9, 0.8, 0.3, -0.4, 0.5, -0.6, 0.7, 1.1];
    let mut values = vec![0.0; 4];
    model.free_acceleration(&x, &mut values);
    for contact in 0..2 {
        let mut point = vec![0.0; contact_point::length(4)];
        model.contact(contact, &x, &mut point);
        values.extend(point);
        values.extend([model.gap(contact, &x), model.restitution(contact)]);
    }
    values
}

#[test]
fn compiled_repetition_and_parts_are_the_scene_written_by_hand() {
    let repeated = Repeated {
        mass_2: 0.3,
        left_m: 2.5,
        ..Repeated::default()
    };
    let repeated = repeated.with_mass_1(0.15).with_legs_2_e(0.25);
    let by_hand = ByHand {
        a: 0.15,
        b: 0.3,
        c: 2.5,
        f: 0.25,
        ..ByHand::default()
    };
    // The same formulas, with sums in another order.
    for (a, b) in values(&repeated).iter().zip(values(&by_hand)) {
        assert!((a - b).abs() <= 1e-12 * (1.0 + b.abs()), "{a} {b}");
    }
    let beads = Beads {
        mass_2: 0.3,
        ..Beads::default()
    };
    assert_eq!(beads.declaration().coordinates[1].name, "next.z");
    assert_all_same(
        include_str!("repetition.rs"),
        &[&Repeated::default(), &Beads::default()],
    );
}
