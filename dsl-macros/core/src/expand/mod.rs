//! Repetition and parts, which are written out before anything else is read: tokens of a scene to tokens of a scene without
//! them, each at the place where it was written. What repeats is copied, with numbers in the place of its indices; the
//! statements of a part stand where it is used, with its name in front of theirs. A scene without any of it is not touched.

mod index;
mod names;
mod part;
mod repeat;

pub(crate) use names::decoded;
pub(crate) use part::{counts, files, is_declaration};

use crate::diagnostics::{Checked, Diagnostics};
use crate::words;
use index::is_punct;
use names::{Names, Scope};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use repeat::{DEEPEST, Repeat, grouped, inside, joined};
use std::rc::Rc;

/// Statements of a scene without repetition and parts.
///
/// # Errors
/// It is too long.
pub(crate) fn expanded(stream: TokenStream, diagnostics: &mut Diagnostics) -> Checked<TokenStream> {
    let tokens: Vec<TokenTree> = stream.clone().into_iter().collect();
    if !is_used(&tokens, 0) {
        return Ok(stream);
    }
    let (mut names, mut parts) = (Names::default(), part::Parts::default());
    for statement in statements(&tokens) {
        parts.note(statement, diagnostics);
    }
    let (mut repeat, scope) = (Repeat::new(diagnostics), Rc::new(Scope::default()));
    let known = &parts.counts;
    let unrolled = parts.unrolled(&tokens, (known, &scope), &mut names, &mut repeat);
    repeat.is_bounded()?;
    for (statement, scope) in &unrolled {
        names.declare_all(statement, scope);
    }
    let resolved = unrolled
        .iter()
        .map(|(statement, scope)| names.resolved(statement, scope, diagnostics));
    let statements = in_one(resolved.collect());
    Ok(statements.into_iter().flatten().collect())
}

/// Whether tokens hold anything of what is written out.
fn is_used(tokens: &[TokenTree], depth: usize) -> bool {
    (0..tokens.len()).any(|at| {
        let rest = &tokens[at..];
        let before = at.checked_sub(1).and_then(|before| tokens.get(before));
        let named = matches!(rest[0], TokenTree::Ident(_));
        let here = match &rest[0] {
            TokenTree::Ident(_) if depth == 0 && part::begins(rest, before) => true,
            TokenTree::Punct(_) if is_punct(rest.first(), '+') => is_punct(rest.get(1), '='),
            TokenTree::Group(group) if depth < DEEPEST => {
                let inner = inside(group);
                let repeats = match group.delimiter() {
                    Delimiter::Bracket => index::is_repetition(&inner),
                    _ => repeat::comprehension(&inner).is_some(),
                };
                repeats || is_used(&inner, depth + 1)
            }
            _ => false,
        };
        // `theta[3]: rad` declares three.
        let bracket = matches!(rest.get(1), Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Bracket);
        here || bracket && named && is_punct(rest.get(2), ':')
    })
}

/// Whether a statement begins at the first of these tokens.
fn begins(tokens: &[TokenTree], before: Option<&TokenTree>) -> bool {
    let Some(TokenTree::Ident(word)) = tokens.first() else {
        return false;
    };
    let word = word.to_string();
    let called = matches!(tokens.get(1), Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis);
    let is_value = called && (word == words::START || word == words::AT);
    !is_punct(before, '.')
        && (words::STATEMENTS.contains(&word.as_str()) && !is_value || part::begins(tokens, before))
}

/// The statements that tokens hold, each with its documentation.
fn statements(tokens: &[TokenTree]) -> Vec<&[TokenTree]> {
    let mut found = Vec::new();
    let (mut begin, mut documented) = (0, false);
    for at in 0..tokens.len() {
        let before = at.checked_sub(1).and_then(|before| tokens.get(before));
        let documents = is_punct(tokens.get(at), '#') && !is_punct(before, '#');
        if documents && !documented || !documented && begins(&tokens[at..], before) {
            found.push(&tokens[begin..at]);
            begin = at;
        }
        documented = documents || documented && !begins(&tokens[at..], before);
    }
    found.push(&tokens[begin..]);
    found.retain(|statement| !statement.is_empty());
    found
}

/// All `lagrangian += ..`, and `dissipation += ..`, as one statement each, in the place of the last.
fn in_one(mut statements: Vec<Vec<TokenTree>>) -> Vec<Vec<TokenTree>> {
    for word in ["lagrangian", "dissipation"] {
        let is_one = |statement: &Vec<TokenTree>| matches!(statement.first(), Some(TokenTree::Ident(first)) if first == word);
        let adds = |statement: &Vec<TokenTree>| {
            is_one(statement) && is_punct(statement.get(1), '+') && is_punct(statement.get(2), '=')
        };
        let Some(last) = statements.iter().rposition(adds) else {
            continue;
        };
        let span = statements[last][0].span();
        let terms: Vec<Vec<TokenTree>> = statements
            .iter_mut()
            .filter(|statement| is_one(statement))
            .map(|statement| {
                let signs =
                    |token: &&TokenTree| is_punct(Some(token), '+') || is_punct(Some(token), '=');
                let ends =
                    |token: &&TokenTree| is_punct(Some(token), ';') || is_punct(Some(token), ',');
                let begin = 1 + statement[1..].iter().take_while(signs).count();
                let end = statement.len() - statement.iter().rev().take_while(ends).count();
                let term = statement[begin.min(end)..end].to_vec();
                statement.clear();
                let span = term.first().map_or(span, TokenTree::span);
                vec![grouped(Delimiter::None, term, span)]
            })
            .collect();
        statements[last].push(repeat::word(word, span));
        statements[last].extend(joined(terms.into_iter(), '+', span));
    }
    statements
}
