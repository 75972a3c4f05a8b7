//! Programs from files in the hands of another program, such as an interpreter: the numbers are those of `hangtime nlp --json`.

use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use hangtime::nl::{self, Program, Solution};
use hangtime::nlp::{Interrupt, IterationInfo};
use hangtime::simulation::ProblemSize;

use crate::arguments::LimitArguments;
use crate::ending::{Ending, Stop};
use crate::failure::BadInput;
use crate::host::{Refusal, guarded};
use crate::json::program_document;
use crate::program_file::{open, read, summary};
use crate::program_options::{self, OPTIONS};

/// A program from a file that was solved.
pub struct HostProgram {
    name: String,
    program: Program,
    size: ProblemSize,
    solution: Solution,
    ending: Ending,
}

impl fmt::Debug for HostProgram {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HostProgram")
            .field("name", &self.name)
            .field("ending", &self.ending)
            .finish_non_exhaustive()
    }
}

/// Names of the options of [`HostProgram::solve`], those of the protocol that modelling languages call solvers by.
#[must_use]
pub fn program_options() -> Vec<&'static str> {
    OPTIONS.iter().map(|(name, _)| *name).collect()
}

impl HostProgram {
    /// Solves the program of the `.nl` file `path` with options as pairs of name and value. It goes on while `observer`, which is
    /// told each iteration in words, answers true and `stop` is not set. Multipliers in the file are started from where the option
    /// `warm_start` says so.
    ///
    /// # Errors
    /// Files that cannot be read or hold no such program, and options that do not exist or are out of their range.
    pub fn solve(
        path: &str,
        options: &[(String, String)],
        stop: &Arc<AtomicBool>,
        observer: &mut (dyn FnMut(&str) -> bool + Send),
    ) -> Result<Self, Refusal> {
        let mut chosen = nl::Options::default();
        chosen.warm = false;
        for (name, value) in options {
            program_options::set(&mut chosen, name, value, &[]).map_err(BadInput::new)?;
        }
        chosen.interrupt = Interrupt::by(Arc::clone(stop));
        let limits = LimitArguments::default();
        let is_asked = AtomicBool::new(false);
        let mut told = |info: &IterationInfo| {
            is_asked.fetch_or(!observer(&info.to_string()), Ordering::Relaxed);
        };
        let asked = || {
            let asked = is_asked.load(Ordering::Relaxed) || stop.load(Ordering::Relaxed);
            asked.then_some(Stop::Interrupt)
        };
        let path = Path::new(path);
        Ok(guarded(|| {
            Self::run(path, &chosen, &limits, &mut told, &asked)
        })?)
    }

    /// Solves the program of a file, which tells its iterations and goes on while there is no reason to stop.
    pub(crate) fn run(
        path: &Path,
        options: &nl::Options,
        limits: &LimitArguments,
        told: &mut (dyn FnMut(&IterationInfo) + Send),
        asked: &(dyn Fn() -> Option<Stop> + Sync),
    ) -> Result<Self, BadInput> {
        let name = path.display().to_string();
        let refused = |what: String| BadInput::new(format!("{name}: {what}"));
        let bytes = read(path)
            .map_err(|error| refused(format!("{error}; give a .nl file that can be read")))?;
        let mut program = open(path, &bytes).map_err(|error| refused(error.to_string()))?;
        drop(bytes);
        let size = ProblemSize::of(&program);
        let solution = nl::solve_with(&mut program, options, &mut |info| {
            told(info);
            asked().is_none()
        })
        .map_err(|error| refused(error.to_string()))?;
        Ok(Self {
            ending: Ending::of_program(&solution, asked(), limits),
            name,
            size,
            program,
            solution,
        })
    }

    /// The line about it on the standard error stream, if it did not end with a solution.
    pub(crate) fn line(&self) -> Option<String> {
        self.ending.line(&self.name)
    }

    /// The result for people.
    pub(crate) fn summary(&self) -> String {
        summary(&self.name, self.size, &self.solution, self.ending.status)
    }

    /// Name of the status.
    #[must_use]
    pub fn status(&self) -> &'static str {
        self.ending.status
    }

    /// What `hangtime nlp` prints with `--json`, in one line.
    #[must_use]
    pub fn json(&self) -> String {
        program_document(&self.name, self.size, &self.solution, &self.ending).text()
    }

    /// The `.sol` file that `hangtime nlp` writes.
    #[must_use]
    pub fn sol(&self) -> String {
        self.solution.file_text(&self.program)
    }

    /// The variables, in the order of the file.
    #[must_use]
    pub fn x(&self) -> &[f64] {
        &self.solution.x
    }

    /// Rates of change of the objective with the right-hand sides of the rows.
    #[must_use]
    pub fn multipliers(&self) -> &[f64] {
        &self.solution.multipliers
    }

    /// Rates of change of the objective with the lower and the upper bounds of the variables.
    #[must_use]
    pub fn bound_multipliers(&self) -> &[Vec<f64>; 2] {
        &self.solution.bound_multipliers
    }

    /// Names of the variables and of the rows: those of the files beside the program, or `x[0]` and `c[0]`.
    #[must_use]
    pub fn names(&self) -> [Vec<String>; 2] {
        [self.program.variable_names(), self.program.row_names()]
    }
}
