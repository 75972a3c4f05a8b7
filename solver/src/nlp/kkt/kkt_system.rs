//! The Newton system of the barrier problem.
//!
//! Slacks, bound multipliers and product rows are eliminated. With `Sigma = z_l/(x-l) + z_u/(u-x)`,
//! `D_k` the same quantity of slack `k`, `g` the gradient of the barrier Lagrangian, and for each row
//! the flexibility `e = sum_k 1/D_k`, what remains is
//!
//! ```text
//!     [ W + Sigma + delta_w I + sum_pairs a a'/e    J'               ] [dx]     [ g - sum_pairs a t/e ]
//!     [ J                                          -diag(e) - delta_c ] [dy] = - [ t                   ]
//! ```
//!
//! where `t = residual - sum_k sign_k g_k / D_k`, `a = (x_j, x_i)` is the gradient of a product row, and `W`
//! holds the multiplier of each product at position (i, j). A pair thus changes a 2x2 block and adds no
//! row; and the restoration phase, whose elastic slacks are eliminated too, has the same pattern.

use crate::clock::ThreadTime;

use crate::linalg::norms::{is_finite, norm_inf};
use crate::linalg::{FactorizationError, Inertia, RefinedSolver, SymmetricPattern};
use crate::nlp::program::barrier_problem::{BarrierProblem, Objective};
use crate::nlp::program::formulation::Formulation;
use crate::nlp::program::iterate::Iterate;
use crate::nlp::{Fault, InputError};
use crate::seconds::Seconds;
use crate::until::Until;

/// Assembly, factorization and solution of Newton systems on one pattern.
pub(crate) struct KktSystem {
    n: usize,
    m: usize,
    solver: RefinedSolver,
    maps: Maps,
    /// Number of products that a variable belongs to.
    product_count: Vec<f64>,
    pub(crate) hessian_values: Vec<f64>,
    pub(crate) jacobian_values: Vec<f64>,
    /// `e` of each row and `D` of each slack, of the assembled matrix.
    flexibility: Vec<f64>,
    stiffness: Vec<f64>,
    /// Gradient of the barrier Lagrangian, and `t`.
    barrier_gradient: Vec<f64>,
    row_terms: Vec<f64>,
    right_hand_side: Vec<f64>,
    solution: Vec<f64>,
    pub(crate) factorizations: usize,
    pub(crate) seconds: Seconds,
}

/// Positions in the matrix.
struct Maps {
    /// Of the entries of Hessian and Jacobian.
    hessian: Vec<u32>,
    jacobian: Vec<u32>,
    /// (i, i), (j, j), (i, j) of each product.
    products: Vec<[u32; 3]>,
}

impl KktSystem {
    pub(crate) fn new(formulation: &Formulation<'_>) -> Result<Self, InputError> {
        let n = formulation.variables.len();
        let m = formulation.rows.len();
        let products = formulation.products.iter();
        let entries = formulation
            .hessian_entries()
            .chain(formulation.jacobian_entries().map(|(row, j)| (n + row, j)))
            .chain(products.flat_map(|&(i, j)| [(i, i), (j, j), (i, j)]));
        let hessian_length = formulation.hessian_entries().count();
        let jacobian_end = hessian_length + formulation.jacobian_entries().count();
        let too_large = InputError::from(Fault::Size {
            variables: n,
            constraints: m,
        });
        let (pattern, mut map) =
            SymmetricPattern::with_map(n + m, entries).ok_or(too_large.clone())?;
        let product_map = map[jacobian_end..]
            .chunks_exact(3)
            .map(|p| [p[0], p[1], p[2]])
            .collect();
        map.truncate(jacobian_end);
        let jacobian_map = map.split_off(hessian_length);
        let mut product_count = vec![0.0; n];
        for &(i, j) in &formulation.products {
            product_count[i] += 1.0;
            product_count[j] += 1.0;
        }
        Ok(Self {
            n,
            m,
            solver: RefinedSolver::new(pattern, n).map_err(|_| too_large)?,
            maps: Maps {
                hessian: map,
                jacobian: jacobian_map,
                products: product_map,
            },
            product_count,
            hessian_values: vec![0.0; hessian_length],
            jacobian_values: vec![0.0; jacobian_end - hessian_length],
            flexibility: Vec::new(),
            stiffness: Vec::new(),
            barrier_gradient: Vec::new(),
            row_terms: Vec::new(),
            right_hand_side: vec![0.0; n + m],
            solution: vec![0.0; n + m],
            factorizations: 0,
            seconds: Seconds::default(),
        })
    }

    /// Until when factorizations may work; one that does not end then has no factors.
    pub(crate) fn work_until(&mut self, until: Until) {
        self.solver.work_until(until);
    }

    /// Number of explicit rows, the negative eigenvalues of a matrix that gives descent.
    pub(crate) fn rows(&self) -> usize {
        self.m
    }

    /// Assembles the matrix at `iterate` from the Hessian and Jacobian values held here. With
    /// `cap_products` the off-diagonal multiplier of a pair is limited so that its bound terms keep the
    /// 2x2 block positive: `|r| <= 0.99 sqrt(Sigma_i/k_i Sigma_j/k_j)`, `k` pairs sharing a variable.
    pub(crate) fn assemble(
        &mut self,
        problem: &BarrierProblem,
        iterate: &Iterate,
        mu: f64,
        cap_products: bool,
    ) {
        let stiffness_of = |i: usize| {
            let mut stiffness = 0.0;
            if problem.lower[i].is_finite() {
                stiffness += iterate.z_lower[i] / (iterate.v[i] - problem.lower[i]);
            }
            if problem.upper[i].is_finite() {
                stiffness += iterate.z_upper[i] / (problem.upper[i] - iterate.v[i]);
            }
            stiffness
        };
        let start = ThreadTime::now();
        let values = self.solver.values_mut();
        values.fill(0.0);
        for (&position, &h) in self.maps.hessian.iter().zip(&self.hessian_values) {
            values[position as usize] += h;
        }
        for (&position, &a) in self.maps.jacobian.iter().zip(&self.jacobian_values) {
            values[position as usize] += a;
        }
        self.stiffness.clear();
        self.stiffness
            .extend((0..problem.variables()).map(stiffness_of));
        for i in 0..self.n {
            self.solver.add_to_diagonal(i, self.stiffness[i]);
        }
        if let Objective::Proximity { weight, .. } = &problem.objective {
            for (i, w) in weight.iter().enumerate() {
                self.solver.add_to_diagonal(i, mu.sqrt() * w * w);
            }
        }
        self.flexibility.clear();
        self.flexibility.resize(problem.rows(), 0.0);
        for (slack, d) in problem.slacks.iter().zip(&self.stiffness[self.n..]) {
            self.flexibility[slack.row] += 1.0 / d;
        }
        for row in 0..self.m {
            self.solver
                .add_to_diagonal(self.n + row, -self.flexibility[row]);
        }
        for (pair, (&(i, j), map)) in problem.products.iter().zip(&self.maps.products).enumerate() {
            let w = 1.0 / self.flexibility[self.m + pair];
            let (x_i, x_j) = (iterate.v[i], iterate.v[j]);
            let mut r = iterate.y[self.m + pair];
            if cap_products {
                let share = |k: usize| self.stiffness[k] / self.product_count[k];
                let cap = 0.99 * (share(i) * share(j)).sqrt();
                if r.abs() > cap {
                    r = r.signum() * cap;
                }
            }
            let values = self.solver.values_mut();
            values[map[0] as usize] += w * x_j * x_j;
            values[map[1] as usize] += w * x_i * x_i;
            values[map[2] as usize] += r + w * x_i * x_j;
        }
        self.seconds.factorize += start.elapsed().as_secs_f64();
    }

    /// Assembles the matrix of the least-squares multiplier problem, `[D J'; J -e]` with `D = 1`, or large for what is `free`.
    fn assemble_least_squares(&mut self, problem: &BarrierProblem, free: &[bool]) {
        const FREE: f64 = 1e16;
        let values = self.solver.values_mut();
        values.fill(0.0);
        for (&position, &a) in self.maps.jacobian.iter().zip(&self.jacobian_values) {
            values[position as usize] += a;
        }
        self.stiffness.clear();
        self.stiffness.resize(problem.variables(), 1.0);
        for (stiffness, _) in self
            .stiffness
            .iter_mut()
            .zip(free)
            .filter(|(_, free)| **free)
        {
            *stiffness = FREE;
        }
        self.flexibility.clear();
        self.flexibility.resize(problem.rows(), 0.0);
        for (slack, d) in problem.slacks.iter().zip(&self.stiffness[self.n..]) {
            self.flexibility[slack.row] += 1.0 / d;
        }
        for i in 0..self.n {
            self.solver.add_to_diagonal(i, self.stiffness[i]);
        }
        for row in 0..self.m {
            self.solver
                .add_to_diagonal(self.n + row, -self.flexibility[row]);
        }
    }

    /// Factorizes the assembled matrix with the given shifts.
    pub(crate) fn factor(
        &mut self,
        delta_w: f64,
        delta_c: f64,
    ) -> Result<Inertia, FactorizationError> {
        let start = ThreadTime::now();
        self.factorizations += 1;
        let result = self.solver.factor(delta_w, delta_c);
        self.seconds.factorize += start.elapsed().as_secs_f64();
        result
    }

    /// Newton direction for the row residuals given, from the factors of the last
    /// [`KktSystem::factor`]. `lagrangian` is the gradient of the Lagrangian with bound multipliers.
    pub(crate) fn direction(
        &mut self,
        problem: &BarrierProblem,
        iterate: &Iterate,
        lagrangian: &[f64],
        residual: &[f64],
        mu: f64,
        direction: &mut Iterate,
    ) -> f64 {
        self.barrier_gradient.clear();
        for (i, lagrangian) in lagrangian.iter().enumerate() {
            let mut g = lagrangian + iterate.z_lower[i] - iterate.z_upper[i];
            if problem.lower[i].is_finite() {
                g -= mu / (iterate.v[i] - problem.lower[i]);
            }
            if problem.upper[i].is_finite() {
                g += mu / (problem.upper[i] - iterate.v[i]);
            }
            self.barrier_gradient.push(g + mu * problem.damping(i));
        }
        let residual = self.solve_reduced(problem, iterate, residual, direction);
        for i in 0..problem.variables() {
            let step = direction.v[i];
            direction.z_lower[i] = if problem.lower[i].is_finite() {
                let distance = iterate.v[i] - problem.lower[i];
                (mu - iterate.z_lower[i] * step) / distance - iterate.z_lower[i]
            } else {
                0.0
            };
            direction.z_upper[i] = if problem.upper[i].is_finite() {
                let distance = problem.upper[i] - iterate.v[i];
                (mu + iterate.z_upper[i] * step) / distance - iterate.z_upper[i]
            } else {
                0.0
            };
        }
        residual
    }

    /// Solves for (dx, ds, dy) from `barrier_gradient` and `residual`.
    fn solve_reduced(
        &mut self,
        problem: &BarrierProblem,
        iterate: &Iterate,
        residual: &[f64],
        direction: &mut Iterate,
    ) -> f64 {
        let start = ThreadTime::now();
        let n = self.n;
        self.row_terms.clear();
        self.row_terms.extend_from_slice(residual);
        for (k, slack) in problem.slacks.iter().enumerate() {
            self.row_terms[slack.row] -=
                slack.sign * self.barrier_gradient[n + k] / self.stiffness[n + k];
        }
        for i in 0..n {
            self.right_hand_side[i] = -self.barrier_gradient[i];
        }
        for row in 0..self.m {
            self.right_hand_side[n + row] = -self.row_terms[row];
        }
        for (pair, &(i, j)) in problem.products.iter().enumerate() {
            let t = self.row_terms[self.m + pair] / self.flexibility[self.m + pair];
            self.right_hand_side[i] -= iterate.v[j] * t;
            self.right_hand_side[j] -= iterate.v[i] * t;
        }
        let residual = self.solver.solve(&self.right_hand_side, &mut self.solution);
        direction.v[..n].copy_from_slice(&self.solution[..n]);
        direction.y[..self.m].copy_from_slice(&self.solution[n..]);
        for (pair, &(i, j)) in problem.products.iter().enumerate() {
            let row = self.m + pair;
            let product = iterate.v[j] * direction.v[i] + iterate.v[i] * direction.v[j];
            direction.y[row] = (product + self.row_terms[row]) / self.flexibility[row];
        }
        for (k, slack) in problem.slacks.iter().enumerate() {
            let g = self.barrier_gradient[n + k] + slack.sign * direction.y[slack.row];
            direction.v[n + k] = -g / self.stiffness[n + k];
        }
        self.seconds.solve += start.elapsed().as_secs_f64();
        residual
    }

    /// Least-squares multipliers of the explicit rows,
    /// `min |grad F + J' y - z_l + z_u + products|`, into `iterate.y`; the multipliers of product rows are
    /// data. Variables that are `free` are left out: their bounds balance what is left. Leaves zeros if the system is singular or an entry exceeds `limit`.
    pub(crate) fn least_squares_multipliers(
        &mut self,
        problem: &BarrierProblem,
        iterate: &mut Iterate,
        gradient: &[f64],
        (limit, dual_shift): (f64, f64),
        free: &[bool],
        work: &mut Iterate,
    ) {
        iterate.y[..self.m].fill(0.0);
        self.assemble_least_squares(problem, free);
        if self.factor(0.0, dual_shift).is_err() {
            return;
        }
        self.barrier_gradient.clear();
        for (i, gradient) in gradient.iter().enumerate() {
            self.barrier_gradient
                .push(gradient - iterate.z_lower[i] + iterate.z_upper[i]);
        }
        for (pair, &(i, j)) in problem.products.iter().enumerate() {
            let y = iterate.y[self.m + pair];
            self.barrier_gradient[i] += y * iterate.v[j];
            self.barrier_gradient[j] += y * iterate.v[i];
        }
        // product rows take no part: their own multiplier is fixed
        self.row_terms.clear();
        self.row_terms.resize(problem.rows(), 0.0);
        for (k, slack) in problem.slacks.iter().enumerate() {
            if slack.row < self.m {
                self.row_terms[slack.row] -=
                    slack.sign * self.barrier_gradient[self.n + k] / self.stiffness[self.n + k];
            }
        }
        for i in 0..self.n {
            self.right_hand_side[i] = -self.barrier_gradient[i];
        }
        for row in 0..self.m {
            self.right_hand_side[self.n + row] = -self.row_terms[row];
        }
        let residual = self.solver.solve(&self.right_hand_side, &mut self.solution);
        let y = &self.solution[self.n..];
        if residual < 1e-5 && y.iter().all(|y| y.abs() <= limit) {
            work.y[..self.m].copy_from_slice(y);
            iterate.y[..self.m].copy_from_slice(y);
        }
    }

    /// Evaluates Hessian and Jacobian at the iterate.
    pub(crate) fn evaluate_jacobian(&mut self, formulation: &mut Formulation<'_>, v: &[f64]) {
        formulation.jacobian(&v[..self.n], &mut self.jacobian_values);
    }

    /// Evaluates the Hessian of the Lagrangian of the explicit rows.
    pub(crate) fn evaluate_hessian(
        &mut self,
        formulation: &mut Formulation<'_>,
        problem: &BarrierProblem,
        iterate: &Iterate,
    ) {
        formulation.hessian(
            &iterate.v[..self.n],
            problem.objective_weight(),
            &iterate.y[..self.m],
            &mut self.hessian_values,
        );
    }

    /// Largest entry of the Hessian of `y' c`, which takes the place of the Hessian held here.
    pub(crate) fn row_curvature(
        &mut self,
        formulation: &mut Formulation<'_>,
        iterate: &Iterate,
    ) -> f64 {
        let (x, y) = (&iterate.v[..self.n], &iterate.y[..self.m]);
        formulation.hessian(x, 0.0, y, &mut self.hessian_values);
        norm_inf(&self.hessian_values)
    }

    /// Whether all derivative values held here are finite.
    pub(crate) fn is_finite(&self) -> bool {
        is_finite(&self.jacobian_values) && is_finite(&self.hessian_values)
    }
}
