//! A zero between two neighbours, of which the function is positive at the first one.

use super::crossing::Sample;

/// Share of the way back that is kept by one step to the left, and number of such steps: together
/// `1e-10` of the way.
const RETREAT: f64 = 0.75;
const RETREATS: usize = 80;
/// Bracketing steps of a root; five or six are common.
const ROOT_STEPS: usize = 100;

/// The left end of a crossing, moved back to where the function exceeds `rounding`: `left` itself, or a point
/// on the way back from `right` to `from`, or `from` if the function does so nowhere.
pub(crate) fn positive_before(
    f: &mut impl FnMut(f64) -> f64,
    from: Sample,
    left: Sample,
    right: Sample,
    rounding: f64,
) -> Sample {
    if left.value > rounding {
        return left;
    }
    let mut width = right.at - from.at;
    for _ in 0..RETREATS {
        width *= RETREAT;
        let at = from.at + width;
        let value = f(at);
        if value > rounding {
            return Sample { at, value };
        }
    }
    from
}

/// Root of `f` between two samples of different sign, by the Illinois rule on the interpolant; the left
/// end if it is not positive.
pub(crate) fn root(f: &mut impl FnMut(f64) -> f64, mut left: Sample, mut right: Sample) -> f64 {
    if left.value <= 0.0 {
        return left.at;
    }
    // Which end moved last: 1 the left one, -1 the right one. An end that stays twice is halved.
    let mut moved = 0;
    for _ in 0..ROOT_STEPS {
        let width = right.at - left.at;
        let secant = right.at - right.value * width / (right.value - left.value);
        let middle = 0.5 * (left.at + right.at);
        // Beside a value that vanishes but for rounding secants have no place left, though the function may rise there before it falls.
        let inside = |at: &f64| *at > left.at && *at < right.at;
        let Some(at) = [secant, middle].into_iter().find(inside) else {
            break;
        };
        if width <= 1e-15 * right.at.abs() {
            break;
        }
        let value = f(at);
        if value > 0.0 {
            if moved == 1 {
                right.value *= 0.5;
            }
            left = Sample { at, value };
            moved = 1;
        } else if value < 0.0 {
            if moved == -1 {
                left.value *= 0.5;
            }
            right = Sample { at, value };
            moved = -1;
        } else {
            return at;
        }
    }
    if left.value.abs() < right.value.abs() {
        left.at
    } else {
        right.at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hill_that_begins_at_rounding_is_left_where_it_ends() {
        let f = |x: f64| 1.6e-15 + x - x * x;
        let [left, right] = [0.0, 3.0].map(|at| Sample { at, value: f(at) });
        let found = root(&mut { f }, left, right);
        assert!((found - 1.0).abs() < 1e-14, "{found}");
    }

    #[test]
    fn low_flight_before_a_deep_fall_is_found_behind_it() {
        let f = |x: f64| 1e-6 * x - x * x;
        let sample = |at| Sample { at, value: f(at) };
        // A start that is positive by rounding error is as good as zero.
        for start in [0.0, 1e-17] {
            let from = Sample {
                at: 0.0,
                value: start,
            };
            let left = positive_before(&mut |x| f(x), from, from, sample(1.0), 1e-15);
            assert!(left.value > 1e-15 && left.at > 0.0 && left.at < 1e-6);
        }
        let sinking = |x: f64| -x;
        let from = Sample {
            at: 0.0,
            value: 0.0,
        };
        let right = Sample {
            at: 1.0,
            value: -1.0,
        };
        assert_eq!(
            positive_before(&mut |x| sinking(x), from, from, right, 1e-15),
            from
        );
    }

    #[test]
    fn root_of_a_cubic_is_found_to_rounding() {
        let f = |x: f64| 0.2 - x * x * x;
        let sample = |at| Sample { at, value: f(at) };
        let found = root(&mut |at| f(at), sample(0.0), sample(1.0));
        assert!((found - 0.2_f64.cbrt()).abs() < 4e-16);
    }
}
