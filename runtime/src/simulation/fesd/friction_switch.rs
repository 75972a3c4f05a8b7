//! Detection of the end of sticking and sliding inside a solved element.

use super::detector::Detector;
use super::stop::Stop;
use super::switch::{ElementStart, FORCE_TOLERANCE, Switch, SwitchKind, bisect, keep_first};
use crate::contact::{ActiveContact, find};
use crate::fesd::contacts::Contacts;
use crate::fesd::finite_element::FiniteElement;

/// What the friction of a sticking contact with friction `s` lacks to its bound, or the sliding velocity
/// in the sense of the slip.
fn friction_value(
    contacts: &Contacts<'_>,
    held: ActiveContact,
    r: f64,
    s: f64,
    sliding: f64,
) -> f64 {
    if held.state.sticks() {
        contacts.friction(held.contact) * r - s.abs()
    } else {
        held.state.sense() * sliding
    }
}

/// Stores the friction conditions at the start of the element.
pub(super) fn start_frictions(
    detector: &mut Detector<'_>,
    active: &[ActiveContact],
    contacts: &Contacts<'_>,
    start: &ElementStart<'_>,
) {
    let row = detector.thetas.len() + 1;
    let frictions = contacts.frictions(active, start.forces);
    for ((&held, &r), s) in active.iter().zip(start.forces).zip(frictions) {
        let sliding = start.sliding[held.contact];
        detector.frictions[held.contact * row] = friction_value(contacts, held, r, s, sliding);
    }
}

/// Contacts that begin to slip, or come to rest, between samples `k - 1` and `k`. The forces at sample `k`
/// are in `detector.forces`, the contacts are evaluated there.
pub(super) fn first_friction(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &mut Contacts<'_>,
    start: &ElementStart<'_>,
    k: usize,
    first: &mut Option<Switch>,
) -> Result<(), Stop> {
    let active = element.active();
    if active
        .iter()
        .all(|held| contacts.friction(held.contact) == 0.0)
    {
        return Ok(());
    }
    let samples = detector.thetas.len();
    let frictions: Vec<f64> = contacts.frictions(active, &detector.forces).collect();
    // All values first: what follows evaluates the contacts elsewhere.
    for (slot, &held) in active.iter().enumerate() {
        let i = held.contact;
        if contacts.friction(i) > 0.0 {
            let sliding = contacts.sliding_velocity(i);
            detector.frictions[i * (samples + 1) + k + 1] = friction_value(
                contacts,
                held,
                detector.forces[slot],
                frictions[slot],
                sliding,
            );
        }
    }
    for &held in active {
        let found = if contacts.friction(held.contact) == 0.0 {
            None
        } else if held.state.sticks() {
            slipping(detector, element, contacts, held.contact, k)
        } else if held.state.sense() != 0.0 && !detector.steady[held.contact] {
            stopping(detector, element, contacts, start, held, k)?
        } else {
            None
        };
        if let Some(switch) = found {
            keep_first(first, switch);
        }
    }
    detector.interpolate(element, k);
    Ok(())
}

/// Values of the friction condition of a contact up to sample `k`, from the start of the element on.
fn samples<'d>(detector: &'d Detector<'_>, contact: usize, k: usize) -> &'d [f64] {
    let row = contact * (detector.thetas.len() + 1);
    &detector.frictions[row..=row + k + 1]
}

/// The end of sticking between samples `k - 1` and `k`.
fn slipping(
    detector: &Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &Contacts<'_>,
    contact: usize,
    k: usize,
) -> Option<Switch> {
    let row = samples(detector, contact, k);
    let (before, value) = (row[k], row[k + 1]);
    let slips = value < -FORCE_TOLERANCE * contacts.tangential_scale(contact);
    let kind = SwitchKind::Slipping;
    slips.then(|| detector.between(kind, contact, element, k, before.max(0.0), value))
}

/// The end of a slip between samples `k - 1` and `k`, or before where sample `k` is the first to tell.
fn stopping(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &mut Contacts<'_>,
    start: &ElementStart<'_>,
    held: ActiveContact,
    k: usize,
) -> Result<Option<Switch>, Stop> {
    let i = held.contact;
    let rounding = detector.sizes[i].sliding_rounding();
    let row = samples(detector, i, k);
    let (before, value) = (row[k], row[k + 1]);
    let function = (SwitchKind::Stopping, i, held.state.sense());
    let slides = row[..=k].iter().any(|speed| *speed > rounding);
    let found = detector.falls((element, contacts), function, k, (before, value))?;
    if found.is_some() || value >= -rounding {
        return Ok(found);
    }
    if !slides {
        let back = stop_after_start(detector, element, contacts, i, k);
        if back.is_some() || k + 1 < detector.thetas.len() {
            return Ok(back);
        }
        if starts_in_sense(contacts, start, held) {
            // The element is too long to show the slip that the forces demand.
            return Err(Stop::Unresolved);
        }
        // The element starts where the slip ends.
        return Ok(Some(Switch {
            kind: SwitchKind::Stopping,
            contact: i,
            theta: 0.0,
            violated: detector.thetas[k],
            slope: (value - before) / element.length(),
        }));
    }
    let kind = SwitchKind::Stopping;
    let switch = detector.between(kind, i, element, k, before.max(0.0), value);
    Ok(Some(switch))
}

/// Whether the forces at the start of the element accelerate a contact in the sense of its slip.
fn starts_in_sense(
    contacts: &mut Contacts<'_>,
    start: &ElementStart<'_>,
    held: ActiveContact,
) -> bool {
    contacts.evaluate_contacts(start.x, [held.contact]);
    held.state.sense() * contacts.sliding_acceleration(held.contact, start.acceleration)
        > -FORCE_TOLERANCE * contacts.tangential_scale(held.contact)
}

/// Sliding velocity in the sense of the slip at place `theta`.
fn slip_speed(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &mut Contacts<'_>,
    contact: usize,
    theta: f64,
) -> f64 {
    detector.tableau.dense_weights(theta, &mut detector.scratch);
    element.interpolate(theta, &detector.scratch, &mut detector.x);
    contacts.evaluate_contacts(&detector.x, [contact]);
    let sense = find(element.active(), contact).map_or(0.0, |held| held.sense());
    sense * contacts.sliding_velocity(contact)
}

/// The stop of a contact that starts to slip with the element and slides the other way at sample `k`: if
/// it moves in its sense somewhere before.
fn stop_after_start(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &mut Contacts<'_>,
    contact: usize,
    k: usize,
) -> Option<Switch> {
    let mut right = detector.thetas[k];
    let mut value = |theta: f64| slip_speed(detector, element, contacts, contact, theta);
    let mut left = 0.5 * right;
    for _ in 0..30 {
        if value(left) > 0.0 {
            break;
        }
        right = left;
        left *= 0.5;
    }
    let speed = value(left);
    if speed <= 0.0 {
        return None;
    }
    let slope = (value(right) - speed) / ((right - left) * element.length());
    let (left, right) = bisect(&mut value, left, right);
    Some(Switch {
        kind: SwitchKind::Stopping,
        contact,
        theta: left,
        violated: right,
        slope,
    })
}
