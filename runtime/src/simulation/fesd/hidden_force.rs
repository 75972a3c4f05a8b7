//! Elements between whose stages something acts.

use super::driver::Driver;
use super::settings::StepFormulation;
use super::switch::{self, Function};
use crate::contact::find;
use crate::enclosure::hide;
use crate::simulation::hidden_force;

/// Share of the tolerance above which a difference counts: an element that is as long as its tolerance allows has
/// differences of this size by itself, which its error estimate is about.
const COUNTS: f64 = 4.0;

/// Whether something acts in the first `share` of the solved element that changes the velocity by more than its tolerance or may take a
/// force away, and that its stages do not show. Only under error control, which may shorten it.
pub(super) fn acts(driver: &mut Driver<'_>, share: f64) -> bool {
    let Some(tolerance) = driver.control.tolerance else {
        return false;
    };
    let element = &driver.element;
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
    let (n, length) = (driver.now.state.v.len(), share * element.length);
    let mut weights = vec![0.0; driver.setup.tableau.stages()];
    let mut x = driver.now.x.clone();
    let functions = Function::of_mode(&driver.now).into_iter();
    let functions: Vec<Function> = functions.filter(|one| one.is_of_forces()).collect();
    let (contacts, active) = (&mut driver.now.contacts, element.active());
    let at = |place: f64, values: &mut [f64]| {
        let theta = share * place;
        driver.setup.tableau.dense_weights(theta, &mut weights);
        element.interpolate(theta, &weights, &mut x);
        let Ok(forces) = switch::forces(contacts, active, &x) else {
            return values.fill(f64::NAN);
        };
        contacts.constrained_acceleration(active, &forces, &mut values[..n]);
        for (value, function) in values[n..].iter_mut().zip(&functions) {
            *value = function.of_forces(contacts, active, &forces);
        }
    };
    let motion = &driver.control.motion;
    let most = |k: usize| {
        let size = match k.checked_sub(n - motion.states.len()) {
            Some(state) => motion.states[state],
            None => motion.speed,
        };
        COUNTS * tolerance * size.max(element.end.v[k].abs())
    };
    hidden_force::acts(&parts, (n, functions.len()), length, at, most)
}
