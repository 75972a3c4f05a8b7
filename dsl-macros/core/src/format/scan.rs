//! A text as words, symbols and comments, with where lines end.

use crate::text;

/// One piece of a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Piece {
    pub(super) kind: Kind,
    pub(super) text: String,
    /// Where it begins, in bytes.
    pub(super) at: usize,
    /// Line ends between the piece before and this one.
    pub(super) lines: usize,
    /// Whether blanks or line ends stand before it.
    pub(super) apart: bool,
}

/// What a piece is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A name, a word of the language, a number or a string.
    Word,
    /// An operator, a bracket or a sign between entries.
    Symbol,
    /// A comment, documentation included; it ends its line if it begins with `//`.
    Comment,
}

impl Piece {
    pub(super) fn is(&self, symbol: &str) -> bool {
        self.kind == Kind::Symbol && self.text == symbol
    }

    pub(super) fn is_comment(&self) -> bool {
        self.kind == Kind::Comment
    }
}

/// Symbols of several characters, longer ones first.
const LONG: [&str; 6] = ["..=", "==", ">=", "<=", "+=", "!="];

/// Divides a text into pieces.
pub(super) fn pieces(text: &str) -> Vec<Piece> {
    let mut pieces = Vec::new();
    let mut rest = text;
    loop {
        let trimmed = rest.trim_start();
        let blank = &rest[..rest.len() - trimmed.len()];
        let Some(first) = trimmed.chars().next() else {
            set_units_apart(&mut pieces);
            return pieces;
        };
        let (kind, length) = if trimmed.starts_with("//") {
            (Kind::Comment, trimmed.find('\n').unwrap_or(trimmed.len()))
        } else if trimmed.starts_with("/*") {
            let length = text::comment(trimmed);
            (Kind::Comment, length.unwrap_or(trimmed.len()))
        } else if begins_number(trimmed) {
            (Kind::Word, number(trimmed))
        } else if first == '"' {
            let length = text::string(trimmed);
            (Kind::Word, length.unwrap_or(trimmed.len()))
        } else if first.is_alphanumeric() || first == '_' {
            let end = trimmed.find(|c: char| !c.is_alphanumeric() && c != '_');
            (Kind::Word, end.unwrap_or(trimmed.len()))
        } else {
            let long = LONG.iter().find(|symbol| trimmed.starts_with(**symbol));
            (
                Kind::Symbol,
                long.map_or(first.len_utf8(), |long| long.len()),
            )
        };
        pieces.push(Piece {
            kind,
            text: trimmed[..length].trim_end().to_owned(),
            at: text.len() - trimmed.len(),
            lines: blank.matches('\n').count(),
            apart: !blank.is_empty(),
        });
        rest = &trimmed[length..];
    }
}

/// A unit stands apart from a number that is a term: `2 [m]`; in a product it binds, as in `2[m]*x`. An index binds.
fn set_units_apart(pieces: &mut [Piece]) {
    let product = |piece: Option<&Piece>| {
        piece.is_some_and(|piece| ["*", "/", "^"].iter().any(|sign| piece.is(sign)))
    };
    for open in 1..pieces.len() {
        if !pieces[open].is("[") {
            continue;
        }
        let number = begins_number(&pieces[open - 1].text);
        let close = pieces[open..].iter().position(|piece| piece.is("]"));
        let behind = close.and_then(|close| pieces.get(open + close + 1));
        let before = open.checked_sub(2).and_then(|before| pieces.get(before));
        pieces[open].apart = number && !product(behind) && !product(before);
    }
}

/// Whether a number stands first, such as `2` or `.5`.
fn begins_number(text: &str) -> bool {
    let digits = text.strip_prefix('.').unwrap_or(text);
    digits.starts_with(|c: char| c.is_ascii_digit())
}

/// Length of a number such as `2`, `0.5`, `.5` or `1e-3`.
fn number(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut end = 0;
    while let Some(&byte) = bytes.get(end) {
        let next = bytes.get(end + 1).copied().unwrap_or_default();
        let exponent = matches!(byte, b'+' | b'-')
            && end > 0
            && matches!(bytes[end - 1], b'e' | b'E')
            && next.is_ascii_digit();
        let point = byte == b'.' && next.is_ascii_digit();
        if !(byte.is_ascii_alphanumeric() || byte == b'_' || exponent || point) {
            // `2.` is a number as well, `2..=3` is a range.
            return if byte == b'.' && next != b'.' && !next.is_ascii_alphabetic() {
                end + 1
            } else {
                end
            };
        }
        end += 1;
    }
    end
}
