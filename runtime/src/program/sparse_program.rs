//! A sparse program made of polynomial rows and of model kernels.
//!
//! ```text
//! c_i(x) = sum linear + sum bilinear + sum products + sum coefficient scale kernel_output
//! ```
//!
//! and the objective as a sum of kernels and products, where `scale` is a product of variables, such as a duration. Values that callers give and get are physical; the
//! solver sees each variable divided by its own unit, so that all of them are of order one.

use std::ops::Range;

use hangtime_solver::mpcc::Mpcc;
use hangtime_solver::nlp::{NlpProblem, Pattern};

use super::haste::Haste;
use super::kernel::{Evaluator, Kernel};
use super::laws::Laws;
use super::parts::{Block, OBJECTIVE, Rows, Scratch, Terms, Variables, common};
use super::powers::objective_size;
use super::terms::{Term, curvatures, product, slopes};
use crate::model::Model;

/// The program.
pub(crate) struct Program<'a> {
    model: &'a dyn Model,
    evaluators: Vec<Evaluator<'a>>,
    blocks: Vec<Block>,
    terms: Terms,
    variables: Variables,
    rows: Rows,
    pub(crate) objective_unit: f64,
    pub(crate) objective_size: f64,
    /// Variables with a price in the objective, of their physical values.
    penalties: Vec<(usize, f64)>,
    haste: Haste,
    pairs: Vec<(usize, usize)>,
    laws: Laws,
    jacobian: Pattern,
    hessian: Pattern,
    scratch: Scratch,
}

impl<'a> Program<'a> {
    pub(crate) fn new(model: &'a dyn Model) -> Self {
        Self {
            model,
            evaluators: Vec::new(),
            blocks: Vec::new(),
            terms: Terms::default(),
            variables: Variables::default(),
            rows: Rows::default(),
            objective_unit: 1.0,
            objective_size: 1.0,
            penalties: Vec::new(),
            haste: Haste::default(),
            pairs: Vec::new(),
            laws: Laws::default(),
            jacobian: Pattern::default(),
            hessian: Pattern::default(),
            scratch: Scratch::default(),
        }
    }

    /// Says which variables are coefficients of the laws of contacts.
    pub(crate) fn set_laws(&mut self, laws: Laws) {
        self.laws = laws;
    }

    /// The variables that are coefficients of the laws of contacts.
    pub(crate) fn laws(&self) -> &Laws {
        &self.laws
    }

    /// Adds a variable with bounds, guess and unit.
    pub(crate) fn variable(
        &mut self,
        name: impl Into<String>,
        (lower, upper): (f64, f64),
        guess: f64,
        unit: f64,
    ) -> usize {
        self.variables.names.push(name.into());
        self.variables.lower.push(lower);
        self.variables.upper.push(upper);
        self.variables.guess.push(guess.clamp(lower, upper));
        self.variables.unit.push(unit);
        self.variables.names.len() - 1
    }

    /// Holds a variable at its lower bound.
    pub(crate) fn hold_at_lower(&mut self, variable: usize) {
        let lower = self.variables.lower[variable];
        self.variables.upper[variable] = lower;
        self.variables.guess[variable] = lower;
    }

    /// Leaves inequalities among the rows out.
    pub(crate) fn relax_rows(&mut self, rows: Range<usize>) {
        for row in rows {
            if self.rows.lower[row] < self.rows.upper[row] {
                self.rows.lower[row] = f64::NEG_INFINITY;
                self.rows.upper[row] = f64::INFINITY;
            }
        }
    }

    /// Numbers of variables and rows so far.
    pub(crate) fn extent(&self) -> (usize, usize) {
        (self.variables.names.len(), self.rows.names.len())
    }

    /// Whether a part of the variables and rows is the same as one of another program, by their names.
    pub(crate) fn is_like(
        &self,
        other: &Program,
        variables: &(Range<usize>, Range<usize>),
        rows: &(Range<usize>, Range<usize>),
    ) -> bool {
        self.variables.names[variables.0.clone()] == other.variables.names[variables.1.clone()]
            && self.rows.names[rows.0.clone()] == other.rows.names[rows.1.clone()]
    }

    /// The variables, and the rows, that a part has in common with one of another program, by their names and in their order:
    /// pairs of the one here and the one there.
    pub(crate) fn in_common(
        &self,
        other: &Program,
        variables: (Range<usize>, Range<usize>),
        rows: (Range<usize>, Range<usize>),
    ) -> [Vec<(usize, usize)>; 2] {
        [
            common(&self.variables.names, &other.variables.names, variables),
            common(&self.rows.names, &other.rows.names, rows),
        ]
    }

    /// Bounds of a variable.
    pub(crate) fn bounds(&self, variable: usize) -> (f64, f64) {
        (
            self.variables.lower[variable],
            self.variables.upper[variable],
        )
    }

    /// Where the solver starts, in physical values.
    pub(crate) fn guessed(&self, variable: usize) -> f64 {
        self.variables.guess[variable]
    }

    /// Name of a variable.
    pub(crate) fn name(&self, variable: usize) -> &str {
        &self.variables.names[variable]
    }

    /// Says where the solver starts, in physical values.
    pub(crate) fn set_guess(&mut self, variable: usize, value: f64) {
        self.variables.guess[variable] = value;
    }

    /// Narrows the bounds of a variable.
    pub(crate) fn bound(&mut self, variable: usize, lower: f64, upper: f64) {
        self.variables.lower[variable] = lower;
        self.variables.upper[variable] = upper;
        self.variables.guess[variable] = self.variables.guess[variable].clamp(lower, upper);
    }

    /// Adds a row `lower <= c <= upper` without terms.
    pub(crate) fn row(&mut self, name: impl Into<String>, lower: f64, upper: f64) -> usize {
        self.row_in(1.0, name, lower, upper)
    }

    /// Adds a row that the solver sees divided by a unit.
    pub(crate) fn row_in(
        &mut self,
        unit: f64,
        name: impl Into<String>,
        lower: f64,
        upper: f64,
    ) -> usize {
        self.rows.unit.push(unit);
        self.rows.names.push(name.into());
        self.rows.lower.push(lower);
        self.rows.upper.push(upper);
        self.rows.names.len() - 1
    }

    /// Adds `coefficient x_i` to a row.
    pub(crate) fn linear(&mut self, row: usize, i: usize, coefficient: f64) {
        if coefficient != 0.0 {
            self.terms.linear.push((row, i, coefficient));
        }
    }

    /// Adds `coefficient x_i x_j` to a row.
    pub(crate) fn bilinear(&mut self, row: usize, i: usize, j: usize, coefficient: f64) {
        self.terms.bilinear.push((row, i, j, coefficient));
    }

    /// Adds `coefficient` times a product of variables to a row, or to the objective.
    pub(crate) fn product(&mut self, row: usize, variables: &[usize], coefficient: f64) {
        let variables = variables.to_vec();
        self.terms.products.push(Term {
            row,
            variables,
            coefficient,
        });
    }

    /// Adds `coefficient scale output` for each (row, output, coefficient), where `scale` is the product of some variables; the
    /// inputs are the variables of `q`, `v`, `u` (or of `T` for terminal functions) and the forces, empty slices where the kernel
    /// reads nothing, which is 0 to it.
    pub(crate) fn block(
        &mut self,
        kernel: &Kernel,
        [q, v, u, forces]: [&[usize]; 4],
        scale: impl IntoIterator<Item = usize>,
        uses: Vec<(usize, usize, f64)>,
    ) {
        let evaluator = self.evaluator(kernel);
        let declaration = self.model.declaration();
        let n = declaration.coordinates.len();
        let mut inputs = vec![None; self.evaluators[evaluator].inputs()];
        for (start, variables) in [(0, q), (n, v), (2 * n, u), (declaration.inputs(), forces)] {
            let slots = inputs.iter_mut().skip(start);
            slots.zip(variables).for_each(|(slot, &x)| *slot = Some(x));
        }
        self.blocks.push(Block {
            evaluator,
            inputs,
            scale: scale.into_iter().collect(),
            uses,
        });
    }

    /// Adds a block of functions that read more: `behind` all else, where there is none for 0.
    pub(crate) fn block_behind(
        &mut self,
        kernel: &Kernel,
        [q, v, u]: [&[usize]; 3],
        behind: &[Option<usize>],
        scale: impl IntoIterator<Item = usize>,
        uses: Vec<(usize, usize, f64)>,
    ) {
        self.block(kernel, [q, v, u, &[]], scale, uses);
        if let Some(block) = self.blocks.last_mut() {
            let first = block.inputs.len() - behind.len();
            block.inputs[first..].copy_from_slice(behind);
        }
    }

    /// Index of the evaluator of a kernel.
    fn evaluator(&mut self, kernel: &Kernel) -> usize {
        let known = self.evaluators.iter().position(|e| e.kernel() == kernel);
        known.unwrap_or_else(|| {
            let evaluator = Evaluator::new(self.model, kernel.clone());
            self.evaluators.push(evaluator);
            self.evaluators.len() - 1
        })
    }

    /// Distance of each row from the nearest of its bounds, in its unit, at a solver's point.
    pub(crate) fn slacks(&mut self, x: &[f64]) -> Vec<f64> {
        let count = self.rows.names.len();
        let (mut lower, mut upper, mut c) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        self.constraint_bounds(&mut lower, &mut upper);
        self.constraint_values(x, &mut c);
        let slack = |((c, lower), upper): ((&f64, f64), f64)| (c - lower).min(upper - c).max(0.0);
        c.iter().zip(lower).zip(upper).map(slack).collect()
    }

    /// Adds `price` to the objective for each unit of these variables, in place of earlier prices.
    pub(crate) fn penalize(&mut self, variables: &[usize], price: f64) {
        let per_value = |&i: &usize| (i, price / self.variables.unit[i]);
        self.penalties = variables.iter().map(per_value).collect();
    }

    /// Adds so many sizes of the objective for each unit of the final time, 0 for none; call once, after everything else.
    pub(crate) fn hasten(self, horizon: usize, price: f64) -> Self {
        let haste = Haste::new(horizon, price * self.objective_size);
        Self { haste, ..self }
    }

    /// The objective at a solver's point without the price of the time, where there is one.
    pub(crate) fn cost_without_haste(&mut self, x: &[f64]) -> Option<f64> {
        let haste = self.haste.take()?;
        let cost = Some(self.objective(x) * self.objective_unit);
        self.haste = haste;
        cost
    }

    /// The price of a unit of a variable that has one.
    pub(crate) fn penalty(&self) -> f64 {
        let unit = |&(i, price): &(usize, f64)| price * self.variables.unit[i];
        self.penalties.first().map_or(0.0, unit)
    }

    /// Declares the pair `0 <= x_i _|_ x_j >= 0`.
    pub(crate) fn pair(&mut self, i: usize, j: usize) {
        self.pairs.push((i, j));
    }

    /// What the solver divides the objective by: the power nearest to its largest derivative by an unknown
    /// in its unit, where the `controls` are one unit off the guess. The solver itself takes derivatives above 100
    /// back to that.
    fn measure_objective(&mut self, controls: &[Vec<usize>], unit: impl Fn(f64) -> f64) {
        let mut x = vec![0.0; self.variables.names.len()];
        let mut gradient = vec![0.0; x.len()];
        self.initial_point(&mut x);
        for &u in controls.iter().flatten() {
            x[u] += 1.0;
        }
        self.gradient(&x, &mut gradient);
        let largest = gradient.iter().fold(0.0, |largest, g| g.abs().max(largest));
        self.objective_unit = unit(largest);
        self.objective_size = objective_size(largest);
    }

    /// Against what differences of an objective count: what it is, or, where it is next to nothing, the power of ten nearest to its largest
    /// derivative, if that is less than the unit. The unit itself may be a thousand times that.
    pub(crate) fn size_of(&self, objective: f64) -> f64 {
        objective.abs().max(self.objective_size)
    }

    /// Fixes the patterns and the unit of the objective, by its largest derivative; call once, after everything is added.
    pub(crate) fn finish(mut self, controls: &[Vec<usize>], unit: impl Fn(f64) -> f64) -> Self {
        self.measure_objective(controls, unit);
        let mut additions = Vec::new();
        self.visit_jacobian(&mut |row, column, _| additions.push((row, column)), None);
        self.jacobian = Pattern::new(&additions);
        additions.clear();
        self.visit_hessian(&mut |i, j, _| additions.push((i.max(j), i.min(j))), None);
        self.hessian = Pattern::new(&additions);
        self
    }

    /// Physical values of a solver's point.
    pub(crate) fn physical(&self, x: &[f64]) -> Vec<f64> {
        x.iter()
            .zip(&self.variables.unit)
            .map(|(x, unit)| x * unit)
            .collect()
    }

    /// Unit of a variable: multipliers of its bounds are per that unit.
    pub(crate) fn unit(&self, variable: usize) -> f64 {
        self.variables.unit[variable]
    }

    /// Unit of a row: its multiplier is per that unit.
    pub(crate) fn row_unit(&self, row: usize) -> f64 {
        self.rows.unit[row]
    }

    fn gather(&mut self, block: usize, x: &[f64]) {
        self.scratch.local.clear();
        let inputs = self.blocks[block].inputs.iter();
        self.scratch
            .local
            .extend(inputs.map(|slot| slot.map_or(0.0, |i| x[i])));
    }

    /// A point to stand where none is given.
    fn nowhere(&self, needed: bool) -> Vec<f64> {
        vec![0.0; usize::from(needed) * self.variables.unit.len()]
    }

    /// Calls `add` for every contribution to the Jacobian, in a fixed order; without a point the values are 0.
    fn visit_jacobian(&mut self, add: &mut dyn FnMut(usize, usize, f64), x: Option<&[f64]>) {
        for &(row, i, c) in &self.terms.linear {
            add(row, i, c);
        }
        let at = |i: usize| x.map_or(0.0, |x| x[i]);
        for &(row, i, j, c) in &self.terms.bilinear {
            add(row, i, c * at(j));
            add(row, j, c * at(i));
        }
        let nowhere = self.nowhere(x.is_none());
        let point = x.unwrap_or(&nowhere);
        for term in self.terms.products.iter().filter(|t| t.row != OBJECTIVE) {
            slopes(&term.variables, point, |i, slope| {
                add(term.row, i, term.coefficient * slope);
            });
        }
        self.visit_slopes(false, x, add);
    }

    /// Calls `add` for what every block adds to the rows, or to the objective.
    fn visit_values(&mut self, objective: bool, x: &[f64], add: &mut dyn FnMut(usize, f64)) {
        for index in 0..self.blocks.len() {
            if !self.blocks[index].serves(objective) {
                continue;
            }
            self.gather(index, x);
            let block = &self.blocks[index];
            let evaluator = &mut self.evaluators[block.evaluator];
            evaluator.evaluate(&self.scratch.local);
            let scale = product(&block.scale, &[], x);
            for &(row, output, c) in block.uses_of(objective) {
                add(row, c * scale * evaluator.outputs[output]);
            }
        }
    }

    /// Calls `add` for what every block adds to the derivatives of the rows, or of the objective; without a point the values are 0.
    fn visit_slopes(
        &mut self,
        objective: bool,
        x: Option<&[f64]>,
        add: &mut dyn FnMut(usize, usize, f64),
    ) {
        let nowhere = self.nowhere(x.is_none());
        let point = x.unwrap_or(&nowhere);
        for index in 0..self.blocks.len() {
            if !self.blocks[index].serves(objective) {
                continue;
            }
            if let Some(x) = x {
                self.gather(index, x);
                let evaluator = self.blocks[index].evaluator;
                self.evaluators[evaluator].differentiate(&self.scratch.local);
            }
            let block = &self.blocks[index];
            let evaluator = &self.evaluators[block.evaluator];
            let scale = product(&block.scale, &[], point);
            let inputs = block.inputs.len();
            for &(row, output, c) in block.uses_of(objective) {
                for &(_, input) in evaluator.jacobian_pattern.iter().filter(|e| e.0 == output) {
                    if let Some(variable) = block.inputs[input] {
                        let value = evaluator.jacobian[output * inputs + input];
                        add(row, variable, c * scale * value);
                    }
                }
                slopes(&block.scale, point, |variable, slope| {
                    add(row, variable, c * slope * evaluator.outputs[output]);
                });
            }
        }
    }

    /// Calls `add` for every contribution to the Hessian; `point` is (x, weight, multipliers).
    fn visit_hessian(
        &mut self,
        add: &mut dyn FnMut(usize, usize, f64),
        point: Option<(&[f64], f64, &[f64])>,
    ) {
        let multiplier = |row: usize| match point {
            Some((_, weight, _)) if row == OBJECTIVE => weight,
            Some((_, _, y)) => y[row],
            None => 0.0,
        };
        for &(row, i, j, c) in &self.terms.bilinear {
            let c = c * multiplier(row);
            add(i, j, if i == j { 2.0 * c } else { c });
        }
        let nowhere = self.nowhere(point.is_none());
        let at = point.map_or(&nowhere[..], |(x, ..)| x);
        for term in &self.terms.products {
            let c = term.coefficient * multiplier(term.row);
            curvatures(&term.variables, at, |i, j, curvature| {
                add(i, j, c * curvature)
            });
        }
        for index in 0..self.blocks.len() {
            let block = &self.blocks[index];
            let evaluator = &mut self.evaluators[block.evaluator];
            self.scratch.weights.clear();
            self.scratch.weights.resize(evaluator.outputs.len(), 0.0);
            for &(row, output, c) in &block.uses {
                self.scratch.weights[output] += c * multiplier(row);
            }
            if let Some((x, ..)) = point {
                self.gather(index, x);
                let evaluator = &mut self.evaluators[self.blocks[index].evaluator];
                evaluator.differentiate(&self.scratch.local);
                evaluator.curve(&self.scratch.local, &self.scratch.weights);
            }
            let block = &self.blocks[index];
            let evaluator = &self.evaluators[block.evaluator];
            let inputs = block.inputs.len();
            let scale = product(&block.scale, &[], at);
            for &(i, j) in &evaluator.hessian_pattern {
                if let (Some(a), Some(b)) = (block.inputs[i], block.inputs[j]) {
                    add(a, b, scale * evaluator.hessian[i * inputs + j]);
                }
            }
            if block.scale.is_empty() {
                continue;
            }
            for &(output, input) in &evaluator.jacobian_pattern {
                if let Some(variable) = block.inputs[input]
                    && block.uses.iter().any(|used| used.1 == output)
                {
                    let value = evaluator.jacobian[output * inputs + input];
                    slopes(&block.scale, at, |scale, slope| {
                        add(
                            scale,
                            variable,
                            self.scratch.weights[output] * value * slope,
                        );
                    });
                }
            }
            let weighted = self.scratch.weights.iter().zip(&evaluator.outputs);
            let total: f64 = weighted.map(|(weight, output)| weight * output).sum();
            curvatures(&block.scale, at, |i, j, curvature| {
                add(i, j, total * curvature)
            });
        }
    }

    /// Runs `work` with the physical values of `x`.
    fn with_physical<R>(&mut self, x: &[f64], work: impl FnOnce(&mut Self, &[f64]) -> R) -> R {
        let mut physical = std::mem::take(&mut self.scratch.physical);
        physical.clear();
        physical.extend(x.iter().zip(&self.variables.unit).map(|(x, unit)| x * unit));
        let result = work(self, &physical);
        self.scratch.physical = physical;
        result
    }
}

impl NlpProblem for Program<'_> {
    fn variables(&self) -> usize {
        self.variables.names.len()
    }

    fn constraints(&self) -> usize {
        self.rows.names.len()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        for (i, unit) in self.variables.unit.iter().enumerate() {
            lower[i] = self.variables.lower[i] / unit;
            upper[i] = self.variables.upper[i] / unit;
        }
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        for (i, unit) in self.rows.unit.iter().enumerate() {
            lower[i] = self.rows.lower[i] / unit;
            upper[i] = self.rows.upper[i] / unit;
        }
    }

    fn initial_point(&self, x: &mut [f64]) {
        for ((x, guess), unit) in x
            .iter_mut()
            .zip(&self.variables.guess)
            .zip(&self.variables.unit)
        {
            *x = guess / unit;
        }
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        let value = self.with_physical(x, |program, x| {
            let mut value = 0.0;
            program.visit_values(true, x, &mut |_, own| value += own);
            let own = program.terms.products.iter().filter(|t| t.row == OBJECTIVE);
            let own = own.map(|term| term.coefficient * product(&term.variables, &[], x));
            value + own.sum::<f64>()
        });
        let price = |&(i, price): &(usize, f64)| price * self.variables.unit[i] * x[i];
        let penalty: f64 = self.penalties.iter().map(price).sum();
        (value + penalty + self.haste.at(x)) / self.objective_unit
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
        self.with_physical(x, |program, x| {
            let unit = program.variables.unit.clone();
            program.visit_slopes(true, Some(x), &mut |_, variable, slope| {
                gradient[variable] += slope * unit[variable];
            });
            for term in program.terms.products.iter().filter(|t| t.row == OBJECTIVE) {
                slopes(&term.variables, x, |variable, slope| {
                    gradient[variable] += term.coefficient * slope * unit[variable];
                });
            }
        });
        for &(i, price) in &self.penalties {
            gradient[i] += price * self.variables.unit[i];
        }
        self.haste.add_to(gradient);
        gradient.iter_mut().for_each(|g| *g /= self.objective_unit);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        c.fill(0.0);
        self.with_physical(x, |program, x| {
            for &(row, i, coefficient) in &program.terms.linear {
                c[row] += coefficient * x[i];
            }
            for &(row, i, j, coefficient) in &program.terms.bilinear {
                c[row] += coefficient * x[i] * x[j];
            }
            for term in program.terms.products.iter().filter(|t| t.row != OBJECTIVE) {
                c[term.row] += term.coefficient * product(&term.variables, &[], x);
            }
            program.visit_values(false, x, &mut |row, own| c[row] += own);
        });
        for (c, unit) in c.iter_mut().zip(&self.rows.unit) {
            *c /= unit;
        }
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.jacobian.entries.clone()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        let places = std::mem::take(&mut self.jacobian.places);
        let mut next = places.iter();
        self.with_physical(x, |program, x| {
            let unit = program.variables.unit.clone();
            let row_unit = program.rows.unit.clone();
            let mut add = |row: usize, column: usize, value: f64| {
                if let Some(&place) = next.next() {
                    values[place] += value * unit[column] / row_unit[row];
                }
            };
            program.visit_jacobian(&mut add, Some(x));
        });
        self.jacobian.places = places;
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.hessian.entries.clone()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        let places = std::mem::take(&mut self.hessian.places);
        let mut next = places.iter();
        let weight = weight / self.objective_unit;
        let scaled = multipliers.iter().zip(&self.rows.unit);
        let multipliers: Vec<f64> = scaled.map(|(y, unit)| y / unit).collect();
        self.with_physical(x, |program, x| {
            let unit = program.variables.unit.clone();
            let mut add = |i: usize, j: usize, value: f64| {
                if let Some(&place) = next.next() {
                    values[place] += value * unit[i] * unit[j];
                }
            };
            program.visit_hessian(&mut add, Some((x, weight, &multipliers)));
        });
        self.hessian.places = places;
    }

    fn variable_name(&self, index: usize) -> String {
        self.variables.names[index].clone()
    }

    fn constraint_name(&self, index: usize) -> String {
        self.rows.names[index].clone()
    }
}

impl Mpcc for Program<'_> {
    fn complementarities(&self) -> &[(usize, usize)] {
        &self.pairs
    }
}
