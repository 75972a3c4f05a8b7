//! `hangtime play`: one page with the language in it, which opens from the file system and asks nobody for anything.

use std::fmt::Write as _;

use serde::Serialize;

use crate::animation;
use crate::arguments::PlayArguments;
use crate::failure::BadInput;
use crate::json::to_line;
use crate::markup::embedded;
use crate::output::OutputDirectory;
use crate::report::Report;
use crate::scene_file::{name, read_text};

/// Name of the page.
const FILE: &str = "play.html";
const TEMPLATE: &str = include_str!("page.html");

/// What a page is made of, beside its own script and style.
#[derive(Debug, Clone, Copy)]
pub struct PlayPage {
    /// The module `hangtime-play` for WebAssembly, compressed by gzip.
    pub module: &'static [u8],
    /// Scenes to choose from, as (name, text of the file).
    pub scenes: &'static [(&'static str, &'static str)],
}

#[derive(Serialize)]
struct SceneText<'a> {
    name: &'a str,
    text: &'a str,
}

/// Writes the page.
pub(crate) fn run(page: Option<PlayPage>, arguments: &PlayArguments) -> Result<Report, BadInput> {
    let page = page.ok_or_else(|| {
        BadInput::new(
            "this program was built without its page; build it with `--features play` \
             (`cargo run --release --features play -- play`)",
        )
    })?;
    let mut scenes: Vec<SceneText<'_>> = Vec::new();
    let own = match &arguments.file {
        Some(file) => Some((name(file), read_text(file)?)),
        None => None,
    };
    if let Some((name, text)) = &own {
        scenes.push(SceneText { name, text });
    }
    let shipped = page.scenes.iter();
    let shipped = shipped.filter(|(name, _)| own.as_ref().is_none_or(|(own, _)| own != name));
    scenes.extend(shipped.map(|&(name, text)| SceneText { name, text }));
    let directory = OutputDirectory::open(&arguments.out)?;
    let mut report = Report::default();
    let files = [(FILE.to_owned(), html(page.module, &scenes))];
    report.text = report.deliver(directory, &files);
    Ok(report)
}

/// The page as HTML.
fn html(module: &[u8], scenes: &[SceneText<'_>]) -> String {
    let mut html = String::with_capacity(TEMPLATE.len() + 2 * module.len());
    for (index, part) in TEMPLATE.split("{{").enumerate() {
        let (name, rest) = part.split_once("}}").unwrap_or(("", part));
        match name {
            "style" => {
                html += animation::STYLE;
                html += include_str!("page.css");
            }
            "elements" => html += animation::ELEMENTS,
            "player" => html += animation::SCRIPT,
            "scenes" => html += &embedded(&to_line(&scenes)),
            "worker" => html += include_str!("worker.js"),
            "module" => push_base64(&mut html, module),
            "equations" => html += include_str!("equations.js"),
            "plots" => html += include_str!("plots.js"),
            "script" => html += include_str!("page.js"),
            _ => debug_assert!(index == 0, "the page has no part `{name}`"),
        }
        html += rest;
    }
    html
}

/// Bytes as text, six bits a letter.
fn push_base64(text: &mut String, bytes: &[u8]) {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for group in bytes.chunks(3) {
        let byte = |k: usize| u32::from(group.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * k)) as usize & 63];
            let _ = text.write_char(if k <= group.len() {
                letter as char
            } else {
                '='
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{SceneText, TEMPLATE, html, push_base64};

    #[test]
    fn base64_of_the_standard_is_met() {
        // Test vectors of RFC 4648.
        for (bytes, wanted) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            let mut text = String::new();
            push_base64(&mut text, bytes.as_bytes());
            assert_eq!(text, wanted);
        }
    }

    #[test]
    fn page_has_all_parts_and_loads_nothing() {
        let scene = SceneText {
            name: "x",
            text: "</script> {{style}}",
        };
        let page = html(b"module", &[scene]);
        assert_eq!(
            page.matches("</script>").count(),
            TEMPLATE.matches("</script>").count()
        );
        for part in [
            "bW9kdWxl",
            "\\u003c/script> {{style}}",
            "playFrames",
            "id=\"stage\"",
        ] {
            assert!(page.contains(part), "{part}");
        }
        for loading in ["src=", "@import", "url(", "http:", "https:"] {
            let page = page.replace("http://www.w3.org/", "");
            assert!(!page.contains(loading), "{loading}");
        }
    }
}
