//! Numbers with units, and conversion.

use crate::error::UnitError;
use crate::unit::Unit;

/// A number with the unit that was written behind it, if any.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity<'a> {
    /// The number, in its own unit.
    pub value: f64,
    /// The unit as written.
    pub unit: Option<&'a str>,
}

impl<'a> Quantity<'a> {
    /// Splits a text such as `8.264m`, `15 km/h`, `-1e-3 rad` or `7` into number and unit. The longest
    /// beginning that is a number counts as the number.
    ///
    /// # Errors
    /// [`UnitError::NotANumber`] if there is none, [`UnitError::BrokenNumber`] if it goes on with something else; those of
    /// reading a [`Unit`] for the rest, which may stand in brackets.
    pub fn parse(text: &'a str) -> Result<Self, UnitError> {
        let text = text.trim();
        let end = number_length(text);
        let value = text[..end].parse().map_err(|_| UnitError::NotANumber {
            text: text.to_owned(),
        })?;
        let unit = text[end..].trim();
        if unit.is_empty() {
            return Ok(Self { value, unit: None });
        }
        if unit.starts_with(|c: char| c.is_ascii_digit() || ",_'/".contains(c)) {
            return Err(UnitError::BrokenNumber {
                text: text.to_owned(),
            });
        }
        // As the language writes it.
        let bracketed = unit
            .strip_prefix('[')
            .and_then(|unit| unit.strip_suffix(']'));
        let unit = bracketed.unwrap_or(unit).trim();
        unit.parse::<Unit>()?;
        Ok(Self {
            value,
            unit: Some(unit),
        })
    }

    /// The number in the unit `to`; a bare number is taken to be in that unit already.
    ///
    /// # Errors
    /// [`UnitError::Different`] if the units measure different things, or those of reading a [`Unit`].
    pub fn in_unit(&self, to: &str) -> Result<f64, UnitError> {
        match self.unit {
            None => Ok(self.value),
            Some(from) => convert(self.value, from, to),
        }
    }
}

/// Length of the number at the start of `text`: sign, digits, point, exponent.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| {
        bytes[from..]
            .iter()
            .take_while(|b| b.is_ascii_digit())
            .count()
    };
    let sign = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let mut end = sign + digits(sign);
    if bytes.get(end) == Some(&b'.') {
        end += 1 + digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits(end + 1 + sign);
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    end
}

/// Converts a number from one unit to another.
///
/// # Errors
/// [`UnitError::Different`] if the units measure different things, or those of reading a [`Unit`].
pub fn convert(value: f64, from: &str, to: &str) -> Result<f64, UnitError> {
    let (source, target) = (from.parse::<Unit>()?, to.parse::<Unit>()?);
    if !source.same_dimension(target) {
        let show = |text: &str| if text.is_empty() { "1" } else { text }.to_owned();
        return Err(UnitError::Different {
            from: show(from),
            to: show(to),
        });
    }
    Ok((source / target).in_si(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantity_splits_number_and_unit() {
        let parts = |text| {
            let quantity = Quantity::parse(text).unwrap();
            (quantity.value, quantity.unit)
        };
        assert_eq!(parts("15km/h"), (15.0, Some("km/h")));
        assert_eq!(parts("8.264m"), (8.264, Some("m")));
        assert_eq!(parts("-1e-3 rad"), (-1e-3, Some("rad")));
        assert_eq!(parts("7"), (7.0, None));
        assert_eq!(parts(".5"), (0.5, None));
        assert_eq!(parts("2 [km/h]"), (2.0, Some("km/h")));
        for broken in ["1,5", "1 000", "1_000", "1/2", "1'000 m"] {
            let error = Quantity::parse(broken).unwrap_err().to_string();
            assert!(error.contains("behind a point"), "{broken}: {error}");
        }
        assert!(Quantity::parse("fast").is_err());
        assert!(Quantity::parse("").is_err());
        assert!(Quantity::parse("3 furlong").is_err());
        assert!(Quantity::parse("\u{b5}").is_err());
    }

    #[test]
    fn convert_scales_and_refuses_other_dimensions() {
        assert_eq!(convert(18.0, "km/h", "m/s"), Ok(5.0));
        assert_eq!(convert(0.1, "m", "m"), Ok(0.1));
        assert!((convert(180.0, "deg", "").unwrap() - std::f64::consts::PI).abs() < 1e-15);
        let error = convert(1.0, "kg", "m/s").unwrap_err().to_string();
        assert_eq!(
            error,
            "`kg` cannot be converted to `m/s`: they measure different things"
        );
    }

    #[test]
    fn in_unit_takes_a_bare_number_as_it_is() {
        assert_eq!(Quantity::parse("3").unwrap().in_unit("kg"), Ok(3.0));
        assert_eq!(Quantity::parse("3 t").unwrap().in_unit("kg"), Ok(3000.0));
    }
}
