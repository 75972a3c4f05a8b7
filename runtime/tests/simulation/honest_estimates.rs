//! Estimates of the error against closed forms, where runs that are compared do the same wrong.

#![allow(clippy::unwrap_used, reason = "test code")]

use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::model::Model;
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, Simulation, Simulator, StepFormulation};

hangtime::model! {
    /// A small mass on a stiff spring beside one that is thrown.
    pub FastAndSmall {
        parameters { m: kg = 1, w: 1/s = 1000, a: m = 1e-7, g: m/s^2 = 9.81, v: m/s = 3 }
        coordinates { x: m, y: m }
        lagrangian m/2*(dot(x)^2 + dot(y)^2) - m/2*w^2*x^2 - m*g*y
        start { x: a, dot(y): v }
        horizon 1 [s]
    }
}

hangtime::model! {
    /// A mass on a spring between its rest and an elastic wall.
    pub Wall {
        parameters { m: kg = 1, w: 1/s = 3, d: m = 0.2, e = 0.7, v: m/s = 1 }
        coordinates { x: m }
        lagrangian m/2*dot(x)^2 - m/2*w^2*x^2
        surface wall: d - x >= 0
        impact wall: restitution e
        start { dot(x): v }
        horizon 7 [s]
    }
}

hangtime::model! {
    /// A mass that is shaken.
    pub Shaken {
        parameters { m: kg = 1, w: 1/s = 10000, a: N = 1 }
        coordinates { x: m }
        lagrangian m/2*dot(x)^2
        forces { x: a*cos(w*t) }
        start { x: 0 [m] }
        horizon 1 [s]
    }
}

hangtime::model! {
    /// A flight at half the height of a thin post.
    pub Post {
        parameters { m: kg = 1, place: m = 1.037, width: m = 2e-3, h: m = 1, v: m/s = 1 }
        coordinates { x: m, z: m }
        lagrangian m/2*|dot((x, z))|^2
        surface ground: z >= h*exp(-((x - place)/width)^2)
        impact ground: inelastic
        start { z: h/2, dot(x): v }
        horizon 2 [s]
    }
}

fn run(simulator: &dyn Simulator, model: &dyn Model, horizon: Option<f64>) -> Simulation {
    let problem = InitialValueProblem::of(model, horizon).unwrap();
    simulator.simulate(model, &problem, &mut |_| true).unwrap()
}

fn fesd(stages: usize, formulation: StepFormulation) -> Fesd {
    Fesd {
        stages: Some(stages),
        formulation,
        ..Fesd::default()
    }
}

/// Largest error of the coordinates at the end as a share of the longest way, or of the velocities as a share of the
/// largest if that is more.
fn error(run: &Simulation, q: &[f64], v: &[f64]) -> f64 {
    let share = |rows: &[Vec<f64>], exact: &[f64]| {
        let from_start = |row: &Vec<f64>| -> f64 {
            let ways = row.iter().zip(&rows[0]).map(|(a, b)| (a - b).abs());
            ways.fold(0.0, f64::max)
        };
        let size = rows.iter().map(from_start).fold(0.0, f64::max);
        let pairs = rows[rows.len() - 1].iter().zip(exact);
        pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) / size
    };
    share(&run.trajectory.q, q).max(share(&run.trajectory.v, v))
}

#[test]
fn what_long_elements_damp_alike_counts_as_error() {
    let model = FastAndSmall::default();
    let FastAndSmall { w, a, g, v, .. } = model;
    let exact = ([a * w.cos(), v - g / 2.0], [-a * w * w.sin(), v - g]);
    // A hundred-thousandth of the velocities is damped to nothing where nobody looks for it.
    for (stages, formulation) in [
        (6, StepFormulation::ActiveSet),
        (4, StepFormulation::TimeFreezing),
        (3, StepFormulation::ActiveSet),
    ] {
        let found = run(&fesd(stages, formulation), &model, None);
        assert!(found.status.is_solved(), "{stages}: {}", found.status);
        let error = error(&found, &exact.0, &exact.1);
        assert!(error < 1e-6, "{stages} stages: {error:e}");
    }
    for steps in [10, 30, 60, 100] {
        let grid = Fesd::default().with_grid(steps, 1);
        let found = run(&grid, &model, None);
        let error = error(&found, &exact.0, &exact.1);
        let estimate = found.error_estimate.unwrap();
        assert!(error < 10.0 * estimate, "{steps}: {error:e} {estimate:e}");
    }
    let steps = FixedStep {
        steps: 1000,
        ..FixedStep::default()
    };
    let found = run(&steps, &model, None);
    let error = error(&found, &exact.0, &exact.1);
    let estimate = found.error_estimate.unwrap();
    assert!(error < 10.0 * estimate, "{error:e} {estimate:e}");
}

#[test]
fn grid_of_one_stage_estimates_the_error_of_the_implicit_euler_method() {
    // A fall from rest: the way is `g (t + h) t/2` instead of `g t^2/2`.
    let model = FastAndSmall {
        a: 0.0,
        v: 0.0,
        ..FastAndSmall::default()
    };
    for steps in [10, 40, 160] {
        let grid = fesd(1, StepFormulation::ActiveSet).with_grid(steps, 1);
        let found = run(&grid, &model, None);
        let error = 1.0 / steps as f64;
        let estimate = found.error_estimate.unwrap();
        assert!(
            estimate > 0.5 * error && estimate < 3.0 * error,
            "{steps}: {error:e} {estimate:e}"
        );
    }
}

/// Position and velocity of [`Wall`] at the time `t`.
fn behind_wall(model: &Wall, t: f64) -> (f64, f64) {
    let Wall { w, d, e, v, .. } = *model;
    let (mut begin, mut x, mut speed) = (0.0, 0.0_f64, v);
    loop {
        let (amplitude, phase) = (x.hypot(speed / w), (speed / w).atan2(x));
        let mut after =
            ((phase - (d / amplitude).min(1.0).acos()) / w).rem_euclid(std::f64::consts::TAU / w);
        if amplitude < d || after < 1e-9 {
            after += std::f64::consts::TAU / w;
        }
        let at = |s: f64| {
            (
                amplitude * (w * s - phase).cos(),
                -amplitude * w * (w * s - phase).sin(),
            )
        };
        if amplitude < d || begin + after > t {
            return at(t - begin);
        }
        (begin, x, speed) = (begin + after, d, -e * at(after).1);
    }
}

#[test]
fn time_stepping_through_bounces_does_not_agree_by_chance() {
    for e in [0.5, 0.7, 0.9, 1.0] {
        for k in 0..8 {
            let horizon = 3.0 + 0.61 * f64::from(k);
            let model = Wall {
                e,
                ..Wall::default()
            };
            let moreau = Moreau {
                steps: 300,
                ..Moreau::default()
            };
            let found = run(&moreau, &model, Some(horizon));
            let (x, v) = behind_wall(&model, horizon);
            let error = error(&found, &[x], &[v]);
            let estimate = found.error_estimate.unwrap();
            assert!(
                error < 10.0 * estimate,
                "e = {e}, {horizon} s: {error:e} {estimate:e}"
            );
        }
    }
}

#[test]
fn the_closed_form_behind_the_wall_is_that_of_the_event_driven_method() {
    let model = Wall::default();
    let found = run(&EventDriven::default(), &model, None);
    let (x, v) = behind_wall(&model, 7.0);
    let error = error(&found, &[x], &[v]);
    assert!(error < 1e-7, "{error:e}");
}

#[test]
fn steps_that_see_a_fast_force_only_at_some_of_its_phases_say_so() {
    // Steps of several periods: halves of them see the same phases.
    let model = Shaken::default();
    let Shaken { w, a, .. } = model;
    let exact = [a / w.powi(2) * (1.0 - w.cos())];
    for steps in [50, 100, 200] {
        let fixed = FixedStep {
            steps,
            ..FixedStep::default()
        };
        let moreau = Moreau {
            steps,
            ..Moreau::default()
        };
        let methods: [&dyn Simulator; 2] = [&fixed, &moreau];
        for method in methods {
            let found = run(method, &model, None);
            let error = error(&found, &exact, &[a / w * w.sin()]);
            let estimate = found.error_estimate.unwrap();
            let name = method.name();
            assert!(
                error < 10.0 * estimate,
                "{name}, {steps} steps: {error:e} {estimate:e}"
            );
        }
    }
}

#[test]
fn free_motion_by_smoothed_switches_has_the_error_of_its_tolerance() {
    let model = FastAndSmall {
        a: 0.3,
        w: 40.0,
        ..FastAndSmall::default()
    };
    let FastAndSmall { w, a, g, v, .. } = model;
    let found = run(&Smooth::default(), &model, None);
    let exact = ([a * w.cos(), v - g / 2.0], [-a * w * w.sin(), v - g]);
    let error = error(&found, &exact.0, &exact.1);
    let estimate = found.error_estimate.unwrap();
    assert!(
        error < 3.0 * estimate && estimate < 1e-2,
        "{error:e} {estimate:e}"
    );
}

#[test]
fn a_run_of_few_stages_that_is_accurate_is_confirmed_by_one_that_is_hardly_longer() {
    // A hundredth of its tolerance would take more elements than a run may have.
    let model = FastAndSmall {
        a: 1.0,
        w: 100.0,
        ..FastAndSmall::default()
    };
    let FastAndSmall { w, a, g, v, .. } = model;
    let found = run(&fesd(2, StepFormulation::ActiveSet), &model, None);
    assert!(found.status.is_solved(), "{}", found.status);
    let exact = ([a * w.cos(), v - g / 2.0], [-a * w * w.sin(), v - g]);
    let error = error(&found, &exact.0, &exact.1);
    let estimate = found.error_estimate.unwrap();
    assert!(error < 10.0 * estimate && error < 1e-6, "{error:e}");
}

#[test]
fn post_between_two_steps_is_a_large_error() {
    for place in [0.301, 0.713, 1.037, 1.3] {
        let model = Post {
            place,
            ..Post::default()
        };
        let fixed = FixedStep {
            steps: 150,
            ..FixedStep::default()
        };
        let moreau = Moreau {
            steps: 150,
            ..Moreau::default()
        };
        let methods: [&dyn Simulator; 3] = [&fixed, &moreau, &Smooth::default()];
        for method in methods {
            let found = run(method, &model, None);
            let x = found.trajectory.q.last().unwrap()[0];
            let estimate = found.error_estimate.unwrap_or(f64::INFINITY);
            // Where it flies on, it should have been stopped.
            assert!(
                x < place + 0.1 || estimate > 0.1,
                "{}, {place}: {x} {estimate:e}",
                method.name()
            );
        }
    }
}
