//! What a scene declares with parameters as coordinates without motion.

use super::SparsityPattern;

/// Parameters that stand behind the coordinates of a scene as coordinates without motion, see [`Model::with_held`](super::Model::with_held).
#[derive(Debug, Clone, Copy)]
pub struct Held {
    /// Their indices among the parameters, in the order of these coordinates, which are the last ones.
    pub parameters: &'static [usize],
    /// What of start, horizon and laws depends on them; the start, the horizon and the laws of the model itself have the values
    /// that the parameters were given.
    pub given: &'static [Given],
    /// Pattern of the Jacobian of [`Model::given_values`](super::Model::given_values) with respect to `x`.
    pub jacobian: SparsityPattern,
    /// Pattern (lower triangle) of the Hessian of the weighted [`Model::given_values`](super::Model::given_values).
    pub hessian: SparsityPattern,
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
