//! What happens to the contacts at one instant.

use super::EventKind;
use crate::contact::ContactState;
use crate::model::{ContactDeclaration, Switching};

/// What has happened to each contact where the mode has changed `from` one `to` another, conditions that came true and were `set` and the
/// contacts that were `struck` first; a contact that already carried a force takes part in an impact without one of its own, and contacts that are
/// closed at the start of a motion are no events.
pub(super) fn of(
    contacts: &[ContactDeclaration],
    (from, to): (&[ContactState], &[ContactState]),
    (struck, set): (&[usize], &[usize]),
    at_start: bool,
) -> Vec<(EventKind, usize)> {
    let set = set.iter().map(|&i| (EventKind::When, i));
    let impacts = struck.iter().map(|&i| (EventKind::Impact, i));
    let states = from.iter().zip(to).zip(contacts).enumerate();
    let changes = states.filter_map(|(i, ((&was, &is), declared))| {
        let lands = was.is_open() && (at_start || struck.contains(&i));
        let sets = declared.switch == Some(Switching::Resets);
        let kind = EventKind::between(was, is).filter(|_| !lands && !sets)?;
        Some((kind, i))
    });
    set.chain(impacts).chain(changes).collect()
}
