//! Explicit functions of a scene as data: operations that may be carried out on other things than numbers, such as ranges of them.

pub use hangtime_dsl::description::{Function, Function2, Operation, Profile, Source, Spline};

/// What an explicit function of the input vector is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Explicit {
    /// The gap of a surface: one value.
    Gap(usize),
    /// Of a contact normal velocity, curvature and normal, `(v_n, curvature, n_1..n_nq)`, see
    /// [`contact_point`](super::contact_point); of dry friction its bound is there.
    Normal(usize),
    /// Of a contact with friction sliding velocity, curvature and tangent, `(v_t, curvature, b_1..b_nq)`, see
    /// [`tangent_point`](super::tangent_point).
    Tangent(usize),
    /// Of a contact with friction in space second sliding velocity, curvature and tangent.
    Across(usize),
    /// Of a contact with friction [`Model::friction_share`](super::Model::friction_share), where it declares one.
    Share(usize),
    /// Accelerations without contact, or the matrix and the right-hand side of the linear system that they solve.
    Motion,
}

/// A function as operations in order of evaluation.
#[derive(Debug, Clone, Copy)]
pub struct Tape<'a> {
    /// The operations; their operands are earlier ones, by position.
    pub operations: &'a [Operation],
    /// Positions of the operations that are the values.
    pub outputs: &'a [u32],
}
