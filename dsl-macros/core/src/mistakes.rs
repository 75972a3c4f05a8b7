//! A page about each mistake that a declaration, or the start of a simulation, can contain.

/// Codes with the pages that stand in files of their names.
macro_rules! pages {
    ($($code:literal)+) => { [$(($code, include_str!(concat!("pages/", $code, ".md")))),+] };
}

/// Codes and pages, in order.
const PAGES: [(&str, &str); 27] = pages! {
    "E01" "E02" "E03" "E04" "E05" "E06" "E07" "E08" "E09" "E10" "E11" "E12" "E13" "E14"
    "E15" "E16" "E17" "E18" "E19" "E20" "E21" "E22" "E23" "E24" "E25" "E26" "E27"
};

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
