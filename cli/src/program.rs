//! `hangtime nlp`: a program from a `.nl` file, as text, as JSON, and as a `.sol` file.

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use hangtime::mpcc::Mpcc as _;
use hangtime::mpcc::Stationarity;
use hangtime::nl::{self, Options, Program, Solution};
use hangtime::simulation::ProblemSize;

use crate::arguments::NlpArguments;
use crate::bounds::Bounds;
use crate::cells::regular_bytes;
use crate::ending::Ending;
use crate::failure::{BadInput, one_line};
use crate::json::ProgramDocument;
use crate::output::OutputDirectory;
use crate::progress::SolveProgress;
use crate::report::Report;
use crate::table::{counted, residual_line, seconds};

/// Most bytes of a file: its program takes about ten times as much memory.
const MOST_BYTES: u64 = 500_000_000;

pub(crate) fn run(arguments: &NlpArguments) -> Result<Report, BadInput> {
    let path = &arguments.file;
    let shown = path.display().to_string();
    // The watcher names the run for as long as the program runs.
    let name: &'static str = Box::leak(shown.clone().into_boxed_str());
    if let Some(sol) = arguments.sol.as_deref().filter(|sol| is_same(path, sol)) {
        return Err(BadInput::new(format!(
            "--sol `{}`: this is the program itself, which would be lost; give another file",
            sol.display()
        )));
    }
    let target = arguments.sol.as_deref().map(Target::open).transpose()?;
    let bounds = Bounds::watch(name, &arguments.limits);
    let refused = |what: String| BadInput::new(format!("{shown}: {what}"));
    let bytes = read(path)
        .map_err(|error| refused(format!("{error}; give a .nl file that can be read")))?;
    let mut program = open(path, &bytes).map_err(|error| refused(error.to_string()))?;
    drop(bytes);
    let size = ProblemSize::of(&program, program.complementarities().len());
    let mut display = SolveProgress::new(name);
    let mut options = Options::default();
    options.warm = false;
    options.interrupt = bounds.interrupt();
    let solution = nl::solve_with(&mut program, &options, &mut |info| {
        display.iteration(info, bounds.asked())
    })
    .map_err(|error| refused(error.to_string()))?;
    drop(display);
    let ending = Ending::of_program(&solution, bounds.asked(), &arguments.limits);
    drop(bounds);
    let mut report = Report::default();
    report.diagnoses.extend(ending.line(name));
    let mut written = String::new();
    if let Some(target) = target {
        written = target.deliver(&mut report, solution.file_text(&program));
    }
    report.text = if arguments.json {
        ProgramDocument::new(name, size, &solution, &ending).text()
    } else {
        summary_of(name, size, &solution, ending.status) + &written
    };
    Ok(report)
}

/// Whether two names are those of one file, links followed.
fn is_same(one: &Path, other: &Path) -> bool {
    match (fs::canonicalize(one), fs::canonicalize(other)) {
        (Ok(one), Ok(other)) => one == other,
        _ => false,
    }
}

/// Where the solution goes.
enum Target {
    /// A file of this name, written whole.
    File(OutputDirectory, String),
    /// Something that is there and is no file, such as a pipe.
    Stream(PathBuf),
}

impl Target {
    /// Finds out before the run whether `path` can be written.
    fn open(path: &Path) -> Result<Self, BadInput> {
        if path.exists() && !path.is_file() && !path.is_dir() {
            return Ok(Self::Stream(path.to_owned()));
        }
        let name = path.file_name().filter(|_| !path.is_dir());
        let Some(name) = name.and_then(|name| name.to_str()) else {
            return Err(BadInput::new(format!(
                "--sol `{}`: give the name of a file",
                path.display()
            )));
        };
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let folder = OutputDirectory::open_for("--sol", folder)?;
        Ok(Self::File(folder, name.to_owned()))
    }

    /// Writes `text`; the line about it, or why it could not be written, goes into the report.
    fn deliver(self, report: &mut Report, text: String) -> String {
        match self {
            Self::File(folder, name) => report.deliver(folder, &[(name, text)]),
            Self::Stream(path) => match fs::write(&path, text) {
                Ok(()) => format!("wrote {}\n", path.display()),
                Err(error) => {
                    let refusal = format!(
                        "{}: {error}; give --sol a file that can be written",
                        path.display()
                    );
                    report.refusals.push(refusal);
                    String::new()
                }
            },
        }
    }
}

/// The bytes of a file, as many as are allowed.
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    regular_bytes(path, MOST_BYTES)
}

/// The program of these bytes of the file `path`, with the names in the files beside it.
pub(crate) fn open(path: &Path, bytes: &[u8]) -> Result<Program, nl::ReadError> {
    let names = |extension| names(&path.with_extension(extension));
    Program::read_named(bytes, names("col"), names("row"))
}

/// The lines of a file with names, if there is one.
fn names(path: &Path) -> Vec<String> {
    let text = read(path).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    text.lines().map(|line| line.trim().to_owned()).collect()
}

/// The result for people.
pub(crate) fn summary(name: &str, program: &Program, solution: &Solution) -> String {
    let size = ProblemSize::of(program, program.complementarities().len());
    summary_of(name, size, solution, solution.status.name())
}

/// The result for people, with the status of a run that may have been asked to end.
fn summary_of(name: &str, size: ProblemSize, solution: &Solution, status: &str) -> String {
    let mut text = format!("{}\n\n", one_line(name));
    let _ = writeln!(
        text,
        "size          {}, {}, {}, {}",
        counted(size.variables, "variable"),
        counted(size.equalities, "equation"),
        counted(size.inequalities, "inequality row"),
        counted(size.complementarities, "pair"),
    );
    let _ = writeln!(text, "status        {status}");
    let _ = writeln!(text, "objective     {:.10e}", solution.objective);
    let meaning = match (solution.stationarity, size.complementarities) {
        (Stationarity::S, 0) => "the optimality conditions hold",
        (Stationarity::S, _) => "strongly stationary",
        (Stationarity::B, _) => "no choice of vanishing sides has a descent direction",
        _ => "nothing is proved about the point",
    };
    let _ = writeln!(
        text,
        "stationarity  {}: {meaning}",
        solution.stationarity.name()
    );
    if let Some(second_order) = solution.second_order {
        let _ = writeln!(
            text,
            "second order  {}: {}",
            second_order.name(),
            second_order.meaning()
        );
    }
    let _ = writeln!(text, "residuals     {}", residual_line(solution.residuals));
    let _ = writeln!(
        text,
        "counts        {}, {} of them in crossovers, {}",
        counted(solution.work.iterations, "interior point iteration"),
        solution.work.crossover_iterations,
        counted(solution.work.factorizations, "factorization"),
    );
    let _ = writeln!(text, "CPU time      {}", seconds(solution.work.seconds));
    text
}
