//! What decides the mode of a contact: its friction, and how it slides.

use super::model_input::drive;
use super::sequence::Switch;
use crate::model::{Model, Switching, tangent_point};
use crate::simulation::{ContactMode, Direction};
use crate::yardstick;

/// The mode of a closed contact without friction, or of one that slides at `velocity`.
pub(in crate::ocp) fn closed_mode(frictional: bool, velocity: f64, zero: f64) -> ContactMode {
    if !frictional {
        ContactMode::Frictionless
    } else if velocity.abs() <= zero {
        ContactMode::Stick
    } else {
        ContactMode::Slip(Direction::of(velocity))
    }
}

/// Whether a contact is a switch that is only passed: nothing holds its function at zero.
pub(in crate::ocp) fn is_passed(model: &dyn Model, contact: usize) -> bool {
    let switch = model.declaration().contacts[contact].switch;
    switch.is_some_and(Switching::passes)
}

/// Whether a contact is a condition that sets velocities where it comes true.
pub(in crate::ocp) fn is_condition(model: &dyn Model, contact: usize) -> bool {
    model.declaration().contacts[contact].switch == Some(Switching::Resets)
}

/// Whether velocities are set at a switch.
pub(in crate::ocp) fn sets(model: &dyn Model, switch: &Switch) -> bool {
    // Its friction is against minus the function, which comes to be positive where it begins to slip backward.
    let comes_true = switch.mode == ContactMode::Slip(Direction::Backward);
    is_condition(model, switch.contact) && (switch.sets || comes_true)
}

/// Whether friction acts on a contact.
pub(in crate::ocp) fn is_frictional(model: &dyn Model, contact: usize) -> bool {
    let declared = model.declaration().contacts[contact].friction;
    declared.is_some() && model.friction(contact) > 0.0
}

/// Sliding velocity of a contact with friction at a time and `x`, which starts with `(q, v)`.
pub(in crate::ocp) fn sliding_velocity(
    model: &dyn Model,
    contact: usize,
    x: &[f64],
    time: f64,
) -> f64 {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let mut point = vec![0.0; tangent_point::length(n)];
    let mut input = x[..2 * n].to_vec();
    let controls = vec![0.0; declaration.controls.len()];
    input.extend(drive(model, &controls, time));
    model.tangent(contact, &input, &mut point);
    point[tangent_point::SLIDING_VELOCITY]
}

/// Sliding velocities of a state `(q, v)` below this are zero, where velocities of the motion are of the order of `usual`.
pub(in crate::ocp) fn zero_velocity(v: &[f64], usual: f64) -> f64 {
    yardstick::NOTHING * v.iter().fold(usual, |largest: f64, v| largest.max(v.abs()))
}
