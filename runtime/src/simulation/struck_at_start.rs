//! Contacts that are closed at the start of a motion and whose velocity there leads into their surfaces.
//!
//! Such a start is no mistake: the contact is struck at once, by the impact law of the scene, as a body that is dropped from there a moment earlier
//! would be. But it may be one, a sign or a part of a velocity that was left out, and the motion begins with other velocities than those
//! that were written; so it is said. What is rounding of the velocities is none of it.

use super::problem::touches_at_start;
use super::{EventKind, InitialValueProblem, Simulation, number, per_second};
use crate::model::{Model, contact_point};
use crate::yardstick;

/// What has to be said of the contacts that a `run` strikes at its start. A method that locates impacts has listed them; of another one the
/// contacts that touch with a velocity into their surfaces are struck in its first step.
pub(super) fn notes(
    model: &dyn Model,
    problem: &InitialValueProblem,
    run: &Simulation,
    locates: bool,
) -> Vec<String> {
    let contacts = model.declaration().contacts;
    if contacts.is_empty() || run.trajectory.time.is_empty() {
        return Vec::new();
    }
    let x = problem.input(model);
    let velocity = |contact: usize| normal_velocity(model, contact, &x);
    let at_once = |contact: usize| {
        let mut events = run.events.iter();
        events.any(|event| {
            event.time == 0.0 && event.kind == EventKind::Impact && event.contact == contact
        })
    };
    let strikes = |contact: &usize| {
        if locates {
            return at_once(*contact);
        }
        let (velocity, terms) = velocity(*contact);
        !contacts[*contact].dry
            && velocity < -yardstick::ROUNDING * terms
            && touches_at_start(model, problem, *contact, &x)
    };
    let when = if locates {
        "at t = 0"
    } else {
        "in the first step"
    };
    let struck = (0..contacts.len()).filter(strikes);
    struck
        .map(|contact| {
            let known = &contacts[contact];
            format!(
                "`{}` is closed at the start and the velocities there lead into it with {} {}: it is struck {when}; start with other \
                 velocities if that is not meant",
                known.name,
                number(-velocity(contact).0),
                per_second(known.unit)
            )
        })
        .collect()
}

/// The normal velocity of a contact at the input `x`, and the size of its terms.
fn normal_velocity(model: &dyn Model, contact: usize, x: &[f64]) -> (f64, f64) {
    let n = model.declaration().coordinates.len();
    let mut point = vec![0.0; contact_point::length(n)];
    model.contact(contact, x, &mut point);
    let normal = &point[contact_point::NORMAL..][..n];
    let terms = normal.iter().zip(&x[n..2 * n]);
    let terms = terms.map(|(n, v)| (n * v).abs()).sum();
    (point[contact_point::NORMAL_VELOCITY], terms)
}
