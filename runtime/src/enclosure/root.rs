//! A zero between two neighbours, of which the function is positive at the first one.

use super::crossing::Sample;

/// Share of the way back that is kept by one step to the left, and number of such steps: together
/// `1e-10` of the way.
const RETREAT: f64 = 0.75;
const RETREATS: usize = 80;
/// Bracketing steps of a root; five or six are common.
const ROOT_STEPS: usize = 100;
/// Secant steps before bisection.
const SECANTS: usize = 12;
/// Secant steps and bisections together; 64 bisections use up all digits.
const POLISHING: usize = 80;

/// Places between which a function falls through zero, a guess of where, and its slope there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bracket {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) guess: f64,
    pub(crate) slope: f64,
}

/// Where in a bracket a function vanishes, to this `resolution` of places, and its value there. The value is larger than `zero` if it is
/// that throughout, and far below if the sign changes without a zero. The function is asked there last.
///
/// A root is where the sign of the function changes, whatever its size: a force that vanishes has no terms left
/// that could tell how small it is.
///
/// # Errors
/// Those of the function.
pub(crate) fn refine<E>(
    mut value: impl FnMut(f64) -> Result<f64, E>,
    bracket: Bracket,
    (zero, resolution): (f64, f64),
) -> Result<(f64, f64), E> {
    let Bracket {
        mut low,
        mut high,
        guess: mut at,
        mut slope,
    } = bracket;
    let mut f = value(at)?;
    let mut beyond = resolution;
    for iteration in 0..POLISHING {
        if f > 0.0 {
            low = at;
        } else {
            high = at;
        }
        if f == 0.0 || at >= high && f > 0.0 {
            break;
        }
        let newton = at - f / slope;
        let mut next = if iteration < SECANTS && newton >= low && newton <= high {
            newton
        } else {
            0.5 * (low + high)
        };
        if (next - at).abs() <= resolution || high - low <= resolution {
            if f <= zero {
                break;
            }
            // Positive at the root to working accuracy: the change of sign is just behind it.
            next = (at + beyond).min(high);
            beyond *= 4.0;
        }
        let f_next = value(next)?;
        let secant = (f_next - f) / (next - at);
        if secant < 0.0 {
            slope = secant;
        }
        (at, f) = (next, f_next);
    }
    Ok((at, f))
}

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
