//! Detection of contacts that close or open inside a solved element.

use super::detector::Detector;
use super::stop::Stop;
use super::switch::{
    ElementStart, FORCE_TOLERANCE, Switch, SwitchKind, bisect, keep_first, lowest,
};
use crate::contact::force_count;
use crate::fesd::contacts::{Contacts, ModeError};
use crate::fesd::finite_element::{ElementError, FiniteElement, MotionSize};

/// Share of the way in an element below which a penetration after a release may be its local error.
const DEEP: f64 = 1e-3;
/// Share of a gap that the cubic through neighbouring samples may miss.
const RESOLVED: f64 = 0.05;

/// Whether the gap of an open contact varies between samples `k - 2`, `k - 1` and `k` by more than they
/// show: the cubic through the outer values and slopes misses the inner value by so much that the gap
/// may have vanished in between.
pub(super) fn hides_a_crossing(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &mut Contacts<'_>,
    k: usize,
) -> bool {
    if k == 0 {
        return false;
    }
    let samples = detector.thetas.len();
    let mut suspects = Vec::new();
    for &i in &detector.open {
        let row = &detector.gaps[i * (samples + 1)..(i + 1) * (samples + 1)];
        let (a, b, c) = (row[k - 1], row[k], row[k + 1]);
        let least = a.min(b).min(c);
        let released = row[..k]
            .iter()
            .all(|gap| *gap <= detector.sizes[i].touching_gap());
        if !released && least > 0.0 && (a - 2.0 * b + c).abs() > least {
            suspects.push((i, a, b, c, least));
        }
    }
    if suspects.is_empty() {
        return false;
    }
    // Slopes at the outer samples by the normal velocities there.
    let width =
        (detector.thetas[k] - if k >= 2 { detector.thetas[k - 2] } else { 0.0 }) * element.length();
    suspects.into_iter().any(|(i, a, b, c, least)| {
        contacts.evaluate_contacts(&detector.x, [i]);
        let after = contacts.normal_velocity(i);
        let outer = if k >= 2 { detector.thetas[k - 2] } else { 0.0 };
        detector.tableau.dense_weights(outer, &mut detector.scratch);
        element.interpolate(outer, &detector.scratch, &mut detector.x);
        contacts.evaluate_contacts(&detector.x, [i]);
        let before = contacts.normal_velocity(i);
        detector.interpolate(element, k);
        let cubic = 0.5 * (a + c) + 0.125 * width * (before - after);
        let missed = (cubic - b).abs();
        missed > least && missed > RESOLVED * a.max(b).max(c)
    })
}

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
        let dips = k == 0 && gap >= 0.0 && bounced;
        if released && !dips && k + 1 < samples {
            continue;
        }
        if gap < -size.gap_rounding() {
            contacts.evaluate_contacts(&detector.x, [i]);
            let velocity = contacts.normal_velocity(i);
            let kind = if !released && before > 0.0 {
                SwitchKind::Entry
            } else if velocity < -size.velocity_rounding() {
                SwitchKind::Reentry
            } else if from_above && gap < -depth {
                return Err(Stop::Unresolved);
            } else {
                continue;
            };
            let (before, after) = match kind {
                SwitchKind::Entry => (before, gap),
                _ => (
                    margin_before(detector, element, contacts, start, i, k),
                    gap.max(velocity),
                ),
            };
            let switch = detector.between(kind, i, element, k, before, after);
            keep_first(&mut first, switch);
        } else if (!released || dips)
            && let Some((lower, upper)) = possible_dip(detector, element, contacts, start, i, k)
        {
            if let Some(switch) = dip(detector, element, i, lower, upper, size.gap_rounding()) {
                keep_first(&mut first, switch);
            }
            detector.interpolate(element, k);
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

/// Interval in which the gap of `contact` has a minimum that could dip below zero, if there is one that
/// sample `k` reveals.
fn possible_dip(
    detector: &Detector<'_>,
    element: &FiniteElement<'_>,
    contacts: &mut Contacts<'_>,
    start: &ElementStart<'_>,
    contact: usize,
    k: usize,
) -> Option<(f64, f64)> {
    let samples = detector.thetas.len();
    let row = &detector.gaps[contact * (samples + 1)..(contact + 1) * (samples + 1)];
    let place = |index: usize| {
        if index == 0 {
            0.0
        } else {
            detector.thetas[index - 1]
        }
    };
    if k == 0 {
        let duration = detector.thetas[0] * element.length();
        let reach = -start.velocities[contact] * duration;
        if row[1] >= row[0] && row[0] < reach {
            return Some((0.0, detector.thetas[0]));
        }
        if row[0] >= -reach {
            return None;
        }
        // A bounce may have come down and gone up again.
        contacts.evaluate_contacts(&detector.x, [contact]);
        let slopes = (-reach, contacts.normal_velocity(contact) * duration);
        let from = last_top_of_cubic((row[0], row[1]), slopes)?;
        return Some((from * detector.thetas[0], detector.thetas[0]));
    }
    let drop = (row[k - 1] - row[k]).max(row[k + 1] - row[k]);
    if row[k] <= row[k - 1] && row[k] <= row[k + 1] && row[k] < drop {
        return Some((place(k - 1), place(k + 1)));
    }
    if k + 1 == samples && row[k + 1] < row[k] && row[k + 1] < row[k] - row[k + 1] {
        contacts.evaluate_contacts(&detector.x, [contact]);
        if contacts.normal_velocity(contact) > 0.0 {
            return Some((place(k), place(k + 1)));
        }
    }
    None
}

/// Where the cubic with these values and slopes at 0 and 1 has its maximum, if it has a minimum after it: the roots of
/// its slope, `a s^2 + b s + c`.
fn last_top_of_cubic((v0, v1): (f64, f64), (c, slope): (f64, f64)) -> Option<f64> {
    let (a, b) = (
        3.0 * (c + slope - 2.0 * (v1 - v0)),
        2.0 * (3.0 * (v1 - v0) - 2.0 * c - slope),
    );
    let root = (b * b - 4.0 * a * c).sqrt();
    // With `c > 0` the smaller of two positive roots is the maximum.
    let (top, bottom) = (2.0 * c / (root - b), (root - b) / (2.0 * a));
    (a > 0.0 && b < 0.0 && root > 0.0 && bottom < 1.0).then_some(top)
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

/// Minimizes the gap of the dense output between `lower` and `upper` by golden section; a minimum below
/// zero is an entry on its falling side.
fn dip(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    contact: usize,
    lower: f64,
    upper: f64,
    gap_rounding: f64,
) -> Option<Switch> {
    let mut value = |theta: f64| detector.gap_at(element, contact, theta);
    let start = value(lower);
    let (bottom, depth) = lowest(&mut value, lower, upper);
    if depth >= -gap_rounding {
        return None;
    }
    let (left, _) = bisect(&mut value, lower, bottom);
    Some(Switch {
        kind: SwitchKind::Entry,
        contact,
        theta: left,
        violated: bottom,
        slope: (depth - start) / ((bottom - lower) * element.length()),
    })
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
