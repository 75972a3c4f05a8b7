//! Detection of contacts that close or open inside a solved element.

use super::detector::Detector;
use super::stop::Stop;
use super::switch::{ElementStart, FORCE_TOLERANCE, Switch, SwitchKind, bisect, keep_first};
use crate::contact::force_count;
use crate::fesd::contacts::{Contacts, ModeError};
use crate::fesd::finite_element::{ElementError, FiniteElement, MotionSize};

/// Share of the way in an element below which a penetration after a release may be its local error.
const DEEP: f64 = 1e-3;

/// Open contacts that close between samples `k - 1` and `k`.
pub(super) fn first_entry(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &mut Contacts<'_>,
    start: &ElementStart<'_>,
    k: usize,
) -> Result<Option<Switch>, Stop> {
    let samples = detector.thetas.len();
    let mut first = None;
    for index in 0..detector.open.len() {
        let i = detector.open[index];
        let size = detector.sizes[i];
        let row = &mut detector.gaps[i * (samples + 1)..(i + 1) * (samples + 1)];
        let gap = detector.pieces.gap(detector.model, i, &detector.x);
        if !gap.is_finite() {
            return Err(beyond(ModeError::NotFinite));
        }
        row[k + 1] = gap;
        let before = row[k];
        // A contact that was just released separates more slowly than the element's local error at
        // first: until it has, only the end of the element tells.
        let released = row[..=k].iter().all(|gap| *gap <= size.touching_gap());
        let depth = DEEP * element.length() * size.speed();
        // Thrown off, deeper than the local error explains, and on the way up: it has fallen back in a flight
        // that is too low for an element of that length.
        let bounced = start.velocities[i] > size.velocity_rounding();
        let from_above = bounced && row[0] >= -size.touching_gap();
        let sunk = from_above && row[1..=k].iter().any(|gap| *gap < -depth);
        if released && sunk && gap > size.touching_gap() {
            return Err(Stop::Unresolved);
        }
        if released && gap < -size.gap_rounding() {
            if (bounced || gap < -depth)
                && let Some(switch) =
                    return_after_release(detector, element, i, k, size.gap_rounding())
            {
                keep_first(&mut first, switch);
                detector.interpolate(element, k);
                continue;
            }
            detector.interpolate(element, k);
        }
        if !released || gap >= 0.0 {
            let function = (SwitchKind::Entry, i, 1.0);
            let found = detector.falls((element, contacts), function, k, (before, gap))?;
            detector.interpolate(element, k);
            let falls = gap < -size.gap_rounding() && before > 0.0 && !released;
            let plain = || detector.between(SwitchKind::Entry, i, element, k, before, gap);
            if let Some(switch) = found.or_else(|| falls.then(plain)) {
                keep_first(&mut first, switch);
                continue;
            }
        }
        if released && k + 1 < samples {
            continue;
        }
        if gap < -size.gap_rounding() {
            contacts.evaluate_contacts(&detector.x, [i]);
            let velocity = contacts.normal_velocity(i);
            if velocity >= -size.velocity_rounding() {
                if from_above && gap < -depth {
                    return Err(Stop::Unresolved);
                }
                continue;
            }
            let before = margin_before(detector, element, contacts, start, i, k);
            let after = gap.max(velocity);
            let switch = detector.between(SwitchKind::Reentry, i, element, k, before, after);
            keep_first(&mut first, switch);
        }
    }
    Ok(first)
}

/// The entry of a contact that was released at the start of the element and is closed at sample `k`: if
/// its gap is positive somewhere before, by more than rounding error, it falls through zero in between.
fn return_after_release(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contact: usize,
    k: usize,
    gap_rounding: f64,
) -> Option<Switch> {
    let violated = detector.thetas[k];
    let mut value = |theta: f64| detector.gap_at(element, contact, theta);
    // Flights lower than the rounding error end in contact; of higher ones one of the places is close to
    // the top.
    let lowest = 0.5 * gap_rounding;
    let mut right = violated;
    let mut left = 0.5 * violated;
    for _ in 0..30 {
        if value(left) > lowest {
            break;
        }
        right = left;
        left *= 0.5;
    }
    let height = value(left);
    if height <= lowest {
        return None;
    }
    let slope = (value(right) - height) / ((right - left) * element.length());
    let (left, right) = bisect(&mut value, left, right);
    Some(Switch {
        kind: SwitchKind::Entry,
        contact,
        theta: left,
        violated: right,
        slope,
    })
}

/// `max(g, v_n)` at sample `k - 1`, at least zero.
fn margin_before(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &mut Contacts<'_>,
    start: &ElementStart<'_>,
    contact: usize,
    k: usize,
) -> f64 {
    if k == 0 {
        contacts.evaluate_contacts(start.x, [contact]);
    } else {
        detector.interpolate(element, k - 1);
        contacts.evaluate_contacts(&detector.x, [contact]);
        detector.interpolate(element, k);
    }
    contacts
        .gap(contact)
        .max(contacts.normal_velocity(contact))
        .max(0.0)
}

/// Active contacts whose force vanishes between samples `k - 1` and `k`.
pub(super) fn first_exit(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &mut Contacts<'_>,
    (motion, k): (Option<&MotionSize>, usize),
    first: &mut Option<Switch>,
) -> Result<(), ModeError> {
    let active = element.active();
    if active.is_empty() {
        return Ok(());
    }
    contacts.evaluate(&detector.x, active.iter().map(|held| held.contact));
    contacts.contact_forces(active, &mut detector.forces[..force_count(active)])?;
    if let Some(motion) = motion {
        observe_drift(detector, element, contacts, motion);
    }
    for (slot, held) in active.iter().enumerate() {
        let i = held.contact;
        let at = i * (detector.thetas.len() + 1) + k;
        let (before, after) = (detector.normal_forces[at].max(0.0), detector.forces[slot]);
        detector.normal_forces[at + 1] = after;
        if contacts.is_dry(i) {
            continue;
        }
        if after < -FORCE_TOLERANCE * contacts.phi_scale(i) {
            let switch = detector.between(SwitchKind::Exit, i, element, k, before, after);
            keep_first(first, switch);
        }
    }
    Ok(())
}

/// Takes note of the gaps of active contacts at the sample that is evaluated. They vanish at the stages; what is left of
/// them in between tells of ground that varies faster than the stages see, which their error estimate does not know.
fn observe_drift(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &Contacts<'_>,
    motion: &MotionSize,
) {
    let of_coordinates = element.position_rounding(motion);
    for held in element.active() {
        let i = held.contact;
        let normal = contacts.normal(i);
        let steepness: f64 = normal.iter().map(|n| n.abs()).sum();
        let rounding = detector.sizes[i].touching_gap() + steepness * of_coordinates;
        let gap = contacts.gap(i).abs() - rounding;
        if gap > 0.0 {
            let (q, v) = detector.x[..2 * normal.len()].split_at(normal.len());
            let way = motion.along(normal, (q, v), element.length());
            detector.drift = detector.drift.max(gap / way);
        }
    }
}

/// Between its stages an element may leave the domain of the model, or of the mode; a shorter one will not.
pub(super) fn beyond(error: ModeError) -> Stop {
    Stop::Element(match error {
        ModeError::NotFinite => ElementError::NotFinite,
        ModeError::Jammed
        | ModeError::Several(_)
        | ModeError::Dependent
        | ModeError::NegativeBound(_)
        | ModeError::NotUnique(_)
        | ModeError::SecondOrder(_) => ElementError::Singular,
    })
}
