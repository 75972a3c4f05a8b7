//! The judge: an event-driven simulation of a plan under its controls.

use crate::yardstick;
use hangtime_solver::mpcc::Stationarity;

use super::at_bounds::at_bounds;
use super::disagreement::compare;
use super::forces;
use super::gradient::gradient;
use super::margins::margins;
use super::objective::{Replayed, replayed};
use super::refine_grid::{ROUNDS, refine, refine_all};
use crate::model::Model;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::collocation::layout::Cut;
use crate::ocp::collocation::program::Collocation;
use crate::ocp::motion::mode::{is_condition, sets};
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::ocp::motion::trajectory::{Trajectory, largest_difference};
use crate::ocp::previous::Previous;
use crate::ocp::program::runner::Runner;
use crate::ocp::search::attempt::{Attempt, Attempts, Local, Purpose};
use crate::ocp::search::proof::certificate;
use crate::ocp::search::replay::{read_replay, simulate};
use crate::ocp::solution::{Margin, Solution, Status};
use crate::ocp::tuning::candidates::OUTPUTS;
use crate::progress::BestMotion;
use crate::rk::ButcherTableau;
use crate::simulation::ContactMode;
use crate::simulation::{
    EventKind, InputError, ProblemSize, Residuals, Simulation, SimulationStatus,
};

/// Most points of a re-simulation in each interval, where fewer do not tell its objective. With the order six of that, eight times as many
/// err by a quarter of a million times less.
const MOST_OUTPUTS: usize = 8 * OUTPUTS;
/// By how much less a refined plan has to miss its re-simulation: the order of the scheme promises 32 times where elements are halved.
const SLOW: f64 = 8.0;
/// Relative excess of the objective up to which a plan with another discretization is one of the same motion: that was coarse.
const MUCH_WORSE: f64 = 0.1;
/// Shares of the distances that the method keeps by itself with which a plan is solved again that they hold back.
const KEPT: [f64; 2] = [0.05, 0.0025];
/// Relative difference of the objective within which it is the same local optimum, of which the same is proved.
const SAME_OPTIMUM: f64 = 1e-2;

/// The judgement of a local optimum with so many elements of each interval: re-simulated, with more of them where they are needed, and else
/// with the schemes of `tableaus`, of growing order, as long as the plan does not agree with the simulation, and is better than the objective
/// of a `known` motion.
pub(in crate::ocp) fn judge<'a>(
    runner: &mut Runner,
    setting: Setting<'a>,
    (coarse, tableaus): (&[usize], &'a [ButcherTableau]),
    (local, stationarity): (Local<'a>, Stationarity),
    known: f64,
) -> Result<Solution, InputError> {
    let cuts = local.cuts.clone();
    let (mut plan, mut solution) = Plan::judged(runner, setting, coarse, (local, stationarity))?;
    if solution.objective - known > (yardstick::VISIBLE * known.abs()).max(solution.tolerated(0.0))
    {
        return Ok(solution);
    }
    let mut elements = coarse.to_vec();
    // Where plan and simulation end together and differ in what contacts do, more elements rarely help.
    let mut read_otherwise = 0;
    let (mut before, mut before_cost) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..ROUNDS {
        let unconfirmed = !runner.stopped() && solution.status == Status::Unconfirmed;
        let distance = solution.departure;
        // Nothing else but the objective differs.
        let costs = solution.costs_otherwise() && solution.disagreement.is_none();
        let ends_there = distance <= runner.settings.largest_distance;
        read_otherwise += usize::from(ends_there && !costs);
        // Nor do they where they bring them together far more slowly than the order of the scheme promises.
        let slow = distance > before / SLOW && !(ends_there && costs);
        if unconfirmed
            && (slow || read_otherwise > 1)
            && let Some((plan, other)) =
                plan.judged_as_simulated(runner, setting, &elements, &solution)?
        {
            let (_, solution) = plan.released(runner, setting, &elements, other)?;
            report(runner, &solution);
            return Ok(solution);
        }
        // What finer elements do not change is not for want of them.
        if ends_there && costs && solution.cost_departure > before_cost / SLOW {
            break;
        }
        (before, before_cost) = (distance, solution.cost_departure);
        let finer = |elements: &mut [usize]| {
            if ends_there && costs {
                refine_all(setting, elements, solution.cost_departure)
            } else {
                refine(runner, setting, elements, &plan.trajectory, distance)
            }
        };
        if !unconfirmed || read_otherwise > 1 || !finer(&mut elements) {
            break;
        }
        let Some(again) = plan.again(runner, setting, &elements, (&[], false))? else {
            break;
        };
        (plan, solution) = Plan::judged(runner, setting, &elements, again)?;
    }
    for tableau in tableaus {
        if runner.stopped() || solution.status != Status::Unconfirmed {
            break;
        }
        let setting = Setting { tableau, ..setting };
        let Some(again) = plan.again(runner, setting, coarse, (&cuts, false))? else {
            break;
        };
        (plan, solution) = Plan::judged(runner, setting, coarse, again)?;
    }
    let (plan, mut solution) = plan.released(runner, setting, &elements, solution)?;
    if let Some((plan, other)) = plan.judged_as_simulated(runner, setting, &elements, &solution)? {
        (_, solution) = plan.released(runner, setting, &elements, other)?;
    }
    report(runner, &solution);
    Ok(solution)
}

/// Tells the observer of a motion that is confirmed.
pub(in crate::ocp) fn report(runner: &mut Runner, solution: &Solution) {
    if matches!(solution.status, Status::Solved | Status::Uncertified) {
        let closes = |kind: EventKind| matches!(kind, EventKind::Impact | EventKind::Contact);
        let events = solution.planned_events.iter();
        let contacts = events.filter(|(_, kind, _)| closes(*kind)).count();
        runner.found(BestMotion::new(contacts, solution.objective, true));
    }
}

/// Whether a distance that the method keeps by itself costs something.
fn is_held_back(solution: &Solution) -> bool {
    solution.margins.iter().any(|margin| !margin.chosen)
}

/// What a finer program of a plan starts from.
struct Plan {
    sequence: Sequence,
    trajectory: Trajectory,
    objective: f64,
    /// What is proved of it.
    stationarity: Stationarity,
}

impl Plan {
    fn of(local: &Local, stationarity: Stationarity) -> Self {
        Self {
            stationarity,
            sequence: local.sequence.clone(),
            trajectory: local.trajectory.clone(),
            objective: local.solution.objective,
        }
    }

    /// A local optimum re-simulated, with elements that follow the re-simulation where the two differ beside an active bound, and what a
    /// finer program of it starts from.
    fn judged(
        runner: &mut Runner,
        setting: Setting,
        elements: &[usize],
        local: (Local, Stationarity),
    ) -> Result<(Self, Solution), InputError> {
        let (mut plan, mut solution) = Self::judged_once(runner, setting, elements, local)?;
        for _ in 0..ROUNDS {
            let Some(mesh) = solution.finer.take().filter(|_| !runner.stopped()) else {
                break;
            };
            let elements: Vec<usize> = mesh.iter().map(Vec::len).collect();
            let mesh = Some(&mesh[..]);
            let setting = Setting { mesh, ..setting };
            let Some(again) = plan.again(runner, setting, &elements, (&[], false))? else {
                break;
            };
            let (finer, other) = Self::judged_once(runner, setting, &elements, again)?;
            if other.status == Status::Unconfirmed && solution.status != Status::Unconfirmed {
                break;
            }
            (plan, solution) = (finer, other);
        }
        Ok((plan, solution))
    }

    /// A local optimum re-simulated. It is polished, unless that loses its confirmation: where a contact opens at once, rounding decides
    /// whether the re-simulation sees it close.
    fn judged_once(
        runner: &mut Runner,
        setting: Setting,
        elements: &[usize],
        (local, stationarity): (Local, Stationarity),
    ) -> Result<(Self, Solution), InputError> {
        let plan = Self::of(&local, stationarity);
        let solution = confirm(runner, setting, elements, &local, stationarity)?;
        let mut local = local.polished(runner);
        let mut polished = confirm(runner, setting, elements, &local, stationarity)?;
        polished.gradient = gradient(&mut local);
        if polished.status == Status::Unconfirmed && solution.status != Status::Unconfirmed {
            let (counts, seconds) = (runner.counts, runner.seconds);
            let solution = Solution {
                counts,
                seconds,
                gradient: polished.gradient,
                ..solution
            };
            return Ok((plan, solution));
        }
        Ok((Self::of(&local, stationarity), polished))
    }

    /// A plan that is unconfirmed, or held back by something that only its sequence asks for, with the contact sequence of its
    /// re-simulation, if that is confirmed, and better than one that is confirmed as well: a motion that is the same may be another
    /// sequence to the simulation, and what is proved of the plan's is not of that one.
    fn judged_as_simulated(
        &self,
        runner: &mut Runner,
        setting: Setting,
        elements: &[usize],
        solution: &Solution,
    ) -> Result<Option<(Self, Solution)>, InputError> {
        let unconfirmed = solution.status == Status::Unconfirmed;
        if runner.stopped() || !unconfirmed && !is_held_back(solution) {
            return Ok(None);
        }
        let Some(seen) = self.as_simulated(setting, solution) else {
            return Ok(None);
        };
        // With its neighbours decided, or where one of these is better and not confirmed, by itself.
        for decides in [true, false] {
            let Some(again) = seen.again(runner, setting, elements, (&[], decides))? else {
                return Ok(None);
            };
            let (plan, other) = Self::judged(runner, setting, elements, again)?;
            let confirmed = other.status != Status::Unconfirmed;
            if confirmed && (unconfirmed || other.objective < solution.objective) {
                return Ok(Some((plan, other)));
            }
        }
        Ok(None)
    }

    /// A confirmed plan that the method's own distances hold back with smaller ones, as long as that is better and stays confirmed.
    fn released(
        self,
        runner: &mut Runner,
        setting: Setting,
        elements: &[usize],
        mut solution: Solution,
    ) -> Result<(Self, Solution), InputError> {
        let mut plan = self;
        for kept in KEPT {
            let confirmed = solution.status != Status::Unconfirmed;
            if !confirmed || !is_held_back(&solution) || runner.stopped() {
                break;
            }
            let setting = Setting { kept, ..setting };
            let Some(again) = plan.again(runner, setting, elements, (&[], false))? else {
                break;
            };
            let (nearer, other) = Self::judged(runner, setting, elements, again)?;
            if other.status == Status::Unconfirmed || other.objective > solution.objective {
                break;
            }
            (plan, solution) = (nearer, other);
        }
        Ok((plan, solution))
    }

    /// The plan with the contact sequence of its re-simulation, where that is another one of the same motion.
    fn as_simulated(&self, setting: Setting, solution: &Solution) -> Option<Self> {
        let motion = solution.motion.as_ref()?;
        if solution.departure > yardstick::VISIBLE {
            return None;
        }
        let read = read_replay(setting, motion, &self.trajectory);
        let sequence = read.ordered(setting.problem.intervals)?;
        let other = sequence.signature() != self.sequence.signature();
        other.then(|| Self {
            sequence,
            trajectory: self.trajectory.clone(),
            objective: self.objective,
            stationarity: Stationarity::None,
        })
    }

    /// The plan with another discretization, and what is proved of it, if there is one that is not much worse. Of another
    /// local optimum the neighbours are decided anew; of the same where that is asked.
    fn again<'a>(
        &self,
        runner: &mut Runner,
        setting: Setting<'a>,
        elements: &[usize],
        (cuts, decides): (&[Cut], bool),
    ) -> Result<Option<(Local<'a>, Stationarity)>, InputError> {
        let mut attempts = Attempts::new(setting, elements);
        let attempt = Attempt {
            sequence: &self.sequence,
            guess: &self.trajectory,
            cuts,
            purpose: Purpose::Near,
        };
        attempts.attempt(runner, attempt);
        let Some(again) = &attempts.best else {
            return Ok(None);
        };
        let excess = excess_of(again, self.objective);
        if excess > MUCH_WORSE {
            return Ok(None);
        }
        let stationarity = if !decides
            && (excess.abs() <= SAME_OPTIMUM || self.stationarity == Stationarity::None)
        {
            self.stationarity
        } else {
            certificate(runner, &mut attempts)
        };
        Ok(attempts.best.map(|best| (best, stationarity)))
    }
}

/// By how much the objective of a plan exceeds another one, relative to that.
fn excess_of(plan: &Local, objective: f64) -> f64 {
    (plan.solution.objective - objective) / plan.program.program.size_of(objective)
}

/// The motion under the controls of a plan, and its objective beside that of the plan, at as many instants as tell it.
pub(super) fn resimulated(
    setting: Setting,
    trajectory: &Trajectory,
    (plan, tolerance): ((&Sequence, f64), f64),
    cost: (f64, f64),
) -> Result<(Simulation, Option<Replayed>), InputError> {
    let mut outputs = OUTPUTS;
    loop {
        let replay = simulate(setting, trajectory, Some(plan), (tolerance, outputs))?;
        let again = replayed(setting.model, &trajectory.controls, &replay, cost)
            .filter(|_| replay.status == SimulationStatus::Solved);
        let coarse = again.is_some_and(|again| again.is_coarse);
        if !coarse || outputs >= MOST_OUTPUTS {
            return Ok((replay, again));
        }
        outputs *= 2;
    }
}

/// Re-simulates a plan and compares.
pub(in crate::ocp) fn confirm(
    runner: &Runner,
    setting: Setting,
    elements: &[usize],
    plan: &Local,
    stationarity: Stationarity,
) -> Result<Solution, InputError> {
    let settings = runner.settings;
    let Local {
        program,
        solution,
        trajectory,
        sequence,
        ..
    } = plan;
    let cost = plan.cost;
    let let_pass = setting.largest_distance(settings, trajectory);
    let with = ((sequence, let_pass), settings.resimulation_tolerance);
    let unit = program.program.size_of(0.0);
    let (replay, again) = resimulated(setting, trajectory, with, (cost, unit))?;
    let apart = Apart::of(setting, trajectory, &replay);
    let forces = forces::looked(setting.model, &replay);
    let at_bounds = at_bounds(
        (setting, elements, settings.tolerance),
        (program, &solution.x),
        (trajectory, &replay),
    );
    let disagreement = compare(setting, settings, sequence, trajectory, &replay)
        .or_else(|| forces::violated(&forces))
        .or_else(|| forces::other_cost(setting, cost, &replay))
        .or(at_bounds.violated);
    let (simulated, cost_departure) = again.map_or((f64::NAN, 0.0), |r| (r.cost, r.departure));
    let margins = margins(program, solution);
    let stationarity = match &at_bounds.apart {
        Some(_) => Stationarity::None,
        None => unless_held_back(stationarity, &margins),
    };
    let agrees = apart.departure <= settings.largest_distance
        && disagreement.is_none()
        && cost_departure <= 1.0;
    let status = status_of(runner, agrees, stationarity);
    Ok(Solution {
        objective: cost,
        objective_unit: unit,
        horizon: trajectory.horizon,
        stationarity,
        resimulation_error: apart.distance,
        resimulation_velocity_error: apart.velocity,
        departure: apart.departure,
        cost_departure,
        resimulated_objective: simulated,
        let_pass,
        disagreement: disagreement.or(at_bounds.apart),
        residuals: Residuals {
            primal: solution.residuals.primal,
            dual: solution.residuals.dual,
            complementarity: complementarity(program, &solution.x),
        },
        planned_events: planned_events(program.model, sequence, trajectory),
        margins,
        excess: forces::excess(&forces, at_bounds.excess),
        finer: at_bounds.finer,
        controls: trajectory.controls.values().to_vec(),
        control_times: trajectory.controls.times(trajectory.horizon),
        shape: trajectory.controls.shape,
        elements: elements.to_vec(),
        previous: Some(Previous::new(trajectory.clone(), sequence.clone())),
        motion: Some(replay),
        size: ProblemSize::of(&program.program),
        seconds: runner.seconds,
        ..Solution::without_motion(status, solution.violations.clone(), runner.counts)
    })
}

/// How far the ends of a plan and of its replay are apart; infinite without an end of the replay.
struct Apart {
    /// Of coordinates, in their units.
    distance: f64,
    /// Of velocities, in their units.
    velocity: f64,
    /// Of coordinates, by what is let pass.
    departure: f64,
}

impl Apart {
    fn of(setting: Setting, trajectory: &Trajectory, replay: &Simulation) -> Self {
        let n = setting.problem.q.len();
        let planned = trajectory.at(trajectory.horizon, true);
        let (q, v) = (replay.trajectory.q.last(), replay.trajectory.v.last());
        match (&replay.status, q, v) {
            (SimulationStatus::Solved, Some(q), Some(v)) => Self {
                distance: largest_difference(q, &planned[..n]),
                velocity: largest_difference(v, &planned[n..2 * n]),
                departure: setting.departure(trajectory, q, &planned[..n]),
            },
            _ => Self {
                distance: f64::INFINITY,
                velocity: f64::INFINITY,
                departure: f64::INFINITY,
            },
        }
    }
}

/// What is proved of a sequence, but nothing where a distance that the method keeps by itself holds the plan back.
fn unless_held_back(stationarity: Stationarity, margins: &[Margin]) -> Stationarity {
    match margins.iter().all(|margin| margin.chosen) {
        true => stationarity,
        false => Stationarity::None,
    }
}

/// The status of a plan that agrees with its replay or not, and of whose contact sequence that is proved.
fn status_of(runner: &Runner, agrees: bool, stationarity: Stationarity) -> Status {
    if runner.stopped() {
        Status::Interrupted
    } else if !agrees {
        Status::Unconfirmed
    } else if stationarity == Stationarity::None {
        Status::Uncertified
    } else {
        Status::Solved
    }
}

fn planned_events(
    model: &dyn Model,
    sequence: &Sequence,
    plan: &Trajectory,
) -> Vec<(f64, EventKind, usize)> {
    let interval = plan.horizon / plan.controls.intervals() as f64;
    let switches = sequence.switches.iter().enumerate();
    // Where a condition ceases to be true, nothing happens.
    let happens = |switch: &Switch| !is_condition(model, switch.contact) || sets(model, switch);
    let switches = switches.filter(|(_, switch)| !switch.passes && happens(switch));
    let switches = switches.map(|(index, switch)| {
        let kind = match switch.mode {
            _ if is_condition(model, switch.contact) => EventKind::When,
            _ if Sequence::takes_over(&sequence.switches, index) => EventKind::Contact,
            _ if switch.closes => EventKind::Impact,
            ContactMode::Open => EventKind::LiftOff,
            ContactMode::Stick => EventKind::Stick,
            ContactMode::Slip(_) | ContactMode::Frictionless => EventKind::Slip,
        };
        let declared = &model.declaration().contacts[switch.contact];
        (switch.time * interval, kind.of(declared), switch.contact)
    });
    switches.collect()
}

/// Largest `min(g, r)` over all stages and contacts: 0 by construction wherever one of them is fixed.
fn complementarity(program: &Collocation, x: &[f64]) -> f64 {
    let x = program.program.physical(x);
    let model = program.model;
    let mut input = vec![0.0; model.declaration().inputs()];
    let mut largest: f64 = 0.0;
    for phase in &program.phases {
        for stage in &phase.stages {
            let variables = stage.state.iter().chain(&stage.drive);
            for (slot, &variable) in input.iter_mut().zip(variables) {
                *slot = x[variable];
            }
            for (&contact, &force) in phase.closed.iter().zip(&stage.forces) {
                largest = largest.max(model.gap(contact, &input).abs().min(x[force].abs()));
            }
        }
    }
    largest
}
