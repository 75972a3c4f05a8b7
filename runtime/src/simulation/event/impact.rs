//! The impact law of contacts that are struck together, and the end of sequences of bounces.

use super::contact_problem::ContactProblem;
use super::dop853::System;
use super::dynamics::{Dynamics, dot, largest};
use crate::contact::{Line, Touching};
use crate::model::{contact_point, pair_size};

/// Bounces lower than this share of the range of a gap are left out, and those lower than ten times a closed gap.
const LOWEST_BOUNCE: f64 = 1e-11;
/// Kinetic energies are compared to this relative accuracy.
const SAME_ENERGY: f64 = 1e-12;

/// Why no contact mode could be found.
#[derive(Debug, Clone)]
pub(in crate::simulation) struct Undetermined {
    pub(in crate::simulation) contact: usize,
    pub(in crate::simulation) message: String,
}

/// Which bounces are left out.
#[derive(Debug, Clone, Copy)]
pub(in crate::simulation) struct LowestBounce {
    /// Normal velocity below which a contact no longer bounces; by default that of a bounce as high as
    /// `height`.
    pub(in crate::simulation) velocity: Option<f64>,
    /// Height relative to the range of the gap so far.
    pub(in crate::simulation) height: f64,
}

/// A bounce that was left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::simulation) struct EndOfBounces {
    pub(in crate::simulation) contact: usize,
    /// Normal velocity before the impact, not negative.
    pub(in crate::simulation) speed: f64,
    /// How high the bounce would have been; infinite if nothing pulls the contact back.
    pub(in crate::simulation) height: f64,
}

/// Outcome of the impact law.
#[derive(Debug, Clone, Default)]
pub(in crate::simulation) struct Impact {
    /// Contacts whose gap closed with a velocity, increasing.
    pub(in crate::simulation) struck: Vec<usize>,
    /// Closed contacts that are at rest afterwards, or whose next flight is too low to be one,
    /// increasing.
    pub(in crate::simulation) resting: Vec<usize>,
    /// Largest of the impulses `p_i`, in units of a normal velocity.
    pub(in crate::simulation) impulse: f64,
    /// Contacts with restitution that were struck and stay.
    pub(in crate::simulation) ended: Vec<EndOfBounces>,
    /// Whether the impacts have been carried out one after the other.
    pub(in crate::simulation) in_turn: bool,
    /// What a user should know of a cluster of impacts.
    pub(in crate::simulation) cluster: Option<&'static str>,
    /// Kinetic energy before and after, if the law has raised it on ground at rest.
    pub(in crate::simulation) energy_gain: Option<(f64, f64)>,
}

/// Whether a closed contact with this normal velocity stays: it has none, or its flight is too low to be one.
pub(super) fn rests(
    dynamics: &mut Dynamics<'_>,
    contact: usize,
    velocity: f64,
    never_open: bool,
) -> bool {
    dynamics.evaluate_contact(contact);
    let (acceleration, _) = dynamics.free_normal_acceleration(contact);
    let highest = if never_open {
        dynamics.closed_gap(contact)
    } else {
        dynamics.lowest_flight(contact)
    };
    let room = highest - dynamics.point(contact)[contact_point::GAP];
    let returns = velocity > 0.0 && velocity * velocity <= -2.0 * acceleration * room;
    velocity.abs() <= dynamics.zero_normal_velocity(contact) || returns
}

/// Changes the velocities in `y` by the impulses of the law, at the contacts `closed` with the normal `velocities`.
/// Returns their normal velocities afterwards.
pub(super) fn strike(
    dynamics: &mut Dynamics<'_>,
    y: &mut [f64],
    closed: &[usize],
    velocities: &[f64],
    outcome: &mut Impact,
) -> Result<Vec<f64>, Undetermined> {
    let n = dynamics.n;
    // Velocities that the law sends back, `-e v_n-`.
    let returned: Vec<f64> = closed
        .iter()
        .zip(velocities)
        .map(|(&i, &velocity)| {
            if velocity < 0.0 && outcome.ended.iter().all(|end| end.contact != i) {
                -dynamics.laws.restitution[i] * velocity
            } else {
                0.0
            }
        })
        .collect();
    let touching = Touching::new(dynamics, closed, |_| true);
    let sliding = |i: usize| {
        let velocity = dynamics.sliding(i);
        let slides = pair_size(velocity) > dynamics.zero_sliding_velocity(i);
        if slides { velocity } else { (0.0, 0.0) }
    };
    let offsets = touching
        .lines
        .iter()
        .enumerate()
        .map(|(k, &line)| match line {
            Line::Normal { .. } => velocities[k] - returned[k],
            Line::Tangent { contact, .. } => sliding(contact).0,
            Line::Across { contact } => sliding(contact).1,
        });
    let problem = ContactProblem {
        what: "impact",
        offsets: offsets.collect(),
        touching,
    };
    let balance = problem.solve(dynamics).map_err(|message| Undetermined {
        contact: outcome.struck.first().copied().unwrap_or_default(),
        message,
    })?;
    let elastic = returned.iter().any(|&velocity| velocity > 0.0);
    let passive = elastic && !closed.iter().any(|&i| dynamics.ground_moves(i));
    let before = if passive {
        dynamics.kinetic_energy(y)
    } else {
        0.0
    };
    let mut change = vec![0.0; n];
    balance.push(dynamics, &balance.forces, &mut change);
    for (v, change) in y[n..2 * n].iter_mut().zip(change) {
        *v += change;
    }
    if passive {
        let after = dynamics.kinetic_energy(y);
        outcome.energy_gain = (after > before * (1.0 + SAME_ENERGY)).then_some((before, after));
    }
    outcome.impulse = largest(balance.normals());
    let motions = balance.motions.iter().zip(&returned);
    Ok(motions
        .map(|(velocity, returned)| velocity + returned)
        .collect())
}

/// Contacts that are closed, evaluated.
pub(super) fn closed_contacts(
    dynamics: &mut Dynamics<'_>,
    t: f64,
    y: &[f64],
    closing: Option<usize>,
) -> Vec<usize> {
    dynamics.load(t, y);
    let mut closed = Vec::new();
    for i in 0..dynamics.contacts {
        if dynamics.pieces.is_idle(i) {
            continue;
        }
        dynamics.evaluate_sides(i);
        let gap = dynamics.point(i)[contact_point::GAP];
        if gap <= dynamics.closed_gap(i) || closing == Some(i) || dynamics.is_active(i) {
            closed.push(i);
        }
    }
    closed
}

/// Struck contacts with restitution whose bounces have become too low. How high the next one would be depends
/// on what presses the contact in the present mode.
pub(super) fn ended_bounces(
    dynamics: &mut Dynamics<'_>,
    t: f64,
    y: &[f64],
    struck: &[usize],
    lowest: LowestBounce,
) -> Vec<EndOfBounces> {
    if struck.iter().all(|&i| dynamics.laws.restitution[i] == 0.0) {
        return Vec::new();
    }
    let presses = presses(dynamics, t, y, struck);
    let pressed = struck.iter().zip(presses);
    pressed
        .filter_map(|(&i, press)| {
            let e = dynamics.laws.restitution[i];
            let speed = -dynamics.point(i)[contact_point::NORMAL_VELOCITY];
            let last = lowest_speed(dynamics, i, press, lowest);
            (e > 0.0 && speed <= last).then(|| EndOfBounces {
                contact: i,
                speed,
                height: if press > 0.0 {
                    (e * speed).powi(2) / (2.0 * press)
                } else {
                    f64::INFINITY
                },
            })
        })
        .collect()
}

/// Normal accelerations with which the present mode presses the contacts on their surfaces.
fn presses(dynamics: &mut Dynamics<'_>, t: f64, y: &[f64], contacts: &[usize]) -> Vec<f64> {
    let n = dynamics.n;
    let mut slope = vec![0.0; y.len()];
    dynamics.derivative(t, y, &mut slope);
    contacts
        .iter()
        .map(|&i| {
            let curvature = dynamics.point(i)[contact_point::CURVATURE];
            -(curvature + dot(dynamics.normal(i), &slope[n..2 * n]))
        })
        .collect()
}

/// Speed up to which a contact that is pressed on its surface with the acceleration `press` does not bounce.
fn lowest_speed(dynamics: &Dynamics<'_>, contact: usize, press: f64, lowest: LowestBounce) -> f64 {
    let height = (lowest.height.max(LOWEST_BOUNCE) * dynamics.gap_range(contact))
        .max(10.0 * dynamics.closed_gap(contact));
    lowest
        .velocity
        .unwrap_or_else(|| (2.0 * press.max(0.0) * height).sqrt())
}

/// Speeds up to which the contacts do not bounce.
pub(super) fn lowest_speeds(
    dynamics: &mut Dynamics<'_>,
    t: f64,
    y: &[f64],
    contacts: &[usize],
    lowest: LowestBounce,
) -> Vec<f64> {
    let presses = presses(dynamics, t, y, contacts);
    let pressed = contacts.iter().zip(presses);
    pressed
        .map(|(&i, press)| lowest_speed(dynamics, i, press, lowest))
        .collect()
}
