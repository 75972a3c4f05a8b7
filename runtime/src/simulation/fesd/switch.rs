//! What ends an element: the switching functions of a contact mode, positive as long as it lasts.

use super::present::Present;
use crate::contact::{ActiveContact, find, force_count};
use crate::enclosure::{Form, Interpolated, Sample, Watched};
use crate::fesd::contact_size::ContactSize;
use crate::fesd::contacts::{Contacts, ModeError};
use crate::yardstick;

/// Which sign condition ends the element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SwitchKind {
    /// The gap of an open contact closes.
    Entry,
    /// A contact that was released closes again: `max(g, v_n)` falls below zero.
    Reentry,
    /// The force of an active contact vanishes.
    Exit,
    /// The friction of a sticking contact reaches its bound.
    Slipping,
    /// The sliding velocity of an active contact vanishes.
    Stopping,
}

/// A switching function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Function {
    pub(super) kind: SwitchKind,
    pub(super) contact: usize,
}

/// A switching function that falls below zero, and where the dense output puts its root.
#[derive(Debug, Clone, Copy)]
pub(super) struct Switch {
    pub(super) function: Function,
    /// Place in the element, `0..=1`.
    pub(super) theta: f64,
    /// Place at which the function is known to be negative, and its value there.
    pub(super) violated: f64,
    pub(super) value: f64,
    /// Slope with respect to time at the root.
    pub(super) slope: f64,
}

impl Switch {
    /// The fall between two neighbours with a root at `theta`, in an element of this length.
    pub(super) fn between(
        function: Function,
        (left, right): (Sample, Sample),
        theta: f64,
        length: f64,
    ) -> Self {
        Self {
            function,
            theta,
            violated: right.at,
            value: right.value,
            slope: (right.value - left.value) / ((right.at - left.at) * length),
        }
    }
}

/// Forces of the active contacts at an input vector.
pub(super) fn forces(
    contacts: &mut Contacts<'_>,
    active: &[ActiveContact],
    x: &[f64],
) -> Result<Vec<f64>, ModeError> {
    contacts.evaluate(x, active.iter().map(|held| held.contact));
    let mut forces = vec![0.0; force_count(active)];
    contacts.contact_forces(active, &mut forces)?;
    Ok(forces)
}

impl Function {
    /// Those of the present mode.
    pub(super) fn of_mode(now: &Present<'_>) -> Vec<Self> {
        let of = |kind, contact| Self { kind, contact };
        let open = now.near().iter().copied();
        let open = open.filter(|&i| find(&now.active, i).is_none());
        let mut functions: Vec<Self> = open.map(|i| of(SwitchKind::Entry, i)).collect();
        for held in &now.active {
            let i = held.contact;
            if !now.contacts.is_dry(i) {
                functions.push(of(SwitchKind::Exit, i));
            }
            if now.contacts.friction(i) == 0.0 {
                continue;
            }
            if held.state.sticks() {
                functions.push(of(SwitchKind::Slipping, i));
            } else if held.state.sense() != 0.0 {
                functions.push(of(SwitchKind::Stopping, i));
            }
        }
        functions
    }

    /// Whether it is one of forces.
    pub(super) fn is_of_forces(self) -> bool {
        matches!(self.kind, SwitchKind::Exit | SwitchKind::Slipping)
    }

    /// Whether it tells of the contact itself, not of its friction.
    pub(super) fn is_normal(self) -> bool {
        !matches!(self.kind, SwitchKind::Slipping | SwitchKind::Stopping)
    }

    /// Its value where the `active` contacts have these forces, if it is one of forces.
    pub(super) fn of_forces(
        self,
        contacts: &Contacts<'_>,
        active: &[ActiveContact],
        forces: &[f64],
    ) -> f64 {
        let of = |held: &ActiveContact| held.contact == self.contact;
        let Some(slot) = active.iter().position(of) else {
            return f64::NAN;
        };
        if self.kind == SwitchKind::Exit {
            return forces[slot];
        }
        let s = contacts.frictions(active, forces).nth(slot);
        contacts.friction(self.contact) * forces[slot] - s.map_or(f64::NAN, f64::abs)
    }

    /// Its value at an input vector.
    pub(super) fn value(
        self,
        contacts: &mut Contacts<'_>,
        active: &[ActiveContact],
        x: &[f64],
    ) -> Result<f64, ModeError> {
        let i = self.contact;
        match self.kind {
            SwitchKind::Entry => return Ok(contacts.pieces.gap(contacts.model, i, x)),
            SwitchKind::Exit | SwitchKind::Slipping => {
                let forces = forces(contacts, active, x)?;
                return Ok(self.of_forces(contacts, active, &forces));
            }
            SwitchKind::Reentry | SwitchKind::Stopping => contacts.evaluate_contacts(x, [i]),
        }
        Ok(if self.kind == SwitchKind::Reentry {
            contacts.gap(i).max(contacts.normal_velocity(i))
        } else {
            self.sense(active) * contacts.sliding_velocity(i)
        })
    }

    /// Its value at the present state, which has been evaluated.
    pub(super) fn at_present(self, now: &Present<'_>) -> f64 {
        let i = self.contact;
        match self.kind {
            SwitchKind::Entry => now.gaps[i],
            SwitchKind::Reentry => now.gaps[i].max(now.velocities[i]),
            SwitchKind::Stopping => self.sense(&now.active) * now.sliding[i],
            SwitchKind::Exit | SwitchKind::Slipping => {
                self.of_forces(&now.contacts, &now.active, &now.forces)
            }
        }
    }

    /// In which sense the contact slides.
    pub(super) fn sense(self, active: &[ActiveContact]) -> f64 {
        find(active, self.contact).map_or(f64::NAN, |state| state.sense())
    }

    /// Its rounding error, and the values that another switch explains.
    pub(super) fn zeros(self, contacts: &Contacts<'_>, size: ContactSize) -> [f64; 2] {
        let of_forces = |scale: f64| [yardstick::ROUNDING * scale, yardstick::NOTHING * scale];
        match self.kind {
            SwitchKind::Entry | SwitchKind::Reentry => [size.gap_rounding(), size.touching_gap()],
            SwitchKind::Stopping => [size.sliding_rounding(), size.crossed_rest()],
            SwitchKind::Exit => of_forces(contacts.phi_scale(self.contact)),
            SwitchKind::Slipping => of_forces(contacts.tangential_scale(self.contact)),
        }
    }

    /// By what it is watched along an element. What slides in space does so in its own frame, which bounds do not know.
    pub(super) fn watched(self, contacts: &Contacts<'_>, active: &[ActiveContact]) -> Watched {
        match self.kind {
            SwitchKind::Entry => Watched::Gap(self.contact),
            SwitchKind::Stopping if !contacts.is_in_space(self.contact) => {
                Watched::Sliding(self.contact, Form::Signed(self.sense(active)))
            }
            _ => Watched::Solved,
        }
    }

    /// What it is called where it is looked at by some of its values.
    pub(super) fn named(self) -> Interpolated {
        match self.kind {
            SwitchKind::Entry | SwitchKind::Reentry => Interpolated::Gap(self.contact),
            SwitchKind::Exit => Interpolated::Force(self.contact),
            SwitchKind::Slipping => Interpolated::Friction(self.contact),
            SwitchKind::Stopping => Interpolated::Sliding(self.contact),
        }
    }
}
