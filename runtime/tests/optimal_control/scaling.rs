//! The same scene in metres and newtons, in millimetres and kilonewtons: the same optimum by the same work.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::{self, one_start};
use hangtime::model::Model;
use hangtime::ocp::{self, ControlShape, Guess, Horizon, Problem, Settings, Solution, Status};

hangtime::model! {
    /// A mass with engines that hops over a hill and shifts its weight.
    Hop {
        parameters { m: kg = 2, g: m/s^2 = 9.81, a: m = 0.1, price = 1, c: 1/N^2 = 1e-4 }
        coordinates { y: m, z: m, l: m in -0.2..=0.2 }
        controls { u: N in -40..=40, w: N in 0..=60, f: N in -8..=8 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2 + dot(l)^2) - m*g*z
        forces { y: u, z: w, l: f }
        surface ground: z - a*sin(2*y/1[m]) >= 0
        impact ground: inelastic
        minimize price*time + c*integral(u^2 + w^2 + f^2)
        finally { y == 2[m], l == 0.19[m] }
        start { dot(y): 1 [m/s], dot(z): 0.3 [m/s] }
    }
}

hangtime::model! {
    /// The same in other units.
    HopInMillimetres {
        parameters { m: kg = 2, g: m/s^2 = 9.81, a: m = 0.1, price = 1, c: 1/N^2 = 1e-4 }
        coordinates { y: mm, z: mm, l: mm in -200..=200 }
        controls { u: kN in -0.04..=0.04, w: kN in 0..=0.06, f: kN in -0.008..=0.008 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2 + dot(l)^2) - m*g*z
        forces { y: u, z: w, l: f }
        surface ground: z - a*sin(2*y/1[m]) >= 0
        impact ground: inelastic
        minimize price*time + c*integral(u^2 + w^2 + f^2)
        finally { y == 2[m], l == 0.19[m] }
        start { dot(y): 1 [m/s], dot(z): 0.3 [m/s] }
    }
}

/// Solves for a scene in which a metre is that large.
fn solve(model: &dyn Model, metre: f64, horizon: Horizon, controls: ControlShape) -> Solution {
    let problem = Problem {
        horizon,
        ..Problem::of(model, 8)
    };
    let mut settings = one_start();
    settings.controls = controls;
    // Its program is measured in the units of the scene.
    settings.without.push("time-freezing".to_owned());
    // These are in the unit of the scene.
    settings.gap_margin *= metre;
    settings.largest_distance *= metre;
    let solution = ocp::solve(model, &problem, &settings, &mut |_| true).unwrap();
    assert_eq!(
        solution.status,
        Status::Solved,
        "{:?}",
        solution.diagnosis()
    );
    solution
}

#[test]
fn scene_in_millimetres_and_kilonewtons_has_the_optimum_and_the_work_of_that_in_si() {
    let free = (Horizon::Free { guess: None }, 1.0);
    let fixed = (Horizon::Fixed(1.2), 0.0);
    for ((horizon, price), controls) in [
        (free, ControlShape::Constant),
        (fixed, ControlShape::Constant),
        (fixed, ControlShape::Linear),
    ] {
        let hop = Hop {
            price,
            ..Hop::default()
        };
        let in_millimetres = HopInMillimetres {
            price,
            ..HopInMillimetres::default()
        };
        let si = solve(&hop, 1.0, horizon, controls);
        let other = solve(&in_millimetres, 1e3, horizon, controls);
        // The solver's tolerance is 1e-9; objectives of the order of one.
        assert!(
            (si.objective - other.objective).abs() < 1e-8,
            "{} {}",
            si.objective,
            other.objective
        );
        assert!((si.horizon - other.horizon).abs() < 1e-7);
        assert_eq!(si.planned_events.len(), other.planned_events.len());
        // Rounding may cost or save a program here and there.
        let ratio = other.counts.programs as f64 / si.counts.programs as f64;
        assert!(
            (ratio - 1.0).abs() < 0.15,
            "{:?} {:?}",
            si.counts,
            other.counts
        );
    }
}

hangtime::model! {
    /// A sledge on flat ground that no range of its force limits.
    Sledge {
        parameters { m: kg = 3, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        controls { u: N, w: N }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u, z: w }
        surface ground: z >= 0
        impact ground: inelastic
        minimize integral(u^2 + w^2)
        finally { y == 4[m], dot(y) == 0 }
        start { z: 0.5 [m] }
        horizon 2 [s]
    }
}

hangtime::model! {
    /// The same in other units.
    SledgeInMillimetres {
        parameters { m: kg = 3, g: m/s^2 = 9.81 }
        coordinates { y: mm, z: mm }
        controls { u: kN, w: kN }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u, z: w }
        surface ground: z >= 0
        impact ground: inelastic
        minimize integral(u^2 + w^2)
        finally { y == 4[m], dot(y) == 0 }
        start { z: 0.5 [m] }
        horizon 2 [s]
    }
}

/// What is drawn for a control without a range comes from the scene, not from the unit that it is stated in.
#[test]
fn random_guesses_of_unbounded_controls_lead_to_the_same_optimum_in_any_unit() {
    for guess in [Guess::Random(7), Guess::Perturbed(7)] {
        let solve = |model: &dyn Model, metre: f64| {
            let mut settings = one_start();
            settings.guess = guess.clone();
            settings.gap_margin *= metre;
            settings.largest_distance *= metre;
            let problem = Problem::of(model, 6);
            ocp::solve(model, &problem, &settings, &mut |_| true).unwrap()
        };
        let si = solve(&Sledge::default(), 1.0);
        let other = solve(&SledgeInMillimetres::default(), 1e3);
        assert_eq!(si.status, Status::Solved, "{:?}", si.diagnosis());
        assert_eq!(other.status, si.status);
        let ratio = si.objective / other.objective;
        assert!((ratio - 1.0).abs() < 1e-7, "{ratio}");
    }
}

#[test]
fn cpu_time_is_reported_by_kind_of_work() {
    let problem = Problem::of(&Sledge::default(), 6);
    let solution = ocp::solve(&Sledge::default(), &problem, &one_start(), &mut |_| true).unwrap();
    let seconds = solution.seconds;
    assert!(seconds.evaluate > 0.0 && seconds.factorize > 0.0 && seconds.solve > 0.0);
    // What is left is simulation and bookkeeping.
    let known = seconds.evaluate + seconds.factorize + seconds.solve;
    assert!(known < seconds.total, "{seconds:?}");
}

hangtime::model! {
    /// A ball on a tether is moved from one end of its circle to the other. At the start its weight acts along the circle, and the force of
    /// the tether is no more than what a guess of the controls is off by.
    Tethered {
        parameters { g = 9.81, l = 2 }
        coordinates { y, z }
        controls { a in -15..=15, b in -15..=15 }
        lagrangian (dot(y)^2 + dot(z)^2)/2 - g*z
        forces { y: a, z: b }
        surface tether: y^2 + z^2 <= l^2
        impact tether: inelastic
        minimize integral(a^2 + b^2)
        finally { y == -2, z == 0, dot(y) == 0, dot(z) == 0 }
        start { y: 2 }
        horizon 1.3
    }
}

#[test]
fn contact_without_a_force_at_the_start_is_measured_by_the_forces_at_hand() {
    let mut settings = Settings::default();
    settings.starts = Some(2);
    let solution = support::attempt(&Tethered::default(), 12, &settings);
    // In a unit of 1e-9 the rounding errors of its rows were 1e-6, and no program came to its tolerance.
    assert!(
        solution.residuals.primal < 1e-11,
        "{:?}",
        solution.residuals
    );
    // Of a motion that stays on the tether the second half is the first one in reverse; one that leaves it a little at first may cost less.
    let half = |controls: &[Vec<f64>]| -> f64 { controls.iter().flatten().map(|u| u * u).sum() };
    let (there, back) = solution.controls.split_at(6);
    assert!(half(there) / half(back) < 1.001, "{solution}");
}
