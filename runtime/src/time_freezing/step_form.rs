//! The program of the time-freezing system.

use super::field::Field;
use super::task::{Outer, Task};
use super::transcription::Transcription;
use super::{conditions, guess, known, rows};
use crate::program::sparse_program::Program;
use crate::rk::ButcherTableau;

/// Adds the variables and rows of `task`, which has at least one interval and element, to a program that has those of `outer`.
/// Where the motion is known, what vanishes in it is fixed.
pub(crate) fn transcribe<'a>(
    program: Program<'a>,
    outer: Outer,
    field: Field<'a>,
    tableau: &ButcherTableau,
    task: Task,
) -> Transcription<'a> {
    let mut transcription = Transcription::new(program, outer, field, tableau, task);
    conditions::add_pairs(&mut transcription);
    guess::set_guess(&mut transcription);
    rows::add(&mut transcription);
    known::fix_sides(&mut transcription);
    transcription
}
