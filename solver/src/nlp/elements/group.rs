//! Elements of one type: evaluation and differentiation in one loop.

use std::any::Any;

use num_dual::{Dual2SVec64, DualSVec64};

use super::{Element, Target};

/// Stands for the objective until the number of rows is known.
pub(crate) const OBJECTIVE: usize = usize::MAX;

/// A value's contribution to a target.
#[derive(Debug, Clone, Copy)]
struct Term {
    /// Row, or the number of rows for the objective.
    target: usize,
    coefficient: f64,
}

/// All elements of type `E` of a problem, structure of arrays.
pub(crate) struct TypedGroup<E, const N: usize, const M: usize> {
    elements: Vec<E>,
    variables: Vec<[usize; N]>,
    /// Terms of value `o` of element `k`: `term_starts[k M + o]..term_starts[k M + o + 1]`.
    terms: Vec<Term>,
    term_starts: Vec<usize>,
    /// Positions of each term's derivatives among the first derivatives.
    first_places: Vec<[u32; N]>,
    /// Positions of the lower triangle of each element, by rows, in the Hessian.
    second_places: Vec<u32>,
}

/// What a problem needs of its groups, whatever their type.
///
/// `out` is `(c, f)`, `first` the Jacobian values followed by the dense gradient, `weights` `(y, weight)`.
pub(crate) trait Group: Any {
    fn add_values(&self, x: &[f64], out: &mut [f64]);
    fn add_first(&self, x: &[f64], first: &mut [f64]);
    fn add_second(&self, x: &[f64], weights: &[f64], hessian: &mut [f64]);
    /// Replaces the objective among the targets by the number of rows, the place after the last row.
    fn place_objective(&mut self, rows: usize);
    /// Visits (target, variable) of each first derivative, in a fixed order.
    fn first_positions(&self, visit: &mut dyn FnMut(usize, usize));
    /// Visits (row, column), row >= column, of each second derivative, in a fixed order.
    fn second_positions(&self, visit: &mut dyn FnMut(usize, usize));
    /// Takes the places of the positions visited.
    fn set_places(&mut self, first: &[u32], second: &[u32]);
}

impl<E: Element<N, M>, const N: usize, const M: usize> TypedGroup<E, N, M> {
    pub(crate) fn new() -> Self {
        Self {
            elements: Vec::new(),
            variables: Vec::new(),
            terms: Vec::new(),
            term_starts: vec![0],
            first_places: Vec::new(),
            second_places: Vec::new(),
        }
    }

    /// Adds an element with the (target, coefficient) of each of its values.
    pub(crate) fn push(
        &mut self,
        element: E,
        variables: [usize; N],
        targets: [&[(Target, f64)]; M],
    ) {
        self.elements.push(element);
        self.variables.push(variables);
        for terms in targets {
            self.terms
                .extend(terms.iter().map(|&(target, coefficient)| Term {
                    target: match target {
                        Target::Objective => OBJECTIVE,
                        Target::Row(row) => row,
                    },
                    coefficient,
                }));
            self.term_starts.push(self.terms.len());
        }
    }

    /// Indices of the terms of value `o` of element `k`.
    fn terms_of(&self, k: usize, o: usize) -> std::ops::Range<usize> {
        self.term_starts[k * M + o]..self.term_starts[k * M + o + 1]
    }
}

impl<E: Element<N, M>, const N: usize, const M: usize> Group for TypedGroup<E, N, M> {
    fn add_values(&self, x: &[f64], out: &mut [f64]) {
        for (k, (element, variables)) in self.elements.iter().zip(&self.variables).enumerate() {
            let values = element.evaluate(&variables.map(|v| x[v]));
            for (o, value) in values.iter().enumerate() {
                for term in &self.terms[self.terms_of(k, o)] {
                    out[term.target] += term.coefficient * value;
                }
            }
        }
    }

    fn add_first(&self, x: &[f64], first: &mut [f64]) {
        for (k, (element, variables)) in self.elements.iter().zip(&self.variables).enumerate() {
            let point: [DualSVec64<N>; N] =
                std::array::from_fn(|i| DualSVec64::from_re(x[variables[i]]).derivative(i));
            let values = element.evaluate(&point);
            for (o, value) in values.iter().enumerate() {
                let Some(gradient) = &value.eps.0 else {
                    continue;
                };
                for t in self.terms_of(k, o) {
                    let coefficient = self.terms[t].coefficient;
                    for (&place, g) in self.first_places[t].iter().zip(gradient.iter()) {
                        first[place as usize] += coefficient * g;
                    }
                }
            }
        }
    }

    fn add_second(&self, x: &[f64], weights: &[f64], hessian: &mut [f64]) {
        let length = N * (N + 1) / 2;
        for (k, (element, variables)) in self.elements.iter().zip(&self.variables).enumerate() {
            let point: [Dual2SVec64<N>; N] =
                std::array::from_fn(|i| Dual2SVec64::from_re(x[variables[i]]).derivative(i));
            let values = element.evaluate(&point);
            let places = &self.second_places[k * length..(k + 1) * length];
            for (o, value) in values.iter().enumerate() {
                let Some(second) = &value.v2.0 else {
                    continue;
                };
                let weight: f64 = self.terms[self.terms_of(k, o)]
                    .iter()
                    .map(|term| term.coefficient * weights[term.target])
                    .sum();
                let mut place = places.iter();
                for i in 0..N {
                    for (j, &place) in place.by_ref().take(i + 1).enumerate() {
                        // both triangles of a variable that stands twice meet on the diagonal
                        let twice = i != j && variables[i] == variables[j];
                        let factor = if twice { 2.0 * weight } else { weight };
                        hessian[place as usize] += factor * second[(i, j)];
                    }
                }
            }
        }
    }

    fn place_objective(&mut self, rows: usize) {
        for term in &mut self.terms {
            if term.target == OBJECTIVE {
                term.target = rows;
            }
        }
    }

    fn first_positions(&self, visit: &mut dyn FnMut(usize, usize)) {
        for (k, variables) in self.variables.iter().enumerate() {
            for o in 0..M {
                for term in &self.terms[self.terms_of(k, o)] {
                    for &variable in variables {
                        visit(term.target, variable);
                    }
                }
            }
        }
    }

    fn second_positions(&self, visit: &mut dyn FnMut(usize, usize)) {
        for variables in &self.variables {
            for i in 0..N {
                for j in 0..=i {
                    let (a, b) = (variables[i], variables[j]);
                    visit(a.max(b), a.min(b));
                }
            }
        }
    }

    fn set_places(&mut self, first: &[u32], second: &[u32]) {
        self.first_places = first
            .chunks_exact(N)
            .map(|chunk| std::array::from_fn(|i| chunk[i]))
            .collect();
        self.second_places = second.to_vec();
    }
}
