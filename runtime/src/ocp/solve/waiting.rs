//! Free final times where rest costs nothing: the shortest of the motions that cost the same, or the word that there is no best length.
//!
//! A motion that may rest at its start or at its end for nothing is never worse for lasting longer: with `J(T)` the least cost in the time `T`,
//! `J` does not grow. So either `J` is the same from some `T` on, and every greater length is as good; or it falls for ever, and no motion is the
//! best one. A price on the time, `min J(T) + p T`, has a shortest motion in both cases (Tikhonov's choice among minima), and tends to the shortest of
//! the best ones as `p` tends to 0. Twice its time costs less only where there is no best one.

use super::searched::searched;
use crate::Observer;
use crate::model::{Function, Model};
use crate::ocp::motion::final_times::FinalTimes;
use crate::ocp::problem::{Horizon, Problem, bounds, has_free_start};
use crate::ocp::settings::{Formulation, Guess, Settings};
use crate::ocp::solution::{Solution, Status};
use crate::ocp::tuning::equal::ROUNDING;
use crate::ocp::tuning::waiting::{FIRST, LESS, LONGER, SECOND};
use crate::simulation::{ControlSignal, EventDriven, InputError, SimulationStatus, simulate_once};
use hangtime_solver::mpcc::Stationarity;

/// What is said of the shortest of equals.
const SHORTEST: &str =
    "rest costs nothing, so that longer motions cost as much: this is the shortest of them";

/// Settings for a problem whose start may rest for nothing: with a price on the time; none for others.
pub(super) fn hasty(model: &dyn Model, problem: &Problem, settings: &Settings) -> Option<Settings> {
    let waits = asks_nothing_of_time(model, problem, settings)
        && !has_free_start(model)
        && rests(model, problem, &problem.start());
    waits.then(|| with_price(settings, FIRST))
}

/// Whether a plan may rest at its end for nothing, of a problem where that was not known before. One that is proved, and that goals do
/// not let last twice as long, has a best length already.
pub(super) fn ends_at_rest(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    solution: &Solution,
) -> bool {
    let end = solution.motion.as_ref().and_then(|motion| {
        let (q, v) = (motion.trajectory.q.last()?, motion.trajectory.v.last()?);
        Some([&q[..], v].concat())
    });
    let proved = solution.status == Status::Solved && is_bounded(model, solution.horizon);
    asks_nothing_of_time(model, problem, settings)
        && !proved
        && end.is_some_and(|end| rests(model, problem, &end))
}

/// The shortest motion that costs what `known` does, or that motion as one of a problem without a best length.
pub(super) fn shortest(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
    known: Solution,
) -> Result<Solution, InputError> {
    let stopped = |solution: &Solution| solution.status == Status::Interrupted;
    if known.previous.is_none() || stopped(&known) {
        return Ok(known);
    }
    let (dear, found) = again(model, problem, with_price(settings, FIRST), observer, known)?;
    if stopped(&dear) || !is_found(&dear) {
        return Ok(dear);
    }
    let bounded = is_bounded(model, dear.horizon);
    let (mut dear, late) = match bounded || dear.objective <= dear.tolerated(0.0) {
        true => (dear, true),
        false => match longer(model, problem, settings, observer, dear)? {
            Longer::CostsLess(late) => return Ok(endless(*late)),
            Longer::CostsAsMuch(dear) => (*dear, true),
            Longer::Unknown(dear) => (*dear, false),
        },
    };
    // Where neither shows, nothing is proved.
    if dear.status == Status::Solved && !(found && late) {
        dear.status = Status::Uncertified;
        dear.stationarity = Stationarity::None;
    }
    // Where goals bound the time no price has to.
    let price = if bounded { 0.0 } else { SECOND };
    let (mut found, _) = again(model, problem, with_price(settings, price), observer, dear)?;
    if let Some(motion) = found.motion.as_mut().filter(|_| !bounded) {
        motion.notes.push(SHORTEST.to_owned());
    }
    Ok(found)
}

/// Whether goals do not let a motion last twice as long.
fn is_bounded(model: &dyn Model, horizon: f64) -> bool {
    let range = FinalTimes {
        shortest: horizon / LONGER,
        longest: horizon * LONGER,
    };
    range.allowed(model).longest < range.longest
}

/// What twice the time comes to.
enum Longer {
    CostsLess(Box<Solution>),
    /// The motion of which that was asked, as with all others here with the work of both.
    CostsAsMuch(Box<Solution>),
    /// No motion was found.
    Unknown(Box<Solution>),
}

/// Whether a motion of twice the time costs less.
fn longer(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
    dear: Solution,
) -> Result<Longer, InputError> {
    let longer = Problem {
        horizon: Horizon::Fixed(LONGER * dear.horizon),
        ..problem.clone()
    };
    let less = dear.objective - dear.tolerated(LESS);
    let (mut late, mut found) = again(model, &longer, settings.clone(), observer, dear.clone())?;
    if !found || late.objective >= less {
        // A motion that is stretched may lead to a poorer one.
        let mut other = searched(model, &longer, settings, observer)?;
        other.counts.add(&late.counts);
        other.seconds += late.seconds;
        found = is_found(&other);
        late = other;
    }
    if found && late.objective < less {
        return Ok(Longer::CostsLess(Box::new(late)));
    }
    let dear = Box::new(Solution {
        counts: late.counts,
        seconds: late.seconds,
        ..dear
    });
    Ok(match found {
        true => Longer::CostsAsMuch(dear),
        false => Longer::Unknown(dear),
    })
}

/// A plan of a problem without a best length.
fn endless(plan: Solution) -> Solution {
    Solution {
        status: Status::Unbounded,
        stationarity: Stationarity::None,
        is_longest: true,
        ..plan
    }
}

/// A motion, solved once more, and whether that has led to one; as it is where it has not.
fn again(
    model: &dyn Model,
    problem: &Problem,
    settings: Settings,
    observer: &mut Observer<'_>,
    known: Solution,
) -> Result<(Solution, bool), InputError> {
    let Some(previous) = known.previous.clone() else {
        return Ok((known, false));
    };
    let settings = Settings {
        guess: Guess::Previous(Box::new(previous)),
        ..settings
    };
    let mut other = searched(model, problem, &settings, observer)?;
    let (mut counts, mut seconds) = (known.counts, known.seconds);
    counts.add(&other.counts);
    seconds += other.seconds;
    let found = is_found(&other);
    if found {
        other.optima = known.optima;
        other.starts = known.starts;
        other.improvements = known.improvements;
    } else {
        let interrupted = other.status == Status::Interrupted;
        other = known;
        if interrupted {
            other.status = Status::Interrupted;
        }
    }
    let other = Solution {
        counts,
        seconds,
        ..other
    };
    Ok((other, found))
}

fn with_price(settings: &Settings, price: f64) -> Settings {
    Settings {
        haste: price,
        ..settings.clone()
    }
}

fn is_found(solution: &Solution) -> bool {
    matches!(solution.status, Status::Solved | Status::Uncertified)
}

/// Whether the final time is free, the objective does not read it, and the motion is the same whenever it begins.
fn asks_nothing_of_time(model: &dyn Model, problem: &Problem, settings: &Settings) -> bool {
    let declaration = model.declaration();
    let Some(declared) = declaration.optimal_control else {
        return false;
    };
    let costs = declared.running_cost || declared.final_cost;
    let time = 2 * declaration.coordinates.len();
    let mut ends = declared.terminal_jacobian.entries.iter();
    let reads_time = declared.final_cost && ends.any(|e| e.0 == 0 && e.1 as usize == time);
    let reads_forces = declared.contacts.any();
    matches!(problem.horizon, Horizon::Free { .. })
        && matches!(settings.formulation, Formulation::Phases)
        && costs
        && !reads_time
        && !reads_forces
        && !declaration.explicit_time
}

/// Whether a state `(q, v)` is at rest without controls, or with those nearest to 0, keeps all bounds there and costs nothing.
fn rests(model: &dyn Model, problem: &Problem, state: &[f64]) -> bool {
    let declaration = model.declaration();
    let Some(declared) = declaration.optimal_control else {
        return false;
    };
    let n = declaration.coordinates.len();
    let (lower, upper) = bounds(model);
    let controls: Vec<f64> = (n..lower.len())
        .map(|k| 0.0_f64.clamp(lower[k], upper[k]))
        .collect();
    let mut input = [state, &controls].concat();
    input.resize(declaration.path_inputs(), 0.0);
    let mut values = vec![0.0; declared.path_functions()];
    model.values(Function::Path, &input, &mut values);
    let first = usize::from(declared.running_cost);
    let free = !declared.running_cost || values[0].abs() <= f64::EPSILON;
    let kept = declared.constraints.iter().zip(&values[first..]);
    let keeps = kept.into_iter().all(|(known, value)| match known.equality {
        true => value.abs() <= ROUNDING,
        false => *value >= -ROUNDING,
    });
    if !free || !keeps {
        return false;
    }
    let signal = ControlSignal::PiecewiseConstant {
        times: vec![0.0],
        values: vec![controls],
    };
    let length = problem.length(model);
    let run = problem.initial_value_problem(state, length, signal);
    let Ok(run) = simulate_once(&EventDriven::default(), model, &run) else {
        return false;
    };
    let trajectory = &run.trajectory;
    let (Some(q), Some(v)) = (trajectory.q.last(), trajectory.v.last()) else {
        return false;
    };
    let moved = |(from, to): (&f64, &f64)| (from - to).abs() > ROUNDING * from.abs().max(1.0);
    // What only counts, as the integral of a state, may go on.
    let reached = [&q[..], v].concat();
    let counts = |k: usize| (declaration.mechanical()..n).contains(&k);
    let mut all = state.iter().zip(&reached).enumerate();
    run.status == SimulationStatus::Solved && !all.any(|(k, pair)| moved(pair) && !counts(k))
}
