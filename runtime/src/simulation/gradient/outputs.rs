//! Derivatives of what a scene records.

use super::acceleration::{Acceleration, Hold};
use super::matrix::Matrix;
use super::wanted::Wanted;
use crate::joints::joint_forces;
use crate::model::{Model, contact_point, joint_rows};
use crate::simulation::Trajectory;

/// What outputs read at an instant: `(q, v, u, t)`, with the time in every scene, and forces and impulses so far of all contacts.
pub(super) struct Instant {
    pub(super) x: Vec<f64>,
    pub(super) read: Vec<f64>,
}

impl Instant {
    /// Instant `k` of a trajectory.
    pub(super) fn recorded(model: &dyn Model, trajectory: &Trajectory, k: usize) -> Self {
        let (q, v, u) = (&trajectory.q[k], &trajectory.v[k], &trajectory.u[k]);
        let mut read = trajectory.contact_force[k].clone();
        let contacts = read.len();
        read.extend(trajectory.friction_force.get(k).into_iter().flatten());
        read.resize(2 * contacts, 0.0);
        read.extend(trajectory.impulses(k));
        read.resize(4 * contacts, 0.0);
        let x = [q, v, u, &[trajectory.time[k]][..]].concat();
        read.extend(of_joints(model, &x, &read));
        Self { x, read }
    }

    /// The instant at `x` at which the `acceleration` is evaluated.
    pub(super) fn evaluated(
        acceleration: &Acceleration<'_>,
        x: Vec<f64>,
        impulses: &[f64],
    ) -> Self {
        let mut read = force_values(acceleration);
        let forces = read.len();
        read.extend(impulses);
        read.resize(2 * forces, 0.0);
        read.extend(of_joints(acceleration.model, &x, &read));
        Self { x, read }
    }

    /// What the scene records there.
    pub(super) fn values(&self, acceleration: &Acceleration<'_>) -> Vec<f64> {
        let mut values = vec![0.0; acceleration.model.outputs().len()];
        acceleration
            .model
            .output_values(&self.x, &self.read, &mut values);
        values
    }
}

/// Derivatives of the outputs at an instant, a row an output. The `acceleration` is evaluated there.
pub(super) fn outputs(
    acceleration: &Acceleration<'_>,
    wanted: &Wanted,
    instant: &Instant,
    state: &Matrix,
    impulses: &Matrix,
) -> Matrix {
    let model = acceleration.model;
    let declaration = model.declaration();
    let (n, controls) = (declaration.coordinates.len(), declaration.controls.len());
    let contacts = declaration.contacts.len();
    let Instant { x, read } = instant;
    let behind = 2 * n + controls + 1;
    let joints = behind + 4 * contacts..behind + 4 * contacts + joint_rows(model);
    let count = model.outputs().len();
    let mut by = Matrix::zeros(count, joints.end + wanted.parameters);
    wanted.derivatives.outputs(x, read, &mut by.values);
    let mut values = Matrix::zeros(count, wanted.count());
    for column in 0..wanted.count() {
        let forces = forces(acceleration, wanted, state, column);
        for output in 0..count {
            let by = by.row(output);
            let mut sum: f64 = (0..2 * n).map(|i| by[i] * state.row(i)[column]).sum();
            for (i, force) in forces.iter().enumerate() {
                sum += times(by[behind + i], *force);
            }
            for i in 0..2 * contacts {
                sum += times(by[behind + 2 * contacts + i], impulses.row(i)[column]);
            }
            sum += wanted.of_output(by, (behind - 1, joints.end), column);
            if by[joints.clone()].iter().any(|by| *by != 0.0) {
                // How forces of joints change is not known.
                sum = f64::NAN;
            }
            values.row_mut(output)[column] = sum;
        }
    }
    values
}

/// The forces of joints, with the forces that contacts have among what is `read`.
fn of_joints(model: &dyn Model, x: &[f64], read: &[f64]) -> Vec<f64> {
    if joint_rows(model) == 0 {
        return Vec::new();
    }
    let contacts = model.declaration().contacts.len();
    joint_forces(model, x, &read[..contacts], &read[contacts..2 * contacts])
}

/// A product in which what is not read may be unknown.
fn times(factor: f64, value: f64) -> f64 {
    if factor == 0.0 { 0.0 } else { factor * value }
}

/// The normal forces of all contacts and then their tangential ones, where the `acceleration` is evaluated.
fn force_values(acceleration: &Acceleration<'_>) -> Vec<f64> {
    let contacts = acceleration.model.declaration().contacts.len();
    let mut forces = vec![0.0; 2 * contacts];
    let of = |contact: usize, provided: f64| {
        provided
            / acceleration
                .point(contact, contact_point::INVERSE_INERTIA)
                .0
    };
    for (&hold, &provided) in acceleration.holds.iter().zip(&acceleration.forces) {
        match hold {
            Hold::Normal { contact, sense } => {
                forces[contact] = of(contact, provided);
                forces[contacts + contact] +=
                    sense * acceleration.friction(contact).0 * forces[contact];
            }
            Hold::Tangent { contact } => forces[contacts + contact] = of(contact, provided),
        }
    }
    for &(contact, sense) in &acceleration.given {
        let (curvature, _) = acceleration.point(contact, contact_point::CURVATURE);
        forces[contact] = of(contact, -curvature);
        forces[contacts + contact] = sense * acceleration.friction(contact).0 * forces[contact];
    }
    forces
}

/// Derivatives of the normal forces of all contacts and then of the tangential ones, by one quantity at a fixed time.
fn forces(
    acceleration: &Acceleration<'_>,
    wanted: &Wanted,
    state: &Matrix,
    column: usize,
) -> Vec<f64> {
    let contacts = acceleration.model.declaration().contacts.len();
    let mut forces = vec![0.0; 2 * contacts];
    let of = |contact: usize, (provided, by): (f64, &[f64])| {
        let (inertia, inertia_by) = acceleration.point(contact, contact_point::INVERSE_INERTIA);
        let force = provided / inertia;
        let inertia_by = wanted.along(inertia_by, state, column);
        (
            force,
            (wanted.along(by, state, column) - force * inertia_by) / inertia,
        )
    };
    let slides = |contact: usize, sense: f64, (force, change): (f64, f64)| {
        let (mu, mu_by) = acceleration.friction(contact);
        let mu_by = wanted.of_parameters(mu_by, column);
        sense * (mu * change + mu_by * force)
    };
    for (j, &hold) in acceleration.holds.iter().enumerate() {
        let provided = (acceleration.forces[j], acceleration.forces_by.row(j));
        match hold {
            Hold::Normal { contact, sense } => {
                let normal = of(contact, provided);
                forces[contact] = normal.1;
                if sense != 0.0 {
                    forces[contacts + contact] = slides(contact, sense, normal);
                }
            }
            Hold::Tangent { contact } => forces[contacts + contact] = of(contact, provided).1,
        }
    }
    for &(contact, sense) in &acceleration.given {
        let (curvature, by) = acceleration.point(contact, contact_point::CURVATURE);
        let negative: Vec<f64> = by.iter().map(|by| -by).collect();
        let normal = of(contact, (-curvature, &negative));
        forces[contact] = normal.1;
        forces[contacts + contact] = slides(contact, sense, normal);
    }
    forces
}
