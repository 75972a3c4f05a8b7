//! Bytes in, keys and numbers out: both encodings of a file look the same from above.

use super::error::ReadError;

/// A file that is being read.
pub(super) struct Source<'a> {
    bytes: &'a [u8],
    position: usize,
    /// Line of `position`, counted from 1; lines are those of the text and of a binary file's heading.
    line: usize,
    is_binary: bool,
}

impl<'a> Source<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            position: 0,
            line: 1,
            is_binary: false,
        }
    }

    /// From here on numbers are binary: 4-byte integers and 8-byte reals, least byte first.
    pub(super) fn turn_binary(&mut self) {
        self.is_binary = true;
    }

    /// An error at the place that was read last.
    pub(super) fn error(&self, what: impl Into<String>) -> ReadError {
        if self.is_binary {
            ReadError::at_byte(self.position, what)
        } else {
            ReadError::at_line(self.line, what)
        }
    }

    /// Bytes that are left.
    pub(super) fn remaining(&self) -> usize {
        self.bytes.len() - self.position
    }

    /// The next line of the heading without its comment, which is text in both encodings.
    pub(super) fn heading_line(&mut self) -> Result<&'a str, ReadError> {
        let rest = &self.bytes[self.position..];
        let Some(length) = rest.iter().take(1000).position(|&byte| byte == b'\n') else {
            return Err(self.error("the heading ends early; a .nl file begins with ten lines"));
        };
        let line = &rest[..length];
        let line = line.split(|&byte| byte == b'#').next().unwrap_or(line);
        let Ok(text) = std::str::from_utf8(line) else {
            return Err(self.error("the heading is no text; give a .nl file"));
        };
        self.position += length + 1;
        self.line += 1;
        Ok(text)
    }

    /// The letter of the next segment or part of an expression; `None` at the end of the file.
    pub(super) fn key(&mut self) -> Option<u8> {
        self.skip_space();
        let key = *self.bytes.get(self.position)?;
        self.position += 1;
        Some(key)
    }

    /// The next digit, which says what kind of bound follows.
    pub(super) fn digit(&mut self) -> Result<usize, ReadError> {
        if !self.is_binary {
            return self.index();
        }
        match self.key() {
            Some(byte) if byte.is_ascii_digit() => Ok(usize::from(byte - b'0')),
            _ => Err(self.error("expected a digit, the kind of a bound")),
        }
    }

    /// The next whole number, which is not negative.
    pub(super) fn index(&mut self) -> Result<usize, ReadError> {
        if self.is_binary {
            let number = i32::from_le_bytes(self.take()?);
            return usize::try_from(number)
                .map_err(|_| self.error(format!("expected a count or an index, found {number}")));
        }
        let word = self.word();
        match word.parse::<u32>() {
            Ok(number) => Ok(number as usize),
            Err(_) => Err(self.error(format!(
                "expected a count or an index, found {}",
                shown(word)
            ))),
        }
    }

    /// The next real number, which is not NaN.
    pub(super) fn real(&mut self) -> Result<f64, ReadError> {
        let number = if self.is_binary {
            f64::from_le_bytes(self.take()?)
        } else {
            let word = self.word();
            match word.parse() {
                Ok(number) => number,
                Err(_) => {
                    return Err(self.error(format!("expected a number, found {}", shown(word))));
                }
            }
        };
        if number.is_nan() {
            return Err(self.error("expected a number, found NaN"));
        }
        Ok(number)
    }

    /// The next real number, which is finite.
    pub(super) fn finite(&mut self) -> Result<f64, ReadError> {
        let number = self.real()?;
        if number.is_infinite() {
            return Err(self.error(format!("expected a finite number, found {number}")));
        }
        Ok(number)
    }

    /// The next short (2 bytes) or long (4 bytes) integer constant of an expression.
    pub(super) fn whole(&mut self, is_short: bool) -> Result<f64, ReadError> {
        match (self.is_binary, is_short) {
            (false, _) => self.finite(),
            (true, true) => Ok(f64::from(i16::from_le_bytes(self.take()?))),
            (true, false) => Ok(f64::from(i32::from_le_bytes(self.take()?))),
        }
    }

    /// The next name: in a binary file its length comes first.
    pub(super) fn name(&mut self) -> Result<String, ReadError> {
        if !self.is_binary {
            return Ok(self.word().into_owned());
        }
        let length = self.index()?;
        if length > self.remaining() {
            return Err(self.error("the file ends inside a name"));
        }
        let name = &self.bytes[self.position..self.position + length];
        self.position += length;
        Ok(String::from_utf8_lossy(name).into_owned())
    }

    /// The next word of a text, at most 60 characters of it; empty at the end.
    fn word(&mut self) -> std::borrow::Cow<'a, str> {
        self.skip_space();
        let rest = &self.bytes[self.position..];
        let length = rest.iter().take_while(|byte| !byte.is_ascii_whitespace());
        let length = length.count();
        self.position += length;
        String::from_utf8_lossy(&rest[..length.min(60)])
    }

    /// In a text, moves over white space and comments.
    fn skip_space(&mut self) {
        while !self.is_binary
            && let Some(&byte) = self.bytes.get(self.position)
        {
            match byte {
                b'\n' => self.line += 1,
                b'#' => {
                    let rest = &self.bytes[self.position..];
                    let end = rest.iter().position(|&byte| byte == b'\n');
                    self.position += end.unwrap_or(rest.len());
                    continue;
                }
                _ if byte.is_ascii_whitespace() => {}
                _ => return,
            }
            self.position += 1;
        }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], ReadError> {
        match self.bytes[self.position..].first_chunk() {
            Some(&bytes) => {
                self.position += N;
                Ok(bytes)
            }
            None => Err(self.error("the file ends inside a number")),
        }
    }
}

/// What was found instead of a number.
fn shown(word: impl AsRef<str>) -> String {
    match word.as_ref() {
        "" => "the end of the file; it is cut off".to_owned(),
        word => format!("`{word}`"),
    }
}
