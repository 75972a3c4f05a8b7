//! The judgement of a plan: an independent simulation under its controls.

use super::attempt::Purpose;
use super::cuts::excess;
use super::grid::ROUNDS;
use super::mode::Mode;
use super::path::Path;
use super::previous::Previous;
use super::search::{Local, Search};
use super::sequence::{Sequence, Switch};
use super::solution::{Size, Solution, Stationarity, Status};
use crate::nlp;
use crate::simulation::{
    Event, EventDriven, EventKind, InputError, Residuals, Simulation, SimulationStatus,
    Simulator as _,
};

/// A contact that closes within this share of the first interval, from a gap \[its unit\] no larger than this, was
/// closed at the start.
const AT_ONCE: f64 = 1e-3;
const ON_THE_SURFACE: f64 = 1e-9;

/// Points of the re-simulation in each interval.
const OUTPUTS: usize = 10;

impl<'a> Search<'a, '_> {
    pub(super) fn simulate(&self, path: &Path, tolerance: f64) -> Result<Simulation, InputError> {
        let problem = self.setting.problem;
        let start = problem.start_of(self.setting.model, path);
        let simulator = EventDriven {
            tolerance,
            max_step: Some(path.horizon / problem.intervals as f64),
            output_times: OUTPUTS * problem.intervals,
            ..EventDriven::default()
        };
        let motion = problem.initial_value_problem(&start, path.horizon, path.signal());
        simulator.simulate(self.setting.model, &motion, &mut |_| true)
    }

    pub(super) fn read(&self, replay: &Simulation, path: &Path) -> Sequence {
        let intervals = self.setting.problem.intervals;
        let interval = path.horizon / intervals as f64;
        let mut closed: Vec<bool> = match replay.trajectory.contact_force.first() {
            Some(forces) => forces.iter().map(|&force| force > 0.0).collect(),
            None => Vec::new(),
        };
        let start = self.setting.problem.start_of(self.setting.model, path);
        let mut input = vec![0.0; self.setting.model.declaration().inputs()];
        input[..start.len()].copy_from_slice(&start);
        // A start that rounding puts above a surface lands at once.
        for (contact, closed) in closed.iter_mut().enumerate() {
            let own = |event: &&Event| event.contact == contact;
            *closed |= self.setting.model.gap(contact, &input) <= ON_THE_SURFACE
                && replay.events.iter().find(own).is_some_and(|first| {
                    first.kind != EventKind::LiftOff && first.time < AT_ONCE * interval
                });
        }
        Sequence::read(self.setting.model, &closed, replay, (interval, intervals))
    }

    /// A result without a motion.
    pub(super) fn failed(&mut self) -> Solution {
        let (status, violations) = self
            .failure
            .take()
            .unwrap_or((nlp::Status::IterationLimit, Vec::new()));
        let status = match status {
            _ if self.watch.stopped => Status::Interrupted,
            nlp::Status::Infeasible => Status::Infeasible,
            nlp::Status::Interrupted => Status::Interrupted,
            status => Status::Failed(status),
        };
        Solution::without_motion(status, violations, self.counts)
    }

    /// Re-simulates a motion, with more elements where they are needed, and else with more stages, as long as the plan
    /// does not agree with the simulation.
    pub(super) fn refine(
        &mut self,
        local: Local<'a>,
        stationarity: Stationarity,
    ) -> Result<Solution, InputError> {
        let (mut sequence, mut path, cuts) = (
            local.sequence.clone(),
            local.path.clone(),
            local.cuts.clone(),
        );
        let mut solution = self.finish(local, stationarity)?;
        let first = self.setting.tableau;
        let coarse = self.elements.clone();
        for _ in 0..ROUNDS {
            if self.watch.stopped
                || solution.status != Status::Unconfirmed
                || !self.refine_grid(&path, solution.resimulation_error)
            {
                break;
            }
            self.best = None;
            self.attempt(&sequence, &path, &[], Purpose::Compare)?;
            let Some(better) = self.best.take() else {
                break;
            };
            sequence.clone_from(&better.sequence);
            path.clone_from(&better.path);
            solution = self.finish(better, stationarity)?;
        }
        self.elements = coarse;
        for tableau in &self.tableaus[1..] {
            if self.watch.stopped || solution.status != Status::Unconfirmed {
                break;
            }
            self.setting.tableau = tableau;
            self.best = None;
            self.attempt(&sequence, &path, &cuts, Purpose::Compare)?;
            let Some(better) = self.best.take() else {
                break;
            };
            sequence.clone_from(&better.sequence);
            path.clone_from(&better.path);
            solution = self.finish(better, stationarity)?;
        }
        self.setting.tableau = first;
        Ok(solution)
    }

    /// Re-simulates a motion and compares.
    fn finish(
        &mut self,
        best: Local<'a>,
        stationarity: Stationarity,
    ) -> Result<Solution, InputError> {
        let replay = self.simulate(&best.path, self.settings.resimulation_tolerance)?;
        let n = self.setting.problem.q.len();
        let planned = best.path.at(best.path.horizon, true);
        let reached = replay.trajectory.q.last();
        let distance = match (&replay.status, reached) {
            (SimulationStatus::Solved, Some(q)) => largest_difference(q, &planned[..n]),
            _ => f64::INFINITY,
        };
        let read = self.read(&replay, &best.path);
        let interval = best.path.horizon / self.setting.problem.intervals as f64;
        let model = self.setting.model;
        let simulated = Path::of_simulation(
            model,
            &replay,
            best.path.horizon,
            best.path.controls.clone(),
        );
        // A slip over less than the distance that is let pass is none.
        let slowest = self.settings.largest_distance / best.path.horizon;
        let disagreement = self.disagreement(
            &best.sequence.seen(model, &best.path, slowest),
            &read.seen(model, &simulated, slowest),
            interval,
        );
        let agrees = distance <= self.settings.largest_distance && disagreement.is_none();
        let status = if self.watch.stopped {
            Status::Interrupted
        } else if !agrees {
            Status::Unconfirmed
        } else if stationarity == Stationarity::None {
            Status::Uncertified
        } else {
            Status::Solved
        };
        let complementarity = complementarity(&best);
        let residuals = Residuals {
            primal: best.solution.residuals.primal,
            dual: best.solution.residuals.dual,
            complementarity,
        };
        let size = Size::of(&best.program.program, 0);
        let planned_events = best.sequence.switches.iter().map(|switch| {
            let time = switch.time * interval;
            let kind = match switch.mode {
                _ if switch.closes => EventKind::Impact,
                Mode::Open => EventKind::LiftOff,
                Mode::Stick => EventKind::Stick,
                Mode::Slip(_) | Mode::Frictionless => EventKind::Slip,
            };
            (time, kind, switch.contact)
        });
        Ok(Solution {
            status,
            objective: best.solution.objective,
            horizon: best.path.horizon,
            stationarity,
            resimulation_error: distance,
            disagreement,
            residuals,
            planned_events: planned_events.collect(),
            excess: excess(&best.program, &best.solution.x, self.limits()),
            controls: best.path.controls.values().to_vec(),
            shape: best.path.controls.shape(),
            elements: self.elements.clone(),
            previous: Some(Previous::new(best.path, best.sequence)),
            motion: Some(replay),
            violations: best.solution.violations,
            size,
            counts: self.counts,
            seconds: 0.0,
            time_freezing: None,
            optima: Vec::new(),
        })
    }
}

impl Search<'_, '_> {
    /// The first difference in kind between the switches of a plan and of its re-simulation, in words.
    fn disagreement(&self, plan: &Sequence, read: &Sequence, interval: f64) -> Option<String> {
        let contacts = self.setting.model.declaration().contacts;
        let initially = plan.initially.iter().zip(&read.initially);
        let other = initially
            .zip(contacts)
            .find(|((plan, read), _)| plan != read);
        if let Some(((mode, read), contact)) = other {
            let (mode, read) = (mode.state(), read.state());
            return Some(format!(
                "`{}` is {mode} at the start of the plan, and {read} at that of the re-simulation",
                contact.name
            ));
        }
        let kind = |s: &Switch| (s.contact, s.closes, s.mode);
        let words = |sequence: &Sequence, index: usize| match sequence.switches.get(index) {
            None => "nothing".to_owned(),
            Some(switch) => {
                let name = contacts[switch.contact].name;
                let time = switch.time * interval;
                match (switch.closes, switch.mode) {
                    (true, Mode::Open) => format!("`{name}` is touched at {time:.6} s"),
                    (false, Mode::Open) => format!("`{name}` opens at {time:.6} s"),
                    (true, Mode::Frictionless) => format!("`{name}` closes at {time:.6} s"),
                    (_, mode) => format!("`{name}` is {} from {time:.6} s on", mode.state()),
                }
            }
        };
        // A simulation may end on either side of an impact at the final time.
        let intervals = self.setting.problem.intervals;
        let lasting = plan.switches.iter().filter(|s| s.interval < intervals);
        let longest = lasting.count().max(read.switches.len());
        (0..longest)
            .find(|&i| plan.switches.get(i).map(kind) != read.switches.get(i).map(kind))
            .map(|i| {
                let (planned, simulated) = (words(plan, i), words(read, i));
                format!(
                    "switch {}: in the plan {planned}, in the re-simulation {simulated}",
                    i + 1
                )
            })
    }
}

pub(super) fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |largest: f64, (a, b)| largest.max((a - b).abs()))
}

/// Largest `min(g, r)` over all stages and contacts: 0 by construction wherever one of them is fixed.
fn complementarity(best: &Local) -> f64 {
    let x = best.program.program.physical(&best.solution.x);
    let model = best.program.model;
    let mut input = vec![0.0; model.declaration().inputs()];
    let mut largest: f64 = 0.0;
    for phase in &best.program.phases {
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
