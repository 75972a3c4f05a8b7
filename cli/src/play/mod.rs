//! `hangtime play`: one page with the language in it, which opens from the file system and asks nobody for anything.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;

use serde::Serialize;

use crate::Scene;
use crate::animation;
use crate::arguments::PlayArguments;
use crate::authoring::TEMPLATE as TEMPLATE_SCENE;
use crate::failure::BadInput;
use crate::json::to_line;
use crate::markup::embedded;
use crate::output::OutputDirectory;
use crate::report::Report;
use crate::scene_file::{name, read_text};

/// Name of the page.
const FILE: &str = "play.html";
const TEMPLATE: &str = include_str!("page.html");
/// The scripts, by the names of their places in the page; each may use those before it.
const SCRIPTS: [(&str, &str); 9] = [
    ("equations", include_str!("equations.js")),
    ("plots", include_str!("plots.js")),
    ("markdown", include_str!("markdown.js")),
    ("store", include_str!("store.js")),
    ("links", include_str!("links.js")),
    ("export", include_str!("export.js")),
    ("editor", include_str!("editor.js")),
    ("reading", include_str!("reading.js")),
    ("script", include_str!("page.js")),
];

/// What a page is made of, beside its own script and style.
#[derive(Debug, Clone, Copy)]
pub struct PlayPage {
    /// The module `hangtime-play` for WebAssembly, compressed by gzip.
    pub module: &'static [u8],
    /// Texts of scenes that are in no list, as (name, text of the file).
    pub scenes: &'static [(&'static str, &'static str)],
    /// What is to be read beside the scene, in the order of reading.
    pub chapters: &'static [PlayChapter],
    /// Compresses by gzip; what is shown only when asked for is packed.
    pub pack: fn(&str) -> Vec<u8>,
}

/// A chapter of a book about the language.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct PlayChapter {
    /// Name of its file, `NAME.md`, by which others link to it.
    pub file: &'static str,
    /// Its title.
    pub title: &'static str,
    /// Its Markdown.
    pub text: &'static str,
}

/// A scene to choose from, as `hangtime list` tells of it.
#[derive(Serialize)]
struct SceneText<'a> {
    name: &'a str,
    text: &'a str,
    title: &'a str,
    about: String,
    group: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    question: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    answer: Option<&'a str>,
    #[serde(skip)]
    picture: &'a str,
}

impl<'a> SceneText<'a> {
    /// A text of which nothing else is known.
    fn bare(name: &'a str, text: &'a str, group: &'a str) -> Self {
        Self {
            name,
            text,
            title: "",
            about: String::new(),
            group,
            question: None,
            answer: None,
            picture: "",
        }
    }

    /// A listed scene whose text is known.
    fn listed(scene: &Scene) -> Option<Self> {
        Some(Self {
            title: scene.title,
            about: scene.about(),
            question: scene.question.map(|question| question.asked),
            answer: scene.question.map(|question| question.answer),
            picture: scene.picture,
            ..Self::bare(scene.name, scene.unread.or(scene.source)?, scene.group)
        })
    }
}

/// Group of scenes that are in no list.
const OTHERS: &str = "other forms";
/// Group of the scene whose file the command was given.
const GIVEN: &str = "from a file";

/// Writes the page.
pub(crate) fn run(
    scenes: &'static [Scene],
    page: Option<PlayPage>,
    arguments: &PlayArguments,
) -> Result<Report, BadInput> {
    let page = page.ok_or_else(|| {
        BadInput::new(
            "this program was built without its page; build it with `--features play` \
             (`cargo run --release --features play -- play`)",
        )
    })?;
    let own = match &arguments.file {
        Some(file) => Some((name(file), read_text(file)?)),
        None => None,
    };
    let mut shown: Vec<SceneText<'_>> = scenes.iter().filter_map(SceneText::listed).collect();
    for &(name, text) in page.scenes {
        if !shown.iter().any(|listed| listed.text == text) {
            shown.push(SceneText::bare(name, text, OTHERS));
        }
    }
    if let Some((name, text)) = &own {
        shown.retain(|listed| listed.name != name);
        shown.insert(0, SceneText::bare(name, text, GIVEN));
    }
    let directory = OutputDirectory::open(&arguments.out)?;
    let mut report = Report::default();
    let files = [(FILE.to_owned(), html(&page, &shown))];
    report.text = report.deliver(directory, &files);
    Ok(report)
}

/// The page as HTML.
fn html(page: &PlayPage, scenes: &[SceneText<'_>]) -> String {
    let mut html = String::with_capacity(TEMPLATE.len() + 2 * page.module.len());
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
            "chapters" => html += &BASE64.encode((page.pack)(&to_line(&page.chapters))),
            "pictures" => {
                let pictures: Vec<_> = scenes.iter().map(|scene| scene.picture).collect();
                html += &BASE64.encode((page.pack)(&to_line(&pictures)));
            }
            "template" => html += &embedded(&to_line(&TEMPLATE_SCENE)),
            "words" => html += &embedded(&to_line(&hangtime_dsl::words())),
            "worker" => html += include_str!("worker.js"),
            "module" => html += &BASE64.encode(page.module),
            _ => match SCRIPTS.iter().find(|(script, _)| *script == name) {
                Some((_, text)) => html += text,
                None => debug_assert!(index == 0, "the page has no part `{name}`"),
            },
        }
        html += rest;
    }
    html
}

#[cfg(test)]
mod tests {
    use super::{PlayChapter, PlayPage, SCRIPTS, SceneText, TEMPLATE, html};

    #[test]
    fn page_has_all_parts_and_loads_nothing() {
        let scene = SceneText::bare("x", "</script> {{style}}", "");
        let chapter = PlayChapter {
            file: "a.md",
            title: "A",
            text: "# A\n</script>",
        };
        let page = PlayPage {
            module: b"module",
            scenes: &[],
            chapters: Box::leak(Box::new([chapter])),
            pack: |text| text.into(),
        };
        let page = html(&page, &[scene]);
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
        for (name, text) in SCRIPTS {
            assert!(page.contains(text), "{name}");
        }
        for loading in ["src=", "@import", "url(", "http:", "https:"] {
            let page = page.replace("http://www.w3.org/", "");
            assert!(!page.contains(loading), "{loading}");
        }
    }
}
