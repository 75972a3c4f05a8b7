//! Elements between whose stages something acts.

use super::driver::Driver;
use super::settings::StepFormulation;
use crate::contact::{find, force_count};
use crate::enclosure::hide;
use crate::simulation::hidden_force::mean_change;

/// Share of the tolerance above which a difference counts: an element that is as long as its tolerance allows has
/// differences of this size by itself, which its error estimate is about.
const COUNTS: f64 = 4.0;

/// Whether something acts in the first `share` of the solved element that changes the velocity by more than its tolerance, and that its stages
/// do not show. Only under error control, which may shorten it.
pub(super) fn acts(driver: &mut Driver<'_>, share: f64) -> bool {
    let Some(tolerance) = driver.control.tolerance else {
        return false;
    };
    let (element, model) = (&driver.element, driver.setup.model);
    if driver.setup.settings.formulation != StepFormulation::ActiveSet {
        return false;
    }
    let acting = driver
        .detector
        .along
        .hiding(|i| find(element.active(), i).is_some());
    if acting.is_empty() {
        return false;
    }
    let parts = match driver.detector.along.calm_parts(&acting) {
        None => return true,
        Some(parts) if !hide(&parts) => return false,
        Some(parts) => parts,
    };
    let parts = parts.iter().filter(|part| part[0] < share);
    let parts: Vec<[f64; 2]> = parts
        .map(|part| part.map(|at| (at / share).min(1.0)))
        .collect();
    let (n, length) = (driver.now.state.v.len(), share * element.length());
    let (contacts, active) = (&mut driver.now.contacts, element.active());
    let mut weights = vec![0.0; driver.setup.tableau.stages()];
    let mut x = driver.now.x.clone();
    let mut forces = vec![0.0; force_count(active)];
    let change = mean_change(&parts, n, |place, acceleration| {
        let theta = share * place;
        driver.setup.tableau.dense_weights(theta, &mut weights);
        element.interpolate(theta, &weights, &mut x);
        if active.is_empty() {
            model.free_acceleration(&x, acceleration);
            return;
        }
        contacts.evaluate(&x, active.iter().map(|held| held.contact));
        match contacts.contact_forces(active, &mut forces) {
            Ok(()) => contacts.constrained_acceleration(active, &forces, acceleration),
            Err(_) => acceleration.fill(f64::NAN),
        }
    });
    let motion = &driver.control.motion;
    let mechanical = n - motion.states.len();
    let share = |(k, change): (usize, f64)| {
        let size = match k.checked_sub(mechanical) {
            Some(state) => motion.states[state],
            None => motion.speed,
        };
        change * length / (size.max(element.end.v[k].abs()) + f64::MIN_POSITIVE)
    };
    let shares = change.into_iter().enumerate().map(share);
    shares.fold(0.0, f64::max) > COUNTS * tolerance
}
