//! Forces that vanish, and friction that reaches its bound, between two samples of an element at which neither has.

use super::detector::Detector;
use super::switch::{FORCE_TOLERANCE, Switch, SwitchKind, keep_first};
use crate::contact::{ActiveContact, force_count};
use crate::enclosure::{Crossing, Sample, Watched, root};
use crate::fesd::contacts::{Contacts, ModeError};
use crate::fesd::finite_element::FiniteElement;

/// Share of the drop by which a curve through three values at equal distances may fall below the least, in the middle: twice what
/// a parabola does.
const DIP: f64 = 0.25;

/// Stores the normal forces at the start of the element.
pub(super) fn start(detector: &mut Detector<'_>, active: &[ActiveContact], forces: &[f64]) {
    let row = detector.thetas.len() + 1;
    for (held, &r) in active.iter().zip(forces) {
        detector.normal_forces[held.contact * row] = r;
    }
}

/// The first contact whose force, or reserve of friction, is the least at sample `k - 1` and falls below zero beside it.
/// Forces and frictions at the samples are known; the contacts are evaluated at sample `k`, and will be.
pub(super) fn first(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &mut Contacts<'_>,
    k: usize,
    first: &mut Option<Switch>,
) -> Result<(), ModeError> {
    let row = detector.thetas.len() + 1;
    let mut evaluated = false;
    if k == 0 {
        return Ok(());
    }
    for (slot, &held) in element.active().iter().enumerate() {
        let at = held.contact * row + k;
        let rows = [
            (SwitchKind::Exit, &detector.normal_forces),
            (SwitchKind::Slipping, &detector.frictions),
        ];
        let dips = rows.map(|(kind, row)| {
            let applies = match kind {
                SwitchKind::Exit => !contacts.is_dry(held.contact),
                _ => held.state.sticks() && contacts.friction(held.contact) > 0.0,
            };
            (kind, applies && may_dip(row[at - 1], row[at], row[at + 1]))
        });
        for (kind, _) in dips.into_iter().filter(|(_, dips)| *dips) {
            evaluated = true;
            if let Some(switch) = dip(detector, element, contacts, (kind, slot), k)? {
                keep_first(first, switch);
            }
        }
    }
    if evaluated {
        detector.interpolate(element, k);
        let held = element.active().iter().map(|held| held.contact);
        contacts.evaluate(&detector.x, held);
    }
    Ok(())
}

/// Whether a curve through three values, of which the middle one is the least and not below zero, may be so.
fn may_dip(before: f64, least: f64, after: f64) -> bool {
    let drop = before.max(after) - least;
    least >= 0.0 && least <= before && least <= after && least < DIP * drop
}

/// The end of a contact, or of its stick, between samples `k - 2` and `k`, if there is one.
fn dip(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &mut Contacts<'_>,
    (kind, slot): (SwitchKind, usize),
    k: usize,
) -> Result<Option<Switch>, ModeError> {
    let active = element.active();
    let held = active[slot];
    let zero = FORCE_TOLERANCE
        * match kind {
            SwitchKind::Exit => contacts.phi_scale(held.contact),
            _ => contacts.tangential_scale(held.contact),
        };
    let places = [detector.left(k - 1), detector.thetas[k]];
    let mut forces = vec![0.0; force_count(active)];
    let mut failed = None;
    let mut value = |theta: f64| {
        detector.tableau.dense_weights(theta, &mut detector.scratch);
        element.interpolate(theta, &detector.scratch, &mut detector.x);
        contacts.evaluate(&detector.x, active.iter().map(|held| held.contact));
        if let Err(error) = contacts.contact_forces(active, &mut forces) {
            failed = Some(error);
            return f64::INFINITY;
        }
        let r = forces[slot];
        if kind == SwitchKind::Exit {
            return r;
        }
        let s = contacts.frictions(active, &forces).nth(slot);
        contacts.friction(held.contact) * r - s.map_or(f64::NAN, f64::abs)
    };
    let [from, to] = places.map(|at| Sample {
        at,
        value: value(at),
    });
    let found = Watched::Solved.first_fall(&mut detector.along, &mut value, (from, to), zero);
    let fall = match found {
        Crossing::Between(left, right) => Some((root(&mut value, left, right), left, right)),
        Crossing::Nowhere => None,
        // Shorter elements follow it.
        Crossing::Undecided => return Err(ModeError::NotFinite),
    };
    if let Some(error) = failed {
        return Err(error);
    }
    Ok(fall.map(|(theta, left, right)| Switch {
        kind,
        contact: held.contact,
        theta,
        violated: right.at,
        slope: (right.value - left.value) / ((right.at - left.at) * element.length()),
    }))
}
