//! Conditions that come true: what they set.

use super::dynamics::{Dynamics, Switch};
use crate::contact::{ContactState, Direction};
use crate::model::Switching;

/// Sets what conditions ask for that come true at a time and a state `y = (q, v, ..)`: the one whose function has `vanished`, those that
/// what was set or an impact has made true since the mode `previously`, each once. Returns them.
pub(super) fn set(
    dynamics: &mut Dynamics<'_>,
    (t, y): (f64, &mut [f64]),
    vanished: Option<Switch>,
    previously: &[ContactState],
) -> Vec<usize> {
    let (n, model) = (dynamics.n, dynamics.model);
    let declared = model.declaration().contacts.iter().enumerate();
    // Friction against minus the function: before the condition is true, it slips forward.
    let below = ContactState::Slip(Direction::Forward);
    let waiting: Vec<usize> = declared
        .filter(|&(i, known)| known.switch == Some(Switching::Resets) && previously[i] == below)
        .map(|(i, _)| i)
        .collect();
    let mut set: Vec<usize> = Vec::new();
    if waiting.is_empty() {
        return set;
    }
    loop {
        dynamics.load(t, y);
        let next = waiting.iter().copied().find(|&i| {
            dynamics.evaluate_tangent(i);
            let holds = dynamics.sliding_velocity(i) < -dynamics.zero_sliding_velocity(i);
            let located = vanished == Some(Switch::SlidingVelocity(i, Direction::Forward));
            !set.contains(&i) && (located || holds)
        });
        let Some(i) = next else { return set };
        let mut velocities = y[n..2 * n].to_vec();
        model.reset(i, dynamics.input(), &mut velocities);
        y[n..2 * n].copy_from_slice(&velocities);
        set.push(i);
    }
}

/// The value of the function of a condition that has just `vanished` at a time and a state `y`; none of another switch.
pub(super) fn function(
    dynamics: &mut Dynamics<'_>,
    (t, y): (f64, &[f64]),
    vanished: Option<Switch>,
) -> Option<f64> {
    let Some(Switch::SlidingVelocity(contact, _)) = vanished else {
        return None;
    };
    dynamics.load(t, y);
    dynamics.evaluate_tangent(contact);
    Some(dynamics.sliding_velocity(contact))
}

/// Sets what those conditions ask for that have come true since the mode `previously` without an event of theirs: their functions vanish at
/// the present state and rise from there on, as where a step ends at a jump of the controls. Adds them to those `set`; whether there is any.
pub(super) fn set_turned(
    dynamics: &mut Dynamics<'_>,
    (t, y): (f64, &mut [f64]),
    previously: &[ContactState],
    set: &mut Vec<usize>,
) -> bool {
    let (n, model) = (dynamics.n, dynamics.model);
    let [below, above] = [Direction::Forward, Direction::Backward].map(ContactState::Slip);
    let declared = model.declaration().contacts.iter().enumerate();
    let turned = declared.filter(|&(i, known)| {
        let turns = previously[i] == below && dynamics.state(i) == above;
        known.switch == Some(Switching::Resets) && turns && !set.contains(&i)
    });
    let turned: Vec<usize> = turned.map(|(i, _)| i).collect();
    for &i in &turned {
        dynamics.load(t, y);
        let mut velocities = y[n..2 * n].to_vec();
        model.reset(i, dynamics.input(), &mut velocities);
        y[n..2 * n].copy_from_slice(&velocities);
    }
    set.extend(&turned);
    !turned.is_empty()
}
