//! Where links lead.

use pulldown_cmark::{Event, HeadingLevel, Parser, Tag, TagEnd};

use crate::book::Book;

/// The targets of all links and images of a chapter.
fn targets(markdown: &str) -> Vec<String> {
    Parser::new(markdown)
        .filter_map(|event| match event {
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                Some(dest_url.into_string())
            }
            _ => None,
        })
        .collect()
}

/// The anchor of a heading: its words in lower case, joined by `-`, as mdBook makes them.
pub(crate) fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter_map(|character| match character {
        ' ' => Some('-'),
        '-' | '_' => Some(character),
        _ if character.is_alphanumeric() => Some(character.to_ascii_lowercase()),
        _ => None,
    });
    kept.collect()
}

/// Levels and texts of all headings.
pub(crate) fn headings(markdown: &str) -> Vec<(HeadingLevel, String)> {
    let mut headings = Vec::new();
    let mut heading: Option<(HeadingLevel, String)> = None;
    for event in Parser::new(markdown) {
        match event {
            Event::Start(Tag::Heading { level, .. }) => heading = Some((level, String::new())),
            Event::Text(text) | Event::Code(text) => {
                if let Some((_, heading)) = &mut heading {
                    heading.push_str(&text);
                }
            }
            Event::End(TagEnd::Heading(_)) => headings.extend(heading.take()),
            _ => {}
        }
    }
    headings
}

/// Links and images that lead nowhere, each as `FILE: TARGET`.
///
/// A target is a chapter, a heading in one (`contacts.md#friction`), or a file in `figures/` for which `figure` says
/// that it is made. Anything else counts as dead: pages need no network, so nothing outside is linked.
#[must_use]
pub fn dead_links(book: &Book, figure: impl Fn(&str) -> bool) -> Vec<String> {
    let alive = |from: &str, target: &str| {
        if let Some(name) = target.strip_prefix("figures/") {
            return figure(name);
        }
        let (file, place) = target
            .split_once('#')
            .map_or((target, None), |(file, place)| (file, Some(place)));
        let file = if file.is_empty() { from } else { file };
        let chapter = book.chapters.iter().find(|chapter| chapter.file == file);
        chapter.is_some_and(|chapter| {
            let anchors = headings(&chapter.text);
            place.is_none_or(|place| anchors.iter().any(|(_, heading)| anchor(heading) == place))
        })
    };
    let mut dead = Vec::new();
    for chapter in &book.chapters {
        let targets = targets(&chapter.text).into_iter();
        let lost = targets.filter(|target| !alive(&chapter.file, target));
        dead.extend(lost.map(|target| format!("{}: {target}", chapter.file)));
    }
    dead
}
