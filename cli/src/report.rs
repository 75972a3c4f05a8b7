//! What a command prints, and the exit status that goes with it.

use std::io::{self, Write as _};
use std::process::ExitCode;

/// Exit status of a result that did not converge.
const NOT_CONVERGED: u8 = 3;
/// Exit status of bad input.
pub(crate) const BAD_INPUT: u8 = 2;

/// What a command prints.
#[derive(Debug, Default)]
pub(crate) struct Report {
    /// For the standard output stream.
    pub(crate) text: String,
    /// Why the result did not converge, one line each, for the standard error stream.
    pub(crate) diagnoses: Vec<String>,
}

impl Report {
    /// Prints it.
    pub(crate) fn print(&self) -> ExitCode {
        let mut stdout = io::stdout().lock();
        let written = stdout
            .write_all(self.text.as_bytes())
            .and_then(|()| stdout.flush());
        for diagnosis in &self.diagnoses {
            complain(diagnosis);
        }
        match written {
            // Whoever reads the other end of a pipe may stop whenever they like.
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                complain(&format!("standard output: {error}; check where it leads"));
                ExitCode::from(BAD_INPUT)
            }
            _ if self.diagnoses.is_empty() => ExitCode::SUCCESS,
            _ => ExitCode::from(NOT_CONVERGED),
        }
    }
}

/// One line on the standard error stream.
pub(crate) fn complain(message: &str) {
    // If even this stream is closed there is nobody left to tell.
    let _ = writeln!(io::stderr(), "error: {message}");
}
