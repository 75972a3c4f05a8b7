//! Programs from files in the hands of another program, such as an interpreter: the numbers are those of `hangtime nlp --json`.

use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use hangtime::mpcc::Mpcc as _;
use hangtime::nl::{self, Program, Solution};
use hangtime::nlp::Interrupt;
use hangtime::simulation::ProblemSize;

use crate::arguments::{LimitArguments, MEMORY_LIMIT};
use crate::ending::{Ending, Stop};
use crate::failure::BadInput;
use crate::host::{Refusal, guarded};
use crate::json::ProgramDocument;
use crate::program::{open, read};
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
        let refused = |what: String| BadInput::new(format!("{path}: {what}"));
        let mut chosen = nl::Options::default();
        chosen.warm = false;
        for (name, value) in options {
            program_options::set(&mut chosen, name, value, &[]).map_err(BadInput::new)?;
        }
        chosen.interrupt = Interrupt::by(Arc::clone(stop));
        let bytes = read(Path::new(path))
            .map_err(|error| refused(format!("{error}; give a .nl file that can be read")))?;
        let mut is_asked = false;
        let (program, solution) = guarded(|| {
            let mut program =
                open(Path::new(path), &bytes).map_err(|error| refused(error.to_string()))?;
            let solution = nl::solve_with(&mut program, &chosen, &mut |info| {
                is_asked |= !observer(&info.to_string());
                !is_asked
            });
            let solution = solution.map_err(|error| refused(error.to_string()))?;
            Ok((program, solution))
        })?;
        let limits = LimitArguments {
            time_limit: None,
            memory_limit: MEMORY_LIMIT,
        };
        Ok(Self {
            name: path.to_owned(),
            size: ProblemSize::of(&program, program.complementarities().len()),
            // nothing but the host interrupts
            ending: Ending::of_program(&solution, Some(Stop::Interrupt), &limits),
            program,
            solution,
        })
    }

    /// Name of the status.
    #[must_use]
    pub fn status(&self) -> &'static str {
        self.ending.status
    }

    /// What `hangtime nlp` prints with `--json`, in one line.
    #[must_use]
    pub fn json(&self) -> String {
        ProgramDocument::new(&self.name, self.size, &self.solution, &self.ending).text()
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
