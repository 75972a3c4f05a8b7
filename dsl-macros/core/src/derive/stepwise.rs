//! Motions of many coordinates that share long parts, as the links of a chain do.
//!
//! The normal forms of the graph flatten sums: the velocity of the last of `n` links is a sum of `n` terms, its energy one of
//! `n^2` products, and what is derived of all links grows with `n^3`. Evaluated in steps, each link adds to what is known of
//! the one before it. Where that takes fewer operations, all of the motion is derived from this evaluation, every
//! sum one quantity: `n` operations for the momenta, `n^2` for what has `n^2` entries.

use super::Sparse;
use super::explicit::{by_parameters, by_rows, lower_triangle, weighted};
use crate::graph::stepwise::{gradient, kept_sum, sweeps};
use crate::graph::{Sym, Variable};
use crate::tape;

/// How many times as long momenta have to be before they are derived in steps; what is simplified entry by entry is shorter
/// than it looks.
const SHORTER: usize = 2;

/// Most operations for each derivative of the equations of motion with which nothing is gained by flat sums: those of a
/// chain in absolute angles, simplified one by one, take five to seven.
const ENTRY: usize = 8;

/// Most operations of momenta, times their number, that are derived by flat sums where those take fewer operations in the end:
/// some two seconds.
const FLAT: usize = 36_000;

/// The stepwise evaluation of a Lagrangian.
pub(super) struct Evaluation {
    pub(super) lagrangian: Sym,
    /// `dL/dv`.
    pub(super) momenta: Vec<Sym>,
    /// Operations of the momenta by flat sums, times their number.
    flat: usize,
}

/// The evaluation in steps of a Lagrangian with these momenta by `velocities`, where it is much shorter than they are.
pub(super) fn evaluation(
    lagrangian: Sym,
    momenta: &[Sym],
    velocities: &[Variable],
) -> Option<Evaluation> {
    let lagrangian = *tape::shortest(&[lagrangian]).evaluated(kept_sum).first()?;
    let own = gradient(lagrangian, velocities);
    let (short, long) = (tape::operations(&own), tape::operations(momenta));
    (SHORTER * short < long).then_some(Evaluation {
        lagrangian,
        momenta: own,
        flat: long * momenta.len(),
    })
}

impl Evaluation {
    /// Whether the motion is to be derived from it: its derivatives take few operations, or those of flat sums too much work.
    /// `applied` is what acts on each coordinate.
    pub(super) fn is_worth_it(&self, applied: &[Sym], moving: usize, inputs: &[Variable]) -> bool {
        if self.flat > FLAT {
            return true;
        }
        let along = along_unknowns(self.momenta.len(), moving);
        let rates = sweeps(&self.momenta).directional(along);
        let residual = rates.iter().zip(applied);
        let residual: Vec<Sym> = residual.map(|(&rate, &acts)| rate - acts).collect();
        let derivatives = jacobian(&residual, inputs).values;
        tape::operations(&derivatives) <= ENTRY * derivatives.len()
    }
}

/// The motion, with unknown number `size + i` as the acceleration of coordinate `i`; those from `moving` on are held.
pub(super) fn along_unknowns(size: usize, moving: usize) -> impl Fn(Variable) -> Sym + Copy {
    move |variable| match variable {
        Variable::Coordinate(i) if usize::from(i) >= moving => Sym::ZERO,
        Variable::Coordinate(i) => Sym::variable(Variable::Velocity(i)),
        Variable::Velocity(i) => Sym::variable(Variable::Unknown(size as u16 + i)),
        Variable::Time => Sym::ONE,
        _ => Sym::ZERO,
    }
}

/// Nonzero derivatives of `outputs` with respect to `inputs`, row by row.
pub(super) fn jacobian(outputs: &[Sym], inputs: &[Variable]) -> Sparse {
    by_rows(&sweeps(outputs), outputs, inputs)
}

/// Nonzero second derivatives (lower triangle) of the outputs weighted by multipliers; none with respect to parameters.
pub(super) fn hessian(outputs: &[Sym], inputs: &[Variable]) -> Sparse {
    let n = inputs.len();
    if by_parameters(inputs) {
        return Sparse::nonzeros(n, n, std::iter::empty());
    }
    let weighted = weighted(outputs.iter().map(|&output| kept_sum(output)));
    let gradient = gradient(weighted, inputs);
    lower_triangle(&sweeps(&gradient), &gradient, inputs)
}
