//! Starts on a boundary, with either acceleration, in slight and in deep penetration.

use hangtime::simulation::{EventDriven, Fesd, InitialValueProblem, SimulationStatus, Simulator};

use super::assert_outcomes;

pub(super) const SCENES: &[&str] = &["leaving-at-once", "rest", "slight-penetration"];

#[test]
fn starts_on_a_boundary_are_contacts_or_not() {
    assert_outcomes(SCENES);
}

hangtime::model! {
    /// A body that starts at some height above a floor.
    Started {
        parameters { height: m = 1 }
        coordinates { z: m }
        lagrangian 1[kg]/2*dot(z)^2
        surface floor: z >= 0
        impact floor: inelastic
        start { z: height }
        horizon 1 [s]
    }
}

#[test]
fn start_deep_inside_the_ground_is_refused_with_the_gap() {
    for (height, written) in [(-1e-3, "-1e-3 m"), (-1.0, "-1e0 m"), (-1e6, "-1e6 m")] {
        let model = Started { height };
        let refused = InitialValueProblem::of(&model, None)
            .and_then(|problem| problem.check(&model))
            .expect_err("a start inside the ground");
        let message = refused.to_string();
        assert!(message.contains("floor"), "{message}");
        assert!(message.contains(written), "{message}");
    }
}

hangtime::model! {
    /// A body on the flat in front of a smooth bump, which it is inside of by as much as the bump has left there.
    BeforeBump {
        parameters { width: m = 0.35 }
        coordinates { y: m, z: m }
        lagrangian 1[kg]/2*|dot((y, z))|^2 - 9.81[N]*z
        surface road: z >= 0.15[m]*exp(-((y - 2.1 [m])/width)^2)
        impact road: inelastic
        start { y: 0 [m] }
        horizon 1 [s]
    }
}

#[test]
fn start_in_front_of_a_bump_that_has_all_but_faded_is_on_the_ground() {
    let model = BeforeBump::default();
    let mut problem = InitialValueProblem::of(&model, None).unwrap();
    let gap = hangtime::model::Model::gap(&model, 0, &[0.0; 4]);
    assert!((gap + 0.15 * f64::exp(-36.0)).abs() < 1e-30, "{gap}");
    for simulator in [&Fesd::default() as &dyn Simulator, &EventDriven::default()] {
        let simulation = simulator.simulate(&model, &problem, &mut |_| true).unwrap();
        assert_eq!(simulation.status, SimulationStatus::Solved);
        assert!(simulation.events.is_empty(), "{:?}", simulation.events);
        // The slope there is some 1e-15: within a second the body does not get anywhere.
        let last = simulation.trajectory.q.last().unwrap();
        assert!(last.iter().all(|q| q.abs() < 1e-13), "{last:?}");
    }
    // What a motion could tell from nothing is refused, with the remedy.
    problem.q[0] = 0.5;
    let refused = problem.check(&model).expect_err("a start inside the bump");
    let message = refused.to_string();
    assert!(message.contains("the formula of the surface"), "{message}");
}
