//! Lines of tables in any style: semicolons, commas, tabs or blanks between cells, decimals behind a point or a comma;
//! and how files that the user names are read.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::Path;

/// The bytes of a file, of which there may be `most`. Anything else, such as a pipe that nobody writes to, might never end and is refused
/// before it is opened.
pub(crate) fn regular_bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::other("this is no file"));
    }
    let mut bytes = Vec::new();
    File::open(path)?
        .take(most.saturating_add(1))
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(io::Error::other(format!("it is longer than {most} bytes")));
    }
    Ok(bytes)
}

/// Reads a regular file of text in UTF-8, of at most so many bytes.
pub(crate) fn regular_text(path: &Path, most: u64) -> io::Result<String> {
    String::from_utf8(regular_bytes(path, most)?)
        .map_err(|_| io::Error::other("this is no text in UTF-8"))
}

/// What stands between semicolons, else between commas or tabs, else between blanks; units stay with their names.
pub(crate) fn cells(line: &str) -> Vec<String> {
    let separator = [';', ',', '\t'].into_iter().find(|&c| line.contains(c));
    let Some(separator) = separator else {
        let mut cells: Vec<String> = Vec::new();
        for word in line.split_whitespace() {
            match cells.last_mut() {
                Some(name) if word.starts_with(['[', '(']) => *name = format!("{name} {word}"),
                _ => cells.push(word.to_owned()),
            }
        }
        return cells;
    };
    let clean = |cell: &str| cell.trim().trim_matches('"').trim().to_owned();
    line.split(separator).map(clean).collect()
}

/// A finite number, whose decimals may stand behind a comma.
pub(crate) fn number_of(cell: &str) -> Option<f64> {
    let value: f64 = cell.replace(',', ".").parse().ok()?;
    value.is_finite().then_some(value)
}

/// The begin of a text, for a message.
pub(crate) fn short(text: &str) -> String {
    text.chars().take(60).collect()
}
