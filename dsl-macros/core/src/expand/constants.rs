//! Numbers that do not move, by name: what may be drawn once.

use super::names::Scope;
use super::part::Placed;
use super::tokens::{ended, group_in, inside, is_punct, items, keyword, undocumented};
use crate::words;
use proc_macro2::{Delimiter, TokenTree};
use std::collections::HashSet;

/// Names of numbers that do not move.
#[derive(Default)]
pub(super) struct Constants(HashSet<String>);

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
            self.0.insert(name);
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
                    let constant = || {
                        let own = format!("{}{text}", scope.prefix);
                        self.0.contains(&own) || self.0.contains(&text)
                    };
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
}
