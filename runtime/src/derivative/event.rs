//! How the time of an event changes: what vanishes there goes on doing so.
//!
//! With the function `c` that the event is a zero of, its derivative `c_p` at a fixed time and its rate `c'` along the motion
//! before, the time changes by `-c_p / c'`.

use super::mode::{Acceleration, Hold};
use super::tangent::{Tangent, add};
use crate::model::{contact_point, tangent_point};
use crate::simulation::{ContactMode, Event, EventKind};

/// Rate of what vanishes at an event, relative to the sizes of its terms, below which it is touched and not crossed.
const GRAZING: f64 = 1e-7;
/// Share of the sizes of its terms that a vanishing force or sliding velocity may have.
pub(super) const VANISHED: f64 = 1e-5;
/// Share of its terms by which the derivative of what is only touched counts as one.
const MOVED: f64 = 1e-6;

/// Where an event is: the motion before it.
pub(super) struct Before<'b> {
    pub(super) modes: &'b [ContactMode],
    /// Rates of everything along the motion.
    pub(super) rates: &'b [f64],
    /// Derivatives at a fixed time.
    pub(super) tangent: &'b Tangent,
    /// Largest normal velocity of each contact in the whole motion.
    pub(super) closing_speeds: &'b [f64],
    /// Largest coordinate and velocity in the whole motion.
    pub(super) sizes: [f64; 2],
}

impl Before<'_> {
    /// Size of the terms of a function with these derivatives by the input vector `x` at a time.
    fn size(&self, by: &[f64], (x, time): (&[f64], f64)) -> f64 {
        terms(self.sizes, self.tangent.layout.n, by, (x, time))
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

/// How the time of an event changes.
pub(super) struct Cause<'e> {
    pub(super) event: &'e Event,
    /// By column.
    pub(super) times: Vec<f64>,
    /// Columns by which it has no derivative, as what vanishes is only touched.
    pub(super) grazed: Vec<bool>,
}

/// How the times of the events found together change, of those that something of their own causes. The `acceleration` is evaluated in the mode
/// before.
pub(super) fn causes<'e>(
    acceleration: &mut Acceleration<'_>,
    x: &[f64],
    events: &'e [Event],
    before: &Before<'_>,
) -> Vec<Cause<'e>> {
    let jumps = events.iter().any(|event| event.kind == EventKind::Impact);
    let happens = |event: &&Event| {
        // What else happens in an impact follows from it.
        let causes = matches!(
            event.kind,
            EventKind::Impact | EventKind::Contact | EventKind::When
        );
        !jumps || causes
    };
    let events = events.iter().filter(happens);
    events
        .filter_map(|event| cause(acceleration, x, event, before))
        .collect()
}

/// How the time of one event changes; none if nothing that vanishes there moves it.
pub(super) fn cause<'e>(
    acceleration: &mut Acceleration<'_>,
    x: &[f64],
    event: &'e Event,
    before: &Before<'_>,
) -> Option<Cause<'e>> {
    let zero = zero(acceleration, x, event, before)?;
    if zero.value.abs() > VANISHED * zero.size {
        return None;
    }
    let (rate, terms) = before.tangent.layout.rate(&zero.by, before.rates);
    let mut times = before.tangent.of(&zero.by);
    let mut grazed = vec![false; times.len()];
    if rate.abs() <= GRAZING * terms.max(zero.rate) {
        let sizes = before.tangent.sizes(&zero.by);
        for ((grazed, change), size) in grazed.iter_mut().zip(&mut times).zip(sizes) {
            *grazed = change.abs() > MOVED * size;
            *change = 0.0;
        }
    } else {
        times.iter_mut().for_each(|change| *change /= -rate);
    }
    Some(Cause {
        event,
        times,
        grazed,
    })
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
