//! Conditions that come true: what they set.

use super::instant::Instant;
use crate::contact::ContactState;
use crate::model::Switching;

/// Whether a contact is a condition that sets something.
fn is_condition<'a>(now: &impl Instant<'a>, contact: usize) -> bool {
    now.view().switch_of(contact) == Some(Switching::Resets)
}

/// Sets what conditions ask for that come true at the present state: the one whose function was `located`, and those that what was set
/// or an impact has made true since the mode in force, each once. Returns them.
pub(crate) fn set<'a>(now: &mut impl Instant<'a>, located: Option<usize>) -> Vec<usize> {
    // Friction against minus the function: before the condition is true, it slips forward.
    let contacts = 0..now.view().sides.len();
    let waiting: Vec<usize> = contacts
        .filter(|&i| is_condition(now, i) && now.state(i).sense() > 0.0)
        .collect();
    let mut set: Vec<usize> = Vec::new();
    if waiting.is_empty() {
        return set;
    }
    loop {
        let x = now.input();
        let next = waiting.iter().copied().find(|&i| {
            now.view_mut().evaluate_tangent(i, &x);
            let holds = now.view().sliding_velocity(i) < -now.rest_speed(i);
            !set.contains(&i) && (located == Some(i) || holds)
        });
        let Some(next) = next else { return set };
        carry_out(now, next);
        set.push(next);
    }
}

/// Sets what a condition asks for.
fn carry_out<'a>(now: &mut impl Instant<'a>, condition: usize) {
    let mut x = now.input();
    let (n, model) = (now.view().n, now.view().model);
    let mut velocities = x[n..2 * n].to_vec();
    model.reset(condition, &x, &mut velocities);
    x[n..2 * n].copy_from_slice(&velocities);
    now.put(&x);
}

/// The value of the function of a condition at the present state.
pub(crate) fn function<'a>(now: &mut impl Instant<'a>, condition: usize) -> f64 {
    let x = now.input();
    now.view_mut().evaluate_tangent(condition, &x);
    now.view().sliding_velocity(condition)
}

/// Sets what those conditions ask for that have come true since the mode `previously` without an event of theirs: their functions vanish at
/// the present state and rise from there on, as where another switch, or a jump of the controls, comes at the same time. Adds them to those
/// `set`, which are left out; whether there is any.
pub(crate) fn set_turned<'a>(
    now: &mut impl Instant<'a>,
    previously: &[ContactState],
    set: &mut Vec<usize>,
) -> bool {
    let turns = |i: usize| previously[i].sense() > 0.0 && now.state(i).sense() < 0.0;
    let turned: Vec<usize> = (0..previously.len())
        .filter(|&i| is_condition(now, i) && !set.contains(&i) && turns(i))
        .collect();
    for &i in &turned {
        carry_out(now, i);
    }
    set.extend(&turned);
    !turned.is_empty()
}
