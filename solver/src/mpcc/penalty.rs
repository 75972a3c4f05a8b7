//! A penalty of the smaller sides, where a choice of sides alone leads nowhere.

use super::forward::forward;
use super::watch::{Purpose, Watch};
use super::{Mpcc, Settings};
use crate::linalg::norms::norm_inf;
use crate::nlp::{self, NlpProblem};

/// First cost of a side, relative to the gradient of the objective, and what a side that does not vanish multiplies its own by.
const COST: f64 = 10.0;
const GROWTH: f64 = 4.0;
/// Most programs, and most iterations of each.
const MOST_PROGRAMS: usize = 4;
const ITERATIONS: usize = 150;
/// Barrier parameter at which each starts, and its dual shift.
const BARRIER: f64 = 1e-4;
const SHIFT: f64 = 1e-8;
/// Size up to which a side vanishes.
const VANISHED: f64 = 1e-6;
/// Violation of rows from which on a program has failed.
const FAILED: f64 = 1e-3;

/// The smooth program
///
/// ```text
///     min f(x) + sum_k w_k x_(s_k)   s.t.  c_l <= c(x) <= c_u,  x_l <= x <= x_u
/// ```
///
/// with the side `s_k` of each pair: no row ties the sides together, so that its multipliers are bounded by the costs `w_k`, and a
/// side that cannot vanish stays positive instead of making the program infeasible.
struct Penalty<'a> {
    problem: &'a mut dyn Mpcc,
    cost: Vec<f64>,
}

impl NlpProblem for Penalty<'_> {
    forward!(
        variables,
        constraints,
        variable_bounds,
        constraint_bounds,
        initial_point,
        constraint_values,
        jacobian_pattern,
        jacobian_values,
        hessian_pattern,
        hessian_values,
        variable_name,
        constraint_name
    );

    fn objective(&mut self, x: &[f64]) -> f64 {
        let cost: f64 = self.cost.iter().zip(x).map(|(c, x)| c * x).sum();
        self.problem.objective(x) + cost
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.problem.gradient(x, gradient);
        for (g, cost) in gradient.iter_mut().zip(&self.cost) {
            *g += cost;
        }
    }
}

/// A point near a given one at which a side of every pair vanishes to `VANISHED`: programs with a cost of the side that is the
/// smaller one where the last program ended, the costs of those that do not vanish growing. `None` where a few programs do not lead
/// there.
pub(crate) fn penalized(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    start: nlp::WarmStart,
    watch: &mut Watch<'_>,
) -> Option<nlp::WarmStart> {
    let pairs = problem.complementarities().to_vec();
    let interior_point = nlp::Settings {
        maximum_iterations: ITERATIONS,
        initial_barrier_parameter: BARRIER,
        bound_push: 1e-2 * BARRIER,
        bound_fraction: 1e-2 * BARRIER,
        permanent_dual_shift: SHIFT,
        ..settings.interior_point.clone()
    };
    let mut from = start;
    let mut gradient = vec![0.0; from.x.len()];
    problem.gradient(&from.x, &mut gradient);
    let mut costs = vec![COST * norm_inf(&gradient).max(1.0); pairs.len()];
    for _ in 0..MOST_PROGRAMS {
        let mut cost = vec![0.0; from.x.len()];
        for (&(i, j), own) in pairs.iter().zip(&costs) {
            cost[if from.x[i] <= from.x[j] { i } else { j }] += own;
        }
        from.barrier_parameter = BARRIER;
        let mut penalty = Penalty {
            problem: &mut *problem,
            cost,
        };
        let solution = watch
            .run(
                Purpose::Crossover,
                &interior_point,
                &mut |_| true,
                |settings, observer| {
                    nlp::solve_from(&mut penalty, settings, Some(&from), Some(observer))
                },
            )
            .ok()?;
        if watch.stop.is_some() || solution.residuals.primal > FAILED {
            return None;
        }
        let mut all = true;
        for (&(i, j), cost) in pairs.iter().zip(&mut costs) {
            if solution.x[i].min(solution.x[j]) > VANISHED {
                *cost *= GROWTH;
                all = false;
            }
        }
        from = nlp::WarmStart::from_solution(&solution);
        if all {
            return Some(from);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `min (x_0 - 0.3)^2 + (x_1 - 1)^2` with `x_1 + x_2 = 1`, `x_3 = 3 x_0`, and the pairs `(0, 1)`, `(2, 3)`.
    struct Chain;

    const PAIRS: [(usize, usize); 2] = [(0, 1), (2, 3)];

    impl NlpProblem for Chain {
        fn variables(&self) -> usize {
            4
        }
        fn constraints(&self) -> usize {
            2
        }
        fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
            lower.fill(0.0);
            upper.fill(f64::INFINITY);
        }
        fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
            lower.copy_from_slice(&[1.0, 0.0]);
            upper.copy_from_slice(&[1.0, 0.0]);
        }
        fn initial_point(&self, x: &mut [f64]) {
            x.copy_from_slice(&[0.6, 0.5, 0.5, 1.8]);
        }
        fn objective(&mut self, x: &[f64]) -> f64 {
            (x[0] - 0.3).powi(2) + (x[1] - 1.0).powi(2)
        }
        fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
            gradient.copy_from_slice(&[2.0 * (x[0] - 0.3), 2.0 * (x[1] - 1.0), 0.0, 0.0]);
        }
        fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
            c.copy_from_slice(&[x[1] + x[2], x[3] - 3.0 * x[0]]);
        }
        fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
            vec![(0, 1), (0, 2), (1, 0), (1, 3)]
        }
        fn jacobian_values(&mut self, _: &[f64], values: &mut [f64]) {
            values.copy_from_slice(&[1.0, 1.0, -3.0, 1.0]);
        }
        fn hessian_pattern(&self) -> Vec<(usize, usize)> {
            vec![(0, 0), (1, 1)]
        }
        fn hessian_values(&mut self, _: &[f64], weight: f64, _: &[f64], values: &mut [f64]) {
            values.fill(2.0 * weight);
        }
    }

    impl Mpcc for Chain {
        fn complementarities(&self) -> &[(usize, usize)] {
            &PAIRS
        }
    }

    #[test]
    fn penalized_goes_on_to_other_sides_where_the_smaller_ones_have_no_point() {
        // x_1 and x_2, the smaller sides at the start, add up to one
        let settings = Settings::default();
        let mut observer = |_: &nlp::IterationInfo| true;
        let mut watch = Watch::new(&settings, &mut observer);
        let start = nlp::WarmStart {
            x: vec![0.6, 0.5, 0.5, 1.8],
            multipliers: vec![0.0; 2],
            multipliers_lower: vec![0.0; 4],
            multipliers_upper: vec![0.0; 4],
            barrier_parameter: 0.0,
        };
        let found = penalized(&mut Chain, &settings, start, &mut watch).expect("a point");
        for (i, j) in PAIRS {
            assert!(found.x[i].min(found.x[j]) <= VANISHED, "{:?}", found.x);
        }
        assert!(
            (found.x[1] + found.x[2] - 1.0).abs() < 1e-8,
            "{:?}",
            found.x
        );
    }
}
