//! Whether a plan is a stationary point of its neighbours, too.
//!
//! A neighbour holds the plan as the limit in which a phase has no length: a contact or flight that is inserted, or what lies between a moved
//! switch and the end of the interval that it went through. Its program is hard to solve from there, as it ends where such a phase is as short
//! as it may be, with nearly nothing that fixes what happens within. With these lengths held at their least the program is one of the kind of
//! the plan, and takes few iterations. The multiplier `z` of a held length says what follows from releasing it: where every `z` is at least 0,
//! the point fulfils the first order conditions of the neighbour's program with the bounds of the lengths active, and nothing that is longer by
//! a little is better. That holds all the more where the inequalities inside these phases are left out, since then the program allows more; so
//! it is asked a second time, where the first has no answer.
//!
//! A plan that keeps at the edge of a friction cone, or in a contact without force, has a neighbour for every interval. One program has all of
//! these phases, each of which is as good as none only up to its least length: hence the tolerance of the comparison with the plan. Its
//! multipliers decide each neighbour alone; the others are asked one by one. A cut in an interval with further phases has no place any more.

use std::ops::RangeInclusive;

use hangtime_solver::nlp;

use super::attempt::{Attempt, Attempts, Start, Verdict, interior_point};
use crate::ocp::collocation::program::Collocation;
use crate::ocp::collocation::transcribe::transcribe;
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::ocp::program::runner::{Ended, Run, Runner};
use crate::ocp::tuning::equal::OPTIMUM;
use crate::ocp::tuning::neighbours::{BETWEEN, HELD, PRECISION};

/// What a neighbour's program with held lengths says.
pub(super) enum Held<'a> {
    /// It is stationary with this objective when the lengths are released.
    Stationary(f64),
    /// Longer phases are better, but the motion is another one than the plan, and worse: with an objective like this, infinite if there is none.
    Apart(f64),
    /// Its motion is better than the plan.
    Better(Box<Start<'a>>),
    /// Longer phases are better, or there is no answer.
    Open,
}

/// A program with further phases at their least lengths.
struct AtLeast<'a> {
    program: Collocation<'a>,
    solution: nlp::Solution,
    /// The variables of these lengths.
    lengths: Vec<usize>,
    /// Change of the objective that counts as none.
    none: f64,
}

impl<'a> AtLeast<'a> {
    /// The solution of the program of a sequence with the lengths of phases that the plan has not held at their least, or why it has none;
    /// `relaxed` without the inequalities inside these phases. `None` where there is nothing to hold.
    fn solved(
        attempts: &Attempts<'a, '_>,
        runner: &mut Runner,
        attempt: Attempt,
        relaxed: bool,
    ) -> Option<Ended<Self>> {
        let best = attempts.best.as_ref()?;
        let Attempt {
            sequence,
            guess,
            cuts,
            ..
        } = attempt;
        let mut program = transcribe(attempts.setting, sequence, guess, cuts, attempts.elements);
        let lengths = program.lengths_of_new_phases(&best.program, &best.solution.x);
        if lengths.is_empty() {
            return None;
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
        Some(ended.map(|solution| {
            let size = OPTIMUM * program.program.objective_unit;
            Self {
                none: OPTIMUM * solution.objective.abs().max(size),
                program,
                solution,
                lengths,
            }
        }))
    }

    /// The least change of the objective for an interval of a held length in these intervals; `None` if there is none.
    fn least_slope(&self, attempts: &Attempts, within: &RangeInclusive<usize>) -> Option<f64> {
        let x = self.program.program.physical(&self.solution.x);
        let interval = self.program.horizon_at(&x) / attempts.setting.problem.intervals as f64;
        let phases = self.program.phases.iter();
        let own = phases.filter(|phase| {
            self.lengths.contains(&phase.scale) && within.contains(&phase.interval)
        });
        let slopes = own.map(|phase| {
            let (length, program) = (phase.scale, &self.program.program);
            let multipliers = (
                self.solution.multipliers_lower[length],
                self.solution.multipliers_upper[length],
            );
            let unit = program.objective_unit / program.unit(length);
            (multipliers.0 - multipliers.1) * unit * interval
        });
        slopes.reduce(f64::min)
    }
}

/// What the program of a neighbour of the plan says with the lengths of its new phases held at their least.
pub(super) fn held<'a>(
    attempts: &Attempts<'a, '_>,
    runner: &mut Runner,
    attempt: Attempt,
) -> Held<'a> {
    for relaxed in [false, true] {
        let held = match AtLeast::solved(attempts, runner, attempt, relaxed) {
            None => break,
            Some(Err(nlp::Status::Infeasible)) if !relaxed => return Held::Apart(f64::INFINITY),
            Some(Err(_)) => continue,
            Some(Ok(held)) => held,
        };
        let (objective, none) = (held.solution.objective, held.none);
        if attempts.improves(objective) {
            return match relaxed {
                true => Held::Open,
                false => Held::Better(Box::new((held.program, held.solution))),
            };
        }
        let least = held.least_slope(attempts, &(0..=usize::MAX));
        let best = attempts.best_objective();
        return if least.is_none_or(|least| least >= -none) {
            Held::Stationary(objective)
        } else if best.is_some_and(|best| objective > best + none) {
            Held::Apart(objective)
        } else {
            Held::Open
        };
    }
    Held::Open
}

/// A neighbour with all switches of the plan, and others.
pub(super) struct Insertion<'s> {
    sequence: &'s Sequence,
    switches: Vec<Switch>,
    /// Where these are.
    intervals: RangeInclusive<usize>,
}

impl<'s> Insertion<'s> {
    /// `None` if the neighbour is of another kind.
    pub(super) fn of(sequence: &'s Sequence, plan: &Sequence) -> Option<Self> {
        let starts_alike =
            (&sequence.initially, &sequence.pieces) == (&plan.initially, &plan.pieces);
        let others = |switch: &&Switch| !plan.switches.contains(switch);
        let switches: Vec<Switch> = sequence.switches.iter().filter(others).copied().collect();
        let intervals = switches.first()?.interval..=switches.last()?.interval;
        let has_all = sequence.switches.len() == plan.switches.len() + switches.len();
        (starts_alike && has_all).then_some(Self {
            sequence,
            switches,
            intervals,
        })
    }
}

/// Asks for these neighbours of the plan, whose sequence is `around`, as many at once as have their phases apart from each other, and keeps what
/// is decided.
pub(super) fn learn_together(
    attempts: &mut Attempts,
    runner: &mut Runner,
    mut insertions: Vec<Insertion>,
    around: Attempt,
) {
    while insertions.len() > 1 && !runner.is_exhausted() {
        let mut taken = vec![false; attempts.setting.problem.intervals + 1];
        let (round, left) = insertions.into_iter().partition::<Vec<_>, _>(|insertion| {
            let (first, last) = (*insertion.intervals.start(), *insertion.intervals.end());
            let free = !taken[first..=last].contains(&true);
            if free {
                let from = first.saturating_sub(BETWEEN);
                let to = (last + BETWEEN).min(taken.len() - 1);
                taken[from..=to].fill(true);
            }
            free
        });
        insertions = left;
        let mut sequence = around.sequence.clone();
        let inserted = round.iter().flat_map(|insertion| &insertion.switches);
        sequence.switches.extend(inserted);
        let sequence = sequence.ordered(attempts.setting.problem.intervals);
        let Some(sequence) = sequence.filter(|_| round.len() > 1) else {
            continue;
        };
        let attempt = Attempt {
            sequence: &sequence,
            ..around
        };
        let at_plan = |held: &AtLeast| {
            let best = attempts.best_objective();
            let apart = best.map(|best| held.solution.objective - best);
            apart.is_some_and(|apart| (-PRECISION * held.none..=held.none).contains(&apart))
        };
        let mut solved = [false, true].into_iter().filter_map(|relaxed| {
            let solved = AtLeast::solved(attempts, runner, attempt, relaxed)?;
            solved.ok().filter(at_plan)
        });
        let Some((held, best)) = solved.next().zip(attempts.best_objective()) else {
            continue;
        };
        for insertion in round {
            let least = held.least_slope(attempts, &insertion.intervals);
            if least.is_some_and(|least| least >= -held.none) {
                attempts.learn(insertion.sequence, Verdict::NotBetter(best));
            }
        }
    }
}
