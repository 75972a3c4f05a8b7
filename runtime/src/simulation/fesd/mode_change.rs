//! What happens at a switch: impacts, the new contact mode, and the events that they leave.

use super::driver::Driver;
use super::switch::{Switch, SwitchKind};
use super::{bounces, edge, impacts, resets};
use crate::contact::edge::leading;
use crate::contact::impact;
use crate::contact::{ActiveContact, ContactState, find};
use crate::fesd::contact_mode;
use crate::fesd::contacts::ModeError;
use crate::simulation::EventKind;

/// Carries out a located switch at the present state.
pub(super) fn carry_out(driver: &mut Driver<'_>, switch: Switch) -> Result<(), ModeError> {
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
fn largest_from_here(driver: &mut Driver<'_>, switch: Switch) -> usize {
    let model = driver.setup.model;
    let others = model.declaration().contacts[switch.contact].alternatives;
    let closes = matches!(switch.kind, SwitchKind::Entry | SwitchKind::Reentry);
    if !closes || others.is_empty() {
        return switch.contact;
    }
    let seen = others.iter().copied().chain([switch.contact]);
    driver.now.evaluate_contacts(seen);
    let zeros = |i| edge::zeros(driver, i);
    let (largest, _) = leading(&driver.now.contacts, switch.contact, zeros);
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
    driver.setup.contacts().filter(touches).collect()
}

/// Impact of everything that touches and closes, then the contact mode; records the events. The
/// contacts that `switched` touch whatever the discretization error of their gaps.
pub(super) fn settle(driver: &mut Driver<'_>, switched: &[usize]) -> Result<(), ModeError> {
    settle_after(driver, switched, None)
}

/// The same where the function of a condition may just have been `located`.
fn settle_after(
    driver: &mut Driver<'_>,
    switched: &[usize],
    located: Option<usize>,
) -> Result<(), ModeError> {
    let v_before = driver.now.state.v.clone();
    let previous = driver.now.active.clone();
    let mut set = resets::set(driver, located);
    let mut struck = change_mode(driver, switched, &mut set)?;
    while resets::set_turned(driver, &previous, &mut set) {
        // What was set may lead into a surface, or change what holds.
        driver.now.active.clone_from(&previous);
        struck.extend(change_mode(driver, switched, &mut set)?);
    }
    record_events(driver, (&struck, &set), &previous, &v_before);
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
    let contacts = driver.setup.contacts();
    driver.now.evaluate_contacts(contacts);
    driver.now.contacts.remember_sizes(&driver.now.x);
    let touching = touching(driver, switched);
    // Dry friction has no impulses, and it acts always.
    let dry = touching.iter().position(|&i| driver.now.contacts.is_dry(i));
    let (surfaces, dry) = touching.split_at(dry.unwrap_or(touching.len()));
    let impact = edge::carry_out(driver, surfaces)?;
    if !impact.struck.is_empty() {
        set.extend(resets::set(driver, None));
    }
    let now = &mut driver.now;
    let surfaces = impact.cluster.as_deref().unwrap_or(surfaces);
    // At an edge the impact may have led to another piece.
    let acting = surfaces.iter().map(|&i| now.contacts.pieces.acting(i));
    let touching: Vec<usize> = acting.chain(dry.iter().copied()).collect();
    let time = now.state.time;
    contact_mode::select(&mut now.contacts, &now.x, &touching, time, &mut now.active)?;
    bounces::end_cascades(driver, &impact.ended);
    if !driver.now.active.is_empty() {
        let active: Vec<usize> = driver.now.active.iter().map(|held| held.contact).collect();
        if impact.cluster.is_some() {
            // A cluster ends within gaps that are more than rounding.
            impacts::project(driver, &active)?;
        }
        driver.now.evaluate_contacts(active);
        bounces::note_held_flights(driver);
        let now = &mut driver.now;
        impact::hold(&now.contacts, &now.active, &mut now.state.v)?;
    }
    Ok(impact.struck)
}

/// Records the conditions that came true and were `set`, the impacts of the contacts that were `struck`, and what has changed since the contacts of `previous` were held.
fn record_events(
    driver: &mut Driver<'_>,
    (struck, set): (&[usize], &[usize]),
    previous: &[ActiveContact],
    v_before: &[f64],
) {
    for &i in set {
        driver.record_event(EventKind::When, i, v_before.to_vec());
    }
    // A contact that already carried a force takes part in the impact without one of its own.
    for &i in struck {
        driver.record_event(EventKind::Impact, i, v_before.to_vec());
    }
    for i in driver.setup.contacts() {
        let state = |active| find(active, i).unwrap_or(ContactState::Open);
        let (before, now) = (state(previous), state(&driver.now.active));
        // What is closed at the start, or has been struck, is no event of its own.
        let lands = before.is_open() && (struck.contains(&i) || driver.now.state.time == 0.0);
        let is_condition = !before.is_open() && !now.is_open() && resets::is_condition(driver, i);
        if let Some(kind) = EventKind::between(before, now)
            && !lands
            && !is_condition
        {
            driver.record_event(kind, i, v_before.to_vec());
        }
    }
}
