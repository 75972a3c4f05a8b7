//! Explicit functions of a scene as data: operations that may be carried out on other things than numbers, such as ranges of them.

pub use hangtime_dsl::description::{
    ExplicitFunction as Explicit, Function, Function2, Operation, Profile, Source, Spline,
};

/// A function as operations in order of evaluation.
#[derive(Debug, Clone, Copy)]
pub struct Tape<'a> {
    /// The operations; their operands are earlier ones, by position.
    pub operations: &'a [Operation],
    /// Positions of the operations that are the values.
    pub outputs: &'a [u32],
}
