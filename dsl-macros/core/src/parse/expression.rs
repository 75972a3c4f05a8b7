//! Expressions, by binding powers: `+ -` < `* /` < unary minus < `^` < components and indices.

use super::cursor::{Cursor, Said};
use super::{number, slips};
use crate::ast::{Expr, Kind, Link, Name, Operator};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported};
use crate::expand::is_product;
use crate::words;
use proc_macro2::{Delimiter, Group, TokenTree};
use std::cell::RefMut;

/// Deepest tree; deeper ones are refused so that recursion over an expression is safe.
const DEPTH: usize = 150;

const SUM: u8 = 1;
const PRODUCT: u8 = 3;
const SIGN: u8 = 5;
const POWER: u8 = 7;

/// Parses one expression and leaves the cursor behind it.
pub(super) fn expression(cursor: &mut Cursor) -> Checked<Expr> {
    whole(cursor, (false, false))
}

/// Parses one expression of a picture, which ends before any word of that.
pub(super) fn expression_in_picture(cursor: &mut Cursor) -> Checked<Expr> {
    whole(cursor, (false, true))
}

/// Parses the right side of a comparison.
pub(super) fn compared(cursor: &mut Cursor) -> Checked<Expr> {
    whole(cursor, (true, false))
}

fn whole(cursor: &mut Cursor, (compared, pictured): (bool, bool)) -> Checked<Expr> {
    let mut parser = Parser {
        said: cursor.all_said(),
        nesting: 0,
        compared,
        pictured,
    };
    cursor.open_comparison();
    let expr = parser.climb(cursor, 0)?;
    let expr = parser.decimal_comma(cursor, expr)?;
    parser.ends_there(cursor, &expr, false)?;
    Ok(expr)
}

struct Parser {
    said: Said,
    nesting: usize,
    /// Whether a comparison stands on the left.
    compared: bool,
    /// Whether the expression ends before words of a picture.
    pictured: bool,
}

impl Parser {
    fn said(&self) -> RefMut<'_, Diagnostics> {
        self.said.borrow_mut()
    }

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
                    .said()
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
            let base = base.as_base();
            return Err(self.said().syntax(
                place,
                format!(
                    "two powers in a row are easily misread; put the inner one in parentheses, as in \
                     `{base}^({exponent})`"
                ),
            ));
        }
        let whole = base.place.to(exponent.place);
        let (base, exponent) = (Box::new(base), Box::new(exponent));
        let kind = Kind::Power {
            base,
            place,
            exponent,
        };
        self.node(kind, whole)
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
        self.node(Kind::Chain(Box::new(left), vec![link]), whole)
    }

    fn node(&mut self, kind: Kind, place: Place) -> Checked<Expr> {
        let mut expr = Expr {
            kind,
            place,
            depth: 1,
            parenthesized: false,
        };
        let below = expr.children().into_iter().map(|part| part.depth).max();
        expr.depth += below.unwrap_or(0);
        // Components and indices nest without brackets.
        match expr.depth > 4 * DEPTH {
            true => Err(self.too_deep(place)),
            false => Ok(expr),
        }
    }

    fn call(&mut self, function: Name, arguments: Vec<Expr>, place: Place) -> Checked<Expr> {
        let kind = Kind::Call {
            function,
            arguments,
        };
        self.node(kind, place)
    }

    fn too_deep(&mut self, place: Place) -> Reported {
        self.said().report(
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
            let place = start.to(inner.place);
            return self.node(Kind::Negate(Box::new(inner)), place);
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
            let applied = point && is_applied(cursor);
            if point
                && !applied
                && !cursor.at_invisible_group(1)
                && matches!(cursor.peek_at(1), Some(TokenTree::Ident(_)))
            {
                cursor.advance();
                let Some(name) = cursor.eat_name() else {
                    return Ok(expr);
                };
                if !cursor.at_invisible_group(0)
                    && let Some(group) = cursor.eat_group(Delimiter::Parenthesis)
                {
                    expr = self.method(expr, name, (cursor, &group))?;
                    continue;
                }
                let (place, vector) = (expr.place.to(name.place()), Box::new(expr));
                expr = self.node(Kind::Component { vector, name }, place)?;
            } else if point
                && (applied
                    || cursor.at_invisible_group(1)
                    || matches!(cursor.peek_at(1), Some(TokenTree::Group(group))
                        if group.delimiter() == Delimiter::Parenthesis))
            {
                // `a . (b + c)`: the inner product with any vector.
                let place = cursor.place();
                cursor.advance();
                let right = self.primary(cursor)?;
                let whole = expr.place.to(right.place);
                let function = Name::at(place, "dot".to_owned());
                expr = self.call(function, vec![expr, right], whole)?;
            } else if let Some(group) = cursor.eat_group(Delimiter::Bracket) {
                let index = self.index(cursor, &group)?;
                let place = expr.place.to(Place::at(group.span_close()));
                let vector = Box::new(expr);
                expr = self.node(Kind::Index { vector, index }, place)?;
            } else {
                return Ok(expr);
            }
        }
    }

    /// A call as in Rust, which is reported and read as what it means.
    fn method(
        &mut self,
        object: Expr,
        name: Name,
        (cursor, group): (&Cursor, &Group),
    ) -> Checked<Expr> {
        let mut arguments = self.items(cursor.inside(group))?;
        let place = object.place.to(Place::at(group.span_close()));
        let function = words::is_function(&name.text) && name.text != "diff";
        let kind = match (name.text.as_str(), arguments.pop()) {
            ("powi" | "powf" | "pow", Some(exponent)) if arguments.is_empty() => Kind::Power {
                base: Box::new(object),
                place: name.place(),
                exponent: Box::new(exponent),
            },
            (text, last) if function || words::NONSMOOTH.contains(&text) => {
                arguments.extend(last);
                arguments.insert(0, object);
                Kind::Call {
                    function: name.clone(),
                    arguments,
                }
            }
            _ => {
                let message = format!(
                    "`.{}(...)` is a call of Rust; write functions as `sin(x)`, powers as `x^2`",
                    name.text
                );
                return Err(self.said().syntax(place, message));
            }
        };
        let meant = self.node(kind, place)?;
        // What has a kink is refused for that.
        if !words::NONSMOOTH.contains(&name.text.as_str()) {
            let rate = match &meant.kind {
                Kind::Call { arguments, .. } if name.text == "dot" && arguments.len() == 2 => {
                    format!(
                        ", or `{} . dot({})` with the velocity",
                        arguments[0], arguments[1]
                    )
                }
                _ => String::new(),
            };
            let message = format!(
                "`.{}(...)` is a call of Rust; write `{meant}`{rate}",
                name.text
            );
            self.said().syntax(place, message);
        }
        Ok(meant)
    }

    fn index(&mut self, cursor: &Cursor, group: &Group) -> Checked<usize> {
        let mut inner = cursor.inside(group);
        if let Some(TokenTree::Literal(literal)) = inner.advance()
            && inner.is_empty()
            && let Ok(index) = literal.to_string().parse()
        {
            return Ok(index);
        }
        Err(self.said().syntax(
            Place::at(group.span_open()),
            "an index is a whole number from 0; a unit in brackets stands after a number only",
        ))
    }

    fn primary(&mut self, cursor: &mut Cursor) -> Checked<Expr> {
        let place = cursor.place();
        if let Some(mut inner) = cursor.eat_invisible_group() {
            let mut expr = self.climb(&mut inner, 0)?;
            self.ends_there(&inner, &expr, false)?;
            if !inner.is_empty() {
                return Err(inner.unexpected("an operator"));
            }
            expr.parenthesized = true;
            return Ok(expr);
        }
        if let Some(literal) = number::literal(cursor) {
            let (kind, place) = number::number(cursor, &literal)?;
            return self.node(kind, place);
        }
        if cursor.eat_symbol("|") {
            let inner = self.climb(cursor, 0)?;
            if !cursor.eat_symbol("|") {
                self.ends_there(cursor, &inner, false)?;
                return Err(cursor.unexpected("the closing `|` of a norm"));
            }
            let whole = place.to(cursor.previous());
            return self.node(Kind::Norm(Box::new(inner)), whole);
        }
        if let Some(group) = cursor.eat_group(Delimiter::Parenthesis) {
            let mut items = self.items(cursor.inside(&group))?;
            let whole = Place {
                start: group.span_open(),
                end: group.span_close(),
            };
            return match items.len() {
                0 => Err(self
                    .said()
                    .syntax(whole, "empty parentheses; write an expression in them")),
                1 => {
                    let mut inner = items.remove(0);
                    inner.place = whole;
                    inner.parenthesized = true;
                    Ok(inner)
                }
                _ => self.node(Kind::Vector(items), whole),
            };
        }
        if cursor.ident().is_some_and(|ident| {
            let text = ident.to_string();
            !words::is_keyword(&text) || is_value(cursor)
        }) && let Some(name) = cursor.eat_name()
        {
            return self.name(cursor, name);
        }
        Err(cursor.unexpected("an expression"))
    }

    fn name(&mut self, cursor: &mut Cursor, name: Name) -> Checked<Expr> {
        if name.text == words::IF && !self.said().is_declared(&name.text) {
            return self.choice(cursor, name);
        }
        let switches = name.text == "match";
        if switches && !self.said().is_declared(&name.text) {
            return Err(self.said().report(
                "E12",
                name.place(),
                format!(
                    "`{}` is no expression; write `if c >= 0 {{ a }} else {{ b }}` in `forces` or `rates`, and declare a `surface` \
                     where the motion strikes",
                    name.text
                ),
            ));
        }
        let Some(group) = cursor.eat_group(Delimiter::Parenthesis) else {
            if cursor.at_symbol("::") {
                return self.path(cursor, &name);
            }
            if words::is_function(&name.text)
                && name.text != "diff"
                && !self.said().is_declared(&name.text)
                && !cursor.at_invisible_group(0)
                && slips::is_argument(cursor)
            {
                return self.call_without_parentheses(cursor, name);
            }
            let place = name.place();
            return self.node(Kind::Name(name), place);
        };
        let whole = name.place().to(Place::at(group.span_close()));
        if name.text == "diff" {
            return self.derivative(cursor, &name, &group);
        }
        let arguments = self.items(cursor.inside(&group))?;
        self.call(name, arguments, whole)
    }

    /// `if left >= right { value } else { other }`, with the cursor behind `if`: a call with the larger side, the smaller one and
    /// both values.
    fn choice(&mut self, cursor: &mut Cursor, name: Name) -> Checked<Expr> {
        const SHAPE: &str = "`if c >= 0 { a } else { b }`";
        let left = self.climb(cursor, 0)?;
        let place = cursor.place();
        let greater = cursor.at_symbol(">");
        if !greater && !cursor.at_symbol("<") {
            let message = format!(
                "`if` compares two numbers by `>=` or `<=`, found {}; write {SHAPE}",
                cursor.describe()
            );
            return Err(self.said().syntax(place, message));
        }
        cursor.advance();
        cursor.eat_symbol("=");
        let right = self.climb(cursor, 0)?;
        let yes = self.braced(cursor, SHAPE)?;
        if !cursor.eat_word("else") {
            let message =
                format!("`else` is missing, as what acts has a value on both sides; write {SHAPE}");
            return Err(self.said().syntax(cursor.place(), message));
        }
        let no = match cursor.at_word(words::IF) {
            // Guarded against chains without end.
            true => self.climb(cursor, u8::MAX)?,
            false => self.braced(cursor, SHAPE)?,
        };
        let (large, small) = if greater {
            (left, right)
        } else {
            (right, left)
        };
        let whole = name.place().to(cursor.previous());
        self.call(name, vec![large, small, yes, no], whole)
    }

    /// An expression in braces.
    fn braced(&mut self, cursor: &mut Cursor, shape: &str) -> Checked<Expr> {
        let Some(group) = cursor.eat_group(Delimiter::Brace) else {
            let message = format!(
                "expected a value in braces, found {}; write {shape}",
                cursor.describe()
            );
            return Err(self.said().syntax(cursor.place(), message));
        };
        let mut inner = cursor.inside(&group);
        let value = self.climb(&mut inner, 0)?;
        if inner.is_empty() {
            return Ok(value);
        }
        Err(inner.unexpected("an operator or `}`"))
    }

    /// `cos theta` or `cos 2*theta`, which is reported and read as a call.
    fn call_without_parentheses(&mut self, cursor: &mut Cursor, name: Name) -> Checked<Expr> {
        let mut argument = self.prefix(cursor)?;
        if matches!(argument.kind, Kind::Number { .. }) && cursor.at_symbol("*") {
            let place = cursor.place();
            cursor.advance();
            let link = Link {
                operator: Operator::Multiply,
                place,
                operand: self.prefix(cursor)?,
            };
            argument = self.linked(argument, link)?;
        }
        let message = format!(
            "`{0}` is a function; its argument stands in parentheses, as in `{0}({argument})`",
            name.text
        );
        self.said().syntax(name.place(), message);
        let place = name.place().to(argument.place);
        self.call(name, vec![argument], place)
    }

    /// `std::f64::consts::PI`, which is reported and read as its last name.
    fn path(&mut self, cursor: &mut Cursor, first: &Name) -> Checked<Expr> {
        let mut last = first.clone();
        while cursor.eat_symbol("::")
            && let Some(name) = cursor.eat_name()
        {
            last = name;
        }
        let place = first.place().to(last.place());
        if last.text.eq_ignore_ascii_case("pi") {
            last.text = "pi".to_owned();
        }
        let text = &last.text;
        let message = format!("a path of Rust has no meaning here; write `{text}`");
        self.said().syntax(place, message);
        self.node(Kind::Name(last), place)
    }

    /// `diff(f)(y)`, `diff(diff(f))(y)`.
    fn derivative(&mut self, cursor: &mut Cursor, diff: &Name, group: &Group) -> Checked<Expr> {
        let mut order = 1;
        let mut inner = cursor.inside(group);
        while inner.at_word("diff") && order < 8 {
            inner.advance();
            let Some(group) = inner.eat_group(Delimiter::Parenthesis) else {
                return Err(inner.unexpected("`(` after `diff`"));
            };
            if !inner.is_empty() {
                return Err(inner.unexpected("`)` after `diff(...)`"));
            }
            inner = cursor.inside(&group);
            order += 1;
        }
        let Some(function) = inner.eat_name().filter(|_| inner.is_empty()) else {
            return Err(self.said().syntax(
                diff.place(),
                "`diff` takes the name of a declared function of one argument: `diff(f)(y)` is f'(y); \
                 the time derivative is `dot(...)`",
            ));
        };
        let Some(argument) = cursor.eat_group(Delimiter::Parenthesis) else {
            return Err(
                cursor.unexpected(&format!("the argument, as in `diff({})(y)`", function.text))
            );
        };
        let place = diff.place().to(Place::at(argument.span_close()));
        let mut items = self.items(cursor.inside(&argument))?;
        if items.len() != 1 {
            return Err(self.said().report(
                "E02",
                place,
                format!(
                    "`diff({})` takes one argument, found {}",
                    function.text,
                    items.len()
                ),
            ));
        }
        let kind = Kind::Derivative {
            function,
            order,
            argument: Box::new(items.remove(0)),
        };
        self.node(kind, place)
    }

    /// Whether nothing follows that reads as a further factor; `list` tells whether a comma may be meant.
    fn ends_there(&mut self, cursor: &Cursor, left: &Expr, list: bool) -> Checked<()> {
        let where_it_may_end = (self.compared, self.pictured);
        slips::no_factor(cursor, (left, list), where_it_may_end)
    }

    /// Expressions between commas.
    fn items(&mut self, mut inner: Cursor) -> Checked<Vec<Expr>> {
        let mut items = Vec::new();
        while !inner.is_empty() {
            let item = self.climb(&mut inner, 0)?;
            self.ends_there(&inner, &item, true)?;
            items.push(item);
            if !inner.is_empty() && !inner.eat_symbol(",") {
                return Err(inner.unexpected("an operator, `,` or `)`"));
            }
        }
        Ok(items)
    }

    /// A number with a decimal comma, which no list holds where a whole expression has ended.
    fn decimal_comma(&mut self, cursor: &mut Cursor, left: Expr) -> Checked<Expr> {
        let Some(number) = cursor.decimal_comma() else {
            return Ok(left);
        };
        let begin = cursor.previous();
        cursor.advance();
        cursor.advance();
        let place = begin.to(cursor.previous());
        let message = format!("a number has a decimal point, not a comma; write `{number}`");
        let reported = self.said().syntax(place, message);
        // Behind a factor it is not told what the rest of the expression is.
        let Kind::Number { .. } = left.kind else {
            return Err(reported);
        };
        let value = number.parse().map_err(|_| reported)?;
        let (kind, place) = number::with_unit(cursor, (value, number), begin)?;
        self.node(kind, place)
    }
}

/// Whether behind a point that stands apart a function is called, as in `v . f(x)`.
fn is_applied(cursor: &Cursor) -> bool {
    let [point, name, arguments] = [0, 1, 2].map(|k| cursor.peek_at(k));
    let named = matches!(name, Some(TokenTree::Ident(_)));
    let called = matches!(arguments, Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis);
    named
        && called
        && point
            .zip(name)
            .is_some_and(|(point, name)| is_product(point, name))
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

/// Whether `start(...)` or `at(...)` is there, the value of a quantity at the start of the motion or at a time, and no statement.
fn is_value(cursor: &Cursor) -> bool {
    (cursor.at_word(words::START) || cursor.at_word(words::AT))
        && matches!(cursor.peek_at(1), Some(TokenTree::Group(group))
            if group.delimiter() == Delimiter::Parenthesis)
}
