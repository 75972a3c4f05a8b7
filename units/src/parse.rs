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

impl Parser<'_> {
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
            let numerator = self.integer()?;
            let denominator = if self.eat('/') { self.integer()? } else { 1 };
            if !self.eat(')') {
                return Err(self.malformed("the exponent lacks its `)`"));
            }
            Ratio::new(numerator, denominator)
                .ok_or_else(|| self.malformed("the exponent divides by zero"))?
        } else {
            Ratio::integer(self.integer()?)
        };
        Ok(unit.pow(exponent))
    }

    fn integer(&mut self) -> Result<i32, UnitError> {
        let negative = self.eat('-');
        if !negative {
            self.eat('+');
        }
        let end = self
            .rest
            .find(|c: char| !c.is_ascii_digit())
            .unwrap_or(self.rest.len());
        let digits = &self.rest[..end];
        if digits.is_empty() || digits.len() > 2 {
            return Err(self.malformed("after `^` write a whole number of at most two digits"));
        }
        self.rest = &self.rest[end..];
        let value = digits
            .bytes()
            .fold(0, |value, digit| 10 * value + i32::from(digit - b'0'));
        Ok(if negative { -value } else { value })
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
        assert!(text("m^").contains("whole number"));
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
