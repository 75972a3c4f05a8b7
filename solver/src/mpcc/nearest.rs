//! The exact point nearest to a given one: the same constraints and pairs with another objective.

use super::Mpcc;
use super::forward::forward;
use crate::nlp::{NlpProblem, Pattern};

/// The complementarity problem
///
/// ```text
///     min 1/2 sum_i ((x_i - a_i) / max(1, |a_i|))^2   s.t. the constraints, bounds and pairs of another problem,
/// ```
///
/// started at `a`. Where an objective leads its relaxed runs to where pairs cannot be met, or keeps them busy for long, this one,
/// which is convex and flat, leaves the question of a choice of sides that has a point at all.
pub(crate) struct Nearest<'a> {
    problem: &'a mut dyn Mpcc,
    to: &'a [f64],
    hessian: Pattern,
    /// Number of entries of the Hessian of the problem itself.
    own_hessian: usize,
}

impl<'a> Nearest<'a> {
    pub(crate) fn new(problem: &'a mut dyn Mpcc, to: &'a [f64]) -> Self {
        let mut hessian = problem.hessian_pattern();
        let own_hessian = hessian.len();
        hessian.extend((0..to.len()).map(|i| (i, i)));
        Self {
            hessian: Pattern::new(&hessian),
            own_hessian,
            problem,
            to,
        }
    }

    fn weight(&self, i: usize) -> f64 {
        self.to[i].abs().max(1.0).powi(-2)
    }
}

impl NlpProblem for Nearest<'_> {
    forward!(
        variables,
        constraints,
        variable_bounds,
        constraint_bounds,
        constraint_values,
        jacobian_pattern,
        jacobian_values,
        variable_name,
        constraint_name
    );

    fn initial_point(&self, x: &mut [f64]) {
        x.copy_from_slice(self.to);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        let terms = (0..x.len()).map(|i| self.weight(i) * (x[i] - self.to[i]).powi(2));
        0.5 * terms.sum::<f64>()
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        for (i, g) in gradient.iter_mut().enumerate() {
            *g = self.weight(i) * (x[i] - self.to[i]);
        }
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.hessian.entries.clone()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        // the problem's own entries come first, each position once
        let (own, added) = values.split_at_mut(self.own_hessian);
        self.problem.hessian_values(x, 0.0, multipliers, own);
        added.fill(0.0);
        for (i, &place) in self.hessian.places[self.own_hessian..].iter().enumerate() {
            values[place] += weight * self.weight(i);
        }
    }
}

impl Mpcc for Nearest<'_> {
    forward!(complementarities, vanishing_sides);
}

#[cfg(test)]
mod tests {
    use super::super::{Settings, solve};
    use super::*;

    /// A pair whose sides add up to two.
    struct Sum;

    impl NlpProblem for Sum {
        fn variables(&self) -> usize {
            2
        }
        fn constraints(&self) -> usize {
            1
        }
        fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
            lower.fill(0.0);
            upper.fill(f64::INFINITY);
        }
        fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
            lower[0] = 2.0;
            upper[0] = 2.0;
        }
        fn initial_point(&self, x: &mut [f64]) {
            x.fill(1.0);
        }
        fn objective(&mut self, x: &[f64]) -> f64 {
            x[1]
        }
        fn gradient(&mut self, _: &[f64], gradient: &mut [f64]) {
            gradient.copy_from_slice(&[0.0, 1.0]);
        }
        fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
            c[0] = x[0] + x[1];
        }
        fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
            vec![(0, 0), (0, 1)]
        }
        fn jacobian_values(&mut self, _: &[f64], values: &mut [f64]) {
            values.fill(1.0);
        }
        fn hessian_pattern(&self) -> Vec<(usize, usize)> {
            vec![(1, 1)]
        }
        fn hessian_values(&mut self, _: &[f64], _: f64, _: &[f64], values: &mut [f64]) {
            values[0] = 0.0;
        }
    }

    impl Mpcc for Sum {
        fn complementarities(&self) -> &[(usize, usize)] {
            &[(0, 1)]
        }
    }

    #[test]
    fn nearest_point_is_exact_and_forgets_the_objective() {
        // the objective asks for (2, 0), the distance to (0.5, 4) for (0, 2): 1/2 (0.5^2 + (2/4)^2) there
        let to = [0.5, 4.0];
        let solution = solve(&mut Nearest::new(&mut Sum, &to), &Settings::default());
        let solution = solution.expect("a valid program");
        assert!(solution.status.is_solved());
        assert_eq!(solution.x[0], 0.0);
        assert!((solution.x[1] - 2.0).abs() < 1e-8 && (solution.objective - 0.25).abs() < 1e-8);
    }
}
