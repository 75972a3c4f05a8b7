//! Bad input, reduced to one line, or shown where it stands.

use hangtime::simulation::InputError;

/// Why a command was refused: one line that says what, where, and how to mend it, or the report on a scene file.
#[derive(Debug, PartialEq, thiserror::Error)]
pub(crate) enum BadInput {
    #[error("{0}")]
    Line(String),
    /// Mistakes in a scene file, shown in its lines.
    #[error("{0}")]
    Report(String),
}

impl BadInput {
    /// A refusal in one short line.
    pub(crate) fn new(message: impl AsRef<str>) -> Self {
        Self::Line(one_line(message.as_ref()))
    }

    /// A refusal of a text, with the lines that are wrong in it.
    pub(crate) fn report(text: &str) -> Self {
        Self::Report(visible(text))
    }
}

/// Longer words of a message are cut: what the user typed may be of any length.
const LONGEST_WORD: usize = 100;
/// Of a longer message the middle is left out.
const LONGEST_LINE: usize = 800;

/// The message in one line: white space becomes single spaces, what a terminal would obey becomes visible, and what is
/// too long is cut.
pub(crate) fn one_line(message: &str) -> String {
    let words = message.split_whitespace();
    let words: Vec<String> = words
        .map(|word| cut(&visible(word), LONGEST_WORD))
        .collect();
    cut(&words.join(" "), LONGEST_LINE)
}

/// Whether a terminal obeys a character instead of showing it: control characters other than line ends and tabs, and
/// marks that turn the direction of writing.
pub(crate) fn steers(c: char) -> bool {
    (c.is_control() && c != '\n' && c != '\t')
        || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// The text with control characters, other than line ends and tabs, in visible form.
pub(crate) fn visible(text: &str) -> String {
    if !text.contains(steers) {
        return text.to_owned();
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if steers(c) {
            shown.extend(c.escape_unicode());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// The text without its middle, if it has more than `most` characters.
fn cut(text: &str, most: usize) -> String {
    let length = text.chars().count();
    if length <= most {
        return text.to_owned();
    }
    let (head, tail) = (most / 2, most / 4);
    let start: String = text.chars().take(head).collect();
    let end: String = text.chars().skip(length - tail).collect();
    format!("{start}[... {} characters ...]{end}", length - head - tail)
}

impl From<InputError> for BadInput {
    fn from(error: InputError) -> Self {
        Self::new(error.to_string())
    }
}

impl From<clap::Error> for BadInput {
    /// Keeps the message and the tips of the argument parser, and names the help to read instead of
    /// printing it.
    fn from(error: clap::Error) -> Self {
        let text = error.render().to_string();
        let lines = text
            .lines()
            .map(str::trim)
            .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"))
            .filter(|line| !line.is_empty())
            .map(|line| line.trim_start_matches("error: "));
        let parts: Vec<&str> = lines.chain(["see --help"]).collect();
        Self::new(parts.join("; ").replace(":;", ":"))
    }
}

/// `; did you mean ...?` for the candidate closest to `name`, or nothing if none is close.
pub(crate) fn did_you_mean<'a>(
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> String {
    /// Two unrelated words of this length reach about 0.6 on this scale.
    const SIMILAR: f64 = 0.7;
    candidates
        .into_iter()
        .map(|candidate| {
            let similarity = strsim::jaro_winkler(&name.to_lowercase(), &candidate.to_lowercase());
            (similarity, candidate)
        })
        .filter(|&(similarity, _)| similarity >= SIMILAR)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| format!("; did you mean `{candidate}`?"))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::{BadInput, did_you_mean};
    use crate::arguments::Arguments;

    fn refused(arguments: &[&str]) -> String {
        let error = Arguments::try_parse_from(arguments).unwrap_err();
        BadInput::from(error).to_string()
    }

    #[test]
    fn parser_errors_become_one_line_with_the_remedy() {
        assert_eq!(
            refused(&["hangtime", "simulate", "ski-jump", "--steps", "0"]),
            "invalid value '0' for '--steps <N>': give a whole number from 1 to \
             1000000; see --help"
        );
        assert_eq!(
            refused(&["hangtime", "simulate", "ski-jump", "--step", "3"]),
            "unexpected argument '--step' found; tip: a similar argument exists: '--steps'; see \
             --help"
        );
        assert_eq!(
            refused(&["hangtime", "simulate"]),
            "the following required arguments were not provided: <SCENE>; see --help"
        );
    }

    #[test]
    fn message_with_long_or_steering_text_is_short_and_visible() {
        let long = "7".repeat(4000);
        for text in [
            BadInput::new(format!("parameter `{long}`: give a number")).to_string(),
            refused(&["hangtime", "simulate", "a", "--steps", &long]),
            BadInput::new("x ".repeat(4000) + "give a number").to_string(),
        ] {
            assert!(text.chars().count() < 900, "{}", text.len());
            assert!(text.contains("characters ..."), "{text}");
            assert!(text.contains("give a"), "{text}");
        }
        let steering = BadInput::new("scene `a\u{1b}[2Jb\u{7}\u{202e}c`\r\nd").to_string();
        assert_eq!(steering, "scene `a\\u{1b}[2Jb\\u{7}\\u{202e}c` d");
    }

    #[test]
    fn count_beyond_its_bound_says_why_there_is_one() {
        let refusal = refused(&["hangtime", "simulate", "a", "--steps", "1000001"]);
        assert!(refusal.contains("at most 1000000: the states"), "{refusal}");
        let refusal = refused(&["hangtime", "solve", "a", "--elements", "-3"]);
        assert!(refusal.contains("whole number from 1 to 1000"), "{refusal}");
    }

    #[test]
    fn did_you_mean_far_name_suggests_nothing() {
        let names = ["start_y", "m", "g"];
        assert_eq!(did_you_mean("starty", names), "; did you mean `start_y`?");
        assert_eq!(did_you_mean("START_Y", names), "; did you mean `start_y`?");
        assert_eq!(did_you_mean("velocity", names), "");
    }
}
