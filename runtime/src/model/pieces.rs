//! Which piece of a surface with an edge acts.
//!
//! The largest of some gaps is not negative where one of them is not. Of its pieces only the one acts whose gap is the
//! largest, `k`. In place of the gap of any other piece `i` stands `g_k - g_i`, which is smooth and not negative as long
//! as that is so: where it vanishes, the motion passes the edge and `i` acts from there on. So an edge is found like the
//! surfaces themselves, and no method looks at a maximum.

use super::{Model, contact_point};

/// The pieces that act.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Pieces {
    /// For each contact the piece of its edge that acts; empty for scenes without edges.
    acting: Vec<usize>,
}

impl Pieces {
    /// Those that act at `x`; of equal ones the first.
    pub(crate) fn at(model: &dyn Model, x: &[f64]) -> Self {
        let mut pieces = Self::default();
        pieces.choose(model, x);
        pieces
    }

    /// Lets those act that do so at `x`.
    pub(crate) fn choose(&mut self, model: &dyn Model, x: &[f64]) {
        let contacts = model.declaration().contacts;
        if contacts.iter().all(|known| known.alternatives.is_empty()) {
            return;
        }
        self.acting.resize(contacts.len(), 0);
        self.choose_among(model, x, 0..contacts.len());
    }

    /// Lets those of the edges of the listed contacts act that do so at `x`.
    pub(crate) fn choose_among(
        &mut self,
        model: &dyn Model,
        x: &[f64],
        contacts: impl IntoIterator<Item = usize>,
    ) {
        let declared = model.declaration().contacts;
        for i in contacts {
            let contact = &declared[i];
            let first = contact.alternatives.iter().all(|&other| i < other);
            if !first || self.acting.is_empty() {
                continue;
            }
            let mut largest = (i, model.gap(i, x));
            for &other in contact.alternatives {
                let gap = model.gap(other, x);
                if gap > largest.1 {
                    largest = (other, gap);
                }
            }
            self.let_act(model, largest.0);
        }
    }

    /// Lets a contact act in place of the other pieces of its edge.
    pub(crate) fn let_act(&mut self, model: &dyn Model, contact: usize) {
        for &other in model.declaration().contacts[contact].alternatives {
            self.acting[other] = contact;
        }
        if let Some(own) = self.acting.get_mut(contact) {
            *own = contact;
        }
    }

    /// Lets a contact act in place of the one of its edge that does so now.
    pub(crate) fn pass_to(&mut self, contact: usize) {
        let before = self.acting(contact);
        for acting in self.acting.iter_mut().filter(|acting| **acting == before) {
            *acting = contact;
        }
    }

    /// The piece of the edge of a contact that acts; of one without an edge itself.
    pub(crate) fn acting(&self, contact: usize) -> usize {
        self.acting.get(contact).copied().unwrap_or(contact)
    }

    /// The piece that acts in place of a contact.
    fn instead(&self, contact: usize) -> Option<usize> {
        Some(self.acting(contact)).filter(|&acting| acting != contact)
    }

    /// Whether another piece acts in place of a contact.
    pub(crate) fn is_idle(&self, contact: usize) -> bool {
        self.instead(contact).is_some()
    }

    /// The gap of a contact; of an idle one, how far it is from acting.
    pub(crate) fn gap(&self, model: &dyn Model, contact: usize, x: &[f64]) -> f64 {
        let gap = model.gap(contact, x);
        match self.instead(contact) {
            Some(acting) => model.gap(acting, x) - gap,
            None => gap,
        }
    }

    /// The contact with that gap, laid out as in [`contact_point`]; an idle one keeps its direction.
    pub(crate) fn contact(&self, model: &dyn Model, contact: usize, x: &[f64], point: &mut [f64]) {
        model.contact(contact, x, point);
        let Some(acting) = self.instead(contact) else {
            return;
        };
        let mut its = vec![0.0; point.len()];
        model.contact(acting, x, &mut its);
        let normal =
            contact_point::NORMAL..contact_point::direction(model.declaration().coordinates.len());
        for k in [
            contact_point::GAP,
            contact_point::NORMAL_VELOCITY,
            contact_point::CURVATURE,
        ]
        .into_iter()
        .chain(normal)
        {
            point[k] = its[k] - point[k];
        }
    }
}

/// The name of a contact with an edge, if there is one.
pub(crate) fn edge(model: &dyn Model) -> Option<&'static str> {
    let contacts = model.declaration().contacts.iter();
    let mut with_edge = contacts.filter(|known| !known.alternatives.is_empty());
    with_edge.next().map(|known| known.name)
}
