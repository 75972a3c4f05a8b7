//! A cursor over token trees that never panics and always knows a place.

use crate::ast::Name;
use crate::diagnostics::{Diagnostics, Place, Reported};
use crate::expand::decoded;
use proc_macro2::{Delimiter, Group, Ident, Spacing, Span, TokenStream, TokenTree};
use std::cell::{RefCell, RefMut};
use std::ops::Range;
use std::rc::Rc;

/// Nesting beyond which invisible groups are left as they are.
const FLATTEN_DEPTH: usize = 64;

/// Position in a list of token trees.
///
/// Groups without delimiters, in which `macro_rules!` hands over what it has parsed, are not tokens here:
/// names, units and lists read through them. Only expressions ask for them, since there they
/// bind like parentheses.
#[derive(Clone)]
pub(crate) struct Cursor {
    tokens: Rc<Vec<TokenTree>>,
    /// Invisible groups of more than one token, outer ones before those inside.
    groups: Rc<Vec<Range<usize>>>,
    /// How many of the groups are behind or around the cursor.
    passed: usize,
    position: usize,
    /// Behind the last token to be read.
    limit: usize,
    /// Where to point when the tokens have run out.
    end: Span,
    said: Said,
}

/// Mistakes found so far, which all cursors over a declaration report to.
pub(crate) type Said = Rc<RefCell<Diagnostics>>;

impl Cursor {
    pub(crate) fn new(stream: TokenStream, end: Span, said: Said) -> Self {
        let mut flat = Flat::default();
        flat.extend(stream, 0);
        Self {
            limit: flat.tokens.len(),
            tokens: flat.tokens.into(),
            groups: flat.groups.into(),
            passed: 0,
            position: 0,
            end,
            said,
        }
    }

    /// The tokens inside a group.
    pub(crate) fn inside(&self, group: &Group) -> Self {
        Self::new(group.stream(), group.span_close(), self.all_said())
    }

    /// Mistakes found so far.
    pub(super) fn said(&self) -> RefMut<'_, Diagnostics> {
        self.said.borrow_mut()
    }

    /// The list of mistakes found so far, to be kept.
    pub(super) fn all_said(&self) -> Said {
        Rc::clone(&self.said)
    }

    /// This position, of which no mistake is told.
    pub(super) fn silent(&self) -> Self {
        Self {
            said: Said::default(),
            ..self.clone()
        }
    }

    /// Moves to where a silent cursor over the same tokens is.
    pub(super) fn follow(&mut self, silent: Self) {
        *self = Self {
            said: self.all_said(),
            ..silent
        };
    }

    /// Reports what was found instead of `expected`.
    pub(super) fn unexpected(&self, expected: &str) -> Reported {
        let message = format!("expected {expected}, found {}", self.describe());
        self.said().syntax(self.place(), message)
    }

    pub(crate) fn peek(&self) -> Option<&TokenTree> {
        self.peek_at(0)
    }

    pub(crate) fn peek_at(&self, offset: usize) -> Option<&TokenTree> {
        self.tokens[..self.limit].get(self.position + offset)
    }

    /// Index of the outermost invisible group that begins `offset` tokens further.
    fn group_at(&self, offset: usize) -> Option<usize> {
        let begin = self.position + offset;
        let first = self.passed + self.groups[self.passed..].partition_point(|g| g.start < begin);
        let group = self.groups.get(first)?;
        (group.start == begin && group.end <= self.limit).then_some(first)
    }

    /// Whether an invisible group begins `offset` tokens further.
    pub(crate) fn at_invisible_group(&self, offset: usize) -> bool {
        self.group_at(offset).is_some()
    }

    /// The tokens of the invisible group that begins here; the cursor moves behind it.
    pub(crate) fn eat_invisible_group(&mut self) -> Option<Self> {
        let index = self.group_at(0)?;
        let group = self.groups[index].clone();
        let mut inner = self.clone();
        inner.passed = index + 1;
        inner.limit = group.end;
        inner.end = group
            .clone()
            .next_back()
            .and_then(|last| self.tokens.get(last))
            .map_or(self.end, TokenTree::span);
        // `-2` was handed over, and the unit stands behind it.
        let signed_number = group.len() == 2
            && inner.at_symbol("-")
            && matches!(inner.peek_at(1), Some(TokenTree::Literal(_)));
        if signed_number
            && matches!(self.peek_at(2), Some(TokenTree::Group(unit))
                if unit.delimiter() == Delimiter::Bracket)
        {
            inner.limit += 1;
        }
        self.position = inner.limit;
        Some(inner)
    }

    /// Forgets the invisible group that begins here if it holds more than an expression, such as
    /// `z >= 0`: its parts are then read one by one.
    pub(crate) fn open_comparison(&mut self) {
        while let Some(index) = self.group_at(0) {
            let compares = self.tokens[self.groups[index].clone()].iter().any(
                |token| matches!(token, TokenTree::Punct(punct) if matches!(punct.as_char(), '<' | '>' | '=')),
            );
            if !compares {
                return;
            }
            self.passed = index + 1;
        }
    }

    pub(crate) fn advance(&mut self) -> Option<TokenTree> {
        let token = self.peek().cloned();
        self.position += usize::from(token.is_some());
        token
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.position >= self.limit
    }

    /// Place of the next token, or of the end.
    pub(crate) fn place(&self) -> Place {
        match self.peek() {
            Some(TokenTree::Group(group)) => Place::at(group.span_open()),
            Some(token) => Place::at(token.span()),
            None => Place::at(self.end),
        }
    }

    /// Place of the token before, or of the next one at the very start.
    pub(crate) fn previous(&self) -> Place {
        match self
            .position
            .checked_sub(1)
            .and_then(|before| self.tokens.get(before))
        {
            Some(TokenTree::Group(group)) => Place::at(group.span_close()),
            Some(token) => Place::at(token.span()),
            None => self.place(),
        }
    }

    /// The next token in words, for messages.
    pub(crate) fn describe(&self) -> String {
        match self.peek() {
            None => "the end".to_owned(),
            Some(TokenTree::Group(group)) => match group.delimiter() {
                Delimiter::Parenthesis => "`(`".to_owned(),
                Delimiter::Brace => "`{`".to_owned(),
                Delimiter::Bracket => "`[`".to_owned(),
                Delimiter::None => "a group".to_owned(),
            },
            Some(token) => {
                let text: String = decoded(token.to_string()).chars().take(40).collect();
                format!("`{text}`")
            }
        }
    }

    /// The number that was meant where a decimal comma stands at the cursor.
    pub(crate) fn decimal_comma(&self) -> Option<String> {
        let digits = |token: Option<&TokenTree>| match token {
            Some(TokenTree::Literal(literal)) => Some(literal.to_string())
                .filter(|text| text.bytes().all(|byte| byte.is_ascii_digit())),
            _ => None,
        };
        let before = self.tokens.get(self.position.checked_sub(1)?);
        let (whole, fraction) = (digits(before)?, digits(self.peek_at(1))?);
        self.at_symbol(",").then(|| format!("{whole}.{fraction}"))
    }

    /// Whether the next tokens are exactly these joint characters.
    pub(crate) fn at_symbol(&self, symbol: &str) -> bool {
        let length = symbol.chars().count();
        symbol.chars().enumerate().all(|(i, wanted)| {
            matches!(
                self.peek_at(i),
                Some(TokenTree::Punct(punct))
                    if punct.as_char() == wanted
                        && (i + 1 == length || punct.spacing() == Spacing::Joint)
            )
        })
    }

    pub(crate) fn eat_symbol(&mut self, symbol: &str) -> bool {
        let found = self.at_symbol(symbol);
        if found {
            self.position += symbol.chars().count();
        }
        found
    }

    pub(crate) fn at_word(&self, word: &str) -> bool {
        matches!(self.peek(), Some(TokenTree::Ident(ident)) if ident == word)
    }

    pub(crate) fn eat_word(&mut self, word: &str) -> bool {
        let found = self.at_word(word);
        self.position += usize::from(found);
        found
    }

    /// Whether a sign of the language comes next, not a name, a number or a bracket.
    pub(crate) fn at_any_symbol(&self) -> bool {
        matches!(self.peek(), Some(TokenTree::Punct(_)))
    }

    pub(crate) fn ident(&self) -> Option<&Ident> {
        match self.peek() {
            Some(TokenTree::Ident(ident)) => Some(ident),
            _ => None,
        }
    }

    pub(crate) fn eat_name(&mut self) -> Option<Name> {
        let ident = self.ident()?.clone();
        self.position += 1;
        Some(Name {
            text: decoded(ident.to_string()),
            ident,
        })
    }

    pub(crate) fn eat_group(&mut self, delimiter: Delimiter) -> Option<Group> {
        match self.peek() {
            Some(TokenTree::Group(group)) if group.delimiter() == delimiter => {
                let group = group.clone();
                self.position += 1;
                Some(group)
            }
            _ => None,
        }
    }

    /// Skips to the next token for which `stop` holds, or to the end.
    pub(crate) fn skip_until(&mut self, stop: impl Fn(&Self) -> bool) {
        while !self.is_empty() && !stop(self) {
            self.position += 1;
        }
    }
}

/// Tokens without their invisible groups, and where those were.
#[derive(Default)]
struct Flat {
    tokens: Vec<TokenTree>,
    groups: Vec<Range<usize>>,
}

impl Flat {
    fn extend(&mut self, stream: TokenStream, depth: usize) {
        for token in stream {
            match token {
                TokenTree::Group(group)
                    if group.delimiter() == Delimiter::None && depth < FLATTEN_DEPTH =>
                {
                    let (index, begin) = (self.groups.len(), self.tokens.len());
                    self.groups.push(begin..begin);
                    self.extend(group.stream(), depth + 1);
                    self.groups[index].end = self.tokens.len();
                    // One token binds as it is; neither has it groups inside.
                    if self.groups[index].len() < 2 {
                        self.groups.truncate(index);
                    }
                }
                token => self.tokens.push(token),
            }
        }
    }
}
