//! What several runs come to: the best of them, and the distinct local optima that they saw.

use std::collections::BTreeSet;

use hangtime_solver::Seconds;
use hangtime_solver::mpcc::Stationarity;

use crate::ocp::solution::{Counts, Improvement, Optimum, Solution, Source, Status};
use crate::ocp::tuning::equal::{COST, OPTIMUM};
use crate::ocp::tuning::grids::NO_MOTION;

/// A motion, or why there is none, where it was found, and when.
#[derive(Clone)]
pub(super) struct Found {
    pub(super) source: Source,
    /// CPU time of the call until then \[s\].
    pub(super) cpu: f64,
    pub(super) solution: Solution,
}

/// What was done, and the CPU time that it took.
pub(super) type Work = (Counts, Seconds);

/// Whether the re-simulation confirms a motion.
pub(super) fn is_confirmed(solution: &Solution) -> bool {
    matches!(solution.status, Status::Solved | Status::Uncertified)
}

/// The smaller the better: confirmed motions first, and of these the ones on equal intervals, which are asked for unless all are aligned
/// with phases; among equals the objective.
pub(super) fn rank(solution: &Solution) -> (usize, f64) {
    let class = match solution.status {
        _ if is_confirmed(solution) => usize::from(solution.is_aligned()),
        Status::Interrupted if solution.motion.is_some() => 2,
        Status::Unconfirmed | Status::Unbounded => 3,
        _ => 4,
    };
    let objective = if solution.objective.is_nan() {
        f64::INFINITY
    } else {
        solution.objective
    };
    (class, objective)
}

/// Whether two motions are confirmed on intervals of one kind, and neither of them costs less.
pub(super) fn costs_the_same(one: &Solution, other: &Solution) -> bool {
    let (a, b) = (rank(one), rank(other));
    is_confirmed(one) && a.0 == b.0 && (a.1 - b.1).abs() <= one.tolerated(COST)
}

/// Whether a solution came to as much as another one: to one that is confirmed sooner than to one that is not, else to an
/// objective that is not worse.
pub(super) fn is_as_good(solution: &Solution, kept: &Solution) -> bool {
    let (a, b) = (rank(solution), rank(kept));
    a.0 < b.0 || a.0 == b.0 && a.1 <= b.1 + kept.tolerated(OPTIMUM)
}

/// The best first; of those that cost the same one that is proved to be an optimum.
pub(super) fn sort(found: &mut [Found]) {
    found.sort_by(|a, b| {
        let (a, b) = (rank(&a.solution), rank(&b.solution));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let proved = found.iter().position(|one| {
        one.solution.status == Status::Solved && costs_the_same(&one.solution, &found[0].solution)
    });
    if let Some(proved) = proved {
        found[..=proved].rotate_right(1);
    }
}

/// Whether a motion counts as the same local optimum as one of that objective and number of switches.
fn agrees(a: &Solution, objective: f64, switches: usize) -> bool {
    a.planned_events.len() == switches && (a.objective - objective).abs() <= a.tolerated(OPTIMUM)
}

/// The first of the motions that were found, with the work of all runs and the local optima that were seen.
pub(super) fn result(
    found: Vec<Found>,
    mut seen: Vec<Found>,
    (counts, seconds): Work,
    stopped: bool,
) -> Solution {
    // A plan that its re-simulation contradicts is no motion that a run which was stopped has come to.
    let contradicted = |Found { solution, .. }: &Found| {
        stopped && solution.motion.is_some() && solution.departure > NO_MOTION
    };
    let best = found.into_iter().next();
    let Some(best) = best.filter(|best| !contradicted(best)) else {
        return Solution {
            seconds,
            ..Solution::without_motion(Status::Interrupted, Vec::new(), counts)
        };
    };
    // Beside a plan on equal intervals those that are aligned with phases are of another problem.
    seen.retain(|run| best.solution.is_aligned() || !run.solution.is_aligned());
    let improvements = improvements(&seen);
    let starts = seen.iter().filter_map(|run| match run.source {
        Source::Start(start) => Some(start),
        _ => None,
    });
    let starts: BTreeSet<usize> = starts.collect();
    let optima = optima(&best, seen);
    let (status, stationarity) = if stopped {
        (Status::Interrupted, Stationarity::None)
    } else {
        (best.solution.status, best.solution.stationarity)
    };
    Solution {
        status,
        stationarity,
        counts,
        seconds,
        starts: starts.len(),
        optima,
        improvements,
        ..best.solution
    }
}

/// The motions that were confirmed and better than all before them.
fn improvements(seen: &[Found]) -> Vec<Improvement> {
    let mut found: Vec<Improvement> = Vec::new();
    for Found {
        source,
        cpu,
        solution,
    } in seen
    {
        let (_, objective) = rank(solution);
        let better = |last: &Improvement| objective < last.objective - solution.tolerated(OPTIMUM);
        if is_confirmed(solution) && found.last().is_none_or(better) {
            found.push(Improvement {
                cpu: *cpu,
                objective,
                status: solution.status,
                source: *source,
            });
        }
    }
    found
}

/// The distinct local optima: the result, and then the others, the best first.
fn optima(best: &Found, seen: Vec<Found>) -> Vec<Optimum> {
    let mut optima: Vec<Optimum> = Vec::new();
    for found in std::iter::once(best.clone()).chain(seen) {
        let Found {
            source, solution, ..
        } = found;
        let starts = match source {
            Source::Start(start) => vec![start],
            Source::Guess | Source::Words => Vec::new(),
        };
        if solution.motion.is_none() || rank(&solution).0 == 3 {
            continue;
        }
        let switches = solution.planned_events.len();
        let same = |other: &&mut Optimum| agrees(&solution, other.objective, other.switches);
        if let Some(known) = optima.iter_mut().find(same) {
            known.starts.extend(starts);
            known.sources.push(source);
            continue;
        }
        optima.push(Optimum {
            objective: solution.objective,
            horizon: solution.horizon,
            status: solution.status,
            stationarity: solution.stationarity,
            switches,
            intervals: solution.elements.len(),
            starts,
            sources: vec![source],
        });
    }
    in_order(optima)
}

/// The first optimum, and then the others, the best first; what they were found from without repetition.
fn in_order(mut optima: Vec<Optimum>) -> Vec<Optimum> {
    for optimum in &mut optima {
        optimum.starts.sort_unstable();
        optimum.starts.dedup();
        optimum.sources.sort_unstable();
        optimum.sources.dedup();
    }
    if let Some((_, others)) = optima.split_first_mut() {
        others.sort_by(|a, b| a.objective.total_cmp(&b.objective));
    }
    optima
}
