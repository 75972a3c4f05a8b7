//! What happens at a switch: impacts, the new contact mode, and the events that they leave.

use super::driver::Driver;
use super::switch::{Function, SwitchKind};
use crate::contact::edge::leading;
use crate::contact::find;
use crate::contact::impact::{close_gaps, hold};
use crate::fesd::contact_mode;
use crate::fesd::contacts::ModeError;
use crate::run::{Instant, impact, resets};
use crate::simulation::{EventKind, changes};
use crate::yardstick;

/// Carries out a located switch at the present state.
pub(super) fn carry_out(driver: &mut Driver<'_>, switch: Function) -> Result<(), ModeError> {
    if switch.kind == SwitchKind::Exit && !driver.setup.settings.exit_condition {
        release(driver, switch.contact)?;
    } else if driver.now.contacts.pieces.is_idle(switch.contact) {
        // Nothing else happens where the next piece of an edge comes to be the largest.
        let model = driver.setup.model;
        driver.now.contacts.pieces.let_act(model, switch.contact);
        settle(driver, &[])?;
    } else {
        let contact = largest_from_here(driver, switch);
        let located = (switch.kind == SwitchKind::Stopping).then_some(contact);
        settle_after(driver, &[contact], located)?;
    }
    driver.record_state();
    Ok(())
}

/// The contact that a switch is of; where several pieces of an edge vanish together, as where a surface goes on smoothly, the
/// piece whose gap falls slowest, which is the largest from there on and acts.
fn largest_from_here(driver: &mut Driver<'_>, switch: Function) -> usize {
    let model = driver.setup.model;
    let others = model.declaration().contacts[switch.contact].alternatives;
    let closes = matches!(switch.kind, SwitchKind::Entry | SwitchKind::Reentry);
    if !closes || others.is_empty() {
        return switch.contact;
    }
    let seen = others.iter().copied().chain([switch.contact]);
    driver.now.evaluate_contacts(seen);
    let (largest, _) = leading(&driver.now.contacts, switch.contact, |i| driver.zeros(i));
    if largest != switch.contact {
        driver.now.contacts.pieces.let_act(model, largest);
    }
    largest
}

/// Ends the contact although its force has not vanished (no exit condition).
fn release(driver: &mut Driver<'_>, contact: usize) -> Result<(), ModeError> {
    driver.now.active.retain(|held| held.contact != contact);
    driver.element.set_mode(&driver.now.active);
    let v = driver.now.state.v.clone();
    driver.record_event(EventKind::LiftOff, contact, v);
    driver.evaluate_state()
}

/// Contacts that touch at the present state: within the rounding error of their gap, held, or among those that `switched`,
/// whatever the discretization error of their gaps.
fn touching(driver: &Driver<'_>, switched: &[usize]) -> Vec<usize> {
    let now = &driver.now;
    let touches = |&i: &usize| {
        !now.contacts.pieces.is_idle(i)
            && (now.contacts.gap(i) <= now.size(i).touching_gap()
                || switched.contains(&i)
                || find(&now.active, i).is_some())
    };
    now.near().iter().copied().filter(touches).collect()
}

/// Impact of everything that touches and closes, then the contact mode; records the events. The
/// contacts that `switched` touch whatever the discretization error of their gaps.
pub(super) fn settle(driver: &mut Driver<'_>, switched: &[usize]) -> Result<(), ModeError> {
    settle_after(driver, switched, None)
}

/// Impact, contact mode and events where the function of a condition may just have been `located`.
fn settle_after(
    driver: &mut Driver<'_>,
    switched: &[usize],
    located: Option<usize>,
) -> Result<(), ModeError> {
    let v_before = driver.now.state.v.clone();
    let contacts = driver.setup.contacts();
    let previous = driver.now.active.clone();
    let from: Vec<_> = contacts.clone().map(|i| driver.state(i)).collect();
    let coming = resets::coming(driver, located);
    let mut set = resets::set(driver, coming)?;
    let mut struck = change_mode(driver, switched, &mut set)?;
    while resets::set_turned(driver, &from, &mut set)? {
        // What was set may lead into a surface, or change what holds.
        driver.now.active.clone_from(&previous);
        struck.extend(change_mode(driver, switched, &mut set)?);
    }
    let to: Vec<_> = contacts.map(|i| driver.state(i)).collect();
    let declared = driver.setup.model.declaration().contacts;
    let at_start = driver.now.state.time == 0.0;
    for (kind, i) in changes::of(declared, (&from, &to), (&struck, &set), at_start) {
        driver.record_event(kind, i, v_before.clone());
    }
    driver.element.set_mode(&driver.now.active);
    driver.element.set_frames(driver.now.contacts.frames());
    driver.evaluate_state()
}

/// Impact of everything that touches and closes, which may make conditions true that are `set`, then the contact mode; what was struck.
fn change_mode(
    driver: &mut Driver<'_>,
    switched: &[usize],
    set: &mut Vec<usize>,
) -> Result<Vec<usize>, ModeError> {
    driver.now.evaluate_near();
    let touching = touching(driver, switched);
    // Dry friction has no impulses, and it acts always.
    let dry = touching.iter().position(|&i| driver.now.contacts.is_dry(i));
    let (surfaces, dry) = touching.split_at(dry.unwrap_or(touching.len()));
    let impact = impact::carry_out(driver, surfaces)?;
    driver.now.numerical_time += impact.impulse / driver.setup.settings.auxiliary_acceleration;
    if !impact.struck.is_empty() {
        set.extend(resets::set(driver, Vec::new())?);
    }
    let now = &mut driver.now;
    // At an edge the impact may have led to another piece.
    let acting = surfaces.iter().map(|&i| now.contacts.pieces.acting(i));
    let touching: Vec<usize> = acting.chain(dry.iter().copied()).collect();
    let time = now.state.time;
    contact_mode::select(&mut now.contacts, &now.x, &touching, time, &mut now.active)?;
    let stays = |end: &impact::EndOfBounces| find(&driver.now.active, end.contact).is_some();
    let mut impact = impact;
    impact.ended.retain(stays);
    driver.record.remarks.add(time, &impact);
    if !driver.now.active.is_empty() {
        let active: Vec<usize> = driver.now.active.iter().map(|held| held.contact).collect();
        if impact.in_turn {
            // A cluster ends within gaps that are more than rounding.
            project(driver, &active)?;
        }
        driver.now.evaluate_contacts(active);
        note_held_flights(driver);
        let now = &mut driver.now;
        // A flight too low to be told apart would end with an impact, whose friction is that of what slides.
        let lines = now.contacts.lines_of_impulses(&now.active);
        hold(&now.contacts, &lines, &mut now.state.v)?;
    }
    Ok(impact.struck)
}

/// Says whether contacts are held that leave with a velocity others could feel: more than rounding leaves of one that rests.
pub(super) fn note_held_flights(driver: &mut Driver<'_>) {
    let now = &driver.now;
    let leaves = |&i: &usize| {
        let size = now.size(i);
        let felt = (yardstick::PROMISE * size.speed()).max(size.touching_velocity());
        now.contacts.normal_velocity(i) > felt
    };
    let held: Vec<usize> = now.active.iter().map(|held| held.contact).collect();
    driver.record.remarks.low_flights |= held.iter().any(leaves);
}

/// Moves the present positions onto the surfaces of `close` contacts, along their directions.
pub(super) fn project(driver: &mut Driver<'_>, close: &[usize]) -> Result<(), ModeError> {
    let now = &mut driver.now;
    for _ in 0..3 {
        now.evaluate_contacts(close.iter().copied());
        close_gaps(&now.contacts, close, &mut now.state.q)?;
    }
    Ok(())
}
