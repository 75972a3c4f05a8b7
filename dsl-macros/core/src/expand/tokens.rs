//! Tokens as they are taken apart and put together.

use crate::diagnostics::Place;
use proc_macro2::{Delimiter, Group, Ident, Literal, Punct, Spacing, Span, TokenStream, TokenTree};

pub(super) fn is_punct(token: Option<&TokenTree>, mark: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == mark)
}

/// Whether a point is an operator between vectors, `v . f(x)`: what is behind it stands apart. Tokens without a place of their own do not.
pub(crate) fn is_product(point: &TokenTree, next: &TokenTree) -> bool {
    let (point, next) = (point.span(), next.span().start());
    next != point.end() && next != point.start()
}

/// The group that a token is, if it has these brackets.
pub(super) fn group_in(token: Option<&TokenTree>, delimiter: Delimiter) -> Option<&Group> {
    match token {
        Some(TokenTree::Group(group)) if group.delimiter() == delimiter => Some(group),
        _ => None,
    }
}

pub(super) fn inside(group: &Group) -> Vec<TokenTree> {
    group.stream().into_iter().collect()
}

/// What an invisible group holds.
pub(super) fn opened(token: &TokenTree) -> Vec<TokenTree> {
    match token {
        TokenTree::Group(group) if group.delimiter() == Delimiter::None => inside(group),
        other => vec![other.clone()],
    }
}

/// Tokens between commas; a comma at the end ends nothing.
pub(super) fn items(tokens: &[TokenTree]) -> impl Iterator<Item = &[TokenTree]> {
    tokens
        .split(|token| is_punct(Some(token), ','))
        .filter(|item| !item.is_empty())
}

/// The components of a vector that is written out; none of anything else.
pub(super) fn components(value: &[TokenTree]) -> Vec<Vec<TokenTree>> {
    match value {
        [TokenTree::Group(group)] if group.delimiter() == Delimiter::None => {
            components(&inside(group))
        }
        [value] => {
            let inner = group_in(Some(value), Delimiter::Parenthesis).map(inside);
            let inner = inner.unwrap_or_default();
            items(&inner).map(<[TokenTree]>::to_vec).collect()
        }
        _ => Vec::new(),
    }
}

/// What stands before the first of these marks, and behind it: nothing if there is none.
pub(super) fn halves(tokens: &[TokenTree], mark: char) -> [&[TokenTree]; 2] {
    let mut halves = tokens.splitn(2, |token| is_punct(Some(token), mark));
    [(); 2].map(|()| halves.next().unwrap_or_default())
}

/// What stands on both sides of some marks, if both sides have anything.
pub(super) fn parted<'t>(tokens: &'t [TokenTree], marks: &[&str]) -> Option<[&'t [TokenTree]; 2]> {
    let is_mark = |(token, mark): (&TokenTree, &&str)| token.to_string() == **mark;
    let mut places = tokens.get(1..)?.windows(marks.len());
    let at = 1 + places.position(|place| place.iter().zip(marks).all(is_mark))?;
    let behind = &tokens[at + marks.len()..];
    (!behind.is_empty()).then_some([&tokens[..at], behind])
}

/// Tokens without their documentation.
pub(super) fn undocumented(mut tokens: &[TokenTree]) -> &[TokenTree] {
    while is_punct(tokens.first(), '#') {
        tokens = tokens.get(2..).unwrap_or_default();
    }
    tokens
}

/// Tokens without the marks at their end.
pub(super) fn ended(tokens: &[TokenTree]) -> &[TokenTree] {
    let is_end = |token: &&TokenTree| is_punct(Some(token), ',') || is_punct(Some(token), ';');
    let ends = tokens.iter().rev().take_while(is_end).count();
    &tokens[..tokens.len() - ends]
}

/// The first word of a statement.
pub(super) fn keyword(statement: &[TokenTree]) -> String {
    match undocumented(statement).first() {
        Some(TokenTree::Ident(word)) => word.to_string(),
        _ => String::new(),
    }
}

/// The place of tokens, or that of what stands around them if there are none.
pub(super) fn place_of(tokens: &[TokenTree], around: Place) -> Place {
    match tokens {
        [first, .., last] => Place::at(first.span()).to(Place::at(last.span())),
        [only] => Place::at(only.span()),
        [] => around,
    }
}

/// A group like another one, around other tokens.
pub(super) fn around(group: &Group, tokens: Vec<TokenTree>) -> TokenTree {
    grouped(group.delimiter(), tokens, group.span())
}

pub(super) fn grouped(delimiter: Delimiter, tokens: Vec<TokenTree>, span: Span) -> TokenTree {
    let mut group = Group::new(delimiter, TokenStream::from_iter(tokens));
    group.set_span(span);
    group.into()
}

pub(super) fn punct(mark: char, span: Span) -> TokenTree {
    let mut punct = Punct::new(mark, Spacing::Alone);
    punct.set_span(span);
    punct.into()
}

pub(super) fn word(text: &str, span: Span) -> TokenTree {
    Ident::new(text, span).into()
}

/// A whole number; a negative one in parentheses.
pub(super) fn number(value: i64, span: Span) -> TokenTree {
    let mut literal = Literal::u64_unsuffixed(value.unsigned_abs());
    literal.set_span(span);
    match value < 0 {
        true => grouped(
            Delimiter::Parenthesis,
            vec![punct('-', span), literal.into()],
            span,
        ),
        false => literal.into(),
    }
}

/// Lists of tokens with a mark between them.
pub(super) fn joined(
    items: impl Iterator<Item = Vec<TokenTree>>,
    mark: char,
    span: Span,
) -> Vec<TokenTree> {
    let mut tokens = Vec::new();
    for item in items {
        if !tokens.is_empty() {
            tokens.push(punct(mark, span));
        }
        tokens.extend(item);
    }
    tokens
}
