//! How the time of an event changes: what vanishes there goes on doing so.
//!
//! With the function `c` that the event is a zero of, its derivative `c_p` at a fixed time and its rate `c'` along the motion
//! before, the time changes by `-c_p / c'`.

use super::acceleration::{Acceleration, Hold};
use super::matrix::{Matrix, add};
use super::wanted::Wanted;
use crate::model::{contact_point, tangent_point};
use crate::simulation::{ContactMode, Event, EventKind};

/// Rate of what vanishes at an event, relative to the sizes of its terms, below which it is touched and not crossed.
const GRAZING: f64 = 1e-7;
/// Share of the sizes of its terms that a vanishing force or sliding velocity may have.
pub(super) const VANISHED: f64 = 1e-5;
/// Relative difference of times of events found together that are no coincidence.
const APART: f64 = 1e-6;

/// Where an event is: the motion before it.
pub(super) struct Before<'b> {
    pub(super) modes: &'b [ContactMode],
    pub(super) v: &'b [f64],
    pub(super) control_rates: &'b [f64],
    /// Derivatives of `(q, v)` at a fixed time.
    pub(super) state: &'b Matrix,
    /// Largest normal velocity of each contact in the whole motion.
    pub(super) closing_speeds: &'b [f64],
    /// Largest coordinate and velocity in the whole motion.
    pub(super) sizes: [f64; 2],
    /// Whether events that quantities take apart are refused.
    pub(super) checked: bool,
}

impl Before<'_> {
    /// Size of the terms of a function with these derivatives by the input vector `x` at a time.
    fn size(&self, by: &[f64], (x, time): (&[f64], f64)) -> f64 {
        terms(self.sizes, self.v.len(), by, (x, time))
    }
}

/// Size of the terms of a function of `n` coordinates with these derivatives by the input vector `x` at a time, in a motion of these sizes.
pub(super) fn terms(
    [place, speed]: [f64; 2],
    n: usize,
    by: &[f64],
    (x, time): (&[f64], f64),
) -> f64 {
    let of = |i: usize| match i {
        i if i < n => place,
        i if i < 2 * n => speed,
        i => x[i].abs().max(time),
    };
    let sizes = (0..x.len()).map(|i| by[i].abs() * of(i));
    sizes.sum()
}

/// A function that vanishes at an event.
struct Zero {
    value: f64,
    by: Vec<f64>,
    /// Size of its rate that counts as crossing, besides the terms of the rate.
    rate: f64,
    /// Size of its terms.
    size: f64,
}

/// Derivatives of the time of the events found together; none if nothing that vanishes there moves it. The `acceleration` is
/// evaluated in the mode before.
///
/// # Errors
/// Why there are none.
pub(super) fn time(
    acceleration: &mut Acceleration<'_>,
    wanted: &Wanted,
    x: &[f64],
    events: &[Event],
    before: &Before<'_>,
) -> Result<Option<Vec<f64>>, String> {
    let mut found: Option<(Vec<f64>, &Event)> = None;
    let jumps = events.iter().any(|event| event.kind == EventKind::Impact);
    for event in events {
        let causes = matches!(
            event.kind,
            EventKind::Impact | EventKind::Contact | EventKind::When
        );
        // What else happens in an impact follows from it.
        if jumps && !causes {
            continue;
        }
        let Some(zero) = zero(acceleration, x, event, before) else {
            continue;
        };
        if zero.value.abs() > VANISHED * zero.size {
            continue;
        }
        let (rate, terms) = acceleration.rate(&zero.by, before.v, before.control_rates);
        if rate.abs() <= GRAZING * terms.max(zero.rate) {
            return Err(format!(
                "at t = {} s `{}` only grazes: the time of this {} has no derivative",
                event.time, event.contact_name, event.kind
            ));
        }
        let moved = |k| -wanted.along(&zero.by, before.state, k) / rate;
        let times: Vec<f64> = (0..wanted.count()).map(moved).collect();
        match &found {
            Some((first, other)) if before.checked && differ(first, &times) => {
                return Err(format!(
                    "at t = {} s `{}` and `{}` change at once, which other parameters take apart: which of them is first \
                     decides the motion",
                    event.time, other.contact_name, event.contact_name
                ));
            }
            Some(_) => {}
            None => found = Some((times, event)),
        }
    }
    Ok(found.map(|(times, _)| times))
}

fn differ(one: &[f64], other: &[f64]) -> bool {
    let mut pairs = one.iter().zip(other);
    let largest = one
        .iter()
        .chain(other)
        .fold(0.0_f64, |most, t| most.max(t.abs()));
    pairs.any(|(one, other)| (one - other).abs() > APART * largest)
}

/// What vanishes at an event, if something of its own does.
fn zero(
    acceleration: &mut Acceleration<'_>,
    x: &[f64],
    event: &Event,
    before: &Before<'_>,
) -> Option<Zero> {
    let contact = event.contact;
    let mode = before.modes.get(contact).copied()?;
    match (event.kind, mode) {
        (EventKind::Impact | EventKind::Contact, ContactMode::Open) => {
            acceleration.load_contact(contact, x);
            let (_, by) = acceleration.point(contact, contact_point::GAP);
            Some(Zero {
                value: 0.0,
                by: by.to_vec(),
                rate: before.closing_speeds[contact],
                size: f64::INFINITY,
            })
        }
        (EventKind::LiftOff, mode) if mode != ContactMode::Open => {
            let (value, by) = acceleration.force(contact, false)?;
            let curvature = acceleration.point(contact, contact_point::CURVATURE).0;
            // Where what acts without the contact vanishes with its force, that says nothing of its terms.
            let terms = before.size(by, (x, event.time));
            let size = force_size(acceleration, contact, false).max(curvature.abs());
            Some(Zero {
                value,
                by: by.to_vec(),
                rate: 0.0,
                size: size.max(terms),
            })
        }
        (EventKind::Slide | EventKind::Switch | EventKind::When, ContactMode::Slip(_)) => {
            let (value, by) = acceleration.tangent(contact, tangent_point::SLIDING_VELOCITY);
            Some(Zero {
                value,
                by: by.to_vec(),
                rate: 0.0,
                size: before.size(by, (x, event.time)),
            })
        }
        (EventKind::Stick | EventKind::Slip, ContactMode::Slip(_)) => {
            let n = acceleration.n;
            let (value, by) = acceleration.tangent(contact, tangent_point::SLIDING_VELOCITY);
            let terms = by[n..2 * n].iter().map(|by| by.abs() * before.sizes[1]);
            Some(Zero {
                value,
                size: terms.sum(),
                by: by.to_vec(),
                rate: 0.0,
            })
        }
        (EventKind::Slip | EventKind::Switch, ContactMode::Stick) => {
            friction_limit(acceleration, event)
        }
        _ => None,
    }
}

/// Size of the terms that a force balances.
pub(super) fn force_size(acceleration: &Acceleration<'_>, contact: usize, tangential: bool) -> f64 {
    let hold = if tangential {
        Hold::Tangent { contact }
    } else {
        Hold::Normal {
            contact,
            sense: 0.0,
        }
    };
    let terms = acceleration.free.iter().enumerate();
    terms
        .map(|(k, a)| (a * acceleration.covector(hold, k).0).abs())
        .sum()
}

/// The friction that a sticking contact has left, in the direction in which it gives way.
fn friction_limit(acceleration: &Acceleration<'_>, event: &Event) -> Option<Zero> {
    let contact = event.contact;
    let ContactMode::Slip(direction) = event.modes.get(contact).copied()? else {
        return None;
    };
    let (value, by, size) = friction_left(acceleration, contact, direction.sign())?;
    Some(Zero {
        value,
        by,
        rate: 0.0,
        size,
    })
}

/// The friction force of a sticking contact and what the law allows against this sense, whose sum vanishes where it gives way in it,
/// with the derivatives of that sum and the size of its terms; none where the forces are not those of the mode.
pub(super) fn friction_left(
    acceleration: &Acceleration<'_>,
    contact: usize,
    sense: f64,
) -> Option<(f64, Vec<f64>, f64)> {
    let (friction, friction_by) = acceleration.force(contact, true)?;
    let mut by = friction_by.to_vec();
    let (mu, mu_by) = acceleration.friction(contact);
    let given = acceleration.model.declaration().contacts[contact].dry;
    let (normal, factor, normal_by) = if given {
        let (curvature, by) = acceleration.point(contact, contact_point::CURVATURE);
        (-curvature, -1.0, by)
    } else {
        let (normal, by) = acceleration.force(contact, false)?;
        (normal, 1.0, by)
    };
    add(&mut by, sense * mu * factor, normal_by);
    let parameters = by.len() - mu_by.len();
    add(&mut by[parameters..], sense * normal, mu_by);
    let size = friction.abs() + mu * normal.abs();
    Some((friction + sense * mu * normal, by, size))
}
