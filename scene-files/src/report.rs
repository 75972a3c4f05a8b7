//! Mistakes as a report that shows their lines.

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use hangtime_dsl::TextMistake;
use std::fmt::Write as _;

/// Most mistakes that are shown.
const MOST: usize = 20;

/// Every mistake with file, line, column, the line itself and a mark below it.
pub(crate) fn report(file: &str, text: &str, mistakes: &[TextMistake]) -> String {
    let renderer = Renderer::plain();
    let mut shown = String::new();
    for mistake in mistakes.iter().take(MOST) {
        let place = place(text, mistake);
        let mut title = Level::ERROR.primary_title(&mistake.message);
        if let Some(code) = mistake.code {
            title = title.id(code);
        }
        let mark = AnnotationKind::Primary.span(place);
        let snippet = Snippet::source(text).path(file).annotation(mark);
        shown += &renderer.render(&[title.element(snippet)]);
        shown += "\n\n";
    }
    let count = mistakes.len();
    let _ = match count {
        1 => write!(shown, "{file}: 1 mistake"),
        _ => write!(shown, "{file}: {count} mistakes"),
    };
    if count > MOST {
        let _ = write!(shown, ", of which the first {MOST} are shown");
    }
    if let Some(code) = mistakes.iter().find_map(|mistake| mistake.code) {
        let _ = write!(shown, "; `hangtime explain {code}` tells more");
    }
    shown
}

/// The place of a mistake in one line: of one that spans several lines the first.
fn place(text: &str, mistake: &TextMistake) -> std::ops::Range<usize> {
    let boundary = |at: usize| {
        let at = at.min(text.len());
        (0..=at)
            .rev()
            .find(|&at| text.is_char_boundary(at))
            .unwrap_or(0)
    };
    let (start, end) = (boundary(mistake.place.start), boundary(mistake.place.end));
    let line = text[start..]
        .find('\n')
        .map_or(text.len(), |line| start + line);
    start..end.min(line).max(start)
}
