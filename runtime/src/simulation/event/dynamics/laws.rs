//! Coefficients of the contact laws besides those of friction.

use crate::model::{Model, friction_coefficients};

/// Coefficients of restitution, one a contact, and which contacts have friction.
pub(in crate::simulation) struct Laws {
    pub(in crate::simulation) restitution: Vec<f64>,
    /// Whether a contact declares friction, if only with the coefficient 0.
    pub(in crate::simulation) declares_friction: bool,
    /// Contacts with friction, increasing.
    pub(super) frictional: Vec<usize>,
}

impl Laws {
    pub(super) fn of(model: &dyn Model) -> Self {
        let contacts = model.declaration().contacts;
        let friction = friction_coefficients(model);
        Self {
            restitution: (0..contacts.len()).map(|i| model.restitution(i)).collect(),
            declares_friction: contacts.iter().any(|c| c.friction.is_some()),
            frictional: (0..contacts.len()).filter(|&i| friction[i] > 0.0).collect(),
        }
    }
}
