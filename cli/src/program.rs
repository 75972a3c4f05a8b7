//! `hangtime nlp`: a program from a `.nl` file, as text, as JSON, and as a `.sol` file.

use std::fs;
use std::path::{Path, PathBuf};

use hangtime::nl::Options;
use hangtime::nlp::IterationInfo;

use crate::arguments::NlpArguments;
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::host_program::HostProgram;
use crate::output::OutputDirectory;
use crate::progress::SolveProgress;
use crate::report::Report;

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
    let bounds = Bounds::watch(name, &arguments.limits);
    let target = arguments.sol.as_deref().map(Target::open).transpose()?;
    let mut display = SolveProgress::new(name);
    let mut options = Options::default();
    options.warm = false;
    options.interrupt = bounds.interrupt();
    let told = &mut |info: &IterationInfo| display.iteration(info);
    let solved = HostProgram::run(path, &options, &arguments.limits, told, &|| bounds.asked())?;
    drop(display);
    drop(bounds);
    let mut report = Report::default();
    report.diagnoses.extend(solved.line());
    let mut written = String::new();
    if let Some(target) = target {
        written = target.deliver(&mut report, solved.sol());
    }
    report.text = if arguments.json {
        solved.json()
    } else {
        solved.summary() + &written
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
