//! Location of a switch: the element lengths at whose end its condition holds.

use super::detection;
use super::driver::Driver;
use super::stop::Stop;
use super::switch::{ElementStart, Switch, SwitchKind};
use crate::contact::{ActiveContact, ContactState, find, force_count};
use crate::fesd::finite_element::newton;
use crate::simulation::along::{LEAPS, LEAST_LEAP};

/// Force beyond its bound that another switch explains, relative to its terms; larger ones are switches of
/// their own.
const CROSSED: f64 = 1e-9;
/// Size of a force that changes its sign, relative to its terms, above which it does so through infinity.
const POLE: f64 = 1e-3;
/// Evaluations of the switch condition that locate one switch.
const MAX_LOCATIONS: usize = 60;

pub(super) fn violation(driver: &mut Driver<'_>) -> Result<Option<Switch>, Stop> {
    let start = ElementStart {
        x: &driver.now.x,
        near: &driver.now.near,
        gaps: &driver.now.gaps,
        velocities: &driver.now.velocities,
        sliding: &driver.now.sliding,
        forces: &driver.now.forces,
        acceleration: &driver.now.acceleration,
        time: driver.now.state.time,
        motion: driver
            .control
            .tolerance
            .is_some()
            .then_some(&driver.control.motion),
    };
    detection::first_violation(
        &mut driver.detector,
        &driver.element,
        &mut driver.now.contacts,
        &start,
    )
}

/// Finds the common length of `count` elements at whose end the switch condition holds, and makes
/// them part of the trajectory. Another contact that turns out to switch earlier takes over.
pub(super) fn locate(
    driver: &mut Driver<'_>,
    mut switch: Switch,
    longest: f64,
    count: usize,
) -> Result<Switch, Stop> {
    for _ in 0..=2 * driver.setup.contacts().len() {
        locate_one(driver, switch, longest, count)?;
        let mut length = driver.element.length();
        if switch.kind == SwitchKind::Exit && !driver.setup.settings.exit_condition {
            length = earliest_release(driver, switch.contact, length, longest, count)?;
        }
        // One element of the length of the last evaluation is the located one.
        let solved = count == 1 && length == driver.element.length();
        let Some(mut other) = accept_located(driver, switch, (length, count), solved)? else {
            return Ok(switch);
        };
        // Places in the last of `count` elements of another length.
        let place =
            |theta: f64| (theta + (count - 1) as f64) * length / longest - (count - 1) as f64;
        (other.theta, other.violated) = (place(other.theta), place(other.violated));
        switch = other;
        driver.return_to_start();
    }
    Err(Stop::Location)
}

/// A contact that closes inside the solved element, and its gap there.
fn passed_through(driver: &mut Driver<'_>) -> Option<(Switch, f64)> {
    let switch = violation(driver).ok().flatten()?;
    let closes = matches!(switch.kind, SwitchKind::Entry | SwitchKind::Reentry);
    closes.then(|| {
        let (place, contact) = (switch.violated, switch.contact);
        let gap = driver.detector.gap_at(&driver.element, contact, place);
        (switch, gap)
    })
}

/// Makes `count` elements of `length` part of the trajectory, unless they pass through the ground or a sign condition is
/// violated at their end: the elements in which the switch was found told only which conditions are violated at one of
/// their samples, and a long one may hold several bounces. Returns that switch, with its place in the last element.
fn accept_located(
    driver: &mut Driver<'_>,
    located: Switch,
    (length, count): (f64, usize),
    mut solved: bool,
) -> Result<Option<Switch>, Stop> {
    driver.return_to_start();
    driver.evaluate_state()?;
    for done in 1..=count {
        if !solved {
            newton::solve(
                &mut driver.element,
                &driver.now.state,
                length,
                &driver.now.piece,
            )?;
        }
        solved = false;
        let passed = passed_through(driver);
        driver.accept_element()?;
        // On ground that has the shape of the flight rounding errors close the gap anywhere.
        if let Some((mut other, gap)) = passed
            && (done < count || other.violated < 1.0)
            && gap < -driver.now.size(other.contact).touching_gap()
        {
            other.theta -= (count - done) as f64;
            other.violated -= (count - done) as f64;
            return Ok(Some(other));
        }
    }
    Ok(earlier_violation(driver, located))
}

/// Whether the condition of a switch already holds at the start of the segment: where dense output puts it
/// next to the start, it may be far from it for an element that is much too long.
pub(super) fn holds_at_start(driver: &Driver<'_>, switch: Switch) -> bool {
    let i = switch.contact;
    let size = driver.now.size(i);
    let slot = driver.now.active.iter().position(|held| held.contact == i);
    let force = slot.map_or(0.0, |slot| driver.now.forces[slot]);
    match switch.kind {
        SwitchKind::Entry => driver.now.gaps[i] <= size.touching_gap(),
        SwitchKind::Reentry => true,
        SwitchKind::Exit => force <= CROSSED * driver.now.contacts.phi_scale(i),
        SwitchKind::Slipping => {
            let frictions = driver
                .now
                .contacts
                .frictions(&driver.now.active, &driver.now.forces);
            let s = frictions
                .zip(&driver.now.active)
                .find(|(_, held)| held.contact == i);
            let margin = driver.now.contacts.friction(i) * force - s.map_or(0.0, |(s, _)| s.abs());
            margin <= CROSSED * driver.now.contacts.tangential_scale(i)
        }
        SwitchKind::Stopping => driver.now.sliding[i].abs() <= size.crossed_rest(),
    }
}

/// A sign condition other than the located one that is violated at the present state.
pub(super) fn earlier_violation(driver: &Driver<'_>, located: Switch) -> Option<Switch> {
    let other = |kind, contact, slope| {
        let normal = |kind| {
            matches!(
                kind,
                SwitchKind::Entry | SwitchKind::Reentry | SwitchKind::Exit
            )
        };
        let same = contact == located.contact && normal(kind) == normal(located.kind);
        (!same).then_some(Switch {
            kind,
            contact,
            theta: 1.0,
            violated: 1.0,
            slope,
        })
    };
    let size = |i: usize| driver.now.size(i);
    let closed = driver
        .now
        .near()
        .iter()
        .copied()
        .filter(|&i| find(&driver.now.active, i).is_none())
        .find(|&i| driver.now.gaps[i] < -size(i).touching_gap())
        .and_then(|i| {
            other(
                SwitchKind::Entry,
                i,
                driver
                    .now
                    .contacts
                    .normal_velocity(i)
                    .min(-f64::MIN_POSITIVE),
            )
        });
    if closed.is_some() {
        return closed;
    }
    let frictions = driver
        .now
        .contacts
        .frictions(&driver.now.active, &driver.now.forces);
    for ((held, &r), s) in driver
        .now
        .active
        .iter()
        .zip(&driver.now.forces)
        .zip(frictions)
    {
        let i = held.contact;
        let opens = r < -CROSSED * driver.now.contacts.phi_scale(i);
        let found = if opens && !driver.now.contacts.is_dry(i) {
            other(SwitchKind::Exit, i, located.slope)
        } else if held.state.sticks() {
            let margin = driver.now.contacts.friction(i) * r - s.abs();
            (margin < -CROSSED * driver.now.contacts.tangential_scale(i))
                .then(|| other(SwitchKind::Slipping, i, located.slope))
                .flatten()
        } else {
            let speed = held.state.sense() * driver.now.sliding[i];
            (speed < -size(i).crossed_rest())
                .then(|| other(SwitchKind::Stopping, i, located.slope))
                .flatten()
        };
        if found.is_some() {
            return found;
        }
    }
    None
}

/// Newton's method with secant slopes on the common element length, kept inside a bracket.
pub(super) fn locate_one(
    driver: &mut Driver<'_>,
    switch: Switch,
    longest: f64,
    count: usize,
) -> Result<(), Stop> {
    let begin = driver.start.state.time;
    let length_at = |theta: f64| ((count - 1) as f64 + theta) * longest / count as f64;
    // A little room beyond the violated place, which the dense output of another element named.
    let (mut before, mut after) = (0.0, length_at(switch.violated) + 0.01 * longest);
    let mut length = length_at(switch.theta);
    let mut slope = switch.slope * count as f64;
    let mut previous: Option<(f64, f64)> = None;
    let mut largest = driver.now.gaps[switch.contact].abs();
    let mut passed = false;
    for _ in 0..MAX_LOCATIONS {
        let value = switch_condition(driver, switch, length, count)?;
        if previous.is_none() {
            largest = largest.max(value.abs());
        }
        if let Some((earlier, earlier_value)) = previous {
            let secant = (value - earlier_value) / (length - earlier);
            if secant.is_finite() && secant != 0.0 {
                slope = secant;
            }
        }
        previous = Some((length, value));
        passed |= value <= 0.0;
        if value > 0.0 {
            before = length;
        } else {
            after = length;
        }
        let step = value / slope;
        // What the switch is told apart by is its own time: an element may be far longer than the flight that ends in it.
        let tolerance = 2.0 * f64::EPSILON * begin.max(length * count as f64);
        let closed = after - before <= tolerance;
        if value == 0.0 || step.abs() <= tolerance || closed {
            let leaps = leaps(driver, switch, (value, largest), longest);
            if !leaps {
                return Ok(());
            }
            match switch.kind {
                // Beside a pole steps are short on its one side too: whether there is another one, halves tell.
                SwitchKind::Entry if !passed && !closed => {
                    length = 0.5 * (before + after);
                    continue;
                }
                SwitchKind::Entry if passed => {
                    let time = begin + length * count as f64;
                    return Err(Stop::Leap(switch.contact, time));
                }
                // A dip that elements of other lengths do not have was an error of one.
                _ => return Err(Stop::Location),
            }
        }
        length -= step;
        if !(before < length && length < after) {
            length = 0.5 * (before + after);
        }
    }
    Err(Stop::Location)
}

/// Whether the function of a switch, of which its place has left this `value`, has changed its sign without passing zero; before it was
/// as large as `largest`.
fn leaps(driver: &Driver<'_>, switch: Switch, (value, largest): (f64, f64), longest: f64) -> bool {
    match switch.kind {
        SwitchKind::Exit | SwitchKind::Slipping => {
            value.abs() > POLE * driver.now.contacts.phi_scale(switch.contact)
        }
        // Of schemes whose last stage is not the end of an element gaps jump there by themselves.
        SwitchKind::Entry if driver.setup.tableau.stiffly_accurate() => {
            let least = driver.now.size(switch.contact).touching_gap();
            let least = least.max(LEAST_LEAP * extent(&driver.now.x, longest));
            value.abs() > least.max(LEAPS * largest)
        }
        // After a release the condition is a velocity, which may jump.
        SwitchKind::Entry | SwitchKind::Reentry | SwitchKind::Stopping => false,
    }
}

/// The largest coordinate, or way that a velocity goes in a time.
fn extent(x: &[f64], time: f64) -> f64 {
    let (q, v) = x.split_at(x.len() / 2);
    let ways = v.iter().map(|v| v * time);
    q.iter()
        .copied()
        .chain(ways)
        .fold(0.0, |most, way| most.max(way.abs()))
}

/// Solves `count` elements of `length` from the segment's start, without recording.
pub(super) fn solve_elements(
    driver: &mut Driver<'_>,
    length: f64,
    count: usize,
) -> Result<(), Stop> {
    driver.now.state.copy_from(&driver.start.state);
    for _ in 0..count {
        newton::solve(
            &mut driver.element,
            &driver.now.state,
            length,
            &driver.now.piece,
        )?;
        driver.now.state.copy_from(&driver.element.end);
    }
    Ok(())
}

/// Value of the switching function after `count` elements of `length` from the segment's start.
pub(super) fn switch_condition(
    driver: &mut Driver<'_>,
    switch: Switch,
    length: f64,
    count: usize,
) -> Result<f64, Stop> {
    solve_elements(driver, length, count)?;
    driver.now.write_input();
    match switch.kind {
        SwitchKind::Entry => {
            let pieces = &driver.now.contacts.pieces;
            Ok(pieces.gap(driver.setup.model, switch.contact, &driver.now.x))
        }
        SwitchKind::Reentry => {
            driver
                .now
                .contacts
                .evaluate_contacts(&driver.now.x, [switch.contact]);
            let gap = driver.now.contacts.gap(switch.contact);
            Ok(gap.max(driver.now.contacts.normal_velocity(switch.contact)))
        }
        SwitchKind::Exit | SwitchKind::Slipping => {
            let held = driver.now.active.iter().map(|held| held.contact);
            driver.now.contacts.evaluate(&driver.now.x, held);
            driver
                .now
                .forces
                .resize(force_count(&driver.now.active), 0.0);
            driver
                .now
                .contacts
                .contact_forces(&driver.now.active, &mut driver.now.forces)?;
            let of = |held: &ActiveContact| held.contact == switch.contact;
            let Some(slot) = driver.now.active.iter().position(of) else {
                return Ok(f64::NAN);
            };
            let r = driver.now.forces[slot];
            if switch.kind == SwitchKind::Exit {
                return Ok(r);
            }
            let s = driver
                .now
                .contacts
                .frictions(&driver.now.active, &driver.now.forces)
                .nth(slot);
            Ok(driver.now.contacts.friction(switch.contact) * r - s.map_or(f64::NAN, f64::abs))
        }
        SwitchKind::Stopping => {
            driver
                .now
                .contacts
                .evaluate_contacts(&driver.now.x, [switch.contact]);
            let sense =
                find(&driver.now.active, switch.contact).map_or(f64::NAN, ContactState::sense);
            Ok(sense * driver.now.contacts.sliding_velocity(switch.contact))
        }
    }
}

/// Without the exit condition the published method also admits earlier take-offs: down to the common
/// element length at which the gap at the first stage of the following element vanishes. Returns that
/// length, by bisection, or `latest` where the scheme admits no earlier one.
pub(super) fn earliest_release(
    driver: &mut Driver<'_>,
    contact: usize,
    latest: f64,
    next_length: f64,
    count: usize,
) -> Result<f64, Stop> {
    let (mut early, mut late) = (0.0, latest);
    for _ in 0..52 {
        let middle = 0.5 * (early + late);
        solve_elements(driver, middle, count)?;
        if first_gap_after_release(driver, contact, next_length)? >= 0.0 {
            late = middle;
        } else {
            early = middle;
        }
    }
    Ok(late)
}

/// Gap at the first stage of an element of length `h` from the present state without `contact`.
pub(super) fn first_gap_after_release(
    driver: &mut Driver<'_>,
    contact: usize,
    h: f64,
) -> Result<f64, Stop> {
    let released: Vec<ActiveContact> = driver
        .now
        .active
        .iter()
        .copied()
        .filter(|held| held.contact != contact)
        .collect();
    driver.next_element.set_mode(&released);
    newton::solve(
        &mut driver.next_element,
        &driver.now.state,
        h,
        &driver.now.piece,
    )?;
    Ok(driver
        .setup
        .model
        .gap(contact, driver.next_element.stage_input(0)))
}
