//! What solvers ask of a scene, of its kernels: their values, and what follows from them by linear algebra, solutions of linear systems,
//! directions of contacts, and derivatives of these.

use super::data::{Rows, SparsityPattern, Structure, Vectors};
use super::functions::{Function, Order, contact_of, friction_of, signature};
use super::inertia::{Direction, Evaluate};
use super::places::contact_point;
use super::system::{Solution, zeros};
use super::variants::{Inertia, Kernels, Solved, System};
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
    /// Evaluates a function or one of its derivatives at `x`, weighted by multipliers.
    pub(super) fn evaluate(
        &self,
        (function, order): (Function, Order),
        (x, weights): (&[f64], &[f64]),
        out: &mut [f64],
    ) {
        let structure = self.structure;
        let task = structure.optimal_control.as_ref();
        let at = (order, x, weights);
        let side = |contact| friction_of(structure, contact).map(|(_, known)| known);
        let kernels = match function {
            Function::Motion => return self.motion(at, out),
            Function::Contact(contact) => return self.contact(contact, at, out),
            Function::Tangent(contact) => {
                let known = side(contact).map(|known| (known.tangent, &known.rows));
                return self.sided((function, known), at, out);
            }
            Function::Across(contact) => {
                let known = side(contact).and_then(|known| known.across.as_ref());
                let known = known.map(|(kernel, rows)| (*kernel, rows));
                return self.sided((function, known), at, out);
            }
            Function::Joints => structure.joints.map(|joints| joints.functions),
            Function::Path => task.and_then(|task| task.path),
            Function::Terminal => task.and_then(|task| task.terminal),
            Function::Impact => task.and_then(|task| task.impact),
            Function::Given => structure.held.and_then(|held| held.given),
        };
        if let Some((values, jacobian, hessian)) = kernels {
            let kernel = match order {
                Order::Value => values,
                Order::Jacobian => jacobian,
                Order::Hessian => hessian,
            };
            (self.evaluate)(kernel, x, weights, out);
        }
    }

    /// The acceleration without contact, or one of its derivatives.
    fn motion(&self, (order, x, weights): (Order, &[f64], &[f64]), out: &mut [f64]) {
        let structure = self.structure;
        let known = structure.motion;
        let kernel = match (order, known.derivatives) {
            (Order::Value, _) => known.acceleration,
            (Order::Jacobian, Kernels(jacobian, _)) => Some(jacobian),
            (Order::Hessian, Kernels(_, hessian)) => Some(hessian),
            _ => None,
        };
        let system = match (kernel, known.derivatives) {
            (Some(kernel), _) => return (self.evaluate)(kernel, x, weights, out),
            (None, Kernels(..)) => return out.fill(f64::NAN),
            (None, Solved(system)) => system,
        };
        match order {
            Order::Value => lend(|work| {
                self.solve(work, system, x);
                let size = structure.systems[system].size;
                out.copy_from_slice(&work.solution.y[size..][..out.len()]);
            }),
            Order::Jacobian => lend(|work| {
                self.differentiate(work, system, x);
                let pattern = structure.declaration.free_jacobian;
                work.solution.gather(pattern.entries, 0, out);
            }),
            Order::Hessian => {
                let pattern = structure.declaration.free_hessian;
                self.second((system, weights), x, (pattern, out));
            }
        }
    }

    /// Forces of joints, which stand behind the accelerations in the solution of the system of motion with the other sign.
    pub(super) fn joint_forces(&self, system: usize, x: &[f64], forces: &mut [f64]) {
        lend(|work| {
            self.solve(work, system, x);
            let size = self.structure.systems[system].size;
            let behind = size + self.structure.declaration.coordinates.len();
            for (force, y) in forces.iter_mut().zip(&work.solution.y[behind..]) {
                *force = -y;
            }
        });
    }

    /// A contact at a point, or derivatives of its rows.
    fn contact(&self, contact: usize, at: (Order, &[f64], &[f64]), out: &mut [f64]) {
        let structure = self.structure;
        let Some((declared, known)) = contact_of(structure, contact) else {
            return out.fill(f64::NAN);
        };
        let side = (Function::Contact(contact), (known.point, &known.rows));
        let solved = self.at_point(side, at, out);
        if !matches!(at.0, Order::Value) {
            return;
        }
        if let Some(inverse_inertia) = solved {
            // Of dry friction it is a formula.
            if !declared.dry {
                out[contact_point::INVERSE_INERTIA] = inverse_inertia;
            }
        } else if known.inertia_from_motion
            && let Solved(system) = structure.motion.derivatives
        {
            let n = structure.declaration.coordinates.len();
            let normal = &out[contact_point::NORMAL..][..n];
            let inverse = self.inverse_inertia(system, at.1, normal);
            out[contact_point::INVERSE_INERTIA] = inverse;
        }
    }

    /// A tangential side at a point, or derivatives of its rows; not a number where there is none.
    fn sided(
        &self,
        (function, known): (Function, Option<(usize, &Rows)>),
        at: (Order, &[f64], &[f64]),
        out: &mut [f64],
    ) {
        match known {
            Some(known) => _ = self.at_point((function, known), at, out),
            None => out.fill(f64::NAN),
        }
    }

    /// The values of a side in formulas, and behind them its direction; or derivatives of its rows. Returns the inverse inertia along the
    /// normal if it follows from the direction.
    fn at_point(
        &self,
        (function, (kernel, rows)): (Function, (usize, &Rows)),
        (order, x, weights): (Order, &[f64], &[f64]),
        out: &mut [f64],
    ) -> Option<f64> {
        match order {
            Order::Value => {
                (self.evaluate)(kernel, x, &[], out);
                rows.solved?;
                // The direction stands behind all formulas.
                let formulas = out.len() - self.structure.declaration.coordinates.len();
                return self.direction(rows, x, &mut out[formulas..]);
            }
            Order::Jacobian => {
                (self.evaluate)(rows.kernels.0, x, &[], out);
                let pattern = signature(self.structure, function)?.jacobian;
                self.rows_jacobian(rows, pattern, x, out);
            }
            Order::Hessian if rows.solved.is_some() => {
                let pattern = signature(self.structure, function)?.hessian;
                self.rows_hessian(rows, pattern, (x, weights), out);
            }
            Order::Hessian => (self.evaluate)(rows.kernels.1, x, weights, out),
        }
        None
    }

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
