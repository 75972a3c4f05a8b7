//! The local error at the end of an element, estimated by how fast its polynomials converge.
//!
//! The embedded estimate `h |k_0 - p(0)|` has order `s`, the end of an element about twice that. How much more accurate it is
//! depends on what the element resolves: a part of the motion that turns by several radians in it is damped by about what the
//! embedded estimate says, however small its share is. Both are told apart by the Legendre coefficients `a_k` of the polynomial
//! `p` of degree `s - 1`: with the defect `D = |k_0 - p(0)|` they fall by the factor `rho` from one to the next, and the end is
//! `s - 1` of them more accurate:
//!
//! ```text
//! e = h/2 D min(1, rho)^(s-1),   rho = min(D / |a_(s-1)|, sqrt(2 (2s-3)/(2s-1) D / |a_(s-2)|))
//! ```
//!
//! For `y' = i w y` and Radau IIA this is about twice the error while `w h` is below `s`, and stays above it beyond, where it
//! grows like `w h`. The second term serves where a coefficient vanishes by chance, as those of an oscillation do in turn.

use super::FiniteElement;
use crate::fesd::finite_element::MotionSize;
use crate::rk::ButcherTableau;

/// Adds the local error of the solved `element` at its end, of each coordinate and then of each velocity, to `errors`.
/// `acceleration` is the true acceleration at the start; what rounding errors of the `motion` may be does not count.
pub(crate) fn add(
    element: &FiniteElement<'_>,
    acceleration: &[f64],
    motion: &MotionSize,
    errors: &mut [f64],
) {
    let (n, h, block, inputs) = (element.n, element.length, element.block(), element.inputs);
    let decay = Decay::new(element.tableau);
    let by_position = element.position_rounding(motion);
    let by_velocity = motion.rounding / h + element.cancelled_velocity();
    for (k, &start) in acceleration.iter().enumerate() {
        let velocity = |j: usize| element.inputs_of_stages[j * inputs + n + k];
        errors[k] += decay.error(element.start.v[k], velocity, h, by_position);
        let acceleration = |j: usize| element.unknowns[j * block + k];
        errors[n + k] += decay.error(start, acceleration, h, by_velocity);
    }
}

/// Weights of stage values for what the estimate reads of their polynomial.
struct Decay {
    stages: usize,
    at_start: [f64; ButcherTableau::MAX_STAGES],
    /// Legendre coefficients of degree `s - 1` and `s - 2`; the latter for three stages or more.
    last: [f64; ButcherTableau::MAX_STAGES],
    before: [f64; ButcherTableau::MAX_STAGES],
}

impl Decay {
    fn new(tableau: &ButcherTableau) -> Self {
        let stages = tableau.stages();
        let mut decay = Self {
            stages,
            at_start: [0.0; ButcherTableau::MAX_STAGES],
            last: [0.0; ButcherTableau::MAX_STAGES],
            before: [0.0; ButcherTableau::MAX_STAGES],
        };
        tableau.lagrange_values(0.0, &mut decay.at_start[..stages]);
        tableau.legendre_weights(stages - 1, &mut decay.last[..stages]);
        if stages > 2 {
            tableau.legendre_weights(stages - 2, &mut decay.before[..stages]);
        }
        decay
    }

    /// Error of the integral over a length `h` of what is `start` at its beginning and has the value `stage(j)` at stage
    /// `j`; an embedded estimate below `rounding` is none.
    fn error(&self, start: f64, stage: impl Fn(usize) -> f64, h: f64, rounding: f64) -> f64 {
        let s = self.stages;
        let sum = |weights: &[f64]| -> f64 {
            let terms = weights[..s].iter().enumerate();
            terms.map(|(j, weight)| weight * stage(j)).sum()
        };
        let squared = (s * s) as f64;
        let defect = ((sum(&self.at_start) - start).abs() - squared * rounding / h).max(0.0);
        if defect == 0.0 {
            return 0.0;
        }
        let mut ratio = (defect / sum(&self.last).abs()).min(1.0);
        if s > 2 {
            let (above, below) = ((4 * s - 6) as f64, (2 * s - 1) as f64);
            ratio = ratio.min((above / below * defect / sum(&self.before).abs()).sqrt());
        }
        0.5 * h * defect * ratio.powi(s as i32 - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::dense;
    use crate::rk::Scheme;

    /// Stage values and error of the end of one step of length 1 for `y' = i w y`, `y(0) = exp(i phase)`: of the real part, from
    /// the real system with the matrix `[[0, -w], [w, 0]]`. The stages are slopes.
    fn oscillation(tableau: &ButcherTableau, w: f64, phase: f64) -> (Vec<f64>, f64) {
        let s = tableau.stages();
        let (c, d) = (phase.cos(), phase.sin());
        let mut matrix = vec![0.0; 4 * s * s];
        let mut slopes = vec![0.0; 2 * s];
        for i in 0..s {
            (slopes[i], slopes[s + i]) = (-w * d, w * c);
            for j in 0..s {
                let same = f64::from(u8::from(i == j));
                matrix[i * 2 * s + j] = same;
                matrix[i * 2 * s + s + j] = w * tableau.a(i, j);
                matrix[(s + i) * 2 * s + s + j] = same;
                matrix[(s + i) * 2 * s + j] = -w * tableau.a(i, j);
            }
        }
        let mut pivots = vec![0; 2 * s];
        assert!(dense::factorize(&mut matrix, &mut pivots).is_ok());
        dense::solve(&matrix, &pivots, &mut slopes);
        let end: f64 = c + (0..s).map(|j| tableau.b()[j] * slopes[j]).sum::<f64>();
        slopes.truncate(s);
        (slopes, (end - (phase + w).cos()).abs())
    }

    #[test]
    fn estimate_is_above_the_error_of_an_oscillation_resolved_or_not() {
        for stages in 1..=ButcherTableau::MAX_STAGES {
            let tableau = ButcherTableau::new(Scheme::RadauIia, stages).expect("a scheme");
            let decay = Decay::new(&tableau);
            for w in [0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 60.0, 500.0] {
                let (mut estimated, mut actual) = (0.0_f64, 0.0_f64);
                // The largest over the phases is what adds up.
                for k in 0..24 {
                    let phase = std::f64::consts::PI * f64::from(k) / 12.0;
                    let (slopes, error) = oscillation(&tableau, w, phase);
                    let start = -w * phase.sin();
                    estimated = estimated.max(decay.error(start, |j| slopes[j], 1.0, 0.0));
                    actual = actual.max(error);
                }
                assert!(
                    estimated > 0.3 * actual || actual < 1e-12,
                    "{stages} stages, w = {w}: {estimated:e} for {actual:e}"
                );
                // Not much more than the error while a step resolves what moves.
                assert!(
                    w > stages as f64 || estimated < 30.0 * actual + 1e-12,
                    "{stages} stages, w = {w}: {estimated:e} for {actual:e}"
                );
            }
        }
    }
}
