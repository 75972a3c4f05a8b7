//! Programs as texts of `.nl` files.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use hangtime_solver::nl::{self, Program, Solution};

/// A program whose variables are nonlinear everywhere: bodies of the rows, the objective, the start, bounds of rows, bounds of variables and
/// further segments, all in words.
pub(crate) fn program(sizes: (usize, usize), rows: &[&str], objective: &str, rest: &str) -> String {
    let (variables, count) = sizes;
    let mut text = format!(
        "g3 1 1 0\n {variables} {count} 1 0 0\n {count} 1\n 0 0\n {variables} {variables} {variables}\n 0 0 0 1\n \
         0 0 0 0 0\n 0 0\n 0 0\n 0 0 0 0 0\n"
    );
    let lines = |words: &str| words.split_whitespace().collect::<Vec<_>>().join("\n") + "\n";
    for (index, row) in rows.iter().enumerate() {
        text += &format!("C{index}\n{}", lines(row));
    }
    text += &format!("O0 0\n{}", lines(objective));
    text + rest
}

/// Solved with the default settings.
pub(crate) fn solve(text: &str) -> Solution {
    let mut program = Program::read(text.as_bytes()).unwrap();
    nl::solve(&mut program, 60.0, &mut |_| true).unwrap()
}
