//! Derivatives of what a scene records.

use super::mode::{Acceleration, Hold};
use super::tangent::{Matrix, Tangent, add};
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
    instant: &Instant,
    tangent: &Tangent,
) -> Matrix {
    let (model, layout) = (acceleration.model, tangent.layout);
    let columns = tangent.all.columns;
    let forces = forces(acceleration, tangent);
    // How forces of joints change is not known.
    let unknown = vec![f64::NAN; columns];
    let row = |i: usize| tangent.all.row(i);
    let inputs = (0..layout.first_parameter()).map(row);
    let provided = (0..forces.values.len() / columns.max(1)).map(|i| forces.row(i));
    let impulses = (layout.impulses()..layout.cost()).map(row);
    let joints = (0..joint_rows(model)).map(|_| &unknown[..]);
    let parameters = (layout.first_parameter()..layout.impulses()).map(row);
    let read = inputs.chain(provided).chain(impulses).chain(joints);
    let read: Vec<&[f64]> = read.chain(parameters).collect();
    let mut by = Matrix::zeros(model.outputs().len(), read.len());
    let derivatives = &acceleration.derivatives;
    derivatives.outputs(&instant.x, &instant.read, &mut by.values);
    let mut values = Matrix::zeros(model.outputs().len(), columns);
    for output in 0..model.outputs().len() {
        let pairs = by.row(output).iter().zip(&read);
        // What is not read may be unknown.
        for (by, row) in pairs.filter(|(by, _)| **by != 0.0) {
            add(values.row_mut(output), *by, row);
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

/// Derivatives of the normal forces of all contacts and then of the tangential ones.
fn forces(acceleration: &Acceleration<'_>, tangent: &Tangent) -> Matrix {
    let contacts = acceleration.model.declaration().contacts.len();
    let mut forces = Matrix::zeros(2 * contacts, tangent.all.columns);
    // A force, and its change.
    let of = |contact: usize, (provided, by): (f64, &[f64]), sense: f64| {
        let (inertia, inertia_by) = acceleration.point(contact, contact_point::INVERSE_INERTIA);
        let force = sense * provided / inertia;
        let mut change: Vec<f64> = tangent.of(by).iter().map(|by| sense * by).collect();
        if force != 0.0 {
            add(&mut change, -force, &tangent.of(inertia_by));
        }
        change.iter_mut().for_each(|by| *by /= inertia);
        (force, change)
    };
    let slides = |contact: usize, sense: f64, (force, change): &(f64, Vec<f64>)| {
        let (mu, mu_by) = acceleration.friction(contact);
        let mut rubs: Vec<f64> = change.iter().map(|by| sense * mu * by).collect();
        add(&mut rubs, sense * force, &tangent.of_parameters(mu_by));
        rubs
    };
    for (j, &hold) in acceleration.holds.iter().enumerate() {
        let provided = (acceleration.forces[j], acceleration.forces_by.row(j));
        let (Hold::Normal { contact, .. } | Hold::Tangent { contact }) = hold;
        let own = of(contact, provided, 1.0);
        match hold {
            Hold::Tangent { .. } => {
                forces.row_mut(contacts + contact).copy_from_slice(&own.1);
            }
            Hold::Normal { sense, .. } => {
                forces.row_mut(contact).copy_from_slice(&own.1);
                if sense != 0.0 {
                    let rubs = slides(contact, sense, &own);
                    forces.row_mut(contacts + contact).copy_from_slice(&rubs);
                }
            }
        }
    }
    for &(contact, sense) in &acceleration.given {
        let curvature = acceleration.point(contact, contact_point::CURVATURE);
        let normal = of(contact, curvature, -1.0);
        let rubs = slides(contact, sense, &normal);
        forces.row_mut(contact).copy_from_slice(&normal.1);
        forces.row_mut(contacts + contact).copy_from_slice(&rubs);
    }
    forces
}
