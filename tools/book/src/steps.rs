//! What a reader of a chapter does: write scenes, run commands.

use pulldown_cmark::{CodeBlockKind, Event, Parser, Tag, TagEnd};

use crate::transcript;

/// How a scene in the book is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A whole scene.
    Whole,
    /// Statements at the end of the file so far.
    More,
    /// A whole scene that is refused.
    Mistaken,
}

/// A scene file.
#[derive(Debug, Clone)]
pub struct SceneText {
    /// Name of the file, `NAME.hang`.
    pub file: String,
    /// What the block holds.
    pub text: String,
    /// How it is meant.
    pub kind: Kind,
}

/// A command, and what the book says that it prints.
#[derive(Debug, Clone)]
pub struct Run {
    /// The arguments behind `hangtime`.
    pub arguments: Vec<String>,
    /// Lines of the output; `...` stands for any number of lines.
    pub shown: Vec<String>,
}

impl Run {
    /// Where an output differs from what is shown: `None` if it does not.
    ///
    /// Lines are compared word by word, blank ones are left out. Words that are numbers may differ by rounding,
    /// 1e-6 of their value (or 1e-8, where they vanish).
    #[must_use]
    pub fn difference(&self, printed: &str) -> Option<String> {
        transcript::difference(&self.shown, printed)
    }
}

/// A part of a program that is compiled elsewhere.
#[derive(Debug, Clone)]
pub struct Excerpt {
    /// Its file, from the root of the repository.
    pub file: String,
    /// The lines.
    pub text: String,
}

/// Measurements in a file beside the scenes.
#[derive(Debug, Clone)]
pub struct Data {
    /// Name of the file.
    pub file: String,
    /// Its lines.
    pub text: String,
}

/// One thing to do.
#[derive(Debug, Clone)]
pub enum Step {
    /// Write a scene.
    Scene(SceneText),
    /// Write measurements.
    Data(Data),
    /// Run a command.
    Run(Run),
    /// Look at a program.
    Excerpt(Excerpt),
}

/// The steps of a chapter in their order.
pub(crate) fn of(markdown: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut block: Option<(String, String)> = None;
    for event in Parser::new(markdown) {
        match event {
            Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(info))) => {
                block = Some((info.into_string(), String::new()));
            }
            Event::Text(text) => {
                if let Some((_, lines)) = &mut block {
                    lines.push_str(&text);
                }
            }
            Event::End(TagEnd::CodeBlock) => {
                if let Some((info, text)) = block.take() {
                    steps.extend(of_block(&info, text));
                }
            }
            _ => {}
        }
    }
    steps
}

fn of_block(info: &str, text: String) -> Vec<Step> {
    let words: Vec<&str> = info.split(',').collect();
    let scene = |kind| {
        vec![Step::Scene(SceneText {
            file: words[1].to_owned(),
            text: text.clone(),
            kind,
        })]
    };
    match words[..] {
        ["hang", _] => scene(Kind::Whole),
        ["hang", _, "more"] => scene(Kind::More),
        ["hang", _, "mistaken"] => scene(Kind::Mistaken),
        ["csv", file] => vec![Step::Data(Data {
            file: file.to_owned(),
            text,
        })],
        ["console"] => runs(&text),
        ["rust", file] => vec![Step::Excerpt(Excerpt {
            file: file.to_owned(),
            text,
        })],
        _ => Vec::new(),
    }
}

/// The commands of one block, each with the lines up to the next one.
fn runs(block: &str) -> Vec<Step> {
    let mut runs: Vec<Run> = Vec::new();
    for line in block.lines() {
        match (line.strip_prefix("$ hangtime"), runs.last_mut()) {
            (Some(arguments), _) => runs.push(Run {
                arguments: arguments.split_whitespace().map(str::to_owned).collect(),
                shown: Vec::new(),
            }),
            (None, Some(command)) => command.shown.push(line.to_owned()),
            (None, None) => {}
        }
    }
    runs.into_iter().map(Step::Run).collect()
}
