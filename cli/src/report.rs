//! What a command prints, and the exit status that goes with it.

use std::io::{self, Write as _};

use crate::arguments::ResultArguments;
use crate::failure::{BadInput, one_line, visible};
use crate::output::OutputDirectory;

/// Exit status of a solved problem.
pub(crate) const SUCCESS: u8 = 0;
/// Exit status of a result that did not converge.
pub(crate) const NOT_CONVERGED: u8 = 3;
/// Exit status of bad input, and of files that could not be written.
pub(crate) const BAD_INPUT: u8 = 2;

/// Refuses a number of rows where none are written.
pub(crate) fn refuse_rows_of_nothing(arguments: &ResultArguments) -> Result<(), BadInput> {
    if arguments.rows.is_some() && !arguments.json && arguments.out.is_none() {
        return Err(BadInput::new(
            "--rows has no meaning without --json or --out, which write the trajectory; add one of them, or leave it out",
        ));
    }
    Ok(())
}

/// What a command prints.
#[derive(Debug, Default)]
pub(crate) struct Report {
    /// For the standard output stream.
    pub(crate) text: String,
    /// Why the result did not converge, one line each, for the standard error stream.
    pub(crate) diagnoses: Vec<String>,
    /// Why files were not written, one line each, for the standard error stream.
    pub(crate) refusals: Vec<String>,
}

impl Report {
    /// A report that is all said in its text.
    pub(crate) fn of(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            ..Self::default()
        }
    }

    /// Writes files, given as (name, content), and returns a line about each. Where that fails, the report tells why,
    /// and everything else in it stays.
    pub(crate) fn deliver(
        &mut self,
        directory: OutputDirectory,
        files: &[(String, String)],
    ) -> String {
        match directory.write(files) {
            Ok(written) => written
                .iter()
                .map(|file| {
                    let what = if file.replaced { "replaced" } else { "wrote" };
                    format!("{what} {}\n", file.path.display())
                })
                .collect(),
            Err(refusal) => {
                self.refusals.push(refusal.to_string());
                String::new()
            }
        }
    }

    /// Prints it; gives the exit status.
    pub(crate) fn print(&self) -> u8 {
        let mut stdout = io::stdout().lock();
        let written = stdout
            .write_all(visible(&self.text).as_bytes())
            .and_then(|()| stdout.flush());
        for line in self.diagnoses.iter().chain(&self.refusals) {
            complain(line);
        }
        match printed(written) {
            failed if failed != SUCCESS => failed,
            _ if !self.refusals.is_empty() => BAD_INPUT,
            _ if self.diagnoses.is_empty() => SUCCESS,
            _ => NOT_CONVERGED,
        }
    }
}

/// The exit status of what has been `written` to the standard output stream.
pub(crate) fn printed(written: io::Result<()>) -> u8 {
    match written {
        // Whoever reads the other end of a pipe may stop whenever they like.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            complain(&format!("standard output: {error}; check where it leads"));
            BAD_INPUT
        }
        _ => SUCCESS,
    }
}

/// Why a command was refused, on the standard error stream.
pub(crate) fn refuse(refusal: &BadInput) {
    match refusal {
        BadInput::Line(line) => complain(line),
        BadInput::Report(text) => {
            let _ = writeln!(io::stderr(), "{text}");
        }
    }
}

/// One short line on the standard error stream.
pub(crate) fn complain(message: &str) {
    // If even this stream is closed there is nobody left to tell.
    let _ = writeln!(io::stderr(), "error: {}", one_line(message));
}
