//! A cursor over token trees that never panics and always knows a place.

use crate::ast::Name;
use crate::diagnostics::Place;
use proc_macro2::{Delimiter, Group, Ident, Spacing, Span, TokenStream, TokenTree};

/// Nesting beyond which invisible groups are not looked into.
const FLATTEN_DEPTH: usize = 64;

/// Position in a list of token trees.
#[derive(Clone)]
pub(crate) struct Cursor {
    tokens: std::rc::Rc<Vec<TokenTree>>,
    position: usize,
    /// Where to point when the tokens have run out.
    end: Span,
}

impl Cursor {
    pub(crate) fn new(stream: TokenStream, end: Span) -> Self {
        let mut tokens = Vec::new();
        flatten(stream, &mut tokens, 0);
        Self {
            tokens: tokens.into(),
            position: 0,
            end,
        }
    }

    /// The tokens inside a group.
    pub(crate) fn inside(group: &Group) -> Self {
        Self::new(group.stream(), group.span_close())
    }

    pub(crate) fn peek(&self) -> Option<&TokenTree> {
        self.tokens.get(self.position)
    }

    pub(crate) fn peek_at(&self, offset: usize) -> Option<&TokenTree> {
        self.tokens.get(self.position + offset)
    }

    pub(crate) fn advance(&mut self) -> Option<TokenTree> {
        let token = self.tokens.get(self.position).cloned();
        self.position += usize::from(token.is_some());
        token
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.position >= self.tokens.len()
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
                let text: String = token.to_string().chars().take(40).collect();
                format!("`{text}`")
            }
        }
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
            text: ident.to_string(),
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

fn flatten(stream: TokenStream, tokens: &mut Vec<TokenTree>, depth: usize) {
    for token in stream {
        match token {
            TokenTree::Group(group)
                if group.delimiter() == Delimiter::None && depth < FLATTEN_DEPTH =>
            {
                flatten(group.stream(), tokens, depth + 1);
            }
            token => tokens.push(token),
        }
    }
}
