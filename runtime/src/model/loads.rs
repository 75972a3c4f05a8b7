//! Dry friction whose given force follows those of surfaces and of friction.

use super::Model;

/// What a unit of the accelerations by contacts adds to the given ones of dry frictions, as last evaluated.
#[derive(Debug, Clone, Default)]
pub(crate) struct Loads {
    /// Friction, what it follows as [`ContactDeclaration::loads`](super::ContactDeclaration::loads) counts it, and factor.
    factors: Vec<(usize, usize, f64)>,
    /// Number of contacts.
    contacts: usize,
}

impl Loads {
    /// Evaluates what the given force of a contact follows at `x`, if it follows any.
    pub(crate) fn evaluate(&mut self, model: &dyn Model, contact: usize, x: &[f64]) {
        let followed = model.declaration().contacts[contact].loads;
        if followed.is_empty() {
            return;
        }
        self.contacts = model.declaration().contacts.len();
        self.factors.retain(|&(friction, ..)| friction != contact);
        let mut factors = vec![0.0; followed.len()];
        model.loads(contact, x, &mut factors);
        let factors = followed.iter().zip(factors);
        self.factors
            .extend(factors.map(|(&other, factor)| (contact, other, factor)));
    }

    /// What a unit of the friction of another contact adds to the normal acceleration of dry friction.
    pub(crate) fn rubbing(&self, contact: usize, other: usize) -> f64 {
        let other = self.contacts + other;
        let factors = self.factors.iter();
        let followed = factors.filter(|known| (known.0, known.1) == (contact, other));
        -followed.map(|known| known.2).sum::<f64>()
    }

    /// What a unit of the normal force of another contact adds to the normal acceleration of dry friction, which is its force less
    /// the given one, and less what it follows of others.
    pub(crate) fn coupling(&self, contact: usize, other: usize) -> f64 {
        let own = if contact == other { 1.0 } else { 0.0 };
        let factors = self.factors.iter();
        let followed = factors.filter(|known| (known.0, known.1) == (contact, other));
        followed.fold(own, |coupling, known| coupling - known.2)
    }
}
