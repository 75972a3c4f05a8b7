//! Dry friction without a surface: closed forms in every simulator, the default one against the event-driven one on random
//! scenes, and how both say that a bound is negative.

use crate::common::{pushed, same_in_every_run, start};
use crate::fesd_laws_against_event_driven::agree;
use hangtime::simulation::InitialValueProblem;
use proptest::prelude::*;

hangtime::model! {
    /// Two links with dry hinges, the second of which is tighter where it is bent.
    Arm {
        parameters { m: kg = 1, l: m = 0.5, g: m/s^2 = 9.81, upper: N m = 0.4, lower: N m = 0.3, bend: N m = 0.2 }
        coordinates { a: rad, b: rad }
        controls { u: N m }
        let elbow = l*(sin(a), -cos(a))
        let tip = elbow + l*(sin(b), -cos(b))
        lagrangian m/2*(|dot(elbow)|^2 + |dot(tip)|^2) - m*g*(elbow.z + tip.z)
        forces { a: u }
        dry friction shoulder: bound upper, sliding dot(a)
        dry friction hinge: sliding dot(b) - dot(a), bound lower + bend*(b - a)^2
    }
}

hangtime::model! {
    /// A crate on a rough floor, with a drawer on a dry rail whose end is a wall.
    Drawer {
        parameters { m: kg = 3, d: kg = 1, g: m/s^2 = 9.81, mu = 0.3, rail: N = 2, k: N/m = 30, way: m = 0.4 }
        coordinates { y: m, z: m, s: m }
        controls { u: N }
        lagrangian m/2*|dot((y, z))|^2 + d/2*|dot((y + s, z))|^2 - (m + d)*g*z - k/2*s^2
        forces { y: u }
        surface floor: z >= 0
        surface wall: s <= way
        impact floor: inelastic, friction mu, sliding dot(y)
        impact wall: restitution 0.4
        dry friction rail: bound rail, sliding dot(s)
    }
}

fn arms() -> impl Strategy<Value = (Arm, InitialValueProblem)> {
    (
        (0.0..1.5_f64, 0.0..1.0_f64, 0.0..0.5_f64),
        (-1.5..1.5_f64, -1.5..1.5_f64),
        (prop::sample::select(vec![0.0, -2.0, 1.0]), -2.0..2.0_f64),
        prop::collection::vec(-3.0..3.0_f64, 3),
    )
        .prop_map(|((upper, lower, bend), (a, b), (turn, fold), torques)| {
            let model = Arm {
                upper,
                lower,
                bend,
                ..Arm::default()
            };
            (model, pushed(&torques, start(&[a, b], &[turn, fold], 0.9)))
        })
}

fn drawers() -> impl Strategy<Value = (Drawer, InitialValueProblem)> {
    (
        (0.05..0.6_f64, 0.1..5.0_f64),
        (-0.4..0.4_f64, prop::sample::select(vec![0.0, 0.0, 0.05])),
        (-2.0..2.0_f64, prop::sample::select(vec![0.0, -1.0, 1.5])),
        prop::collection::vec(-20.0..20.0_f64, 4),
    )
        .prop_map(|((mu, rail), (s, above), (along, out), forces)| {
            let model = Drawer {
                mu,
                rail,
                ..Drawer::default()
            };
            let problem = start(&[0.0, above, s], &[along, 0.0, out], 1.0);
            (model, pushed(&forces, problem))
        })
}

proptest! {
    #![proptest_config(same_in_every_run(200))]

    #[test]
    fn arm_with_dry_hinges_moves_alike((model, problem) in arms()) {
        agree(&model, &problem, 1e-8)?;
    }

    #[test]
    fn drawer_in_a_crate_on_a_rough_floor_moves_alike((model, problem) in drawers()) {
        agree(&model, &problem, 1e-8)?;
    }
}
