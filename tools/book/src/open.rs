//! Links that open a scene in the page of `hangtime play`: the text is in the link.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD as BASE64_URL;
use flate2::Compression;
use flate2::write::DeflateEncoder;

use crate::highlight::escape;

/// Where the page is, from the pages of the book.
pub const PAGE: &str = "play.html";

/// What stands behind the `#`: name and text as JSON, compressed, six bits a letter. The page reads it (`links.js` of it).
#[must_use]
pub fn fragment(name: &str, text: &str) -> String {
    let content = serde_json::json!({ "name": name, "text": text, "values": {} }).to_string();
    let mut packed = DeflateEncoder::new(Vec::new(), Compression::best());
    // Writing to memory does not fail.
    let _ = packed.write_all(content.as_bytes());
    let packed = packed.finish().unwrap_or_default();
    format!("scene={}", BASE64_URL.encode(&packed))
}

/// A link with these words.
pub(crate) fn anchor(name: &str, text: &str, words: &str) -> String {
    let name = name.strip_suffix(".hang").unwrap_or(name);
    format!(
        "<a class=\"open\" href=\"{PAGE}#{}\">{}</a>",
        fragment(name, text),
        escape(words)
    )
}

/// HTML in which such links are their words.
pub(crate) fn without(html: &str) -> String {
    let mut parts = html.split("<a class=\"open\" ");
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let words = part
            .split_once('>')
            .and_then(|(_, rest)| rest.split_once("</a>"));
        let (words, rest) = words.unwrap_or(("", part));
        plain.push_str(words);
        plain.push_str(rest);
    }
    plain
}
