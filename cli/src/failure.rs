//! Bad input, reduced to one line.

use hangtime::simulation::InputError;

/// Why a command was refused: one line that says what, where, and how to mend it.
#[derive(Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct BadInput(String);

impl BadInput {
    /// A refusal; line breaks become spaces.
    pub(crate) fn new(message: impl AsRef<str>) -> Self {
        let words: Vec<&str> = message.as_ref().split_whitespace().collect();
        Self(words.join(" "))
    }
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
        let parts: Vec<&str> = lines.chain(["see `hangtime --help`"]).collect();
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
             10000000; see `hangtime --help`"
        );
        assert_eq!(
            refused(&["hangtime", "simulate", "ski-jump", "--step", "3"]),
            "unexpected argument '--step' found; tip: a similar argument exists: '--steps'; see \
             `hangtime --help`"
        );
        assert_eq!(
            refused(&["hangtime", "simulate"]),
            "the following required arguments were not provided: <SCENE>; see `hangtime --help`"
        );
    }

    #[test]
    fn did_you_mean_far_name_suggests_nothing() {
        let names = ["start_y", "m", "g"];
        assert_eq!(did_you_mean("starty", names), "; did you mean `start_y`?");
        assert_eq!(did_you_mean("START_Y", names), "; did you mean `start_y`?");
        assert_eq!(did_you_mean("velocity", names), "");
    }
}
