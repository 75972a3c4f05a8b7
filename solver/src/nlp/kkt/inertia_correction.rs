//! Shifts of the Newton matrix until it has the inertia of a descent direction.

use super::kkt_system::KktSystem;
use crate::linalg::Inertia;
use crate::nlp::program::barrier_problem::BarrierProblem;
use crate::nlp::program::iterate::Iterate;

/// What the next factorization of a matrix with wrong inertia should use.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Remedy {
    ShiftRows,
    CapProducts,
    ShiftHessian(f64),
}

/// Memory of the shifts over the iterations (Waechter and Biegler 2006, section 3.1).
#[derive(Debug, Clone, Default)]
pub(crate) struct InertiaCorrection {
    /// Last successful shift, 0 before the first.
    last: f64,
    /// Shift that the current matrix was factorized with.
    pub(crate) delta_w: f64,
    pub(crate) delta_c: f64,
    /// Matrices one after the other whose rows were dependent, until they are taken to be.
    dependent: usize,
}

impl InertiaCorrection {
    const FIRST: f64 = 1e-4;
    const LARGEST: f64 = 1e20;
    const SMALLEST: f64 = 1e-20;
    /// Matrices with dependent rows one after the other after which those of the next ones are taken to be dependent, without a
    /// factorization that shows it.
    const DEPENDENT: usize = 3;

    /// Shift to try after `tried` (0: none yet) failed; `floor` is a shift wanted for other reasons.
    fn next_shift(&self, tried: Option<f64>, floor: f64) -> f64 {
        match tried {
            None if self.last == 0.0 => Self::FIRST.max(8.0 * floor),
            None => (self.last / 3.0).max(8.0 * floor).max(Self::SMALLEST),
            Some(shift) if self.last == 0.0 => 100.0 * shift,
            Some(shift) => 8.0 * shift,
        }
    }

    /// Factorizes the assembled matrix, shifting until the inertia is `(n, m, 0)`.
    ///
    /// Too few negative eigenvalues or a zero pivot mean dependent rows: `delta_c` first. Then the
    /// off-diagonal of pairs is capped, and only then `delta_w` grows from `floor` on. `false` when no
    /// shift up to 1e20 helps.
    pub(crate) fn factorize(
        &mut self,
        kkt: &mut KktSystem,
        problem: &BarrierProblem,
        iterate: &Iterate,
        mu: f64,
        floor: f64,
        permanent_dual_shift: f64,
    ) -> bool {
        let m = kkt.rows();
        self.delta_w = floor;
        self.delta_c = permanent_dual_shift * mu.powf(0.25);
        let mut rows_shifted = self.dependent >= Self::DEPENDENT;
        if rows_shifted {
            self.shift_rows(mu);
        }
        let mut capped = problem.products.is_empty();
        let mut tried = None;
        loop {
            let inertia = kkt.factor(self.delta_w, self.delta_c);
            let remedy = match inertia {
                Ok(Inertia { negative, zero, .. }) if negative == m && zero == 0 => break,
                Ok(Inertia { negative, zero, .. })
                    if (negative < m || zero > 0) && !rows_shifted =>
                {
                    Remedy::ShiftRows
                }
                Err(_) => return false,
                _ if !capped => Remedy::CapProducts,
                _ => Remedy::ShiftHessian(self.next_shift(tried, floor)),
            };
            match remedy {
                Remedy::ShiftRows => {
                    rows_shifted = true;
                    self.shift_rows(mu);
                }
                Remedy::CapProducts => {
                    capped = true;
                    kkt.assemble(problem, iterate, mu, true);
                }
                Remedy::ShiftHessian(shift) => {
                    if shift > Self::LARGEST {
                        return false;
                    }
                    tried = Some(shift);
                    self.delta_w = shift;
                }
            }
        }
        if tried.is_some() {
            self.last = self.delta_w;
        }
        self.dependent = if rows_shifted { self.dependent + 1 } else { 0 };
        true
    }

    fn shift_rows(&mut self, mu: f64) {
        self.delta_c = self.delta_c.max(1e-8 * mu.powf(0.25));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn next_shift_starts_small_and_grows_by_100_until_the_first_success_then_by_8() {
        let mut memory = InertiaCorrection::default();
        assert_eq!(memory.next_shift(None, 0.0), 1e-4);
        assert_eq!(memory.next_shift(Some(1e-4), 0.0), 1e-2);
        memory.last = 9.0;
        assert_eq!(memory.next_shift(None, 0.0), 3.0);
        assert_eq!(memory.next_shift(Some(3.0), 0.0), 24.0);
        assert_eq!(memory.next_shift(None, 1.0), 8.0);
    }
}
