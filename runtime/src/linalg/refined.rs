//! Solves with iterative refinement and a check of the residual.

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
        for row in 0..self.pattern.dimension() {
            self.values[self.pattern.diagonal(row)] +=
                if row < self.primal { delta_w } else { -delta_c };
        }
        self.back_end.factor(values, delta_w, delta_c)
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
            self.residual.fill(0.0);
            self.pattern
                .multiply_add(&self.values, solution, &mut self.residual);
            for (r, b) in self.residual.iter_mut().zip(right_hand_side) {
                *r = b - *r;
            }
            let scale = norm_inf(solution).min(1e6 * norm_b) + norm_b;
            let error = norm_inf(&self.residual);
            let residual = if error == 0.0 { 0.0 } else { error / scale };
            // also false for a residual that is not a number
            let improved = residual < best_residual;
            if improved {
                let stalled = residual > 0.5 * best_residual && steps > 2;
                best_residual = residual;
                best_error = error;
                self.best.copy_from_slice(solution);
                if residual <= Self::TARGET || steps == Self::STEPS || stalled {
                    break;
                }
            } else {
                break;
            }
            self.back_end.solve(&mut self.residual);
            for (x, d) in solution.iter_mut().zip(&self.residual) {
                *x += d;
            }
            steps += 1;
        }
        solution.copy_from_slice(&self.best);
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

/// Largest absolute entry; not a number if there is one.
fn norm_inf(x: &[f64]) -> f64 {
    let (fours, others) = x.as_chunks::<4>();
    let mut lanes = [0.0_f64; 4];
    // zero for finite entries, and not a number from the first that is not
    let mut faults = [0.0_f64; 4];
    for four in fours {
        for ((lane, fault), a) in lanes.iter_mut().zip(&mut faults).zip(four) {
            if a.abs() > *lane {
                *lane = a.abs();
            }
            *fault += a * 0.0;
        }
    }
    let mut norm: f64 = 0.0;
    let mut fault: f64 = faults.iter().sum();
    for a in lanes.iter().chain(others) {
        norm = norm.max(a.abs());
        fault += a * 0.0;
    }
    if fault == 0.0 {
        norm
    } else if x.iter().any(|a| a.is_nan()) {
        f64::NAN
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norm_inf_sees_every_lane_and_every_fault() {
        let mut x = vec![1.0; 11];
        for k in 0..x.len() {
            x[k] = -3.0;
            assert_eq!(norm_inf(&x), 3.0);
            x[k] = f64::NEG_INFINITY;
            assert_eq!(norm_inf(&x), f64::INFINITY);
            x[k] = f64::NAN;
            assert!(norm_inf(&x).is_nan());
            x[k] = 1.0;
        }
        assert_eq!(norm_inf(&[]), 0.0);
    }
}
