//! The first place where a function falls through zero, which cannot be missed.
//!
//! Parts of an interval are looked at from the left, each until it is known that the function is not negative there, or that it only
//! falls: by its range, by lines through its ends of the least and the greatest slope, and by the sign of its slope. A part of which
//! none of this is known is halved (Moore, *Interval analysis*, 1966; Neumaier, *Interval methods for systems of equations*, 1990), and
//! so is one that may hold a pole or a jump, about which slopes say nothing: down to the two neighbours between which it is.

use super::range::Range;

/// A point and the function's value there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    pub(crate) at: f64,
    pub(crate) value: f64,
}

/// A function with bounds.
pub(crate) trait Bounded {
    /// Its value.
    fn value(&mut self, at: f64) -> f64;
    /// Its range over a part.
    fn range(&mut self, part: [f64; 2]) -> Range;
    /// The ranges of its slope and of the slope of that over a part, which may be a place; all numbers where they are not known.
    fn slopes(&mut self, part: [f64; 2]) -> [Range; 2];
}

/// What is known of a function between two places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Crossing {
    /// It is negative nowhere, but for less than what counts as zero.
    Nowhere,
    /// It is negative first between these neighbours.
    Between(Sample, Sample),
    /// It varies so fast that too many parts would have to be looked at.
    Undecided,
}

/// Parts after which a function varies too fast. One that crosses or dips at every tenth of them has that many in a step.
const MOST_PARTS: usize = 20_000;
/// Parts of this share of the place are not halved: all that is left of them is rounding.
const NARROWEST: f64 = 4.0 * f64::EPSILON;

/// The first place between `from`, where `f` is not below `-zero`, and `to` at which it falls below `-zero`.
pub(crate) fn first_crossing(
    f: &mut impl Bounded,
    from: Sample,
    to: Sample,
    zero: f64,
) -> Crossing {
    let mut left = from;
    let mut ends = vec![to];
    for _ in 0..MOST_PARTS {
        let Some(&right) = ends.last() else {
            return Crossing::Nowhere;
        };
        match look(f, left, right, zero) {
            Part::Positive => {
                left = right;
                ends.pop();
            }
            Part::Falls => return Crossing::Between(left, right),
            Part::Unknown => {
                let at = 0.5 * (left.at + right.at);
                let value = f.value(at);
                // What is behind a place where it is negative comes later.
                if value < -zero {
                    ends.clear();
                }
                ends.push(Sample { at, value });
            }
        }
    }
    Crossing::Undecided
}

enum Part {
    Positive,
    Falls,
    Unknown,
}

fn look(f: &mut impl Bounded, left: Sample, right: Sample, zero: f64) -> Part {
    let negative = right.value < -zero;
    let width = right.at - left.at;
    if width <= NARROWEST * right.at.abs() || width < f64::MIN_POSITIVE {
        return if negative {
            Part::Falls
        } else {
            Part::Positive
        };
    }
    let part = [left.at, right.at];
    let range = f.range(part);
    if !negative && range.low >= -zero {
        return Part::Positive;
    }
    if !range.is_continuous() {
        return Part::Unknown;
    }
    let [slope, mut bend] = f.slopes(part);
    if !slope.is_continuous() {
        bend = Range::ALL;
    }
    if negative {
        // What only falls, or is a hill, crosses once.
        let once = slope.high <= 0.0 || bend.high <= 0.0;
        return if once { Part::Falls } else { Part::Unknown };
    }
    let lines = least_of_lines(left.value, right.value, slope, width);
    if lines >= -zero {
        return Part::Positive;
    }
    // Parabolas from either end, with the slope there.
    let parabolas = [(left, 1.0), (right, -1.0)]
        .into_iter()
        .any(|(end, sense)| {
            bend.low > f64::NEG_INFINITY && {
                let slope = f.slopes([end.at, end.at])[0].scaled(sense);
                least_of_parabola((end.value, slope.low, bend.low), width) >= -zero
            }
        });
    if parabolas {
        Part::Positive
    } else {
        Part::Unknown
    }
}

/// The least value of a function with these values at the ends of a part of this width and slopes in this range: where the lines of
/// the least slope from the left and of the greatest to the right meet.
fn least_of_lines(left: f64, right: f64, slope: Range, width: f64) -> f64 {
    if slope.low >= 0.0 {
        return left;
    }
    if slope.high <= 0.0 {
        return right;
    }
    let spread = slope.width();
    if !spread.is_finite() {
        return f64::NEG_INFINITY;
    }
    let way = ((left - right + slope.high * width) / spread).clamp(0.0, width);
    left + slope.low * way
}

/// The least value over a width of `value + slope x + bend x^2/2`.
fn least_of_parabola((value, slope, bend): (f64, f64, f64), width: f64) -> f64 {
    let end = value + width * (slope + 0.5 * bend * width);
    if bend > 0.0 && slope < 0.0 && -slope < bend * width {
        return value - 0.5 * slope * slope / bend;
    }
    value.min(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `sin(w t) + b t - c`, by interval arithmetic, and how often it was asked.
    struct Wave {
        w: f64,
        b: f64,
        c: f64,
        asked: usize,
    }

    impl Bounded for Wave {
        fn value(&mut self, t: f64) -> f64 {
            (self.w * t).sin() + self.b * t - self.c
        }

        fn range(&mut self, [a, b]: [f64; 2]) -> Range {
            self.asked += 1;
            let t = Range::between(a, b);
            let sine = t.scaled(self.w).call(crate::model::tape::Function::Sin);
            sine + t.scaled(self.b) - Range::of(self.c)
        }

        fn slopes(&mut self, [a, b]: [f64; 2]) -> [Range; 2] {
            self.asked += 1;
            let t = Range::between(a, b).scaled(self.w);
            let cosine = t.call(crate::model::tape::Function::Cos);
            let sine = t.call(crate::model::tape::Function::Sin);
            let slope = cosine.scaled(self.w) + Range::of(self.b);
            [slope, sine.scaled(-self.w * self.w)]
        }
    }

    fn first(mut f: Wave, end: f64) -> (Crossing, usize) {
        let [from, to] = [0.0, end].map(|at| Sample {
            at,
            value: f.value(at),
        });
        let crossing = first_crossing(&mut f, from, to, 1e-13);
        (crossing, f.asked)
    }

    #[test]
    fn all_falls_of_a_fast_wave_are_found_one_after_the_other() {
        // sin(w t) >= c first ends where w t = pi - asin(c).
        for w in [5.0, 67.3, 1000.0] {
            let mut f = Wave {
                w,
                b: 0.0,
                c: 0.3,
                asked: 0,
            };
            let mut at = 0.5 * std::f64::consts::PI / w;
            let count = 20;
            for k in 0..count {
                let [from, to] = [at, 40.0].map(|at| Sample {
                    at,
                    value: f.value(at),
                });
                let Crossing::Between(left, right) = first_crossing(&mut f, from, to, 1e-13) else {
                    panic!("missed {k} of {w}");
                };
                let exact = (std::f64::consts::PI - 0.3_f64.asin()
                    + std::f64::consts::TAU * f64::from(k))
                    / w;
                assert!(left.at <= exact && exact <= right.at, "{k} of {w}");
                // Near the next top.
                at = exact + 1.6 * std::f64::consts::PI / w;
            }
            assert!(f.asked < 60 * count as usize, "{w}: {}", f.asked);
        }
    }

    #[test]
    fn dip_is_told_from_a_miss_down_to_rounding() {
        // With a slow rise the first dip is the lowest one: where the cosine is -b/w behind the bottom of the sine.
        let (w, b) = (40.0, 1e-3_f64);
        let place = (std::f64::consts::TAU - (-b / w).acos()) / w;
        let wave = |c| Wave { w, b, c, asked: 0 };
        let bottom = wave(0.0).value(place);
        for depth in [1e-2, 1e-6, 1e-11] {
            let (crossing, _) = first(wave(bottom + depth), 10.0);
            let Crossing::Between(left, right) = crossing else {
                panic!("missed {depth}: {crossing:?}");
            };
            let half = (2.0 * depth).sqrt() / w;
            assert!(left.at < place && (right.at - place).abs() < 1.1 * half);
            let (crossing, asked) = first(wave(bottom - depth), 10.0);
            assert_eq!(crossing, Crossing::Nowhere, "{depth}");
            assert!(asked < 4000, "{asked}");
        }
    }

    /// `z - y^3` for `z = t + c t^3`, `y = t`, with the ranges of both and nothing of what they have in common: what leaves a surface
    /// tangentially.
    struct TakeOff {
        c: f64,
        asked: usize,
    }

    impl Bounded for TakeOff {
        fn value(&mut self, t: f64) -> f64 {
            self.c * t.powi(3)
        }

        fn range(&mut self, [a, b]: [f64; 2]) -> Range {
            self.asked += 1;
            Range::between(a + self.c * a.powi(3), b + self.c * b.powi(3)) - Range::between(a, b)
        }

        fn slopes(&mut self, [a, b]: [f64; 2]) -> [Range; 2] {
            self.asked += 1;
            let t = Range::between(a, b);
            // Each part of the slope turns.
            let turning = Range::between(a - b, b - a);
            let slope = t.square().scaled(3.0 * self.c) + turning;
            [slope, t.scaled(6.0 * self.c) + turning]
        }
    }

    #[test]
    fn tangential_take_off_takes_few_parts() {
        let mut f = TakeOff { c: 0.3, asked: 0 };
        let [from, to] = [0.0, 1.0].map(|at| Sample {
            at,
            value: f.value(at),
        });
        assert_eq!(first_crossing(&mut f, from, to, 1e-13), Crossing::Nowhere);
        assert!(f.asked < 300, "{}", f.asked);
    }

    /// A positive function of which nothing but values is known.
    struct Unbounded;

    impl Bounded for Unbounded {
        fn value(&mut self, _: f64) -> f64 {
            1.0
        }

        fn range(&mut self, _: [f64; 2]) -> Range {
            Range::ALL
        }

        fn slopes(&mut self, _: [f64; 2]) -> [Range; 2] {
            [Range::ALL; 2]
        }
    }

    #[test]
    fn what_varies_too_fast_is_said() {
        let [from, to] = [0.0, 1.0].map(|at| Sample { at, value: 1.0 });
        let crossing = first_crossing(&mut Unbounded, from, to, 1e-13);
        assert_eq!(crossing, Crossing::Undecided);
    }
}
