//! The primal-dual point.

use super::barrier_problem::BarrierProblem;

/// A primal-dual point of a barrier problem.
#[derive(Debug, Clone, Default)]
pub(crate) struct Iterate {
    /// Variables and slacks (x, s).
    pub(crate) v: Vec<f64>,
    /// Multipliers of the rows, product rows last.
    pub(crate) y: Vec<f64>,
    /// Multipliers of the bounds; zero where there is no bound.
    pub(crate) z_lower: Vec<f64>,
    pub(crate) z_upper: Vec<f64>,
}

impl Iterate {
    pub(crate) fn zeros(problem: &BarrierProblem) -> Self {
        let n = problem.variables();
        Self {
            v: vec![0.0; n],
            y: vec![0.0; problem.rows()],
            z_lower: vec![0.0; n],
            z_upper: vec![0.0; n],
        }
    }

    /// Takes over the values of `other`, which has the same shape.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.v.copy_from_slice(&other.v);
        self.y.copy_from_slice(&other.y);
        self.z_lower.copy_from_slice(&other.z_lower);
        self.z_upper.copy_from_slice(&other.z_upper);
    }
}

/// Largest step length in (0, 1] that keeps `v + alpha d` a fraction `tau` inside its bounds.
pub(crate) fn longest_primal_step(problem: &BarrierProblem, v: &[f64], d: &[f64], tau: f64) -> f64 {
    let mut alpha: f64 = 1.0;
    let bounds = problem.lower.iter().zip(&problem.upper);
    for ((&v, &d), (&lower, &upper)) in v.iter().zip(d).zip(bounds) {
        let room = tau * if d < 0.0 { v - lower } else { upper - v };
        // most steps end before they need a division; a bound that is not there is infinitely far
        if room < alpha * d.abs() {
            alpha = room / d.abs();
        }
    }
    alpha
}

/// Largest step length in (0, 1] that keeps `z + alpha d >= (1 - tau) z`.
pub(crate) fn longest_dual_step(z: &[f64], d: &[f64], tau: f64) -> f64 {
    let mut alpha: f64 = 1.0;
    for (&z, &d) in z.iter().zip(d) {
        if z > 0.0 && tau * z < alpha * -d {
            alpha = -tau * z / d;
        }
    }
    alpha
}

/// `z` clipped to `[mu / (kappa distance), kappa mu / distance]` (Waechter and Biegler, equation 16).
pub(crate) fn safeguarded(z: f64, distance: f64, mu: f64) -> f64 {
    const KAPPA: f64 = 1e10;
    let product = z * distance;
    if product > KAPPA * mu {
        KAPPA * mu / distance
    } else if product * KAPPA < mu {
        mu / (KAPPA * distance)
    } else {
        z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn longest_dual_step_stops_at_the_fraction() {
        assert_eq!(longest_dual_step(&[1.0, 2.0], &[-2.0, 1.0], 0.99), 0.495);
        assert_eq!(longest_dual_step(&[1.0], &[-0.5], 0.99), 1.0);
    }

    #[test]
    fn safeguarded_keeps_the_product_near_mu() {
        assert_eq!(safeguarded(1e15, 1.0, 1e-2), 1e8);
        assert_eq!(safeguarded(0.0, 1.0, 1e-2), 1e-12);
        assert_eq!(safeguarded(0.5, 1.0, 1e-2), 0.5);
    }
}
