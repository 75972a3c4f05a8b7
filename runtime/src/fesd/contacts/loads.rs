//! Dry friction whose given force follows those of surfaces.

use super::Contacts;

impl Contacts<'_> {
    /// Evaluates what the given force of a contact follows, if it follows any.
    pub(super) fn evaluate_loads(&mut self, contact: usize, x: &[f64]) {
        let followed = self.model.declaration().contacts[contact].loads;
        if followed.is_empty() {
            return;
        }
        self.loads.retain(|&(friction, ..)| friction != contact);
        let mut factors = vec![0.0; followed.len()];
        self.model.loads(contact, x, &mut factors);
        let factors = followed.iter().zip(factors);
        self.loads
            .extend(factors.map(|(&surface, factor)| (contact, surface, factor)));
    }

    /// What a unit of the normal force of another contact adds to the normal acceleration of dry friction, which is its force less
    /// the given one, and less what it follows of others.
    pub(super) fn coupling_of_given(&self, contact: usize, other: usize) -> f64 {
        let own = if contact == other { 1.0 } else { 0.0 };
        let loads = self.loads.iter();
        let load = loads.filter(|load| (load.0, load.1) == (contact, other));
        load.fold(own, |coupling, load| coupling - load.2)
    }
}
