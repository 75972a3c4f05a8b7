//! Expressions of equal shape, evaluated together, with exact first and second derivatives.

use super::expression::{Expression, Function, Shape, Slot};

/// Instances evaluated at once.
const LANES: usize = 8;
type Lanes = [f64; LANES];

/// All expressions of one shape.
#[derive(Debug, Clone)]
pub(crate) struct Batch {
    shape: Vec<Slot>,
    functions: Vec<Option<Function>>,
    /// Which expression of the problem each instance is.
    pub(crate) members: Vec<usize>,
    /// Constants and variables of each instance.
    constants: Vec<Vec<f64>>,
    pub(crate) variables: Vec<Vec<usize>>,
    value: Vec<Lanes>,
    first: Vec<Lanes>,
    second: Vec<Lanes>,
    tangent: Vec<Lanes>,
    bar: Vec<Lanes>,
    bar_tangent: Vec<Lanes>,
}

/// Groups expressions by shape.
pub(crate) fn group<'e>(expressions: impl Iterator<Item = &'e Expression>) -> Vec<Batch> {
    let mut batches: Vec<Batch> = Vec::new();
    let mut known: std::collections::HashMap<Shape, usize> = std::collections::HashMap::new();
    for (member, expression) in expressions.enumerate() {
        let (shape, constants, variables) = expression.shape();
        let k = *known.entry(shape.clone()).or_insert_with(|| {
            let n = shape.0.len();
            let functions = shape
                .0
                .iter()
                .map(|slot| match slot {
                    Slot::Unary(key, _) => Some(Function::from_key(*key)),
                    _ => None,
                })
                .collect();
            batches.push(Batch {
                shape: shape.0,
                functions,
                members: Vec::new(),
                constants: Vec::new(),
                variables: Vec::new(),
                value: vec![[0.0; LANES]; n],
                first: vec![[0.0; LANES]; n],
                second: vec![[0.0; LANES]; n],
                tangent: vec![[0.0; LANES]; n],
                bar: vec![[0.0; LANES]; n],
                bar_tangent: vec![[0.0; LANES]; n],
            });
            batches.len() - 1
        });
        batches[k].members.push(member);
        batches[k].constants.push(constants);
        batches[k].variables.push(variables);
    }
    batches
}

fn combine(a: Lanes, b: Lanes, f: impl Fn(f64, f64) -> f64) -> Lanes {
    std::array::from_fn(|l| f(a[l], b[l]))
}

fn add(target: &mut Lanes, a: Lanes) {
    for (t, a) in target.iter_mut().zip(a) {
        *t += a;
    }
}

impl Batch {
    /// Starts of the groups of lanes.
    fn chunks(&self) -> impl Iterator<Item = usize> + use<> {
        (0..self.members.len()).step_by(LANES)
    }

    /// Values of instances `start..`; lanes beyond the last instance repeat it.
    fn forward(&mut self, start: usize, x: &[f64]) {
        let last = self.members.len() - 1;
        for k in 0..self.shape.len() {
            self.value[k] = match self.shape[k] {
                Slot::Constant(c) => {
                    std::array::from_fn(|l| self.constants[(start + l).min(last)][c])
                }
                Slot::Variable(v) => {
                    std::array::from_fn(|l| x[self.variables[(start + l).min(last)][v]])
                }
                Slot::Sum(p, q) => combine(self.value[p], self.value[q], |a, b| a + b),
                Slot::Product(p, q) => combine(self.value[p], self.value[q], |a, b| a * b),
                Slot::Unary(_, p) => {
                    let mut value = [0.0; LANES];
                    if let Some(f) = self.functions[k] {
                        for (l, value) in value.iter_mut().enumerate() {
                            let (v, first, second) = f.evaluate(self.value[p][l]);
                            *value = v;
                            self.first[k][l] = first;
                            self.second[k][l] = second;
                        }
                    }
                    value
                }
            };
        }
    }

    /// Adjoints of the nodes for the weights of the results.
    fn reverse(&mut self, weights: Lanes) {
        self.bar.fill([0.0; LANES]);
        let n = self.shape.len();
        self.bar[n - 1] = weights;
        for k in (0..n).rev() {
            let b = self.bar[k];
            match self.shape[k] {
                Slot::Constant(_) | Slot::Variable(_) => {}
                Slot::Sum(p, q) => {
                    add(&mut self.bar[p], b);
                    add(&mut self.bar[q], b);
                }
                Slot::Product(p, q) => {
                    add(&mut self.bar[p], combine(b, self.value[q], |b, v| b * v));
                    add(&mut self.bar[q], combine(b, self.value[p], |b, v| b * v));
                }
                Slot::Unary(_, p) => {
                    add(&mut self.bar[p], combine(b, self.first[k], |b, d| b * d));
                }
            }
        }
    }

    /// Calls `result(member, value)`.
    pub(crate) fn values(&mut self, x: &[f64], result: &mut dyn FnMut(usize, f64)) {
        for start in self.chunks() {
            self.forward(start, x);
            let values = self.value[self.shape.len() - 1];
            for (&member, value) in self.members[start..].iter().zip(values) {
                result(member, value);
            }
        }
    }

    /// Calls `result(instance, local variable, derivative)` for the occurrences of variables.
    pub(crate) fn gradients(&mut self, x: &[f64], result: &mut dyn FnMut(usize, usize, f64)) {
        for start in self.chunks() {
            self.forward(start, x);
            self.reverse([1.0; LANES]);
            let lanes = (self.members.len() - start).min(LANES);
            for (k, slot) in self.shape.iter().enumerate() {
                if let Slot::Variable(v) = *slot {
                    for l in 0..lanes {
                        result(start + l, v, self.bar[k][l]);
                    }
                }
            }
        }
    }

    /// Calls `result(instance, local row, local column, second derivative)`, forward over reverse, with
    /// the weight of each member.
    pub(crate) fn hessians(
        &mut self,
        x: &[f64],
        weight: &dyn Fn(usize) -> f64,
        result: &mut dyn FnMut(usize, usize, usize, f64),
    ) {
        let n = self.shape.len();
        for start in self.chunks() {
            let lanes = (self.members.len() - start).min(LANES);
            let last = self.members.len() - 1;
            let weights: Lanes =
                std::array::from_fn(|l| weight(self.members[(start + l).min(last)]));
            if weights[..lanes].iter().all(|w| *w == 0.0) {
                continue;
            }
            self.forward(start, x);
            self.reverse(weights);
            for column in 0..self.variables[start].len() {
                for k in 0..n {
                    self.tangent[k] = match self.shape[k] {
                        Slot::Constant(_) => [0.0; LANES],
                        Slot::Variable(v) => [f64::from(u8::from(v == column)); LANES],
                        Slot::Sum(p, q) => combine(self.tangent[p], self.tangent[q], |a, b| a + b),
                        Slot::Product(p, q) => {
                            let left = combine(self.tangent[p], self.value[q], |a, b| a * b);
                            let right = combine(self.value[p], self.tangent[q], |a, b| a * b);
                            combine(left, right, |a, b| a + b)
                        }
                        Slot::Unary(_, p) => combine(self.first[k], self.tangent[p], |a, b| a * b),
                    };
                }
                self.bar_tangent.fill([0.0; LANES]);
                for k in (0..n).rev() {
                    let (b, t) = (self.bar[k], self.bar_tangent[k]);
                    match self.shape[k] {
                        Slot::Constant(_) => {}
                        Slot::Variable(row) => {
                            for (l, t) in t.iter().enumerate().take(lanes) {
                                if *t != 0.0 {
                                    result(start + l, row, column, *t);
                                }
                            }
                        }
                        Slot::Sum(p, q) => {
                            add(&mut self.bar_tangent[p], t);
                            add(&mut self.bar_tangent[q], t);
                        }
                        Slot::Product(p, q) => {
                            let by_q = combine(t, self.value[q], |a, b| a * b);
                            let by_p = combine(t, self.value[p], |a, b| a * b);
                            add(&mut self.bar_tangent[p], by_q);
                            add(
                                &mut self.bar_tangent[p],
                                combine(b, self.tangent[q], |a, b| a * b),
                            );
                            add(&mut self.bar_tangent[q], by_p);
                            add(
                                &mut self.bar_tangent[q],
                                combine(b, self.tangent[p], |a, b| a * b),
                            );
                        }
                        Slot::Unary(_, p) => {
                            let curved = combine(self.second[k], self.tangent[p], |a, b| a * b);
                            add(
                                &mut self.bar_tangent[p],
                                combine(t, self.first[k], |a, b| a * b),
                            );
                            add(&mut self.bar_tangent[p], combine(b, curved, |a, b| a * b));
                        }
                    }
                }
            }
        }
    }
}
