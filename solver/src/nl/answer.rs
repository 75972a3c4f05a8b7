//! Solution files of programs that were refused.

use super::heading::counts;
use super::source::Source;

/// The number by which modelling languages know a failure (`solve_result_num` of AMPL, 500 to 599).
const FAILURE: usize = 500;

/// The text of a `.sol` file without values for the `.nl` file with these bytes, which says why the program was not solved: whoever
/// called the solver shows `message` to its user. `None` where not even the counts of the heading can be read.
pub fn refusal_text(bytes: &[u8], message: &str) -> Option<String> {
    let (options, variables, rows) = counts(&mut Source::new(bytes)).ok()?;
    let options: String = options.iter().map(|option| format!("{option}\n")).collect();
    Some(format!(
        "{}\n\nOptions\n{options}{rows}\n0\n{variables}\n0\nobjno 0 {FAILURE}\n",
        one_line(message)
    ))
}

/// A message without line ends, since an empty line ends it.
pub(super) fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}
