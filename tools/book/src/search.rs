//! A page that searches the book in the browser: it carries all sections along.

use serde::Serialize;

use crate::book::Book;
use crate::links::anchor;
use crate::page::{Page, SEARCH, document};

const SCRIPT: &str = include_str!("search.js");

/// What stands under one heading.
#[derive(Serialize)]
struct Section {
    /// Where it is.
    address: String,
    chapter: String,
    heading: String,
    text: String,
}

/// The page.
pub(crate) fn page(book: &Book) -> Result<Page, String> {
    let sections = serde_json::to_string(&sections(book)).map_err(|error| error.to_string())?;
    // No browser takes it for markup.
    let sections = sections.replace('<', "\\u003c");
    let text = format!(
        "<h1>Search</h1>\n<p><label>Words <input type=\"search\" id=\"words\"></label> <output id=\"count\" role=\"status\"></output></p>\n\
         <ol id=\"found\"></ol>\n<script type=\"application/json\" id=\"sections\">{sections}</script>\n<script>\n{SCRIPT}</script>\n"
    );
    Ok(Page {
        file: SEARCH.to_owned(),
        html: document(book, None, "Search", &text),
    })
}

fn sections(book: &Book) -> Vec<Section> {
    let mut sections = Vec::new();
    for (place, chapter) in book.chapters.iter().enumerate() {
        let mut section = Section {
            address: chapter.address(place),
            chapter: chapter.title.clone(),
            heading: chapter.title.clone(),
            text: String::new(),
        };
        let mut fenced = false;
        for line in chapter.text.lines() {
            fenced ^= line.starts_with("```");
            let heading = line.trim_start_matches('#');
            let level = line.len() - heading.len();
            if fenced || level < 2 || !heading.starts_with(' ') {
                if !line.starts_with('<') {
                    section.text.push_str(line);
                    section.text.push('\n');
                }
                continue;
            }
            let heading = heading.trim().replace('`', "");
            let next = Section {
                address: format!("{}#{}", chapter.address(place), anchor(&heading)),
                chapter: chapter.title.clone(),
                heading,
                text: String::new(),
            };
            sections.push(std::mem::replace(&mut section, next));
        }
        sections.push(section);
    }
    sections
}
