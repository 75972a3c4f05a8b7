//! Words on the grid: the best places of their switches, and the plans that these come to.

use crate::ocp::motion::candidate::Candidate;
use crate::ocp::program::runner::Runner;
use crate::ocp::search::attempt::{Attempt, Attempts, Local, Purpose};
use crate::ocp::search::readings::Readings;
use crate::ocp::tuning::equal::OPTIMUM;
use crate::ocp::tuning::on_grid::{BEYOND, FINE, JUDGED, LEAST, MOVED, MOVED_WITHIN, NEAR, PLACED};
use crate::ocp::words::off_grid::Timed;
use crate::ocp::words::on_grid::{Grid, Placed};

/// The grids that words are put on, on the way to one with that many intervals: the coarsest and the finest that it contains, or one that is
/// near. What is found on the first one is a candidate on the next, so that a finer grid ends at nothing worse.
pub(super) fn grids(intervals: usize) -> Vec<usize> {
    let divides = |coarser: &usize| intervals.is_multiple_of(*coarser);
    let contained: Vec<usize> = (LEAST..=FINE.min(intervals)).filter(divides).collect();
    let near = intervals.div_ceil(intervals.div_ceil(FINE));
    let mut grids = vec![*contained.first().unwrap_or(&near)];
    grids.extend(contained.last().filter(|last| **last > grids[0]));
    grids
}

/// A plan to begin with on the grid, and how it is read.
pub(super) type Begun = (Candidate, Readings);

/// Plans on the grid.
pub(super) struct Plans {
    /// The best first.
    pub(super) begun: Vec<Begun>,
    /// Whether what their elements leave out between stages costs the best word more than is let be.
    pub(super) cost: bool,
}

/// What the best words come to on the grid.
pub(super) fn on_grid(runner: &mut Runner, words: &[Timed], grids: &[Grid]) -> Plans {
    let placed = placed(runner, words, grids);
    let moved = moved(runner, words, placed, grids);
    let mut plans = solved(runner, &moved, grids);
    if plans.begun.is_empty() {
        // What their motions do otherwise may be a plan where they are none themselves.
        let reached = moved.into_iter().filter(|(placed, _)| placed.reaches());
        let reached = reached
            .take(JUDGED)
            .map(|(placed, _)| (placed.candidate, Readings::All));
        plans.begun.extend(reached);
    }
    plans
}

/// A word on the grid, and the index of the word, whose units it has.
type OnGrid = (Placed, usize);

/// Adds a word behind those that are better.
fn insert(all: &mut Vec<OnGrid>, one: OnGrid) {
    let place = all.partition_point(|(other, _)| other.rank() < one.0.rank());
    all.insert(place, one);
}

/// The words with their switches rounded to the grid, the best first.
fn placed(runner: &mut Runner, words: &[Timed], grids: &[Grid]) -> Vec<OnGrid> {
    let mut placed: Vec<OnGrid> = Vec::new();
    for (index, (word, grid)) in words.iter().zip(grids).enumerate() {
        let reached = placed.iter().find(|(best, _)| best.reaches());
        let least = reached.map_or(f64::INFINITY, |(best, _)| best.merit);
        let enough = index >= PLACED && least.is_finite();
        let hopeless = runner.ledger.is_hopeless(word.merit);
        if enough || hopeless || runner.stopped() || word.merit > least + BEYOND * least.abs() {
            continue;
        }
        if let Some(best) = grid.rounded(runner, word) {
            insert(&mut placed, (best, index));
        }
    }
    placed
}

/// The same with the switches of the best ones moved to other intervals where these cost more than they have to, and through the ends of
/// their intervals.
fn moved(runner: &mut Runner, words: &[Timed], placed: Vec<OnGrid>, grids: &[Grid]) -> Vec<OnGrid> {
    let least = placed.first().map_or(f64::INFINITY, |(best, _)| best.merit);
    let mut moved: Vec<OnGrid> = Vec::new();
    for (rank, (best, index)) in placed.into_iter().enumerate() {
        let near = !best.reaches() || best.merit <= least + MOVED_WITHIN * least.abs();
        let uses = |rule: &str| rank < MOVED && near && runner.settings.uses(rule);
        let (shifts, goes_through) = (uses("shift"), uses("through"));
        let mut best = best;
        if shifts {
            best = grids[index].shifted(runner, &words[index], best);
        }
        if goes_through {
            best = grids[index].moved(runner, &words[index], best);
        }
        insert(&mut moved, (best, index));
    }
    moved
}

/// The best ones that reach the goals, solved exactly, the best first.
fn solved(runner: &mut Runner, moved: &[OnGrid], grids: &[Grid]) -> Plans {
    let mut plans: Vec<Candidate> = Vec::new();
    let mut cost = None;
    for (placed, index) in moved.iter().filter(|(placed, _)| placed.reaches()) {
        if plans.len() >= JUDGED || runner.stopped() {
            break;
        }
        if runner.ledger.is_outdone(placed.merit) {
            continue;
        }
        let grid = &grids[*index];
        let mut attempts = Attempts::new(grid.setting, grid.elements);
        let attempt = Attempt {
            sequence: &placed.candidate.sequence,
            guess: &placed.candidate.trajectory,
            cuts: &[],
            purpose: Purpose::Near,
        };
        attempts.attempt(runner, attempt);
        let least = attempts
            .best
            .as_ref()
            .map_or(f64::INFINITY, |best| best.cost);
        let most = placed.merit + NEAR * placed.merit.abs();
        cost.get_or_insert(least > most);
        // Words that differ in phases of no length come to the same plan.
        let same = |best: &Local| {
            let signature = best.sequence.signature();
            let mut plans = plans.iter();
            plans.any(|plan| {
                let apart = (plan.objective - best.cost).abs();
                apart <= OPTIMUM * plan.objective.abs() && plan.sequence.signature() == signature
            })
        };
        if let Some(best) = attempts.best.take().filter(|best| !same(best)) {
            let place = plans.partition_point(|other| other.objective < best.cost);
            let plan = Candidate {
                objective: best.cost,
                sequence: best.sequence,
                trajectory: best.trajectory,
            };
            plans.insert(place, plan);
        }
    }
    let begun = plans.into_iter().map(|plan| (plan, Readings::Own));
    Plans {
        begun: begun.collect(),
        cost: cost.unwrap_or(false),
    }
}
