//! Coefficients of the contact laws.

use crate::model::{Model, kinetic_coefficients};

/// Coefficients of the contact laws, one entry a contact.
pub(in crate::simulation) struct Laws {
    pub(in crate::simulation) restitution: Vec<f64>,
    pub(in crate::simulation) friction: Vec<f64>,
    /// Friction of contacts that slide.
    pub(in crate::simulation) kinetic: Vec<f64>,
    /// Whether a contact declares friction, if only with the coefficient 0.
    pub(in crate::simulation) declares_friction: bool,
    /// Contacts with friction, increasing.
    pub(super) frictional: Vec<usize>,
}

impl Laws {
    pub(super) fn of(model: &dyn Model) -> Self {
        let contacts = model.declaration().contacts;
        let declared = |i: usize| contacts[i].friction.map_or(0.0, |_| model.friction(i));
        let friction: Vec<f64> = (0..contacts.len()).map(declared).collect();
        Self {
            restitution: (0..contacts.len()).map(|i| model.restitution(i)).collect(),
            declares_friction: contacts.iter().any(|c| c.friction.is_some()),
            frictional: (0..contacts.len()).filter(|&i| friction[i] > 0.0).collect(),
            friction,
            kinetic: kinetic_coefficients(model),
        }
    }

    /// Coefficients of friction at rest and of sliding.
    pub(in crate::simulation) fn frictions(&self, contact: usize) -> (f64, f64) {
        (self.friction[contact], self.kinetic[contact])
    }
}
