//! Mistakes as a report that shows their lines.

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use hangtime_dsl::{TextMistake, in_used};
use std::fmt::Write as _;
use std::path::Path;

/// Most mistakes that are shown.
const MOST: usize = 20;

/// Every mistake and every warning with file, line, column, the line itself, a mark below it, and the page that tells
/// more; empty if there is none.
pub(crate) fn report(file: &str, text: &str, mistakes: &[TextMistake]) -> String {
    let renderer = Renderer::plain();
    let mut shown = String::new();
    if mistakes.is_empty() {
        return shown;
    }
    for mistake in mistakes.iter().take(MOST) {
        let (used, text, within) = in_used(text, &mistake.place);
        let file = match used {
            Some(used) => Path::new(file).with_file_name(used).display().to_string(),
            None => file.to_owned(),
        };
        let place = place(text, &within);
        let level = if mistake.warning {
            Level::WARNING
        } else {
            Level::ERROR
        };
        let mut title = level.primary_title(&mistake.message);
        if let Some(code) = mistake.code {
            title = title.id(code);
        }
        let mark = AnnotationKind::Primary.span(place);
        let snippet = Snippet::source(text).path(file).annotation(mark);
        let page = hangtime_dsl::page_name(mistake.code);
        let help = Level::HELP.message(format!("`hangtime explain {page}` tells more"));
        let group = title.element(snippet).element(help);
        shown += &renderer.render(&[group]);
        shown += "\n\n";
    }
    let warnings = mistakes.iter().filter(|mistake| mistake.warning).count();
    let counts = [
        counted(mistakes.len() - warnings, "mistake"),
        counted(warnings, "warning"),
    ];
    let counts: Vec<String> = counts.into_iter().flatten().collect();
    let _ = write!(shown, "{file}: {}", counts.join(", "));
    if mistakes.len() > MOST {
        let _ = write!(shown, ", of which the first {MOST} are shown");
    }
    shown
}

/// `1 mistake`, `2 mistakes`; nothing for none.
fn counted(count: usize, what: &str) -> Option<String> {
    match count {
        0 => None,
        1 => Some(format!("1 {what}")),
        _ => Some(format!("{count} {what}s")),
    }
}

/// The place of a mistake in one line: of one that spans several lines the first.
fn place(text: &str, place: &std::ops::Range<usize>) -> std::ops::Range<usize> {
    let boundary = |at: usize| {
        let at = at.min(text.len());
        (0..=at)
            .rev()
            .find(|&at| text.is_char_boundary(at))
            .unwrap_or(0)
    };
    let (start, end) = (boundary(place.start), boundary(place.end));
    let line = text[start..]
        .find('\n')
        .map_or(text.len(), |line| start + line);
    start..end.min(line).max(start)
}
