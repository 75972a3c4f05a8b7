//! Coefficients of the laws of contacts that are unknowns of a program.

/// Variables that are coefficients of the laws of contacts, where those are unknowns; empty where none is.
#[derive(Debug, Clone, Default)]
pub(crate) struct Laws {
    pub(crate) restitution: Vec<Option<usize>>,
    pub(crate) friction: Vec<Option<usize>>,
}

impl Laws {
    /// The coefficient of restitution of a contact, if it is an unknown.
    pub(crate) fn restitution(&self, contact: usize) -> Option<usize> {
        self.restitution.get(contact).copied().flatten()
    }

    /// The coefficient of friction of a contact, if it is an unknown.
    pub(crate) fn friction(&self, contact: usize) -> Option<usize> {
        self.friction.get(contact).copied().flatten()
    }
}
