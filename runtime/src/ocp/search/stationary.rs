//! Whether the best motion is a stationary point of a neighbour, too.
//!
//! A neighbour holds the best motion as the limit in which a phase has no length: a contact or flight that is inserted, or
//! what lies between a moved switch and the end of the interval that it went through. Its program is hard to solve from
//! there, as it ends where such a phase is as short as it may be, with nearly nothing that fixes what happens within. With
//! these lengths held at their least the program is one of the kind of the best, and takes few iterations. The multiplier
//! `z` of a held length says what follows from releasing it: where every `z` is at least 0, the point fulfils the first
//! order conditions of the neighbour's program with the bounds of the lengths active, and nothing that is longer by a
//! little is better. That holds all the more where the inequalities inside these phases are left out, since then the
//! program allows more; so it is asked a second time, where the first has no answer.

use hangtime_solver::nlp;

use super::attempt::{Attempt, Attempts, Start, interior_point};
use crate::ocp::collocation::program::Collocation;
use crate::ocp::collocation::transcribe::transcribe;
use crate::ocp::program::runner::{Run, Runner};
use crate::ocp::tuning::equal::OPTIMUM;
use crate::ocp::tuning::neighbours::HELD;
use crate::simulation::InputError;

/// What a neighbour's program with held lengths says.
pub(super) enum Held<'a> {
    /// It is stationary with this objective when the lengths are released.
    Stationary(f64),
    /// Longer phases are better, but the motion is another one than the best, and worse: with an objective like this,
    /// infinite if there is none.
    Apart(f64),
    /// Its motion is better than the best.
    Better(Box<Start<'a>>),
    /// Longer phases are better, or there is no answer.
    Open,
}

/// What the program of a neighbour of the best says with the lengths of its new phases held at their least.
pub(super) fn held<'a>(
    attempts: &Attempts<'a, '_>,
    runner: &mut Runner,
    attempt: Attempt,
) -> Result<Held<'a>, InputError> {
    for relaxed in [false, true] {
        match solve_held(attempts, runner, attempt, relaxed)? {
            Some(Ok(held)) => return Ok(held),
            Some(Err(nlp::Status::Infeasible)) if !relaxed => {
                return Ok(Held::Apart(f64::INFINITY));
            }
            Some(Err(_)) => {}
            None => break,
        }
    }
    Ok(Held::Open)
}

/// `None` where there is nothing to hold.
fn solve_held<'a>(
    attempts: &Attempts<'a, '_>,
    runner: &mut Runner,
    attempt: Attempt,
    relaxed: bool,
) -> Result<Option<Result<Held<'a>, nlp::Status>>, InputError> {
    let Some((program, lengths, ended)) = solved(attempts, runner, attempt, relaxed)? else {
        return Ok(None);
    };
    Ok(Some(ended.map(|solution| {
        if !attempts.improves(solution.objective) {
            return released(attempts, &program, &lengths, &solution);
        }
        match relaxed {
            true => Held::Open,
            false => Held::Better(Box::new((program, solution))),
        }
    })))
}

/// A program whose new phases are held, the variables of their lengths, and its solution or why it has none.
pub(super) type Solved<'a> = (
    Collocation<'a>,
    Vec<usize>,
    Result<nlp::Solution, nlp::Status>,
);

/// Solves the program of a sequence with the lengths of phases that the best has not held at their least, if there are any.
pub(super) fn solved<'a>(
    attempts: &Attempts<'a, '_>,
    runner: &mut Runner,
    attempt: Attempt,
    relaxed: bool,
) -> Result<Option<Solved<'a>>, InputError> {
    let Some(best) = &attempts.best else {
        return Ok(None);
    };
    let Attempt {
        sequence,
        guess,
        cuts,
        ..
    } = attempt;
    let mut program = transcribe(attempts.setting, sequence, guess, cuts, attempts.elements);
    let lengths = program.lengths_of_new_phases(&best.program, &best.solution.x);
    if lengths.is_empty() {
        return Ok(None);
    }
    program.hold(&lengths, relaxed);
    let (barrier, iterations) = HELD;
    let mut settings = interior_point(runner.settings);
    settings.initial_barrier_parameter = barrier;
    settings.maximum_iterations = settings.maximum_iterations.min(iterations);
    settings.bound_push = barrier;
    settings.bound_fraction = barrier;
    let start = program.start_from(&best.program, &best.solution, barrier);
    let run = Run {
        settings: &settings,
        start: Some(&start),
        restores: if relaxed { 0 } else { usize::MAX },
        best: Some(best.solution.objective),
    };
    let ended = runner.solve(&mut program.program, &run);
    Ok(Some((program, lengths, ended)))
}

/// What follows from releasing the lengths of a motion that is no better than the best.
fn released<'a>(
    attempts: &Attempts<'a, '_>,
    program: &Collocation,
    lengths: &[usize],
    held: &nlp::Solution,
) -> Held<'a> {
    let objective = held.objective;
    let none = none(program, objective);
    let slopes = lengths
        .iter()
        .map(|&length| slope(attempts, program, held, length));
    let least = slopes.fold(f64::INFINITY, f64::min);
    if least >= -none {
        Held::Stationary(objective)
    } else if attempts
        .best_objective()
        .is_some_and(|best| objective > best + none)
    {
        Held::Apart(objective)
    } else {
        Held::Open
    }
}

/// Change of the objective for an interval of a held length.
pub(super) fn slope(
    attempts: &Attempts,
    program: &Collocation,
    held: &nlp::Solution,
    length: usize,
) -> f64 {
    let interval = program.horizon_at(&program.program.physical(&held.x))
        / attempts.setting.problem.intervals as f64;
    let multiplier = held.multipliers_lower[length] - held.multipliers_upper[length];
    multiplier * program.program.objective_unit() / program.program.unit(length) * interval
}

/// Change of an objective that counts as none.
pub(super) fn none(program: &Collocation, objective: f64) -> f64 {
    OPTIMUM
        * objective
            .abs()
            .max(OPTIMUM * program.program.objective_unit())
}
