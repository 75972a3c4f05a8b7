//! A piece of a motion as polynomials, whose ranges over any part of it are known.
//!
//! A polynomial lies between the least and the greatest of its Bernstein coefficients over a part, which de Casteljau's halvings give for
//! that part. Source: Farouki, *The Bernstein polynomial basis: a centennial retrospective* (2012).

use nalgebra::DMatrix;
use std::f64::consts::PI;
use std::sync::OnceLock;

use super::range::Range;

/// Largest degree and one more.
const COEFFICIENTS: usize = 20;

/// How polynomials of one degree are made of values.
#[derive(Debug)]
struct Basis {
    /// Places through which they go.
    nodes: Vec<f64>,
    /// From values there to Bernstein coefficients, row-major.
    matrix: Vec<f64>,
}

/// Of all degrees.
static BASES: [OnceLock<Basis>; COEFFICIENTS] = [const { OnceLock::new() }; COEFFICIENTS];

impl Basis {
    fn new(degree: usize) -> Self {
        let count = degree + 1;
        let angle = |j: usize| PI * j as f64 / degree as f64;
        let nodes: Vec<f64> = (0..count).map(|j| 0.5 - 0.5 * angle(j).cos()).collect();
        let basis = DMatrix::from_fn(count, count, |row, k| bernstein(degree, k, nodes[row]));
        // Bernstein polynomials at different places are independent.
        let inverse = basis.try_inverse();
        let inverse = inverse.unwrap_or_else(|| DMatrix::zeros(count, count));
        Self {
            matrix: inverse.transpose().iter().copied().collect(),
            nodes,
        }
    }
}

/// Polynomials of one degree in a share of a step, from 0 to 1.
#[derive(Debug, Clone)]
pub(crate) struct Path {
    degree: usize,
    basis: &'static Basis,
    /// Coefficients of each polynomial, one after the other.
    coefficients: Vec<f64>,
    values: Vec<f64>,
}

impl Path {
    /// Polynomials of this degree, none yet.
    pub(crate) fn new(degree: usize) -> Self {
        let degree = degree.clamp(1, COEFFICIENTS - 1);
        Self {
            degree,
            basis: BASES[degree].get_or_init(|| Basis::new(degree)),
            coefficients: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Takes up the polynomials through the values `at` places of a piece, of as many components as there are `count`.
    pub(crate) fn follow(&mut self, count: usize, mut at: impl FnMut(f64, &mut [f64])) {
        let places = self.degree + 1;
        self.values.resize(places * count, 0.0);
        let rows = self.values.chunks_exact_mut(count.max(1));
        for (row, &node) in rows.zip(&self.basis.nodes) {
            at(node, row);
        }
        self.coefficients.clear();
        for component in 0..count {
            let values = || self.values[component..].iter().step_by(count);
            for row in self.basis.matrix.chunks_exact(places) {
                let terms = row.iter().zip(values());
                self.coefficients.push(terms.map(|(a, b)| a * b).sum());
            }
            // Ends are places, and not to be rounded.
            let first = component * places;
            self.coefficients[first] = self.values[component];
            self.coefficients[first + places - 1] = self.values[(places - 1) * count + component];
        }
    }

    /// The value of a component.
    pub(crate) fn value(&self, component: usize, at: f64) -> f64 {
        self.derivative(component, 0, [at, at]).low
    }

    /// The Bernstein coefficients over a part of the derivative of some order of a component by the share, and their number.
    fn over(&self, component: usize, order: usize, part: [f64; 2]) -> ([f64; COEFFICIENTS], usize) {
        let [from, to] = part;
        let mut n = self.degree;
        let mut c = [0.0; COEFFICIENTS];
        c[..=n].copy_from_slice(&self.coefficients[component * (n + 1)..][..=n]);
        for _ in 0..order.min(self.degree) {
            for k in 0..n {
                c[k] = n as f64 * (c[k + 1] - c[k]);
            }
            n -= 1;
        }
        if to < 1.0 {
            // Of de Casteljau's triangle for the left part one edge stays in place.
            for level in 1..=n {
                for k in (level..=n).rev() {
                    c[k] = (1.0 - to) * c[k - 1] + to * c[k];
                }
            }
        }
        if from > 0.0 {
            let share = from / to;
            for level in 1..=n {
                for k in 0..=n - level {
                    c[k] = (1.0 - share) * c[k] + share * c[k + 1];
                }
            }
        }
        (c, n + 1)
    }

    /// The range of a component over a part of the piece.
    pub(crate) fn range(&self, component: usize, part: [f64; 2]) -> Range {
        self.derivative(component, 0, part)
    }

    /// The range of its derivative of some order by the share over a part, which may be a place.
    pub(crate) fn derivative(&self, component: usize, order: usize, part: [f64; 2]) -> Range {
        let (c, count) = self.over(component, order, part);
        Range::hull(c[..count].iter().copied())
    }
}

fn bernstein(n: usize, k: usize, x: f64) -> f64 {
    let binomial: f64 = (0..k).map(|j| (n - j) as f64 / (k - j) as f64).product();
    binomial * x.powi(k as i32) * (1.0 - x).powi((n - k) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two components of degree 7 or less: `(x - 0.3)^2 (x - 2)` and a line.
    fn path() -> Path {
        let mut path = Path::new(7);
        path.follow(2, |x, out| {
            out[0] = (x - 0.3).powi(2) * (x - 2.0);
            out[1] = 3.0 - 2.0 * x;
        });
        path
    }

    #[test]
    fn ranges_contain_the_values_and_shrink_to_them() {
        let path = path();
        let value = |x: f64| (x - 0.3).powi(2) * (x - 2.0);
        for (a, b) in [(0.0, 1.0), (0.25, 0.5), (0.3, 0.31), (0.9, 1.0)] {
            let range = path.range(0, [a, b]);
            let values = (0..=100).map(|k| value(a + (b - a) * f64::from(k) / 100.0));
            let seen = Range::hull(values);
            assert!(range.low <= seen.low + 1e-14 && range.high >= seen.high - 1e-14);
            assert!(
                range.width() <= 1.5 * seen.width() + 1e-13,
                "{range:?} {seen:?}"
            );
        }
        let line = path.range(1, [0.25, 0.5]);
        assert!((line.low - 2.0).abs() < 1e-13 && (line.high - 2.5).abs() < 1e-13);
    }

    #[test]
    fn rates_are_those_of_the_derivative() {
        let path = path();
        let rate = |x: f64| 2.0 * (x - 0.3) * (x - 2.0) + (x - 0.3).powi(2);
        for (a, b) in [(0.0, 1.0), (0.25, 0.5), (0.3, 0.31)] {
            let range = path.derivative(0, 1, [a, b]);
            for x in [a, 0.5 * (a + b), b] {
                assert!(range.low - 1e-11 <= rate(x) && rate(x) <= range.high + 1e-11);
            }
        }
        let line = path.derivative(1, 1, [0.0, 1.0]);
        assert!((line.low + 2.0).abs() < 1e-12 && (line.high + 2.0).abs() < 1e-12);
        let bend = path.derivative(0, 2, [0.4, 0.4]);
        assert!((bend.low - (6.0 * 0.4 - 5.2)).abs() < 1e-10 && bend.width() < 1e-10);
        assert!((path.value(0, 0.7) + 0.4 * 0.4 * 1.3).abs() < 1e-14);
    }
}
