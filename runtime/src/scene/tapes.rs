//! Explicit functions of a scene from a text, for ranges of their inputs.

use crate::model::{Explicit, Tape};
use hangtime_dsl::description::{Description, ExplicitFunction, Kernel};

/// Explicit functions of a contact: gap, normal side, tangential side, second tangential side, factor of friction.
const OF_CONTACT: usize = 5;

/// The explicit functions of a scene.
#[derive(Debug)]
pub(super) struct Tapes {
    motion: Option<Kernel>,
    /// Of each contact one after the other.
    contacts: Vec<Option<Kernel>>,
}

impl Tapes {
    pub(super) fn of(description: &Description) -> Self {
        let places = OF_CONTACT * description.structure.contacts.len();
        let mut tapes = Self {
            motion: None,
            contacts: (0..places).map(|_| None).collect(),
        };
        for (function, kernel) in description.explicit_functions() {
            let (contact, kind) = match function {
                ExplicitFunction::Motion => {
                    tapes.motion = Some(kernel);
                    continue;
                }
                ExplicitFunction::Gap(i) => (i, 0),
                ExplicitFunction::Normal(i) => (i, 1),
                ExplicitFunction::Tangent(i) => (i, 2),
                ExplicitFunction::Across(i) => (i, 3),
                ExplicitFunction::Share(i) => (i, 4),
            };
            tapes.contacts[OF_CONTACT * contact + kind] = Some(kernel);
        }
        tapes
    }

    pub(super) fn get(&self, function: Explicit) -> Option<Tape<'_>> {
        let of = |contact: usize, kind: usize| {
            let stored = self.contacts.get(OF_CONTACT * contact + kind)?;
            stored.as_ref()
        };
        let stored = match function {
            Explicit::Motion => self.motion.as_ref(),
            Explicit::Gap(i) => of(i, 0),
            Explicit::Normal(i) => of(i, 1),
            Explicit::Tangent(i) => of(i, 2),
            Explicit::Across(i) => of(i, 3),
            Explicit::Share(i) => of(i, 4),
        }?;
        Some(Tape {
            operations: &stored.operations,
            outputs: &stored.outputs,
        })
    }
}
