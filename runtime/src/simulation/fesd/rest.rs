//! Rest where the functions of switches vanish together: how long it lasts, and motions that come to it by ever more switches in ever less
//! time.

use super::driver::Driver;
use super::mode_change;
use crate::contact::passing::{self, Place};
use crate::fesd::contacts::ModeError;
use crate::fesd::switch::rates;

/// Time of a burst of switches, as a share of the time reached and of the horizon.
pub(super) const BURST: f64 = 1e-6;

/// Whether the motion rests.
pub(super) fn rests(driver: &Driver<'_>) -> bool {
    driver.now.contacts.rest.is_some()
}

/// Rests until `end`, or until what acts is balanced no more, where the next contact mode is chosen.
pub(super) fn rest(driver: &mut Driver<'_>, end: f64) -> Result<(), ModeError> {
    let now = &mut driver.now;
    let Some(rest) = now.contacts.rest.clone() else {
        return Ok(());
    };
    now.write_input();
    let time = now.state.time;
    let all = 0..driver.setup.model.declaration().contacts.len();
    let zeros: Vec<f64> = all.map(|i| now.contacts.rest_speed(i, time)).collect();
    let x = now.x.clone();
    let place = Place {
        x: &x,
        rates: &rates(&now.contacts),
        touching: &rest.contacts,
        zeros: &zeros,
        moment: end - time,
    };
    let lasts = passing::lasts(&mut now.contacts, &place, end - time);
    let over = lasts < end - time;
    now.numerical_time += lasts;
    now.state.time = if over { time + lasts } else { end };
    if !over && let Some(parts) = passing::parts_after(&mut now.contacts, &place, lasts) {
        now.contacts.rest = Some(crate::contact::Rest { parts, ..rest });
    }
    driver.record.counts.elements += 1;
    driver.evaluate_state()?;
    if over {
        mode_change::settle(driver, &[])?;
    }
    driver.record_state();
    Ok(())
}

/// Whether the switches of the last moment have led to a rest, into which the motion is put.
///
/// # Errors
/// Where they have led to sliding of second order.
pub(super) fn comes_to_rest(driver: &mut Driver<'_>) -> Result<bool, ModeError> {
    let moment = BURST * driver.setup.horizon;
    let now = driver.now.state.time;
    let declared = driver.setup.model.declaration().contacts;
    let mut recent = Vec::new();
    for event in driver.record.events.iter().rev() {
        if now - event.time > moment {
            break;
        }
        if declared[event.contact].switch.is_some() && !recent.contains(&event.contact) {
            recent.push(event.contact);
        }
    }
    if recent.is_empty() {
        return Ok(false);
    }
    recent.sort_unstable();
    let before = (driver.now.state.clone(), driver.now.active.clone());
    let now = &mut driver.now;
    now.write_input();
    let largest = now
        .acceleration
        .iter()
        .fold(0.0_f64, |size, a| size.max(a.abs()));
    let (model, n) = (driver.setup.model, now.state.q.len());
    let moved = passing::move_to_zero(
        model,
        &mut now.contacts,
        &mut now.x,
        &recent,
        (moment, largest),
    );
    if !moved {
        return Ok(false);
    }
    now.state.q.copy_from_slice(&now.x[..n]);
    now.state.v.copy_from_slice(&now.x[n..2 * n]);
    let settled = mode_change::settle(driver, &recent);
    if settled.is_ok() && rests(driver) {
        driver.record_state();
        return Ok(true);
    }
    driver.now.state = before.0;
    driver.now.active = before.1;
    driver.now.contacts.rest = None;
    match settled {
        Err(error @ ModeError::SecondOrder(_)) => Err(error),
        _ => Ok(false),
    }
}
