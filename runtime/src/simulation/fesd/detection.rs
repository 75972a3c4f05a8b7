//! Detection of the first violated sign condition inside a solved element.
//!
//! The switching functions are those of the time-freezing system: an open contact closes when its gap
//! falls through zero, or, after a release, when `max(g, v_n)` falls below zero (the region `g < 0 < v_n`
//! still carries the free dynamics); an active one opens when its force does. A sticking contact slips when
//! its friction reaches the bound `mu r`, and one that slides stops when its sliding velocity vanishes.

use super::detector::Detector;
use super::stop::Stop;
use super::switch::{ElementStart, Switch};
use super::{between_samples, force_dips, friction_switch, gap_switch};
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
    let row = detector.thetas.len() + 1;
    for (i, &gap) in start.gaps.iter().enumerate() {
        if find(active, i).is_none() {
            detector.open.push(i);
            detector.gaps[i * row] = gap;
        }
    }
    if detector.open.is_empty() && active.is_empty() {
        return Ok(None);
    }
    for (i, size) in detector.sizes.iter_mut().enumerate() {
        *size = contacts.size(i, start.time);
    }
    friction_switch::start_frictions(detector, active, contacts, start);
    force_dips::start(detector, active, start.forces);
    detector.begin(start.x);
    for k in 0..detector.thetas.len() {
        detector.interpolate(element, k);
        detector.keep_sample();
        let mut first = gap_switch::first_entry(detector, element, contacts, start, k)?;
        gap_switch::first_exit(detector, element, contacts, (start.motion, k), &mut first)
            .map_err(gap_switch::beyond)?;
        friction_switch::first_friction(detector, element, contacts, start, k, &mut first)?;
        force_dips::first(detector, element, contacts, k, &mut first)
            .map_err(gap_switch::beyond)?;
        if first.is_some() {
            return Ok(first);
        }
        if gap_switch::hides_a_crossing(detector, element, contacts, k) {
            return Err(Stop::Unresolved);
        }
        let passed = between_samples::first_entry(detector, element, k, start.horizon);
        if passed.is_some() {
            return Ok(passed);
        }
    }
    Ok(None)
}
