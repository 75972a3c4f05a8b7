//! What several runs come to: the best of them, and the distinct local optima that they saw.

use std::collections::BTreeSet;

use hangtime_solver::Seconds;
use hangtime_solver::mpcc::Stationarity;

use crate::model::Model;
use crate::ocp::solution::{Counts, Improvement, Optimum, Solution, Source, Status};
use crate::ocp::tuning::equal::{COST, OPTIMUM, ROUNDING};
use crate::ocp::tuning::grids::{NO_MOTION, NO_TIME};

/// A motion, or why there is none, and the start that it goes back to.
#[derive(Clone)]
pub(super) struct Found {
    pub(super) start: usize,
    pub(super) source: Source,
    pub(super) solution: Solution,
}

/// The smaller the better: confirmed motions first; among equals the objective.
pub(super) fn rank(solution: &Solution) -> (usize, f64) {
    let class = match solution.status {
        Status::Solved | Status::Uncertified => 0,
        Status::Interrupted if solution.motion.is_some() => 1,
        Status::Unconfirmed | Status::Unbounded => 2,
        _ => 3,
    };
    let objective = if solution.objective.is_nan() {
        f64::INFINITY
    } else {
        solution.objective
    };
    (class, objective)
}

/// Whether a run came to more than another one: of two confirmed motions that cost the same, one that is proved to be an optimum. The
/// later of two that came to nothing knows more, unless it made no motion to speak of and the other one tells what is violated.
pub(super) fn is_better(later: &Found, earlier: &Found) -> bool {
    let (a, b) = (rank(&later.solution), rank(&earlier.solution));
    let solved = |found: &Found| found.solution.status == Status::Solved;
    if costs_the_same(&later.solution, &earlier.solution) && solved(later) != solved(earlier) {
        return solved(later);
    }
    let silent = later.solution.motion.is_none() && later.solution.violations.is_empty();
    let knows = !silent || earlier.solution.violations.is_empty();
    a.0 < b.0 || a.0 == b.0 && a.1 <= b.1 && knows
}

/// Whether two motions are confirmed, and neither of them costs less.
pub(super) fn costs_the_same(one: &Solution, other: &Solution) -> bool {
    let (a, b) = (rank(one), rank(other));
    a.0 == 0 && b.0 == 0 && (a.1 - b.1).abs() <= one.tolerated(COST)
}

/// Whether final times without an end lead to a motion that no other one can beat by more than its own final time: that is the
/// objective.
pub(super) fn ends_at_no_time(model: &dyn Model, solution: &Solution) -> bool {
    let declared = model.declaration().optimal_control;
    let time = solution.horizon;
    solution.status == Status::Unbounded
        && declared.is_some_and(|declared| declared.free_time && !declared.running_cost)
        && (solution.objective - time).abs() <= ROUNDING * time
        && time <= NO_TIME * solution.final_times.1
}

/// The best first.
pub(super) fn sort(found: &mut [Found]) {
    found.sort_by(|a, b| {
        let (a, b) = (rank(&a.solution), rank(&b.solution));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
}

/// Whether two motions count as the same local optimum.
pub(super) fn is_same(a: &Solution, b: &Solution) -> bool {
    agrees(a, b.objective, b.planned_events.len())
}

/// The same of another objective and number of switches.
fn agrees(a: &Solution, objective: f64, switches: usize) -> bool {
    a.planned_events.len() == switches && (a.objective - objective).abs() <= a.tolerated(OPTIMUM)
}

/// The first of the motions that were found, with the work of all runs and the local optima that were seen.
pub(super) fn result(found: Vec<Found>, seen: Vec<Found>, stopped: bool) -> Solution {
    let mut counts = Counts::default();
    let mut seconds = Seconds::default();
    for run in &seen {
        counts.add(&run.solution.counts);
        seconds += run.solution.seconds;
    }
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
    let mut cpu = 0.0;
    let mut found: Vec<Improvement> = Vec::new();
    for Found {
        source, solution, ..
    } in seen
    {
        cpu += solution.seconds.total;
        let (class, objective) = rank(solution);
        let better = |last: &Improvement| objective < last.objective - solution.tolerated(OPTIMUM);
        if class == 0 && found.last().is_none_or(better) {
            found.push(Improvement {
                cpu,
                objective,
                status: solution.status,
                source: *source,
            });
        }
    }
    found
}

/// Adds local optima that were found besides to those of a solution.
pub(super) fn add_optima(solution: &mut Solution, others: Vec<Optimum>) {
    let mut optima = std::mem::take(&mut solution.optima);
    for other in others {
        let same = |known: &&mut Optimum| {
            let apart = (known.objective - other.objective).abs();
            known.switches == other.switches && apart <= solution.tolerated(OPTIMUM)
        };
        match optima.iter_mut().find(same) {
            Some(known) => {
                known.starts.extend(other.starts);
                known.sources.extend(other.sources);
            }
            None => optima.push(other),
        }
    }
    solution.optima = in_order(optima);
}

/// The distinct local optima: the result, and then the others, the best first.
fn optima(best: &Found, seen: Vec<Found>) -> Vec<Optimum> {
    let mut optima: Vec<Optimum> = Vec::new();
    for found in std::iter::once(best.clone()).chain(seen) {
        let Found {
            start,
            source,
            solution,
        } = found;
        let starts = if source == Source::Start(start) {
            vec![start]
        } else {
            Vec::new()
        };
        if solution.motion.is_none() || rank(&solution).0 == 2 {
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
