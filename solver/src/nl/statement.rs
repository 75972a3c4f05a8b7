//! What a file states, before it becomes a program.

use super::graph::{Graph, NodeId};

/// An objective or a row: `sum coefficient x + expression`.
#[derive(Debug, Clone, Default)]
pub(super) struct Body {
    /// (variable, coefficient), each variable at most once.
    pub(super) linear: Vec<(usize, f64)>,
    pub(super) expression: Option<NodeId>,
}

/// What is asked of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Demand {
    /// Lower and upper bound.
    Bounds(f64, f64),
    /// The row complements a variable.
    Complements {
        variable: usize,
        /// Which bounds of the variable take part.
        lower: bool,
        upper: bool,
    },
}

/// Multipliers that a file gives beside its starting point, in the signs of modelling languages: rates of change of the objective with
/// the sides of rows and bounds.
#[derive(Debug, Clone, Default)]
pub(super) struct Duals {
    /// Of the rows (`d` segment).
    pub(super) rows: Vec<(usize, f64)>,
    /// Of the lower and the upper bounds (suffixes `ipopt_zL_in` and `ipopt_zU_in`).
    pub(super) lower: Vec<(usize, f64)>,
    pub(super) upper: Vec<(usize, f64)>,
}

/// What a file states.
#[derive(Debug, Default)]
pub(super) struct Statement {
    /// The options of the first line, which a solution file repeats.
    pub(super) options: Vec<String>,
    pub(super) graph: Graph,
    /// Bounds of the variables.
    pub(super) bounds: Vec<(f64, f64)>,
    pub(super) start: Vec<f64>,
    /// Multipliers to start from, as the file gives them; empty without any.
    pub(super) duals: Duals,
    pub(super) rows: Vec<(Body, Demand)>,
    pub(super) objective: Body,
    pub(super) maximizes: bool,
}
