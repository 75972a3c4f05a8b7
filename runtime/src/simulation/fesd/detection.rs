//! Detection of the first violated sign condition inside a solved element.
//!
//! The switching functions are those of the time-freezing system: an open contact closes when its gap
//! falls through zero, or, after a release, when `max(g, v_n)` falls below zero (the region `g < 0 < v_n`
//! still carries the free dynamics); an active one opens when its force does. A sticking contact slips when
//! its friction reaches the bound `mu r`, and one that slides stops when its sliding velocity vanishes.

use super::detector::Detector;
use super::stop::Stop;
use super::switch::{ElementStart, Switch};
use super::{force_dips, friction_switch, gap_switch};
use crate::contact::find;
use crate::fesd::contacts::Contacts;
use crate::fesd::finite_element::FiniteElement;

/// The first violation in `element`, if any.
pub(super) fn first_violation(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &mut Contacts<'_>,
    start: &ElementStart<'_>,
) -> Result<Option<Switch>, Stop> {
    let active = element.active();
    detector.pieces.clone_from(&contacts.pieces);
    detector.open.clear();
    detector.drift = 0.0;
    for &i in start.near.contacts() {
        detector.sizes[i] = contacts.size(i, start.time);
    }
    for &i in start.near.contacts() {
        // What an idle piece lacks to acting is the difference of two gaps, whose terms may cancel.
        let acting = detector.sizes[contacts.pieces.acting(i)];
        detector.sizes[i] = detector.sizes[i].as_difference_from(acting);
    }
    detector.enclose(element, start);
    if !start.near.holds(|k| detector.along.input(k)) {
        // What is far might come near unseen.
        return Err(Stop::Unresolved);
    }
    let row = detector.thetas.len() + 1;
    for &i in start.near.contacts() {
        let (zero, gap) = (detector.sizes[i].gap_rounding(), start.gaps[i]);
        if find(active, i).is_none() && !detector.stays_open(i, zero) {
            detector.open.push(i);
            detector.gaps[i * row] = gap;
        }
    }
    detector.tell_steady(active);
    detector.note(active);
    if detector.open.is_empty() && active.is_empty() {
        return Ok(None);
    }
    friction_switch::start_frictions(detector, active, contacts, start);
    force_dips::start(detector, active, start.forces);
    if let Some(motion) = start.motion {
        let of_coordinates = element.position_rounding(motion);
        contacts.evaluate_contacts(start.x, detector.open.iter().copied());
        for &i in &detector.open {
            let steepness: f64 = contacts.normal(i).iter().map(|n| n.abs()).sum();
            detector.sizes[i] = detector.sizes[i].with_error(steepness * of_coordinates);
        }
    }
    for k in 0..detector.thetas.len() {
        detector.interpolate(element, k);
        let mut first = gap_switch::first_entry(detector, element, contacts, start, k)?;
        gap_switch::first_exit(detector, element, contacts, (start.motion, k), &mut first)
            .map_err(gap_switch::beyond)?;
        friction_switch::first_friction(detector, element, contacts, start, k, &mut first)?;
        force_dips::first(detector, element, contacts, k, &mut first)
            .map_err(gap_switch::beyond)?;
        if first.is_some() {
            return Ok(first);
        }
    }
    Ok(None)
}
