//! A text in the settled style: one statement a line, one entry a line in blocks that take several, blanks around `+`
//! and `-` and none around `*` and `/`, comments where they were.

mod scan;
mod spacing;

use crate::{expand, parse, text, words};
use scan::{Piece, pieces};
use spacing::{Apart, Line, none};
use std::collections::HashSet;

/// Longest line.
const LONGEST: usize = 120;
/// Longest block in one line.
const LONGEST_BLOCK: usize = 100;
/// One step to the right.
const INDENT: &str = "    ";

/// The text in the settled style, if it is a declaration.
pub(crate) fn formatted(text: &str) -> String {
    let pieces = pieces(text);
    let body = text::tokens(text, "scene").ok().and_then(parse::body);
    let mut writer = Writer {
        text: String::new(),
        depth: 0,
        begins: expand::begins(body.unwrap_or_default()),
    };
    let first = pieces.iter().position(|piece| !piece.is_comment());
    match first {
        Some(first) if !writer.begins.contains(&pieces[first].at) => {
            // `pub Name { ... }`.
            let open = pieces.iter().position(|piece| piece.is("{"));
            let open = open.unwrap_or(pieces.len());
            let close = pieces.iter().rposition(|piece| piece.is("}"));
            let close = close.unwrap_or(pieces.len()).max(open);
            writer.comments(&pieces[..first]);
            let mut header = Line::new(none);
            pieces[first..open]
                .iter()
                .for_each(|piece| header.push(piece));
            writer.line(&format!("{} {{", header.text));
            writer.depth += 1;
            writer.statements(pieces.get(open + 1..close).unwrap_or_default());
            writer.depth -= 1;
            writer.line("}");
            writer.comments(pieces.get(close + 1..).unwrap_or_default());
        }
        _ => writer.statements(&pieces),
    }
    writer.text
}

struct Writer {
    text: String,
    depth: usize,
    /// Where statements begin, in bytes.
    begins: HashSet<usize>,
}

impl Writer {
    fn indent(&self) -> String {
        INDENT.repeat(self.depth)
    }

    fn line(&mut self, line: &str) {
        self.text += &self.indent();
        self.text += line;
        self.text.push('\n');
    }

    /// An empty line, if there was one before this piece and something stands above.
    fn space(&mut self, piece: &Piece) {
        let begins = self.text.is_empty() || self.text.ends_with("{\n");
        if piece.lines > 1 && !begins {
            self.text.push('\n');
        }
    }

    /// Comments, each on a line of its own, or behind what stands on its line.
    fn comments(&mut self, comments: &[Piece]) {
        for comment in comments {
            if comment.lines == 0 && self.text.ends_with('\n') && !self.text.ends_with("{\n") {
                self.text.pop();
                self.text += &format!(" {}\n", comment.text);
                continue;
            }
            self.space(comment);
            self.line(&comment.text);
        }
    }

    /// Statements with the comments between them.
    fn statements(&mut self, pieces: &[Piece]) {
        let mut rest = pieces;
        while let Some(piece) = rest.first() {
            if piece.is_comment() {
                self.comments(&rest[..1]);
                rest = &rest[1..];
                continue;
            }
            let end = statement_end(rest, &self.begins);
            self.space(piece);
            self.statement(&rest[..end]);
            rest = &rest[end..];
        }
    }

    fn statement(&mut self, pieces: &[Piece]) {
        let ends = pieces
            .iter()
            .rposition(|piece| !piece.is(";") && !piece.is(","));
        let pieces = &pieces[..=ends.unwrap_or(0)];
        // A profile has its argument and its units before the block, `when` its condition, `at` its time, what is measured its file.
        let open = pieces.iter().position(|piece| piece.is("{"));
        let named = |&open: &usize| {
            open == 1
                || ["profile", "measured", "when", "at", "part"].contains(&pieces[0].text.as_str())
        };
        let remarks = |head: &[Piece]| head.iter().any(Piece::is_comment);
        let Some(open) = open
            .filter(named)
            .filter(|&open| pieces.len() > open + 1 && !remarks(&pieces[..open]))
        else {
            // A part in use may be called so.
            let is_use = pieces
                .get(1)
                .is_some_and(|next| next.is(":") || next.is("["));
            let of_bodies = words::is_of_bodies(&pieces[0].text) && !is_use;
            let apart: Apart = if of_bodies { words::is_clause } else { none };
            return self.expression(pieces, apart, "");
        };
        let word = &plain(&pieces[..open], none);
        if pieces[0].text == "part" {
            self.line(&format!("{word} {{"));
            self.depth += 1;
            self.statements(&pieces[open + 1..pieces.len() - 1]);
            self.depth -= 1;
            return self.line("}");
        }
        let picture: Apart = if word == "picture" {
            words::is_of_picture
        } else {
            none
        };
        let inner = &pieces[open + 1..pieces.len() - 1];
        let entries = entries(inner);
        let commented = inner.iter().any(Piece::is_comment);
        let broken = inner.first().is_some_and(|piece| piece.lines > 0);
        let joined: Vec<String> = entries.iter().map(|entry| plain(entry, picture)).collect();
        let whole = match joined.len() {
            0 => format!("{word} {{}}"),
            _ => format!("{word} {{ {} }}", joined.join(", ")),
        };
        // A string may go over several lines.
        let width = whole.lines().last().map_or(0, str::len);
        if !commented && !broken && self.indent().len() + width <= LONGEST_BLOCK {
            return self.line(&whole);
        }
        self.line(&format!("{word} {{"));
        self.depth += 1;
        for entry in entries {
            self.entry(&entry, picture);
        }
        self.depth -= 1;
        self.line("}");
    }

    /// An entry of a block on lines of its own; comments may stand before it and behind it.
    fn entry(&mut self, pieces: &[Piece], picture: Apart) {
        let comments = pieces.iter().take_while(|piece| piece.is_comment());
        let (before, rest) = pieces.split_at(comments.count());
        self.comments(before);
        let Some(first) = rest.first() else { return };
        self.space(first);
        let last = rest.iter().rposition(|piece| !piece.is_comment());
        let (own, behind) = rest.split_at(last.map_or(0, |last| last + 1));
        self.expression(own, picture, ",");
        self.comments(behind);
    }

    /// Pieces as one line, or as several if it is too long or a comment stands inside.
    fn expression(&mut self, pieces: &[Piece], picture: Apart, end: &str) {
        let (mut line, mut start) = (Line::new(picture), 0);
        let more = format!("{}{INDENT}", self.indent());
        for (index, piece) in pieces.iter().enumerate() {
            if line.breaks_before(piece) {
                let term = term(&pieces[index..], picture);
                if self.indent().len() + line.text.len() - start + 1 + term.len() + end.len()
                    > LONGEST
                {
                    line.text.push('\n');
                    start = line.text.len();
                    line.text += &more;
                }
            }
            line.push(piece);
            if piece.is_comment() && piece.text.starts_with("//") && index + 1 < pieces.len() {
                line.text.push('\n');
                start = line.text.len();
                line.text += &more;
            }
        }
        let text = format!("{}{end}", line.text);
        self.line(&text);
    }
}

/// Where the first statement ends: before the next one, or before what belongs to that.
fn statement_end(pieces: &[Piece], begins: &HashSet<usize>) -> usize {
    let mut depth = 0_usize;
    for (index, piece) in pieces.iter().enumerate() {
        if index > 0 && depth == 0 && begins.contains(&piece.at) {
            // Comments above the next statement are its own; one behind this statement stays there.
            let comments = pieces[..index].iter().rev();
            return index - comments.take_while(|piece| piece.is_comment()).count();
        }
        if ["{", "(", "["].iter().any(|open| piece.is(open)) {
            depth += 1;
        } else if ["}", ")", "]"].iter().any(|close| piece.is(close)) {
            depth = depth.saturating_sub(1);
        }
    }
    let comments = pieces.iter().rev();
    pieces.len() - comments.take_while(|piece| piece.is_comment()).count()
}

/// The entries of a block. A comment behind a comma on its line belongs to the entry before.
fn entries(pieces: &[Piece]) -> Vec<Vec<Piece>> {
    let mut entries: Vec<Vec<Piece>> = vec![Vec::new()];
    let mut depth = 0_usize;
    for (index, piece) in pieces.iter().enumerate() {
        let behind_comma = index > 0 && pieces[index - 1].is(",");
        let current = entries.len() - 1;
        if piece.is(",") && depth == 0 {
            entries.push(Vec::new());
            continue;
        }
        if piece.is_comment() && piece.lines == 0 && behind_comma && current > 0 {
            entries[current - 1].push(piece.clone());
            continue;
        }
        if ["(", "[", "{"].iter().any(|open| piece.is(open)) {
            depth += 1;
        } else if [")", "]", "}"].iter().any(|close| piece.is(close)) {
            depth = depth.saturating_sub(1);
        }
        entries[current].push(piece.clone());
    }
    entries.retain(|entry| !entry.is_empty());
    entries
}

/// Pieces as one line.
fn plain(pieces: &[Piece], picture: Apart) -> String {
    let mut line = Line::new(picture);
    pieces.iter().for_each(|piece| line.push(piece));
    line.text
}

/// What stands from a sign up to the next place where a line may be broken.
fn term(pieces: &[Piece], picture: Apart) -> String {
    let mut line = Line::new(picture);
    for (index, piece) in pieces.iter().enumerate() {
        if (index > 0 && line.breaks_before(piece)) || piece.is_comment() {
            break;
        }
        line.push(piece);
    }
    line.text
}
