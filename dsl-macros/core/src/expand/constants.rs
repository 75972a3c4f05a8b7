//! Numbers that do not move, by name: what may be drawn once, and lengths that are no lengths.

use super::names::Scope;
use super::part::Placed;
use super::tokens::{ended, group_in, inside, is_punct, items, keyword, place_of, undocumented};
use crate::diagnostics::{Checked, Diagnostics, Place};
use crate::words;
use proc_macro2::{Delimiter, Span, TokenTree};
use std::collections::HashMap;

/// Names of numbers that do not move, and whether they are negative.
#[derive(Default)]
pub(super) struct Constants(HashMap<String, bool>);

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
            let sign = entry.iter().position(|token| is_punct(Some(token), '='));
            let value = sign.map_or(&entry[..0], |sign| ended(&entry[sign + 1..]));
            let (Some(TokenTree::Ident(name)), true) = (entry.first(), self.all(value, scope))
            else {
                continue;
            };
            let name = format!("{}{}", scope.prefix, super::decoded(name.to_string()));
            self.0.insert(name, is_punct(value.first(), '-'));
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

    fn find(&self, text: &str, scope: &Scope) -> Option<bool> {
        let own = self.0.get(&format!("{}{text}", scope.prefix));
        own.or_else(|| self.0.get(text)).copied()
    }

    /// E10: a length that is a number is positive.
    pub(super) fn is_length(
        &self,
        value: &[TokenTree],
        scope: &Scope,
        diagnostics: &mut Diagnostics,
    ) -> Checked<()> {
        let wrong = match value {
            [TokenTree::Ident(name)] => self.find(&name.to_string(), scope) == Some(true),
            [TokenTree::Literal(first), ..] => first.to_string().parse::<f64>() == Ok(0.0),
            _ => is_punct(value.first(), '-'),
        };
        if !wrong {
            return Ok(());
        }
        let message = "the size of a shape is positive";
        let place = place_of(value, Place::at(Span::call_site()));
        Err(diagnostics.report("E10", place, message))
    }
}
