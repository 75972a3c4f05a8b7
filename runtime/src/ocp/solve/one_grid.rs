//! From a guess to a judged motion, on one grid of the controls.

use hangtime_solver::Seconds;
use hangtime_solver::mpcc::Stationarity;
use hangtime_solver::nlp;

use crate::model::Model;
use crate::ocp::collocation::discretization::{Setting, parabolas};
use crate::ocp::effort::Effort;
use crate::ocp::global::coarse_to_fine::{self, RelaxedMotions};
use crate::ocp::global::guess::{bent, guess};
use crate::ocp::judge::confirm::judge;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::final_times::FinalTimes;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::previous::Previous;
use crate::ocp::problem::{Problem, bounds};
use crate::ocp::program::runner::Runner;
use crate::ocp::program::units::Units;
use crate::ocp::progress::Watch;
use crate::ocp::scale::Scale;
use crate::ocp::search::attempt::{Attempts, Local, Visited};
use crate::ocp::search::candidates::{Found, Proved, Readings, Search};
use crate::ocp::search::ride::ride;
use crate::ocp::search::sampled::sampled;
use crate::ocp::settings::{Formulation, Guess, Settings};
use crate::ocp::solution::{Counts, Solution, Status};
use crate::ocp::tuning::grids::MORE_STAGES;
use crate::rk::{ButcherTableau, Scheme};
use crate::simulation::InputError;

/// What a solution on one grid takes over from the one before it.
pub(super) struct Start<'s> {
    pub(super) watch: Watch<'s>,
    pub(super) counts: Counts,
    pub(super) seconds: Seconds,
    /// The motion on a coarser grid.
    pub(super) coarser: Option<Previous>,
    pub(super) known: Known,
    pub(super) effort: Effort,
}

/// What searches from other starts came through on a grid.
#[derive(Clone)]
pub(super) struct Known {
    /// Start of the present search.
    pub(super) start: usize,
    pub(super) visited: Vec<Visited>,
    pub(super) relaxed: RelaxedMotions,
    /// A motion near which to look, instead of near the guess, and the share of its range by which it is bent.
    pub(super) near: Option<(Previous, f64)>,
    /// Objective of the best motion that is confirmed; infinite without any.
    pub(super) confirmed: f64,
    /// What is proved of the motion that it is to begin with.
    pub(super) proved: Option<Proved>,
}

impl Default for Known {
    fn default() -> Self {
        Self {
            start: 0,
            visited: Vec::new(),
            relaxed: RelaxedMotions::default(),
            near: None,
            confirmed: f64::INFINITY,
            proved: None,
        }
    }
}

impl Known {
    /// Adds what the search from another start came through.
    pub(super) fn extend(&mut self, other: Self) {
        let new = other.visited.into_iter();
        self.visited
            .extend(new.filter(|visited| visited.start == other.start));
        self.relaxed.extend(other.relaxed);
    }

    /// Adds what a search ended at.
    pub(super) fn ended_at(&mut self, solution: &Solution) {
        if matches!(solution.status, Status::Solved | Status::Uncertified) {
            self.confirmed = self.confirmed.min(solution.objective);
        }
    }

    /// The motion near which to look, bent, on the grid of a problem.
    fn bent(&self, model: &dyn Model, problem: &Problem) -> Result<Option<Trajectory>, InputError> {
        let Some((near, bend)) = &self.near else {
            return Ok(None);
        };
        let motion = near.trajectory(model, problem)?;
        Ok(Some(bent(motion, model, problem, *bend, self.start as u64)))
    }

    /// The same for the search from another start.
    pub(super) fn from(&self, start: usize) -> Self {
        Self {
            start,
            visited: self.visited.clone(),
            relaxed: self.relaxed.clone().from(start),
            near: None,
            confirmed: self.confirmed,
            proved: None,
        }
    }
}

/// What a search leaves for those after it.
#[derive(Default)]
pub(super) struct Trace {
    pub(super) known: Known,
    /// The start of a search before it that came to where it does, where it comes to nothing else.
    pub(super) repeats: Option<usize>,
}

impl Trace {
    /// That of a search from a start, and what it has found.
    fn of<'a>(start: usize, search: Search<'a, '_>) -> (Self, Found<'a>) {
        let Search {
            found,
            attempts,
            relaxed,
            ..
        } = search;
        let known = Known {
            start,
            visited: attempts.into_visited(),
            relaxed,
            ..Known::default()
        };
        let repeats = found.repeats.filter(|_| found.optima.is_empty());
        (Self { known, repeats }, found)
    }
}

/// What a search around one guess has come to.
pub(super) struct Round<'s> {
    pub(super) solution: Solution,
    pub(super) watch: Watch<'s>,
    pub(super) trace: Trace,
    /// The final times that were looked at.
    pub(super) range: FinalTimes,
    /// The end of them at which the plan lies, or the nearest point of a program without a solution.
    pub(super) next: Option<f64>,
    /// Whether the controls of the plan are of another size than the units that they were measured in.
    pub(super) of_another_size: bool,
}

/// Solves on the grid of the problem, with final times around the given one, or else around the guess, and units
/// for the sizes of known controls.
pub(super) fn solve_round<'s>(
    model: &dyn Model,
    problem: &Problem,
    settings: &'s Settings,
    start: Start<'s>,
    centre: Option<f64>,
    known: &[Vec<f64>],
) -> Result<Round<'s>, InputError> {
    let (lower, upper) = bounds(model);
    let bounds = (&lower[..], &upper[..]);
    let coarser = start.coarser;
    let guessed = match (&coarser, start.known.bent(model, problem)?) {
        (Some(coarser), _) => coarser.trajectory(model, problem)?,
        (None, Some(bent)) => bent,
        (None, None) => guess(model, problem, &settings.guess, bounds)?,
    };
    let guessed = match centre {
        Some(centre) => guessed.stretched(centre),
        None => guessed,
    };
    let scale = Scale::of(model, problem);
    let units = Units::new(model, &scale, &guessed, bounds).measured_by(known, bounds);
    // A price on the time has to be seen beside the objective.
    let priced = settings.haste > 0.0;
    let units = if start.effort.proves() && coarser.is_some() || priced {
        units.exact()
    } else {
        units
    };
    let tableaus = tableaus(settings.stages);
    let first = tableaus.split_first();
    let (tableau, finer) = first.ok_or_else(|| settings.refuse_stages())?;
    let parabolas = parabolas(model, &problem.start());
    let scene = (model, problem);
    let setting = Setting::new(scene, settings, (tableau, &units), (bounds, &parabolas));
    let mut runner = Runner::new(
        settings,
        start.watch,
        (start.counts, start.seconds),
        start.effort,
    );
    let elements = vec![settings.elements; problem.intervals];
    let origin = start.known.start;
    let mut search = Search {
        attempts: Attempts::new(setting, &elements).after(origin, start.known.visited),
        relaxed: start.known.relaxed,
        found: Found::default(),
        proved: start.known.proved,
    };
    let simulated = simulated(&mut runner, setting, &scale, coarser.as_ref())?;
    let known = (coarser.as_ref(), &simulated[..]);
    let feasible = find(&mut runner, &mut search, &guessed, known)?;
    let nearest = runner.nearest_horizon();
    let (trace, found) = Trace::of(origin, search);
    let known = start.known.confirmed;
    let mut solution = best(&mut runner, setting, finer, (found.optima, feasible), known)?;
    solution.time_freezing = found.time_freezing;
    let range = setting.final_times();
    let time = match &solution.motion {
        Some(_) => Some(solution.horizon),
        None => nearest,
    };
    let next = time.and_then(|time| range.end_at(time));
    let of_another_size = solution.motion.is_some() && !units.fit(&solution.controls, bounds);
    Ok(Round {
        of_another_size,
        solution,
        watch: runner.into_watch(),
        trace,
        range,
        next,
    })
}

/// The schemes of a plan, of growing order.
pub(super) fn tableaus(stages: usize) -> Vec<ButcherTableau> {
    let stages = (stages..=ButcherTableau::MAX_STAGES).step_by(MORE_STAGES);
    let tableaus = stages.filter_map(|stages| ButcherTableau::new(Scheme::RadauIia, stages));
    tableaus.collect()
}

/// The simulated motions that the search begins with, if it does, each with units of its own: it may last a small part of the time that
/// the guess does, and units that are off by powers of a thousand keep a program from the motion that it starts from.
fn simulated(
    runner: &mut Runner,
    setting: Setting,
    scale: &Scale,
    coarser: Option<&Previous>,
) -> Result<Vec<(Candidate, Units)>, InputError> {
    let settings = runner.settings;
    let searches = settings.formulation == Formulation::Phases && coarser.is_none();
    if !searches || settings.guess != Guess::Sampled {
        return Ok(Vec::new());
    }
    let Setting {
        model,
        units,
        bounds,
        ..
    } = setting;
    let motions = sampled(runner, setting)?.into_iter();
    let with_units = motions.map(|motion| {
        let own = units.of_motion(model, scale, &motion.trajectory, bounds);
        (motion, own)
    });
    Ok(with_units.collect())
}

/// Looks for local optima from a known motion, or else from the guess, or else from the ride without controls. Whether
/// that was asked for, and fulfils the goals within the bounds.
fn find<'a>(
    runner: &mut Runner,
    search: &mut Search<'a, '_>,
    guessed: &Trajectory,
    (coarser, simulated): (Option<&Previous>, &'a [(Candidate, Units)]),
) -> Result<bool, InputError> {
    let setting = search.attempts.setting;
    let settings = runner.settings;
    let previous = match &settings.guess {
        Guess::Previous(previous) => Some(&**previous),
        _ => coarser,
    };
    let intervals = setting.problem.intervals;
    if let Some(previous) = previous {
        let candidate = previous.candidate(guessed, intervals);
        let readings = if coarser.is_some() {
            Readings::First
        } else {
            Readings::All
        };
        search.try_candidate(runner, candidate, readings)?;
    }
    // Its switches lie elsewhere on the finer grid, and a contact-implicit program on that grid says where.
    let none = search.found.optima.is_empty();
    let looks = (none || runner.effort == Effort::Carry) && search.found.repeats.is_none();
    if coarser.is_some()
        && looks
        && !runner.stopped()
        && let Some(candidate) = coarse_to_fine::on_this_grid(runner, setting, guessed)?
    {
        search.try_candidate(runner, candidate, Readings::First)?;
    }
    if settings.formulation == Formulation::Phases && coarser.is_none() {
        match settings.guess {
            Guess::Reachable => search.try_reachable(runner)?,
            Guess::Sampled => search.try_simulated(runner, simulated)?,
            Guess::Stepping => search.try_stepping(runner, guessed)?,
            _ => {}
        }
        // One of several searches leaves the rest to the others.
        let beside = match settings.guess {
            Guess::Reachable => true,
            Guess::Sampled | Guess::Stepping => runner.effort == Effort::Explore,
            _ => false,
        };
        if beside {
            return Ok(false);
        }
    }
    // Without a previous motion, or too far from it: search.
    let none = search.found.optima.is_empty();
    if none && (coarser.is_none() || search.found.repeats.is_none()) {
        let simulated = matches!(settings.guess, Guess::Ride | Guess::Random(_));
        search.try_guess(runner, guessed, simulated)?;
    }
    // The ride without controls obeys the dynamics, which is what other guesses may be too far from.
    let none = search.found.optima.is_empty() && search.found.repeats.is_none();
    if none && !matches!(settings.guess, Guess::Ride) && !runner.stopped() {
        let Setting {
            model,
            problem,
            bounds,
            ..
        } = setting;
        let ride = guess(model, problem, &Guess::Ride, bounds)?;
        search.try_guess(runner, &ride, true)?;
    }
    // Up to where it comes nearest to the goals it is a motion itself.
    let none = search.found.optima.is_empty() && search.found.repeats.is_none();
    if !none || runner.stopped() {
        return Ok(false);
    }
    let Some(ride) = ride(runner.settings.replay_tolerance, setting)? else {
        return Ok(false);
    };
    search.try_candidate(runner, ride.candidate, Readings::First)?;
    Ok(ride.reaches)
}

/// The best of what was `found` that the re-simulation confirms, or else the best; why there is none, of a problem that may be known
/// to be feasible. Plans that are worse than a `known` motion are not refined.
fn best<'a>(
    runner: &mut Runner,
    setting: Setting<'a>,
    finer: &'a [ButcherTableau],
    (found, feasible): (Vec<(Local<'a>, Stationarity)>, bool),
    known: f64,
) -> Result<Solution, InputError> {
    let mut result: Option<Solution> = None;
    for (local, stationarity) in found {
        let at_an_end = setting.final_times().end_at(local.trajectory.horizon);
        // A plan at an end of the final times is not the last one: it is not worth finer grids.
        let finer = if at_an_end.is_some() { &[] } else { finer };
        let solution = judge(runner, setting, finer, (local, stationarity), known)?;
        let confirmed = solution.status != Status::Unconfirmed;
        if confirmed || result.is_none() {
            result = Some(solution);
        }
        if confirmed {
            break;
        }
    }
    result.map_or_else(|| failed(runner, feasible), Ok)
}

/// A result without a motion; of a problem that is known to be `feasible` it is not said that it is not. An error where no program
/// could be started.
fn failed(runner: &mut Runner, feasible: bool) -> Result<Solution, InputError> {
    let (status, violations) = match (runner.take_failure(), runner.take_refusal()) {
        (Some(failure), _) => (failure.status, failure.violations),
        (None, Some(refusal)) => return Err(refusal),
        (None, None) => (nlp::Status::IterationLimit, Vec::new()),
    };
    let status = match status {
        _ if runner.stopped() => Status::Interrupted,
        nlp::Status::Infeasible if !feasible => Status::NotFound,
        nlp::Status::Interrupted => Status::Interrupted,
        status => Status::Failed(status),
    };
    Ok(Solution {
        seconds: runner.seconds,
        ..Solution::without_motion(status, violations, runner.counts)
    })
}
