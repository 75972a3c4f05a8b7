//! Chapters as HTML pages.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use pulldown_cmark::{
    CodeBlockKind, CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd, html,
};

use crate::book::{Book, Chapter};
use crate::formula::mathml;
use crate::highlight::{console, escape, scene};
use crate::links::{anchor, headings};
use crate::open;

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

/// Name of the page that searches the book.
pub(crate) const SEARCH: &str = "search.html";

/// The page of a chapter.
///
/// # Errors
/// A formula that is not understood, and where.
pub(crate) fn page(book: &Book, place: usize, opens: bool) -> Result<Page, String> {
    let chapter = &book.chapters[place];
    let body = body(book, chapter, opens).map_err(|said| format!("{}: {said}", chapter.file))?;
    let neighbour = |at: Option<usize>, rel: &str, arrow: &str| {
        let Some((at, next)) = at.and_then(|at| Some((at, book.chapters.get(at)?))) else {
            return String::new();
        };
        let (address, title) = (next.address(at), escape(&next.title));
        format!("<a rel=\"{rel}\" href=\"{address}\"><span>{arrow}</span> {title}</a>")
    };
    let previous = neighbour(place.checked_sub(1), "prev", "\u{2190}");
    let next = neighbour(Some(place + 1), "next", "\u{2192}");
    let turn = format!(
        "<nav class=\"turn\" aria-label=\"Pages before and after\">{previous}{next}</nav>\n"
    );
    Ok(Page {
        file: chapter.address(place),
        html: document(book, Some(place), &chapter.title, &(body + &turn)),
    })
}

/// A whole document: the contents, in which the present chapter is marked, and a text.
pub(crate) fn document(book: &Book, place: Option<usize>, title: &str, text: &str) -> String {
    let title = escape(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title} - hangtime</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<a class=\"skip\" href=\"#text\">To the text</a>\n\
         <details class=\"contents\" id=\"contents\"><summary>Contents</summary>\n{}</details>\n\
         <main id=\"text\" tabindex=\"-1\">\n{text}</main>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        contents(book, place),
    )
}

/// The list of chapters; under the present one its sections.
fn contents(book: &Book, place: Option<usize>) -> String {
    let mut list = format!(
        "<form action=\"{}\" role=\"search\"><input type=\"search\" name=\"q\" id=\"asked\" placeholder=\"search\" aria-label=\"search the book\"></form>\n\
         <nav aria-label=\"Chapters\"><ol>\n",
        SEARCH
    );
    for (at, chapter) in book.chapters.iter().enumerate() {
        let (address, title) = (chapter.address(at), escape(&chapter.title));
        let here = if Some(at) == place {
            " aria-current=\"page\""
        } else {
            ""
        };
        // Writing to a string cannot fail.
        let _ = write!(list, "<li><a href=\"{address}\"{here}>{title}</a>");
        if Some(at) == place {
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

/// The Markdown of a chapter as HTML: headings with anchors, scenes in colours, formulas set, links to pages.
fn body(book: &Book, chapter: &Chapter, opens: bool) -> Result<String, String> {
    let mut events = Vec::new();
    let mut scenes = Scenes {
        opens,
        files: BTreeMap::new(),
    };
    let options = Options::ENABLE_TABLES | Options::ENABLE_MATH;
    let mut parser = Parser::new_ext(&chapter.text, options);
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
                events.push(Event::Html(scenes.block(&info, &text)?.into()));
            }
            Event::InlineMath(formula) => {
                events.push(Event::InlineHtml(mathml(&formula, false)?.into()));
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
    Ok(if opens { text } else { open::without(&text) })
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

/// The scenes of a chapter so far.
struct Scenes {
    /// Whether they can be opened.
    opens: bool,
    /// The files, as they are by now.
    files: BTreeMap<String, String>,
}

impl Scenes {
    /// A fenced block.
    fn block(&mut self, info: &str, text: &str) -> Result<String, String> {
        let words: Vec<&str> = info.split(',').collect();
        let language = words[0];
        let shown = match language {
            "math" => {
                return Ok(format!(
                    "<div class=\"table\" tabindex=\"0\">{}</div>\n",
                    mathml(text, true)?
                ));
            }
            "hang" | "rust" => scene(text),
            "console" => console(text),
            _ => escape(text),
        };
        let caption = words.get(1).map_or(String::new(), |file| {
            let link = match language {
                "hang" if self.opens => self.link(file, text, words.get(2) == Some(&"more")),
                _ => String::new(),
            };
            format!("<figcaption>{}{link}</figcaption>", escape(file))
        });
        Ok(format!(
            "<figure class=\"code {language}\">{caption}<pre tabindex=\"0\"><code>{shown}</code></pre></figure>\n"
        ))
    }

    /// A link that opens the file, as it is with this block.
    fn link(&mut self, file: &str, text: &str, more: bool) -> String {
        let whole = self.files.entry(file.to_owned()).or_default();
        if !more {
            whole.clear();
        }
        whole.push_str(text);
        open::anchor(file, whole, "open in the page")
    }
}
