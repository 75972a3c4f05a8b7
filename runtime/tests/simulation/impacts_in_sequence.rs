//! Contacts that touch when one of them is struck: at once by Moreau's law, or one after the other where the scene says
//! `in sequence`.

use crate::common::start;
use hangtime::baselines::{Moreau, Smooth};
use hangtime::model::Model;
use hangtime::simulation::{
    Event, EventDriven, EventKind, Fesd, InitialValueProblem, Simulation, Simulator,
    StepFormulation,
};

hangtime::model! {
    /// Four balls in a row without gravity.
    Cradle {
        parameters { e = 1, gap: m = 0 }
        coordinates { a: m, b: m, c: m, d: m }
        lagrangian 0.4 [kg]*dot(a)^2 + 0.4 [kg]*dot(b)^2 + 0.4 [kg]*dot(c)^2 + 0.4 [kg]*dot(d)^2
        surface ab: b - a >= 0.2 [m]
        surface bc: c - b >= 0.2 [m]
        surface cd: d - c >= 0.2 [m]
        impact ab, bc, cd: restitution e, in sequence
        start { a: -0.5 [m], b: 0, c: 0.2 [m] + gap, d: 0.4 [m] + 2*gap, dot(a): 1.5 [m/s] }
        horizon 0.6 [s]
    }
}

hangtime::model! {
    /// Unequal bodies in a row, the law of which says nothing of an order.
    Row {
        parameters { e = 0.7, gap: m = 0 }
        coordinates { a: m, b: m, c: m, d: m }
        lagrangian 0.4 [kg]*dot(a)^2 + 0.9 [kg]*dot(b)^2 + 0.3 [kg]*dot(c)^2 + 0.5 [kg]*dot(d)^2
        surface ab: b - a >= 0.2 [m]
        surface bc: c - b >= 0.2 [m]
        surface cd: d - c >= 0.2 [m]
        impact ab, bc, cd: restitution e
        start { a: -0.5 [m], b: 0, c: 0.2 [m] + gap, d: 0.4 [m] + 2*gap, dot(a): 1.5 [m/s] }
        horizon 0.6 [s]
    }
}

hangtime::model! {
    /// The same in sequence.
    RowInSequence {
        parameters { e = 0.7 }
        coordinates { a: m, b: m, c: m, d: m }
        lagrangian 0.4 [kg]*dot(a)^2 + 0.9 [kg]*dot(b)^2 + 0.3 [kg]*dot(c)^2 + 0.5 [kg]*dot(d)^2
        surface ab: b - a >= 0.2 [m]
        surface bc: c - b >= 0.2 [m]
        surface cd: d - c >= 0.2 [m]
        impact ab, bc, cd: restitution e, in sequence
        start { a: -0.5 [m], b: 0, c: 0.2 [m], d: 0.4 [m], dot(a): 1.5 [m/s] }
        horizon 0.6 [s]
    }
}

hangtime::model! {
    /// A ball on another one, dropped together; the law of the contact between them says that it is struck after the floor.
    Stack {
        parameters { m: kg = 0.5, n: kg = 0.07, e = 0.9, height: m = 0.8 }
        coordinates { a: m, b: m }
        lagrangian m/2*dot(a)^2 + n/2*dot(b)^2 - 9.81 [m/s^2]*(m*a + n*b)
        surface floor: a >= 0
        surface between: b - a >= 0.15 [m]
        impact floor: restitution e
        impact between: restitution e, in sequence
        start { a: height, b: height + 0.15 [m] }
        horizon 0.45 [s]
    }
}

hangtime::model! {
    /// A ball on another one, dropped together with a gap between them; the law says nothing of an order.
    Open {
        parameters { gap: m = 0 }
        coordinates { a: m, b: m }
        lagrangian 0.25 [kg]*dot(a)^2 + 0.03 [kg]*dot(b)^2 - 9.81 [m/s^2]*(0.5 [kg]*a + 0.06 [kg]*b)
        surface floor: a >= 0
        surface between: b - a >= 0.15 [m]
        impact floor, between: restitution 0.9
        start { a: 0.8 [m], b: 0.95 [m] + gap }
        horizon 0.45 [s]
    }
}

hangtime::model! {
    /// Two balls beside each other that reach the floor at one instant.
    Pair {
        coordinates { a: m, b: m }
        lagrangian 0.25 [kg]*dot(a)^2 + 0.03 [kg]*dot(b)^2 - 9.81 [m/s^2]*(0.5 [kg]*a + 0.06 [kg]*b)
        surface left: a >= 0
        surface right: b >= 0
        impact left, right: restitution 0.8
        start { a: 0.8 [m], b: 0.8 [m] }
        horizon 0.6 [s]
    }
}

fn run(simulator: &dyn Simulator, model: &dyn Model) -> Simulation {
    let problem = InitialValueProblem::of(model, None).expect("the scene has a horizon");
    let run = simulator
        .simulate(model, &problem, &mut |_| true)
        .expect("the problem is accepted");
    assert!(
        run.status.is_solved(),
        "{}: {}",
        simulator.name(),
        run.status
    );
    run
}

fn velocities(run: &Simulation) -> &[f64] {
    run.trajectory.v.last().expect("a run has an end")
}

/// All methods that carry out impacts one after the other.
fn methods() -> [Box<dyn Simulator>; 4] {
    [
        Box::new(Fesd::default()),
        Box::new(Fesd::default().with_grid(12, 2)),
        Box::new(Fesd::default().with_formulation(StepFormulation::TimeFreezing)),
        Box::new(EventDriven::default()),
    ]
}

fn near(found: &[f64], expected: &[f64], tolerance: f64, words: &str) {
    let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0, f64::max);
    assert!(apart <= tolerance, "{words}: {found:?} {expected:?}");
}

fn note(run: &Simulation) -> Option<&String> {
    run.notes.iter().find(|note| note.contains("in sequence"))
}

#[test]
fn as_many_balls_leave_a_cradle_as_come() {
    let model = Cradle::default();
    for method in methods() {
        let one = run(&*method, &model);
        near(velocities(&one), &[0.0, 0.0, 0.0, 1.5], 1e-9, method.name());
        assert_eq!(note(&one), None);
        // Two that touch each other.
        let two = start(&[-0.9, -0.7, 0.2, 0.4], &[1.5, 1.5, 0.0, 0.0], 0.8);
        let two = method
            .simulate(&model, &two, &mut |_| true)
            .expect("accepted");
        near(velocities(&two), &[0.0, 0.0, 1.5, 1.5], 1e-9, method.name());
    }
}

#[test]
fn impacts_in_sequence_are_those_of_gaps_too_small_to_be_seen() {
    for e in [0.0, 0.35, 0.7, 1.0] {
        // Apart by gaps that the event-driven method tells from none, which it passes in their order.
        let apart = Row { e, gap: 1e-8 };
        let exact = run(&EventDriven::default(), &apart);
        let model = RowInSequence { e };
        for method in methods() {
            let run = run(&*method, &model);
            let words = format!("{} {e}", method.name());
            near(velocities(&run), velocities(&exact), 2e-6, &words);
        }
    }
}

#[test]
fn ball_on_a_ball_is_thrown_up_as_in_closed_form() {
    for (n, e) in [(0.07, 0.9), (0.02, 1.0), (0.05, 0.6)] {
        let model = Stack {
            n,
            e,
            ..Stack::default()
        };
        let time = (2.0 * model.height / 9.81).sqrt();
        let speed = 9.81 * time;
        // The lower one turns round, then they strike each other.
        let share = (1.0 + e) * (1.0 + e) * speed / (model.m + n);
        let fall = 9.81 * (0.45 - time);
        let expected = [e * speed - n * share - fall, model.m * share - speed - fall];
        for method in methods() {
            let run = run(&*method, &model);
            let words = format!("{} {n} {e}", method.name());
            near(velocities(&run), &expected, 1e-6, &words);
            let struck = |event: &&Event| event.contact == 1 && event.kind == EventKind::Impact;
            assert_eq!(run.events.iter().filter(struck).count(), 1, "{words}");
        }
    }
}

#[test]
fn run_says_where_the_order_of_impacts_decides() {
    let methods: [&dyn Simulator; 2] = [&Fesd::default(), &EventDriven::default()];
    for method in methods {
        for gap in [0.0, 1e-9] {
            let run = run(method, &Open { gap });
            let note = note(&run).expect("the order decides");
            assert!(
                note.contains("`impact between: ..., in sequence`"),
                "{note}"
            );
        }
        for model in [&Open { gap: 0.02 } as &dyn Model, &Pair::default()] {
            assert_eq!(note(&run(method, model)), None, "{}", method.name());
        }
    }
}

#[test]
fn methods_whose_impacts_are_all_at_once_refuse_a_sequence() {
    let model = Cradle::default();
    let problem = InitialValueProblem::of(&model, None).expect("the scene has a horizon");
    let complementarity = Fesd::default().with_formulation(StepFormulation::Complementarity);
    let methods: [&dyn Simulator; 3] = [&Moreau::default(), &Smooth::default(), &complementarity];
    for method in methods {
        let refused = method.simulate(&model, &problem, &mut |_| true);
        let error = refused.expect_err("impacts of all contacts at once");
        assert!(error.is_unsupported(), "{error}");
    }
}
