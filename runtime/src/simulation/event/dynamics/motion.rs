//! The motion that the contact accelerations of a mode give, and the projection onto its surfaces.

use super::{Dynamics, rows, switching};
use crate::contact::{ContactState, Line, shares, stuck};
use crate::model::{contact_point, joint_rows};
use crate::simulation::event::dop853::System;

/// Newton steps of one projection; the second already meets rounding error after a step that passed
/// the error test.
const PROJECTIONS: usize = 6;

/// Whether the sliding velocity of a closed contact vanishes with those that the mode keeps zero, at the
/// points last evaluated.
pub(in crate::simulation) fn holds(dynamics: &Dynamics<'_>, contact: usize) -> bool {
    let state = ContactState::sticking(dynamics.is_in_space(contact));
    stuck(contact, state).all(|line| depends(dynamics, line))
}

/// Whether the normal velocity of an open contact vanishes with those that the mode keeps zero, at the points last
/// evaluated.
pub(in crate::simulation) fn keeps_apart(dynamics: &Dynamics<'_>, contact: usize) -> bool {
    depends(dynamics, Line::normal(contact))
}

/// The lines whose velocities the mode keeps zero.
pub(in crate::simulation) fn held(dynamics: &Dynamics<'_>) -> Vec<Line> {
    let normals = dynamics.mode.active.iter().map(|&i| Line::normal(i));
    normals
        .chain(dynamics.mode.sticking.iter().copied())
        .collect()
}

/// Whether the velocity of a line depends on those that the mode keeps zero.
fn depends(dynamics: &Dynamics<'_>, line: Line) -> bool {
    !shares::is_free(dynamics, &held(dynamics), line).unwrap_or(false)
}

/// Moves the state onto `g = 0`, `v_n = 0` of the active contacts and `v_t = 0` of the sticking ones,
/// along their directions `d` and `e`. `false` if it cannot.
///
/// Before that, in the metric of the mass matrix, onto the joints, which contacts leave as they are.
pub(in crate::simulation) fn project(dynamics: &mut Dynamics<'_>, t: f64, y: &mut [f64]) -> bool {
    hold(dynamics, t, y, false)
}

/// The same at an event: a flight too low to be told apart would end with an impact, whose friction is that of what slides.
pub(in crate::simulation) fn settle(dynamics: &mut Dynamics<'_>, t: f64, y: &mut [f64]) -> bool {
    hold(dynamics, t, y, true)
}

fn hold(dynamics: &mut Dynamics<'_>, t: f64, y: &mut [f64], friction: bool) -> bool {
    if !project_on_joints(dynamics, t, y) {
        return false;
    }
    if dynamics.mode.active.is_empty() {
        return true;
    }
    let n = dynamics.n;
    let normals = dynamics.mode.active.len();
    let mut previous = f64::INFINITY;
    for _ in 0..PROJECTIONS {
        dynamics.load(t, y);
        // Largest gap in units of what rounding leaves of it.
        let mut worst = 0.0_f64;
        for slot in 0..normals {
            let i = dynamics.mode.active[slot];
            dynamics.evaluate_contact(i);
            let gap = dynamics.point(i)[contact_point::GAP];
            dynamics.equations.right[slot] = -gap;
            if gap.is_nan() {
                return false;
            }
            let rounding = dynamics.gap_rounding(i).max(f64::MIN_POSITIVE);
            worst = worst.max(gap.abs() / rounding);
        }
        if worst <= 1.0 || worst >= previous {
            break;
        }
        previous = worst;
        if rows::solve_rows(dynamics, normals, false).is_none() {
            return false;
        }
        rows::push(dynamics, &mut y[..n]);
    }
    for slot in 0..normals {
        dynamics.equations.right[slot] =
            -dynamics.point(dynamics.mode.active[slot])[contact_point::NORMAL_VELOCITY];
    }
    if !dynamics.mode.sticking.is_empty() {
        dynamics.load(t, y);
    }
    for slot in 0..dynamics.mode.sticking.len() {
        let held = dynamics.mode.sticking[slot];
        dynamics.evaluate_tangent(held.contact());
        dynamics.equations.right[normals + slot] = -dynamics.velocity(held);
    }
    let rows = normals + dynamics.mode.sticking.len();
    if rows::solve_rows(dynamics, rows, friction).is_none() {
        return false;
    }
    rows::push(dynamics, &mut y[n..2 * n]);
    dynamics.load(t, y);
    true
}

/// Accelerations that the forces of joints take away at a state without contacts, each coordinate by its own inertia; none without joints.
pub(in crate::simulation) fn held_by_joints(
    dynamics: &mut Dynamics<'_>,
    t: f64,
    y: &[f64],
) -> Option<Vec<f64>> {
    let mut joints = dynamics.joints.take()?;
    let n = dynamics.n;
    dynamics.load(t, y);
    let x = dynamics.input().to_vec();
    joints.evaluate(&x);
    let mut forces = vec![0.0; joint_rows(dynamics.model)];
    dynamics.model.joint_forces(&x, &mut forces);
    let mut held = vec![0.0; n];
    for (&row, gradient) in joints.held().iter().zip(joints.gradients().chunks_exact(n)) {
        for (held, g) in held.iter_mut().zip(gradient) {
            *held += g * forces[row];
        }
    }
    let mass = dynamics.mass(t, y);
    for (k, held) in held.iter_mut().enumerate() {
        *held /= mass[k * n + k];
    }
    dynamics.joints = Some(joints);
    Some(held)
}

/// Moves the state onto the joints, in the metric of the mass matrix; `false` if it cannot.
pub(in crate::simulation) fn project_on_joints(
    dynamics: &mut Dynamics<'_>,
    t: f64,
    y: &mut [f64],
) -> bool {
    let Some(mut joints) = dynamics.joints.take() else {
        return true;
    };
    let n = dynamics.n;
    dynamics.load(t, y);
    let mut x = dynamics.input().to_vec();
    let moved = joints.settle(&mut x, 0.0);
    dynamics.joints = Some(joints);
    y[..2 * n].copy_from_slice(&x[..2 * n]);
    dynamics.load(t, y);
    moved.is_ok()
}

/// `dtau/dt = 1/p` of the time-freezing system with `a_bar`, `p = prod_i (1 - s_i p)`,
/// `s_i = r_i / a_bar` over the active contacts: the weight of the free dynamics is `p`, those of
/// the auxiliary dynamics `gamma_i = s_i p`.
fn speed_of_numerical_time(dynamics: &Dynamics<'_>) -> f64 {
    // Dry friction belongs to the free dynamics.
    let surfaces = || {
        let active = dynamics.mode.active.iter();
        active.filter(|&&i| !dynamics.is_dry(i))
    };
    let shares = || surfaces().map(|&i| dynamics.equations.r[i]);
    let sum: f64 = shares().map(|r| r / dynamics.auxiliary_acceleration).sum();
    if surfaces().count() < 2 {
        return 1.0 + sum;
    }
    // The residual p - prod(1 - s p) increases with p and 1 / (1 + sum s) lies below its root.
    let mut p = 1.0 / (1.0 + sum);
    for _ in 0..20 {
        let (mut product, mut slope) = (1.0, 0.0);
        for r in shares() {
            let s = r / dynamics.auxiliary_acceleration;
            slope = slope * (1.0 - s * p) - s * product;
            product *= 1.0 - s * p;
        }
        let step = (p - product) / (1.0 - slope);
        p -= step;
        if step.abs() <= 1e-15 {
            break;
        }
    }
    1.0 / p
}

impl System for Dynamics<'_> {
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) {
        let n = self.n;
        self.load(t, y);
        self.evaluate_free_acceleration();
        self.stay_near();
        dy[..n].copy_from_slice(&y[n..2 * n]);
        dy[n..2 * n].copy_from_slice(self.free_acceleration());
        dy[2 * n] = 1.0;
        let rows = rows::evaluate_rows(self);
        if rows > 0 {
            if let Some(sign) = rows::solve_rows(self, rows, true) {
                self.orientation = sign;
                rows::push(self, &mut dy[n..2 * n]);
                rows::share(self, rows);
            } else {
                self.equations.right[..rows].fill(f64::NAN);
                dy[n..2 * n].fill(f64::NAN);
            }
            rows::store_forces(self, rows);
            dy[2 * n] = speed_of_numerical_time(self);
        }
        switching::evaluate_switches(self, rows);
        if !self.mode.sticking.is_empty() {
            rows::refine(self, rows, &mut dy[n..2 * n]);
        }
        if let Some(function) = self
            .switching
            .values
            .iter()
            .position(|value| value.is_nan())
        {
            self.switching.undefined = Some(self.switch(function).contact());
        }
        for ((value, lowest), highest) in self
            .switching
            .values
            .iter()
            .zip(&mut self.switching.lowest)
            .zip(&mut self.switching.highest)
        {
            *lowest = lowest.min(*value);
            *highest = highest.max(*value);
        }
    }
}
