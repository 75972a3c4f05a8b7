//! What a program is made of.

use std::ops::Range;

use super::terms::Term;

/// The row of the objective in the uses of a kernel.
pub(crate) const OBJECTIVE: usize = usize::MAX;

/// One use of a kernel.
pub(super) struct Block {
    pub(super) evaluator: usize,
    /// Variable of each local input; `None` where the kernel does not read it.
    pub(super) inputs: Vec<Option<usize>>,
    /// Variables whose product it is multiplied by.
    pub(super) scale: Vec<usize>,
    /// (row, or [`OBJECTIVE`]; output; coefficient).
    pub(super) uses: Vec<(usize, usize, f64)>,
}

impl Block {
    /// Whether it adds to the objective, or to rows.
    pub(super) fn serves(&self, objective: bool) -> bool {
        self.uses_of(objective).next().is_some()
    }

    /// Its uses in the objective, or in rows.
    pub(super) fn uses_of(&self, objective: bool) -> impl Iterator<Item = &(usize, usize, f64)> {
        let uses = self.uses.iter();
        uses.filter(move |used| (used.0 == OBJECTIVE) == objective)
    }
}

/// Linear and bilinear terms, `(row, variable, coefficient)` and `(row, variable, variable, coefficient)`, and others.
#[derive(Default)]
pub(super) struct Terms {
    pub(super) linear: Vec<(usize, usize, f64)>,
    pub(super) bilinear: Vec<(usize, usize, usize, f64)>,
    pub(super) products: Vec<Term>,
}

/// The unknowns.
#[derive(Default)]
pub(super) struct Variables {
    pub(super) lower: Vec<f64>,
    pub(super) upper: Vec<f64>,
    pub(super) guess: Vec<f64>,
    pub(super) unit: Vec<f64>,
    pub(super) names: Vec<String>,
}

/// The rows.
#[derive(Default)]
pub(super) struct Rows {
    pub(super) lower: Vec<f64>,
    pub(super) upper: Vec<f64>,
    pub(super) unit: Vec<f64>,
    pub(super) names: Vec<String>,
}

/// Memory of the evaluations.
#[derive(Default)]
pub(super) struct Scratch {
    /// Inputs of a kernel.
    pub(super) local: Vec<f64>,
    /// Values of the unknowns.
    pub(super) physical: Vec<f64>,
    /// Multipliers of the outputs of a kernel.
    pub(super) weights: Vec<f64>,
}

/// The names that a part of one list has in common with a part of another one, in their order: pairs of places.
pub(super) fn common(
    own: &[String],
    others: &[String],
    (here, there): (Range<usize>, Range<usize>),
) -> Vec<(usize, usize)> {
    let mut next = there.start;
    let found = |i: usize| {
        let same = others[next..there.end]
            .iter()
            .position(|name| *name == own[i])?;
        next += same + 1;
        Some((i, next - 1))
    };
    here.filter_map(found).collect()
}
