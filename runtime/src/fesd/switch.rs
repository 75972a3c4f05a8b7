//! Switches of what acts: which side of a function that is only passed acts where it vanishes, and whether the motion is unique.
//!
//! Where its rate vanishes as well, the sides of all that are passed follow from what agrees a moment later (`contact/passing.rs`).
//!
//! A switch that may slide is decided by the laws of friction, as it is one. One that is only passed (`Switching::Passes`) is neither
//! held at its zero nor does its sign change the rate of its function, so that this rate says which side comes next.

use super::contacts::{Contacts, Line, ModeError};
use crate::contact::ActiveContact;
use crate::contact::passing::{self, Follows, Place};
use crate::model::{joint_rows, switching_terms, tangent_point};

/// Share of the time scale of the motion after which a function is looked at whose rate vanishes with it: the square of it is far
/// above rounding.
const LATER: f64 = 1e-3;

/// Whether the sides of the `passed` switches can be told by what follows: of few, without joints.
pub(super) fn can_choose(contacts: &Contacts<'_>, passed: &[usize]) -> bool {
    passed.len() <= passing::MOST && joint_rows(contacts.model) == 0
}

/// Chooses the sides of the `passed` switches, or finds that the motion rests, where the functions of all of them vanish and the rate of one;
/// the motion has this time scale. Contacts are evaluated at `x` again.
pub(super) fn choose(
    contacts: &mut Contacts<'_>,
    x: &[f64],
    (touching, passed): (&[usize], &[usize]),
    (time_scale, time): (f64, f64),
) -> Result<(), ModeError> {
    let all = 0..contacts.model.declaration().contacts.len();
    let zeros: Vec<f64> = all.map(|i| contacts.rest_speed(i, time)).collect();
    let place = Place {
        x,
        rates: &rates(contacts),
        touching,
        zeros: &zeros,
        moment: LATER * time_scale,
    };
    let follows = passing::follows(contacts, &place, passed)?;
    contacts.evaluate(x, touching.iter().copied());
    match follows {
        Follows::Sides => {}
        Follows::Rest(rest) => contacts.rest = Some(rest),
        Follows::Several(contact) => return Err(ModeError::NotUnique(contact)),
        Follows::Holds(contact) => return Err(ModeError::SecondOrder(contact)),
    }
    Ok(())
}

/// Rates of what the model reads besides coordinates and velocities: controls, and the time.
pub(crate) fn rates(contacts: &Contacts<'_>) -> Vec<f64> {
    let declaration = contacts.model.declaration();
    let mut rates = contacts.control_slopes.clone();
    rates.resize(declaration.controls.len(), 0.0);
    if declaration.explicit_time {
        rates.push(1.0);
    }
    rates
}

/// The side of a switch whose function vanishes at `x`, where the motion has the acceleration `motion` and this time scale: the sign of
/// its rate, and where that is none, below `zero`, of the function a little later; the side of before, if that says nothing.
pub(super) fn side(
    contacts: &Contacts<'_>,
    contact: usize,
    x: &[f64],
    (motion, time_scale): (&[f64], f64),
    zero: f64,
) -> f64 {
    let rate = contacts.sliding_acceleration(contact, motion);
    if rate.abs() > zero {
        return rate.signum();
    }
    let n = contacts.n;
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
pub(super) fn is_unique(
    contacts: &Contacts<'_>,
    active: &[ActiveContact],
) -> Result<(), ModeError> {
    for held in active.iter().filter(|held| held.state.sticks()) {
        let line = Line::Tangent {
            contact: held.contact,
            sense: 1.0,
        };
        if contacts.switch_of(held.contact).is_some() && contacts.coupling(line, line) <= 0.0 {
            return Err(ModeError::NotUnique(held.contact));
        }
    }
    Ok(())
}
