//! Rest where the functions of switches vanish together, as a run of finite elements takes part in it.

use super::driver::Driver;
use super::mode_change;
use crate::fesd::contacts::ModeError;
use crate::run::rest;

/// Whether the motion rests.
pub(super) fn rests(driver: &Driver<'_>) -> bool {
    driver.now.contacts.rest.is_some()
}

/// Rests until `end`, or until what acts is balanced no more, where the next contact mode is chosen.
pub(super) fn rest(driver: &mut Driver<'_>, end: f64) -> Result<(), ModeError> {
    let time = driver.now.state.time;
    let Some((lasts, over)) = rest::lasts(driver, end - time) else {
        return Ok(());
    };
    driver.now.numerical_time += lasts;
    driver.now.state.time = if over { time + lasts } else { end };
    driver.record.counts.elements += 1;
    if over {
        mode_change::settle(driver, &[])?;
    } else {
        driver.evaluate_state()?;
    }
    driver.record_state();
    Ok(())
}

/// Whether the switches of the last moment have led to a rest, into which the motion is put.
///
/// # Errors
/// Where they have led to sliding of second order.
pub(super) fn comes_to_rest(driver: &mut Driver<'_>) -> Result<bool, ModeError> {
    let now = &driver.now;
    let before = (now.state.clone(), now.active.clone(), now.forces.clone());
    let accelerations = driver.now.acceleration.iter();
    let largest = accelerations.fold(0.0_f64, |size, a| size.max(a.abs()));
    let events = std::mem::take(&mut driver.record.events);
    let listed = events.iter().rev().map(|event| (event.time, event.contact));
    let within = (driver.setup.horizon, largest);
    let switches = rest::comes_to_rest(driver, listed, within);
    driver.record.events = events;
    let Some(switches) = switches else {
        return Ok(false);
    };
    let settled = mode_change::settle(driver, &switches);
    if settled.is_ok() && rests(driver) {
        driver.record_state();
        return Ok(true);
    }
    driver.now.state = before.0;
    driver.now.active = before.1;
    driver.now.forces = before.2;
    driver.now.contacts.rest = None;
    match settled {
        Err(error @ ModeError::SecondOrder(_)) => Err(error),
        _ => Ok(false),
    }
}
