//! Rounding errors of gaps, measured: a gap of 1e-17 m may be one, of terms that are large and cancel inside of the model.
//!
//! What is left of the fourth difference of gaps at five points at equal distances along a motion is rounding error (More, Wild,
//! *Estimating computational noise*, 2011): what is smooth leaves the fourth power of the distance.

/// Gaps below so many of their rounding errors are closed.
pub(crate) const ROUNDINGS: f64 = 64.0;
/// Share of the motion of a moment by which the points are apart.
const APART: f64 = 1e-4;
/// Larger shares, where a moment is so short that large terms of the gap are one number at most points.
const FURTHER_APART: [f64; 5] = [1e-3, 1e-2, 1e-1, 1.0, 1e1];
/// Share of the coordinates themselves by which they are moved as well.
const OF_ALL: f64 = 1e-9;
/// Rounding errors at one distance are at most so many times those at the one before; what is smooth grows by the fourth power of the
/// factor, 10, what has a kink by the factor, and a root by its square root.
const LIKE: f64 = 3.0;
/// Fourth differences of numbers with an error of one have errors of this size, `sqrt(70)`.
const FOURTH_DIFFERENCE: f64 = 8.366_600_265_340_756;

/// Rounding error of a gap, from its values after shares of a moment in which the motion is smooth.
pub(crate) fn rounding_error(mut gap: impl FnMut(f64) -> f64) -> f64 {
    left_at(&mut gap, APART)
}

/// Rounding error of a gap at the start `x = (q, v, ..)` of a motion, as a function of that: along the motion with accelerations `a` in a
/// `moment` that is short beside any wave on the way, and along the line from the origin, since what rests does not move.
pub(crate) fn rounding_error_at_start(
    x: &[f64],
    a: &[f64],
    moment: f64,
    gap: impl Fn(&[f64]) -> f64,
) -> f64 {
    let n = a.len();
    let ways = (0..n).map(|k| moment * (x[n + k] + moment * a[k]) + OF_ALL * x[k]);
    let ways: Vec<f64> = ways.collect();
    let mut moved = x.to_vec();
    let mut gap = |share: f64| {
        for k in 0..n {
            moved[k] = x[k] + share * ways[k];
        }
        gap(&moved)
    };
    let near = left_at(&mut gap, APART);
    let further = FURTHER_APART.map(|apart| left_at(&mut gap, apart));
    let pairs = further.windows(2).filter(|pair| pair[1] <= LIKE * pair[0]);
    pairs.map(|pair| pair[0]).fold(near, f64::max)
}

/// What points so far apart show.
fn left_at(gap: &mut impl FnMut(f64) -> f64, apart: f64) -> f64 {
    let [a, b, c, d, e] = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|multiple| gap(multiple * apart));
    (a - 4.0 * b + 6.0 * c - 4.0 * d + e).abs() / FOURTH_DIFFERENCE
}

#[cfg(test)]
mod tests {
    use super::*;

    /// That of the gap of a coordinate that moves at 1.
    fn measured(place: f64, moment: f64, gap: impl Fn(f64) -> f64) -> f64 {
        rounding_error_at_start(&[place, 1.0], &[0.0], moment, |x| gap(x[0]))
    }

    #[test]
    fn rounding_error_of_a_gap_with_a_large_term_is_that_of_the_term_and_not_of_the_gap() {
        // Near the lowest point of a wave, which cancels in the gap: the cosine has errors of 1e-16.
        let trough = |y: f64| 0.4 * (1.0 - (2.0 * y).cos()) - 8e-9;
        for moment in [0.0, 1e-9, 1e-7] {
            let error = measured(1e-4, moment, trough);
            assert!((1e-18..2e-16).contains(&error), "{moment}: {error}");
        }
    }

    #[test]
    fn smooth_gaps_and_kinks_leave_no_rounding_error_at_the_start() {
        // Up to waves of which a moment is a sixth: the points that are furthest apart show no more than their height.
        for wave in [1e-4, 1e-2, 0.1, 1.0] {
            let error = measured(0.3, 1.0, |y| (wave * y).sin());
            assert!(error < 1e-15, "{wave}: {error}");
        }
        let error = measured(0.0, 1.0, |y| (y - 0.07).abs());
        assert!(error < 1e-15, "{error}");
        // The height at the nearest points, and not the hundred times as high one at the furthest.
        let error = measured(0.0, 1.0, |y| y.abs().sqrt());
        assert!(error < 1e-2, "{error}");
        assert!(measured(0.0, 1.0, |_| f64::NAN).is_nan());
    }
}
