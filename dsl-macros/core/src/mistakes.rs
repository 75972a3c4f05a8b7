//! A page about each mistake that a declaration, or the start of a simulation, can contain.

/// Codes and pages, in order.
const PAGES: [(&str, &str); 27] = [
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
    ("E21", include_str!("pages/E21.md")),
    ("E22", include_str!("pages/E22.md")),
    ("E23", include_str!("pages/E23.md")),
    ("E24", include_str!("pages/E24.md")),
    ("E25", include_str!("pages/E25.md")),
    ("E26", include_str!("pages/E26.md")),
    ("E27", include_str!("pages/E27.md")),
];

/// The name of the page about mistakes that have no code, and its text.
const SYNTAX: (&str, &str) = ("syntax", include_str!("pages/syntax.md"));

/// The name under which the page about a mistake is found: its code, or `syntax` where it has none.
#[must_use]
pub fn page_name(code: Option<&'static str>) -> &'static str {
    code.unwrap_or(SYNTAX.0)
}

/// The codes that have a page, in order.
pub fn mistake_codes() -> impl Iterator<Item = &'static str> {
    PAGES.iter().map(|&(code, _)| code)
}

/// The page about one mistake, in Markdown; `None` if there is no such code. Case and zeros before the
/// number are ignored: `E07`, `e07` and `E7` are the same. `syntax` is the page about mistakes without a code.
///
/// ```
/// let page = hangtime_dsl::explanation("e3");
/// assert!(page.is_some_and(|page| page.contains("units differ")));
/// assert_eq!(page, hangtime_dsl::explanation("E03"));
/// assert!(hangtime_dsl::explanation("E99").is_none());
/// ```
#[must_use]
pub fn explanation(code: &str) -> Option<&'static str> {
    if code.trim().eq_ignore_ascii_case(SYNTAX.0) {
        return Some(SYNTAX.1);
    }
    let digits = code.trim().strip_prefix(['E', 'e'])?;
    if !digits.bytes().all(|digit| digit.is_ascii_digit()) {
        return None;
    }
    let number: usize = digits.parse().ok()?;
    PAGES.get(number.checked_sub(1)?).map(|&(_, page)| page)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_stand_at_the_place_of_their_number() {
        for (i, code) in mistake_codes().enumerate() {
            assert_eq!(code, format!("E{:02}", i + 1));
            let page = explanation(code).expect("a page");
            assert!(page.starts_with(&format!("# {code}: ")));
            assert_eq!(explanation(&format!(" e{}", i + 1)), Some(page));
        }
        for none in [
            "",
            "E",
            "E0",
            "E+7",
            "7",
            "E28",
            "E7x",
            "E99999999999999999999",
        ] {
            assert_eq!(explanation(none), None, "{none}");
        }
    }
}
