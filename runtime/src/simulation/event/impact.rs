//! The impact law of contacts that are struck together, and the end of sequences of bounces.

use super::contact_problem::ContactProblem;
use super::dop853::System;
use super::dynamics::{Dynamics, dot, largest};
use crate::contact::impact::{self, Blow};
use crate::contact::{Balance, Line, View};
use crate::model::contact_point;

/// Bounces lower than this share of the range of a gap are left out, and those lower than ten times a closed gap.
const LOWEST_BOUNCE: f64 = 1e-11;

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

/// An impact with its impulses.
pub(super) struct Struck {
    balance: Balance,
    returned: Vec<f64>,
}

impl Struck {
    /// Adds the jump to the velocities `v`.
    pub(super) fn carry_out(&self, view: &View<'_>, v: &mut [f64]) {
        let mut change = vec![0.0; v.len()];
        self.balance.push(view, &self.balance.forces, &mut change);
        for (v, change) in v.iter_mut().zip(change) {
            *v += change;
        }
    }

    /// The largest normal impulse.
    pub(super) fn impulse(&self) -> f64 {
        largest(self.balance.normals())
    }
}

/// The only impact of the contacts `together`, which are evaluated, with a coefficient of `restitution` each; `zeros` are the normal and
/// sliding velocities of all contacts that are none.
pub(super) fn blow(
    view: &View<'_>,
    together: &[usize],
    restitution: &[f64],
    zeros: &[(f64, f64)],
) -> Result<Struck, Undetermined> {
    let Blow {
        touching,
        offsets,
        returned,
    } = Blow::new(view, together, restitution, |line| match line {
        Line::Normal { contact, .. } => zeros[contact].0,
        _ => zeros[line.contact()].1,
    });
    let problem = ContactProblem {
        what: "impact",
        touching,
        offsets,
    };
    match problem.solve(view) {
        Ok(balance) => Ok(Struck { balance, returned }),
        Err(message) => Err(Undetermined {
            contact: together.first().copied().unwrap_or_default(),
            message,
        }),
    }
}

/// Changes the velocities in `y` by the impulses of the law, at the contacts `closed`, which are evaluated. Returns their normal
/// velocities afterwards.
pub(super) fn strike(
    dynamics: &mut Dynamics<'_>,
    y: &mut [f64],
    closed: &[usize],
    outcome: &mut Impact,
) -> Result<Vec<f64>, Undetermined> {
    let n = dynamics.n;
    let bounces = |i: usize| outcome.ended.iter().all(|end| end.contact != i);
    let restitution = |&i: &usize| {
        if bounces(i) {
            dynamics.laws.restitution[i]
        } else {
            0.0
        }
    };
    let restitution: Vec<f64> = closed.iter().map(restitution).collect();
    let struck = blow(dynamics, closed, &restitution, &dynamics.zero_velocities());
    let struck = struck.map_err(|error| Undetermined {
        contact: outcome.struck.first().copied().unwrap_or_default(),
        ..error
    })?;
    let elastic = struck.returned.iter().any(|&velocity| velocity > 0.0);
    let passive = elastic && !closed.iter().any(|&i| dynamics.ground_moves(i));
    let mut x = dynamics.input().to_vec();
    let before = if passive {
        dynamics.kinetic_energy(&x)
    } else {
        0.0
    };
    struck.carry_out(dynamics, &mut y[n..2 * n]);
    if passive {
        x[n..2 * n].copy_from_slice(&y[n..2 * n]);
        outcome.energy_gain = impact::gain(before, dynamics.kinetic_energy(&x));
    }
    outcome.impulse = struck.impulse();
    Ok(impact::velocities_after(&struck.balance, &struck.returned).collect())
}

/// Contacts that are closed, evaluated.
pub(super) fn closed_contacts(
    dynamics: &mut Dynamics<'_>,
    t: f64,
    y: &[f64],
    closing: Option<usize>,
) -> Vec<usize> {
    dynamics.load(t, y);
    dynamics.stay_near();
    let mut closed = Vec::new();
    for i in dynamics.near().to_vec() {
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
