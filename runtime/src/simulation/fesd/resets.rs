//! Conditions that come true: what they set.

use super::driver::Driver;
use crate::fesd::active_contact::find;
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
        let mut velocities = now.state.v.clone();
        driver.setup.model.reset(i, &now.x, &mut velocities);
        driver.now.state.v = velocities;
        driver.now.write_input();
        set.push(i);
    }
}
