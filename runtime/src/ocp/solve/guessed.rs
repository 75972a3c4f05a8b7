//! The motion of the scene's own guess, from its start and with its free parameters under controls that are nearest to none: where it meets
//! the goals no result is worse.

use super::nearest::on_straight;
use super::optima::{Found, rank, result};
use super::run::Task;
use super::shared_observer::SharedObserver;
use crate::Observer;
use crate::model::{Given, Model, held};
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::effort::Effort;
use crate::ocp::judge::confirm::report;
use crate::ocp::judge::incumbent::incumbent;
use crate::ocp::motion::targets::goal_values;
use crate::ocp::problem::{Horizon, Problem};
use crate::ocp::search::replay::simulate;
use crate::ocp::search::throw::{End, Throw, ends};
use crate::ocp::settings::Settings;
use crate::ocp::solution::{Solution, Source, Status};
use crate::ocp::tuning::equal::{COST, ROUNDING};
use crate::ocp::tuning::on_grid::SIMULATED;
use crate::ocp::tuning::sampled::LONGER;
use crate::simulation::InputError;

/// A problem on a scene, and how it is solved.
type Scene<'s> = (&'s dyn Model, &'s Problem, &'s Settings);

/// The motion of the guess, where it meets all goals and bounds: where the final time is free up to where it costs least.
pub(super) fn guessed(
    (model, problem, settings): Scene,
    observer: &mut Observer<'_>,
) -> Result<Option<Solution>, InputError> {
    let length = problem.length(model);
    let given = Problem {
        horizon: Horizon::Fixed(length),
        ..problem.clone()
    };
    // A time that parameters give is that of their declared values.
    let own = match held::place(model, Given::Horizon) {
        Some(_) => &given,
        None => problem,
    };
    let best = on_straight(model, own, settings, |setting, straight| {
        let longest = match own.horizon {
            Horizon::Fixed(horizon) => horizon,
            Horizon::Free { .. } => LONGER * straight.horizon.max(length),
        };
        let throw = Throw {
            start: problem.start(),
            controls: straight.controls.clone(),
            horizon: longest,
        };
        let all = ends(setting, &throw, longest, usize::MAX);
        let at_start = goal_values(model, &[&throw.start[..], &[longest]].concat());
        // How far a plan may be from its re-simulation says nothing of how far a guess may be from its goals.
        let share = settings
            .largest_distance
            .min(Settings::default().largest_distance);
        let most = |(k, at_start): (usize, &f64)| {
            let values = all.iter().map(|end| end.missing[k].abs());
            share * values.fold(at_start.abs(), f64::max)
        };
        let largest: Vec<f64> = at_start.iter().enumerate().map(most).collect();
        let mut best: Option<Solution> = None;
        for horizon in places(setting, settings, (&all, &largest))? {
            let found = incumbent(setting, settings, (&throw.over(horizon), &largest))?;
            let cost = best.as_ref().map_or(f64::INFINITY, |best| best.objective);
            best = found.filter(|found| found.objective < cost).or(best);
        }
        Ok(best)
    })
    // Where it cannot be simulated it is none.
    .unwrap_or_default();
    if let Some(best) = &best {
        let observer = SharedObserver::new(observer);
        let task = Task::new((model, problem, settings), &observer);
        task.run(Effort::Quick, |runner| {
            report(runner, best);
            Ok(())
        })?;
    }
    Ok(best)
}

/// Final times at which a motion may meet its goals within these distances: the cheapest of its places that do, and those between two places
/// where goals that are equations hold.
fn places(
    setting: Setting,
    settings: &Settings,
    (all, largest): (&[End], &[f64]),
) -> Result<Vec<f64>, InputError> {
    let inside = |end: &End| end.missing[largest.len()..].iter().all(|m| *m <= ROUNDING);
    let meets = |end: &&End| {
        let mut goals = end.missing.iter().zip(largest);
        inside(end) && goals.all(|(m, l)| m.abs() <= *l)
    };
    let met = all.iter().filter(meets);
    let cheapest = met.min_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut found: Vec<f64> = cheapest.map(|end| end.throw.horizon).into_iter().collect();
    for pair in all.windows(2).filter(|pair| inside(&pair[1])) {
        let crosses = |k: &usize| pair[0].missing[*k] * pair[1].missing[*k] < 0.0;
        let Some(goal) = (0..largest.len()).find(crosses) else {
            continue;
        };
        if found.len() < SIMULATED {
            found.extend(crossing(setting, settings, (pair, goal))?);
        }
    }
    Ok(found)
}

/// When a goal holds between two places of a motion, on one side of which it is missed one way and on the other the other way.
fn crossing(
    setting: Setting,
    settings: &Settings,
    (pair, goal): (&[End], usize),
) -> Result<Option<f64>, InputError> {
    let [mut from, mut to] = [0, 1].map(|k: usize| pair[k].throw.horizon);
    let before = pair[0].missing[goal];
    while to - from > ROUNDING * to {
        let horizon = 0.5 * (from + to);
        let driven = pair[1].throw.over(horizon);
        let motion = simulate(setting, &driven, None, (settings.resimulation_tolerance, 1))?;
        let (q, v) = (motion.trajectory.q.last(), motion.trajectory.v.last());
        let (Some(q), Some(v)) = (q, v) else {
            return Ok(None);
        };
        let missing = goal_values(setting.model, &[&q[..], v, &[horizon]].concat())[goal];
        match missing * before > 0.0 {
            true => from = horizon,
            false => to = horizon,
        }
    }
    Ok(Some(to))
}

/// A result, or the motion of the guess where that is better: with its contact sequence solved where that leads further.
pub(super) fn no_worse(
    (model, problem, settings): Scene,
    observer: &mut Observer<'_>,
    known: Solution,
    guessed: Solution,
) -> Result<Solution, InputError> {
    let outdone = match rank(&known) {
        (0..=2, objective) => objective > guessed.objective + known.tolerated(COST),
        // A plan that is not confirmed, or has no best length, says more.
        (3, _) => false,
        _ => true,
    };
    if !outdone {
        return Ok(known);
    }
    let observer = SharedObserver::new(observer);
    let task = Task::new((model, problem, settings), &observer);
    let interrupted = known.status == Status::Interrupted;
    let carry = || task.run(Effort::Conclude, |runner| task.carry(runner, &guessed));
    // Where its sequence has no program that can be started the motion stays as it is.
    let carried = (!interrupted).then(carry).and_then(Result::ok);
    let (best, work) = carried.unwrap_or_else(|| (guessed, Default::default()));
    let (mut counts, mut seconds) = (known.counts, known.seconds);
    counts.add(&work.0);
    seconds += work.1;
    let found = |source: Source, solution: &Solution| Found {
        source,
        cpu: seconds.total,
        solution: solution.clone(),
    };
    let best = found(Source::Guess, &best);
    let seen = vec![found(Source::Words, &known), best.clone()];
    let stopped = interrupted || observer.stopped();
    Ok(Solution {
        starts: known.starts,
        bound: known.bound,
        words: known.words,
        final_times: known.final_times,
        time_freezing: known.time_freezing,
        ..result(vec![best], seen, (counts, seconds), stopped)
    })
}
