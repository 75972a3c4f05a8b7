//! Maxima and minima in surfaces.

use crate::graph::{Sym, Variable};

/// A maximum or a minimum, which a variable stands for until the surface that contains it is taken apart.
#[derive(Clone)]
pub(crate) struct Kink {
    pub(crate) variable: Variable,
    /// Whether it is the largest of its parts; the smallest otherwise.
    pub(crate) largest: bool,
    pub(crate) parts: Vec<Sym>,
}
