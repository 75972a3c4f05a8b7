//! The forces of contacts at the last evaluation, and what given ones follow.

use super::Dynamics;
use crate::model::{contact_point, friction_share};

impl Dynamics<'_> {
    /// Evaluates what the given force of a contact follows, if it follows any.
    pub(super) fn evaluate_loads(&mut self, contact: usize) {
        let followed = self.model.declaration().contacts[contact].loads;
        if followed.is_empty() {
            return;
        }
        let known = &mut self.evaluated;
        known.loads.retain(|&(friction, ..)| friction != contact);
        let mut factors = vec![0.0; followed.len()];
        self.model.loads(contact, &known.x, &mut factors);
        let factors = followed.iter().zip(factors);
        known
            .loads
            .extend(factors.map(|(&surface, factor)| (contact, surface, factor)));
    }

    /// What a unit of the normal force of another contact adds to the normal acceleration of dry friction, which is its force less
    /// the given one, and less what it follows of others.
    pub(super) fn coupling_of_given(&self, contact: usize, other: usize) -> f64 {
        let own = if contact == other { 1.0 } else { 0.0 };
        let loads = self.evaluated.loads.iter();
        let load = loads.filter(|load| (load.0, load.1) == (contact, other));
        load.fold(own, |coupling, load| coupling - load.2)
    }

    /// Normal contact forces at the last evaluation, `lambda_i = r_i / D_i`, 0 for open contacts.
    pub(in crate::simulation) fn forces(&self, out: &mut [f64]) {
        self.divide_by_inertia(&self.equations.r, out);
    }

    /// Tangential contact forces at the last evaluation, `s_i / D_i`, 0 for open contacts.
    pub(in crate::simulation) fn friction_forces(&self, out: &mut [f64]) {
        self.divide_by_inertia(&self.equations.s, out);
        for &i in self.mode.active.iter().filter(|&&i| self.is_in_space(i)) {
            // In space it has a size, and a direction that the velocities tell.
            out[i] = self.friction_size(i) / self.point(i)[contact_point::INVERSE_INERTIA];
        }
        for (i, force) in out.iter_mut().enumerate() {
            *force *= friction_share(self.model, i, &self.evaluated.x);
        }
    }

    fn divide_by_inertia(&self, accelerations: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for &i in &self.mode.active {
            out[i] = accelerations[i] / self.point(i)[contact_point::INVERSE_INERTIA];
        }
    }

    /// Normal contact acceleration of an active contact at the last evaluation.
    pub(in crate::simulation) fn normal_force(&self, contact: usize) -> f64 {
        self.equations.r[contact]
    }

    /// What a contact that sticks at the last evaluation has left before it slips, `mu r - |s|`.
    pub(in crate::simulation) fn friction_reserve(&self, contact: usize) -> f64 {
        self.laws.friction[contact] * self.equations.r[contact] - self.friction_size(contact)
    }
}
