//! What happens to the contacts at one instant.

use super::dynamics::Dynamics;
use crate::contact::ContactState;
use crate::model::Switching;
use crate::simulation::{Event, EventKind};

/// An instant at which the contact mode changes.
pub(super) struct Instant<'i, 'a> {
    pub(super) dynamics: &'i Dynamics<'a>,
    pub(super) time: f64,
    /// State `(q, v, numerical time)` after it.
    pub(super) after: &'i [f64],
    /// Velocities and contact mode before it.
    pub(super) velocities: &'i [f64],
    pub(super) mode: &'i [ContactState],
}

impl Instant<'_, '_> {
    /// What happened to each contact, conditions that came true and impacts first; contacts that are closed at the start of the motion
    /// are no events.
    pub(super) fn events(&self, (struck, set): (&[usize], &[usize]), at_start: bool) -> Vec<Event> {
        let set = set.iter().map(|&i| self.event(EventKind::When, i));
        let declared = self.dynamics.model.declaration().contacts;
        let impacts = struck.iter().map(|&i| self.event(EventKind::Impact, i));
        let changes = self.mode.iter().enumerate().filter_map(|(i, was)| {
            let lands = was.is_open() && (at_start || struck.contains(&i));
            let kind = EventKind::between(*was, self.dynamics.state(i)).filter(|_| !lands)?;
            if declared[i].switch == Some(Switching::Resets) {
                return None;
            }
            Some(self.event(kind, i))
        });
        set.chain(impacts).chain(changes).collect()
    }

    fn event(&self, kind: EventKind, contact: usize) -> Event {
        let n = self.dynamics.n;
        let declared = &self.dynamics.model.declaration().contacts[contact];
        Event {
            time: self.time,
            kind: kind.of(declared),
            contact,
            contact_name: declared.name,
            modes: self.dynamics.contact_modes(),
            q: self.after[..n].to_vec(),
            v_before: self.velocities.to_vec(),
            v_after: self.after[n..2 * n].to_vec(),
            contact_impulse: Vec::new(),
            friction_impulse: Vec::new(),
        }
    }
}
