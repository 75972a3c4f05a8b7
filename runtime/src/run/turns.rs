//! Motions that turn round a rest: whether they do so in ever longer times.

use super::ahead::{after, set_sides};
use super::place::Place;
use super::rest::HALVINGS;
use crate::contact::{ModeError, View};

/// Turns of a motion around a rest that are compared, and steps in the time of the first switch.
const TURNS: usize = 4;
const STEPS_A_SWITCH: f64 = 8.0;
const MOST_STEPS: usize = 2_000;
/// Growth of the time of a turn over all turns that is none: steps of fourth order, and terms that vanish with the moment.
const GROWS: f64 = 1e-3;

/// Whether a motion that begins beside the rest turns round it in ever longer times.
pub(super) fn turns_outwards(
    view: &mut View<'_>,
    at: &Place<'_>,
    open: &[usize],
) -> Result<bool, ModeError> {
    let switches: Vec<usize> = at.touching.to_vec();
    set_sides(view, &switches, |_| 1.0);
    let mut x = after(view, at, at.x, at.later(), true)?;
    for &i in &switches {
        view.sides[i] = 0.0;
        view.evaluate_tangent(i, &x);
        view.sides[i] = if view.sliding_velocity(i) < 0.0 {
            -1.0
        } else {
            1.0
        };
    }
    let mut h = at.later() / STEPS_A_SWITCH;
    let (mut time, mut switched, mut turns) = (0.0, 0.0, Vec::new());
    for _ in 0..MOST_STEPS {
        let Some((to, step, crossed)) = step_to_switch(view, at, &switches, &x, h)? else {
            break;
        };
        x = to;
        time += step;
        let Some(contact) = crossed else {
            continue;
        };
        view.sides[contact] = -view.sides[contact];
        h = (time - switched) / STEPS_A_SWITCH;
        switched = time;
        if contact == open[0] && view.sides[contact] > 0.0 {
            turns.push(time);
            if turns.len() > TURNS + 1 {
                break;
            }
        }
    }
    set_sides(view, &switches, |_| 0.0);
    let times: Vec<f64> = turns.windows(2).map(|pair| pair[1] - pair[0]).collect();
    Ok(match (times.first(), times.last()) {
        (Some(first), Some(last)) if times.len() >= TURNS => *last > (1.0 + GROWS) * first,
        _ => false,
    })
}

/// A step of length `h`, or to the first switch within it, which is said; nothing where a side leads back at once.
type ToSwitch = Option<(Vec<f64>, f64, Option<usize>)>;

fn step_to_switch(
    view: &mut View<'_>,
    at: &Place<'_>,
    switches: &[usize],
    x: &[f64],
    h: f64,
) -> Result<ToSwitch, ModeError> {
    let crossed = |view: &mut View<'_>, to: &[f64]| {
        switches.iter().copied().find(|&i| {
            view.evaluate_tangent(i, to);
            view.sides[i] * view.sliding_velocity(i) < 0.0
        })
    };
    let to = after(view, at, x, h, true)?;
    if crossed(view, &to).is_none() {
        return Ok(Some((to, h, None)));
    }
    let (mut left, mut right) = (0.0, h);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (left + right);
        let to = after(view, at, x, middle, true)?;
        match crossed(view, &to) {
            Some(_) => right = middle,
            None => left = middle,
        }
    }
    if right <= f64::EPSILON * h {
        return Ok(None);
    }
    let to = after(view, at, x, right, true)?;
    let contact = crossed(view, &to);
    Ok(Some((to, right, contact)))
}
