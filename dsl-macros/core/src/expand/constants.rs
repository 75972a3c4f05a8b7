//! Numbers that do not move, by name: what may be drawn once, lengths that are no lengths, and corners that make no polygon.

use super::names::Scope;
use super::part::Placed;
use super::tokens::{ended, group_in, inside, is_punct, items, keyword, opened, undocumented};
use crate::words;
use hangtime_units::Unit;
use proc_macro2::{Delimiter, TokenTree};
use std::collections::HashMap;

/// Names of numbers that do not move, and what they are without being set otherwise, in SI units, as far as that is computed here.
#[derive(Default)]
pub(super) struct Constants(HashMap<String, Option<f64>>);

impl Constants {
    /// Names of numbers that are declared here and do not move.
    pub(super) fn note(&mut self, statement: &[TokenTree], scope: &Scope) {
        let statement = undocumented(statement);
        let inner = statement
            .get(1)
            .and_then(|block| group_in(Some(block), Delimiter::Brace));
        let entries = match (keyword(statement).as_str(), inner) {
            ("parameters", Some(block)) => inside(block),
            ("let", _) => statement[1..].to_vec(),
            _ => return,
        };
        for entry in items(&entries).map(undocumented) {
            let sign = entry.iter().rposition(|token| is_punct(Some(token), '='));
            let value = sign.map_or(&entry[..0], |sign| ended(&entry[sign + 1..]));
            let (Some(TokenTree::Ident(name)), true) = (entry.first(), self.all(value, scope))
            else {
                continue;
            };
            let name = format!("{}{}", scope.prefix, super::decoded(name.to_string()));
            let number = self.value(value, scope);
            // A number without a unit is in the one that is declared.
            let number = match (entry, value) {
                ([_, colon, unit, ..], [.., TokenTree::Literal(_)])
                    if is_punct(Some(colon), ':') =>
                {
                    number.and_then(|number| in_si(std::slice::from_ref(unit), number))
                }
                _ => number,
            };
            self.0.insert(name, number);
        }
    }

    /// Whether tokens hold nothing but numbers and names of numbers that do not move.
    pub(super) fn all(&self, tokens: &[TokenTree], scope: &Scope) -> bool {
        let mut before = None;
        tokens.iter().all(|token| {
            let is_unit = matches!(before.replace(token), Some(TokenTree::Literal(_)));
            match token {
                TokenTree::Ident(name) => {
                    let text = super::decoded(name.to_string());
                    let alias = scope.aliases.get(&text);
                    let constant = || self.find(&text, scope).is_some();
                    let of_alias = |(value, outer): &Placed| self.all(value, outer);
                    alias.map_or_else(constant, of_alias)
                        || words::is_function(&text)
                        || text == "pi"
                }
                TokenTree::Group(group) => {
                    is_unit && group.delimiter() == Delimiter::Bracket
                        || self.all(&inside(group), scope)
                }
                _ => true,
            }
        })
    }

    fn find(&self, text: &str, scope: &Scope) -> Option<Option<f64>> {
        let own = self.0.get(&format!("{}{text}", scope.prefix));
        own.or_else(|| self.0.get(text)).copied()
    }

    /// The number that tokens are, in SI units; none where they are more than sums, products, powers and roots of numbers.
    pub(super) fn value(&self, tokens: &[TokenTree], scope: &Scope) -> Option<f64> {
        let mut rest = tokens;
        let value = self.climb(&mut rest, 0, scope)?;
        rest.is_empty().then_some(value)
    }

    /// The operand at the begin, with what binds at least so much.
    fn climb(&self, rest: &mut &[TokenTree], least: u8, scope: &Scope) -> Option<f64> {
        let (first, behind) = rest.split_first()?;
        *rest = behind;
        let mut left = match first {
            TokenTree::Punct(mark) if mark.as_char() == '-' => -self.climb(rest, 3, scope)?,
            TokenTree::Literal(number) => {
                let number = number.to_string().parse().ok()?;
                let unit = group_in(rest.first(), Delimiter::Bracket);
                *rest = &rest[usize::from(unit.is_some())..];
                unit.map_or(Some(number), |unit| in_si(&inside(unit), number))?
            }
            TokenTree::Group(group) => self.value(&inside(group), scope)?,
            TokenTree::Ident(name) => {
                let text = super::decoded(name.to_string());
                let argument = group_in(rest.first(), Delimiter::Parenthesis);
                let function: Option<fn(f64) -> f64> = match text.as_str() {
                    "sqrt" => Some(f64::sqrt),
                    "sin" => Some(f64::sin),
                    "cos" => Some(f64::cos),
                    "tan" => Some(f64::tan),
                    _ => None,
                };
                match (argument, function, scope.aliases.get(&text)) {
                    (Some(argument), Some(function), None) => {
                        *rest = &rest[1..];
                        function(self.value(&inside(argument), scope)?)
                    }
                    (_, _, Some((value, outer))) => self.value(value, outer)?,
                    _ if text == "pi" => std::f64::consts::PI,
                    _ => self.find(&text, scope)??,
                }
            }
            TokenTree::Punct(_) => return None,
        };
        while let Some(TokenTree::Punct(mark)) = rest.first() {
            let (own, apply): (u8, fn(f64, f64) -> f64) = match mark.as_char() {
                '+' => (1, |a, b| a + b),
                '-' => (1, |a, b| a - b),
                '*' => (2, |a, b| a * b),
                '/' => (2, |a, b| a / b),
                '^' => (4, f64::powf),
                _ => return None,
            };
            if own < least {
                break;
            }
            *rest = &rest[1..];
            left = apply(left, self.climb(rest, own + 1, scope)?);
        }
        Some(left)
    }
}

/// A number in a unit, in SI units.
fn in_si(unit: &[TokenTree], number: f64) -> Option<f64> {
    let unit = unit.iter().flat_map(opened).map(|token| token.to_string());
    let unit: Unit = unit.collect::<Vec<_>>().join(" ").parse().ok()?;
    Some(unit.in_si(number))
}
