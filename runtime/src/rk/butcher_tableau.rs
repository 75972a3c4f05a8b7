//! Butcher tableaus of the collocation schemes, with dense output.

use super::nodes;

/// Families of collocation schemes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scheme {
    /// Radau IIA: `c_s = 1`, order `2 s - 1`, stiffly accurate; keeps its order in contact.
    /// Source: Hairer, Wanner, Solving ODEs II, section IV.5.
    #[default]
    RadauIia,
    /// Gauss-Legendre: order `2 s`, not stiffly accurate. Source: Hairer, Lubich, Wanner, Geometric
    /// Numerical Integration, section II.1.3.
    GaussLegendre,
}

impl Scheme {
    /// Name used on the command line and in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::RadauIia => "radau-iia",
            Self::GaussLegendre => "gauss-legendre",
        }
    }

    /// Classical order with `stages` stages.
    #[must_use]
    pub fn order(self, stages: usize) -> usize {
        match self {
            Self::RadauIia => 2 * stages - 1,
            Self::GaussLegendre => 2 * stages,
        }
    }
}

/// Coefficients of a collocation scheme:
///
/// ```text
/// c_1 | a_11 ... a_1s
///  :  |  :        :
/// c_s | a_s1 ... a_ss
/// ----+--------------
///     | b_1  ... b_s
/// ```
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ButcherTableau {
    scheme: Scheme,
    a: Vec<f64>,
    a_squared: Vec<f64>,
    b: Vec<f64>,
    b_times_a: Vec<f64>,
    c: Vec<f64>,
    /// Places and weights that integrate the polynomials of the nodes exactly.
    rule: Vec<[f64; 2]>,
}

impl ButcherTableau {
    /// Largest number of stages offered.
    pub(crate) const MAX_STAGES: usize = 9;

    /// The scheme with `stages` stages, `1..=MAX_STAGES`; `None` outside.
    #[must_use]
    pub(crate) fn new(scheme: Scheme, stages: usize) -> Option<Self> {
        if !(1..=Self::MAX_STAGES).contains(&stages) {
            return None;
        }
        let c = match scheme {
            Scheme::RadauIia => nodes::radau_iia(stages),
            Scheme::GaussLegendre => nodes::gauss_legendre(stages),
        };
        let rule = gauss_rule(stages.div_ceil(2));
        let mut a = vec![0.0; stages * stages];
        for (i, row) in a.chunks_exact_mut(stages).enumerate() {
            lagrange_integrals(&c, &rule, c[i], row);
        }
        let mut b = vec![0.0; stages];
        lagrange_integrals(&c, &rule, 1.0, &mut b);
        let mut a_squared = vec![0.0; stages * stages];
        let mut b_times_a = vec![0.0; stages];
        for j in 0..stages {
            for k in 0..stages {
                b_times_a[j] += b[k] * a[k * stages + j];
                for i in 0..stages {
                    a_squared[i * stages + j] += a[i * stages + k] * a[k * stages + j];
                }
            }
        }
        Some(Self {
            scheme,
            a,
            a_squared,
            b,
            b_times_a,
            c,
            rule,
        })
    }

    /// Number of stages `s`.
    #[must_use]
    pub(crate) fn stages(&self) -> usize {
        self.c.len()
    }

    /// Coefficient `a_ij`.
    #[must_use]
    pub(crate) fn a(&self, i: usize, j: usize) -> f64 {
        self.a[i * self.c.len() + j]
    }

    /// Coefficient `(A^2)_ij`, for second-order systems.
    #[must_use]
    pub(crate) fn a_squared(&self, i: usize, j: usize) -> f64 {
        self.a_squared[i * self.c.len() + j]
    }

    /// Weights `b`.
    #[must_use]
    pub(crate) fn b(&self) -> &[f64] {
        &self.b
    }

    /// Weights `(b'A)_j`, for second-order systems.
    #[must_use]
    pub(crate) fn b_times_a(&self) -> &[f64] {
        &self.b_times_a
    }

    /// Nodes `c`.
    #[must_use]
    pub(crate) fn c(&self) -> &[f64] {
        &self.c
    }

    /// Whether the last stage is the end of the step (`c_s = 1`).
    #[must_use]
    pub(crate) fn stiffly_accurate(&self) -> bool {
        self.scheme == Scheme::RadauIia
    }

    /// Dense output weights `b_j(theta) = int_0^theta l_j`: `x(theta) = x_0 + h sum_j b_j(theta) k_j`.
    /// `weights` has length `s`.
    pub(crate) fn dense_weights(&self, theta: f64, weights: &mut [f64]) {
        lagrange_integrals(&self.c, &self.rule, theta, weights);
    }

    /// Values `l_j(theta)` of the Lagrange polynomials of the nodes; `values` has length `s`.
    pub(crate) fn lagrange_values(&self, theta: f64, values: &mut [f64]) {
        for (j, value) in values.iter_mut().enumerate() {
            *value = lagrange(&self.c, j, theta);
        }
    }

    /// Weights of the values at the nodes for the coefficient of the Legendre polynomial of this `degree`, below `s`, of the
    /// polynomial through them: the scheme integrates the product of both exactly. `weights` has length `s`.
    pub(crate) fn legendre_weights(&self, degree: usize, weights: &mut [f64]) {
        let norm = (2 * degree + 1) as f64;
        for ((weight, b), c) in weights.iter_mut().zip(&self.b).zip(&self.c) {
            *weight = norm * b * nodes::legendre(degree, 2.0 * c - 1.0).0;
        }
    }

    /// Values `l_j(theta)` of the Lagrange polynomials of the nodes `0, c_1 .. c_s`.
    pub(crate) fn values_with_start(&self, theta: f64) -> Vec<f64> {
        let nodes = self.nodes_with_start();
        let others = |j: usize| (0..nodes.len()).filter(move |&k| k != j);
        let factor = |j: usize, k: usize| (theta - nodes[k]) / (nodes[j] - nodes[k]);
        (0..nodes.len())
            .map(|j| others(j).map(|k| factor(j, k)).product())
            .collect()
    }

    /// Weights `l_j^2 (1 - 2 l_j'(c_j) (theta - c_j))` of values and `l_j^2 (theta - c_j)` of slopes at the same nodes: Hermite's
    /// polynomial, which has both.
    pub(crate) fn hermite_with_start(&self, theta: f64) -> Vec<(f64, f64)> {
        let nodes = self.nodes_with_start();
        let slope = |j: usize| -> f64 {
            let others = (0..nodes.len()).filter(|&k| k != j);
            others.map(|k| 1.0 / (nodes[j] - nodes[k])).sum()
        };
        let lagrange = self.values_with_start(theta).into_iter().enumerate();
        let weights = lagrange.map(|(j, value)| {
            let (square, distance) = (value * value, theta - nodes[j]);
            (
                square * (1.0 - 2.0 * slope(j) * distance),
                square * distance,
            )
        });
        weights.collect()
    }

    /// Slopes `l_j'(theta)` of the same.
    pub(crate) fn slopes_with_start(&self, theta: f64) -> Vec<f64> {
        let nodes = self.nodes_with_start();
        let others = |j: usize| (0..nodes.len()).filter(move |&k| k != j);
        let factor = |j: usize, k: usize| (theta - nodes[k]) / (nodes[j] - nodes[k]);
        let without = |j: usize, i: usize| -> f64 {
            let rest = others(j).filter(|&k| k != i);
            rest.map(|k| factor(j, k)).product()
        };
        (0..nodes.len())
            .map(|j| {
                others(j)
                    .map(|i| without(j, i) / (nodes[j] - nodes[i]))
                    .sum()
            })
            .collect()
    }

    fn nodes_with_start(&self) -> Vec<f64> {
        std::iter::once(0.0).chain(self.c.iter().copied()).collect()
    }
}

/// `l_j(x)` in product form, accurate to a few units in the last place.
fn lagrange(c: &[f64], j: usize, x: f64) -> f64 {
    c.iter()
        .enumerate()
        .filter(|&(k, _)| k != j)
        .map(|(_, &node)| (x - node) / (c[j] - node))
        .product()
}

/// Places and weights of a Gauss rule on `[0, 1]`: `1 / ((1 - y^2) P'(y)^2)` at `y = 2 node - 1`.
fn gauss_rule(points: usize) -> Vec<[f64; 2]> {
    let weight = |node: f64| {
        let y = 2.0 * node - 1.0;
        let slope = nodes::legendre_derivative(points, y);
        1.0 / ((1.0 - y * y) * slope * slope)
    };
    let rule = nodes::gauss_legendre(points).into_iter();
    rule.map(|node| [node, weight(node)]).collect()
}

/// `int_0^end l_j` for all `j`, by a Gauss rule that is exact for the degree.
fn lagrange_integrals(c: &[f64], rule: &[[f64; 2]], end: f64, integrals: &mut [f64]) {
    integrals.fill(0.0);
    for [node, weight] in rule {
        for (j, integral) in integrals.iter_mut().enumerate() {
            *integral += end * weight * lagrange(c, j, node * end);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tableaus() -> impl Iterator<Item = ButcherTableau> {
        [Scheme::RadauIia, Scheme::GaussLegendre]
            .into_iter()
            .flat_map(|scheme| {
                (1..=ButcherTableau::MAX_STAGES)
                    .filter_map(move |stages| ButcherTableau::new(scheme, stages))
            })
    }

    #[test]
    fn quadrature_condition_b_holds_up_to_the_order() {
        for tableau in tableaus() {
            for k in 1..=tableau.scheme.order(tableau.stages()) {
                let sum: f64 = tableau
                    .b()
                    .iter()
                    .zip(tableau.c())
                    .map(|(b, c)| b * c.powi(k as i32 - 1))
                    .sum();
                let error = (sum - 1.0 / k as f64).abs();
                assert!(error < 4e-15, "{tableau:?}: B({k}) off by {error:e}");
            }
        }
    }

    #[test]
    fn collocation_condition_c_holds_up_to_the_number_of_stages() {
        for tableau in tableaus() {
            let s = tableau.stages();
            for i in 0..s {
                for k in 1..=s {
                    let sum: f64 = (0..s)
                        .map(|j| tableau.a(i, j) * tableau.c()[j].powi(k as i32 - 1))
                        .sum();
                    let error = (sum - tableau.c()[i].powi(k as i32) / k as f64).abs();
                    assert!(error < 4e-15, "C({k}) row {i} off by {error:e}");
                }
            }
        }
    }

    #[test]
    fn radau_iia_two_and_three_stages_match_the_published_coefficients() {
        let two = ButcherTableau::new(Scheme::RadauIia, 2).expect("two stages");
        for (value, published) in [
            (two.a(0, 0), 5.0 / 12.0),
            (two.a(0, 1), -1.0 / 12.0),
            (two.a(1, 0), 0.75),
            (two.a(1, 1), 0.25),
        ] {
            assert!((value - published).abs() < 2e-16);
        }
        // The integrals of three products of rounded factors carry a few units in the last place.
        let three = ButcherTableau::new(Scheme::RadauIia, 3).expect("three stages");
        let r = 6.0_f64.sqrt();
        assert!((three.c()[0] - (4.0 - r) / 10.0).abs() < 1e-15);
        assert!((three.a(0, 0) - (88.0 - 7.0 * r) / 360.0).abs() < 1e-15);
        assert!((three.a(2, 1) - (16.0 + r) / 36.0).abs() < 1e-15);
    }

    #[test]
    fn dense_output_ends_where_the_step_ends() {
        for tableau in tableaus() {
            let mut weights = vec![0.0; tableau.stages()];
            tableau.dense_weights(1.0, &mut weights);
            assert_eq!(weights, tableau.b());
        }
    }

    #[test]
    fn hermites_polynomial_is_exact_where_there_are_as_many_values_and_slopes() {
        let tableau = ButcherTableau::new(Scheme::RadauIia, 3).expect("three stages");
        let nodes = tableau.nodes_with_start();
        for theta in [0.0_f64, 0.1, 0.7, 1.0] {
            for power in 0..8 {
                let terms = nodes.iter().zip(tableau.hermite_with_start(theta));
                let rise = |c: f64| match power {
                    0 => 0.0,
                    _ => f64::from(power) * c.powi(power - 1),
                };
                let sum: f64 = terms
                    .map(|(&c, (value, slope))| value * c.powi(power) + slope * rise(c))
                    .sum();
                assert!(
                    (sum - theta.powi(power)).abs() < 1e-13,
                    "{power} at {theta}"
                );
            }
        }
    }

    #[test]
    fn number_of_stages_outside_the_range_is_refused() {
        assert!(ButcherTableau::new(Scheme::RadauIia, 0).is_none());
        assert!(ButcherTableau::new(Scheme::RadauIia, 10).is_none());
    }
}
