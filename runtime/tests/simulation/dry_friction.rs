//! Dry friction without a surface: closed forms in every simulator, the default one against the event-driven one on random
//! scenes, and how both say that a bound is negative.

use crate::common::{distance, last, same_in_every_run, start};
use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    ContactMode, ControlSignal, Direction, EventDriven, EventKind, Fesd, InitialValueProblem,
    Simulation, SimulationStatus, Simulator, StepFormulation,
};
use proptest::prelude::*;
use std::f64::consts::PI;

hangtime::model! {
    /// A mass on a spring, on a dry guide. The sliding velocity may be measured in any scale.
    Guide {
        parameters { m: kg = 1, k: N/m = 100, f: N = 2, scale = 1, release: m = 0.135 }
        coordinates { x: m }
        lagrangian m/2*dot(x)^2 - k/2*x^2
        /// Holds the mass where the spring is weak.
        dry friction guide: bound f/scale, sliding scale*dot(x)
        outputs { rub: N = scale*friction_force(guide) }
        start { x: release }
        horizon 2 [s]
    }
}

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

hangtime::model! {
    /// A mass whose bound falls along its way, below zero.
    Worn {
        parameters { m: kg = 1, f: N = 1, way: m = 1 }
        coordinates { x: m }
        lagrangian m/2*dot(x)^2
        dry friction rail: bound f*(1 - x/way), sliding dot(x)
        start { dot(x): 3 [m/s] }
        horizon 2 [s]
    }
}

fn run(simulator: &dyn Simulator, model: &dyn Model, problem: &InitialValueProblem) -> Simulation {
    simulator
        .simulate(model, problem, &mut |_| true)
        .expect("the problem is accepted")
}

fn formulation(formulation: StepFormulation) -> Fesd {
    Fesd::default().with_formulation(formulation)
}

/// Where the mass on the guide is at a time, from its release at rest: between turns it swings about the place at which
/// the spring pulls as the friction brakes, until a turn lies in the dead zone `|x| <= f/k`.
fn released(model: &Guide, time: f64) -> f64 {
    let half = PI * (model.m / model.k).sqrt();
    let dead = model.f / model.k;
    let (mut turn, mut left) = (model.release, time);
    while turn.abs() > dead {
        let centre = dead.copysign(turn);
        if left < half {
            return centre + (turn - centre) * (PI * left / half).cos();
        }
        turn = 2.0 * centre - turn;
        left -= half;
    }
    turn
}

#[test]
fn amplitude_falls_by_the_same_way_each_half_period_until_the_dead_zone() {
    // Three half periods: 135, -95, 55 and -15 mm, of which the spring can no longer pull.
    for (scale, unit) in [(1.0, 1.0), (4.0, 1.0), (1.0, 1e-3), (1.0, 1e6)] {
        let mut model = Guide {
            scale,
            ..Guide::default()
        };
        (model.m, model.k, model.f) = (unit * model.m, unit * model.k, unit * model.f);
        let problem = InitialValueProblem::of(&model, None).expect("a start and a horizon");
        let simulators: [&dyn Simulator; 4] = [
            &Fesd::default(),
            &EventDriven::default(),
            &formulation(StepFormulation::TimeFreezing),
            &formulation(StepFormulation::ActiveSet).with_scheme(Scheme::GaussLegendre, 3),
        ];
        for simulator in simulators {
            let simulation = run(simulator, &model, &problem);
            assert_eq!(simulation.status, SimulationStatus::Solved);
            let events: Vec<(EventKind, f64)> = simulation
                .events
                .iter()
                .map(|event| (event.kind, event.time))
                .collect();
            let expected = [EventKind::Slip, EventKind::Slip, EventKind::Stick];
            for (k, kind) in expected.into_iter().enumerate() {
                let half = PI / 10.0;
                assert_eq!(events[k].0, kind, "{}", simulator.name());
                // What the default promises: 1e-6 of the largest values, in velocities of 1 m/s.
                let late = events[k].1 - (k + 1) as f64 * half;
                assert!(late.abs() < 1e-6, "{}: {late:e}", simulator.name());
            }
            assert_eq!(events.len(), 3);
            let backward = ContactMode::Slip(Direction::Backward);
            assert_eq!(simulation.initial_modes, [backward]);
            let states = simulation
                .trajectory
                .time
                .iter()
                .zip(&simulation.trajectory.q);
            for (&time, q) in states {
                let distance = (q[0] - released(&model, time)).abs();
                assert!(
                    distance < 1e-6,
                    "{} at {time}: {distance:e}",
                    simulator.name()
                );
            }
            // In the dead zone friction carries what the spring pulls.
            let held = simulation["rub"].last().expect("a motion");
            assert!((held + unit * 1.5).abs() < unit * 1e-4, "{held}");
            let bound = simulation["force(guide)"].last().expect("a motion");
            assert!((bound - model.f / scale).abs() < unit * 1e-9, "{bound}");
        }
    }
}

#[test]
fn methods_to_compare_with_approach_the_closed_form() {
    let model = Guide::default();
    let problem = InitialValueProblem::of(&model, None).expect("a start and a horizon");
    let error = |simulator: &dyn Simulator| {
        let simulation = run(simulator, &model, &problem);
        assert!(
            matches!(simulation.status, SimulationStatus::Solved),
            "{}: {:?}",
            simulator.name(),
            simulation.status
        );
        let states = simulation
            .trajectory
            .time
            .iter()
            .zip(&simulation.trajectory.q);
        let errors = states.map(|(&time, q)| (q[0] - released(&model, time)).abs());
        errors.fold(0.0, f64::max)
    };
    // Runge-Kutta steps notice each of three turns up to a step late, and so long friction pushes with 2 f/m too much: that
    // is 2 f/(m omega) h = 0.4 h of the amplitude. Impulses over a step end it at rest, so that what follows, with up to
    // 0.75 m/s after the first turn and 0.35 m/s after the second, is late by up to a step for each.
    for steps in [1000, 8000] {
        let h = 2.0 / steps as f64;
        let moreau = error(&Moreau {
            steps,
            ..Moreau::default()
        });
        assert!(moreau < 0.75 * h, "{moreau:e}");
        let fixed = error(&FixedStep {
            steps,
            ..FixedStep::default()
        });
        assert!(fixed < 1.2 * h, "{fixed:e}");
    }
    // Where it should stick it creeps with `atanh(|k x|/f)` of the width, as stiff as `f/m` over that.
    for width in [1e-3, 1e-4] {
        let smooth = error(&Smooth {
            width,
            tolerance: 1e-4 * width,
            ..Smooth::default()
        });
        assert!(smooth < 2.0 * width, "{smooth:e}");
    }
}

#[test]
fn steps_as_complementarity_problems_follow_the_closed_form() {
    let model = Guide::default();
    let problem = InitialValueProblem::of(&model, None).expect("a start and a horizon");
    let simulator = formulation(StepFormulation::Complementarity).with_grid(40, 3);
    let simulation = run(&simulator, &model, &problem);
    let states = simulation
        .trajectory
        .time
        .iter()
        .zip(&simulation.trajectory.q);
    for (&time, q) in states {
        let distance = (q[0] - released(&model, time)).abs();
        // Switches are known to the residual of the program, 1e-7, and the scheme.
        assert!(distance < 1e-5, "{time}: {distance:e}");
    }
}

#[test]
fn friction_of_zero_brakes_nothing() {
    let model = Guide {
        f: 0.0,
        ..Guide::default()
    };
    let problem = InitialValueProblem::of(&model, None).expect("a start and a horizon");
    for simulator in [&Fesd::default() as &dyn Simulator, &EventDriven::default()] {
        let simulation = run(simulator, &model, &problem);
        assert_eq!(simulation.status, SimulationStatus::Solved);
        let (q, _) = last(&simulation.trajectory);
        let expected = 0.135 * 20.0_f64.cos();
        assert!(
            (q[0] - expected).abs() < 1e-6,
            "{}: {}",
            simulator.name(),
            q[0]
        );
    }
}

hangtime::model! {
    /// Ten cars in a row, each with dry brakes; the first is pulled.
    Cars {
        parameters { m: kg = 1, k: N/m = 100, f: N = 1 }
        coordinates { a: m, b: m, c: m, d: m, e: m, g: m, h: m, i: m, j: m, l: m }
        lagrangian m/2*(dot(a)^2 + dot(b)^2 + dot(c)^2 + dot(d)^2 + dot(e)^2 + dot(g)^2 + dot(h)^2 + dot(i)^2 + dot(j)^2
            + dot(l)^2) - k/2*((b - a)^2 + (c - b)^2 + (d - c)^2 + (e - d)^2 + (g - e)^2 + (h - g)^2 + (i - h)^2
            + (j - i)^2 + (l - j)^2)
        forces { a: 5 [N/s]*t }
        dry friction car_1: bound f, sliding dot(a)
        dry friction car_2: bound f, sliding dot(b)
        dry friction car_3: bound f, sliding dot(c)
        dry friction car_4: bound f, sliding dot(d)
        dry friction car_5: bound f, sliding dot(e)
        dry friction car_6: bound f, sliding dot(g)
        dry friction car_7: bound f, sliding dot(h)
        dry friction car_8: bound f, sliding dot(i)
        dry friction car_9: bound f, sliding dot(j)
        dry friction car_10: bound f, sliding dot(l)
        horizon 2 [s]
    }
}

#[test]
fn cars_are_pulled_loose_one_after_the_other() {
    let cars = Cars::default();
    let problem = InitialValueProblem::of(&cars, None).expect("a horizon");
    let simulation = run(&Fesd::default(), &cars, &problem);
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert_eq!(simulation.initial_modes, [ContactMode::Stick; 10]);
    let first = &simulation.events[0];
    assert_eq!((first.kind, first.contact), (EventKind::Slip, 0));
    assert!((first.time - 0.2).abs() < 1e-9);
    let loose: Vec<usize> = (0..10)
        .map(|car| {
            let mut events = simulation.events.iter();
            events
                .position(|event| event.contact == car)
                .unwrap_or(usize::MAX)
        })
        .collect();
    assert!(loose.is_sorted(), "{loose:?}");
    let other = run(&EventDriven::default(), &cars, &problem);
    assert_eq!(other.status, SimulationStatus::Solved);
    let told = |simulation: &Simulation| -> Vec<(EventKind, usize)> {
        let events = simulation.events.iter();
        events.map(|event| (event.kind, event.contact)).collect()
    };
    assert_eq!(told(&other), told(&simulation));
}

#[test]
fn bound_below_zero_is_named() {
    let problem = InitialValueProblem::of(&Worn::default(), None).expect("a start and a horizon");
    let simulators: [&dyn Simulator; 3] = [
        &Fesd::default(),
        &EventDriven::default(),
        &formulation(StepFormulation::TimeFreezing),
    ];
    for simulator in simulators {
        let simulation = run(simulator, &Worn::default(), &problem);
        let SimulationStatus::AmbiguousContact(diagnosis) = &simulation.status else {
            panic!("{}: {:?}", simulator.name(), simulation.status);
        };
        let named = "the bound of dry friction `rail` is negative";
        assert!(diagnosis.message.contains(named), "{}", diagnosis.message);
        assert!(diagnosis.time < 0.5);
    }
    let worn = Worn {
        f: -1.0,
        ..Worn::default()
    };
    let refused = EventDriven::default().simulate(&worn, &problem, &mut |_| true);
    let message = refused.expect_err("a negative bound").to_string();
    assert!(message.contains("`rail` is negative") && message.contains("E10"));
}

/// Same events at the same times and the same end.
fn agree(model: &dyn Model, problem: &InitialValueProblem) -> Result<(), TestCaseError> {
    let event = EventDriven {
        tolerance: 1e-12,
        rest_velocity: Some(1e-3),
        ..EventDriven::default()
    };
    let event = run(&event, model, problem);
    prop_assert_eq!(&event.status, &SimulationStatus::Solved);
    for formulation in [StepFormulation::ActiveSet, StepFormulation::TimeFreezing] {
        let fesd = Fesd {
            rest_velocity: Some(1e-3),
            ..Fesd::default()
                .with_scheme(Scheme::RadauIia, 5)
                .with_grid(1, 1)
                .with_tolerance(1e-12)
                .with_formulation(formulation)
        };
        let fesd = run(&fesd, model, problem);
        prop_assert_eq!(&fesd.status, &SimulationStatus::Solved);
        prop_assert_eq!(fesd.counts.fallbacks, 0);
        let list = |simulation: &Simulation| -> Vec<(EventKind, usize)> {
            let events = simulation.events.iter();
            events.map(|event| (event.kind, event.contact)).collect()
        };
        prop_assert_eq!(list(&fesd), list(&event));
        for (a, b) in fesd.events.iter().zip(&event.events) {
            let late = (a.time - b.time).abs();
            prop_assert!(late <= 1e-8, "{:?} at {}: {:e}", a.kind, b.time, late);
        }
        let ((q, v), (q_event, v_event)) = (last(&fesd.trajectory), last(&event.trajectory));
        // Both integrate with 1e-12 of the values; differences grow some hundred times from switch to switch.
        let apart = distance(q, q_event).max(distance(v, v_event));
        prop_assert!(apart <= 1e-8, "{:e}", apart);
        prop_assert!(fesd.residuals.dual <= 1e-9, "{:?}", fesd.residuals);
    }
    Ok(())
}

fn pushed(forces: &[f64], problem: InitialValueProblem) -> InitialValueProblem {
    let length = problem.horizon / forces.len() as f64;
    InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: (0..forces.len()).map(|k| length * k as f64).collect(),
            values: forces.iter().map(|&force| vec![force]).collect(),
        },
        ..problem
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
        agree(&model, &problem)?;
    }

    #[test]
    fn drawer_in_a_crate_on_a_rough_floor_moves_alike((model, problem) in drawers()) {
        agree(&model, &problem)?;
    }
}
