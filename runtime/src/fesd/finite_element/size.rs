//! How large the system of an element is: the entries of its assembled matrix.

use super::{FiniteElement, State, assembly, newton};
use crate::contact::ActiveContact;
use crate::model::{ControlPiece, Model, surfaces};
use crate::size::{Purpose, SizeGroup, Tally};

/// Purposes of the unknowns of a stage, which are those of its equations: accelerations, forces, corrections.
fn purposes(element: &FiniteElement<'_>) -> Vec<Purpose> {
    let (n, constraints) = (element.n, &element.constraints);
    let normals = constraints.positions();
    let mut purposes = vec![Purpose::State; n];
    purposes.resize(n + normals, Purpose::ContactForce);
    purposes.resize(n + constraints.count(), Purpose::Friction);
    purposes.resize(element.block(), Purpose::Gap);
    purposes
}

/// Adds the rows of joints that are held at the end of an element, each with what it moves the state by.
fn add_joints(tally: &mut Tally, model: &dyn Model) {
    let Some(joints) = model.declaration().joints else {
        return;
    };
    let rows = joints.equations().enumerate();
    let held: Vec<bool> = rows
        .filter(|&(row, _)| model.joint_row_held(row))
        .map(|(_, (joint, _))| joint.holonomic)
        .collect();
    let positions = held.iter().filter(|holonomic| **holonomic).count();
    let size = tally.of(Purpose::Joint);
    size.variables += held.len() + positions;
    size.equalities += held.len() + positions;
    // One small matrix moves both.
    size.jacobian_nonzeros += held.len() * held.len();
}

/// Adds the signs that are watched of contacts.
fn add_signs(tally: &mut Tally, model: &dyn Model, active: &[ActiveContact], stages: usize) {
    let surfaces = surfaces(model);
    // One sign of the gap or the force of each contact is watched, and one of each friction.
    for contact in 0..model.declaration().contacts.len() {
        let held = active.iter().find(|held| held.contact == contact);
        if contact < surfaces {
            let sign = held.map_or(Purpose::Gap, |_| Purpose::ContactForce);
            tally.of(sign).inequalities += stages;
        }
        if held.is_some_and(|held| held.state.rubs()) {
            tally.of(Purpose::Friction).inequalities += stages;
        }
    }
}

/// The groups of an element in its contact mode from a `start`, a place where nothing vanishes by chance, to one that long.
pub(crate) fn groups(
    element: &mut FiniteElement<'_>,
    start: &State,
    (length, controls): (f64, &ControlPiece),
) -> Vec<SizeGroup> {
    // Where there is no such motion the first matrix is that of its stages.
    let _ = newton::solve(element, start, length, controls);
    assembly::assemble(element);
    let (model, stages) = (element.model, element.tableau.stages());
    let purposes = purposes(element);
    let mut tally = Tally::default();
    for &purpose in &purposes {
        let size = tally.of(purpose);
        size.variables += stages;
        size.equalities += stages;
    }
    let of = |place: usize| purposes[place % purposes.len()];
    let size = stages * purposes.len();
    for (place, _) in element
        .matrix
        .iter()
        .enumerate()
        .filter(|(_, entry)| **entry != 0.0)
    {
        tally
            .of(of(place / size).max(of(place % size)))
            .jacobian_nonzeros += 1;
    }
    let active = element.active().to_vec();
    add_signs(&mut tally, model, &active, stages);
    add_joints(&mut tally, model);
    tally.groups()
}
