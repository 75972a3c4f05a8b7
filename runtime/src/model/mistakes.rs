//! A page about each mistake that a declaration, or the start of a simulation, can contain.

/// Codes and pages, in order.
const PAGES: [(&str, &str); 20] = [
    ("E01", include_str!("pages/E01.md")),
    ("E02", include_str!("pages/E02.md")),
    ("E03", include_str!("pages/E03.md")),
    ("E04", include_str!("pages/E04.md")),
    ("E05", include_str!("pages/E05.md")),
    ("E06", include_str!("pages/E06.md")),
    ("E07", include_str!("pages/E07.md")),
    ("E08", include_str!("pages/E08.md")),
    ("E09", include_str!("pages/E09.md")),
    ("E10", include_str!("pages/E10.md")),
    ("E11", include_str!("pages/E11.md")),
    ("E12", include_str!("pages/E12.md")),
    ("E13", include_str!("pages/E13.md")),
    ("E14", include_str!("pages/E14.md")),
    ("E15", include_str!("pages/E15.md")),
    ("E16", include_str!("pages/E16.md")),
    ("E17", include_str!("pages/E17.md")),
    ("E18", include_str!("pages/E18.md")),
    ("E19", include_str!("pages/E19.md")),
    ("E20", include_str!("pages/E20.md")),
];

/// The codes that have a page, in order.
pub fn mistake_codes() -> impl Iterator<Item = &'static str> {
    PAGES.iter().map(|&(code, _)| code)
}

/// The page about one mistake (`"E07"`), in Markdown; `None` if there is no such code. Case is ignored.
///
/// ```
/// assert!(hangtime::model::explanation("e03").is_some_and(|page| page.contains("units differ")));
/// assert!(hangtime::model::explanation("E99").is_none());
/// ```
#[must_use]
pub fn explanation(code: &str) -> Option<&'static str> {
    PAGES
        .iter()
        .find(|(known, _)| known.eq_ignore_ascii_case(code.trim()))
        .map(|&(_, page)| page)
}
