//! A page about each mistake that the modelling language reports.

/// The codes that have a page, in order.
pub const CODES: &[&str] = &[];

/// The page about one mistake, in Markdown; `None` if the code is not known. Case is ignored.
#[must_use]
pub fn explanation(code: &str) -> Option<&'static str> {
    let _ = code;
    None
}
