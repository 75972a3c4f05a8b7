//! What the tests of the simulators share: scenes and measures.

pub(crate) mod event;
pub(crate) mod laws;
pub(crate) mod scenes;

use hangtime::model::Model;
use hangtime::simulation::{ControlSignal, InitialValueProblem, Simulation, Trajectory};
use proptest::prelude::{ProptestConfig, prop_assert};
use proptest::test_runner::{RngSeed, TestCaseError};

/// Random cases, the same in every run: what fails here fails everywhere.
pub(crate) fn same_in_every_run(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(20_261_122),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// The problem that starts at `(q, v)` and has no controls.
pub(crate) fn start(q: &[f64], v: &[f64], horizon: f64) -> InitialValueProblem {
    InitialValueProblem {
        q: q.to_vec(),
        v: v.to_vec(),
        horizon,
        controls: ControlSignal::Zero,
        points: 100_000,
    }
}

/// The problem with a control that is constant on equal intervals.
pub(crate) fn pushed(forces: &[f64], problem: InitialValueProblem) -> InitialValueProblem {
    let length = problem.horizon / forces.len() as f64;
    InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: (0..forces.len()).map(|k| length * k as f64).collect(),
            values: forces.iter().map(|&force| vec![force]).collect(),
        },
        ..problem
    }
}

/// Position and velocity at the end.
pub(crate) fn last(trajectory: &Trajectory) -> (&[f64], &[f64]) {
    (
        trajectory.q.last().expect("a trajectory has a start"),
        trajectory.v.last().expect("a trajectory has a start"),
    )
}

/// Largest distance between two vectors' components.
pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |s, (a, b)| s.max((a - b).abs()))
}

/// Kinetic plus potential energy at every point of the trajectory.
pub(crate) fn energies(model: &dyn Model, simulation: &Simulation) -> Vec<f64> {
    let trajectory = &simulation.trajectory;
    (0..trajectory.time.len())
        .map(|k| {
            let mut x = trajectory.q[k].clone();
            x.extend_from_slice(&trajectory.v[k]);
            x.extend_from_slice(&trajectory.u[k]);
            let mut energy = [0.0; 2];
            model.energy(&x, &mut energy);
            energy[0] + energy[1]
        })
        .collect()
}

/// Gap of a contact at point `k` of the trajectory.
pub(crate) fn gap_at(model: &dyn Model, trajectory: &Trajectory, contact: usize, k: usize) -> f64 {
    let mut x = trajectory.q[k].clone();
    x.extend_from_slice(&trajectory.v[k]);
    x.extend_from_slice(&trajectory.u[k]);
    model.gap(contact, &x)
}

/// Energy may only fall, up to the error of one step: the tolerance times the energy's rate of change
/// with the state, at most some 1e3.
pub(crate) fn check_energy(
    model: &dyn Model,
    simulation: &Simulation,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    for pair in energies(model, simulation).windows(2) {
        let allowed = 1e3 * tolerance * (1.0 + pair[0].abs());
        prop_assert!(pair[1] <= pair[0] + allowed, "{:?}", pair);
    }
    Ok(())
}

/// Least-squares slope of log error against log step count, negated.
pub(crate) fn order(errors: &[(usize, f64)]) -> f64 {
    let points: Vec<(f64, f64)> = errors
        .iter()
        .map(|&(count, error)| ((count as f64).ln(), error.ln()))
        .collect();
    let mean =
        |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let covariance = mean(&|p| (p.0 - x) * (p.1 - y));
    -covariance / mean(&|p| (p.0 - x).powi(2))
}
