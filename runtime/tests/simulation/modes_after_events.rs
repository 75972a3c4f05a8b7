//! Every simulator tells the modes of all contacts: at the start, and after each event.

#![allow(clippy::unwrap_used, reason = "test code")]

use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::model::{Model, tangent_point};
use hangtime::simulation::{
    ContactMode, ControlSignal, Direction, EventDriven, EventKind, Fesd, InitialValueProblem,
    Simulation, SimulationStatus, Simulator,
};

hangtime::model! {
    /// A box on rough ground, pushed sideways and lifted.
    pub PushedBox {
        parameters { m: kg = 3, g: m/s^2 = 9.81, mu = 0.35 }
        coordinates { x: m, z: m }
        controls { push: N, lift: N }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        forces { x: push, z: lift }
        surface ground: z >= 0
        surface wall: 4[m] - x >= 0
        impact ground: inelastic, friction mu
        impact wall: inelastic
    }
}

hangtime::model! {
    /// A point that falls onto a smooth slope.
    pub SmoothSlope {
        parameters { m: kg = 3, g: m/s^2 = 9.81, tilt = 0.45, height: m = 0 }
        coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        surface slope: z + tilt*x >= 0
        surface ceiling: 3[m] - z >= 0
        impact slope, ceiling: inelastic
        start { z: height }
        horizon 0.5 [s]
    }
}

/// Rest, push, braking, push backwards, braking, lift, fall.
fn pushed() -> InitialValueProblem {
    let model = PushedBox::default();
    InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: vec![0.0, 0.2, 0.7, 1.3, 1.6, 2.2, 2.5],
            values: [
                [0.0, 0.0],
                [20.0, 0.0],
                [0.0, 0.0],
                [-25.0, 5.0],
                [0.0, 0.0],
                [0.0, 40.0],
                [0.0, 0.0],
            ]
            .map(Vec::from)
            .into(),
        },
        ..InitialValueProblem::of(&model, Some(3.5)).unwrap()
    }
}

/// Mode of a contact at entry `index` of the trajectory, by the events until then.
fn mode_at(simulation: &Simulation, index: usize, contact: usize) -> ContactMode {
    let time = simulation.trajectory.time[index];
    let mut modes = &simulation.initial_modes;
    for event in simulation.events.iter().filter(|event| event.time <= time) {
        modes = &event.modes;
    }
    modes[contact]
}

/// Compares the modes with forces and velocities at all points that are no event.
fn check_modes(model: &dyn Model, simulation: &Simulation, tolerance: f64) {
    let trajectory = &simulation.trajectory;
    let mut seen = Vec::new();
    for (k, &time) in trajectory.time.iter().enumerate() {
        if simulation
            .events
            .iter()
            .any(|event| (event.time - time).abs() < 1e-6)
        {
            continue;
        }
        let mut x = [&trajectory.q[k][..], &trajectory.v[k], &trajectory.u[k]].concat();
        x.resize(model.declaration().inputs(), 0.0);
        for (i, contact) in model.declaration().contacts.iter().enumerate() {
            let mode = mode_at(simulation, k, i);
            let force = trajectory.contact_force[k][i];
            assert_eq!(
                mode == ContactMode::Open,
                force == 0.0,
                "{time}: {mode} with {force} N"
            );
            seen.push(mode);
            if contact.friction.is_none() {
                assert!(matches!(
                    mode,
                    ContactMode::Open | ContactMode::Frictionless
                ));
                continue;
            }
            let mut point = vec![0.0; tangent_point::length(2)];
            model.tangent(i, &x, &mut point);
            let (sliding, mu) = (point[tangent_point::SLIDING_VELOCITY], model.friction(i));
            let friction = trajectory.friction_force[k][i];
            match mode {
                ContactMode::Open => assert_eq!(friction, 0.0),
                ContactMode::Frictionless => panic!("{} has friction", contact.name),
                ContactMode::Stick => {
                    assert!(
                        sliding.abs() < tolerance,
                        "{time}: sticks with {sliding} m/s"
                    );
                    assert!(friction.abs() <= mu * force * (1.0 + tolerance));
                }
                ContactMode::Slip(direction) => {
                    assert!(
                        direction.sign() * sliding > 0.0,
                        "{time}: {mode}, {sliding} m/s"
                    );
                    let expected = -direction.sign() * mu * force;
                    assert!((friction - expected).abs() < tolerance * force);
                }
            }
        }
    }
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen.len(), 4, "{seen:?}");
}

#[test]
fn events_of_a_pushed_box_carry_the_modes_that_forces_and_velocities_show() {
    use ContactMode::{Open, Slip, Stick};
    use Direction::{Backward, Forward};
    use EventKind as Kind;

    let (model, problem) = (PushedBox::default(), pushed());
    let simulators: [(&dyn Simulator, f64); 2] = [
        (&EventDriven::default(), 1e-9),
        (&Fesd::default().with_grid(40, 2), 1e-9),
    ];
    for (simulator, tolerance) in simulators {
        let simulation = simulator.simulate(&model, &problem, &mut |_| true).unwrap();
        assert_eq!(simulation.status, SimulationStatus::Solved);
        assert_eq!(
            simulation.initial_modes,
            [Stick, Open],
            "{}",
            simulator.name()
        );
        let events: Vec<_> = simulation
            .events
            .iter()
            .map(|event| (event.kind, event.contact_name, event.modes[0]))
            .collect();
        let kinds = [
            Kind::Slip,
            Kind::Stick,
            Kind::Slip,
            Kind::Stick,
            Kind::LiftOff,
            Kind::Impact,
        ];
        let modes = [Slip(Forward), Stick, Slip(Backward), Stick, Open, Stick];
        assert_eq!(
            events.len(),
            kinds.len(),
            "{}: {events:?}",
            simulator.name()
        );
        // Which way is forward belongs to the derived tangent.
        let turned = events[0].2 == Slip(Backward);
        for (event, (kind, mode)) in events.iter().zip(kinds.into_iter().zip(modes)) {
            let mode = match mode {
                Slip(Forward) if turned => Slip(Backward),
                Slip(Backward) if turned => Slip(Forward),
                mode => mode,
            };
            assert_eq!(*event, (kind, "ground", mode), "{}", simulator.name());
        }
        check_modes(&model, &simulation, tolerance);
    }
}

#[test]
fn every_method_knows_the_modes_of_the_start() {
    use ContactMode::{Frictionless, Open};

    let simulators: [&dyn Simulator; 5] = [
        &EventDriven::default(),
        &Fesd::default(),
        &Moreau {
            steps: 100,
            ..Moreau::default()
        },
        &FixedStep {
            steps: 100,
            ..FixedStep::default()
        },
        &Smooth::default(),
    ];
    for (height, first) in [(0.0, Frictionless), (0.6, Open)] {
        let model = SmoothSlope {
            height,
            ..SmoothSlope::default()
        };
        let problem = InitialValueProblem::of(&model, None).unwrap();
        for simulator in simulators {
            let simulation = simulator.simulate(&model, &problem, &mut |_| true).unwrap();
            assert_eq!(
                simulation.status,
                SimulationStatus::Solved,
                "{}",
                simulator.name()
            );
            assert_eq!(
                simulation.initial_modes,
                [first, Open],
                "{}",
                simulator.name()
            );
            if let Some(event) = simulation.events.last() {
                assert_eq!(event.modes, [Frictionless, Open], "{}", simulator.name());
            }
        }
    }
}

#[test]
fn time_stepping_tells_slip_and_stick_of_its_first_step() {
    let model = PushedBox::default();
    for (speed, sticks) in [(0.0, true), (1.5, false), (-1.5, false)] {
        let problem = InitialValueProblem {
            v: vec![speed, 0.0],
            ..InitialValueProblem::of(&model, Some(0.05)).unwrap()
        };
        let reference = EventDriven::default()
            .simulate(&model, &problem, &mut |_| true)
            .unwrap();
        let moreau = Moreau {
            steps: 50,
            ..Moreau::default()
        };
        let simulation = moreau.simulate(&model, &problem, &mut |_| true).unwrap();
        assert_eq!(simulation.initial_modes[0] == ContactMode::Stick, sticks);
        assert_eq!(simulation.initial_modes, reference.initial_modes);
    }
}
