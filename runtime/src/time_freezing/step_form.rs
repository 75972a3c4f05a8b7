//! The program of the time-freezing system, as the solver for complementarity sees it.

use hangtime_solver::mpcc::Mpcc;
use hangtime_solver::nlp::NlpProblem;

use super::field::Field;
use super::task::{Outer, Task};
use super::transcription::Transcription;
use super::{conditions, guess, known, modes, rows};
use crate::program::sparse_program::Program;
use crate::rk::ButcherTableau;

/// Adds the variables and rows of `task`, which has at least one interval and element, to a program that has those of `outer`.
/// Where the motion is known, what vanishes in it is fixed.
pub(crate) fn transcribe<'a>(
    program: Program<'a>,
    outer: Outer,
    field: Field<'a>,
    tableau: &ButcherTableau,
    task: Task,
) -> Transcription<'a> {
    let mut transcription = Transcription::new(program, outer, field, tableau, task);
    conditions::add_pairs(&mut transcription);
    guess::set_guess(&mut transcription);
    rows::add(&mut transcription);
    known::fix_sides(&mut transcription);
    transcription
}

impl NlpProblem for Transcription<'_> {
    fn variables(&self) -> usize {
        self.program.variables()
    }

    fn constraints(&self) -> usize {
        self.program.constraints()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.program.variable_bounds(lower, upper);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.program.constraint_bounds(lower, upper);
    }

    fn initial_point(&self, x: &mut [f64]) {
        self.program.initial_point(x);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        self.program.objective(x)
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.program.gradient(x, gradient);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        self.program.constraint_values(x, c);
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.program.jacobian_pattern()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        self.program.jacobian_values(x, values);
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.program.hessian_pattern()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        self.program.hessian_values(x, weight, multipliers, values);
    }

    fn variable_name(&self, index: usize) -> String {
        self.program.variable_name(index)
    }

    fn constraint_name(&self, index: usize) -> String {
        self.program.constraint_name(index)
    }
}

impl Mpcc for Transcription<'_> {
    fn complementarities(&self) -> &[(usize, usize)] {
        self.program.complementarities()
    }

    fn complementarity_name(&self, index: usize) -> String {
        let (i, j) = self.complementarities()[index];
        let [first, second] = [i, j].map(|i| {
            let name = self.program.name(i);
            name.strip_prefix("sum of ").unwrap_or(name)
        });
        match (first.split_once(' '), second.split_once(' ')) {
            (Some((one, place)), Some((other, same))) if place == same => {
                format!("{one} _|_ {other} {place}")
            }
            _ => format!("{first} _|_ {second}"),
        }
    }

    fn vanishing_sides(&self, x: &[f64], vanishes: &mut [bool]) -> bool {
        modes::mark_vanishing(self, x, vanishes);
        true
    }
}
