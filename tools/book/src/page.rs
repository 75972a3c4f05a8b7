//! Chapters as HTML pages.

use std::fmt::Write as _;

use pulldown_cmark::{
    CodeBlockKind, CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd, html,
};

use crate::book::{Book, Chapter};
use crate::highlight::{console, escape, scene};
use crate::links::{anchor, headings};

/// One page.
#[derive(Debug, Clone)]
pub struct Page {
    /// Name of its file.
    pub file: String,
    /// The whole document.
    pub html: String,
}

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The chapters as pages that need nothing but each other and the folder `figures`.
#[must_use]
pub fn pages(book: &Book) -> Vec<Page> {
    let places = 0..book.chapters.len();
    places.map(|place| page(book, place)).collect()
}

fn page(book: &Book, place: usize) -> Page {
    let chapter = &book.chapters[place];
    let neighbour = |at: Option<usize>, rel: &str, arrow: &str| {
        let Some((at, next)) = at.and_then(|at| Some((at, book.chapters.get(at)?))) else {
            return String::new();
        };
        let (address, title) = (next.address(at), escape(&next.title));
        format!("<a rel=\"{rel}\" href=\"{address}\"><span>{arrow}</span> {title}</a>")
    };
    let previous = neighbour(place.checked_sub(1), "prev", "\u{2190}");
    let next = neighbour(Some(place + 1), "next", "\u{2192}");
    let title = escape(&chapter.title);
    let html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title} - hangtime</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<a class=\"skip\" href=\"#text\">To the text</a>\n\
         <details class=\"contents\" id=\"contents\"><summary>Contents</summary>\n{}</details>\n\
         <main id=\"text\" tabindex=\"-1\">\n{}<nav class=\"turn\" aria-label=\"Pages before and after\">{previous}{next}</nav>\n\
         </main>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        contents(book, place),
        body(book, chapter),
    );
    Page {
        file: chapter.address(place),
        html,
    }
}

/// The list of chapters; under the present one its sections.
fn contents(book: &Book, place: usize) -> String {
    let mut list = String::from("<nav aria-label=\"Chapters\"><ol>\n");
    for (at, chapter) in book.chapters.iter().enumerate() {
        let (address, title) = (chapter.address(at), escape(&chapter.title));
        let here = if at == place {
            " aria-current=\"page\""
        } else {
            ""
        };
        // Writing to a string cannot fail.
        let _ = write!(list, "<li><a href=\"{address}\"{here}>{title}</a>");
        if at == place {
            list.push_str("<ul>");
            let headings = headings(&chapter.text).into_iter();
            for (_, section) in headings.filter(|(level, _)| *level == HeadingLevel::H2) {
                let _ = write!(
                    list,
                    "<li><a href=\"#{}\">{}</a></li>",
                    anchor(&section),
                    escape(&section)
                );
            }
            list.push_str("</ul>");
        }
        list.push_str("</li>\n");
    }
    list + "</ol></nav>\n"
}

/// The Markdown of a chapter as HTML: headings with anchors, scenes in colours, links to pages.
fn body(book: &Book, chapter: &Chapter) -> String {
    let mut events = Vec::new();
    let mut parser = Parser::new_ext(&chapter.text, Options::ENABLE_TABLES);
    while let Some(event) = parser.next() {
        match event {
            Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(info))) => {
                let mut text = String::new();
                for inner in parser.by_ref() {
                    match inner {
                        Event::Text(line) => text.push_str(&line),
                        _ => break,
                    }
                }
                events.push(Event::Html(block(&info, &text).into()));
            }
            Event::Start(Tag::Heading { level, .. }) => {
                let inner: Vec<Event> = parser
                    .by_ref()
                    .take_while(|event| !matches!(event, Event::End(TagEnd::Heading(_))))
                    .collect();
                events.push(Event::Html(heading(level, inner).into()));
            }
            Event::Start(Tag::Link {
                link_type,
                dest_url,
                title,
                id,
            }) => {
                let dest_url = page_of(book, dest_url);
                events.push(Event::Start(Tag::Link {
                    link_type,
                    dest_url,
                    title,
                    id,
                }));
            }
            Event::Start(Tag::Table(alignments)) => {
                events.push(Event::Html("<div class=\"table\" tabindex=\"0\">".into()));
                events.push(Event::Start(Tag::Table(alignments)));
            }
            Event::End(TagEnd::Table) => {
                events.push(Event::End(TagEnd::Table));
                events.push(Event::Html("</div>".into()));
            }
            other => events.push(other),
        }
    }
    let mut text = String::new();
    html::push_html(&mut text, events.into_iter());
    text
}

/// A link to a chapter leads to its page.
fn page_of<'a>(book: &Book, target: CowStr<'a>) -> CowStr<'a> {
    let (file, place) = target.split_at(target.find('#').unwrap_or(target.len()));
    let mut chapters = book.chapters.iter();
    match chapters.position(|chapter| chapter.file == file) {
        Some(at) => (book.chapters[at].address(at) + place).into(),
        None => target,
    }
}

fn heading(level: HeadingLevel, inner: Vec<Event<'_>>) -> String {
    let mut text = String::new();
    for event in &inner {
        if let Event::Text(part) | Event::Code(part) = event {
            text.push_str(part);
        }
    }
    let mut shown = String::new();
    html::push_html(&mut shown, inner.into_iter());
    let id = anchor(&text);
    format!("<{level} id=\"{id}\"><a class=\"anchor\" href=\"#{id}\">{shown}</a></{level}>\n")
}

fn block(info: &str, text: &str) -> String {
    let mut words = info.split(',');
    let (language, file) = (words.next().unwrap_or(""), words.next());
    let shown = match language {
        "hang" | "rust" => scene(text),
        "console" => console(text),
        _ => escape(text),
    };
    let caption = file.map_or(String::new(), |file| {
        format!("<figcaption>{}</figcaption>", escape(file))
    });
    format!(
        "<figure class=\"code {language}\">{caption}<pre tabindex=\"0\"><code>{shown}</code></pre></figure>\n"
    )
}
