//! What counts as zero in the event-driven simulator: releases and grazing against closed forms, and that results
//! depend neither on the place of a scene nor on its units.

#![allow(clippy::unwrap_used, reason = "test code")]

use hangtime::model::Model;
use hangtime::simulation::{
    EventDriven, EventKind, InitialValueProblem, Simulation, SimulationStatus, Simulator,
};

hangtime::model! {
    /// A mass on a cubic guide, no gravity.
    pub Cubic {
        parameters { m: kg = 7, c: 1/m^2 = 0.3, x0: m = -1.7, v: m/s = 2.1, shift: m = 0 }
        coordinates { x: m, z: m }
        // The mass is above where the guide bends upwards, which ends at the origin.
        fn f(p) = -c*p^3
        lagrangian m/2*|dot((x, z))|^2
        surface guide: z - f(x - shift) >= 0
        impact guide: inelastic
        start { x: shift + x0, z: f(x0), dot(x): v, dot(z): v*diff(f)(x0) }
        horizon 2 [s]
    }
}

hangtime::model! {
    /// A block that slides on a rough floor and is lifted by a little more than its weight.
    pub Lifted {
        parameters { m: kg = 1, g: m/s^2 = 10, mu = 0.25, more: N = 1e-6, v: m/s = 3 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { z: m*g + more }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        start { dot(y): v }
        horizon 0.5 [s]
    }
}

hangtime::model! {
    /// A ball flies into a thin post without gravity: its gap is constant up to there.
    pub Post {
        parameters { m: kg = 1, width: m = 0.01, place: m = 0.777, e = 0.5, height: m = 0.5, v: m/s = 1 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2
        surface post: z - 1 [m]*exp(-((y - place)/width)^2) >= 0
        impact post: restitution e
        start { z: height, dot(y): v }
        horizon 1.5 [s]
    }
}

hangtime::model! {
    /// A mass on a track of sines.
    pub Crests {
        parameters { m: kg = 0.4, a: m = 0.25, k: 1/m = 1.7, g: m/s^2 = 3.71, v: m/s = 1 }
        coordinates { x: m, z: m }
        fn track(p) = a*sin(k*p)
        lagrangian m/2*|dot((x, z))|^2 - m*g*z
        surface track: z - track(x) >= 0
        impact track: inelastic
        start { dot(x): v, dot(z): v*diff(track)(0) }
        horizon 2.5 [s]
    }
}

hangtime::model! {
    /// A rod whose ends hit an incline with friction and restitution.
    pub Rod {
        parameters {
            m: kg = 1.7, j: kg m^2 = 0.21, a: m = 0.45, b: m = 0.6, g: m/s^2 = 9.81, slope = 0.15, mu = 0.25,
            e_left = 0.4, e_right = 0.3, x0: m = 0, z0: m = 0, height: m = 0.9, angle0 = 0.3, v_x: m/s = 0.8,
            v_z: m/s = -1.1, spin: 1/s = 0.7,
        }
        coordinates { x: m, z: m, angle }
        let left = (x - x0 - a*cos(angle), z - z0 - a*sin(angle))
        let right = (x - x0 + b*cos(angle), z - z0 + b*sin(angle))
        lagrangian m/2*|dot((x, z))|^2 + j/2*dot(angle)^2 - m*g*z
        surface left: left.y*sin(slope) + left.z*cos(slope) >= 0
        surface right: right.y*sin(slope) + right.z*cos(slope) >= 0
        impact left: restitution e_left, friction mu, sliding dot(left.y*cos(slope) - left.z*sin(slope))
        impact right: restitution e_right, friction mu, sliding dot(right.y*cos(slope) - right.z*sin(slope))
        start {
            x: x0, z: z0 + height, angle: angle0, dot(x): v_x, dot(z): v_z, dot(angle): spin,
        }
        horizon 1.2 [s]
    }
}

hangtime::model! {
    /// A fall beside a ground that ends where its root does.
    pub Root {
        coordinates { y, z }
        lagrangian (dot(y)^2 + dot(z)^2)/2 - 2*z
        surface ground: z - sqrt(0.8 - y) >= -3
        impact ground: inelastic
        start { z: 2, dot(y): 1.5 }
        horizon 2
    }
}

hangtime::model! {
    /// A flight through the pole of a gap.
    pub GapPole {
        coordinates { y, z }
        lagrangian (dot(y)^2 + dot(z)^2)/2 - 2*z
        surface ground: z + tan(2*y) >= -30
        impact ground: inelastic
        start { z: 2, dot(y): 1.5 }
        horizon 2
    }
}

hangtime::model! {
    /// A force with a pole.
    pub ForcePole {
        coordinates { y, z }
        lagrangian (dot(y)^2 + dot(z)^2)/2 - 2*z
        forces { y: tan(2*y) }
        surface ground: z >= 0
        impact ground: inelastic
        start { z: 2, dot(y): 1.5 }
        horizon 2
    }
}

fn simulate(model: &dyn Model, tolerance: f64) -> Simulation {
    let problem = InitialValueProblem::of(model, None).unwrap();
    let simulator = EventDriven {
        tolerance,
        ..EventDriven::default()
    };
    simulator.simulate(model, &problem, &mut |_| true).unwrap()
}

#[test]
fn release_without_gravity_is_where_the_guide_ceases_to_bend_upwards() {
    for (c, x0, v, shift) in [
        (0.3_f64, -1.7_f64, 2.1_f64, 0.0_f64),
        (0.05, -0.4, 0.3, 0.0),
        (2.0, -0.9, 11.0, 0.0),
        (0.3, -1.7, 2.1, 1e5),
    ] {
        let model = Cubic {
            c,
            x0,
            v,
            shift,
            ..Cubic::default()
        };
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let simulation = simulate(&model, tolerance);
            assert_eq!(simulation.status, SimulationStatus::Solved);
            assert_eq!(simulation.events.len(), 1);
            let release = &simulation.events[0];
            assert_eq!(release.kind, EventKind::LiftOff);
            // The root is located to rounding error of the place.
            let rounding = 1e-14 * shift.max(1.0);
            assert!(
                (release.q[0] - shift).abs() < 10.0 * rounding,
                "{release:?}"
            );
            // Nothing but the guide acts: the speed stays that of the start, up to the tolerance of some 20 steps.
            let speed = v * (1.0 + (3.0 * c * x0 * x0).powi(2)).sqrt();
            let found = release.v_after[0].hypot(release.v_after[1]);
            assert!((found - speed).abs() < 100.0 * tolerance.max(rounding) * speed);
            // A force that pulls is none.
            assert!(simulation.residuals.dual < 1e-9 * speed * speed);
        }
    }
}

#[test]
fn crests_passed_with_vanishing_force_are_passed() {
    for (a, k, g) in [
        (0.25_f64, 1.7_f64, 3.71_f64),
        (0.6, 0.9, 9.81),
        (0.1, 4.0, 1.62),
    ] {
        // On the crest `v_x^2 = g/(a k^2)` makes the force vanish; energy gives the speed at the start.
        let grazing: f64 = ((g / (a * k * k) + 2.0 * g * a) / (1.0 + (a * k).powi(2))).sqrt();
        for deviation in [
            -1e-6, -1e-10, -1e-13, -3e-16, 0.0, 3e-16, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9,
            1e-8, 1e-6,
        ] {
            let model = Crests {
                a,
                k,
                g,
                v: grazing * (1.0 + deviation),
                ..Crests::default()
            };
            for tolerance in [1e-9, 1e-12] {
                let simulation = simulate(&model, tolerance);
                let case = format!("a = {a}, {deviation:e}, {tolerance:e}");
                // So near grazing the errors of a run decide on which side of the crest it goes on, and it may say so.
                let near = deviation.abs() <= 1e-9;
                match &simulation.status {
                    SimulationStatus::Inaccurate(diagnosis) if near => {
                        assert!(diagnosis.time < 2.5, "{case}");
                        assert!(simulation.error_estimate.unwrap() > 1e-6, "{case}");
                    }
                    status => assert_eq!(*status, SimulationStatus::Solved, "{case}"),
                }
                // At each crest one flight at most.
                let crests =
                    (simulation.trajectory.q.last().unwrap()[0] * k / std::f64::consts::TAU).ceil();
                assert!(simulation.events.len() as f64 <= 2.0 * crests, "{case}");
                // Flights of a deviation up to 1e-6 end with impacts that take a smaller share of the energy.
                let energy = |q: &[f64], v: &[f64]| 0.5 * (v[0] * v[0] + v[1] * v[1]) + g * q[1];
                let (q, v) = (&simulation.trajectory.q, &simulation.trajectory.v);
                let change =
                    energy(q.last().unwrap(), v.last().unwrap()) / energy(&q[0], &v[0]) - 1.0;
                let lost = 1e-3 * deviation.abs().max(1e-9) + 100.0 * tolerance;
                assert!(change.abs() < lost.max(1e-7), "{case}: {change:e}");
            }
        }
    }
}

/// Impacts that are compared: each amplifies rounding errors a few times, and those of a rod that comes to rest are
/// many.
const COMPARED: usize = 8;

/// The first events of `found` are those of `expected`, with times to `accuracy`, and contacts renamed.
fn same_events(
    expected: &Simulation,
    found: &Simulation,
    contact: fn(usize) -> usize,
    accuracy: f64,
) {
    assert_eq!(found.status, SimulationStatus::Solved);
    let kinds = |simulation: &Simulation, rename: fn(usize) -> usize| {
        let events = simulation.events.iter().take(COMPARED);
        events
            .map(|event| (event.kind, rename(event.contact)))
            .collect::<Vec<_>>()
    };
    assert_eq!(kinds(expected, |i| i), kinds(found, contact));
    for (a, b) in expected.events.iter().zip(&found.events).take(COMPARED) {
        assert!((a.time - b.time).abs() < accuracy, "{a:?} {b:?}");
    }
}

#[test]
fn rod_in_other_units_has_the_same_events() {
    let base = Rod::default();
    let expected = simulate(&base, 1e-9);
    assert_eq!(expected.status, SimulationStatus::Solved);
    assert!(expected.events.len() >= COMPARED);
    for (length, mass) in [
        (1e-3, 1.0),
        (1e3, 1.0),
        (1.0, 1e-3),
        (1e3, 1e3),
        (1e-3, 1e3),
    ] {
        let model = Rod {
            m: mass * base.m,
            j: mass * length * length * base.j,
            a: length * base.a,
            b: length * base.b,
            g: length * base.g,
            height: length * base.height,
            v_x: length * base.v_x,
            v_z: length * base.v_z,
            ..base
        };
        let found = simulate(&model, 1e-9);
        // Factors of a thousand round: 1e-16, amplified by a dozen impacts of factors below ten.
        same_events(&expected, &found, |i| i, 1e-11);
    }
}

#[test]
fn track_in_other_units_has_the_same_errors() {
    let base = Crests {
        v: 2.6,
        ..Crests::default()
    };
    let expected = simulate(&base, 1e-5);
    assert!(expected.events.len() >= 4);
    for length in [1e-3, 1e3] {
        let model = Crests {
            a: length * base.a,
            k: base.k / length,
            g: length * base.g,
            v: length * base.v,
            ..base
        };
        // The same steps: at this tolerance errors are 1e-6, and what differs is rounding.
        same_events(&expected, &simulate(&model, 1e-5), |i| i, 1e-11);
    }
}

#[test]
fn rod_in_another_place_has_the_same_events() {
    let expected = simulate(&Rod::default(), 1e-9);
    for (x0, z0) in [(1e5, 0.0), (0.0, -1e5), (-1e5, 1e5)] {
        let model = Rod {
            x0,
            z0,
            ..Rod::default()
        };
        // Coordinates of 1e5 round to 1e-11.
        same_events(&expected, &simulate(&model, 1e-9), |i| i, 1e-8);
    }
}

#[test]
fn rod_in_the_mirror_has_the_same_events() {
    let base = Rod::default();
    let model = Rod {
        a: base.b,
        b: base.a,
        e_left: base.e_right,
        e_right: base.e_left,
        slope: -base.slope,
        angle0: -base.angle0,
        v_x: -base.v_x,
        spin: -base.spin,
        ..base
    };
    let (expected, found) = (simulate(&base, 1e-9), simulate(&model, 1e-9));
    // Signs are exact; sums are taken in another order.
    same_events(&expected, &found, |i| 1 - i, 1e-11);
}

#[test]
fn gap_that_ends_or_jumps_through_infinity_ends_the_run_by_name() {
    let ended = [
        (simulate(&Root::default(), 1e-9), Some(0), "`ground`"),
        (simulate(&GapPole::default(), 1e-9), Some(0), "`ground`"),
        (simulate(&ForcePole::default(), 1e-9), None, "`y`"),
    ];
    for (simulation, contact, name) in ended {
        let SimulationStatus::NotFinite(diagnosis) = &simulation.status else {
            panic!("{name}: {:?}", simulation.status);
        };
        assert_eq!(diagnosis.contact, contact);
        assert!(diagnosis.message.contains(name), "{}", diagnosis.message);
    }
}

#[test]
fn block_lifted_by_little_more_than_its_weight_leaves_the_floor_at_once() {
    for more in [1e-3, 1e-6, 1e-7] {
        let model = Lifted {
            more,
            ..Lifted::default()
        };
        let run = simulate(&model, 1e-9);
        let (q, v) = (&run.trajectory.q, &run.trajectory.v);
        let (q, v) = (q.last().unwrap(), v.last().unwrap());
        // The difference of two forces of 10 N has an error of 2e-15 N.
        let height = more / model.m * 0.5 * 0.5 / 2.0;
        assert!((q[1] - height).abs() < 1e-7 * height, "{more}: {q:?}");
        assert!(
            (q[0] - 0.5 * model.v).abs() < 1e-12 && v[0] == model.v,
            "{more}: {q:?}, {v:?}"
        );
    }
}

#[test]
fn ball_bounces_off_a_post_that_is_steep_where_its_gap_first_changes() {
    for width in [0.02, 0.01] {
        let model = Post {
            width,
            ..Post::default()
        };
        let run = simulate(&model, 1e-9);
        assert!(run.status.is_solved(), "{:?}", run.status);
        let steep = 2.0_f64.ln().sqrt() / width;
        let push = (1.0 + model.e) * steep / (1.0 + steep * steep);
        let left = 1.5 - (model.place - width * 2.0_f64.ln().sqrt()) / model.v;
        let end = [
            model.place - width * 2.0_f64.ln().sqrt() + left * (1.0 - steep * push),
            model.height + left * push,
        ];
        let q = run.trajectory.q.last().unwrap();
        // Rounding of the place where the normal turns by a part in `width`.
        let error = (q[0] - end[0]).abs().max((q[1] - end[1]).abs());
        assert!(error < 1e-12 / width, "{width}: {error:e}");
    }
}
