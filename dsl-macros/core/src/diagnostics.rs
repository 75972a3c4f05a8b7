//! The collector of mistakes: every one found is reported, at the user's token.

use proc_macro2::{Delimiter, Group, Ident, Literal, Punct, Spacing, Span, TokenStream, TokenTree};
use quote::quote;
use std::collections::{BTreeMap, HashSet};

/// Where a piece of the declaration begins and ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) start: Span,
    pub(crate) end: Span,
}

impl Place {
    pub(crate) fn at(span: Span) -> Self {
        Self {
            start: span,
            end: span,
        }
    }

    /// Whether it is the same place, as spans are shown: they are compared in no other way on stable Rust.
    fn is_that(self, other: Self) -> bool {
        let shown = |place: Self| format!("{:?}{:?}", place.start, place.end);
        shown(self) == shown(other)
    }

    /// From the start of this place to the end of another.
    pub(crate) fn to(self, other: Self) -> Self {
        Self {
            start: self.start,
            end: other.end,
        }
    }
}

/// One mistake.
#[derive(Debug, Clone)]
pub struct Mistake {
    /// Code of the mistake (`E01` to `E27`); `None` for plain syntax errors.
    pub code: Option<&'static str>,
    /// What is wrong and what to write instead.
    pub message: String,
    /// Whether the declaration is accepted all the same.
    pub warning: bool,
    pub(crate) place: Place,
}

impl Mistake {
    /// The text that the compiler shows: the code, if there is one, then the message.
    #[must_use]
    pub fn text(&self) -> String {
        match self.code {
            Some(code) => format!("{code}: {}", self.message),
            None => self.message.clone(),
        }
    }

    /// Tokens that make the compiler underline the place of the mistake.
    fn to_tokens(&self) -> TokenStream {
        if self.warning {
            self.to_lint()
        } else {
            self.to_error()
        }
    }

    /// The use of a constant that is deprecated: the one way in which a macro can warn on stable Rust.
    fn to_lint(&self) -> TokenStream {
        let text = self.text();
        let used = Ident::new("warning", Span::call_site().located_at(self.place.start));
        quote! {
            const _: () = {
                #[deprecated(note = #text)]
                #[allow(non_upper_case_globals)]
                const warning: () = ();
                #used
            };
        }
    }

    fn to_error(&self) -> TokenStream {
        let Place { start, end } = self.place;
        let punct = |symbol, spacing| {
            let mut punct = Punct::new(symbol, spacing);
            punct.set_span(start);
            TokenTree::Punct(punct)
        };
        let mut text = Literal::string(&self.text());
        text.set_span(end);
        let mut group = Group::new(Delimiter::Brace, TokenTree::Literal(text).into());
        group.set_span(end);
        TokenStream::from_iter([
            punct(':', Spacing::Joint),
            punct(':', Spacing::Alone),
            TokenTree::Ident(Ident::new("core", start)),
            punct(':', Spacing::Joint),
            punct(':', Spacing::Alone),
            TokenTree::Ident(Ident::new("compile_error", start)),
            punct('!', Spacing::Alone),
            TokenTree::Group(group),
        ])
    }
}

/// A mistake has been reported; whoever receives this says nothing more about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Reported;

/// Result of a step that reports its own mistakes.
pub(crate) type Checked<T> = Result<T, Reported>;

/// All results, if each is one; each has reported its own mistakes.
pub(crate) fn all<T>(results: impl Iterator<Item = Checked<T>>) -> Checked<Vec<T>> {
    let results: Vec<Checked<T>> = results.collect();
    results.into_iter().collect()
}

/// Mistakes found so far.
#[derive(Debug, Default)]
pub(crate) struct Diagnostics {
    mistakes: Vec<Mistake>,
    /// Names whose declaration failed.
    poisoned: HashSet<String>,
    /// Names that are declared anywhere.
    declared: HashSet<String>,
    /// Whether the scene is read from a text and becomes no source of Rust, so that names may be words of Rust.
    pub(crate) is_data: bool,
}

impl Diagnostics {
    /// Reports a mistake with its code. The same text is reported once.
    pub(crate) fn report(
        &mut self,
        code: impl Into<Option<&'static str>>,
        place: Place,
        message: impl Into<String>,
    ) -> Reported {
        self.push(code.into(), place, message.into(), false)
    }

    /// Reports what is most likely not meant, but leaves no doubt what the declaration means.
    pub(crate) fn warn(&mut self, code: &'static str, place: Place, message: impl Into<String>) {
        let _: Reported = self.push(Some(code), place, message.into(), true);
    }

    /// Reports a plain syntax error.
    pub(crate) fn syntax(&mut self, place: Place, message: impl Into<String>) -> Reported {
        self.push(None, place, message.into(), false)
    }

    /// Takes over what was found apart from these.
    pub(crate) fn absorb(&mut self, found: Self) {
        for known in found.mistakes {
            let _: Reported = self.push(known.code, known.place, known.message, known.warning);
        }
    }

    fn push(
        &mut self,
        code: Option<&'static str>,
        place: Place,
        message: String,
        warning: bool,
    ) -> Reported {
        let message = with_short_names(in_one_line(message));
        // Of all members of a repetition one is told.
        let same = |known: &Mistake| {
            known.code == code
                && (known.message == message
                    || said(&known.message) == said(&message) && known.place.is_that(place))
        };
        if !self.mistakes.iter().any(same) {
            self.mistakes.push(Mistake {
                code,
                message,
                warning,
                place,
            });
        }
        Reported
    }

    /// Marks a name whose declaration failed, so that its uses give no second message.
    pub(crate) fn poison(&mut self, name: &str) {
        self.poisoned.insert(name.to_owned());
    }

    /// Whether the declaration of a name failed.
    pub(crate) fn is_poisoned(&self, name: &str) -> bool {
        self.poisoned.contains(name)
    }

    /// Notes that a name is declared somewhere.
    pub(crate) fn declare(&mut self, name: &str) {
        self.declared.insert(name.to_owned());
    }

    /// Whether a name is declared anywhere.
    pub(crate) fn is_declared(&self, name: &str) -> bool {
        self.declared.contains(name)
    }

    /// Number of mistakes so far, without warnings.
    pub(crate) fn mistakes(&self) -> usize {
        self.others_than(&[])
    }

    /// Number of mistakes so far with other codes than these.
    pub(crate) fn others_than(&self, codes: &[&str]) -> usize {
        let is_other = |mistake: &&Mistake| mistake.code.is_none_or(|code| !codes.contains(&code));
        let mistakes = self.mistakes.iter().filter(|mistake| !mistake.warning);
        mistakes.filter(is_other).count()
    }

    /// Whether none was found since there were so many.
    pub(crate) fn none_since(&self, before: usize) -> Checked<()> {
        match self.mistakes() > before {
            true => Err(Reported),
            false => Ok(()),
        }
    }

    pub(crate) fn into_mistakes(self) -> Vec<Mistake> {
        self.mistakes
    }
}

/// A message in one line, whatever it quotes: the text of a string may go over several.
fn in_one_line(message: String) -> String {
    if !message.contains(char::is_control) {
        return message;
    }
    let words = message.split(|c: char| c.is_control() || c == ' ');
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    words.join(" ")
}

/// What a message says, without its advice and without indices.
fn said(message: &str) -> String {
    let said = message.split(';').next().unwrap_or_default();
    said.chars().filter(|c| !c.is_ascii_digit()).collect()
}

/// Longest name that a message quotes whole, in characters: a line of a terminal.
const LONGEST_NAME: usize = 80;
/// What is left of a longer one at its begin and at its end, in characters.
const LEFT: [usize; 2] = [40, 12];

/// A message with long names cut in the middle.
fn with_short_names(message: String) -> String {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let is_long = |name: &str| name.chars().count() > LONGEST_NAME;
    if !message.split(|c| !is_part(c)).any(is_long) {
        return message;
    }
    let mut shown = String::new();
    for piece in message.split_inclusive(|c| !is_part(c)) {
        let name = piece.trim_end_matches(|c| !is_part(c));
        if is_long(name) {
            shown.extend(name.chars().take(LEFT[0]));
            shown += "...";
            shown.extend(name.chars().skip(name.chars().count() - LEFT[1]));
            shown += &piece[name.len()..];
        } else {
            shown += piece;
        }
    }
    shown
}

/// All mistakes as `compile_error!`s, all warnings as lints.
pub(crate) fn to_tokens(mistakes: &[Mistake]) -> TokenStream {
    mistakes.iter().flat_map(Mistake::to_tokens).collect()
}

/// The candidate closest to `name` in spelling, if any is close.
pub(crate) fn closest<'a>(
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let limit = match name.chars().count() {
        0..=2 => 1,
        3..=5 => 2,
        _ => 3,
    };
    candidates
        .into_iter()
        .map(|candidate| (distance(name, candidate), candidate))
        .filter(|&(distance, candidate)| {
            // A single letter replaced by another is another name, not a slip.
            let shorter = candidate.chars().count().min(name.chars().count());
            distance <= limit && distance < shorter.max(1)
        })
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// Edit distance with transpositions of neighbours; a difference in case alone counts nothing.
fn distance(a: &str, b: &str) -> usize {
    let compared = |text: &str| text.to_lowercase().chars().take(64).collect::<String>();
    strsim::osa_distance(&compared(a), &compared(b))
}

/// Number of names that differ by their indices only up to which each is listed.
const LISTED: usize = 4;

/// `a, b, c` in backquotes; many that differ by their indices only stand once, as `x[..]`.
pub(crate) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<(&str, String)> = names
        .into_iter()
        .map(|name| (name, without_indices(name)))
        .collect();
    let mut alike = BTreeMap::new();
    for (_, stem) in &names {
        *alike.entry(stem.as_str()).or_insert(0) += 1;
    }
    let mut listed: Vec<&str> = Vec::new();
    for (name, stem) in &names {
        match alike.get_mut(stem.as_str()) {
            Some(count) if *count > LISTED => {
                listed.push(stem);
                *count = 0;
            }
            Some(0) => {}
            _ => listed.push(name),
        }
    }
    let quoted = listed.iter().map(|name| format!("`{name}`"));
    quoted.collect::<Vec<_>>().join(", ")
}

/// A name with `..` in the place of its indices.
fn without_indices(name: &str) -> String {
    let mut parts = name.split('[');
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| match part.split_once(']') {
        Some((_, rest)) => text + "[..]" + rest,
        None => text + "[" + part,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_that_quotes_several_lines_is_one() {
        let quoted = "expected a name, found `\"\r\n  a\n`";
        assert_eq!(
            in_one_line(quoted.to_owned()),
            "expected a name, found `\" a `"
        );
        let short = "`x`  is not declared";
        assert_eq!(in_one_line(short.to_owned()), short);
    }

    #[test]
    fn long_names_are_cut_and_others_are_not() {
        let long = "b".repeat(2_000);
        let cut = with_short_names(format!("`x_{long}` is not declared; write `{long}*y`"));
        assert!(cut.chars().count() < 200, "{cut}");
        assert!(
            cut.starts_with("`x_bb") && cut.contains("b...b") && cut.ends_with("b*y`"),
            "{cut}"
        );
        let short = format!("`{}` is not declared", "c".repeat(LONGEST_NAME));
        assert_eq!(with_short_names(short.clone()), short);
    }

    #[test]
    fn names_with_many_indices_are_listed_once() {
        let x: Vec<String> = (1..=LISTED + 1).map(|k| format!("x[{k}].tip")).collect();
        let of_x = x.iter().map(String::as_str);
        let all = || ["g", "z[1]", "z[2]"].into_iter().chain(of_x.clone());
        assert_eq!(list(all()), "`g`, `z[1]`, `z[2]`, `x[..].tip`");
        assert_eq!(list(all().take(4)), "`g`, `z[1]`, `z[2]`, `x[1].tip`");
    }

    #[test]
    fn closest_finds_slips_and_ignores_strangers() {
        let names = ["theta", "phi", "m_b", "m_r", "y"];
        assert_eq!(closest("thetta", names), Some("theta"));
        assert_eq!(closest("htea", names), Some("theta"));
        assert_eq!(closest("m_rr", names), Some("m_r"));
        assert_eq!(closest("Phi", names), Some("phi"));
        assert_eq!(closest("velocity", names), None);
        assert_eq!(closest("q", names), None);
    }
}
