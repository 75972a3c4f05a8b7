//! Derivatives of what a scene records.

use super::mode::Acceleration;
use super::tangent::{Matrix, Tangent, add};
use crate::contact::Line;
use crate::model::{contact_point, joint_rows};
use crate::simulation::Instant;

/// Derivatives of the outputs at an instant, a row an output. The `acceleration` is evaluated there.
pub(super) fn outputs(
    acceleration: &Acceleration<'_>,
    instant: Instant<'_>,
    tangent: &Tangent,
) -> Matrix {
    let (model, layout) = (acceleration.model, tangent.layout);
    let columns = tangent.all.columns;
    let (_, forces) = forces(acceleration, tangent);
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
    let [x, values] = instant.read(model);
    derivatives.outputs(&x, &values, &mut by.values);
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

/// Forces of all contacts, normal ones and then tangential ones, that provide these accelerations along the lines of a mode, or impulses that
/// provide velocities, and how they change where that does by the rows of `changes`, functions of the scene as `of` says.
pub(super) fn of_contacts(
    acceleration: &Acceleration<'_>,
    (provided, changes): (&[f64], &Matrix),
    tangent: &Tangent,
    of: impl Fn(&[f64]) -> Vec<f64>,
) -> (Vec<f64>, Matrix) {
    let contacts = acceleration.model.declaration().contacts.len();
    let mut forces = vec![0.0; 2 * contacts];
    let mut by = Matrix::zeros(2 * contacts, changes.columns);
    for (j, &line) in acceleration.lines.iter().enumerate() {
        let contact = line.contact();
        let (inertia, inertia_by) = acceleration.point(contact, contact_point::INVERSE_INERTIA);
        let force = provided[j] / inertia;
        let mut change = changes.row(j).to_vec();
        if force != 0.0 {
            add(&mut change, -force, &of(inertia_by));
        }
        change.iter_mut().for_each(|by| *by /= inertia);
        let Line::Normal { slope, .. } = line else {
            forces[contacts + contact] = force;
            add(by.row_mut(contacts + contact), 1.0, &change);
            continue;
        };
        forces[contact] = force;
        add(by.row_mut(contact), 1.0, &change);
        if slope != 0.0 {
            let (mu, mu_by) = acceleration.friction(contact);
            forces[contacts + contact] = slope * force;
            let rubs = by.row_mut(contacts + contact);
            add(rubs, slope, &change);
            add(rubs, slope / mu * force, &tangent.of_parameters(mu_by));
        }
    }
    (forces, by)
}

/// Those where the `acceleration` is evaluated.
pub(super) fn forces(acceleration: &Acceleration<'_>, tangent: &Tangent) -> (Vec<f64>, Matrix) {
    let mut changes = Matrix::zeros(acceleration.lines.len(), tangent.all.columns);
    for j in 0..acceleration.lines.len() {
        let by = tangent.of(acceleration.forces_by.row(j));
        changes.row_mut(j).copy_from_slice(&by);
    }
    let provided = (&acceleration.forces[..], &changes);
    of_contacts(acceleration, provided, tangent, |by| tangent.of(by))
}
