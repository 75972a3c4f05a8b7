//! Impacts at edges, see [`edge`](crate::contact::edge).

use super::driver::Driver;
use super::impacts::{self, Impact};
use crate::contact::edge::{Zeros, at_edges};
use crate::fesd::contacts::ModeError;

/// What counts as zero at a contact.
pub(super) fn zeros(driver: &Driver<'_>, contact: usize) -> Zeros {
    let size = driver.now.size(contact);
    Zeros {
        gap: size.touching_gap(),
        rounding: size.velocity_rounding(),
        velocity: size.touching_velocity(),
    }
}

/// Carries out the impact of the `touching` contacts at the present state, where all are evaluated. At edges other pieces
/// may act afterwards.
pub(super) fn carry_out(driver: &mut Driver<'_>, touching: &[usize]) -> Result<Impact, ModeError> {
    match pass(driver, touching) {
        Some(impact) => Ok(impact),
        None => impacts::carry_out(driver, touching),
    }
}

/// The impact of those `touching` contacts that are at no edge, if the motion that it leads to is free at the edges. The
/// pieces that lead from there on act. None, with everything as it was, where it is not.
fn pass(driver: &mut Driver<'_>, touching: &[usize]) -> Option<Impact> {
    let edges = at_edges(&driver.now.contacts, touching, |i| zeros(driver, i))?;
    let (state, numerical_time) = (driver.now.state.clone(), driver.now.numerical_time);
    let (gains, notes) = (driver.record.energy_gains, driver.record.notes.len());
    let contacts = driver.setup.contacts();
    let impact = impacts::carry_out(driver, &edges.others).ok();
    driver.now.evaluate_contacts(contacts.clone());
    let leads = edges.leads(&driver.now.contacts, |i| zeros(driver, i));
    let passes = |impact: &Impact| edges.blocked || !impact.struck.is_empty();
    if let (Some(mut impact), Some(leads)) = (impact.filter(passes), leads) {
        for (piece, _) in leads {
            let model = driver.setup.model;
            driver.now.contacts.pieces.let_act(model, piece);
        }
        impact.cluster = impact.cluster.map(|_| touching.to_vec());
        return Some(impact);
    }
    driver.now.state = state;
    driver.now.numerical_time = numerical_time;
    driver.record.energy_gains = gains;
    driver.record.notes.truncate(notes);
    driver.now.evaluate_contacts(contacts);
    None
}
