//! Rest where the functions of switches vanish together.

/// A rest: of each contact that touches the part of its sides in the mixture, in `-1..=1`.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Rest {
    pub(crate) contacts: Vec<usize>,
    pub(crate) parts: Vec<f64>,
}

impl Rest {
    /// The part of a contact, if it is one of those that hold the rest.
    pub(crate) fn part(&self, contact: usize) -> Option<f64> {
        let slot = self.contacts.iter().position(|&other| other == contact)?;
        Some(self.parts[slot])
    }
}
