//! The textbook way to solve a complementarity problem, to compare with: separate nonlinear programs with product
//! constraints `x_i x_j <= sigma` as rows, for `sigma = 1, 0.1, ..., 1e-8`, each started at the last point (Scholtes,
//! SIAM Journal on Optimization 11, 2001). Their end is then made exact and certified, so that objectives are
//! comparable, by the complementarity method started there.

use std::collections::HashMap;

use hangtime_solver::mpcc::{self, Mpcc, RelaxationRule};
use hangtime_solver::nlp::{self, InputError, NlpProblem};

/// First, last and ratio of the relaxation parameters.
const RELAXATIONS: (f64, f64, f64) = (1.0, 1e-8, 0.1);
/// Barrier parameter of the last run, whose relaxation is ten times as large: where crossovers begin.
const LAST_BARRIER: f64 = 1e-6;

/// Solves `problem` by the homotopy: the exact point, with the iterations and factorizations of all runs.
pub(crate) fn homotopy(problem: &mut dyn Mpcc) -> Result<mpcc::Solution, InputError> {
    let mut settings = mpcc::Settings::default().interior_point;
    // the textbook has no unit of the objective
    settings.objective_unit = Some(1.0);
    let mut start = vec![0.0; problem.variables()];
    problem.initial_point(&mut start);
    let pairs = problem.complementarities().to_vec();
    let (first, last, ratio) = RELAXATIONS;
    let mut hessian = problem.hessian_pattern();
    let own_hessian = hessian.len();
    let mut places: HashMap<(usize, usize), usize> = hessian.iter().copied().zip(0..).collect();
    let places = pairs.iter().map(|&(i, j)| {
        let position = (i.max(j), i.min(j));
        *places.entry(position).or_insert_with(|| {
            hessian.push(position);
            hessian.len() - 1
        })
    });
    let mut relaxed = Relaxed {
        places: places.collect(),
        own_hessian,
        problem,
        pairs,
        start,
        sigma: Some(first),
        hessian,
    };
    let (mut iterations, mut factorizations) = (0, 0);
    while let Some(sigma) = relaxed.sigma {
        let run = nlp::solve(&mut relaxed, &settings)?;
        iterations += run.counts.iterations;
        factorizations += run.counts.factorizations;
        // a failed step still gives the next one its start
        relaxed.start = run.x;
        let next = ratio * sigma;
        relaxed.sigma = (next > 0.5 * last).then_some(next);
    }
    let mut settings = mpcc::Settings::default();
    settings.rules = vec![RelaxationRule::Proportional];
    settings.second_opinion = false;
    settings.interior_point.objective_unit = Some(1.0);
    settings.interior_point.initial_barrier_parameter = LAST_BARRIER;
    settings.interior_point.bound_push = 1e-9;
    settings.interior_point.bound_fraction = 1e-9;
    let mut solution = mpcc::solve(&mut relaxed, &settings)?;
    solution.iterations += iterations;
    solution.factorizations += factorizations;
    Ok(solution)
}

/// The problem from another start, with rows for the products of its pairs while there is a `sigma`.
struct Relaxed<'a> {
    problem: &'a mut dyn Mpcc,
    pairs: Vec<(usize, usize)>,
    start: Vec<f64>,
    sigma: Option<f64>,
    /// Hessian pattern: that of the problem, and the positions of products that it lacks; place of each product.
    hessian: Vec<(usize, usize)>,
    own_hessian: usize,
    places: Vec<usize>,
}

impl Relaxed<'_> {
    /// The pairs that are rows.
    fn products(&self) -> &[(usize, usize)] {
        if self.sigma.is_some() {
            &self.pairs
        } else {
            &[]
        }
    }
}

impl NlpProblem for Relaxed<'_> {
    fn variables(&self) -> usize {
        self.problem.variables()
    }

    fn constraints(&self) -> usize {
        self.problem.constraints() + self.products().len()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.problem.variable_bounds(lower, upper);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        let m = self.problem.constraints();
        self.problem
            .constraint_bounds(&mut lower[..m], &mut upper[..m]);
        lower[m..].fill(f64::NEG_INFINITY);
        upper[m..].fill(self.sigma.unwrap_or(0.0));
    }

    fn initial_point(&self, x: &mut [f64]) {
        x.copy_from_slice(&self.start);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        self.problem.objective(x)
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.problem.gradient(x, gradient);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        let m = self.problem.constraints();
        self.problem.constraint_values(x, &mut c[..m]);
        for (c, &(i, j)) in c[m..].iter_mut().zip(self.products()) {
            *c = x[i] * x[j];
        }
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        let m = self.problem.constraints();
        let mut pattern = self.problem.jacobian_pattern();
        for (k, &(i, j)) in self.products().iter().enumerate() {
            pattern.extend([(m + k, i), (m + k, j)]);
        }
        pattern
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        let own = values.len() - 2 * self.products().len();
        self.problem.jacobian_values(x, &mut values[..own]);
        for (values, &(i, j)) in values[own..].chunks_exact_mut(2).zip(self.products()) {
            values.copy_from_slice(&[x[j], x[i]]);
        }
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        let length = if self.sigma.is_some() {
            self.hessian.len()
        } else {
            self.own_hessian
        };
        self.hessian[..length].to_vec()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        let m = self.problem.constraints();
        values.fill(0.0);
        self.problem.hessian_values(
            x,
            weight,
            &multipliers[..m],
            &mut values[..self.own_hessian],
        );
        for (&place, multiplier) in self.places.iter().zip(&multipliers[m..]) {
            values[place] += multiplier;
        }
    }

    fn variable_name(&self, index: usize) -> String {
        self.problem.variable_name(index)
    }

    fn constraint_name(&self, index: usize) -> String {
        match index.checked_sub(self.problem.constraints()) {
            Some(pair) => self.problem.complementarity_name(pair),
            None => self.problem.constraint_name(index),
        }
    }
}

impl Mpcc for Relaxed<'_> {
    fn complementarities(&self) -> &[(usize, usize)] {
        &self.pairs
    }

    fn complementarity_name(&self, index: usize) -> String {
        self.problem.complementarity_name(index)
    }

    fn vanishing_sides(&self, x: &[f64], vanishes: &mut [bool]) -> bool {
        self.problem.vanishing_sides(x, vanishes)
    }
}
