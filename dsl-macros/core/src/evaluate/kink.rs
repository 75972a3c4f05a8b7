//! Maxima and minima in surfaces, and switches of what acts.

use crate::diagnostics::Place;
use crate::graph::{self, Sym, Variable};

/// A maximum or a minimum, which a variable stands for until the surface that contains it is taken apart.
#[derive(Clone)]
pub(crate) struct Kink {
    pub(crate) variable: Variable,
    /// Whether it is the largest of its parts; the smallest otherwise.
    pub(crate) largest: bool,
    pub(crate) parts: Vec<Sym>,
}

/// The largest value of a quantity over the motion.
#[derive(Clone)]
pub(crate) struct Peak {
    pub(crate) variable: Variable,
    pub(crate) value: Sym,
    /// As written, with `peak`.
    pub(crate) shown: String,
}

/// A function of the motion whose sign switches what acts.
#[derive(Clone)]
pub(crate) struct Switch {
    /// What stands for the sign of `function`, or for its size where it is a kink.
    pub(crate) variable: Variable,
    pub(crate) function: Sym,
    /// Whether only the derivative of what acts jumps.
    pub(crate) kink: bool,
    /// As written.
    pub(crate) shown: String,
    pub(crate) place: Place,
}

/// Whether a value contains a switch.
pub(super) fn has_switch(components: &[Sym]) -> bool {
    let mut variables = graph::variables(components).into_iter();
    variables.any(|variable| matches!(variable, Variable::Switch(_)))
}
