//! Where blanks stand in a line: `m/2*|dot(p)|^2 - 3[kg]*g`.

use super::scan::{Kind, Piece};
use crate::words;

/// Words that stand apart from what follows where a value or a mark stands before them.
pub(super) type Apart = fn(&str) -> bool;

/// No words.
pub(super) fn none(_: &str) -> bool {
    false
}

/// Writes pieces behind each other.
pub(super) struct Line {
    pub(super) text: String,
    /// Whether what stands last can be the left side of an operator.
    value: bool,
    /// Whether a blank must follow unless the line ends.
    wants_blank: bool,
    /// Whether the last piece binds to the next one.
    binds: bool,
    apart: Apart,
    norms: Vec<usize>,
    depth: usize,
}

impl Line {
    /// A line in which some words stand apart.
    pub(super) fn new(apart: Apart) -> Self {
        Self {
            text: String::new(),
            value: false,
            wants_blank: false,
            binds: false,
            apart,
            norms: Vec::new(),
            depth: 0,
        }
    }

    /// Whether the next piece is a plus or minus between terms outside all brackets, where a line may be broken.
    pub(super) fn breaks_before(&self, piece: &Piece) -> bool {
        let sign = piece.is("+") || piece.is("-");
        sign && self.value && self.depth == 0 && self.norms.is_empty()
    }

    pub(super) fn push(&mut self, piece: &Piece) {
        match piece.kind {
            Kind::Word => self.word(piece),
            Kind::Symbol => self.symbol(piece),
            Kind::Comment => {
                self.separate();
                self.write(&piece.text);
                self.wants_blank = true;
            }
        }
    }

    fn separate(&mut self) {
        let fresh = self.text.is_empty() || self.text.ends_with([' ', '\n']);
        if !self.binds && !fresh {
            self.text.push(' ');
        }
    }

    fn write(&mut self, text: &str) {
        self.text.push_str(text);
        self.wants_blank = false;
        self.binds = false;
    }

    fn word(&mut self, piece: &Piece) {
        let begins = self.value || self.text.is_empty() || self.text.ends_with([',', ':']);
        if self.value || self.wants_blank {
            self.separate();
        }
        let text = piece.text.as_str();
        let keyword = (words::is_keyword(text) && ![words::START, words::AT].contains(&text))
            || ["in", words::IF, "else"].contains(&text)
            || begins && (self.apart)(text);
        self.write(text);
        self.value = !keyword;
        self.wants_blank = keyword;
    }

    fn symbol(&mut self, piece: &Piece) {
        match piece.text.as_str() {
            sign @ ("+" | "-") if self.value => self.spaced(sign),
            sign @ ("=" | "==" | ">=" | "<=" | "+=" | "!=" | "<" | ">") => self.spaced(sign),
            // The values of a comparison.
            "{" => {
                self.spaced("{");
                self.depth += 1;
            }
            "}" => {
                self.depth = self.depth.saturating_sub(1);
                self.spaced("}");
                self.value = true;
            }
            mark @ ("," | ":" | ";") => {
                self.write(mark);
                self.value = false;
                self.wants_blank = true;
            }
            "(" => self.open("("),
            // A unit stands behind its number, an index behind its vector.
            "[" => {
                self.wants_blank = piece.apart;
                self.open("[");
            }
            close @ (")" | "]") => {
                self.depth = self.depth.saturating_sub(1);
                self.write(close);
                self.value = true;
            }
            "|" if self.norms.last() == Some(&self.depth) && self.value => {
                self.norms.pop();
                self.write("|");
            }
            "|" => {
                self.norms.push(self.depth);
                self.open_norm();
            }
            "." if piece.apart => {
                self.text.push(' ');
                self.write(".");
                self.value = false;
                self.wants_blank = true;
            }
            other => {
                if self.wants_blank {
                    self.separate();
                }
                self.write(other);
                self.value = false;
                self.binds = true;
            }
        }
    }

    fn spaced(&mut self, sign: &str) {
        self.separate();
        self.write(sign);
        self.value = false;
        self.wants_blank = true;
    }

    fn open(&mut self, bracket: &str) {
        if self.wants_blank {
            self.separate();
        }
        self.depth += 1;
        self.write(bracket);
        self.value = false;
        self.binds = true;
    }

    fn open_norm(&mut self) {
        if self.wants_blank || self.value {
            self.separate();
        }
        self.write("|");
        self.value = false;
        self.binds = true;
    }
}
