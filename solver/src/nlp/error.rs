//! What can be wrong with the input.

use crate::InputError;

/// What can be wrong with a program; [`InputError`] carries its message to the user.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Fault {
    /// A setting lies outside its range.
    #[error("setting `{name}` is {value}; choose a value in {range}")]
    Setting {
        /// Name of the field.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The admissible range.
        range: &'static str,
    },
    /// A lower bound exceeds its upper bound, or one of them is not a number.
    #[error("{name}: lower bound {lower}, upper bound {upper}; give bounds with lower <= upper")]
    Bounds {
        /// Name of the variable or constraint.
        name: String,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// A component of the starting point is not finite.
    #[error("the starting point has {name} = {value}; give a finite value")]
    Start {
        /// Name of the variable.
        name: String,
        /// Its value.
        value: f64,
    },
    /// A pattern names a position outside the matrix.
    #[error(
        "the {matrix} pattern has entry ({row}, {column}) outside {rows} x {columns}; \
         indices start at 0, and the Hessian is given by its lower triangle"
    )]
    Pattern {
        /// Which matrix.
        matrix: &'static str,
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
        /// Rows of the matrix.
        rows: usize,
        /// Columns of the matrix.
        columns: usize,
    },
    /// Multipliers or a point of the wrong length were given for a warm start.
    #[error("warm start: expected {expected} entries of {what}, got {found}")]
    WarmStart {
        /// Which vector.
        what: &'static str,
        /// Its right length.
        expected: usize,
        /// The length found.
        found: usize,
    },
    /// A function is not finite at the starting point.
    #[error("{what} is not finite at the starting point; start inside the domain of the functions")]
    NotFiniteAtStart {
        /// The function, by name.
        what: String,
    },
    /// A complementarity pair is not a pair of two variables bounded below by zero.
    #[error("pair {index} ({first}, {second}): {fault}")]
    Complementarity {
        /// Index of the pair.
        index: usize,
        /// First variable.
        first: usize,
        /// Second variable.
        second: usize,
        /// What is wrong and how to mend it.
        fault: &'static str,
    },
    /// The Newton matrix is too large for its symbolic analysis.
    #[error(
        "{variables} variables and {constraints} constraints, or their nonzeros, are too many for the memory or the 32-bit \
         indices of the factorization; state a smaller problem"
    )]
    Size {
        /// Number of variables.
        variables: usize,
        /// Number of constraints.
        constraints: usize,
    },
}

impl From<Fault> for InputError {
    fn from(fault: Fault) -> Self {
        Self::new(fault.to_string())
    }
}
