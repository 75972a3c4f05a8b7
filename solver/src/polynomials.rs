//! Problems of the tests: objective and rows are sums of products of variables.

use crate::mpcc::Mpcc;
use crate::nlp::NlpProblem;

/// Numbers times products of variables; one may stand several times in a product.
pub(crate) type Sum = Vec<(f64, &'static [usize])>;

/// `min objective` subject to `lower <= row <= upper`, bounds of the variables, and pairs.
#[derive(Default)]
pub(crate) struct Polynomials {
    pub(crate) bounds: Vec<(f64, f64)>,
    pub(crate) start: Vec<f64>,
    pub(crate) objective: Sum,
    pub(crate) rows: Vec<(f64, f64, Sum)>,
    pub(crate) pairs: Vec<(usize, usize)>,
}

/// Product of the values of variables but those at places that are left out.
fn product(variables: &[usize], left_out: &[usize], x: &[f64]) -> f64 {
    let kept = (0..variables.len()).filter(|place| !left_out.contains(place));
    kept.map(|place| x[variables[place]]).product()
}

fn value(sum: &Sum, x: &[f64]) -> f64 {
    let terms = sum.iter();
    terms.map(|(factor, of)| factor * product(of, &[], x)).sum()
}

impl Polynomials {
    /// Derivatives of the rows at a point: row, variable, value; what is of the same place adds up.
    fn slopes(&self, x: &[f64]) -> Vec<(usize, usize, f64)> {
        let rows = self.rows.iter().enumerate();
        let terms = rows.flat_map(|(row, (_, _, sum))| sum.iter().map(move |term| (row, term)));
        let each = terms.flat_map(|(row, (factor, of))| {
            (0..of.len()).map(move |k| (row, of[k], factor * product(of, &[k], x)))
        });
        let mut found: Vec<(usize, usize, f64)> = Vec::new();
        for (row, variable, slope) in each {
            match found.iter_mut().find(|f| (f.0, f.1) == (row, variable)) {
                Some(known) => known.2 += slope,
                None => found.push((row, variable, slope)),
            }
        }
        found
    }

    /// Second derivatives, with the weight of the objective behind those of the rows.
    fn curvatures(&self, x: &[f64], weights: &[f64]) -> Vec<(usize, usize, f64)> {
        let rows = self.rows.iter().map(|(_, _, sum)| sum);
        let sums = rows.chain([&self.objective]).zip(weights);
        let mut found = Vec::new();
        for (sum, weight) in sums {
            for &(factor, of) in sum {
                for k in 0..of.len() {
                    for l in 0..k {
                        let (i, j) = (of[k].max(of[l]), of[k].min(of[l]));
                        let twice = if i == j { 2.0 } else { 1.0 };
                        let value = weight * factor * twice * product(of, &[k, l], x);
                        found.push((i, j, value));
                    }
                }
            }
        }
        found
    }
}

impl NlpProblem for Polynomials {
    fn variables(&self) -> usize {
        self.bounds.len()
    }
    fn constraints(&self) -> usize {
        self.rows.len()
    }
    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        for (i, bounds) in self.bounds.iter().enumerate() {
            (lower[i], upper[i]) = *bounds;
        }
    }
    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        for (i, row) in self.rows.iter().enumerate() {
            (lower[i], upper[i]) = (row.0, row.1);
        }
    }
    fn initial_point(&self, x: &mut [f64]) {
        x.copy_from_slice(&self.start);
    }
    fn objective(&mut self, x: &[f64]) -> f64 {
        value(&self.objective, x)
    }
    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
        for (factor, of) in &self.objective {
            for (k, &i) in of.iter().enumerate() {
                gradient[i] += factor * product(of, &[k], x);
            }
        }
    }
    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        for (c, row) in c.iter_mut().zip(&self.rows) {
            *c = value(&row.2, x);
        }
    }
    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        let slopes = self.slopes(&self.start).into_iter();
        slopes.map(|(row, variable, _)| (row, variable)).collect()
    }
    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        for (value, slope) in values.iter_mut().zip(self.slopes(x)) {
            *value = slope.2;
        }
    }
    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        let zeros = vec![0.0; self.rows.len() + 1];
        let curvatures = self.curvatures(&self.start, &zeros).into_iter();
        let mut pattern: Vec<(usize, usize)> = curvatures.map(|(i, j, _)| (i, j)).collect();
        pattern.sort_unstable();
        pattern.dedup();
        pattern
    }
    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        let pattern = self.hessian_pattern();
        for (i, j, value) in self.curvatures(x, &[multipliers, &[weight]].concat()) {
            if let Ok(place) = pattern.binary_search(&(i, j)) {
                values[place] += value;
            }
        }
    }
}

impl Mpcc for Polynomials {
    fn complementarities(&self) -> &[(usize, usize)] {
        &self.pairs
    }
}
