//! Unit to readable text.

use crate::catalogue::NAMED;
use crate::ratio::Ratio;
use crate::unit::{BASES, Unit};
use std::fmt;

/// Derived units that are preferred over their base units in print.
const PREFERRED: [&str; 4] = ["N", "J", "W", "Pa"];

/// Units in common use, tried before falling back on a factor.
const COMMON: [&str; 16] = [
    "deg", "km/h", "km", "cm", "mm", "g", "t", "ms", "min", "h", "kN", "kJ", "kW", "kPa", "MPa",
    "rpm",
];

impl fmt::Display for Unit {
    /// Readable and parsable: `N`, `kg m^2`, `m/s`, `1/s`, `1` for pure numbers, `km/h`; a scale
    /// without a name in front, as in `12 m`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.scale != 1.0 {
            for text in COMMON {
                if text.parse::<Self>().is_ok_and(|common| common == *self) {
                    return f.write_str(text);
                }
            }
            write!(f, "{} ", self.scale)?;
        }
        if let Some(named) = PREFERRED.iter().find_map(|symbol| {
            NAMED
                .iter()
                .find(|named| named.symbol == *symbol && named.unit.same_dimension(*self))
        }) {
            return f.write_str(named.symbol);
        }
        // Stiffness and damping read better with a newton: N/m, N s/m, N s.
        if self.exponents[1] == Ratio::ONE && self.exponents[3..].iter().all(|e| e.is_zero()) {
            let (metre, second) = (self.exponents[0], self.exponents[2]);
            let text = match (metre.numerator(), second.numerator()) {
                (0, -2) => "N/m",
                (0, -1) => "N s/m",
                (1, -1) => "N s",
                (2, -1) => "N m s",
                _ => "",
            };
            if !text.is_empty() && metre.denominator() == 1 && second.denominator() == 1 {
                return f.write_str(text);
            }
        }
        f.write_str(&in_base_units(self.exponents))
    }
}

fn in_base_units(exponents: [Ratio; 7]) -> String {
    // Kilogram first, then metre, as in `kg m^2`.
    let order = [1, 0, 2, 3, 4, 5, 6];
    let power = |index: usize, exponent: Ratio| {
        if exponent == Ratio::ONE {
            BASES[index].to_owned()
        } else {
            format!("{}^{exponent}", BASES[index])
        }
    };
    let above: Vec<String> = order
        .into_iter()
        .filter(|&i| exponents[i] > Ratio::ZERO)
        .map(|i| power(i, exponents[i]))
        .collect();
    let below: Vec<String> = order
        .into_iter()
        .filter(|&i| exponents[i].numerator() < 0)
        .map(|i| power(i, -exponents[i]))
        .collect();
    let mut text = if above.is_empty() {
        "1".to_owned()
    } else {
        above.join(" ")
    };
    match below.as_slice() {
        [] => {}
        [one] => text = format!("{text}/{one}"),
        many => text = format!("{text}/({})", many.join(" ")),
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn print_is_readable_and_parses_back() {
        for text in [
            "N", "J", "W", "Pa", "N/m", "N s/m", "N s", "kg m^2", "m/s", "m/s^2", "1/s", "1",
            "km/h", "deg", "kg/m", "1/(m s)", "m^(1/2)", "cm", "A",
        ] {
            let unit: Unit = text.parse().unwrap();
            assert_eq!(unit.to_string(), text);
        }
        assert_eq!("kg m^2/s^2".parse::<Unit>().unwrap().to_string(), "J");
        let odd = Unit {
            scale: 12.0,
            ..Unit::mechanical(1, 0, 0)
        };
        assert_eq!(odd.to_string(), "12 m");
    }
}
