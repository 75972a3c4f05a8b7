//! Finding where a function of time first becomes negative.

/// Levels of bisection that are always made: eight parts of a step are looked at.
const LEAST_DEPTH: u32 = 3;
/// Levels of bisection after which the double-precision numbers between two points run out.
const LARGEST_DEPTH: u32 = 48;
/// Evaluations after which a function counts as noise around zero.
const LARGEST_COUNT: usize = 2000;
/// Share of the way back that is kept by one step to the left, and number of such steps: together
/// `1e-10` of the way.
const RETREAT: f64 = 0.75;
const RETREATS: usize = 80;
/// Bracketing steps of a root; five or six are common.
const ROOT_STEPS: usize = 100;

/// A point and the function's value there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::simulation) struct Sample {
    pub(in crate::simulation) at: f64,
    pub(in crate::simulation) value: f64,
}

/// The first crossing of zero from above between `from` and `to`: neighbouring samples of which the
/// second is below `-zero`. Minima between samples are followed down: a part of the interval is left
/// aside only if its lower end exceeds half the second difference there, four times the dip that a
/// parabola could hide.
pub(in crate::simulation) fn first_crossing(
    f: &mut impl FnMut(f64) -> f64,
    from: Sample,
    to: Sample,
    zero: f64,
) -> Option<(Sample, Sample)> {
    let mut search = Search { f, zero, count: 0 };
    search.halves(from, to, 0)
}

/// The left end of a crossing, moved back to where the function exceeds `rounding`: `left` itself, or a point
/// on the way back from `right` to `from`, or `from` if the function does so nowhere.
pub(in crate::simulation) fn positive_before(
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

struct Search<'a, F> {
    f: &'a mut F,
    zero: f64,
    count: usize,
}

impl<F: FnMut(f64) -> f64> Search<'_, F> {
    fn halves(&mut self, from: Sample, to: Sample, depth: u32) -> Option<(Sample, Sample)> {
        self.count += 1;
        let at = 0.5 * (from.at + to.at);
        let middle = Sample {
            at,
            value: (self.f)(at),
        };
        let hidden = 0.5 * (from.value - 2.0 * middle.value + to.value).abs();
        for (left, right) in [(from, middle), (middle, to)] {
            let crosses = right.value < -self.zero;
            let may_dip = if crosses {
                hidden > (left.value - right.value).abs()
            } else {
                hidden > self.zero && left.value.min(right.value) - hidden < -self.zero
            };
            let deeper = depth + 1 < LEAST_DEPTH
                || (may_dip && depth < LARGEST_DEPTH && self.count < LARGEST_COUNT);
            if deeper && let Some(found) = self.halves(left, right, depth + 1) {
                return Some(found);
            }
            if crosses {
                return Some((left, right));
            }
        }
        None
    }
}

/// Root of `f` between two samples of different sign, by the Illinois rule on the interpolant; the left
/// end if it is not positive.
pub(in crate::simulation) fn root(
    f: &mut impl FnMut(f64) -> f64,
    mut left: Sample,
    mut right: Sample,
) -> f64 {
    if left.value <= 0.0 {
        return left.at;
    }
    // Which end moved last: 1 the left one, -1 the right one. An end that stays twice is halved.
    let mut moved = 0;
    for _ in 0..ROOT_STEPS {
        let width = right.at - left.at;
        let at = right.at - right.value * width / (right.value - left.value);
        if width <= 1e-15 * right.at.abs() || !(at > left.at && at < right.at) {
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

    fn crossing(f: impl Fn(f64) -> f64, zero: f64) -> Option<(f64, f64)> {
        let sample = |at| Sample { at, value: f(at) };
        first_crossing(&mut |at| f(at), sample(0.0), sample(1.0), zero)
            .map(|(left, right)| (left.at, right.at))
    }

    #[test]
    fn dip_between_samples_is_found_however_narrow() {
        for depth in [1e-2, 1e-5, 1e-9] {
            let f = |x: f64| (x - 0.3141).powi(2) - depth;
            let (left, right) = crossing(f, 1e-14).unwrap();
            let exact = 0.3141 - depth.sqrt();
            assert!(left <= exact && exact <= right);
        }
    }

    #[test]
    fn touching_without_crossing_is_no_crossing() {
        assert_eq!(crossing(|x| (x - 0.3141).powi(2), 1e-14), None);
        assert_eq!(crossing(|x| (x - 0.3141).powi(2) + 1e-9, 1e-14), None);
        assert_eq!(crossing(|x| x.powi(3), 1e-14), None);
        assert_eq!(crossing(|_| 0.0, 1e-14), None);
        assert_eq!(crossing(|_| f64::NAN, 1e-14), None);
    }

    #[test]
    fn first_of_several_crossings_is_reported() {
        let f = |x: f64| (17.0 * x).cos() + 0.5;
        let (left, right) = crossing(f, 1e-14).unwrap();
        let exact = (2.0 * std::f64::consts::FRAC_PI_3) / 17.0;
        assert!(left <= exact && exact <= right);
        let (left, right) = crossing(|x| x - 2.0 * x * x, 1e-14).unwrap();
        assert!(left <= 0.5 && 0.5 <= right);
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
    fn noise_larger_than_the_threshold_ends() {
        // Not a crossing to be relied on; what matters is that the search comes back.
        let noise = |x: f64| 1e-3 * (x * 1e9).sin();
        let _ = crossing(noise, 1e-14);
        let _ = crossing(|x| 2e-3 + noise(x), 1e-14);
    }

    #[test]
    fn root_of_a_cubic_is_found_to_rounding() {
        let f = |x: f64| 0.2 - x * x * x;
        let sample = |at| Sample { at, value: f(at) };
        let found = root(&mut |at| f(at), sample(0.0), sample(1.0));
        assert!((found - 0.2_f64.cbrt()).abs() < 4e-16);
    }
}
