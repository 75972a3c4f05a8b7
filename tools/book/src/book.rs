//! The chapters of a book, in the order of its summary.

use std::fs;
use std::io::{Error, ErrorKind, Result};
use std::path::Path;

use pulldown_cmark::{Event, Parser, Tag, TagEnd};

use crate::steps::{self, Step};
use crate::{gallery, language, reference};

/// One chapter.
#[derive(Debug, Clone)]
pub struct Chapter {
    /// Name of its file in the folder of the book, `NAME.md`.
    pub file: String,
    /// Its name in the summary.
    pub title: String,
    /// Its Markdown.
    pub text: String,
}

impl Chapter {
    /// Scenes, commands and excerpts of programs, in their order.
    #[must_use]
    pub fn steps(&self) -> Vec<Step> {
        steps::of(&self.text)
    }

    /// Whether the code writes it.
    #[must_use]
    pub fn is_generated(&self) -> bool {
        language::GENERATED.contains(&self.file.as_str())
    }

    /// The address of its page, `NAME.html`; the first chapter is `index.html`.
    pub(crate) fn address(&self, place: usize) -> String {
        match place {
            0 => "index.html".to_owned(),
            _ => self.file.replace(".md", ".html"),
        }
    }
}

/// A book: its chapters.
#[derive(Debug, Clone)]
pub struct Book {
    /// In the order of the summary.
    pub chapters: Vec<Chapter>,
}

impl Book {
    /// Reads `SUMMARY.md` in a folder, and the chapters that it links to; those that the code writes are no files of the folder. `root` is
    /// that of the repository.
    ///
    /// # Errors
    /// A file that cannot be read, named in the message; a summary without chapters; what lacks documentation in the code.
    pub fn read(folder: &Path, root: &Path) -> Result<Self> {
        let read = |file: &str| {
            fs::read_to_string(folder.join(file))
                .map_err(|error| Error::new(error.kind(), format!("{file}: {error}")))
        };
        let mut chapters = Vec::new();
        for (file, title) in listed(&read("SUMMARY.md")?) {
            let text = match reference::chapter(&file, root)? {
                Some(text) => text,
                None if file == gallery::FILE => gallery::chapter(),
                None => read(&file)?,
            };
            chapters.push(Chapter { file, title, text });
        }
        if chapters.is_empty() {
            return Err(Error::new(
                ErrorKind::InvalidData,
                "SUMMARY.md: no links to chapters",
            ));
        }
        Ok(Self { chapters })
    }
}

/// Files and titles of the links in a summary.
fn listed(summary: &str) -> Vec<(String, String)> {
    let mut chapters: Vec<(String, String)> = Vec::new();
    let mut inside = false;
    for event in Parser::new(summary) {
        match event {
            Event::Start(Tag::Link { dest_url, .. }) => {
                chapters.push((dest_url.into_string(), String::new()));
                inside = true;
            }
            Event::End(TagEnd::Link) => inside = false,
            Event::Text(text) | Event::Code(text) if inside => {
                if let Some((_, title)) = chapters.last_mut() {
                    title.push_str(&text);
                }
            }
            _ => {}
        }
    }
    chapters
}
