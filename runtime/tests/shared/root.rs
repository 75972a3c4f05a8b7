//! Roots of closed forms, found by nothing that is tested.

/// Where a function that is positive at `low` and not at `high` vanishes, by bisection to rounding error.
pub(crate) fn root(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    loop {
        let middle = 0.5 * (low + high);
        if middle == low || middle == high {
            return middle;
        }
        *(if f(middle) > 0.0 { &mut low } else { &mut high }) = middle;
    }
}
