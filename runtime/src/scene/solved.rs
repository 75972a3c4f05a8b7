//! What follows from kernels by linear algebra: solutions of linear systems, directions of contacts, and their derivatives.

use super::data::{Rows, SparsityPattern, Structure, Vectors};
use super::inertia::{Direction, Evaluate};
use super::system::{Solution, zeros};
use super::variants::{Inertia, System};
use std::cell::Cell;

/// The kernels of a scene and how they are put together.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub(super) structure: &'static Structure,
    pub(super) evaluate: Evaluate<'a>,
}

/// Memory of a thread, so that no call allocates after the first ones.
#[derive(Debug, Default)]
pub(super) struct Work {
    /// Values of a kernel on their way elsewhere.
    values: Vec<f64>,
    /// Values of a second kernel.
    others: Vec<f64>,
    pub(super) solution: Solution,
}

thread_local! {
    static WORK: Cell<Option<Box<Work>>> = const { Cell::new(None) };
}

/// Lends the memory of this thread.
pub(super) fn lend<T>(work: impl FnOnce(&mut Work) -> T) -> T {
    let mut memory = WORK.take().unwrap_or_default();
    let result = work(&mut memory);
    WORK.set(Some(memory));
    result
}

impl View<'_> {
    /// As many values of a kernel as `count`, in lent memory.
    fn values(
        &self,
        values: &mut Vec<f64>,
        (kernel, count): (usize, usize),
        (x, y): (&[f64], &[f64]),
    ) {
        zeros(values, count);
        (self.evaluate)(kernel, x, y, values);
    }

    /// Solves a linear system.
    pub(super) fn solve(&self, work: &mut Work, system: usize, x: &[f64]) {
        let system = &self.structure.systems[system];
        let count = system.size * (system.size + 1);
        self.values(&mut work.values, (system.solve, count), (x, &[]));
        work.solution.solve_system(&work.values, system.size);
    }

    /// Solves a linear system and differentiates the solution.
    pub(super) fn differentiate(&self, work: &mut Work, system: usize, x: &[f64]) {
        self.solve(work, system, x);
        let (kernel, pattern) = self.structure.systems[system].jacobian;
        let (values, solution) = (&mut work.values, &mut work.solution);
        self.values(values, (kernel, pattern.len()), (x, &solution.y));
        solution.differentiate(pattern, values, self.structure.columns());
    }

    /// Second derivatives of the weighted solution of a linear system; weights behind those given are zero.
    pub(super) fn second(
        &self,
        (system, weights): (usize, &[f64]),
        x: &[f64],
        (pattern, out): (SparsityPattern, &mut [f64]),
    ) {
        lend(|work| {
            self.differentiate(work, system, x);
            let system = &self.structure.systems[system];
            let mut lambda = std::mem::take(&mut work.solution.vectors[1]);
            lambda.clear();
            lambda.extend_from_slice(weights);
            lambda.resize(system.size, 0.0);
            work.solution.solve_transposed(&lambda);
            work.solution.vectors[1] = lambda;
            let (residual, cross) = (system.hessian, system.cross);
            let of = (x, &work.solution.y[..]);
            self.values(&mut work.values, (residual.0, residual.1.len()), of);
            self.values(&mut work.others, (cross.0, cross.1.len()), of);
            work.solution.pull_back(
                (residual.1, &work.values),
                (cross.1, &work.others),
                pattern.entries,
                out,
            );
        });
    }

    /// The direction behind what is known at a point by formulas, if it is solved for. Gives the inverse inertia along the normal if that
    /// follows from it.
    pub(super) fn direction(&self, rows: &Rows, x: &[f64], direction: &mut [f64]) -> Option<f64> {
        match rows.solved?.by {
            Inertia(vectors) => self.by_inertia(vectors, x, |own| own.value(direction)),
            System(system) => Some(lend(|work| {
                let size = self.structure.systems[system].size;
                self.solve(work, system, x);
                direction.copy_from_slice(&work.solution.y[size..][..direction.len()]);
                1.0 / work.solution.y[2 * size - 1]
            })),
        }
    }

    /// The inverse inertia along a normal, by the system of the motion.
    pub(super) fn inverse_inertia(&self, system: usize, x: &[f64], normal: &[f64]) -> f64 {
        lend(|work| {
            self.solve(work, system, x);
            let mut along = std::mem::take(&mut work.solution.vectors[0]);
            zeros(&mut along, normal.len());
            work.solution.solve(normal, &mut along);
            let inverse = along.iter().zip(normal).map(|(a, b)| a * b).sum();
            work.solution.vectors[0] = along;
            inverse
        })
    }

    /// Lends a direction that is solved for with the inertia of the scene.
    fn by_inertia<T>(
        &self,
        vectors: Vectors,
        x: &[f64],
        work: impl FnOnce(&Direction<'_>) -> T,
    ) -> Option<T> {
        Some(work(&Direction {
            inertia: self.structure.inertia?,
            vectors,
            inputs: self.structure.columns(),
            evaluate: self.evaluate,
            x,
        }))
    }

    /// Derivatives of the rows behind formulas, in the places of a pattern behind those of the formulas.
    pub(super) fn rows_jacobian(
        &self,
        rows: &Rows,
        pattern: SparsityPattern,
        x: &[f64],
        values: &mut [f64],
    ) {
        let Some(solved) = rows.solved else { return };
        let below = (&pattern.entries[solved.nonzeros..], solved.formulas);
        let values = &mut values[solved.nonzeros..];
        match solved.by {
            Inertia(vectors) => {
                self.by_inertia(vectors, x, |own| own.jacobian(below, values));
            }
            System(system) => lend(|work| {
                self.differentiate(work, system, x);
                work.solution.gather(below.0, below.1, values);
            }),
        }
    }

    /// Second derivatives of weighted rows, of which some are solved for.
    pub(super) fn rows_hessian(
        &self,
        rows: &Rows,
        pattern: SparsityPattern,
        (x, multipliers): (&[f64], &[f64]),
        values: &mut [f64],
    ) {
        let Some(solved) = rows.solved else { return };
        let weights = &multipliers[solved.formulas..];
        match solved.by {
            Inertia(vectors) => {
                let places = pattern.entries;
                self.by_inertia(vectors, x, |own| own.hessian(weights, places, values));
            }
            System(system) => self.second((system, weights), x, (pattern, values)),
        }
        let of_formulas = (rows.kernels.1, solved.places.len());
        lend(|work| {
            self.values(&mut work.values, of_formulas, (x, multipliers));
            for (&place, value) in solved.places.iter().zip(&work.values) {
                values[place] += value;
            }
        });
    }
}
