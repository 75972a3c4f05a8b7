//! Programs that fall apart: parts that share no variable, row or term of the objective are programs of their own.
//!
//! Ten copies of a program whose certificate takes two branches ask for a thousand branches as a whole, and for twenty as ten.

use super::program::Program;
use crate::mpcc::Mpcc;
use crate::nlp::NlpProblem;

/// Most parts: each evaluates the whole program. What is left beyond them is one part more.
const MOST: usize = 64;

/// The variables of the parts of a program, in ascending order; one part where it does not fall apart. Those without complementarity are
/// one part together.
pub(super) fn components(program: &Program) -> Vec<Vec<usize>> {
    let n = program.variables();
    let mut parents: Vec<usize> = (0..n).collect();
    let mut first = vec![None; program.constraints()];
    for (row, column) in program.jacobian_pattern() {
        let other = *first[row].get_or_insert(column);
        unite(&mut parents, other, column);
    }
    for (i, j) in program.hessian_pattern() {
        unite(&mut parents, i, j);
    }
    for &(i, j) in program.complementarities() {
        unite(&mut parents, i, j);
    }
    let mut part_of = vec![None; n];
    let mut parts: Vec<Vec<usize>> = Vec::new();
    for &(i, _) in program.complementarities() {
        let root = root(&mut parents, i);
        if part_of[root].is_none() {
            if parts.len() <= MOST {
                parts.push(Vec::new());
            }
            part_of[root] = Some(parts.len() - 1);
        }
    }
    let mut rest = Vec::new();
    for i in 0..n {
        match part_of[root(&mut parents, i)] {
            Some(part) => parts[part].push(i),
            None => rest.push(i),
        }
    }
    if !rest.is_empty() {
        parts.push(rest);
    }
    parts
}

/// The one that stands for all that `i` is united with.
fn root(parents: &mut [usize], mut i: usize) -> usize {
    while parents[i] != i {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    i
}

fn unite(parents: &mut [usize], i: usize, j: usize) {
    let (i, j) = (root(parents, i), root(parents, j));
    parents[i.max(j)] = i.min(j);
}

/// A part of a program; all other variables stay where they are.
pub(super) struct Component<'a> {
    program: &'a mut Program,
    /// A point of the whole program.
    x: Vec<f64>,
    pub(super) variables: Vec<usize>,
    pub(super) rows: Vec<usize>,
    pairs: Vec<(usize, usize)>,
    /// Entries of the derivatives, with their places among those of the whole program.
    jacobian: Vec<(usize, (usize, usize))>,
    hessian: Vec<(usize, (usize, usize))>,
    whole: Whole,
}

/// Values of the whole program.
struct Whole {
    gradient: Vec<f64>,
    rows: Vec<f64>,
    multipliers: Vec<f64>,
    jacobian: Vec<f64>,
    hessian: Vec<f64>,
}

impl<'a> Component<'a> {
    /// The part with these variables; `x` is a point of the whole program.
    pub(super) fn new(program: &'a mut Program, variables: Vec<usize>, x: &[f64]) -> Self {
        let (n, m) = (program.variables(), program.constraints());
        let mut place = vec![None; n];
        for (local, &i) in variables.iter().enumerate() {
            place[i] = Some(local);
        }
        let pattern = program.jacobian_pattern();
        let mut rows: Vec<usize> = pattern
            .iter()
            .filter(|entry| place[entry.1].is_some())
            .map(|entry| entry.0)
            .collect();
        rows.sort_unstable();
        rows.dedup();
        let mut row_place = vec![0; m];
        for (local, &row) in rows.iter().enumerate() {
            row_place[row] = local;
        }
        let entries = pattern.iter().enumerate();
        let jacobian = entries.filter_map(|(k, &(row, i))| Some((k, (row_place[row], place[i]?))));
        let jacobian = jacobian.collect();
        let second = program.hessian_pattern();
        let hessian = second.iter().enumerate();
        let hessian = hessian.filter_map(|(k, &(i, j))| Some((k, (place[i]?, place[j]?))));
        let hessian = hessian.collect();
        let pairs = program.complementarities().iter();
        let pairs = pairs.filter_map(|&(i, j)| Some((place[i]?, place[j]?)));
        Self {
            pairs: pairs.collect(),
            x: x.to_vec(),
            variables,
            rows,
            jacobian,
            hessian,
            whole: Whole {
                gradient: vec![0.0; n],
                rows: vec![0.0; m],
                multipliers: vec![0.0; m],
                jacobian: vec![0.0; pattern.len()],
                hessian: vec![0.0; second.len()],
            },
            program,
        }
    }

    fn move_to(&mut self, x: &[f64]) {
        for (&i, x) in self.variables.iter().zip(x) {
            self.x[i] = *x;
        }
    }

    fn of_variables(&self, whole: &[f64], own: &mut [f64]) {
        for (own, &i) in own.iter_mut().zip(&self.variables) {
            *own = whole[i];
        }
    }

    fn of_rows(&self, whole: &[f64], own: &mut [f64]) {
        for (own, &row) in own.iter_mut().zip(&self.rows) {
            *own = whole[row];
        }
    }
}

impl NlpProblem for Component<'_> {
    fn variables(&self) -> usize {
        self.variables.len()
    }

    fn constraints(&self) -> usize {
        self.rows.len()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        let mut whole = (self.x.clone(), self.x.clone());
        self.program.variable_bounds(&mut whole.0, &mut whole.1);
        self.of_variables(&whole.0, lower);
        self.of_variables(&whole.1, upper);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        let mut whole = (self.whole.rows.clone(), self.whole.rows.clone());
        self.program.constraint_bounds(&mut whole.0, &mut whole.1);
        self.of_rows(&whole.0, lower);
        self.of_rows(&whole.1, upper);
    }

    fn initial_point(&self, x: &mut [f64]) {
        let mut whole = self.x.clone();
        self.program.initial_point(&mut whole);
        self.of_variables(&whole, x);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        self.move_to(x);
        self.program.objective(&self.x)
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.move_to(x);
        self.program.gradient(&self.x, &mut self.whole.gradient);
        self.of_variables(&self.whole.gradient, gradient);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        self.move_to(x);
        self.program
            .constraint_values(&self.x, &mut self.whole.rows);
        self.of_rows(&self.whole.rows, c);
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.jacobian.iter().map(|entry| entry.1).collect()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        self.move_to(x);
        self.program
            .jacobian_values(&self.x, &mut self.whole.jacobian);
        for (value, entry) in values.iter_mut().zip(&self.jacobian) {
            *value = self.whole.jacobian[entry.0];
        }
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.hessian.iter().map(|entry| entry.1).collect()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        self.move_to(x);
        for (&row, y) in self.rows.iter().zip(multipliers) {
            self.whole.multipliers[row] = *y;
        }
        let Whole {
            multipliers,
            hessian,
            ..
        } = &mut self.whole;
        self.program
            .hessian_values(&self.x, weight, multipliers, hessian);
        for (value, entry) in values.iter_mut().zip(&self.hessian) {
            *value = hessian[entry.0];
        }
    }

    fn variable_name(&self, index: usize) -> String {
        self.program.variable_name(self.variables[index])
    }

    fn constraint_name(&self, index: usize) -> String {
        self.program.constraint_name(self.rows[index])
    }
}

impl Mpcc for Component<'_> {
    fn complementarities(&self) -> &[(usize, usize)] {
        &self.pairs
    }
}
