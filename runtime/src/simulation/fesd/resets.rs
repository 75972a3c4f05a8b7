//! Conditions that come true: what they set.

use super::driver::Driver;
use crate::contact::{ActiveContact, find};
use crate::model::Switching;

/// Whether a contact is a condition that sets something.
pub(super) fn is_condition(driver: &Driver<'_>, contact: usize) -> bool {
    let declared = driver.setup.model.declaration().contacts;
    declared[contact].switch == Some(Switching::Resets)
}

/// Sets what conditions ask for that come true at the present state: the one whose function was `located`, and those that what was set
/// or an impact has made true since the mode in force, each once. Returns them.
pub(super) fn set(driver: &mut Driver<'_>, located: Option<usize>) -> Vec<usize> {
    // Friction against minus the function: before the condition is true, it slips forward.
    let waiting: Vec<usize> = driver
        .setup
        .contacts()
        .filter(|&i| is_condition(driver, i))
        .filter(|&i| find(&driver.now.active, i).is_some_and(|held| held.sense() > 0.0))
        .collect();
    let mut set: Vec<usize> = Vec::new();
    if waiting.is_empty() {
        return set;
    }
    loop {
        driver.now.evaluate_contacts(waiting.iter().copied());
        let now = &driver.now;
        let next = waiting.iter().copied().find(|&i| {
            let holds = now.contacts.sliding_velocity(i) < -now.size(i).at_rest();
            !set.contains(&i) && (located == Some(i) || holds)
        });
        let Some(i) = next else { return set };
        carry_out(driver, i);
        set.push(i);
    }
}

/// Sets what a condition asks for.
fn carry_out(driver: &mut Driver<'_>, condition: usize) {
    let mut velocities = driver.now.state.v.clone();
    let model = driver.setup.model;
    model.reset(condition, &driver.now.x, &mut velocities);
    driver.now.state.v = velocities;
    driver.now.write_input();
}

/// Sets what those conditions ask for that have come true since the contacts of `previous` were held, without a switch of theirs: their
/// functions vanish at the present state and rise from there on, as where another switch, or a jump of the controls, comes at the same time.
/// Those that were `set` before are left out; the others are added to them. Whether there is any.
pub(super) fn set_turned(
    driver: &mut Driver<'_>,
    previous: &[ActiveContact],
    set: &mut Vec<usize>,
) -> bool {
    let sense = |held: &[ActiveContact], i| find(held, i).map_or(0.0, |held| held.sense());
    let active = &driver.now.active;
    let turned: Vec<usize> = driver
        .setup
        .contacts()
        .filter(|&i| is_condition(driver, i) && !set.contains(&i))
        .filter(|&i| sense(previous, i) > 0.0 && sense(active, i) < 0.0)
        .collect();
    for &i in &turned {
        carry_out(driver, i);
    }
    set.extend(&turned);
    !turned.is_empty()
}
