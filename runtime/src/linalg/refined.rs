//! Solves with iterative refinement and a check of the residual.

use super::norms::norm_inf;
use super::{FactorizationError, Inertia, KktFactorization, SymmetricPattern};

/// How well a system was solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolveQuality {
    /// `|b - K x|_inf / (|K x|-scale + |b|_inf)`, the relative residual of the returned solution:
    /// the scale is `min(|x|_inf, 1e6 |b|_inf) + |b|_inf`.
    pub residual: f64,
    /// `|b - K x|_inf / |b|_inf`, which a large solution cannot hide.
    pub backward: f64,
    /// Refinement steps taken.
    pub steps: usize,
}

impl SolveQuality {
    /// The worse of two solves in every respect.
    pub(crate) fn worse(&self, other: &Self) -> Self {
        Self {
            residual: self.residual.max(other.residual),
            backward: self.backward.max(other.backward),
            steps: self.steps.max(other.steps),
        }
    }
}

/// A factorization together with the matrix it belongs to.
///
/// The system is `K + diag(delta_w I, -delta_c I)` with the shifts of the last
/// [`RefinedSolver::factor`]; whatever else a factorization shifts or loses is removed by refinement
/// against this matrix.
///
/// # Examples
/// The saddle point system `[2 0 1; 0 2 1; 1 1 0] x = (1, 1, 2)`:
///
/// ```
/// use hangtime::linalg::{MultifrontalLdl, RefinedSolver, SymmetricPattern};
///
/// let entries = [(0, 0), (1, 1), (2, 0), (2, 1)];
/// let (pattern, map) = SymmetricPattern::new(3, &entries).ok_or("an entry outside the matrix")?;
/// let mut values = vec![0.0; pattern.stored()];
/// for (&position, a) in map.iter().zip([2.0, 2.0, 1.0, 1.0]) {
///     values[position] += a;
/// }
/// let back_end = Box::new(MultifrontalLdl::new(&pattern, 2)?);
/// let mut solver = RefinedSolver::new(pattern, 2, back_end);
/// let inertia = solver.factor(&values, 0.0, 0.0)?;
/// assert_eq!((inertia.positive, inertia.negative), (2, 1));
/// let mut x = vec![0.0; 3];
/// let quality = solver.solve(&[1.0, 1.0, 2.0], &mut x);
/// assert!(quality.residual < 1e-12);
/// assert!((x[0] - 1.0).abs() < 1e-12 && (x[2] + 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct RefinedSolver {
    pattern: SymmetricPattern,
    primal: usize,
    back_end: Box<dyn KktFactorization + Send>,
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
    pub fn new(
        pattern: SymmetricPattern,
        primal: usize,
        back_end: Box<dyn KktFactorization + Send>,
    ) -> Self {
        let n = pattern.dimension();
        let stored = pattern.stored();
        Self {
            pattern,
            primal,
            back_end,
            values: vec![0.0; stored],
            shifts: (0.0, 0.0),
            residual: vec![0.0; n],
            best: vec![0.0; n],
        }
    }

    /// Pattern of the matrix.
    pub fn pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }

    /// Replaces the factorization; the next call must be [`RefinedSolver::factor`].
    pub fn replace_back_end(&mut self, back_end: Box<dyn KktFactorization + Send>) {
        self.back_end = back_end;
    }

    /// Factorizes; see [`KktFactorization::factor`].
    ///
    /// # Errors
    /// [`FactorizationError`] when there are no factors to solve with.
    pub fn factor(
        &mut self,
        values: &[f64],
        delta_w: f64,
        delta_c: f64,
    ) -> Result<Inertia, FactorizationError> {
        self.values.copy_from_slice(values);
        self.factor_held(delta_w, delta_c)
    }

    /// Values of the matrix, to be assembled in place before [`RefinedSolver::factor_held`].
    pub(crate) fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// Adds to an entry on the diagonal of the matrix held here.
    pub(crate) fn add_to_diagonal(&mut self, row: usize, value: f64) {
        self.values[self.pattern.diagonal(row)] += value;
    }

    /// As [`RefinedSolver::factor`], with the values held here.
    pub(crate) fn factor_held(
        &mut self,
        delta_w: f64,
        delta_c: f64,
    ) -> Result<Inertia, FactorizationError> {
        self.shifts = (delta_w, delta_c);
        self.back_end.factor(&self.values, delta_w, delta_c)
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

    /// Solves for `right_hand_side`; the result is the best iterate of the refinement.
    pub fn solve(&mut self, right_hand_side: &[f64], solution: &mut [f64]) -> SolveQuality {
        let norm_b = norm_inf(right_hand_side);
        solution.copy_from_slice(right_hand_side);
        self.back_end.solve(solution);
        let mut best_residual = f64::INFINITY;
        let mut best_error = f64::INFINITY;
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
                best_error = error;
                if residual <= Self::TARGET || steps == Self::STEPS || stalled {
                    break;
                }
                self.best.copy_from_slice(solution);
            } else {
                solution.copy_from_slice(&self.best);
                break;
            }
            self.back_end.solve(&mut self.residual);
            for (x, d) in solution.iter_mut().zip(&self.residual) {
                *x += d;
            }
            steps += 1;
        }
        SolveQuality {
            residual: best_residual,
            backward: if best_error == 0.0 {
                0.0
            } else {
                best_error / norm_b
            },
            steps,
        }
    }

    /// Entries of the factor.
    pub fn factor_entries(&self) -> usize {
        self.back_end.factor_entries()
    }
}
