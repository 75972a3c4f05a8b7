//! Location of a switch: the element lengths at whose end its condition holds.

use super::driver::Driver;
use super::stop::Stop;
use super::switch::{Function, Switch, SwitchKind};
use crate::contact::ActiveContact;
use crate::fesd::contact_size::ContactSize;
use crate::fesd::finite_element::newton;
use crate::yardstick;

/// Size of a force that changes its sign, relative to its terms, above which it does so through infinity.
const POLE: f64 = 1e-3;
/// Evaluations of the switch condition that locate one switch: 64 bisections use up all digits.
const MAX_LOCATIONS: usize = 80;

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
        let mut length = driver.element.length;
        let function = switch.function;
        if function.kind == SwitchKind::Exit && !driver.setup.settings.exit_condition {
            length = earliest_release(driver, function.contact, length, longest, count)?;
        }
        // One element of the length of the last evaluation is the located one.
        let solved = count == 1 && length == driver.element.length;
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

/// A contact that closes inside the solved element by more than what rounding explains: on ground that has the shape of the flight
/// rounding errors close the gap anywhere.
fn passed_through(driver: &mut Driver<'_>, within: f64) -> Option<Switch> {
    let switch = driver.first_violation().ok().flatten()?;
    let Function { kind, contact } = switch.function;
    let closes = matches!(kind, SwitchKind::Entry | SwitchKind::Reentry);
    let deep = switch.value < -driver.now.size(contact).touching_gap();
    (closes && deep && switch.violated < within).then_some(switch)
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
        // The last one ends at the switch.
        let within = if done < count { f64::INFINITY } else { 1.0 };
        let passed = passed_through(driver, within);
        driver.accept_element()?;
        if let Some(mut other) = passed {
            other.theta -= (count - done) as f64;
            other.violated -= (count - done) as f64;
            return Ok(Some(other));
        }
    }
    Ok(earlier_violation(driver, located))
}

/// Whether the condition of a switch already holds at the start of the segment: where dense output puts it
/// next to the start, it may be far from it for an element that is much too long.
pub(super) fn holds_at_start(driver: &Driver<'_>, function: Function) -> bool {
    let [_, explained] = function.zeros(&driver.now.contacts, driver.now.size(function.contact));
    function.kind == SwitchKind::Reentry || function.at_present(&driver.now) <= explained
}

/// A switching function other than the located one that is negative at the present state.
fn earlier_violation(driver: &Driver<'_>, located: Switch) -> Option<Switch> {
    let now = &driver.now;
    let is_other = |other: &Function| {
        other.contact != located.function.contact
            || other.is_normal() != located.function.is_normal()
    };
    let is_negative = |other: &Function| {
        let [_, explained] = other.zeros(&now.contacts, now.size(other.contact));
        other.at_present(now) < -explained
    };
    let functions = Function::of_mode(now).into_iter();
    let function = functions.filter(is_other).find(is_negative)?;
    let slope = match function.kind {
        SwitchKind::Entry => now.velocities[function.contact].min(-f64::MIN_POSITIVE),
        _ => located.slope,
    };
    Some(Switch {
        function,
        theta: 1.0,
        violated: 1.0,
        value: function.at_present(now),
        slope,
    })
}

/// Newton's method with secant slopes on the common element length, kept inside a bracket.
fn locate_one(
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
    let mut largest = driver.now.gaps[switch.function.contact].abs();
    let (mut passed, mut leapt) = (false, false);
    if switch.function.kind == SwitchKind::Stopping {
        // Beside a pole sizes are those of the pole.
        switch_condition(driver, switch.function, 0.0, 0)?;
    }
    let at_start = driver.now.size(switch.function.contact);
    for _ in 0..MAX_LOCATIONS {
        let value = switch_condition(driver, switch.function, length, count)?;
        if previous.is_none() && value.is_finite() {
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
        if value == 0.0 || closed || !leapt && step.abs() <= tolerance {
            if !leaps(
                driver,
                switch.function,
                (value, largest),
                (longest, at_start),
            ) {
                return Ok(());
            }
            match switch.function.kind {
                // Beside a pole steps are short: where it is, and whether there is another side, halves tell.
                SwitchKind::Entry | SwitchKind::Stopping if !closed => {
                    leapt = true;
                    length = 0.5 * (before + after);
                    continue;
                }
                kind @ (SwitchKind::Entry | SwitchKind::Stopping)
                    if passed || kind == SwitchKind::Stopping =>
                {
                    let time = begin + length * count as f64;
                    return Err(Stop::Leap(switch.function.contact, time));
                }
                // A dip that elements of other lengths do not have was an error of one.
                _ => return Err(Stop::Location),
            }
        }
        length -= step;
        if leapt || !(before < length && length < after) {
            length = 0.5 * (before + after);
        }
    }
    Err(Stop::Location)
}

/// Whether the function of a switch, of which its place has left this `value`, has changed its sign without passing zero; before it was
/// as large as `largest`, and its sizes were those `at_start`.
fn leaps(
    driver: &Driver<'_>,
    function: Function,
    (value, largest): (f64, f64),
    (longest, at_start): (f64, ContactSize),
) -> bool {
    match function.kind {
        SwitchKind::Exit | SwitchKind::Slipping => {
            value.abs() > POLE * driver.now.contacts.phi_scale(function.contact)
        }
        // Of schemes whose last stage is not the end of an element gaps jump there by themselves.
        SwitchKind::Entry if driver.setup.tableau.stiffly_accurate() => {
            let least = driver.now.size(function.contact).touching_gap();
            let least = least.max(yardstick::PROMISE * extent(&driver.now.x, longest));
            value.abs() > least.max(yardstick::VISIBLE * largest)
        }
        // Where a condition jumps it is another one; beside a pole its function is more than ever.
        SwitchKind::Stopping if driver.now.contacts.switch_of(function.contact).is_some() => {
            let least = at_start.sliding_speed().max(at_start.crossed_rest());
            value.abs() > least.max(yardstick::VISIBLE * largest)
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
fn solve_elements(driver: &mut Driver<'_>, length: f64, count: usize) -> Result<(), Stop> {
    driver.now.state.copy_from(&driver.start.state);
    for _ in 0..count {
        let now = &driver.now;
        newton::solve(&mut driver.element, &now.state, length, &now.piece)?;
        driver.now.state.copy_from(&driver.element.end);
    }
    Ok(())
}

/// Value of the switching function after `count` elements of `length` from the segment's start.
fn switch_condition(
    driver: &mut Driver<'_>,
    function: Function,
    length: f64,
    count: usize,
) -> Result<f64, Stop> {
    solve_elements(driver, length, count)?;
    driver.now.write_input();
    let now = &mut driver.now;
    Ok(function.value(&mut now.contacts, &now.active, &now.x)?)
}

/// Without the exit condition the published method also admits earlier take-offs: down to the common
/// element length at which the gap at the first stage of the following element vanishes. Returns that
/// length, by bisection, or `latest` where the scheme admits no earlier one.
fn earliest_release(
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
fn first_gap_after_release(driver: &mut Driver<'_>, contact: usize, h: f64) -> Result<f64, Stop> {
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
