//! The unit itself: exponents of the SI base units and a scale.

use crate::ratio::Ratio;
use std::ops::{Div, Mul};

/// Symbols of the base units, in the order of [`Unit::exponents`].
pub const BASES: [&str; 7] = ["m", "kg", "s", "A", "K", "mol", "cd"];

/// A unit of measurement: `scale * m^e0 kg^e1 s^e2 A^e3 K^e4 mol^e5 cd^e6`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Exponents of metre, kilogram, second, ampere, kelvin, mole, candela.
    pub exponents: [Ratio; 7],
    /// How many SI units one of this unit is: 1000 for `km`.
    pub scale: f64,
}

impl Unit {
    /// The unit of pure numbers.
    pub const ONE: Self = Self {
        exponents: [Ratio::ZERO; 7],
        scale: 1.0,
    };

    /// The SI unit with integer exponents of metre, kilogram and second.
    #[must_use]
    pub const fn mechanical(metre: i32, kilogram: i32, second: i32) -> Self {
        let mut exponents = [Ratio::ZERO; 7];
        exponents[0] = Ratio::integer(metre);
        exponents[1] = Ratio::integer(kilogram);
        exponents[2] = Ratio::integer(second);
        Self {
            exponents,
            scale: 1.0,
        }
    }

    /// The unit of this dimension with scale 1.
    #[must_use]
    pub const fn si(self) -> Self {
        Self {
            exponents: self.exponents,
            scale: 1.0,
        }
    }

    /// Whether all exponents are zero.
    #[must_use]
    pub fn is_dimensionless(self) -> bool {
        self.exponents.iter().all(|exponent| exponent.is_zero())
    }

    /// Whether both measure the same kind of quantity.
    #[must_use]
    pub fn same_dimension(self, other: Self) -> bool {
        self.exponents == other.exponents
    }

    /// A number of this unit in SI units. Where the scale is a power of ten, the decimal number with its point moved, to the last
    /// bit: 20 uH are 2e-5 H.
    ///
    /// ```
    /// let unit: hangtime_units::Unit = "uH".parse()?;
    /// assert_eq!(unit.in_si(20.0), 2e-5);
    /// # Ok::<(), hangtime_units::UnitError>(())
    /// ```
    #[must_use]
    pub fn in_si(self, value: f64) -> f64 {
        // Of some products and quotients of prefixes, with a rounding each.
        const ROUNDING: f64 = 1e-14;
        let power = self.scale.log10().round() as i32;
        if (self.scale / 10.0_f64.powi(power) - 1.0).abs() > ROUNDING {
            return value * self.scale;
        }
        let written = format!("{value:e}");
        let moved = written.split_once('e').and_then(|(digits, exponent)| {
            let exponent = exponent.parse::<i32>().ok()? + power;
            format!("{digits}e{exponent}").parse().ok()
        });
        moved.unwrap_or(value * self.scale)
    }

    /// The unit raised to a power.
    #[must_use]
    pub fn pow(self, exponent: Ratio) -> Self {
        Self {
            exponents: self.exponents.map(|own| own * exponent),
            scale: if exponent.denominator() == 1 {
                self.scale.powi(exponent.numerator())
            } else {
                self.scale.powf(exponent.to_f64())
            },
        }
    }
}

impl Mul for Unit {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let mut exponents = self.exponents;
        for (own, its) in exponents.iter_mut().zip(other.exponents) {
            *own = *own + its;
        }
        Self {
            exponents,
            scale: self.scale * other.scale,
        }
    }
}

impl Div for Unit {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let mut exponents = self.exponents;
        for (own, its) in exponents.iter_mut().zip(other.exponents) {
            *own = *own - its;
        }
        Self {
            exponents,
            scale: self.scale / other.scale,
        }
    }
}
