//! Runs that end otherwise than solved do so for a true reason, and those that need not end do not.

use crate::common::start;
use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::model::Model;
use hangtime::prelude::simulate;
use hangtime::rk::Scheme;
use hangtime::simulation::{EventDriven, Fesd, InitialValueProblem, Simulation, Simulator};

hangtime::model! {
    /// A spring that swings many times.
    Spring {
        parameters { stiffness = 1600 }
        coordinates { z }
        lagrangian dot(z)^2/2 - stiffness*z^2/2
        surface floor: z >= -5
        impact floor: inelastic
        start { z: 1 }
        horizon 5
    }
}

hangtime::model! {
    /// A ball that keeps its energy.
    Elastic {
        parameters { m: kg = 1, g: m/s^2 = 10, height: m = 0.05 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        surface floor: z >= 0
        impact floor: restitution 1
        start { z: height }
        horizon 1 [s]
    }
}

hangtime::model! {
    /// Four balls in a row that a spring and two dry frictions join, one of which is at rest against its neighbour.
    Row {
        parameters { hook = 2.5, still = 1.0, rub = 1.4 }
        coordinates { a, b, c, d }
        lagrangian 0.14*dot(a)^2 + 0.5*dot(b)^2 + 0.7*dot(c)^2 + 0.7*dot(d)^2 - hook*(-a + b - 1)^2
        surface bc: -b + c - 0.4 >= 0
        impact bc: inelastic
        surface cd: -c + d - 0.5 >= 0
        impact cd: inelastic
        surface wall: a + 0.5 >= 0
        impact wall: restitution 1.0
        dry friction first: bound still, sliding dot(b)
        dry friction second: bound rub, sliding dot(c)
        start { b: 0.9, c: 1.9, d: 3.0, dot(d): -2.2 }
        horizon 2.6
    }
}

fn run(simulator: &dyn Simulator, model: &dyn Model) -> Simulation {
    let problem = InitialValueProblem::of(model, None).expect("the scene has a horizon");
    simulator
        .simulate(model, &problem, &mut |_| true)
        .expect("the problem is accepted")
}

#[test]
fn run_whose_error_is_as_large_as_the_motion_is_not_solved() {
    let model = Spring::default();
    for steps in [60, 4000] {
        let fixed = FixedStep {
            steps,
            ..FixedStep::default()
        };
        let moreau = Moreau {
            steps: 10 * steps,
            ..Moreau::default()
        };
        let methods: [&dyn Simulator; 2] = [&fixed, &moreau];
        for method in methods {
            let run = run(method, &model);
            // z = cos(40 t).
            let exact = 200.0_f64.cos();
            let error = (run.trajectory.q.last().unwrap()[0] - exact).abs();
            let estimate = run.error_estimate.unwrap();
            let words = format!(
                "{} {steps}: {error:e} {estimate:e}, {}",
                method.name(),
                run.status
            );
            assert_eq!(run.status.is_solved(), estimate <= 1.0, "{words}");
            // What is solved and says nothing more is as it says.
            assert!(error <= 5.0 * estimate, "{words}");
            let noted = run
                .notes
                .iter()
                .any(|note| note.contains("error is estimated"));
            assert_eq!(noted, run.status.is_solved() && estimate > 1e-3, "{words}");
            assert!(
                steps == 60 || error < 0.1 && run.status.is_solved(),
                "{words}"
            );
        }
    }
    // Steps beyond the stability of the method.
    let few = FixedStep {
        steps: 60,
        ..FixedStep::default()
    };
    let few = run(&few, &model);
    assert_eq!(few.status.name(), "inaccurate", "{}", few.status);
    let wide = run(
        &Smooth {
            width: 0.5,
            ..Smooth::default()
        },
        &Elastic0::default(),
    );
    assert_eq!(wide.status.name(), "inaccurate", "{}", wide.status);
}

hangtime::model! {
    /// A ball that comes to rest where it falls.
    Elastic0 {
        coordinates { z }
        lagrangian dot(z)^2/2 - 9.81*z
        surface floor: z >= 0
        impact floor: inelastic
        start { z: 1 }
        horizon 1
    }
}

#[test]
fn number_of_impacts_that_pass_does_not_depend_on_the_horizon() {
    // A bounce every 0.2 s: 12,000 in all, more in a hundredth of the horizon than in the whole of a shorter one.
    let model = Elastic::default();
    let methods: [&dyn Simulator; 2] = [&Fesd::default(), &EventDriven::default()];
    for method in methods {
        let problem = start(&[0.05], &[0.0], 2400.05);
        let run = method.simulate(&model, &problem, &mut |_| true).unwrap();
        assert!(run.status.is_solved(), "{}: {}", method.name(), run.status);
        assert_eq!((run.events.len(), run.counts.events), (12_000, 12_000));
        let limited = start(&[0.05], &[0.0], 1e6);
        let few = Fesd {
            most_events: 70,
            ..Fesd::default()
        };
        let run = few.simulate(&model, &limited, &mut |_| true).unwrap();
        assert_eq!(run.status.name(), "event_limit", "{}", run.status);
        let reached = run.status.diagnosis().unwrap().time;
        // The 71st bounce.
        assert!((reached - (0.1 + 70.0 * 0.2)).abs() < 1e-6, "{reached}");
    }
}

#[test]
fn motion_at_which_elements_fail_is_that_of_the_other_method() {
    let model = Row::default();
    let default = simulate(&model).run().expect("the scene is accepted");
    let event = run(&EventDriven::default(), &model);
    assert!(event.status.is_solved(), "{}", event.status);
    assert!(default.status.is_solved(), "{}", default.status);
    let handed = |note: &String| note.contains("this is the motion by the event-driven method");
    let apart = default.trajectory.q.last().unwrap().iter();
    let apart = apart.zip(event.trajectory.q.last().unwrap());
    let apart = apart.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    assert!(apart < 1e-6, "{apart:e}");
    // The run that has been handed over says so, and at which time; whoever names the method gets that method.
    let elements = run(&Fesd::default(), &model);
    let note = default.notes.iter().find(|note| handed(note));
    assert_eq!(note.is_some(), !elements.status.is_solved());
    assert!(!elements.notes.iter().any(handed));
    assert!(note.is_none_or(|note| note.contains("finite elements ended with `")));
    let asked = run(&Fesd::default().with_scheme(Scheme::RadauIia, 1), &model);
    assert!(!asked.status.is_solved(), "{}", asked.status);
}
