//! A declaration as the text of a file: from characters to tokens, and mistakes with their place in the text.

use crate::diagnostics::{Mistake, closest};
use crate::expand::is_product;
use crate::{expand, parse, words};
use proc_macro2::{Delimiter, Group, Ident, Span, TokenStream, TokenTree};
use std::ops::Range;
use std::path::Path;

/// Most bytes of a text: some thousand lines.
pub const LONGEST: u64 = 1 << 18;
/// Most brackets inside each other.
const DEEPEST: usize = 64;
/// What stands between a text and that of a file which it uses, before the name of the file: the begin of a comment.
const USED: &str = "\n// \u{c}use ";
/// Most mistakes of the characters that are listed.
const MOST: usize = 20;

/// One mistake of a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextMistake {
    /// Code of the mistake (`E01` to `E27`); `None` for plain syntax errors.
    pub code: Option<&'static str>,
    /// What is wrong and what to write instead, in one line.
    pub message: String,
    /// Whether the declaration is accepted all the same.
    pub warning: bool,
    /// The bytes of the text where it stands.
    pub place: Range<usize>,
}

impl TextMistake {
    fn new(place: Range<usize>, message: impl Into<String>) -> Self {
        Self {
            code: None,
            message: message.into(),
            warning: false,
            place,
        }
    }

    /// What is shown of it: the code, if there is one, then the message.
    #[must_use]
    pub fn text(&self) -> String {
        match self.code {
            Some(code) => format!("{code}: {}", self.message),
            None => self.message.clone(),
        }
    }

    /// A mistake in tokens of the text.
    pub(crate) fn of(mistake: Mistake) -> Self {
        let start = mistake.place.start.byte_range().start;
        let end = mistake.place.end.byte_range().end;
        Self {
            place: start..end.max(start),
            code: mistake.code,
            message: mistake.message,
            warning: mistake.warning,
        }
    }
}

/// The tokens of a text that holds what stands inside `model! { ... }`, or only the statements of a scene that is then
/// called after `stem`, the name of its file.
pub(crate) fn tokens(text: &str, stem: &str) -> Result<TokenStream, Vec<TextMistake>> {
    if text.len() as u64 > LONGEST {
        let message =
            format!("the text has more than {LONGEST} bytes; declare one scene in a file");
        return Err(vec![TextMistake::new(0..0, message)]);
    }
    let mistakes = characters(text);
    if !mistakes.is_empty() {
        return Err(mistakes);
    }
    match text.parse::<TokenStream>() {
        Ok(tokens) => Ok(with_header(tokens, stem)),
        Err(error) => {
            let at = error.span().byte_range().start.min(text.len());
            let end = text[at..].chars().next().map_or(at, |c| at + c.len_utf8());
            let message = "no number, name or symbol of the language begins here";
            Err(vec![TextMistake::new(at..end, message)])
        }
    }
}

/// The text of a declaration, without its documentation, and with parentheses around invisible groups where they bind.
pub(crate) fn of_declaration(tokens: TokenStream) -> String {
    let tokens: TokenStream = undocumented(tokens).into_iter().collect();
    tokens.to_string()
}

/// Tokens without attributes and invisible groups.
fn undocumented(tokens: TokenStream) -> Vec<TokenTree> {
    let mut tokens = tokens.into_iter().peekable();
    let mut kept: Vec<TokenTree> = Vec::new();
    while let Some(token) = tokens.next() {
        match token {
            TokenTree::Punct(mark) if mark.as_char() == '#' => {
                tokens.next_if(|next| matches!(next, TokenTree::Group(_)));
            }
            // Blanks are lost in text that is made of tokens.
            TokenTree::Punct(mark)
                if mark.as_char() == '.'
                    && tokens
                        .peek()
                        .is_some_and(|next| is_product(&mark.clone().into(), next)) =>
            {
                let mut operand = Vec::new();
                while let Some(next) = tokens.next_if(|next| match next {
                    TokenTree::Ident(_) => {
                        operand.is_empty() || operand.last().is_some_and(operates)
                    }
                    TokenTree::Punct(mark) => !operand.is_empty() && mark.as_char() == '.',
                    TokenTree::Group(group) => {
                        !operand.is_empty() && group.delimiter() != Delimiter::Brace
                    }
                    TokenTree::Literal(_) => false,
                }) {
                    operand.push(next);
                }
                kept.push(mark.into());
                if !operand.is_empty() {
                    let operand = undocumented(operand.into_iter().collect());
                    kept.push(
                        Group::new(Delimiter::Parenthesis, operand.into_iter().collect()).into(),
                    );
                }
            }
            TokenTree::Group(group) => {
                let inner = undocumented(group.stream());
                let binds =
                    kept.last().is_some_and(operates) || tokens.peek().is_some_and(operates);
                let delimiter = match group.delimiter() {
                    Delimiter::None if inner.len() > 1 && binds => Delimiter::Parenthesis,
                    delimiter => delimiter,
                };
                if delimiter == Delimiter::None {
                    kept.extend(inner);
                } else {
                    kept.push(Group::new(delimiter, inner.into_iter().collect()).into());
                }
            }
            other => kept.push(other),
        }
    }
    kept
}

/// Whether a token is an operator, which binds to a part of a group beside it if that has no parentheses.
fn operates(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Punct(mark) if "+-*/^.".contains(mark.as_char()))
}

/// The declaration with `pub Name { ... }` around it if it is without.
fn with_header(tokens: TokenStream, stem: &str) -> TokenStream {
    let mut tokens = tokens.into_iter().peekable();
    let mut header: Vec<TokenTree> = Vec::new();
    // Documentation of a whole file is written `//!` or `///`.
    while let Some(TokenTree::Punct(mark)) = tokens.peek()
        && matches!(mark.as_char(), '#' | '!')
    {
        let mark = mark.as_char();
        let token = tokens.next();
        if mark == '#' {
            header.extend(token);
        }
        if let Some(TokenTree::Group(_)) = tokens.peek() {
            header.extend(tokens.next());
        }
    }
    let mut body: Vec<TokenTree> = tokens.collect();
    if is_whole(&body) {
        take_in(&mut body);
    } else {
        let span = |token: Option<&TokenTree>| token.map_or_else(Span::call_site, TokenTree::span);
        let (first, last) = (span(body.first()), span(body.last()));
        let mut group = Group::new(Delimiter::Brace, body.into_iter().collect());
        group.set_span(last);
        header.extend([
            TokenTree::Ident(Ident::new("pub", first)),
            TokenTree::Ident(Ident::new(&type_name(stem), first)),
            TokenTree::Group(group),
        ]);
        return header.into_iter().collect();
    }
    header.into_iter().chain(body).collect()
}

/// The tokens of a file that a declaration uses.
pub(crate) fn tokens_of_used(text: &str) -> Result<TokenStream, String> {
    let tokens = text.replace("//!", "// ").parse::<TokenStream>();
    tokens.map_err(|error| error.to_string())
}

/// A declaration with the statements behind it inside of its braces.
pub(crate) fn taken_in(tokens: TokenStream) -> TokenStream {
    let mut tokens: Vec<TokenTree> = tokens.into_iter().collect();
    take_in(&mut tokens);
    tokens.into_iter().collect()
}

/// Puts what files behind a declaration declare inside of its braces.
fn take_in(whole: &mut Vec<TokenTree>) {
    let is_body = |token: &TokenTree| matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace);
    let Some(at) = whole.iter().position(is_body) else {
        return;
    };
    if let TokenTree::Group(body) = whole[at].clone()
        && expand::is_declaration(&whole[at + 1..])
    {
        let inside = body.stream().into_iter().chain(whole.drain(at + 1..));
        let mut group = Group::new(Delimiter::Brace, inside.collect());
        group.set_span(body.span());
        whole[at] = group.into();
    }
}

/// A text with those of the files that `use "leg.hang"` names in it behind it, and so on; `read` reads one, by its name as
/// seen from where the text stands.
///
/// # Errors
/// What `read` said of a file that it cannot read.
///
/// ```
/// use hangtime_dsl::{in_used, with_used};
/// let leg = "part leg(m: kg) { coordinates { q: m } lagrangian += m/2*dot(q)^2 }";
/// let read = |name: &str| Ok(leg.replace("leg", name.trim_end_matches(".hang")));
/// let whole = with_used("use \"leg.hang\" left: leg(1 [kg])", read)?;
/// assert!(hangtime_dsl::describe_text(&whole, "biped").is_ok());
/// let place = whole.find("leg(m").map_or(0..0, |at| at..at + 3);
/// assert_eq!(in_used(&whole, &place), (Some("leg.hang"), leg, 5..8));
/// # Ok::<(), String>(())
/// ```
pub fn with_used(
    text: &str,
    mut read: impl FnMut(&str) -> Result<String, String>,
) -> Result<String, String> {
    let mut whole = text.to_owned();
    let (mut begin, mut names, mut asked) = (0, vec![String::new()], 0);
    loop {
        let own = &whole[begin..];
        if own.contains("use") {
            let tokens = tokens(own, "scene").ok().and_then(parse::body);
            note_used(tokens.unwrap_or_default(), &mut names, asked);
        }
        asked += 1;
        let Some(name) = names.get(asked) else {
            return Ok(whole);
        };
        whole += &format!("{USED}{name}\n");
        begin = whole.len();
        whole += &read(name)?.replace("//!", "// ");
    }
}

/// The files that these tokens of one of them use behind those that are known, each once and as seen from the first one.
pub(crate) fn note_used(tokens: TokenStream, names: &mut Vec<String>, user: usize) {
    for name in expand::files(tokens) {
        let name = Path::new(&names[user]).with_file_name(name);
        let name = name.to_string_lossy().into_owned();
        if !names.contains(&name) {
            names.push(name);
        }
    }
}

/// Where bytes of a text of [`with_used`] stand: the file that is used and its text, or none and that of the scene itself, and the
/// bytes in it.
#[must_use]
pub fn in_used<'a>(
    text: &'a str,
    place: &Range<usize>,
) -> (Option<&'a str>, &'a str, Range<usize>) {
    let before = text
        .get(..place.start)
        .and_then(|before| before.rfind(USED));
    let name = before.map(|at| text[at + USED.len()..].lines().next().unwrap_or_default());
    let begin = match (before, name) {
        (Some(at), Some(name)) => at + USED.len() + name.len() + 1,
        _ => 0,
    };
    let own = text.get(begin..).unwrap_or_default();
    let own = own.find(USED).map_or(own, |end| &own[..end]);
    let within = |at: usize| at.saturating_sub(begin);
    (name, own, within(place.start)..within(place.end))
}

/// Whether tokens are a declaration with its name and its braces: `pub Name { ... }`. Names of scenes begin with a capital
/// letter; what else stands first is a statement, right or misspelt.
fn is_whole(tokens: &[TokenTree]) -> bool {
    let word = match tokens.first() {
        Some(TokenTree::Ident(word)) => word.to_string(),
        Some(TokenTree::Group(_)) => return true,
        _ => return false,
    };
    if words::STATEMENTS.contains(&word.as_str()) {
        return false;
    }
    let holds_statements = match tokens.get(1) {
        Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
            let first = group.stream().into_iter().find_map(|token| match token {
                TokenTree::Ident(word) => Some(word.to_string()),
                _ => None,
            });
            first.is_some_and(|first| words::STATEMENTS.contains(&first.as_str()))
        }
        _ => false,
    };
    let named = word.starts_with(char::is_uppercase) && closest(&word, words::STATEMENTS).is_none();
    holds_statements || named || matches!(word.as_str(), "pub" | "model" | "hangtime")
}

/// The name of a scene whose file is called `stem`: `ski-jump` is `SkiJump`.
fn type_name(stem: &str) -> String {
    let words = stem.split(|c: char| !c.is_ascii_alphanumeric());
    let name: String = words
        .filter_map(|word| {
            let mut letters = word.chars();
            let first = letters.next()?;
            Some(first.to_ascii_uppercase().to_string() + letters.as_str())
        })
        .collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) && !words::is_rust_word(&name) {
        name
    } else {
        format!("Scene{name}")
    }
}

/// What is wrong with the characters: brackets that do not match, comments without end, and what no token holds.
fn characters(text: &str) -> Vec<TextMistake> {
    let mut scan = Scan {
        text,
        at: 0,
        open: Vec::new(),
        mistakes: Vec::new(),
    };
    while scan.at < text.len() && scan.mistakes.len() < MOST {
        if !scan.step() {
            break;
        }
    }
    if scan.mistakes.is_empty()
        && let Some(&(at, bracket)) = scan.open.last()
    {
        let message = format!("the bracket `{bracket}` is never closed");
        scan.mistakes.push(TextMistake::new(at..at + 1, message));
    }
    scan.mistakes
}

struct Scan<'a> {
    text: &'a str,
    at: usize,
    /// Open brackets and where they stand.
    open: Vec<(usize, char)>,
    mistakes: Vec<TextMistake>,
}

impl Scan<'_> {
    /// Reads on; false if there is no sense in it.
    fn step(&mut self) -> bool {
        let rest = &self.text[self.at..];
        let Some(c) = rest.chars().next() else {
            return false;
        };
        let length = match c {
            _ if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            _ if rest.starts_with("/*") => match comment(rest) {
                Some(length) => length,
                None => return self.stop(2, "this comment is never closed; end it with `*/`"),
            },
            '"' => match string(rest) {
                Some(length) => length,
                None => return self.stop(1, "this string is never closed"),
            },
            '(' | '[' | '{' => {
                self.open.push((self.at, c));
                if self.open.len() > DEEPEST {
                    return self.stop(
                        1,
                        "brackets are nested too deeply here; introduce abbreviations with `let`",
                    );
                }
                1
            }
            ')' | ']' | '}' => match self.open.pop() {
                Some((_, open)) if closes(open, c) => 1,
                Some((_, open)) => {
                    let message =
                        format!("`{c}` closes nothing here: the bracket `{open}` is open");
                    return self.stop(1, &message);
                }
                None => {
                    return self.stop(1, &format!("`{c}` closes nothing: no bracket is open"));
                }
            },
            '\'' => self.prime(),
            '#' if !rest.starts_with("#[") && !rest.starts_with("#!") => {
                let place = self.at..self.at + 1;
                let message = "`#` begins no comment; write `//`";
                self.mistakes.push(TextMistake::new(place, message));
                rest.find('\n').unwrap_or(rest.len())
            }
            _ => {
                if let Some(remedy) = stray(c) {
                    let message = format!("`{}` is no character of the language{remedy}", shown(c));
                    let place = self.at..self.at + c.len_utf8();
                    self.mistakes.push(TextMistake::new(place, message));
                }
                c.len_utf8()
            }
        };
        self.at += length;
        true
    }

    /// Notes a mistake behind which nothing can be read.
    fn stop(&mut self, length: usize, message: &str) -> bool {
        let place = self.at..self.at + length;
        self.mistakes.push(TextMistake::new(place, message));
        false
    }

    /// Primes, which do not denote rates here; how many bytes they are.
    fn prime(&mut self) -> usize {
        let (before, rest) = self.text.split_at(self.at);
        let count = rest.len() - rest.trim_start_matches('\'').len();
        let is_part = |c: char| c.is_alphanumeric() || c == '_';
        let name = &before[before.trim_end_matches(is_part).len()..];
        let start = self.at - name.len();
        let message = if name.is_empty() {
            "`'` has no meaning here; the rate of a quantity `y` is written `dot(y)`".to_owned()
        } else if rest[count..].starts_with('(') {
            let inner = "diff(".repeat(count) + name + &")".repeat(count);
            format!("write `{inner}(...)` for the derivative of the function `{name}`")
        } else if count == 1 {
            format!("write `dot({name})` for the rate of `{name}`, instead of `{name}'`")
        } else {
            format!(
                "write `dot({name})` for the rate of `{name}`; accelerations are derived and do not occur in a \
                 declaration"
            )
        };
        self.mistakes
            .push(TextMistake::new(start..self.at + count, message));
        count
    }
}

fn closes(open: char, close: char) -> bool {
    matches!((open, close), ('(', ')') | ('[', ']') | ('{', '}'))
}

/// Length of a comment, which may hold others.
pub(crate) fn comment(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let (mut depth, mut at) = (0_usize, 0);
    while at + 1 < bytes.len() {
        match &bytes[at..at + 2] {
            b"/*" => depth += 1,
            b"*/" => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            return Some(at);
        }
    }
    None
}

/// Length of a string literal.
pub(crate) fn string(text: &str) -> Option<usize> {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            '"' if !escaped => return Some(at + 1),
            _ => escaped = c == '\\' && !escaped,
        }
    }
    None
}

/// A character as it can be printed.
fn shown(c: char) -> String {
    if c.is_control() {
        c.escape_unicode().to_string()
    } else {
        c.to_string()
    }
}

/// Whether a character occurs in no token; then what to write instead, if that is clear.
fn stray(c: char) -> Option<&'static str> {
    let remedy = match c {
        '\u{d7}' | '\u{b7}' | '\u{22c5}' | '\u{2219}' => "; write `*`",
        '\u{2212}' | '\u{2013}' | '\u{2014}' => "; write `-`",
        '\u{f7}' => "; write `/`",
        '\u{2264}' => "; write `<=`",
        '\u{2265}' => "; write `>=`",
        '\u{b2}' => "; write `^2`",
        '\u{b3}' => "; write `^3`",
        '\u{b0}' => "; angles in degrees have the unit `deg`",
        '\u{2032}' | '\u{2019}' => "; the rate of a quantity `y` is written `dot(y)`",
        '\u{221a}' => "; write `sqrt(...)`",
        '`' | '\\' => "",
        '\u{feff}' => return None,
        _ if c.is_ascii_control() && !c.is_ascii_whitespace() => "",
        _ if c.is_ascii() || c.is_alphanumeric() || c.is_whitespace() => return None,
        _ => "",
    };
    Some(remedy)
}

#[cfg(test)]
mod tests {
    use super::{characters, type_name};

    fn first(text: &str) -> (usize, String) {
        let mistake = characters(text).into_iter().next().unwrap();
        (mistake.place.start, mistake.message)
    }

    #[test]
    fn characters_of_a_declaration_pass() {
        for text in [
            "",
            "a { b [c] (d) } // it's (\n",
            "/* y' /* ( */ */ x",
            "#[doc = \"it's ( \\\" \"] {}",
        ] {
            assert!(characters(text).is_empty(), "{text}");
        }
    }

    #[test]
    fn text_of_a_declaration_can_be_read_again() {
        let declared = "/// A ball.\npub Ball { parameters { /// Its [mass] # 1.\n m: kg = 1, g: m/s^2 = 1.5e1 } \
                        coordinates { z: m } lagrangian m/2*dot(z)^2 - m*g*z start { z: -1[m] } }";
        let tokens = || declared.parse().expect("tokens");
        let text = super::of_declaration(tokens());
        assert!(!text.contains('#'), "{text}");
        let [first, again] = [declared, &text]
            .map(|text| crate::describe_text(text, "ball").expect("no mistakes").0);
        let [first_declared, declared] = [&first, &again].map(|scene| scene.structure.declaration);
        assert_eq!(first.kernels, again.kernels);
        assert_eq!(first_declared.name, declared.name);
        assert_eq!(declared.documentation, "");
    }

    #[test]
    fn wrong_characters_are_named_where_they_stand() {
        for (text, at, words) in [
            ("m*y'^2", 2, "write `dot(y)` for the rate of `y`"),
            ("m*y''", 2, "accelerations are derived"),
            ("{ (a }", 5, "the bracket `(` is open"),
            ("{ a", 0, "`{` is never closed"),
            ("a )", 2, "no bracket is open"),
            ("a /* b", 2, "never closed"),
            ("m\u{b7}g", 1, "write `*`"),
            ("a \u{1b}[2J", 2, "\\u{1b}"),
            ("a `b`", 2, "no character of the language"),
        ] {
            let (found, message) = first(text);
            assert_eq!(found, at, "{text}: {message}");
            assert!(message.contains(words), "{text}: {message}");
        }
        let deep = "(".repeat(100_000);
        assert!(first(&deep).1.contains("nested too deeply"));
        assert_eq!(characters(&"`".repeat(1000)).len(), super::MOST);
    }

    #[test]
    fn file_gives_its_name_to_a_scene_without_one() {
        for (stem, name) in [
            ("ski-jump", "SkiJump"),
            ("ball_2", "Ball2"),
            ("2-balls", "Scene2Balls"),
            ("self", "SceneSelf"),
            ("\u{e4}", "Scene"),
            ("", "Scene"),
        ] {
            assert_eq!(type_name(stem), name);
        }
    }
}
