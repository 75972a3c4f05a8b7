//! Impact laws of declared scenes: what an impact does must not depend on how the scene is written down.

use hangtime::model::{Model, contact_point};
use hangtime::simulation::{
    EventDriven, EventKind, Fesd, InitialValueProblem, SimulationStatus, Simulator,
};

hangtime::model! {
    /// A ball over a floor that may be raised, sloped, curved, and written with any factor.
    pub Ball {
        parameters {
            m: kg = 1, g: m/s^2 = 9.81, e = 0.5,
            raised: m = 0, slope = 0, bend: 1/m = 0, factor = 1,
        }
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface floor: factor*(z - raised - slope*y - bend*y^2) >= 0
        impact floor: restitution e
        start { y: 0.3 [m], z: 1.4 [m], dot(y): 0.7 [m/s] }
        horizon 0.9 [s]
    }
}

/// Normal velocity of the floor at the state `(q, v)`.
fn normal_velocity(model: &Ball, q: &[f64], v: &[f64]) -> f64 {
    let mut point = [0.0; contact_point::length(2)];
    model.contact(0, &[q, v].concat(), &mut point);
    point[contact_point::NORMAL_VELOCITY]
}

#[test]
fn restitution_does_not_depend_on_mass_place_slope_curvature_or_factor() {
    let methods: [&dyn Simulator; 2] = [&EventDriven::default(), &Fesd::default()];
    let mut checked = 0;
    for method in methods {
        for e in [0.3, 0.5, 0.9, 1.0] {
            for m in [1.0, 2.0, 10.0] {
                for (raised, slope, bend) in [
                    (0.0, 0.0, 0.0),
                    (0.2, 0.0, 0.0),
                    (0.0, 0.4, 0.0),
                    (-0.3, -0.2, 0.5),
                    (0.1, 0.3, -0.6),
                ] {
                    for factor in [1.0, 2.0] {
                        let model = Ball {
                            e,
                            m,
                            raised,
                            slope,
                            bend,
                            factor,
                            ..Ball::default()
                        };
                        let problem = InitialValueProblem::of(&model, None).unwrap();
                        let run = method.simulate(&model, &problem, &mut |_| true).unwrap();
                        assert_eq!(run.status, SimulationStatus::Solved);
                        let impact = run.events.iter().find(|x| x.kind == EventKind::Impact);
                        let impact = impact.expect("the ball strikes the floor");
                        let before = normal_velocity(&model, &impact.q, &impact.v_before);
                        let after = normal_velocity(&model, &impact.q, &impact.v_after);
                        let name = method.name();
                        assert!(before < -1.0, "{name}: {before}");
                        // One linear equation: rounding error.
                        let error = (after / before + e).abs();
                        assert!(error < 1e-13, "{name} {model:?}: {error:e}");
                        checked += 1;
                    }
                }
            }
        }
    }
    assert_eq!(checked, 240);
}

hangtime::model! {
    /// A hoop that is thrown onto a rough floor.
    pub Hoop {
        parameters {
            m: kg = 1, r: m = 0.5, g: m/s^2 = 9.81,
            mu = 0.4, spin: 1/s = 0, speed: m/s = 2, height: m = 1,
        }
        coordinates { y: m, z: m, phi }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) + m*r^2/2*dot(phi)^2 - m*g*z
        surface floor: z - r >= 0
        impact floor: inelastic, friction mu, sliding dot(y) + r*dot(phi)
        start { z: r + height, dot(y): speed, dot(phi): spin }
        horizon 6 [s]
    }
}

/// The hoop's impact and the ride after it by hand: (velocities after the impact, time of rolling or
/// `None` if it rolls at once, final velocities).
fn hoop_by_hand(model: &Hoop) -> ([f64; 2], Option<f64>, [f64; 2]) {
    // Sliding velocity w = y' + r phi' of the contact point; a tangential impulse s changes y' by s / m and
    // r phi' by s / m as well (moment of inertia m r^2).
    let fall = (2.0 * model.g * model.height).sqrt();
    let (mut y, mut roll) = (model.speed, model.r * model.spin);
    let wanted = -0.5 * (y + roll);
    let given = wanted.clamp(-model.mu * fall, model.mu * fall);
    (y, roll) = (y + given, roll + given);
    let after = [y, roll / model.r];
    let sliding = y + roll;
    if (wanted - given).abs() < 1e-14 {
        return (after, None, after);
    }
    let landed = (2.0 * model.height / model.g).sqrt();
    let slows = sliding.abs() / (2.0 * model.mu * model.g);
    let last = -0.5 * sliding;
    let end = [y + last, (roll + last) / model.r];
    (after, Some(landed + slows), end)
}

#[test]
fn hoop_slips_at_the_impact_or_rolls_at_once_as_coulomb_says() {
    let methods: [&dyn Simulator; 2] = [&EventDriven::default(), &Fesd::default()];
    for (mu, speed, spin) in [
        (0.4, 2.0, 0.0),    // sticks within the impact
        (0.1, 6.0, 0.0),    // slips through it, rolls later
        (0.1, 2.0, 12.0),   // spins forwards
        (0.15, 4.0, -20.0), // comes back
    ] {
        let model = Hoop {
            mu,
            speed,
            spin,
            ..Hoop::default()
        };
        let (after, rolls, end) = hoop_by_hand(&model);
        for method in methods {
            let problem = InitialValueProblem::of(&model, None).unwrap();
            let run = method.simulate(&model, &problem, &mut |_| true).unwrap();
            let name = method.name();
            assert_eq!(run.status, SimulationStatus::Solved, "{name}");
            let impact = &run.events[0];
            assert_eq!(impact.kind, EventKind::Impact);
            for (k, expected) in [(0, after[0]), (2, after[1])] {
                let error = (impact.v_after[k] - expected).abs();
                assert!(error < 1e-12, "{name} {model:?}: {error:e}");
            }
            let stick = run.events.iter().find(|x| x.kind == EventKind::Stick);
            match rolls {
                // Constant accelerations: rounding and the tolerance of a switch.
                Some(time) => {
                    let stick = stick.expect("it ends up rolling");
                    let error = (stick.time - time).abs();
                    assert!(error < 1e-10, "{name} {model:?}: {error:e}");
                }
                None => assert!(
                    stick.is_none_or(|x| x.time == impact.time),
                    "{name}: {stick:?}"
                ),
            }
            let v = run.trajectory.v.last().unwrap();
            assert!((v[0] - end[0]).abs() < 1e-10, "{name} {model:?}: {v:?}");
            assert!((v[2] - end[1]).abs() < 1e-10, "{name} {model:?}: {v:?}");
        }
    }
}
