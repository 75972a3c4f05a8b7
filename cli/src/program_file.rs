//! Programs in `.nl` files: how they are read, and what is told of their solutions.

use std::fmt::Write as _;
use std::io;
use std::path::Path;

use hangtime::mpcc::Stationarity;
use hangtime::nl::{self, Program, Solution};
use hangtime::simulation::ProblemSize;

use crate::cells::regular_bytes;
use crate::failure::one_line;
use crate::table::{counted, residual_line, seconds};

/// Most bytes of a file: its program takes about ten times as much memory.
const MOST_BYTES: u64 = 500_000_000;

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

/// The result for people, with the status of a run that may have been asked to end.
pub(crate) fn summary(name: &str, size: ProblemSize, solution: &Solution, status: &str) -> String {
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
