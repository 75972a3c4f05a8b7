//! Columns of bodies that collapse on each other: impacts that follow faster than time can tell apart.

#![expect(clippy::unwrap_used, reason = "a failed step fails the test")]

use crate::common::{energies, start};
use hangtime::model::Model;
use hangtime::simulation::{EventDriven, EventKind, Fesd, Simulation, SimulationStatus, Simulator};

hangtime::model! {
    /// Three bodies on a line without gravity, between which there are two contacts.
    Row {
        parameters { m_1: kg = 1, m_2: kg = 1, m_3: kg = 1, e = 0.1 }
        coordinates { x_1: m, x_2: m, x_3: m }
        lagrangian m_1/2*dot(x_1)^2 + m_2/2*dot(x_2)^2 + m_3/2*dot(x_3)^2
        surface left: x_2 - x_1 >= 0
        surface right: x_3 - x_2 >= 0
        impact left, right: restitution e
        start { x_3: 1 }
        horizon 2 [s]
    }
}

hangtime::model! {
    /// Three balls above each other on a floor.
    Column {
        parameters { m_1: kg = 1, m_2: kg = 1, m_3: kg = 1, g: m/s^2 = 9.81, e = 0.1 }
        coordinates { z_1: m, z_2: m, z_3: m }
        lagrangian m_1/2*dot(z_1)^2 + m_2/2*dot(z_2)^2 + m_3/2*dot(z_3)^2 - g*(m_1*z_1 + m_2*z_2 + m_3*z_3)
        surface floor: z_1 >= 0
        surface lower: z_2 - z_1 >= 0
        surface upper: z_3 - z_2 >= 0
        impact floor, lower, upper: restitution e
        start { z_1: 0 }
        horizon 1.5 [s]
    }
}

hangtime::model! {
    /// Four balls above each other on a floor.
    TallColumn {
        parameters { m_1: kg = 1, m_2: kg = 1, m_3: kg = 1, m_4: kg = 1, g: m/s^2 = 9.81, e = 0.1 }
        coordinates { z_1: m, z_2: m, z_3: m, z_4: m }
        lagrangian m_1/2*dot(z_1)^2 + m_2/2*dot(z_2)^2 + m_3/2*dot(z_3)^2 + m_4/2*dot(z_4)^2
            - g*(m_1*z_1 + m_2*z_2 + m_3*z_3 + m_4*z_4)
        surface floor: z_1 >= 0
        surface lower: z_2 - z_1 >= 0
        surface middle: z_3 - z_2 >= 0
        surface upper: z_4 - z_3 >= 0
        impact floor, lower, middle, upper: restitution e
        start { z_1: 0 }
        horizon 1.5 [s]
    }
}

fn run(
    simulator: &dyn Simulator,
    model: &dyn Model,
    q: &[f64],
    v: &[f64],
    horizon: f64,
) -> Simulation {
    let simulation = simulator
        .simulate(model, &start(q, v, horizon), &mut |_| true)
        .unwrap();
    assert_eq!(
        simulation.status,
        SimulationStatus::Solved,
        "{}",
        simulator.name()
    );
    simulation
}

/// Runs both methods; energy never grows in either. Where none says that rounding decides, the ends agree.
fn both(model: &dyn Model, q: &[f64], v: &[f64], horizon: f64) -> [Simulation; 2] {
    let runs = [
        run(&EventDriven::default(), model, q, v, horizon),
        run(&Fesd::default(), model, q, v, horizon),
    ];
    for simulation in &runs {
        let energies = energies(model, simulation);
        let sizes = energies
            .iter()
            .fold(0.0_f64, |most, energy| most.max(energy.abs()));
        for pair in energies.windows(2) {
            // The default tolerance of both methods is above 1e-9; a gain by a false impact is of order one.
            assert!(
                pair[1] <= pair[0] + 1e-8 * sizes,
                "{pair:?} {:?}",
                simulation.notes
            );
        }
    }
    let undecided = runs.iter().any(|run| {
        run.notes
            .iter()
            .any(|note| note.contains("decide their order"))
    });
    if !undecided {
        let [event, fesd] = &runs;
        let (a, b) = (
            event.trajectory.q.last().unwrap(),
            fesd.trajectory.q.last().unwrap(),
        );
        for (a, b) in a.iter().zip(b) {
            // A thousand times the tolerance of the coarser method: impacts magnify errors.
            assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
    }
    runs
}

#[test]
fn inelastic_collapse_of_three_bodies_ends_in_their_common_velocity() {
    // With equal masses and e below 7 - 4 sqrt(3) = 0.0718 the middle body never gets out from between the others
    // (McNamara and Young 1992): infinitely many impacts in finite time, then one velocity, that of momentum.
    let model = Row {
        e: 0.05,
        ..Row::default()
    };
    for simulation in both(&model, &[0.0, 0.3, 1.0], &[1.3, 0.2, -0.7], 2.0) {
        let common = (1.3 + 0.2 - 0.7) / 3.0;
        for v in simulation.trajectory.v.last().unwrap() {
            assert!((v - common).abs() < 1e-6, "{v} {:?}", simulation.notes);
        }
        assert!(
            simulation
                .events
                .iter()
                .filter(|e| e.kind == EventKind::Impact)
                .count()
                > 4
        );
    }
}

#[test]
fn row_of_other_masses_keeps_its_momentum_through_a_cluster() {
    for (masses, e) in [
        ([2.0, 0.4, 5.0], 0.3),
        ([7.0, 0.2, 1.0], 0.1),
        ([1.0, 3.0, 0.5], 0.0),
    ] {
        let [m_1, m_2, m_3] = masses;
        let model = Row { m_1, m_2, m_3, e };
        let v = [1.1, -0.4, -0.9];
        let momentum = |v: &[f64]| masses.iter().zip(v).map(|(m, v)| m * v).sum::<f64>();
        for simulation in both(&model, &[0.0, 0.4, 1.0], &v, 2.0) {
            for now in &simulation.trajectory.v {
                // Impulses act on both bodies of a contact alike, to rounding of some hundred impacts.
                assert!((momentum(now) - momentum(&v)).abs() < 1e-11);
            }
        }
    }
}

#[test]
fn column_of_three_that_collapses_never_gains_energy_and_comes_to_the_same_end() {
    for (masses, e) in [
        ([0.3, 4.0, 1.5], 0.2),
        ([6.0, 0.5, 3.0], 0.1),
        ([0.2, 0.9, 5.0], 0.4),
    ] {
        let [m_1, m_2, m_3] = masses;
        let model = Column {
            m_1,
            m_2,
            m_3,
            e,
            ..Column::default()
        };
        both(&model, &[0.07, 0.31, 0.44], &[-0.4, -1.2, 0.3], 1.5);
        both(&model, &[0.0, 0.0, 0.25], &[0.0, 0.0, -1.7], 1.5);
    }
}

#[test]
fn column_of_four_that_collapses_never_gains_energy_and_comes_to_the_same_end() {
    for (masses, e) in [([0.3, 4.0, 1.5, 2.0], 0.2), ([6.0, 0.5, 3.0, 0.8], 0.1)] {
        let [m_1, m_2, m_3, m_4] = masses;
        let model = TallColumn {
            m_1,
            m_2,
            m_3,
            m_4,
            e,
            ..TallColumn::default()
        };
        both(
            &model,
            &[0.07, 0.31, 0.44, 0.6],
            &[-0.4, -1.2, 0.3, -2.0],
            1.5,
        );
    }
}
