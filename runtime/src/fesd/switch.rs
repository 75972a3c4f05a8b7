//! Switches of what acts: which side of a function that is only passed acts where it vanishes, and whether the motion is unique.
//!
//! A switch that may slide is decided by the laws of friction, as it is one. One that is only passed (`Switching::Passes`) is neither
//! held at its zero nor does its sign change the rate of its function, so that this rate says which side comes next.

use super::active_contact::ActiveContact;
use super::contact_mode::{BIACTIVE, Solved, difference_step};
use super::contacts::{Contacts, Line, ModeError};
use crate::model::{Switching, switching_terms, tangent_point};

/// Most times that the sides of switches are chosen again, as what they change elsewhere is known.
const ROUNDS: usize = 4;

/// Share of the time scale of the motion after which a function is looked at whose rate vanishes with it: the square of it is far
/// above rounding.
const LATER: f64 = 1e-3;

/// The forces of the contacts that touch, with the sides of the switches that are passed now.
pub(super) fn sided(
    contacts: &mut Contacts<'_>,
    x: &[f64],
    touching: &[usize],
    time: f64,
) -> Result<Solved, ModeError> {
    contacts.sides.fill(0.0);
    let passed: Vec<usize> = touching
        .iter()
        .copied()
        .filter(|&i| contacts.switch(i) == Some(Switching::Passes))
        .filter(|&i| contacts.sliding_velocity(i).abs() <= contacts.size(i, time).at_rest())
        .collect();
    if passed.is_empty() {
        return Solved::new(contacts, touching.to_vec(), time);
    }
    let mut motion = contacts.free_acceleration().to_vec();
    for _ in 0..ROUNDS {
        let before = contacts.sides.clone();
        for &i in &passed {
            contacts.sides[i] = side(contacts, i, x, &motion);
        }
        // What was tried elsewhere is undone.
        contacts.evaluate(x, touching.iter().copied());
        let solved = Solved::new(contacts, touching.to_vec(), time)?;
        if contacts.sides == before {
            return Ok(solved);
        }
        motion = solved.motion(contacts);
    }
    Solved::new(contacts, touching.to_vec(), time)
}

/// The side of a switch whose function vanishes at `x`, where the motion has the acceleration `motion`: the sign of its rate, and where
/// that vanishes too, of the function a little later; the side of before, if that says nothing.
fn side(contacts: &mut Contacts<'_>, contact: usize, x: &[f64], motion: &[f64]) -> f64 {
    let rate = contacts.sliding_acceleration(contact, motion);
    let scale = contacts.tangential_scale(contact);
    if rate.abs() > BIACTIVE * scale {
        return rate.signum();
    }
    let n = contacts.n;
    let (_, time_scale) = difference_step(contacts, x, (motion, scale));
    let step = LATER * time_scale;
    let mut later = x.to_vec();
    for k in 0..n {
        later[k] += step * x[n + k] + 0.5 * step * step * motion[k];
        later[n + k] += step * motion[k];
    }
    if contacts.model.declaration().explicit_time
        && let Some(time) = later.last_mut()
    {
        *time += step;
    }
    let mut point = vec![0.0; tangent_point::length(n)];
    contacts.model.tangent(contact, &later, &mut point);
    let value = point[tangent_point::SLIDING_VELOCITY];
    let rounding = f64::EPSILON * switching_terms(contacts.model, contact, &later);
    if value.abs() > 16.0 * rounding {
        value.signum()
    } else if contacts.sides[contact] == 0.0 {
        1.0
    } else {
        contacts.sides[contact]
    }
}

/// Refuses a motion along the zero of a switch whose two sides both push away from it: it could leave to either at any time.
pub(super) fn is_unique(contacts: &Contacts<'_>, active: &[ActiveContact]) -> Result<(), ModeError> {
    for held in active.iter().filter(|held| held.sticks()) {
        let line = Line::Tangent {
            contact: held.contact,
            sense: 1.0,
        };
        if contacts.switch(held.contact).is_some() && contacts.coupling(line, line) <= 0.0 {
            return Err(ModeError::NotUnique(held.contact));
        }
    }
    Ok(())
}
