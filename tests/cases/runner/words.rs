//! Texts cut at words and marks that stand in no bracket and in no quotes.

/// Places of a text that stand in no bracket and in no quotes.
fn outside(text: &str) -> impl Iterator<Item = usize> + '_ {
    let (mut depth, mut quoted) = (0_i32, false);
    text.bytes().enumerate().filter_map(move |(at, byte)| {
        match byte {
            b'"' => quoted = !quoted,
            b'(' | b'[' | b'{' if !quoted => depth += 1,
            b')' | b']' | b'}' if !quoted => depth -= 1,
            _ => {}
        }
        (depth == 0 && !quoted).then_some(at)
    })
}

/// The two sides of the first `mark`.
pub(crate) fn split<'a>(text: &'a str, mark: &str) -> Option<(&'a str, &'a str)> {
    let at = outside(text).find(|&at| text.as_bytes()[at..].starts_with(mark.as_bytes()))?;
    Some((text[..at].trim(), text[at + mark.len()..].trim()))
}

/// The same for the last one.
pub(crate) fn split_last<'a>(text: &'a str, mark: &str) -> Option<(&'a str, &'a str)> {
    let found = outside(text).filter(|&at| text.as_bytes()[at..].starts_with(mark.as_bytes()));
    let at = found.last()?;
    Some((text[..at].trim(), text[at + mark.len()..].trim()))
}

/// All parts between such marks.
pub(crate) fn parts<'a>(mut text: &'a str, mark: &str) -> Vec<&'a str> {
    let mut parts = Vec::new();
    while let Some((part, rest)) = split(text, mark) {
        parts.push(part);
        text = rest;
    }
    parts.push(text.trim());
    parts
}

/// What stands behind a word that a text begins with.
pub(crate) fn behind<'a>(text: &'a str, word: &str) -> Option<&'a str> {
    let rest = text.strip_prefix(word)?;
    let ends = rest.is_empty() || rest.starts_with([' ', '"']);
    ends.then(|| rest.trim_start())
}

/// A quoted text at the begin, and what stands behind it.
///
/// # Errors
/// It does not begin with a quote, or that is not closed.
pub(crate) fn quoted(text: &str) -> Result<(&str, &str), String> {
    let inner = text.strip_prefix('"').and_then(|rest| rest.split_once('"'));
    let (inner, rest) = inner.ok_or_else(|| format!("`{text}` is no text in quotes"))?;
    Ok((inner, rest.trim()))
}

/// A text with single spaces between its words, so that lines of reports may break anywhere.
pub(crate) fn flat(text: &str) -> String {
    let words = text.split_whitespace().filter(|word| *word != "|");
    words.collect::<Vec<_>>().join(" ")
}
