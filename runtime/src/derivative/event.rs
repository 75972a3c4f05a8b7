//! How the time of an event changes: what vanishes there goes on doing so.
//!
//! With the function `c` that the event is a zero of, its derivative `c_p` at a fixed time and its rate `c'` along the motion
//! before, the time changes by `-c_p / c'`.

use super::mode::Acceleration;
use super::place::{Place, VANISHED};
use super::tangent::{Tangent, add};
use crate::contact::sum_of_sizes;
use crate::model::{contact_point, tangent_point};
use crate::simulation::{ContactMode, Event, EventKind};
use crate::yardstick;

/// Rate of what vanishes at an event, relative to the sizes of its terms, below which it is touched and not crossed.
const GRAZING: f64 = 1e-7;
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

/// Rates of everything along the motion before an event, those that derivatives have ([`Walk::flow`](super::walk::Walk)), and derivatives at a
/// fixed time.
type Before<'b> = ([&'b [f64]; 2], &'b Tangent);

/// How the times of the events found together change, of those that something of their own causes. The acceleration is evaluated in the mode
/// before.
pub(super) fn causes<'e>(
    at: &mut Place<'_>,
    x: &[f64],
    events: &'e [Event],
    before: Before<'_>,
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
        .filter_map(|event| cause(at, x, event, before))
        .collect()
}

/// How the time of one event changes; none if nothing that vanishes there moves it.
pub(super) fn cause<'e>(
    at: &mut Place<'_>,
    x: &[f64],
    event: &'e Event,
    ([rates, flow], tangent): Before<'_>,
) -> Option<Cause<'e>> {
    let zero = zero(at, x, event)?;
    if zero.value.abs() > VANISHED * zero.size {
        return None;
    }
    let (rate, terms) = tangent.layout.rate(&zero.by, rates);
    let mut times = tangent.of(&zero.by);
    let mut grazed = vec![false; times.len()];
    if rate.abs() <= GRAZING * terms.max(zero.rate) {
        let sizes = tangent.sizes(&zero.by);
        for ((grazed, change), size) in grazed.iter_mut().zip(&mut times).zip(sizes) {
            *grazed = change.abs() > yardstick::PROMISE * size;
            *change = 0.0;
        }
    } else {
        let rate = tangent.layout.rate(&zero.by, flow).0;
        times.iter_mut().for_each(|change| *change /= -rate);
    }
    Some(Cause {
        event,
        times,
        grazed,
    })
}

/// What vanishes at an event, if something of its own does.
fn zero(at: &mut Place<'_>, x: &[f64], event: &Event) -> Option<Zero> {
    let contact = event.contact;
    let mode = at.modes.get(contact).copied()?;
    let closes = matches!(event.kind, EventKind::Impact | EventKind::Contact);
    if closes && mode == ContactMode::Open {
        at.acceleration.load_contact(contact, x);
    }
    let acceleration = &at.acceleration;
    let of = |(value, by): (f64, &[f64]), rate: f64, size: f64| Zero {
        value,
        by: by.to_vec(),
        rate,
        size,
    };
    let terms = |by: &[f64]| at.terms(by, (x, event.time));
    match (event.kind, mode) {
        (EventKind::Impact | EventKind::Contact, ContactMode::Open) => {
            let (_, by) = acceleration.point(contact, contact_point::GAP);
            Some(of((0.0, by), at.closing_speeds[contact], f64::INFINITY))
        }
        (EventKind::LiftOff, mode) if mode != ContactMode::Open => {
            let force = acceleration.force(contact, false)?;
            let curvature = acceleration.point(contact, contact_point::CURVATURE).0;
            // Where what acts without the contact vanishes with its force, that says nothing of its terms.
            let size = force_size(acceleration, contact).max(curvature.abs());
            Some(of(force, 0.0, size.max(terms(force.1))))
        }
        (EventKind::Slide | EventKind::Switch | EventKind::When, ContactMode::Slip(_)) => {
            let sliding = acceleration.tangent(contact, tangent_point::SLIDING_VELOCITY);
            Some(of(sliding, 0.0, terms(sliding.1)))
        }
        (EventKind::Stick | EventKind::Slip, ContactMode::Slip(_)) => {
            let n = acceleration.n;
            let sliding = acceleration.tangent(contact, tangent_point::SLIDING_VELOCITY);
            let terms = sliding.1[n..2 * n].iter().map(|by| by.abs() * at.sizes[1]);
            Some(of(sliding, 0.0, terms.sum()))
        }
        (EventKind::Slip | EventKind::Switch, ContactMode::Stick) => {
            // The friction that is left, in the direction in which the contact gives way.
            let ContactMode::Slip(direction) = event.modes.get(contact).copied()? else {
                return None;
            };
            let (value, by, size) = friction_left(acceleration, contact, direction.sign())?;
            Some(of((value, &by), 0.0, size))
        }
        _ => None,
    }
}

/// Size of the terms that a normal force balances.
pub(super) fn force_size(acceleration: &Acceleration<'_>, contact: usize) -> f64 {
    sum_of_sizes(
        acceleration.normal(contact),
        acceleration.free_acceleration(),
    )
}

/// The friction force of a sticking contact and what the law allows against this sense, whose sum vanishes where it gives way in it,
/// with the derivatives of that sum and the size of its terms; `None` where the forces are not those of the mode.
pub(super) fn friction_left(
    acceleration: &Acceleration<'_>,
    contact: usize,
    sense: f64,
) -> Option<(f64, Vec<f64>, f64)> {
    let (friction, friction_by) = acceleration.force(contact, true)?;
    let mut by = friction_by.to_vec();
    let (mu, mu_by) = acceleration.friction(contact);
    let (normal, normal_by) = acceleration.force(contact, false)?;
    add(&mut by, sense * mu, normal_by);
    let parameters = by.len() - mu_by.len();
    add(&mut by[parameters..], sense * normal, mu_by);
    let size = friction.abs() + mu * normal.abs();
    Some((friction + sense * mu * normal, by, size))
}
