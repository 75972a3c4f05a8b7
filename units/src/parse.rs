//! Text to unit.

use crate::catalogue;
use crate::error::UnitError;
use crate::ratio::Ratio;
use crate::unit::Unit;
use std::str::FromStr;

/// Deepest nesting of parentheses, against texts made to exhaust the stack.
const DEPTH: usize = 32;

impl FromStr for Unit {
    type Err = UnitError;

    /// Reads a unit: symbols with SI prefixes, powers `^`, products by a blank, `*` or `.`, quotients
    /// by `/`, parentheses, and `1`. The empty text is the unit of pure numbers.
    ///
    /// # Errors
    /// [`UnitError::Unknown`] for a symbol that is no unit; [`UnitError::Malformed`] for anything else,
    /// also for the ambiguous `J/kg K`.
    fn from_str(text: &str) -> Result<Self, UnitError> {
        let mut parser = Parser {
            text,
            rest: text.trim(),
        };
        if parser.rest.is_empty() {
            return Ok(Self::ONE);
        }
        let unit = parser.product(0)?;
        if parser.rest.is_empty() {
            Ok(unit)
        } else {
            Err(parser.malformed("this does not read as a unit; write e.g. `kg m/s^2`"))
        }
    }
}

struct Parser<'a> {
    text: &'a str,
    rest: &'a str,
}

impl<'a> Parser<'a> {
    fn malformed(&self, reason: &'static str) -> UnitError {
        UnitError::Malformed {
            text: self.text.trim().to_owned(),
            reason,
        }
    }

    fn eat(&mut self, token: char) -> bool {
        match self.rest.trim_start().strip_prefix(token) {
            Some(rest) => {
                self.rest = rest.trim_start();
                true
            }
            None => false,
        }
    }

    fn product(&mut self, depth: usize) -> Result<Unit, UnitError> {
        if depth > DEPTH {
            return Err(self.malformed("too many parentheses"));
        }
        let mut unit = self.power(depth)?;
        let mut divided = false;
        loop {
            self.rest = self.rest.trim_start();
            if self.eat('/') {
                unit = unit / self.power(depth)?;
                divided = true;
            } else if self.eat('*') || self.eat('.') || self.eat('\u{b7}') {
                unit = unit * self.power(depth)?;
            } else if self
                .rest
                .starts_with(|c: char| c.is_alphabetic() || c == '(')
            {
                if divided {
                    return Err(self.malformed(
                        "ambiguous after `/`; write parentheses as in `J/(kg K)` or a `*`",
                    ));
                }
                unit = unit * self.power(depth)?;
            } else {
                return Ok(unit);
            }
        }
    }

    fn power(&mut self, depth: usize) -> Result<Unit, UnitError> {
        let unit = self.symbol(depth)?;
        if !self.eat('^') {
            return Ok(unit);
        }
        let exponent = if self.eat('(') {
            let numerator = self.exponent()?;
            let denominator = match self.eat('/') {
                true => self.exponent()?,
                false => Ratio::ONE,
            };
            if !self.eat(')') {
                return Err(self.malformed("the exponent lacks its `)`"));
            }
            let inverse = denominator.recip();
            numerator * inverse.ok_or_else(|| self.malformed("the exponent divides by zero"))?
        } else {
            self.exponent()?
        };
        Ok(unit.pow(exponent))
    }

    /// A number of at most two digits, and two behind a point.
    fn exponent(&mut self) -> Result<Ratio, UnitError> {
        let negative = self.eat('-');
        if !negative {
            self.eat('+');
        }
        let wrong = "after `^` write a number of at most two digits, or a fraction in parentheses as in `m^(3/2)`";
        let whole = self.digits();
        let behind = match self.rest.strip_prefix('.') {
            Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => {
                self.rest = rest;
                self.digits()
            }
            _ => "",
        };
        let long = whole.len() > 2 || behind.len() > 2;
        if long || whole.len() + behind.len() == 0 {
            return Err(self.malformed(wrong));
        }
        let digits = whole.bytes().chain(behind.bytes());
        let value = digits.fold(0, |value, digit| 10 * value + i32::from(digit - b'0'));
        let value = if negative { -value } else { value };
        Ratio::new(value, 10_i32.pow(behind.len() as u32)).ok_or_else(|| self.malformed(wrong))
    }

    fn digits(&mut self) -> &'a str {
        let end = self.rest.find(|c: char| !c.is_ascii_digit());
        let (digits, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest;
        digits
    }

    fn symbol(&mut self, depth: usize) -> Result<Unit, UnitError> {
        self.rest = self.rest.trim_start();
        if self.eat('(') {
            let unit = self.product(depth + 1)?;
            return if self.eat(')') {
                Ok(unit)
            } else {
                Err(self.malformed("a `)` is missing"))
            };
        }
        if let Some(rest) = self.rest.strip_prefix('1')
            && !rest.starts_with(|c: char| c.is_ascii_digit() || c == '.')
        {
            self.rest = rest;
            return Ok(Unit::ONE);
        }
        let end = self
            .rest
            .find(|c: char| !c.is_alphabetic())
            .unwrap_or(self.rest.len());
        let symbol = &self.rest[..end];
        if symbol.is_empty() {
            return Err(self.malformed("a unit symbol is missing; write e.g. `kg m/s^2`"));
        }
        if ["degC", "degF", "celsius", "Celsius"].contains(&symbol) {
            return Err(self.malformed(
                "its zero is another one than that of K; write a temperature as in `293.15 [K]`, a difference as in `20 [K]`",
            ));
        }
        let unit = catalogue::lookup(symbol).ok_or_else(|| UnitError::Unknown {
            symbol: symbol.to_owned(),
            suggestion: catalogue::suggest(symbol),
        })?;
        self.rest = &self.rest[end..];
        Ok(unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(text: &str) -> Unit {
        text.parse().unwrap()
    }

    #[test]
    fn parse_products_quotients_powers_agree_with_derived_units() {
        assert_eq!(unit("kg m/s^2"), unit("N"));
        assert_eq!(unit("kg*m*s^-2"), unit("N"));
        assert_eq!(unit("N m").si(), unit("J"));
        assert_eq!(unit("1/m"), unit("m^-1"));
        assert_eq!(unit("J/(kg K)"), unit("J/kg/K"));
        assert_eq!(unit("m^(1/2)").pow(Ratio::integer(2)), unit("m"));
        assert_eq!(unit("N/m^1.5"), unit("N m^(-3/2)"));
        assert_eq!(
            unit("m^3 s^-1 Pa^-.5").pow(Ratio::integer(2)),
            unit("m^6/(s^2 Pa)")
        );
        assert_eq!(unit(""), Unit::ONE);
        assert_eq!(unit("rad"), Unit::ONE);
    }

    #[test]
    fn parse_prefixes_scale() {
        assert_eq!(unit("km").scale, 1000.0);
        assert_eq!(unit("kg").scale, 1.0);
        assert_eq!(unit("ms").scale, 1e-3);
        assert_eq!(unit("min").scale, 60.0);
        assert_eq!(unit("MPa").scale, 1e6);
        assert_eq!(unit("dag").scale, 1e1 * 1e-3);
    }

    #[test]
    fn parse_mistakes_are_named() {
        let text = |text: &str| text.parse::<Unit>().unwrap_err().to_string();
        assert_eq!(text("sec"), "unknown unit `sec`; did you mean `s`?");
        assert_eq!(
            text("furlong").split(';').next(),
            Some("unknown unit `furlong`")
        );
        assert!(text("J/kg K").contains("ambiguous after `/`"));
        assert!(text("m^").contains("at most two digits"));
        assert!(text("m^(1/0)").contains("divides by zero"));
        assert!(text("(m").contains("`)` is missing"));
        assert!(text("2 m").contains("a unit symbol is missing"));
        assert!(text(&"(".repeat(100_000)).contains("too many parentheses"));
        // Messages are one line, however long and broken the text is.
        for wrong in ["(".repeat(100_000), "m\n2 ".repeat(100)] {
            assert!(text(&wrong).len() < 200 && !text(&wrong).contains('\n'));
        }
    }
}
