//! Small exact fractions, for exponents of units.

use std::fmt;
use std::ops::{Add, Mul, Neg, Sub};

/// An exact fraction in lowest terms with a positive denominator.
///
/// Exponents of units are fractions because roots occur (`m^(1/2)`). Arithmetic saturates at the
/// ends of `i32`, far beyond any unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Ratio {
    numerator: i32,
    denominator: i32,
}

impl Ratio {
    /// Zero.
    pub const ZERO: Self = Self::integer(0);
    /// One.
    pub const ONE: Self = Self::integer(1);

    /// A whole number.
    #[must_use]
    pub const fn integer(value: i32) -> Self {
        Self {
            numerator: value,
            denominator: 1,
        }
    }

    /// `numerator / denominator` in lowest terms; `None` if the denominator is zero.
    #[must_use]
    pub fn new(numerator: i32, denominator: i32) -> Option<Self> {
        (denominator != 0).then(|| Self::reduced(numerator.into(), denominator.into()))
    }

    /// The fraction with the smallest denominator up to 12 that equals `value`, if there is one.
    #[must_use]
    pub fn from_f64(value: f64) -> Option<Self> {
        (1..=12).find_map(|denominator| {
            let numerator = value * f64::from(denominator);
            let rounded = numerator.round();
            // Values such as 1.0 / 3.0 carry one rounding; two units in the last place admit it.
            ((numerator - rounded).abs() <= 2.0 * f64::EPSILON * rounded.abs().max(1.0)
                && rounded.abs() < 1e6)
                .then(|| Self::reduced(rounded as i64, denominator.into()))
        })
    }

    /// Numerator; carries the sign.
    #[must_use]
    pub const fn numerator(self) -> i32 {
        self.numerator
    }

    /// Denominator, positive.
    #[must_use]
    pub const fn denominator(self) -> i32 {
        self.denominator
    }

    /// Whether this is zero.
    #[must_use]
    pub const fn is_zero(self) -> bool {
        self.numerator == 0
    }

    /// `1 / self`; `None` for zero.
    #[must_use]
    pub fn recip(self) -> Option<Self> {
        Self::new(self.denominator, self.numerator)
    }

    /// The nearest floating-point number.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        f64::from(self.numerator) / f64::from(self.denominator)
    }

    fn reduced(numerator: i64, denominator: i64) -> Self {
        let divisor = gcd(numerator.unsigned_abs(), denominator.unsigned_abs()).max(1) as i64;
        let sign = if denominator < 0 { -1 } else { 1 };
        let clamp = |value: i64| value.clamp(-i64::from(i32::MAX), i64::from(i32::MAX)) as i32;
        Self {
            numerator: clamp(sign * numerator / divisor),
            denominator: clamp(sign * denominator / divisor).max(1),
        }
    }
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

impl Add for Ratio {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (a, b) = (i64::from(self.numerator), i64::from(self.denominator));
        let (c, d) = (i64::from(other.numerator), i64::from(other.denominator));
        Self::reduced((a * d).saturating_add(c * b), b * d)
    }
}

impl Sub for Ratio {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Ratio {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            numerator: -self.numerator,
            denominator: self.denominator,
        }
    }
}

impl Mul for Ratio {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::reduced(
            i64::from(self.numerator) * i64::from(other.numerator),
            i64::from(self.denominator) * i64::from(other.denominator),
        )
    }
}

impl fmt::Display for Ratio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.denominator == 1 {
            write!(f, "{}", self.numerator)
        } else {
            write!(f, "({}/{})", self.numerator, self.denominator)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratio_arithmetic_stays_in_lowest_terms() {
        let (half, third) = (Ratio::new(1, 2).unwrap(), Ratio::new(2, 6).unwrap());
        assert_eq!(half + third, Ratio::new(5, 6).unwrap());
        assert_eq!(half - half, Ratio::ZERO);
        assert_eq!(half * third, Ratio::new(-1, -6).unwrap());
        assert_eq!(Ratio::new(1, 0), None);
        assert_eq!(Ratio::ZERO.recip(), None);
    }

    #[test]
    fn from_f64_finds_thirds_and_refuses_irrationals() {
        assert_eq!(Ratio::from_f64(1.0 / 3.0), Ratio::new(1, 3));
        assert_eq!(Ratio::from_f64(-1.5), Ratio::new(-3, 2));
        assert_eq!(Ratio::from_f64(std::f64::consts::SQRT_2), None);
        assert_eq!(Ratio::from_f64(f64::NAN), None);
    }
}
