//! The values of the switching functions in a contact mode, and what counts as zero.

use super::switch::Switch;
use super::{Dynamics, rows};
use crate::linalg::products::dot;
use crate::model::contact_point;
use crate::simulation::event::dop853::System;
use crate::yardstick;

/// Sliding velocities up to this multiple of what counts as zero are those of a contact that others hold: it is held
/// by rounding error where the geometry keeps it, and slides where that was so at one instant only.
const HELD: f64 = 1e3;
/// Value of a switching function that is none.
const CONSTANT: f64 = 1.0;

/// Sets the sizes of forces to which others are compared, for the contacts given; contacts and free
/// acceleration are evaluated.
pub(in crate::simulation) fn set_force_floors(dynamics: &mut Dynamics<'_>, contacts: &[usize]) {
    let view = &dynamics.view;
    view.model.mass_matrix(&dynamics.x, &mut dynamics.mass);
    let a = view.free_acceleration();
    let square: f64 = dynamics
        .mass
        .chunks_exact(view.n.max(1))
        .zip(a)
        .map(|(row, a_k)| a_k * dot(row, a))
        .sum();
    for &i in contacts {
        let inverse_inertia = dynamics.point(i)[contact_point::INVERSE_INERTIA];
        let floor = f64::max(
            (inverse_inertia * square).max(0.0).sqrt(),
            dynamics.scales[i].acceleration(),
        );
        dynamics.switching.force_floor[i] = floor;
        dynamics.switching.accepted_pull[i] = 0.0;
        if let Some(slot) = dynamics
            .laws
            .frictional
            .iter()
            .position(|&other| other == i)
        {
            let first = dynamics.contacts + 2 * slot;
            let floor = (1.0 + dynamics.friction(i)) * floor;
            dynamics.switching.force_floor[first..first + 2].fill(floor);
            dynamics.switching.accepted_pull[first..first + 2].fill(0.0);
        }
    }
}

/// Accepts the contact forces last evaluated: one that is negative by rounding error, or for an instant only, is
/// no reason to leave a new mode again.
pub(in crate::simulation) fn accept_forces(dynamics: &mut Dynamics<'_>) {
    for function in 0..dynamics.functions() {
        if dynamics.switch(function).is_force() {
            let pull = -dynamics.switching.values[function];
            let accepted = &mut dynamics.switching.accepted_pull[function];
            *accepted = accepted.max(2.0 * pull);
        }
    }
}

/// Up to this a sliding velocity is that of a contact that others hold.
pub(in crate::simulation) fn held_velocity(dynamics: &Dynamics<'_>, contact: usize) -> f64 {
    HELD * dynamics.zero_sliding_velocity(contact)
}

/// What counts as zero for a switching function.
pub(in crate::simulation) fn zero_value(dynamics: &Dynamics<'_>, function: usize) -> f64 {
    match dynamics.switch(function) {
        Switch::Gap(i) => dynamics.closed_gap(i),
        Switch::SlidingVelocity(i, _) => dynamics.zero_sliding_velocity(i),
        Switch::NormalForce(_) | Switch::FrictionLimit(..) => (yardstick::ROUNDING
            * size(dynamics, function))
        .max(dynamics.switching.accepted_pull[function]),
        Switch::HeldVelocity(_) | Switch::Constant(_) => 0.0,
    }
}

/// Size of a switching function: the range of a gap, the terms of forces, the largest sliding velocity.
pub(in crate::simulation) fn size(dynamics: &Dynamics<'_>, function: usize) -> f64 {
    match dynamics.switch(function) {
        Switch::Gap(i) => dynamics.gap_range(i),
        Switch::SlidingVelocity(i, _) | Switch::HeldVelocity(i) => {
            dynamics.scales[i].sliding_velocity
        }
        Switch::NormalForce(_) | Switch::FrictionLimit(..) => {
            dynamics.switching.force_scale[function].max(dynamics.switching.force_floor[function])
        }
        Switch::Constant(_) => CONSTANT,
    }
}

/// Evaluates one switching function; `slope` is for the derivative, if it needs that.
pub(in crate::simulation) fn switching_value(
    dynamics: &mut Dynamics<'_>,
    function: usize,
    t: f64,
    y: &[f64],
    slope: &mut [f64],
) -> f64 {
    match dynamics.switch(function) {
        Switch::Gap(i) => {
            dynamics.load(t, y);
            dynamics.gap(i)
        }
        Switch::SlidingVelocity(i, direction) => {
            dynamics.load(t, y);
            dynamics.evaluate_tangent(i);
            direction.sign() * dynamics.sliding_velocity(i)
        }
        Switch::HeldVelocity(i) => {
            dynamics.load(t, y);
            dynamics.evaluate_tangent(i);
            held_velocity(dynamics, i) - dynamics.sliding_velocity(i).abs()
        }
        Switch::NormalForce(_) | Switch::FrictionLimit(..) => {
            dynamics.derivative(t, y, slope);
            dynamics.switching.values[function]
        }
        Switch::Constant(_) => CONSTANT,
    }
}

/// Writes the switching functions, once rows and contact accelerations are known, and the sizes of the
/// terms of those that are forces.
pub(super) fn evaluate_switches(dynamics: &mut Dynamics<'_>, rows: usize) {
    if !dynamics.switching.gaps_are_idle {
        for &i in dynamics.near.contacts() {
            if dynamics.mode.states[i].is_open() {
                let gap = dynamics
                    .view
                    .pieces
                    .gap(dynamics.view.model, i, &dynamics.x);
                dynamics.switching.values[i] = gap;
            }
        }
    }
    for slot in 0..dynamics.mode.active.len() {
        let i = dynamics.mode.active[slot];
        dynamics.switching.values[i] = dynamics.equations.r[i];
        dynamics.switching.force_scale[i] = rows::row_scale(dynamics, slot, rows);
    }
    for function in dynamics.contacts..dynamics.functions() {
        dynamics.switching.values[function] = match dynamics.switch(function) {
            Switch::FrictionLimit(i, _) if dynamics.is_in_space(i) => dynamics.friction_reserve(i),
            Switch::FrictionLimit(i, direction) => {
                dynamics.friction(i) * dynamics.equations.r[i]
                    + direction.sign() * dynamics.equations.s[i]
            }
            Switch::SlidingVelocity(i, direction) => {
                direction.sign() * dynamics.sliding_velocity(i)
            }
            Switch::HeldVelocity(i) => {
                held_velocity(dynamics, i) - dynamics.sliding_velocity(i).abs()
            }
            _ => CONSTANT,
        };
    }
    for slot in 0..dynamics.mode.sticking.len() {
        let i = dynamics.mode.sticking[slot].contact();
        let scale = dynamics.friction(i) * dynamics.switching.force_scale[i]
            + rows::row_scale(dynamics, dynamics.mode.active.len() + slot, rows);
        let first = dynamics
            .laws
            .frictional
            .iter()
            .position(|&other| other == i)
            .map_or(0, |slot| dynamics.contacts + 2 * slot);
        dynamics.switching.force_scale[first..first + 2].fill(scale);
    }
}
