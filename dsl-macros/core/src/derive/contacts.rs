//! All contacts of a scene, of which equal ones are derived once.

use super::alike::Names;
use super::contact_equations::ContactEquations;
use crate::graph::Sym;
use std::ops::Deref;

/// One of them.
pub(crate) enum Derived {
    Own(Box<ContactEquations>),
    /// As the contact with this number, which is derived, under other names.
    Like(usize, Names),
}

/// What is derived of all contacts of a scene.
#[derive(Default)]
pub(crate) struct Contacts {
    all: Vec<Derived>,
}

/// The equations of one contact.
pub(crate) enum Known<'a> {
    Own(&'a ContactEquations),
    Renamed(Box<ContactEquations>),
}

impl Deref for Known<'_> {
    type Target = ContactEquations;

    fn deref(&self) -> &ContactEquations {
        match self {
            Self::Own(own) => own,
            Self::Renamed(renamed) => renamed,
        }
    }
}

impl Contacts {
    pub(super) fn push(&mut self, derived: Derived) {
        self.all.push(derived);
    }

    pub(crate) fn len(&self) -> usize {
        self.all.len()
    }

    /// Those that are derived.
    pub(super) fn own(&self) -> impl Iterator<Item = &ContactEquations> {
        self.all.iter().filter_map(|derived| match derived {
            Derived::Own(own) => Some(&**own),
            Derived::Like(..) => None,
        })
    }

    /// All of them in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Known<'_>> {
        (0..self.all.len()).map(|contact| self.get(contact))
    }

    /// What a contact is.
    pub(crate) fn derived(&self) -> &[Derived] {
        &self.all
    }

    /// The equations of a contact.
    pub(crate) fn get(&self, contact: usize) -> Known<'_> {
        self.renamed(contact, Names::contact)
    }

    /// The equations of a contact, without derivatives where they are those of another one.
    pub(crate) fn values(&self, contact: usize) -> Known<'_> {
        self.renamed(contact, Names::values)
    }

    fn renamed(
        &self,
        contact: usize,
        by: fn(&Names, &ContactEquations) -> ContactEquations,
    ) -> Known<'_> {
        match &self.all[contact] {
            Derived::Own(own) => Known::Own(own),
            Derived::Like(like, names) => {
                Known::Renamed(Box::new(by(names, &self.renamed(*like, by))))
            }
        }
    }

    /// Adds to a contact that is derived what a unit of the force of another one adds to its bound.
    pub(super) fn follow(&mut self, contact: usize, followed: usize, load: Sym) {
        if let Derived::Own(own) = &mut self.all[contact] {
            own.followed.push(followed);
            own.loads.push(load);
        }
    }
}
