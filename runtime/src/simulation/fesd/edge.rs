//! Impacts at edges: which piece of a surface acts where several vanish together, and which impacts pass an edge by.
//!
//! The largest of some gaps is not negative where one of them is not, so at an edge all motions are free that leave one
//! of its pieces: `max_i v_n,i >= 0`. The contact acts only against the others. Where other contacts are struck at the
//! very instant at which a body is at an edge, their impulses alone decide whether there is one of the edge.

use super::driver::Driver;
use super::impacts::{self, Impact};
use crate::fesd::contacts::ModeError;

/// The piece whose gap is the largest from here on, of those of the edge of a contact that vanish together with it, and its
/// normal velocity; all contacts are evaluated. Where they stay equal, the contact itself.
pub(super) fn leading(driver: &Driver<'_>, contact: usize) -> (usize, f64) {
    let now = &driver.now;
    let others = driver.setup.model.declaration().contacts[contact].alternatives;
    let own = now.contacts.normal_velocity(contact);
    let mut least = (contact, 0.0);
    for &other in others {
        // That of an idle piece is how fast the acting one moves away from it.
        let size = now.size(other);
        let ahead = now.contacts.normal_velocity(other);
        let ties = now.contacts.gap(other) <= size.touching_gap();
        if ties && ahead < least.1 - size.velocity_rounding() {
            least = (other, ahead);
        }
    }
    (least.0, own - least.1)
}

/// Whether a contact that touches is at an edge, where pieces of it vanish together, and is not struck there.
fn is_passed(driver: &Driver<'_>, contact: usize) -> bool {
    let others = driver.setup.model.declaration().contacts[contact].alternatives;
    let ties =
        |&other: &usize| driver.now.contacts.gap(other) <= driver.now.size(other).touching_gap();
    others.iter().any(ties) && is_free(driver, contact)
}

/// Whether the present velocity leaves a piece of the edge of a contact, or moves along it.
fn is_free(driver: &Driver<'_>, contact: usize) -> bool {
    leading(driver, contact).1 >= -driver.now.size(contact).touching_velocity()
}

/// Carries out the impact of the `touching` contacts at the present state, where all are evaluated. At edges other pieces
/// may act afterwards.
pub(super) fn carry_out(driver: &mut Driver<'_>, touching: &[usize]) -> Result<Impact, ModeError> {
    match pass(driver, touching) {
        Some(impact) => Ok(impact),
        None => impacts::carry_out(driver, touching),
    }
}

/// The impact of those `touching` contacts that are at no edge, if the motion that it leads to is free at the edges. The
/// pieces that lead from there on act. None, with everything as it was, where it is not.
fn pass(driver: &mut Driver<'_>, touching: &[usize]) -> Option<Impact> {
    let (edges, others): (Vec<usize>, Vec<usize>) =
        touching.iter().partition(|&&i| is_passed(driver, i));
    // Whether the piece that acts stands against a motion that another one sets free, where surfaces meet; the very edge of a single one
    // is struck.
    let several = touching.len() > 1;
    let mut passed = edges.iter().filter(|_| several);
    let blocked = passed
        .any(|&i| driver.now.contacts.normal_velocity(i) < -driver.now.size(i).touching_velocity());
    if edges.is_empty() || others.is_empty() && !blocked {
        return None;
    }
    let (state, numerical_time) = (driver.now.state.clone(), driver.now.numerical_time);
    let (gains, notes) = (driver.record.energy_gains, driver.record.notes.len());
    let contacts = driver.setup.contacts();
    let impact = impacts::carry_out(driver, &others).ok();
    driver.now.evaluate_contacts(contacts.clone());
    let free = edges.iter().all(|&i| is_free(driver, i));
    let passes = |impact: &Impact| free && (blocked || !impact.struck.is_empty());
    if let Some(mut impact) = impact.filter(passes) {
        for edge in edges {
            let (piece, _) = leading(driver, edge);
            driver
                .now
                .contacts
                .pieces
                .let_act(driver.setup.model, piece);
        }
        impact.cluster = impact.cluster.map(|_| touching.to_vec());
        return Some(impact);
    }
    driver.now.state = state;
    driver.now.numerical_time = numerical_time;
    driver.record.energy_gains = gains;
    driver.record.notes.truncate(notes);
    driver.now.evaluate_contacts(contacts);
    None
}
