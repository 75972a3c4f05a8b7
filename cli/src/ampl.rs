//! `hangtime FILE -AMPL [option=value ..]`: the protocol by which AMPL, Pyomo and JuMP call solvers.
//!
//! The answer is a `.sol` file beside the `.nl` file, whatever happens, and the exit status 0; what happened is the number at the end
//! of that file. Options come from the environment variable `hangtime_options` and then from the command line.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use hangtime::nl::{self, Program, Solution};
use hangtime::nlp::IterationInfo;
use hangtime::simulation::ProblemSize;

use crate::arguments::LimitArguments;
use crate::bounds::Bounds;
use crate::failure::{BadInput, one_line};
use crate::output::OutputDirectory;
use crate::program_file::{open, read, summary};
use crate::program_options::{self, OPTIONS, wrong};
use crate::report::Report;

/// The flag that follows the name of the file.
const FLAG: &str = "-AMPL";
/// Where users of modelling languages keep options.
const VARIABLE: &str = "hangtime_options";
/// Lines of the log between headings.
const PAGE: usize = 20;

/// The option that concerns the log, with what it is.
const PRINT_LEVEL: (&str, &str) = (
    "print_level",
    "0: nothing, 1: the result, 2: every iteration (2)",
);
/// Another name of it, as solvers of the same kind have it.
const OUTLEV: &str = "outlev";

/// What the options say.
struct Wishes {
    solve: nl::Options,
    print_level: usize,
}

/// The file and the words after the flag, if the arguments are those of the protocol.
pub(crate) fn call(arguments: &[OsString]) -> Option<(&Path, &[OsString])> {
    let place = arguments.iter().position(|word| word == FLAG)?;
    (place == 2).then(|| (Path::new(&arguments[1]), &arguments[3..]))
}

/// What a call answers by which a modelling language asks what it has before it solves: `-v` for the version, `-=` for the options.
pub(crate) fn told(arguments: &[OsString]) -> Option<String> {
    let [_, question] = arguments else {
        return None;
    };
    let version = format!("hangtime {}\n", env!("CARGO_PKG_VERSION"));
    match question.to_str()? {
        "-v" => Some(version),
        "-=" => {
            let lines = OPTIONS.iter().chain([&PRINT_LEVEL]);
            let lines = lines.map(|(name, meaning)| format!("{name:16} {meaning}\n"));
            Some(lines.collect())
        }
        _ => None,
    }
}

/// Solves the program and writes its `.sol` file; only a file that cannot be read, or a `.sol` file that cannot be written, is an error.
pub(crate) fn run(stub: &Path, words: &[OsString]) -> Result<Report, BadInput> {
    let path = program_path(stub);
    let shown = path.display().to_string();
    let refused = |error: io::Error| {
        BadInput::new(format!(
            "{shown}: {error}; give a .nl file that can be read, or its name without .nl"
        ))
    };
    let bytes = read(&path).map_err(refused)?;
    let target = path.with_extension("sol");
    let (text, answer) = match answer(&path, &bytes, words) {
        Ok(answer) => answer,
        Err(why) => {
            let message = format!("hangtime: {}", one_line(&why));
            let Some(answer) = nl::refusal_text(&bytes, &message) else {
                return Err(BadInput::new(format!("{shown}: {why}")));
            };
            (message + "\n", answer)
        }
    };
    let folder = target
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let folder = OutputDirectory::open_for(FLAG, folder.unwrap_or(Path::new(".")))?;
    let name = target
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let mut report = Report::default();
    report.deliver(folder, &[(name, answer)]);
    report.text = text;
    Ok(report)
}

/// The `.nl` file that AMPL means by its name without the extension.
fn program_path(stub: &Path) -> PathBuf {
    if stub.extension().is_some_and(|extension| extension == "nl") {
        return stub.to_owned();
    }
    let mut name = stub.as_os_str().to_owned();
    name.push(".nl");
    PathBuf::from(name)
}

/// What is printed at the end, and the `.sol` file; or why the program was not solved.
fn answer(path: &Path, bytes: &[u8], words: &[OsString]) -> Result<(String, String), String> {
    let wishes = wishes(words)?;
    let mut program = open(path, bytes).map_err(|error| error.to_string())?;
    let name: &'static str = Box::leak(path.display().to_string().into_boxed_str());
    let limits = LimitArguments::default();
    let bounds = Bounds::watch(name, &limits);
    let mut log = Log::new(wishes.print_level);
    let mut options = wishes.solve;
    options.interrupt = bounds.interrupt();
    let solution = nl::solve_with(&mut program, &options, &mut |info| {
        log.line(info);
        bounds.asked().is_none()
    })
    .map_err(|error| error.to_string())?;
    let text = match wishes.print_level {
        0 => String::new(),
        _ => ended(name, &program, &solution),
    };
    Ok((text, solution.file_text_with_suffixes(&program)))
}

/// The lines after the log.
fn ended(name: &str, program: &Program, solution: &Solution) -> String {
    let mut text = String::from("\n");
    let size = ProblemSize::of(program);
    text += &summary(name, size, solution, solution.status.name());
    if let Some(diagnosis) = solution.diagnosis() {
        let _ = writeln!(text, "diagnosis     {}", one_line(&diagnosis));
    }
    let _ = writeln!(text, "\nhangtime: {}", solution.status.name());
    text
}

/// The log of the iterations, as it happens.
struct Log {
    is_shown: bool,
    lines: usize,
}

impl Log {
    fn new(print_level: usize) -> Self {
        if print_level > 0 {
            // nobody has to read it
            let _ = writeln!(io::stdout(), "hangtime {}", env!("CARGO_PKG_VERSION"));
        }
        Self {
            is_shown: print_level > 1,
            lines: 0,
        }
    }

    fn line(&mut self, info: &IterationInfo) {
        if !self.is_shown {
            return;
        }
        let mut text = String::new();
        if self.lines.is_multiple_of(PAGE) {
            let _ = writeln!(text, "\n{}", IterationInfo::HEADING);
        }
        let _ = writeln!(text, "{info}");
        self.lines += 1;
        let _ = io::stdout().write_all(text.as_bytes());
    }
}

/// What environment and command line ask for.
fn wishes(words: &[OsString]) -> Result<Wishes, String> {
    let variable = std::env::var(VARIABLE).unwrap_or_default();
    let of_line = words.iter().map(|word| word.to_string_lossy().into_owned());
    let mut wishes = Wishes {
        solve: nl::Options::default(),
        print_level: 2,
    };
    let all: Vec<String> = variable
        .split_whitespace()
        .map(str::to_owned)
        .chain(of_line)
        .collect();
    let mut words = all.iter();
    while let Some(word) = words.next() {
        let (name, value) = match word.split_once('=') {
            Some((name, value)) => (name, value),
            None => (word.as_str(), words.next().map_or("", String::as_str)),
        };
        set(&mut wishes, name.trim(), value.trim())?;
    }
    Ok(wishes)
}

/// Takes in one option.
fn set(wishes: &mut Wishes, name: &str, value: &str) -> Result<(), String> {
    match name {
        "print_level" | OUTLEV => {
            let range = "a whole number from 0 to 12";
            let level = value.parse().ok().filter(|level| *level <= 12);
            wishes.print_level = level.ok_or_else(|| wrong(PRINT_LEVEL.0, value, range))?;
            Ok(())
        }
        // by these AMPL and its kin say how the answer goes back, which here is always the same
        "wantsol" | "halt_on_ampl_error" => Ok(()),
        _ => program_options::set(&mut wishes.solve, name, value, &[PRINT_LEVEL]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<OsString> {
        text.split(' ').map(OsString::from).collect()
    }

    #[test]
    fn options_are_taken_with_and_without_an_equals_sign_and_by_other_names() {
        let wishes = wishes(&words(
            "tol=1e-6 max_iter 7 outlev=0 timelim=2.5 warm_start=no",
        ))
        .unwrap();
        assert_eq!(wishes.solve.tolerance, 1e-6);
        assert_eq!(wishes.solve.maximum_iterations, Some(7));
        assert_eq!(wishes.solve.maximum_seconds, 2.5);
        assert!(!wishes.solve.warm && wishes.print_level == 0);
    }

    #[test]
    fn options_out_of_range_and_unknown_ones_are_named_with_what_to_write() {
        let refusal = |text: &str| wishes(&words(text)).err().unwrap();
        assert!(refusal("tol=-1").contains("`tol`: found `-1`; give a number above 0"));
        assert!(refusal("starts=0").contains("whole number from 1"));
        assert!(refusal("max_iters=3").contains("did you mean `max_iter`?"));
    }

    #[test]
    fn protocol_is_known_by_its_flag_and_finds_the_file_by_its_stub() {
        let arguments = words("hangtime dir/a.b -AMPL tol=1e-6");
        let (stub, options) = call(&arguments).unwrap();
        assert_eq!(program_path(stub), Path::new("dir/a.b.nl"));
        assert_eq!(options, words("tol=1e-6"));
        assert_eq!(program_path(Path::new("c.nl")), Path::new("c.nl"));
        assert!(call(&words("hangtime nlp c.nl")).is_none());
    }
}
