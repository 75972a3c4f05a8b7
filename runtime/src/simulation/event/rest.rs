//! Rest where the functions of switches vanish together: how long it lasts, and motions that come to it by ever more switches in ever less
//! time.

use super::dynamics::Dynamics;
use super::sides;
use crate::contact::passing::{self, Place};
use crate::contact::{ContactState, Rest};
use crate::simulation::Event;

/// Share of the horizon within which switches that lead to a rest follow each other.
const BURST: f64 = 1e-6;

/// How long the motion rests from the state `y` at `t` on, at most up to `limit`, and whether it is over then; none where it does not rest. The parts of
/// the sides are those at the end.
pub(super) fn lasts(
    dynamics: &mut Dynamics<'_>,
    (t, y): (f64, &[f64]),
    limit: f64,
) -> Option<(f64, bool)> {
    let rest = dynamics.rest.clone()?;
    let longest = limit - t;
    let rates = sides::rates(dynamics, (t, y));
    let x = dynamics.input().to_vec();
    let zeros: Vec<f64> = (0..dynamics.contacts)
        .map(|i| dynamics.zero_speed(i))
        .collect();
    let place = Place {
        x: &x,
        rates: &rates,
        touching: &rest.contacts,
        zeros: &zeros,
        moment: longest,
    };
    let lasts = passing::lasts(dynamics, &place, longest);
    let over = lasts < longest;
    if !over && let Some(parts) = passing::parts_after(dynamics, &place, lasts) {
        dynamics.rest = Some(Rest { parts, ..rest });
    }
    Some((lasts, over))
}

/// The state at rest to which the switches of the last moment before `t` lead from the state `y` with this `slope`, if they lead to one. They
/// act as in a mode then.
pub(super) fn nearest(
    dynamics: &mut Dynamics<'_>,
    events: &[Event],
    (t, y, slope): (f64, &[f64], &[f64]),
    horizon: f64,
) -> Option<Vec<f64>> {
    let moment = BURST * horizon;
    let declared = dynamics.model.declaration().contacts;
    let recent = events.iter().rev();
    let recent = recent.take_while(|event| t - event.time <= moment);
    let mut switches: Vec<usize> = recent
        .filter(|event| declared[event.contact].switch.is_some())
        .map(|event| event.contact)
        .collect();
    switches.sort_unstable();
    switches.dedup();
    if switches.is_empty() {
        return None;
    }
    dynamics.load(t, y);
    let (n, model) = (dynamics.n, dynamics.model);
    let largest = slope[n..2 * n].iter();
    let largest = largest.fold(0.0_f64, |size, a| size.max(a.abs()));
    let mut x = dynamics.input().to_vec();
    let found = passing::move_to_zero(model, dynamics, &mut x, &switches, (moment, largest));
    // Where no mode was found all are open, but a switch always acts.
    let mut mode = dynamics.mode().to_vec();
    for &i in &switches {
        if mode[i].is_open() {
            mode[i] = ContactState::slip(1.0);
        }
    }
    dynamics.set_mode(&mode);
    found.then(|| x[..2 * n].to_vec())
}
