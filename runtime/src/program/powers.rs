//! Powers of ten as units: what a person would choose for a size.

/// Base of the units of lengths and of what is measured like them.
pub(crate) const THOUSAND: f64 = 1e3;
/// Base of the units of objectives.
pub(crate) const MILLION: f64 = 1e6;
const TEN: f64 = 10.0;

/// Size of an objective with derivatives up to `largest`: a power of a million, or of ten where that is smaller.
pub(crate) fn objective_size(largest: f64) -> f64 {
    nearest_power(MILLION, largest).min(nearest_power(TEN, largest))
}

/// The power of a base nearest to a size; 1 for none.
pub(crate) fn nearest_power(base: f64, size: f64) -> f64 {
    let power = base.powf((size.log10() / base.log10()).round());
    if (power * power).is_normal() && (1.0 / (power * power)).is_normal() {
        power
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_power_of_a_thousand_leaves_ordinary_numbers_alone() {
        // What is left of zero by rounding is no size: nothing can be divided by it, nor by its square.
        for size in [
            0.04,
            1.0,
            31.0,
            0.0,
            5e-324,
            1e-170,
            1e170,
            f64::INFINITY,
            f64::NAN,
        ] {
            assert_eq!(nearest_power(1e3, size), 1.0, "{size}");
        }
        assert_eq!([40.0, 31e3].map(|size| nearest_power(1e3, size)), [1e3; 2]);
        assert_eq!(nearest_power(1e3, 0.4e-3), 1e-3);
    }
}
