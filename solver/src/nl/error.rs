//! Why a file was refused.

/// Why a `.nl` file was refused: where it is wrong, what is wrong, and how to mend it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{place}: {what}")]
pub struct ReadError {
    place: Place,
    what: String,
}

/// Where a file is wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    Line(usize),
    Byte(usize),
    Whole,
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
            Self::Whole => f.write_str("the whole file"),
        }
    }
}

impl ReadError {
    /// At a line of a text, counted from 1.
    pub(super) fn at_line(line: usize, what: impl Into<String>) -> Self {
        Self::new(Place::Line(line), what)
    }

    /// At a byte of a binary file, counted from 0.
    pub(super) fn at_byte(byte: usize, what: impl Into<String>) -> Self {
        Self::new(Place::Byte(byte), what)
    }

    /// At no place in particular.
    pub(super) fn whole(what: impl Into<String>) -> Self {
        Self::new(Place::Whole, what)
    }

    fn new(place: Place, what: impl Into<String>) -> Self {
        Self {
            place,
            what: what.into(),
        }
    }
}
