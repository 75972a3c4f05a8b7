//! Gradient-based scaling and the start inside the bounds.

/// Size that no gradient of objective and rows exceeds at the start.
pub(crate) const GRADIENT: f64 = 100.0;

/// Factor that brings a gradient of size `largest` down to 100; never enlarges, never below 1e-8.
pub(crate) fn row_scaling(largest: f64) -> f64 {
    if largest > GRADIENT {
        (GRADIENT / largest).max(1e-8)
    } else {
        1.0
    }
}

/// `value` pushed into the interior of `[lower, upper]` (Waechter and Biegler 2006, section 3.6):
/// at least `push max(1, |bound|)` from a bound, and at most the fraction `fraction` of the interval.
pub(crate) fn interior(value: f64, lower: f64, upper: f64, push: f64, fraction: f64) -> f64 {
    let width = upper - lower;
    let mut value = value;
    if lower.is_finite() {
        let mut distance = push * lower.abs().max(1.0);
        if upper.is_finite() {
            distance = distance.min(fraction * width);
        }
        value = value.max(lower + distance);
    }
    if upper.is_finite() {
        let mut distance = push * upper.abs().max(1.0);
        if lower.is_finite() {
            distance = distance.min(fraction * width);
        }
        value = value.min(upper - distance);
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn row_scaling_leaves_small_gradients_and_limits_large_ones() {
        assert_eq!(row_scaling(99.0), 1.0);
        assert_eq!(row_scaling(1e4), 1e-2);
        assert_eq!(row_scaling(1e20), 1e-8);
    }

    #[test]
    fn interior_keeps_the_given_distances() {
        assert_eq!(interior(0.0, 0.0, f64::INFINITY, 1e-2, 1e-2), 1e-2);
        assert_eq!(interior(9.0, f64::NEG_INFINITY, 5.0, 1e-2, 1e-2), 4.95);
        assert_eq!(interior(0.0, 0.0, 0.1, 1e-2, 1e-2), 1e-3);
        assert_eq!(
            interior(3.0, f64::NEG_INFINITY, f64::INFINITY, 1.0, 0.1),
            3.0
        );
    }
}
