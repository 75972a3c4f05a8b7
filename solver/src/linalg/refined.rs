//! Solves with iterative refinement and a check of the residual.

use super::norms::norm_inf;
use super::{FactorizationError, Inertia, MultifrontalLdl, SymmetricPattern};
use crate::until::Until;

/// A factorization together with the matrix it belongs to.
///
/// The system is `K + diag(delta_w I, -delta_c I)` with the shifts of the last
/// [`RefinedSolver::factor`]; whatever else a factorization shifts or loses is removed by refinement
/// against this matrix.
pub(crate) struct RefinedSolver {
    pattern: SymmetricPattern,
    primal: usize,
    factorization: MultifrontalLdl,
    values: Vec<f64>,
    /// Shifts (delta_w, delta_c) of the last factorization.
    shifts: (f64, f64),
    residual: Vec<f64>,
    best: Vec<f64>,
}

impl RefinedSolver {
    /// Most refinement steps in a solve.
    const STEPS: usize = 10;
    /// Relative residual at which refinement ends.
    const TARGET: f64 = 1e-12;

    /// Solver of systems on `pattern` whose first `primal` rows are primal.
    ///
    /// # Errors
    /// Those of [`MultifrontalLdl::new`].
    pub(crate) fn new(
        pattern: SymmetricPattern,
        primal: usize,
    ) -> Result<Self, FactorizationError> {
        let factorization = MultifrontalLdl::new(&pattern, primal)?;
        let n = pattern.dimension();
        let stored = pattern.stored();
        Ok(Self {
            pattern,
            primal,
            factorization,
            values: vec![0.0; stored],
            shifts: (0.0, 0.0),
            residual: vec![0.0; n],
            best: vec![0.0; n],
        })
    }

    /// Until when factorizations may work; one that does not end then has no factors.
    pub(crate) fn work_until(&mut self, until: Until) {
        self.factorization.work_until(until);
    }

    /// Values of the matrix, to be assembled in place before [`RefinedSolver::factor`].
    pub(crate) fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// Adds to an entry on the diagonal of the matrix held here.
    pub(crate) fn add_to_diagonal(&mut self, row: usize, value: f64) {
        self.values[self.pattern.diagonal(row)] += value;
    }

    /// Factorizes the matrix held here; see [`MultifrontalLdl::factor`].
    ///
    /// # Errors
    /// [`FactorizationError`] when there are no factors to solve with.
    pub(crate) fn factor(
        &mut self,
        delta_w: f64,
        delta_c: f64,
    ) -> Result<Inertia, FactorizationError> {
        self.shifts = (delta_w, delta_c);
        self.factorization.factor(&self.values, delta_w, delta_c)
    }

    /// `b - (K + D) x` into `residual`, `D` the shifts.
    fn update_residual(&mut self, right_hand_side: &[f64], solution: &[f64]) {
        self.residual.fill(0.0);
        self.pattern
            .multiply_add(&self.values, solution, &mut self.residual);
        let (x_primal, x_dual) = solution.split_at(self.primal);
        let (b_primal, b_dual) = right_hand_side.split_at(self.primal);
        let (r_primal, r_dual) = self.residual.split_at_mut(self.primal);
        let (delta_w, delta_c) = self.shifts;
        for (r, b, x, shift) in [
            (r_primal, b_primal, x_primal, delta_w),
            (r_dual, b_dual, x_dual, -delta_c),
        ] {
            for ((r, b), x) in r.iter_mut().zip(b).zip(x) {
                *r = b - (*r + shift * x);
            }
        }
    }

    /// Solves for `right_hand_side`; the result is the best iterate of the refinement. Returns its relative residual
    /// `|b - K x|_inf / (min(|x|_inf, 1e6 |b|_inf) + |b|_inf)`.
    pub(crate) fn solve(&mut self, right_hand_side: &[f64], solution: &mut [f64]) -> f64 {
        let norm_b = norm_inf(right_hand_side);
        solution.copy_from_slice(right_hand_side);
        self.factorization.solve(solution);
        let mut best_residual = f64::INFINITY;
        let mut steps = 0;
        loop {
            self.update_residual(right_hand_side, solution);
            let scale = norm_inf(solution).min(1e6 * norm_b) + norm_b;
            let error = norm_inf(&self.residual);
            let residual = if error == 0.0 { 0.0 } else { error / scale };
            // also false for a residual that is not a number
            if residual < best_residual {
                let stalled = residual > 0.5 * best_residual && steps > 2;
                best_residual = residual;
                if residual <= Self::TARGET || steps == Self::STEPS || stalled {
                    break;
                }
                self.best.copy_from_slice(solution);
            } else {
                solution.copy_from_slice(&self.best);
                break;
            }
            self.factorization.solve(&mut self.residual);
            for (x, d) in solution.iter_mut().zip(&self.residual) {
                *x += d;
            }
            steps += 1;
        }
        best_residual
    }
}
