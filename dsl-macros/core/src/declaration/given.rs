//! What a scene declares with parameters as coordinates without motion.

use super::SparsityPattern;

/// Parameters that stand behind the coordinates of a scene as coordinates without motion, and behind them what is remembered of its
/// start, see `Model::with_held`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Held {
    /// Their indices among the parameters, in the order of these coordinates.
    pub parameters: &'static [usize],
    /// Components of the start `(q, v)` of the scene itself that the coordinates behind those are, and decide: those of
    /// `Model::remembered`.
    pub starts: &'static [usize],
    /// Number of coordinates behind those that are largest values, the `Model::epigraphs` of the end and of the
    /// whole motion.
    pub largest: usize,
    /// Of the last controls, which are largest values of each instant, the numbers of their conditions, which are the last path
    /// constraints: each a function that is the control less a value.
    pub at_stages: &'static [usize],
    /// What of start, horizon and laws depends on them; the start, the horizon and the laws of the model itself have the values
    /// that the parameters were given.
    pub given: &'static [Given],
    /// Pattern of the Jacobian of `Model::given_values` with respect to `x`.
    pub jacobian: SparsityPattern,
    /// Pattern (lower triangle) of the Hessian of the weighted `Model::given_values`.
    pub hessian: SparsityPattern,
}

impl Held {
    /// Number of coordinates without motion.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.parameters.len() + self.starts.len() + self.largest
    }
}

/// What a scene declares as a function of parameters alone, by the index of a component of the start `(q, v)` or of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Given {
    /// A component of the start `(q, v)`, where it is not free.
    Start(usize),
    /// The length of the motion.
    Horizon,
    /// The coefficient of restitution of a contact.
    Restitution(usize),
    /// The coefficient of friction of a contact.
    Friction(usize),
}
