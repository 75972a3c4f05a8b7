//! The same scene over lengths, masses and times from 1e-9 to 1e9: the same status, the same optimum, the same words.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::one_start;
use hangtime::model::Model;
use hangtime::ocp::{self, Horizon, Problem, Settings, Status};

hangtime::model! {
    /// A cart that is pushed in least time to a place in front of a wall.
    Stopped {
        parameters { m: kg = 1, far: m = 1, push: N = 1, share = 0.95 }
        coordinates { x: m }
        controls { u in -1..=1 }
        lagrangian m/2*dot(x)^2
        forces { x: push*u }
        surface wall: x <= far
        impact wall: inelastic
        minimize time
        finally { x == share*far }
        horizon 2 [s]
    }
}

#[test]
fn wall_behind_the_goal_is_about_to_be_struck_at_no_scale() {
    for far in [1e-7, 1e-5, 1e-2, 1.0, 50.0] {
        let cart = Stopped {
            far,
            push: far,
            ..Stopped::default()
        };
        let problem = Problem::of(&cart, 4);
        let solution = ocp::solve(&cart, &problem, &Settings::default(), &mut |_| true).unwrap();
        let exact = (2.0 * cart.share).sqrt();
        assert!(
            (solution.objective / exact - 1.0).abs() < 1e-8,
            "{far}: {} {exact}",
            solution.objective
        );
        assert_eq!(solution.struck_after_the_end(&cart), [], "{far}");
    }
}

hangtime::model! {
    /// A lander with an engine that only pushes up and one to the side is to be down and at rest soon.
    Lander {
        parameters { m: kg = 2, g: m/s^2 = 9, ground: m = 0, height: m = 11, far: m = 4, up: N = 30, side: N = 9 }
        coordinates { z: m, y: m }
        controls { u: N in 0..=up, w: N in -side..=side }
        lagrangian m/2*(dot(z)^2 + dot(y)^2) - m*g*z
        forces { z: u, y: w }
        surface floor: z >= ground
        impact floor: inelastic
        minimize time
        finally { z == ground, dot(z) == 0, y == far, dot(y) == 0 }
        start { z: ground + height }
    }
}

hangtime::model! {
    /// The same with coordinates, controls and goals in another order.
    Permuted {
        parameters { far: m = 4, side: N = 9, up: N = 30, height: m = 11, ground: m = 0, g: m/s^2 = 9, m: kg = 2 }
        coordinates { y: m, z: m }
        controls { w: N in -side..=side, u: N in 0..=up }
        lagrangian m/2*(dot(z)^2 + dot(y)^2) - m*g*z
        forces { y: w, z: u }
        surface floor: z >= ground
        impact floor: inelastic
        minimize time
        finally { dot(y) == 0, y == far, dot(z) == 0, z == ground }
        start { z: ground + height }
    }
}

hangtime::model! {
    /// A block with friction is pushed from rest to rest with least effort.
    Block {
        parameters { m: kg = 1.3, g: m/s^2 = 9, mu = 0.2, from: m = 0, way: m = 2.5, duration: s = 1.7, limit: N = 60 }
        coordinates { x: m, z: m }
        controls { u: N in -limit..=limit }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        forces { x: u }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize integral(u^2)
        finally { x == from + way, dot(x) == 0 }
        start { x: from }
        horizon duration
    }
}

/// How a scene is measured, mirrored and moved.
#[derive(Debug, Clone, Copy)]
struct Measured {
    length: f64,
    mass: f64,
    time: f64,
    /// 1 or -1, and a number of its lengths by which all is moved.
    mirror: f64,
    shift: f64,
}

impl Measured {
    const fn in_units(length: f64, mass: f64, time: f64) -> Self {
        let (mirror, shift) = (1.0, 0.0);
        Self {
            length,
            mass,
            time,
            mirror,
            shift,
        }
    }

    const fn moved(self, mirror: f64, shift: f64) -> Self {
        Self {
            mirror,
            shift,
            ..self
        }
    }

    fn force(self) -> f64 {
        self.mass * self.length / self.time.powi(2)
    }

    /// The status and the objective, in the units of the scene, of a lander, of the same permuted, and of a block.
    fn results(self) -> [(Status, f64); 3] {
        let Self {
            length,
            mass,
            time,
            mirror,
            shift,
        } = self;
        let (m, g, far) = (
            2.0 * mass,
            9.0 * length / time.powi(2),
            mirror * 4.0 * length,
        );
        let (ground, height) = (shift * length, 11.0 * length);
        let (up, side) = (30.0 * self.force(), 9.0 * self.force());
        let lander = Lander {
            m,
            g,
            ground,
            height,
            far,
            up,
            side,
        };
        let permuted = Permuted {
            m,
            g,
            ground,
            height,
            far,
            up,
            side,
        };
        let block = Block {
            m: 1.3 * mass,
            g,
            mu: 0.2,
            from: shift * length,
            way: mirror * 2.5 * length,
            duration: 1.7 * time,
            limit: 60.0 * self.force(),
        };
        let soon = Horizon::Free {
            guess: Some(2.2 * time),
        };
        let solved = |model: &dyn Model, horizon: Horizon, unit: f64| {
            let problem = Problem {
                horizon,
                ..Problem::of(model, 5)
            };
            let solution = ocp::solve(model, &problem, &one_start(), &mut |_| true).unwrap();
            (solution.status, solution.objective / unit)
        };
        [
            solved(&lander, soon, time),
            solved(&permuted, soon, time),
            solved(
                &block,
                Horizon::Fixed(1.7 * time),
                self.force().powi(2) * time,
            ),
        ]
    }
}

/// The same status and the same objectives as in units of one.
fn assert_the_same(measured: &[Measured]) {
    let ones = Measured::in_units(1.0, 1.0, 1.0);
    let usual = ones.results();
    assert_eq!((usual[0].0, usual[2].0), (Status::Solved, Status::Solved));
    let mut differ = Vec::new();
    for way in measured {
        for ((status, objective), (wanted, least)) in way.results().into_iter().zip(usual) {
            let apart = (objective / least - 1.0).abs();
            if status != wanted || apart.is_nan() || apart >= 1e-8 {
                differ.push(format!("{way:?}: {status:?} {objective}, usually {least}"));
            }
        }
    }
    assert!(differ.is_empty(), "{}", differ.join("\n"));
}

#[test]
fn scenes_in_other_units_mirrored_and_moved_have_the_same_result() {
    assert_the_same(&[
        Measured::in_units(1e-9, 3e4, 1.0),
        Measured::in_units(1e9, 1.0, 2e-3),
        Measured::in_units(1.0, 1.0, 1.0).moved(-1.0, 6.0),
    ]);
}

#[test]
#[ignore = "long"]
fn scenes_in_all_units_have_the_same_result() {
    let powers = |most: i32| (-most..=most).map(|power| 1e3_f64.powi(power));
    let ones = Measured::in_units(1.0, 1.0, 1.0);
    let lengths = powers(3).map(|length| Measured { length, ..ones });
    let masses = powers(3).map(|mass| Measured { mass, ..ones });
    // Beyond a thousand the units of velocities and of objectives do not follow: docs/experiments/optimal_control.md.
    let times = powers(1).map(|time| Measured { time, ..ones });
    let all: Vec<Measured> = lengths.chain(masses).chain(times).collect();
    let moved = all.iter().map(|way| way.moved(-1.0, 3.0));
    let all: Vec<Measured> = all.iter().copied().chain(moved).collect();
    assert_the_same(&all);
}
