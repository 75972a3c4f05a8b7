//! Which impacts bounce, and what is said of bounces that are left out.

use super::driver::Driver;
use crate::contact::{ActiveContact, find};

/// Rest velocity where none is set, relative to the size of the normal velocity.
const REST: f64 = 1e-6;

/// What a run says of bounces that it leaves out.
pub(super) const LEFT_OUT: &str = "slower than the rest velocity end in contact";

/// What it says of flights that it leaves out, where they begin with more than the share [`FELT`] of the velocity.
pub(super) const LOW_FLIGHTS: &str =
    "flights lower than the rounding error of their gap are left out";
const FELT: f64 = 1e-6;

/// Normal velocity below which a contact with restitution no longer bounces.
pub(super) fn rest_velocity(driver: &Driver<'_>, contact: usize) -> f64 {
    let largest = driver.now.size(contact).speed();
    let chosen = driver.setup.settings.rest_velocity;
    chosen.unwrap_or(REST * largest)
}

/// Speed up to which a contact that touches, `alone` or beside others, does not bounce: its bounce would stay within
/// what counts as touching. Infinite without restitution.
pub(super) fn slowest_bounce(driver: &Driver<'_>, contact: usize, alone: bool) -> f64 {
    let size = driver.now.size(contact);
    let lowest = if alone {
        size.gap_rounding()
    } else {
        size.touching_gap()
    };
    let slowest = (2.0 * driver.now.contacts.phi_scale(contact) * lowest).sqrt();
    rest_velocity(driver, contact).max(slowest / driver.setup.restitution[contact])
}

/// Remembers the bounces that the contacts in `ended`, which came with the given speeds and stay, did not
/// carry out.
pub(super) fn end_cascades(driver: &mut Driver<'_>, ended: &[(usize, f64)]) {
    for &(i, speed) in ended {
        if find(&driver.now.active, i).is_none() {
            continue;
        }
        let pull = -driver.now.contacts.normal_acceleration(i);
        let height = (driver.setup.restitution[i] * speed).powi(2) / (2.0 * pull);
        let cascades = &mut driver.record.cascades[i];
        if cascades.count == 0 {
            cascades.first = driver.now.state.time;
        }
        cascades.count += 1;
        cascades.height = cascades.height.max(height);
    }
}

/// Says which bounce cascades were ended.
pub(super) fn note_cascades(driver: &mut Driver<'_>) {
    let contacts = driver.setup.model.declaration().contacts;
    for (i, contact) in contacts.iter().enumerate() {
        let cascades = driver.record.cascades[i];
        if cascades.count > 0 {
            let times = if cascades.count == 1 {
                "once"
            } else {
                "repeatedly"
            };
            driver.note(&format!(
                "bounces of `{}` {LEFT_OUT}: {times}, first at t = {} s; a bounce left out is at most {:.1e} {} high",
                contact.name, cascades.first, cascades.height, contact.unit
            ));
        }
    }
}

/// Says whether contacts are held that leave with a velocity others could feel: more than rounding leaves of one that rests.
pub(super) fn note_held_flights(driver: &mut Driver<'_>) {
    let now = &driver.now;
    let leaves = |held: &ActiveContact| {
        let (i, size) = (held.contact, now.size(held.contact));
        let felt = (FELT * size.speed()).max(size.touching_velocity());
        now.contacts.normal_velocity(i) > felt
    };
    if now.active.iter().any(leaves) {
        driver.note(LOW_FLIGHTS);
    }
}
