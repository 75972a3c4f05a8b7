//! The filter: pairs of constraint violation and objective that no trial point may be dominated by.

/// Margin of the violation, gamma_theta.
pub(super) const GAMMA_THETA: f64 = 1e-5;
/// Margin of the objective, gamma_phi.
pub(super) const GAMMA_PHI: f64 = 1e-8;

/// Entries (theta, phi), margins already subtracted (Waechter and Biegler 2006, section 2.3).
#[derive(Debug, Clone, Default)]
pub(super) struct Filter {
    entries: Vec<(f64, f64)>,
    /// Violation above which no point is acceptable.
    pub(super) theta_max: f64,
}

impl Filter {
    pub(super) fn new(theta_max: f64) -> Self {
        Self {
            entries: Vec::with_capacity(64),
            theta_max,
        }
    }

    pub(super) fn clear(&mut self) {
        self.entries.clear();
    }

    /// Whether (theta, phi) is dominated by no entry and below the greatest violation.
    pub(super) fn accepts(&self, theta: f64, phi: f64) -> bool {
        theta <= self.theta_max
            && self
                .entries
                .iter()
                .all(|&(t, p)| theta <= t || not_above(phi, p, p))
    }

    /// Adds the envelope of (theta, phi) and drops entries that it dominates.
    pub(super) fn add(&mut self, theta: f64, phi: f64) {
        let entry = ((1.0 - GAMMA_THETA) * theta, phi - GAMMA_PHI * theta);
        self.entries.retain(|e| e.0 < entry.0 || e.1 < entry.1);
        self.entries.push(entry);
    }
}

/// `left <= right` up to ten units of rounding of `base`.
pub(super) fn not_above(left: f64, right: f64, base: f64) -> bool {
    left - right <= 10.0 * f64::EPSILON * base.abs()
}

/// Switching condition: the step promises so much descent of the objective, compared with the
/// violation, that the objective decides: `alpha (-slope)^2.3 > theta^1.1` (equation 19).
pub(super) fn is_switching(slope: f64, alpha: f64, theta: f64) -> bool {
    slope < 0.0 && alpha * (-slope).powf(2.3) > theta.powf(1.1)
}

/// Armijo condition `phi(alpha) <= phi + 1e-8 alpha slope` (equation 20).
pub(super) fn is_armijo(trial: f64, phi: f64, alpha: f64, slope: f64) -> bool {
    not_above(trial - phi, 1e-8 * alpha * slope, phi)
}

/// Sufficient progress in violation or objective compared with the current point (equation 18).
pub(super) fn is_sufficient(theta_trial: f64, phi_trial: f64, theta: f64, phi: f64) -> bool {
    not_above(theta_trial, (1.0 - GAMMA_THETA) * theta, theta)
        || not_above(phi_trial - phi, -GAMMA_PHI * theta, phi)
}

/// Step length below which the line search gives up (equation 23), `gamma_alpha = 0.05`.
pub(super) fn smallest_step(theta: f64, slope: f64, theta_min: f64) -> f64 {
    let mut bound = GAMMA_THETA;
    if slope < 0.0 {
        bound = bound.min(GAMMA_PHI * theta / -slope);
        if theta <= theta_min {
            bound = bound.min(theta.powf(1.1) / (-slope).powf(2.3));
        }
    }
    0.05 * bound
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accepts_point_dominated_in_both_measures_is_refused() {
        let mut filter = Filter::new(10.0);
        filter.add(1.0, 5.0);
        assert!(!filter.accepts(1.0, 5.0));
        assert!(filter.accepts(0.999, 5.0));
        assert!(filter.accepts(1.0, 4.999));
        assert!(!filter.accepts(11.0, -1e9));
    }

    #[test]
    fn add_dominating_entry_replaces_dominated_ones() {
        let mut filter = Filter::new(10.0);
        filter.add(1.0, 5.0);
        filter.add(2.0, 4.0);
        filter.add(0.5, 3.0);
        assert_eq!(filter.entries.len(), 1);
    }

    #[test]
    fn is_switching_compares_powers_of_slope_and_violation() {
        // 1 * 1^2.3 = 1 against 2^1.1 = 2.14 and 0.5^1.1 = 0.466
        assert!(!is_switching(-1.0, 1.0, 2.0));
        assert!(is_switching(-1.0, 1.0, 0.5));
        assert!(!is_switching(1.0, 1.0, 0.0));
    }

    #[test]
    fn is_armijo_needs_descent_in_proportion_to_the_slope() {
        assert!(is_armijo(0.9, 1.0, 1.0, -1.0));
        assert!(!is_armijo(1.1, 1.0, 1.0, -1.0));
    }

    #[test]
    fn smallest_step_follows_the_three_cases() {
        // slope >= 0: 0.05 gamma_theta
        assert_eq!(smallest_step(1.0, 1.0, 1e-4), 0.05 * 1e-5);
        // theta > theta_min, gamma_phi theta / -slope = 1e-8 * 1 / 10
        assert!((smallest_step(1.0, -10.0, 1e-4) - 0.05e-9).abs() < 1e-22);
        // theta <= theta_min: also theta^1.1 / slope^2.3 = 1e-11 / 1
        let theta: f64 = 1e-10;
        assert!((smallest_step(theta, -1.0, 1e-4) - 0.05 * 1e-18).abs() < 1e-30);
    }
}
