//! Conditions that come true: what they set.

use super::instant::Instant;
use crate::contact::{ContactState, Line};
use crate::model::{ContactDeclaration, Model, Switching, tangent_point};
use crate::yardstick;

/// Whether a contact is a condition that sets something.
fn is_condition<'a>(now: &impl Instant<'a>, contact: usize) -> bool {
    now.view().switch_of(contact) == Some(Switching::Resets)
}

/// Conditions that are true at a start `x` and would set something there, in words.
pub(crate) fn true_at_start(model: &dyn Model, x: &[f64]) -> Vec<String> {
    let contacts = model.declaration().contacts.iter().enumerate();
    let waits_for = |&(condition, known): &(usize, &ContactDeclaration)| {
        let n = model.declaration().coordinates.len();
        let mut point = vec![0.0; tangent_point::length(n)];
        let mut set = x[n..2 * n].to_vec();
        let is_condition = known.switch == Some(Switching::Resets);
        if is_condition {
            model.tangent(condition, x, &mut point);
            model.reset(condition, x, &mut set);
        }
        point[tangent_point::SLIDING_VELOCITY] <= 0.0 && set != x[n..2 * n]
    };
    let found = contacts.filter(waits_for);
    found
        .map(|(_, known)| {
            format!(
                "`when {}` is true at the start, and sets nothing until it has been false: it waits to come true; let what it sets start so, or \
                 start where it is false",
                known.name
            )
        })
        .collect()
}

/// Conditions that are not true in the mode in force. Friction acts against minus their functions: it slips forward.
fn waiting<'a>(now: &impl Instant<'a>) -> Vec<usize> {
    let contacts = 0..now.view().sides.len();
    contacts
        .filter(|&i| is_condition(now, i) && now.state(i).sense() > 0.0)
        .collect()
}

/// Conditions that come true before anything else happens at the present instant: the one whose function was `located`, and those whose
/// functions fall to zero within the same instant in the mode in force.
pub(crate) fn coming<'a>(now: &mut impl Instant<'a>, located: Option<usize>) -> Vec<usize> {
    let waiting = waiting(now);
    if waiting.is_empty() || now.time() == 0.0 {
        return Vec::new();
    }
    let (acceleration, instant) = (now.accelerations(), yardstick::ROUNDING * now.time());
    let mut comes = |&i: &usize| {
        let against = function(now, i);
        let rate = now
            .view()
            .line_acceleration(Line::tangent(i), &acceleration);
        located == Some(i) || rate < 0.0 && against <= -rate * instant
    };
    waiting.into_iter().filter(|i| comes(i)).collect()
}

/// Sets what the conditions ask for that are `coming`, all of them from the present state, and then those that this, or an impact, has made
/// true since the mode in force, each once. Returns them.
///
/// # Errors
/// [`Instant::set_twice`] where two of them set one velocity to different values.
pub(crate) fn set<'a, I: Instant<'a>>(
    now: &mut I,
    coming: Vec<usize>,
) -> Result<Vec<usize>, I::Error> {
    let waiting = waiting(now);
    let mut set = coming;
    if waiting.is_empty() {
        return Ok(set);
    }
    carry_out(now, &set)?;
    loop {
        let mut holds = |i: usize| function(now, i) < -now.rest_speed(i);
        let next: Vec<usize> = waiting
            .iter()
            .copied()
            .filter(|&i| !set.contains(&i) && holds(i))
            .collect();
        if next.is_empty() {
            return Ok(set);
        }
        carry_out(now, &next)?;
        set.extend(next);
    }
}

/// Sets what these conditions ask for, all of them from the present state.
fn carry_out<'a, I: Instant<'a>>(now: &mut I, conditions: &[usize]) -> Result<(), I::Error> {
    let x = now.input();
    let (n, model) = (now.view().n, now.view().model);
    let before = &x[n..2 * n];
    let mut after = before.to_vec();
    for &condition in conditions {
        let mut own = before.to_vec();
        model.reset(condition, &x, &mut own);
        for ((after, own), before) in after.iter_mut().zip(own).zip(before) {
            if own == *before || own == *after {
                continue;
            }
            if *after != *before {
                return Err(now.set_twice(condition));
            }
            *after = own;
        }
    }
    let mut x = x.clone();
    x[n..2 * n].copy_from_slice(&after);
    now.put(&x);
    Ok(())
}

/// What is wrong where this condition sets what another one sets otherwise at the same instant.
pub(crate) fn set_twice(name: &str) -> String {
    format!(
        "the motion is not unique: `when {name}` and another condition come true at one instant and set the same to different values; let \
         one of them set it, or move a threshold"
    )
}

/// Minus the value of the function of a condition at the present state.
pub(crate) fn function<'a>(now: &mut impl Instant<'a>, condition: usize) -> f64 {
    let x = now.input();
    now.view_mut().evaluate_tangent(condition, &x);
    now.view().sliding_velocity(condition)
}

/// Sets what those conditions ask for that have come true since the mode `previously` without an event of theirs: their functions vanish at
/// the present state and rise from there on, as where another switch, or a jump of the controls, comes at the same time. Adds them to those
/// `set`, which are left out; whether there is any.
///
/// # Errors
/// As for [`set`].
pub(crate) fn set_turned<'a, I: Instant<'a>>(
    now: &mut I,
    previously: &[ContactState],
    set: &mut Vec<usize>,
) -> Result<bool, I::Error> {
    let turns = |i: usize| previously[i].sense() > 0.0 && now.state(i).sense() < 0.0;
    let turned: Vec<usize> = (0..previously.len())
        .filter(|&i| is_condition(now, i) && !set.contains(&i) && turns(i))
        .collect();
    carry_out(now, &turned)?;
    set.extend(&turned);
    Ok(!turned.is_empty())
}
