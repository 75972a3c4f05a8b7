//! Switches that hide behind others: several within one long element, and rest under large forces.

#![allow(clippy::unwrap_used, reason = "test code")]

use hangtime::prelude::*;

hangtime::model! {
    /// A ball in a low room that loses no energy.
    pub Room {
        parameters { m: kg = 1, g: m/s^2 = 9.81, w: m = 2, h: m = 1, v: m/s = 3 }
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface floor: z >= 0
        surface ceiling: h - z >= 0
        surface left: y >= 0
        surface right: w - y >= 0
        impact floor, ceiling, left, right: restitution 1
        start { y: w/3, z: h/2, dot(y): v, dot(z): v }
        horizon 2 [s]
    }
}

hangtime::model! {
    /// A block that stops on a slope.
    pub Slope {
        parameters { m: kg = 2, g: m/s^2 = 9.81, angle = 0.2, mu = 0.7, v: m/s = 1 }
        coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        surface slope: z*cos(angle) + x*sin(angle) >= 0
        impact slope: inelastic, friction mu
        start { dot(x): v*cos(angle), dot(z): -v*sin(angle) }
        horizon 2 [s]
    }
}

/// Times at which a body that moves between two walls without losing speed strikes one, which take turns: the first time
/// and the time between two.
fn strikes(first: f64, between: f64, horizon: f64) -> Vec<f64> {
    let times = (0..).map(|k| first + f64::from(k) * between);
    times.take_while(|time| *time < horizon).collect()
}

#[test]
fn no_bounce_is_lost_where_a_long_element_holds_many() {
    // Fast bounces between floor and ceiling, seldom ones of the walls: strikes at the walls start long elements in which
    // one sample is behind both floor and ceiling.
    for (g, h, w, v) in [
        (459.0, 0.0171, 2.0, 4.0),
        (350.0, 0.023, 1.3, 3.1),
        (820.0, 0.0084, 2.9, 2.7),
        (97.0, 0.061, 1.7, 5.3),
        (1300.0, 0.0026, 0.9, 1.9),
    ] {
        let room = Room {
            g,
            h,
            w,
            v,
            ..Room::default()
        };
        let run = simulate(&room).run().unwrap();
        assert!(run.status.is_solved(), "g = {g}: {:?}", run.status);
        let at_floor = (v * v + g * h).sqrt();
        let at_ceiling = (v * v - g * h).max(0.0).sqrt();
        assert!(at_ceiling > 0.3, "the ball reaches the ceiling");
        let mut expected = strikes((v - at_ceiling) / g, (at_floor - at_ceiling) / g, 2.0);
        expected.extend(strikes(2.0 / 3.0 * w / v, w / v, 2.0));
        expected.sort_by(f64::total_cmp);
        let found: Vec<f64> = run.events.iter().map(|event| event.time).collect();
        assert_eq!(found.len(), expected.len(), "g = {g}");
        for (found, expected) in found.iter().zip(&expected) {
            assert!(
                (found - expected).abs() < 1e-9,
                "g = {g}: {found} instead of {expected}"
            );
        }
    }
}

#[test]
fn a_block_that_sticks_stays_where_it_is_under_forces_that_move_it_by_rounding() {
    // Of the way down, 1e-9 m, not even a millionth: the rounding error of `g t^2` would be 1e-12 m.
    for (g, v) in [(3000.0_f64, 3e-3_f64), (2100.0, 1e-3), (5200.0, 7e-3)] {
        let slope = Slope {
            g,
            v,
            ..Slope::default()
        };
        let (sin, cos) = slope.angle.sin_cos();
        let way = v * v / (2.0 * g * (slope.mu * cos - sin));
        let runs = [
            simulate(&slope).run().unwrap(),
            simulate(&slope)
                .method(EventDriven::default())
                .run()
                .unwrap(),
        ];
        for run in runs {
            assert!(run.status.is_solved());
            let (x, z) = (run["x"].last().unwrap(), run["z"].last().unwrap());
            assert!(
                (x - way * cos).abs() < 1e-6 * way,
                "{x} instead of {}",
                way * cos
            );
            assert!(
                (z + way * sin).abs() < 1e-6 * way,
                "{z} instead of {}",
                -way * sin
            );
        }
    }
}

hangtime::model! {
    /// A bead that slides over steep waves with hardly any speed left at their crests.
    pub Waves {
        parameters { m: kg = 1, g: m/s^2 = 9.81, a: m = 0.2, k: 1/m = 2, v: m/s = 1 }
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface ground: z >= a*cos(k*y)
        impact ground: inelastic
        start { z: a, dot(y): v }
        horizon 1.6 [s]
    }
}

#[test]
fn crests_between_the_stages_of_an_element_are_not_stepped_over() {
    // Crests of 0.4 ms on a way of 20 ms up and down, which is a parabola beside them: two runs that step over them agree.
    for (k, v) in [(1790.0, 4.68e-3), (1500.0, 5.6e-3), (2100.0, 4.1e-3)] {
        let waves = Waves {
            k,
            v,
            ..Waves::default()
        };
        let run = simulate(&waves).run().unwrap();
        assert!(run.status.is_solved(), "k = {k}: {}", run.status);
        let exact = EventDriven {
            tolerance: 1e-13,
            ..EventDriven::default()
        };
        let exact = simulate(&waves).method(exact).run().unwrap();
        let y = |run: &Simulation| *run.trajectory.q.last().unwrap().first().unwrap();
        let error = (y(&run) - y(&exact)).abs() / y(&exact);
        assert!(error < 1e-6, "k = {k}: {error:e}");
    }
}

hangtime::model! {
    /// A fast ride into waves that are millimetres high.
    pub Ripples {
        parameters { a: m = 0.00409, k: 1/m = 1006.3, v: m/s = 57.237, g: m/s^2 = 9.81 }
        coordinates { y: m, s: m }
        fn track(y) = a*(1 - cos(k*y))
        lagrangian (dot(y)^2 + (dot(s) + diff(track)(y)*dot(y))^2)/2 - g*(track(y) + s)
        surface ground: s >= 0
        impact ground: inelastic, along (-diff(track)(y), 1)
        start { dot(y): v }
        horizon 0.5 [s]
    }
}

#[test]
fn newtons_method_finds_back_from_an_element_that_is_far_off() {
    // Stages of elements that are much too long reach velocities of 1e7 m/s; whoever starts from them stays there.
    for (k, v) in [(1300.0, 75.0), (1700.0, 40.0)] {
        let ripples = Ripples {
            k,
            v,
            ..Ripples::default()
        };
        let run = simulate(&ripples).run().unwrap();
        assert!(run.status.is_solved(), "k = {k}, v = {v}: {}", run.status);
        let exact = simulate(&ripples)
            .method(EventDriven::default())
            .run()
            .unwrap();
        assert!(exact.status.is_solved(), "{}", exact.status);
        let y = |run: &Simulation| run.trajectory.q.last().unwrap()[0];
        let apart = (y(&run) - y(&exact)).abs() / y(&exact).abs();
        assert!(apart < 1e-5, "k = {k}, v = {v}: {apart:e}");
    }
}
