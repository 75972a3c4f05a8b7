//! Interval arithmetic: the values that an operation has for any numbers of the ranges of its operands.
//!
//! Operands count as independent of each other but for squares, so that a range contains all that a function has, and mostly some
//! more. Bounds are not rounded outward: their rounding errors, some `1e-16` of the numbers they consist of, are less than what counts
//! as zero of any function. Sources: Moore, *Interval analysis* (1966); for what is known to be continuous the decorations of IEEE
//! 1788-2015.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::{Add, Mul, Neg, Sub};

use crate::model::tape::Function;
use hangtime_dsl::description::{inverse_root, piecewise};

/// Share of an angle by which its rounding may hide a greatest value of a sine.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Part of an argument over which a function is a polynomial of a few powers: an angle of one radian, or a factor `e`.
pub(super) const CALM: f64 = 1.0;
/// Arguments from which on exponential and hyperbolic functions differ from their limits by rounding.
const SATURATED: f64 = 40.0;
/// Pieces of a function given by points that the stages of a step tell.
const PIECES: usize = 8;
/// Order of the last derivative of such a function that is continuous (Reinsch, 1967, for natural quintic splines).
const SMOOTH: usize = 4;

/// From a least to a greatest number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Range {
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Whether the values are known to be those of a function that has one everywhere, and neither pole nor jump.
    continuous: bool,
}

impl Range {
    /// All numbers.
    pub(crate) const ALL: Self = Self {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
        continuous: false,
    };

    /// One number.
    pub(crate) fn of(value: f64) -> Self {
        Self::between(value, value)
    }

    /// That between two numbers, in whatever order; all numbers where one of them is none.
    pub(crate) fn between(a: f64, b: f64) -> Self {
        if a.is_nan() || b.is_nan() {
            return Self::ALL;
        }
        Self {
            low: a.min(b),
            high: a.max(b),
            continuous: true,
        }
    }

    /// Whether it is that of a function without poles and jumps: only of such a one a slope says how it goes on.
    pub(crate) fn is_continuous(self) -> bool {
        self.continuous && self.width().is_finite()
    }

    /// That of a function which is continuous only `if` this holds as well.
    fn continuous_if(self, holds: bool) -> Self {
        let continuous = self.continuous && holds;
        Self { continuous, ..self }
    }

    /// That of some numbers.
    pub(crate) fn hull(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values = values.into_iter();
        let first = values.next().map_or(Self::ALL, Self::of);
        values.fold(first, |range, value| range.with(Self::of(value)))
    }

    /// That of both.
    pub(crate) fn with(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            continuous: self.continuous && other.continuous,
        }
    }

    /// What both have in common, which is not nothing.
    pub(crate) fn within(self, other: Self) -> Self {
        let (low, high) = (self.low.max(other.low), self.high.min(other.high));
        if low <= high {
            Self { low, high, ..self }
        } else {
            self
        }
    }

    pub(crate) fn contains(self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    pub(crate) fn width(self) -> f64 {
        self.high - self.low
    }

    fn is_one_number(self) -> bool {
        self.low == self.high
    }

    pub(crate) fn scaled(self, factor: f64) -> Self {
        self.monotone(|value| factor * value)
    }

    pub(crate) fn square(self) -> Self {
        let size = self.size();
        size.monotone(|value| value * value)
    }

    /// Absolute values.
    pub(crate) fn size(self) -> Self {
        let mut size = self.monotone(f64::abs);
        if self.contains(0.0) {
            size.low = 0.0;
        }
        size
    }

    /// Through a divisor that may vanish: without bound where it has one sign, and any number where it has both.
    pub(crate) fn over(self, divisor: Self) -> Self {
        let (low, high) = (divisor.low, divisor.high);
        // Zeros of one sign: the inverse of either is without bound in the sense of the other end.
        let inverse = match (low < 0.0, high > 0.0) {
            (false, true) => Self::between(1.0 / high, 1.0 / low.abs()),
            (true, false) => Self::between(1.0 / low, -1.0 / high.abs()),
            _ => return Self::ALL,
        };
        self * inverse.continuous_if(divisor.continuous && !divisor.contains(0.0))
    }

    /// Of a function that only rises, or only falls, and is continuous.
    fn monotone(self, f: impl Fn(f64) -> f64) -> Self {
        Self::between(f(self.low), f(self.high)).continuous_if(self.continuous)
    }

    /// Of a function that has values between these two only: any number where it may have none, so that nobody takes the motion for known
    /// beyond the place where the function ends.
    fn inside(self, low: f64, high: f64, f: impl Fn(f64) -> f64) -> Self {
        if self.low < low || self.high > high {
            return Self::ALL;
        }
        self.monotone(f)
    }

    pub(crate) fn root(self) -> Self {
        self.inside(0.0, f64::INFINITY, f64::sqrt)
    }

    /// Whether it contains a place `first + k period`.
    fn meets(self, first: f64, period: f64) -> bool {
        let slack = ROUNDING * self.low.abs().max(self.high.abs());
        let next = ((self.low - slack - first) / period).ceil();
        first + next * period <= self.high + slack
    }

    /// Of a function of period 2 pi with its greatest value 1 at `top` and its least -1 half a period from there.
    fn wave(self, top: f64, f: impl Fn(f64) -> f64) -> Self {
        if !self.width().is_finite() || self.width() >= TAU {
            return Self::between(-1.0, 1.0).continuous_if(self.continuous);
        }
        let mut range = self.monotone(f);
        if self.meets(top, TAU) {
            range.high = 1.0;
        }
        if self.meets(top + PI, TAU) {
            range.low = -1.0;
        }
        range
    }

    pub(crate) fn call(self, function: Function) -> Self {
        match function {
            Function::Sin => self.wave(FRAC_PI_2, f64::sin),
            Function::Cos => self.wave(0.0, f64::cos),
            // It only rises but for its poles.
            Function::Tan if self.width() < PI && self.low.tan() <= self.high.tan() => {
                self.monotone(f64::tan)
            }
            Function::Tan => Self::ALL,
            Function::Asin => self.inside(-1.0, 1.0, f64::asin),
            Function::Acos => self.inside(-1.0, 1.0, f64::acos),
            Function::Atan => self.monotone(f64::atan),
            Function::Sinh => self.monotone(f64::sinh),
            Function::Cosh => self.size().monotone(f64::cosh),
            Function::Tanh => self.monotone(f64::tanh),
            Function::Exp => self.monotone(f64::exp),
            Function::Ln => self.inside(0.0, f64::INFINITY, f64::ln),
            Function::Cbrt => self.monotone(f64::cbrt),
            Function::Root => self.root(),
            Function::InverseRoot if self.low <= 0.0 => Self::ALL,
            Function::InverseRoot => self.monotone(inverse_root),
            Function::Abs => self.size(),
            Function::Sign => self
                .monotone(f64::signum)
                .continuous_if(!self.contains(0.0) || self.is_one_number()),
            Function::Profile(profile) => {
                self.pieces(profile.pieces(), usize::from(profile.order()))
            }
        }
    }

    /// Of a function given by points: of each piece that it touches, by the mean value over the part of it.
    fn pieces(self, pieces: &[(f64, [f64; 6])], order: usize) -> Self {
        if !self.width().is_finite() {
            return Self::ALL;
        }
        let inner = pieces.iter().skip(1).map(|piece| piece.0);
        let inner = inner.filter(|from| self.low < *from && *from < self.high);
        let mut ends = vec![self.low];
        ends.extend(inner);
        ends.push(self.high);
        let value = |order: usize, x: f64| piecewise(pieces, order, x);
        let part = |ends: &[f64]| {
            let (a, b) = (ends[0], ends[1]);
            // The polynomial around the middle with all its derivatives.
            let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
            let reach = Self::between(-half, half);
            let mut sum = Self::of(0.0);
            for k in (order..6).rev() {
                let share = 1.0 / (k - order + 1) as f64;
                sum = Self::of(value(k, middle)) + sum * reach.scaled(share);
            }
            sum
        };
        let parts = ends.windows(2).map(part).reduce(Self::with);
        parts
            .unwrap_or(Self::ALL)
            .continuous_if(self.continuous && order <= SMOOTH)
    }

    /// Whether its greatest number is at most this `factor` of its least, in size, and of the same sign.
    pub(super) fn keeps_its_size(self, factor: f64) -> bool {
        let size = self.size();
        size.low > 0.0 && size.high <= factor * size.low
    }

    /// Logarithm of the factor by which its greatest number is more than its least, in size.
    pub(super) fn change(self) -> f64 {
        let size = self.size();
        (size.high / size.low).ln()
    }

    /// Whether a function of it is one that a few places tell. Sizes and signs are, as what they do happens where their argument vanishes,
    /// and sines of no more than `wave` radians.
    pub(super) fn is_calm_in(self, function: Function, wave: f64) -> bool {
        match function {
            Function::Exp => self.width() <= CALM || self.high < -SATURATED,
            Function::Sinh | Function::Cosh => self.width() <= CALM,
            Function::Tanh => self.width() <= CALM || self.size().low > SATURATED,
            Function::Atan => self.width() <= CALM + self.size().low,
            // Beside a pole it is the inverse of the way to it, which a few places tell as far as that keeps its size.
            Function::Tan => {
                let values = self.call(function);
                values.width() <= CALM + values.size().low
            }
            Function::Profile(profile) => {
                let inner = profile.pieces().iter().skip(1).map(|piece| piece.0);
                let inner = inner.filter(|from| self.low < *from && *from < self.high);
                inner.count() < PIECES
            }
            Function::Sin | Function::Cos => self.width() <= wave,
            Function::Asin | Function::Acos | Function::Cbrt => true,
            Function::Root | Function::Abs | Function::Sign => true,
            // Their arguments have to keep their size.
            Function::Ln | Function::InverseRoot => true,
        }
    }

    pub(crate) fn atan2(self, x: Self) -> Self {
        let is_one_place = self.is_one_number() && x.is_one_number();
        if x.low <= 0.0 && self.contains(0.0) && !is_one_place {
            return Self::between(-PI, PI).continuous_if(false);
        }
        self.corners(x, f64::atan2)
    }

    pub(crate) fn power(self, exponent: Self) -> Self {
        let whole = exponent.is_one_number() && exponent.low.fract() == 0.0;
        match exponent.low {
            n if whole && n < 0.0 => return Self::of(1.0).over(self.power(-exponent)),
            n if whole && n % 2.0 == 0.0 => return self.size().monotone(|x| x.powf(n)),
            n if whole => return self.monotone(|x| x.powf(n)),
            _ if self.low < 0.0 => return Self::ALL,
            _ => {}
        }
        self.corners(exponent, f64::powf)
            .continuous_if(self.low > 0.0 || exponent.low > 0.0)
    }

    /// Of a function of two numbers whose extremes are at corners.
    fn corners(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let [a, b] = [self.low, self.high].map(|own| {
            let ends = [other.low, other.high].map(|other| f(own, other));
            Self::between(ends[0], ends[1])
        });
        a.with(b).continuous_if(self.continuous && other.continuous)
    }
}

impl Add for Range {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let sum = Self::between(self.low + other.low, self.high + other.high);
        sum.continuous_if(self.continuous && other.continuous)
    }
}

impl Sub for Range {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Range {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            low: -self.high,
            high: -self.low,
            ..self
        }
    }
}

impl Mul for Range {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        if self.is_one_number() && other.is_one_number() {
            return self
                .monotone(|value| value * other.low)
                .continuous_if(other.continuous);
        }
        // Nothing of what has no bound is nothing.
        let product = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
        self.corners(other, product)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::tape::Spline;

    #[test]
    fn signs_of_products_are_all_looked_at() {
        let range = Range::between;
        assert_eq!(range(-2.0, 3.0) * range(-5.0, 4.0), range(-15.0, 12.0));
        assert_eq!(range(-2.0, 4.0).over(range(-4.0, -2.0)), range(-2.0, 1.0));
        assert_eq!(range(1.0, 4.0).over(range(-4.0, 2.0)), Range::ALL);
        assert_eq!(range(-2.0, 1.0).square(), range(0.0, 4.0));
        assert_eq!(range(-3.0, -1.0).square(), range(1.0, 9.0));
    }

    /// A function given by points.
    static HAT: Spline = Spline::new(
        0,
        "hat",
        &[
            (0.0, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
            (0.0, [0.0, 1.0, -0.5, 0.25, 0.1, -0.2]),
            (1.0, [0.65, -0.1, 0.3, 0.0, 0.0, 0.0]),
        ],
    );

    /// Each function has its values in its range, and its range is little more than its values, over parts of all widths.
    #[test]
    fn functions_have_their_values_in_their_ranges_and_not_much_more() {
        use Function::*;
        let of = crate::model::tape::Profile::of;
        let others = [
            Root,
            InverseRoot,
            Abs,
            Sign,
            Profile(of(&HAT, 0)),
            Profile(of(&HAT, 1)),
            Profile(of(&HAT, 2)),
        ];
        for function in Function::NAMED.into_iter().chain(others) {
            for (k, width) in [0.01, 0.3, 1.1, 2.9, 7.0].into_iter().enumerate() {
                let low = -3.3 + 1.37 * k as f64;
                let range = Range::between(low, low + width).call(function);
                let values: Vec<f64> = (0..=1000)
                    .map(|j| function.value(low + width * f64::from(j) / 1000.0))
                    .filter(|value| !value.is_nan())
                    .collect();
                for value in &values {
                    let slack = 1e-12 * value.abs().max(1.0);
                    assert!(
                        range.low - slack <= *value && *value <= range.high + slack,
                        "{function:?} at {low} + {width}: {value} not in {range:?}"
                    );
                }
                if width < 0.5 && range.width().is_finite() && !values.is_empty() {
                    let seen = Range::hull(values.iter().copied());
                    assert!(
                        range.width() <= 2.0 * seen.width() + 1e-9,
                        "{function:?} {range:?} {seen:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn angles_of_a_box_that_crosses_the_cut_are_all_angles() {
        let range = Range::between;
        let cut = range(-1.0, 1.0).atan2(range(-2.0, -1.0));
        assert_eq!((cut.low, cut.high, cut.continuous), (-PI, PI, false));
        let quarter = range(1.0, 2.0).atan2(range(-1.0, 1.0));
        assert!(
            (quarter.low - 0.25 * PI).abs() < 1e-15 && (quarter.high - 0.75 * PI).abs() < 1e-15
        );
        assert_eq!(range(0.0, 4.0).power(range(1.5, 2.5)), range(0.0, 32.0));
        assert_eq!(range(-2.0, 1.0).power(Range::of(4.0)), range(0.0, 16.0));
        assert_eq!(range(-2.0, 1.0).power(Range::of(3.0)), range(-8.0, 1.0));
        assert_eq!(range(-2.0, -1.0).power(Range::of(-2.0)), range(0.25, 1.0));
    }
}
