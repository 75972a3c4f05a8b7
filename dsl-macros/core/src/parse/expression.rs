//! Expressions, by binding powers: `+ -` < `* /` < unary minus < `^` < components and indices.

use super::cursor::{Cursor, unexpected};
use super::unit;
use crate::ast::{Expr, Kind, Link, Name, Operator};
use crate::diagnostics::{Checked, Diagnostics, Place, closest};
use crate::words;
use proc_macro2::{Delimiter, Group, Ident, Literal, Spacing, TokenTree};

/// Deepest tree; deeper ones are refused so that recursion over an expression is safe.
const DEPTH: usize = 150;

const SUM: u8 = 1;
const PRODUCT: u8 = 3;
const SIGN: u8 = 5;
const POWER: u8 = 7;

/// Parses one expression and leaves the cursor behind it.
pub(super) fn expression(cursor: &mut Cursor, diagnostics: &mut Diagnostics) -> Checked<Expr> {
    let mut parser = Parser {
        diagnostics,
        nesting: 0,
    };
    cursor.open_comparison();
    let expr = parser.climb(cursor, 0)?;
    parser.juxtaposed(cursor, &expr)?;
    Ok(expr)
}

struct Parser<'a> {
    diagnostics: &'a mut Diagnostics,
    nesting: usize,
}

impl Parser<'_> {
    fn climb(&mut self, cursor: &mut Cursor, least: u8) -> Checked<Expr> {
        self.nesting += 1;
        if self.nesting > DEPTH {
            self.nesting -= 1;
            return Err(self.too_deep(cursor.place()));
        }
        let expr = self.climb_unguarded(cursor, least);
        self.nesting -= 1;
        expr
    }

    fn climb_unguarded(&mut self, cursor: &mut Cursor, least: u8) -> Checked<Expr> {
        let mut left = self.prefix(cursor)?;
        loop {
            let (operator, own) = match cursor.peek() {
                // What begins with a sign in a group of its own is no second operand.
                _ if cursor.at_invisible_group(0) => return Ok(left),
                Some(TokenTree::Punct(punct)) => match punct.as_char() {
                    '+' => (Some(Operator::Add), SUM),
                    '-' => (Some(Operator::Subtract), SUM),
                    '*' => (Some(Operator::Multiply), PRODUCT),
                    '/' => (Some(Operator::Divide), PRODUCT),
                    '^' => (None, POWER),
                    _ => return Ok(left),
                },
                _ => return Ok(left),
            };
            if own < least {
                return Ok(left);
            }
            let place = cursor.place();
            cursor.advance();
            let Some(operator) = operator else {
                left = self.power(cursor, place, left)?;
                continue;
            };
            if operator == Operator::Multiply && cursor.at_symbol("*") {
                return Err(self
                    .diagnostics
                    .syntax(place, "`**` is no operator; write powers as `x^2`"));
            }
            let operand = self.climb(cursor, own + 1)?;
            let link = Link {
                operator,
                place,
                operand,
            };
            left = self.linked(left, link)?;
        }
    }

    fn power(&mut self, cursor: &mut Cursor, place: Place, base: Expr) -> Checked<Expr> {
        // The exponent may carry a sign: x^-2.
        let exponent = self.climb(cursor, SIGN)?;
        if stacked_power(&exponent) {
            return Err(self.diagnostics.syntax(
                place,
                format!(
                    "two powers in a row are easily misread; put the inner one in parentheses, as in \
                     `{base}^({exponent})`"
                ),
            ));
        }
        let whole = base.place.to(exponent.place);
        let depth = base.depth.max(exponent.depth);
        self.node(
            Kind::Power {
                base: Box::new(base),
                place,
                exponent: Box::new(exponent),
            },
            whole,
            depth,
        )
    }

    /// One more operand behind an expression: a sum of terms or a product of factors becomes longer, not
    /// deeper.
    fn linked(&mut self, mut left: Expr, link: Link) -> Checked<Expr> {
        let whole = left.place.to(link.operand.place);
        if let Kind::Chain(_, rest) = &mut left.kind
            && !left.parenthesized
            && rest[0].operator.is_additive() == link.operator.is_additive()
        {
            left.place = whole;
            left.depth = left.depth.max(link.operand.depth + 1);
            rest.push(link);
            return Ok(left);
        }
        let depth = left.depth.max(link.operand.depth);
        self.node(Kind::Chain(Box::new(left), vec![link]), whole, depth)
    }

    fn node(&mut self, kind: Kind, place: Place, depth_below: usize) -> Checked<Expr> {
        // Components and indices nest without brackets.
        if depth_below >= 4 * DEPTH {
            return Err(self.too_deep(place));
        }
        Ok(Expr {
            kind,
            place,
            depth: depth_below + 1,
            parenthesized: false,
        })
    }

    fn too_deep(&mut self, place: Place) -> crate::diagnostics::Reported {
        self.diagnostics.report(
            "E22",
            place,
            "the expression is nested too deeply; split it with `let`",
        )
    }

    fn prefix(&mut self, cursor: &mut Cursor) -> Checked<Expr> {
        let start = cursor.place();
        let group = cursor.at_invisible_group(0);
        if !group && cursor.eat_symbol("+") {
            return self.climb(cursor, SIGN);
        }
        if !group && cursor.eat_symbol("-") {
            let inner = self.climb(cursor, SIGN)?;
            let (place, depth) = (start.to(inner.place), inner.depth);
            return self.node(Kind::Negate(Box::new(inner)), place, depth);
        }
        let primary = self.primary(cursor)?;
        self.postfix(cursor, primary)
    }

    fn postfix(&mut self, cursor: &mut Cursor, mut expr: Expr) -> Checked<Expr> {
        loop {
            let point = cursor.at_symbol(".");
            if !point && cursor.at_invisible_group(0) {
                return Ok(expr);
            }
            if point
                && !cursor.at_invisible_group(1)
                && matches!(cursor.peek_at(1), Some(TokenTree::Ident(_)))
            {
                cursor.advance();
                let Some(name) = cursor.eat_name() else {
                    return Ok(expr);
                };
                if matches!(cursor.peek(), Some(TokenTree::Group(group))
                    if group.delimiter() == Delimiter::Parenthesis)
                    && !cursor.at_invisible_group(0)
                {
                    return Err(self.diagnostics.syntax(
                        name.place(),
                        format!(
                            "`.{}(...)` is a call of Rust; write functions as `sin(x)`, powers as `x^2`",
                            name.text
                        ),
                    ));
                }
                let (place, depth) = (expr.place.to(name.place()), expr.depth);
                expr = self.node(
                    Kind::Component {
                        vector: Box::new(expr),
                        name,
                    },
                    place,
                    depth,
                )?;
            } else if point
                && (cursor.at_invisible_group(1)
                    || matches!(cursor.peek_at(1), Some(TokenTree::Group(group))
                        if group.delimiter() == Delimiter::Parenthesis))
            {
                // `a . (b + c)`: the inner product with any vector.
                let place = cursor.place();
                cursor.advance();
                let right = self.primary(cursor)?;
                let (whole, depth) = (expr.place.to(right.place), expr.depth.max(right.depth));
                let function = Name {
                    text: "dot".to_owned(),
                    ident: Ident::new("dot", place.start),
                };
                let arguments = vec![expr, right];
                expr = self.node(
                    Kind::Call {
                        function,
                        arguments,
                    },
                    whole,
                    depth,
                )?;
            } else if let Some(group) = cursor.eat_group(Delimiter::Bracket) {
                let index = self.index(&group)?;
                let (place, depth) = (expr.place.to(Place::at(group.span_close())), expr.depth);
                expr = self.node(
                    Kind::Index {
                        vector: Box::new(expr),
                        index,
                    },
                    place,
                    depth,
                )?;
            } else {
                return Ok(expr);
            }
        }
    }

    fn index(&mut self, group: &Group) -> Checked<usize> {
        let mut inner = Cursor::inside(group);
        if let Some(TokenTree::Literal(literal)) = inner.advance()
            && inner.is_empty()
            && let Ok(index) = literal.to_string().parse()
        {
            return Ok(index);
        }
        Err(self.diagnostics.syntax(
            Place::at(group.span_open()),
            "an index is a whole number from 0; a unit in brackets stands after a number only",
        ))
    }

    fn primary(&mut self, cursor: &mut Cursor) -> Checked<Expr> {
        let place = cursor.place();
        if let Some(mut inner) = cursor.eat_invisible_group() {
            let mut expr = self.climb(&mut inner, 0)?;
            self.juxtaposed(&inner, &expr)?;
            if !inner.is_empty() {
                return Err(unexpected(&inner, self.diagnostics, "an operator"));
            }
            expr.parenthesized = true;
            return Ok(expr);
        }
        if let Some(TokenTree::Literal(literal)) = cursor.peek() {
            let literal = literal.clone();
            cursor.advance();
            return self.number(cursor, &literal);
        }
        if cursor.eat_symbol("|") {
            let inner = self.climb(cursor, 0)?;
            if !cursor.eat_symbol("|") {
                self.juxtaposed(cursor, &inner)?;
                return Err(unexpected(
                    cursor,
                    self.diagnostics,
                    "the closing `|` of a norm",
                ));
            }
            let (whole, depth) = (place.to(cursor.previous()), inner.depth);
            return self.node(Kind::Norm(Box::new(inner)), whole, depth);
        }
        if let Some(group) = cursor.eat_group(Delimiter::Parenthesis) {
            let mut items = self.items(&group)?;
            let whole = Place {
                start: group.span_open(),
                end: group.span_close(),
            };
            let depth = items.iter().map(|item| item.depth).max().unwrap_or(0);
            return match items.len() {
                0 => Err(self
                    .diagnostics
                    .syntax(whole, "empty parentheses; write an expression in them")),
                1 => {
                    let mut inner = items.remove(0);
                    inner.place = whole;
                    inner.parenthesized = true;
                    Ok(inner)
                }
                _ => self.node(Kind::Vector(items), whole, depth),
            };
        }
        if cursor.ident().is_some_and(|ident| {
            let text = ident.to_string();
            !words::is_keyword(&text)
        }) && let Some(name) = cursor.eat_name()
        {
            return self.name(cursor, name);
        }
        Err(unexpected(cursor, self.diagnostics, "an expression"))
    }

    fn name(&mut self, cursor: &mut Cursor, name: Name) -> Checked<Expr> {
        if name.text == "if" || name.text == "match" {
            return Err(self.diagnostics.report(
                "E12",
                name.place(),
                format!(
                    "`{}` switches inside smooth dynamics; declare a `surface` where the motion switches",
                    name.text
                ),
            ));
        }
        let Some(group) = cursor.eat_group(Delimiter::Parenthesis) else {
            let place = name.place();
            return self.node(Kind::Name(name), place, 0);
        };
        let whole = name.place().to(Place::at(group.span_close()));
        if name.text == "diff" {
            return self.derivative(cursor, &name, &group);
        }
        let arguments = self.items(&group)?;
        let depth = arguments.iter().map(|item| item.depth).max().unwrap_or(0);
        self.node(
            Kind::Call {
                function: name,
                arguments,
            },
            whole,
            depth,
        )
    }

    /// `diff(f)(y)`, `diff(diff(f))(y)`.
    fn derivative(&mut self, cursor: &mut Cursor, diff: &Name, group: &Group) -> Checked<Expr> {
        let mut order = 1;
        let mut inner = Cursor::inside(group);
        while inner.at_word("diff") && order < 8 {
            inner.advance();
            let Some(group) = inner.eat_group(Delimiter::Parenthesis) else {
                return Err(unexpected(&inner, self.diagnostics, "`(` after `diff`"));
            };
            if !inner.is_empty() {
                return Err(unexpected(
                    &inner,
                    self.diagnostics,
                    "`)` after `diff(...)`",
                ));
            }
            inner = Cursor::inside(&group);
            order += 1;
        }
        let Some(function) = inner.eat_name().filter(|_| inner.is_empty()) else {
            return Err(self.diagnostics.syntax(
                diff.place(),
                "`diff` takes the name of a declared function of one argument: `diff(f)(y)` is f'(y); \
                 the time derivative is `dot(...)`",
            ));
        };
        let Some(argument) = cursor.eat_group(Delimiter::Parenthesis) else {
            return Err(unexpected(
                cursor,
                self.diagnostics,
                &format!("the argument, as in `diff({})(y)`", function.text),
            ));
        };
        let place = diff.place().to(Place::at(argument.span_close()));
        let mut items = self.items(&argument)?;
        if items.len() != 1 {
            return Err(self.diagnostics.report(
                "E02",
                place,
                format!(
                    "`diff({})` takes one argument, found {}",
                    function.text,
                    items.len()
                ),
            ));
        }
        let item = items.remove(0);
        let depth = item.depth;
        self.node(
            Kind::Derivative {
                function,
                order,
                argument: Box::new(item),
            },
            place,
            depth,
        )
    }

    /// Expressions between commas.
    fn items(&mut self, group: &Group) -> Checked<Vec<Expr>> {
        let mut inner = Cursor::inside(group);
        let mut items = Vec::new();
        while !inner.is_empty() {
            let item = self.climb(&mut inner, 0)?;
            self.juxtaposed(&inner, &item)?;
            items.push(item);
            if !inner.is_empty() && !inner.eat_symbol(",") {
                return Err(unexpected(
                    &inner,
                    self.diagnostics,
                    "an operator, `,` or `)`",
                ));
            }
        }
        Ok(items)
    }

    /// Two factors without an operator between them.
    fn juxtaposed(&mut self, cursor: &Cursor, left: &Expr) -> Checked<()> {
        let right = match cursor.peek() {
            _ if cursor.at_invisible_group(0) => "...".to_owned(),
            Some(TokenTree::Punct(punct)) if punct.as_char() == '\'' => {
                return Err(self.apostrophe(cursor.place()));
            }
            Some(TokenTree::Literal(literal)) if literal.to_string().starts_with('\'') => {
                return Err(self.apostrophe(cursor.place()));
            }
            Some(TokenTree::Ident(ident)) => {
                let text = ident.to_string();
                if words::is_keyword(&text) || text == "in" {
                    return Ok(());
                }
                // `name:` and `name =` begin another entry of a list.
                if matches!(cursor.peek_at(1), Some(TokenTree::Punct(punct))
                    if punct.as_char() == ':'
                        || punct.as_char() == '=' && punct.spacing() == Spacing::Alone)
                {
                    self.diagnostics.poison(&text);
                    return Err(self.diagnostics.syntax(
                        cursor.place(),
                        format!("a comma is missing before `{text}`"),
                    ));
                }
                match cursor.peek_at(1) {
                    // A name with a block behind it was meant to begin a statement.
                    Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
                        return Ok(());
                    }
                    Some(TokenTree::Group(group))
                        if group.delimiter() == Delimiter::Parenthesis =>
                    {
                        format!("{text}(...)")
                    }
                    _ => {
                        if let Some(statement) = closest(&text, words::STATEMENTS) {
                            return Err(self.diagnostics.syntax(
                                cursor.place(),
                                format!("unknown statement `{text}`; did you mean `{statement}`?"),
                            ));
                        }
                        text
                    }
                }
            }
            Some(TokenTree::Literal(literal)) => literal.to_string(),
            Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis => {
                "(...)".to_owned()
            }
            _ => return Ok(()),
        };
        Err(self.missing_operator(cursor.place(), left, &right))
    }

    /// The remedy where `right` stands behind an expression without an operator.
    fn missing_operator(
        &mut self,
        place: Place,
        left: &Expr,
        right: &str,
    ) -> crate::diagnostics::Reported {
        // The last term is what the missing operator would multiply.
        let last = match &left.kind {
            Kind::Chain(_, rest) if rest[0].operator.is_additive() => {
                rest.last().map_or(left, |link| &link.operand)
            }
            _ => left,
        };
        let factor = match &last.kind {
            Kind::Chain(_, rest) => rest.last().map_or(last, |link| &link.operand),
            _ => last,
        };
        if let Kind::Name(function) = &factor.kind
            && words::is_function(&function.text)
        {
            let message = format!(
                "`{0}` is a function; its argument stands in parentheses, as in `{0}({right})`",
                function.text
            );
            return self.diagnostics.syntax(function.place(), message);
        }
        if let Kind::Number {
            text, unit: None, ..
        } = &factor.kind
            && right.parse::<hangtime_units::Unit>().is_ok()
        {
            let message = format!(
                "an operator is missing before `{right}`; write a unit as `{text} [{right}]` and a product as \
                 `{text}*{right}`"
            );
            return self.diagnostics.syntax(place, message);
        }
        let left = match last.to_string() {
            long if long.chars().count() > 24 => "...".to_owned(),
            short => short,
        };
        self.diagnostics.syntax(
            place,
            format!("an operator is missing before `{right}`; write a product as `{left}*{right}`"),
        )
    }

    fn apostrophe(&mut self, place: Place) -> crate::diagnostics::Reported {
        self.diagnostics.syntax(
            place,
            "an apostrophe is no operator here, as it is a token of another kind in Rust; the velocity is `dot(y)`, \
             the derivative of a function `diff(f)(y)`",
        )
    }

    fn number(&mut self, cursor: &mut Cursor, literal: &Literal) -> Checked<Expr> {
        let place = Place::at(literal.span());
        let text = literal.to_string();
        let digits = text.replace('_', "");
        let value = match digits.parse::<f64>() {
            Ok(value) if value.is_infinite() => {
                let message = format!(
                    "the number {text} is too large for double precision, which ends at 1.8e308"
                );
                return Err(self.diagnostics.report("E21", place, message));
            }
            Ok(value) if value < f64::MIN_POSITIVE && has_digits(&digits) => {
                let message = format!(
                    "the number {text} is too small for double precision, which begins at 2.2e-308"
                );
                return Err(self.diagnostics.report("E21", place, message));
            }
            Ok(value) => value,
            Err(_) => return Err(self.bad_number(place, &digits)),
        };
        let unit = match cursor.eat_group(Delimiter::Bracket) {
            Some(group) => unit::bracketed(&group, self.diagnostics)?,
            None => None,
        };
        let end = cursor.previous();
        self.node(Kind::Number { value, text, unit }, place.to(end), 0)
    }

    fn bad_number(&mut self, place: Place, text: &str) -> crate::diagnostics::Reported {
        let end = text
            .find(|c: char| c.is_alphabetic() && !matches!(c, 'e' | 'E'))
            .unwrap_or(text.len());
        let (number, suffix) = text.split_at(end);
        let message = if !text.starts_with(|c: char| c.is_ascii_digit()) {
            format!("{text} is not a number; expressions are made of numbers and names")
        } else if matches!(
            suffix,
            "f64" | "f32" | "i32" | "u32" | "usize" | "i64" | "u64"
        ) {
            format!(
                "`{number}` carries the type `{suffix}` of Rust; numbers here have no type, write `{number}`"
            )
        } else if number.parse::<f64>().is_ok() && !suffix.is_empty() {
            format!(
                "`{text}` is not a number; write a unit as `{number} [{suffix}]` and a product as \
                 `{number}*{suffix}`"
            )
        } else {
            format!("`{text}` is not a decimal number")
        };
        self.diagnostics.syntax(place, message)
    }
}

/// Whether a decimal number is written with a digit other than 0 before its exponent.
fn has_digits(text: &str) -> bool {
    let mantissa = text.split(['e', 'E']).next().unwrap_or_default();
    mantissa.contains(|c| matches!(c, '1'..='9'))
}

/// Whether an exponent is itself a power without parentheses around it.
fn stacked_power(exponent: &Expr) -> bool {
    !exponent.parenthesized
        && match &exponent.kind {
            Kind::Negate(inner) => stacked_power(inner),
            Kind::Power { .. } => true,
            _ => false,
        }
}
