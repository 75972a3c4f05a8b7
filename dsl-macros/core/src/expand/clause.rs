//! What stands behind the name of a body, a shape or a joint: clauses that begin with a word, and names with a value.

use super::names::indices;
use super::tokens::{ended, grouped, is_punct, items, keyword, place_of, undocumented};
use crate::diagnostics::{Checked, Diagnostics, Place, closest, list};
use crate::words;
use proc_macro2::{Delimiter, Ident, TokenTree};

/// `mass m`, `tip = (l, 0)` or `fixed`.
#[derive(Clone, Copy)]
pub(super) struct Clause<'t>(&'t [TokenTree]);

impl<'t> Clause<'t> {
    pub(super) fn first(&self) -> &'t TokenTree {
        &self.0[0]
    }

    /// The word or the name at the begin.
    pub(super) fn word(&self) -> String {
        keyword(self.0)
    }

    pub(super) fn is_named(&self) -> bool {
        matches!(self.0, [TokenTree::Ident(_), sign, _, ..] if is_punct(Some(sign), '='))
    }

    pub(super) fn whole(&self) -> &'t [TokenTree] {
        self.0
    }

    pub(super) fn place(&self) -> Place {
        place_of(self.0, Place::at(self.0[0].span()))
    }

    /// What stands behind the word.
    pub(super) fn tokens(&self) -> &'t [TokenTree] {
        &self.0[1 + usize::from(self.is_named())..]
    }

    /// The same as one operand.
    pub(super) fn value(&self) -> TokenTree {
        let tokens = self.tokens();
        let span = tokens
            .first()
            .map_or_else(|| self.0[0].span(), TokenTree::span);
        grouped(Delimiter::None, tokens.to_vec(), span)
    }
}

/// The clauses between commas, or between a value and the next of the words.
pub(super) fn clauses<'t>(tokens: &'t [TokenTree], words: &[&str]) -> Vec<Clause<'t>> {
    let mut found = Vec::new();
    for item in items(tokens) {
        let mut begin = 0;
        for at in 1..item.len() {
            let is_word = matches!(&item[at], TokenTree::Ident(word) if words.iter().any(|known| word == known));
            let ends = !matches!(item[at - 1], TokenTree::Punct(_));
            let has_value = at - begin > 1
                || matches!(&item[begin], TokenTree::Ident(word) if words::BARE.iter().any(|bare| word == bare));
            if is_word && ends && has_value {
                found.push(Clause(&item[begin..at]));
                begin = at;
            }
        }
        found.push(Clause(&item[begin..]));
    }
    found
}

/// Each clause in the place of its word, once and with a value unless it is one of the bare ones.
pub(super) fn sorted<'t, const N: usize>(
    clauses: impl Iterator<Item = Clause<'t>>,
    words: &[&str; N],
    what: &str,
    diagnostics: &mut Diagnostics,
) -> Checked<[Option<Clause<'t>>; N]> {
    let mut found = [None; N];
    for clause in clauses {
        let text = clause.first().to_string();
        let Some(index) = words.iter().position(|known| *known == text) else {
            let help = match closest(&text, words.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("it knows {}", list(words.iter().copied())),
            };
            let message = format!("`{text}` says nothing of {what}; {help}");
            return Err(diagnostics.report("E27", clause.place(), message));
        };
        let has_value = clause.tokens().is_empty() == words::BARE.contains(&text.as_str());
        let message = match found[index].replace(clause) {
            Some(_) => format!("`{text}` stands twice; keep one"),
            None if has_value => continue,
            None if clause.tokens().is_empty() => format!("`{text}` needs its value behind it"),
            None => format!("nothing stands behind `{text}` but a comma or the next word"),
        };
        return Err(diagnostics.syntax(clause.place(), message));
    }
    Ok(found)
}

/// Name, indices and what stands behind the colon of `word name[1]: ..`.
pub(super) fn head<'t>(
    statement: &'t [TokenTree],
    diagnostics: &mut Diagnostics,
) -> Checked<(&'t Ident, Vec<i64>, &'t [TokenTree])> {
    let statement = ended(undocumented(statement));
    let example = words::example(&keyword(statement)).unwrap_or_default();
    let [TokenTree::Ident(word), TokenTree::Ident(name), rest @ ..] = statement else {
        let message = format!("`{}` is written as in `{example}`", keyword(statement));
        return Err(diagnostics.syntax(Place::at(statement[0].span()), message));
    };
    let own = rest.first().and_then(indices);
    let rest = &rest[usize::from(own.is_some())..];
    match rest {
        [colon, rest @ ..] if is_punct(Some(colon), ':') && !rest.is_empty() => {
            Ok((name, own.unwrap_or_default(), rest))
        }
        _ => {
            let message =
                format!("a colon and what is said of `{name}` are missing; write `{example}`");
            let place = Place::at(word.span()).to(Place::at(name.span()));
            Err(diagnostics.syntax(place, message))
        }
    }
}

/// A whole name as it is written.
pub(super) fn shown(whole: &str) -> String {
    whole.replace("][", ", ")
}
