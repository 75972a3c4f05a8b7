//! Functions as formulas, with their derivatives.

use super::simplify::simplify_all;
use crate::graph::{self, Sweeps, Sym, Variable};
use crate::tape;
use std::collections::{BTreeMap, BTreeSet};

/// Most operations of formulas whose derivatives are tried as formulas; those of longer ones were never the
/// cheaper ones.
const DIFFERENTIATED: usize = 120;

/// Most operations of derivatives for which no second way of deriving them is tried.
const SHORT: usize = 40;

/// Values of a sparse matrix with their positions.
#[derive(Default)]
pub(crate) struct Sparse {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) entries: Vec<(usize, usize)>,
    pub(crate) values: Vec<Sym>,
}

/// A vector-valued function of the inputs with its derivatives.
#[derive(Default)]
pub(crate) struct Explicit {
    pub(crate) values: Vec<Sym>,
    pub(crate) jacobian: Sparse,
    pub(crate) hessian: Sparse,
}

impl Sparse {
    /// The structural nonzeros of a matrix.
    pub(super) fn nonzeros(
        rows: usize,
        columns: usize,
        entries: impl Iterator<Item = ((usize, usize), Sym)>,
    ) -> Self {
        let (entries, values) = entries
            .filter(|(_, value)| !value.is_structural_zero())
            .unzip();
        Self {
            rows,
            columns,
            entries,
            values,
        }
    }

    /// These in their cheapest common form.
    fn simplified(self) -> Self {
        let values = simplify_all(&self.values);
        let entries = self.entries.into_iter().zip(values);
        Self::nonzeros(self.rows, self.columns, entries)
    }

    /// Of two forms of the same matrix the cheaper one, at the positions that are nonzero in both.
    pub(super) fn cheaper(self, other: Self) -> Self {
        let common = |one: Self, other: &Self| {
            let positions: BTreeSet<(usize, usize)> = other.entries.iter().copied().collect();
            let entries = one.entries.into_iter().zip(one.values);
            let kept = entries.filter(|(entry, _)| positions.contains(entry));
            Self::nonzeros(one.rows, one.columns, kept)
        };
        let first = common(self, &other);
        let second = common(other, &first);
        let (own, its) = (tape::cost(&first.values), tape::cost(&second.values));
        if its < own { second } else { first }
    }
}

impl Explicit {
    pub(super) fn new(values: Vec<Sym>, inputs: &[Variable]) -> Self {
        Self {
            jacobian: jacobian(&values, inputs),
            hessian: hessian(&values, inputs),
            values,
        }
    }

    /// The components of both; the Hessians are those of weighted sums, and add up.
    pub(super) fn followed_by(mut self, other: Self) -> Self {
        let rows = self.values.len();
        let below = other.jacobian.entries.iter();
        let below = below.map(|&(row, column)| (rows + row, column));
        self.jacobian.entries.extend(below);
        self.jacobian.values.extend(other.jacobian.values);
        self.jacobian.rows += other.jacobian.rows;
        self.values.extend(other.values);
        let own = self.hessian.entries.into_iter().zip(self.hessian.values);
        let mut sums: BTreeMap<(usize, usize), Sym> = own.collect();
        for (entry, value) in other.hessian.entries.into_iter().zip(other.hessian.values) {
            *sums.entry(entry).or_insert(Sym::ZERO) += value;
        }
        self.hessian =
            Sparse::nonzeros(other.hessian.rows, other.hessian.columns, sums.into_iter());
        self
    }

    /// Some rows followed by a vector of `n` components that is zero but for those listed, of which the rows behind them
    /// are.
    pub(super) fn spread(mut self, rows: usize, n: usize, listed: &[usize]) -> Self {
        let place = |row: usize| match row.checked_sub(rows) {
            Some(k) => rows + listed[k],
            None => row,
        };
        let mut values = self.values[..rows].to_vec();
        values.resize(rows + n, Sym::ZERO);
        for (row, value) in self.values.into_iter().enumerate().skip(rows) {
            values[place(row)] = value;
        }
        for (row, _) in &mut self.jacobian.entries {
            *row = place(*row);
        }
        self.jacobian.rows = rows + n;
        Self { values, ..self }
    }

    /// Formulas whose derivatives are taken of themselves or from `written_out`, the same function by
    /// elimination, whichever takes fewer operations.
    pub(super) fn cheapest(
        values: Vec<Sym>,
        written_out: impl FnOnce() -> Self,
        inputs: &[Variable],
    ) -> Self {
        if tape::operations(&values) > DIFFERENTIATED {
            return Self {
                values,
                ..written_out()
            };
        }
        let formulas = Self::new(values, inputs);
        let length = tape::operations(&formulas.jacobian.values)
            + tape::operations(&formulas.hessian.values);
        if length <= SHORT {
            return formulas;
        }
        let written_out = written_out();
        Self {
            values: formulas.values,
            jacobian: formulas.jacobian.cheaper(written_out.jacobian),
            hessian: formulas.hessian.cheaper(written_out.hessian),
        }
    }
}

/// Nonzero derivatives of `outputs` with respect to `inputs`, row by row.
pub(crate) fn jacobian(outputs: &[Sym], inputs: &[Variable]) -> Sparse {
    by_rows(&Sweeps::over(outputs), outputs, inputs).simplified()
}

/// The same from the `sweeps` of the outputs, as they come.
pub(super) fn by_rows(sweeps: &Sweeps, outputs: &[Sym], inputs: &[Variable]) -> Sparse {
    let columns = columns(sweeps, outputs, inputs);
    let entries = (0..outputs.len()).flat_map(|i| (0..inputs.len()).map(move |j| (i, j)));
    let entries = entries.map(|(i, j)| ((i, j), columns[j][i]));
    Sparse::nonzeros(outputs.len(), inputs.len(), entries)
}

/// The lower triangle of the derivatives of a gradient, from its `sweeps`.
pub(super) fn lower_triangle(sweeps: &Sweeps, gradient: &[Sym], inputs: &[Variable]) -> Sparse {
    let (columns, n) = (columns(sweeps, gradient, inputs), inputs.len());
    let entries = (0..n).flat_map(|i| (0..=i).map(move |j| (i, j)));
    let entries = entries.map(|(i, j)| ((i, j), columns[j][i]));
    Sparse::nonzeros(n, n, entries)
}

/// Derivatives of `outputs` by each input, from their `sweeps`; of most inputs of a contact nothing depends.
pub(super) fn columns(sweeps: &Sweeps, outputs: &[Sym], inputs: &[Variable]) -> Vec<Vec<Sym>> {
    let known = graph::variables(outputs);
    let column = |&input: &Variable| match known.contains(&input) {
        true => sweeps.partial(input),
        false => vec![Sym::ZERO; outputs.len()],
    };
    inputs.iter().map(column).collect()
}

/// The sum of outputs weighted by multipliers.
pub(super) fn weighted(outputs: impl Iterator<Item = Sym>) -> Sym {
    let multiplier = |i: usize| Sym::variable(Variable::Multiplier(i as u16));
    let terms = outputs.enumerate();
    terms.map(|(i, output)| multiplier(i) * output).sum()
}

/// Nonzero second derivatives (lower triangle) of the outputs weighted by multipliers, by two ways of which
/// now one and now the other takes fewer operations: adjoints, then a sweep of dual numbers for
/// each input; or one sweep that carries second derivatives, over the shortest evaluation.
///
/// None with respect to parameters: nothing that differentiates a motion by those reads second derivatives.
pub(super) fn hessian(outputs: &[Sym], inputs: &[Variable]) -> Sparse {
    if by_parameters(inputs) {
        return Sparse::nonzeros(inputs.len(), inputs.len(), std::iter::empty());
    }
    let weighted = weighted(outputs.iter().copied());
    let gradient = simplify_all(&graph::gradient(weighted, inputs));
    let by_columns = lower_triangle(&Sweeps::over(&gradient), &gradient, inputs).simplified();
    if tape::operations(&by_columns.values) < SHORT {
        return by_columns;
    }
    let evaluation = tape::shortest(&[weighted]).stepwise();
    let entries = graph::hessian(evaluation[0], inputs);
    let at_once = Sparse::nonzeros(inputs.len(), inputs.len(), entries.into_iter());
    by_columns.cheaper(at_once)
}

/// Whether parameters are among what is differentiated by.
pub(super) fn by_parameters(inputs: &[Variable]) -> bool {
    let mut inputs = inputs.iter();
    inputs.any(|input| matches!(input, Variable::Parameter(_)))
}
