//! The pipeline: global phase, contact sequence, high order, repair, certificate, re-simulation.

use cpu_time::ThreadTime;

use super::collocation::{Collocation, Cut, Setting, parabolas};
use super::contact_implicit::ContactImplicit;
use super::cuts::{Limits, between_stages};
use super::path::{Path, Units};
use super::problem::{Problem, bounds};
use super::repair::Pressure;
use super::sequence::{Sequence, Signature};
use super::settings::Settings;
use super::solution::{Counts, Size, Solution, Stationarity, Status};
use crate::model::Model;
use crate::nlp::{self, NlpProblem as _};
use crate::rk::{ButcherTableau, Scheme};
use crate::simulation::{
    EventDriven, EventKind, InputError, Simulation, SimulationStatus, Simulator as _,
};
use crate::{mpcc, mpcc::RelaxationRule, simulation};

/// Elements an interval of the first programs of the global phase, and the rules that relax them: few elements
/// and many rules, because the programs differ in the local optima that they end at, and are cheap.
const COARSE: [(usize, &[RelaxationRule]); 2] = [
    (
        1,
        &[
            RelaxationRule::Proportional,
            RelaxationRule::Continuation,
            RelaxationRule::RollOff,
        ],
    ),
    (2, &[RelaxationRule::RollOff, RelaxationRule::Continuation]),
];
/// Last relaxation and first barrier parameter of the first programs.
const COARSE_RELAXATION: (f64, f64) = (1e-3, 1e-1);
/// Elements an interval of the refined programs, started from the first ones.
const FINE: usize = 4;
/// Rules of the refined programs.
const FINE_RULES: [RelaxationRule; 3] = [
    RelaxationRule::Proportional,
    RelaxationRule::RollOff,
    RelaxationRule::Continuation,
];
/// How many of them are tried where the first programs did not agree.
const FINE_ALTERNATIVES: usize = 2;
/// Last relaxation and first barrier parameter of the refined programs.
const FINE_RELAXATION: (f64, f64) = (1e-6, 1e-4);
/// Relative difference of the objective within which two relaxed motions count as the same.
const SAME: f64 = 1e-3;
/// Barrier parameters that a collocation program is started with, in this order.
const BARRIERS: [f64; 3] = [1e-2, 1e-3, 1e-1];
/// Barrier parameter after a cut, and those that follow if that fails.
const BARRIERS_AFTER_CUT: [f64; 3] = [1e-4, 1e-2, 1e-3];
/// Rounds of cuts of one sequence.
const ROUNDS: usize = 5;
/// Relative decrease of the objective that counts as an improvement.
const IMPROVEMENT: f64 = 1e-9;
/// Gap below which a motion starts on a surface, in its unit.
const AT_START: f64 = 1e-9;
/// Barrier parameters that a neighbouring sequence is started with, and most iterations for it.
const NEIGHBOUR_BARRIERS: [f64; 2] = [1e-2, 1e-3];
const NEIGHBOUR_ITERATIONS: usize = 150;
/// Gap below which a flight counts as touching, relative to the gap margin.
const TOUCHING: f64 = 0.1;
/// Most switches of short contacts and flights for which a sequence is tried with them, too.
const SHORT_SWITCHES: usize = 2;
/// Points of the re-simulation in each interval.
const OUTPUTS: usize = 10;

/// What the solver is doing, for whoever waits.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// Name of the step.
    pub step: &'static str,
    /// Programs solved so far.
    pub programs: usize,
    /// Interior point iterations so far.
    pub iterations: usize,
    /// Best objective with a consistent contact sequence so far.
    pub objective: Option<f64>,
}

/// Solves an optimal control problem; `progress` is called after every program.
///
/// # Errors
/// [`InputError`] if problem or settings are refused; everything that happens later is a [`Status`].
///
/// # Examples
/// See the [module](super).
pub fn solve(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    progress: &mut dyn FnMut(Progress),
) -> Result<Solution, InputError> {
    settings.check()?;
    problem.check(model)?;
    let clock = ThreadTime::try_now();
    let (lower, upper) = bounds(model);
    let bounds = (&lower[..], &upper[..]);
    let guess = Path::guess(model, problem, settings.guess, bounds)?;
    let units = Units::new(model, &guess, bounds);
    let Some(tableau) = ButcherTableau::new(Scheme::RadauIia, settings.stages) else {
        return Err(settings.refuse_stages());
    };
    let start: Vec<f64> = problem.q.iter().chain(&problem.v).copied().collect();
    let parabolas = parabolas(model, &start);
    let setting = Setting {
        model,
        problem,
        tableau: &tableau,
        units: &units,
        bounds,
        parabolas: &parabolas,
    };
    let mut search = Search {
        setting,
        settings,
        progress,
        counts: Counts::default(),
        tried: Vec::new(),
        best: None,
        undecided: false,
        failure: None,
    };
    let mut solution = search.run(&guess)?;
    if let Ok(elapsed) = clock.and_then(|clock| clock.try_elapsed()) {
        solution.seconds = elapsed.as_secs_f64();
    }
    Ok(solution)
}

/// A motion of the global phase.
struct Relaxed {
    objective: f64,
    path: Path,
    /// Which contacts are closed in each element.
    closed: Vec<Vec<bool>>,
    /// Elements an interval.
    elements: usize,
}

/// A solved program of a sequence.
struct Local<'a> {
    program: Collocation<'a>,
    solution: nlp::Solution,
    path: Path,
    sequence: Sequence,
    cuts: Vec<Cut>,
}

/// The search over contact sequences.
struct Search<'a, 's> {
    setting: Setting<'a>,
    settings: &'s Settings,
    progress: &'s mut dyn FnMut(Progress),
    counts: Counts,
    tried: Vec<Signature>,
    best: Option<Local<'a>>,
    /// Whether a neighbour of the best could not be solved.
    undecided: bool,
    /// Why the last program failed, and its worst rows.
    failure: Option<(nlp::Status, Vec<nlp::Violation>)>,
}

impl<'a> Search<'a, '_> {
    fn run(&mut self, guess: &Path) -> Result<Solution, InputError> {
        let mut found: Vec<(Local<'a>, Stationarity)> = Vec::new();
        for global in self.global(guess)?.into_iter().take(self.settings.starts) {
            self.read_and_attempt(global)?;
            let stationarity = self.repair()?;
            if let Some(best) = self.best.take() {
                let objective = best.solution.objective;
                let place = found.partition_point(|(l, _)| l.solution.objective < objective);
                found.insert(place, (best, stationarity));
            }
        }
        // The best that the re-simulation confirms, or else the best.
        let mut result: Option<Solution> = None;
        for (local, stationarity) in found {
            let solution = self.finish(local, stationarity)?;
            let confirmed = solution.status != Status::Unconfirmed;
            if confirmed || result.is_none() {
                result = Some(solution);
            }
            if confirmed {
                break;
            }
        }
        Ok(match result {
            Some(solution) => solution,
            None => self.failed(),
        })
    }

    /// Attempts the sequences that a relaxed motion suggests. It and the event-driven motion under the same
    /// controls may disagree where the motion is sensitive, and short contacts may be meant or not: all are
    /// candidates, the likely ones first.
    fn read_and_attempt(&mut self, global: Relaxed) -> Result<(), InputError> {
        let replay = self.simulate(&global.path, self.settings.replay_tolerance)?;
        let relaxed =
            Sequence::of_elements(self.closed_at_start(), &global.closed, global.elements);
        let mut candidates = vec![(relaxed, global.path)];
        if replay.status == SimulationStatus::Solved {
            let path = &candidates[0].1;
            let simulated = Path::of_simulation(
                self.setting.model,
                &replay,
                path.horizon,
                path.controls.clone(),
            );
            candidates.push((self.read(&replay, path), simulated));
        }
        let tidied = candidates
            .iter()
            .map(|(sequence, path)| (sequence.clone().tidied(), path));
        let raw = candidates.iter().filter(|(sequence, _)| {
            let short = sequence.switches.len() - sequence.clone().tidied().switches.len();
            short <= SHORT_SWITCHES
        });
        let raw = raw.map(|(sequence, path)| (sequence.clone(), path));
        for (sequence, path) in tidied.chain(raw) {
            let Some(sequence) = sequence.ordered(self.setting.problem.intervals) else {
                continue;
            };
            if !self.tried.contains(&sequence.signature()) {
                self.attempt(&sequence, path, &[])?;
            }
        }
        Ok(())
    }

    fn report(&mut self, step: &'static str) {
        (self.progress)(Progress {
            step,
            programs: self.counts.programs,
            iterations: self.counts.global_iterations + self.counts.iterations,
            objective: self.best.as_ref().map(|best| best.solution.objective),
        });
    }

    /// The contact-implicit phase: distinct motions, the best first; the guess itself if no program could be solved.
    fn global(&mut self, guess: &Path) -> Result<Vec<Relaxed>, InputError> {
        let mut coarse: Vec<Relaxed> = Vec::new();
        let mut unsolved = 0;
        for (elements, rules) in COARSE {
            for &rule in rules {
                let found = self.relaxed(guess, elements, rule, COARSE_RELAXATION)?;
                unsolved += usize::from(found.is_none());
                insert(&mut coarse, found);
            }
        }
        let mut starts: Vec<Path> = coarse.into_iter().map(|found| found.path).collect();
        // Programs that fail or end far apart cast doubt on the others.
        let hard = unsolved > 0;
        if starts.is_empty() {
            starts.push(guess.clone());
        }
        let mut fine: Vec<Relaxed> = Vec::new();
        for start in &starts {
            for (index, &rule) in FINE_RULES.iter().enumerate() {
                if index >= FINE_ALTERNATIVES && !fine.is_empty() {
                    break;
                }
                let found = self.relaxed(start, FINE, rule, FINE_RELAXATION)?;
                let solved = found.is_some();
                insert(&mut fine, found);
                if solved && !hard {
                    break;
                }
            }
        }
        if fine.is_empty() {
            // Too few elements for the motion, perhaps: the next phase starts from the guess.
            fine.push(Relaxed {
                objective: f64::INFINITY,
                path: guess.clone(),
                closed: vec![self.closed_at_start(); FINE * self.setting.problem.intervals],
                elements: FINE,
            });
        }
        Ok(fine)
    }

    /// One contact-implicit program, relaxed by one rule down to `relaxation.0` from the barrier parameter
    /// `relaxation.1`.
    fn relaxed(
        &mut self,
        start: &Path,
        elements: usize,
        rule: RelaxationRule,
        relaxation: (f64, f64),
    ) -> Result<Option<Relaxed>, InputError> {
        let Setting {
            model,
            problem,
            units,
            bounds,
            ..
        } = self.setting;
        let mut program = ContactImplicit::new(model, problem, elements, start, units, bounds);
        let mut settings = mpcc::Settings {
            rules: vec![rule],
            crossover: false,
            final_relaxation: relaxation.0,
            ..mpcc::Settings::default()
        };
        settings.interior_point.initial_barrier_parameter = relaxation.1;
        settings.interior_point.maximum_iterations = self.settings.maximum_iterations;
        let solution =
            mpcc::solve(&mut program.program, &settings).map_err(|error| refused(&error))?;
        self.counts.programs += 1;
        self.counts.global_iterations += solution.iterations;
        self.counts.factorizations += solution.factorizations;
        self.report("contact-implicit search");
        if solution.status == mpcc::Status::Relaxed {
            return Ok(Some(Relaxed {
                objective: solution.objective,
                path: program.path(&solution.x),
                closed: program.closed(&solution.x),
                elements,
            }));
        }
        let status = match solution.status {
            mpcc::Status::Failed(status) => status,
            _ => nlp::Status::Infeasible,
        };
        self.failure = Some((status, solution.violations));
        Ok(None)
    }

    fn simulate(&self, path: &Path, tolerance: f64) -> Result<Simulation, InputError> {
        let problem = self.setting.problem;
        let simulator = EventDriven {
            tolerance,
            max_step: Some(path.horizon / problem.intervals as f64),
            output_times: OUTPUTS * problem.intervals,
            ..EventDriven::default()
        };
        let motion = problem.initial_value_problem(path.horizon, path.signal());
        simulator.simulate(self.setting.model, &motion, &mut |_| {})
    }

    /// Contacts that the motion starts on.
    fn closed_at_start(&self) -> Vec<bool> {
        let Setting { model, problem, .. } = self.setting;
        let input = problem
            .initial_value_problem(1.0, simulation::ControlSignal::Zero)
            .input(model);
        (0..model.declaration().contacts.len())
            .map(|contact| model.gap(contact, &input) <= AT_START * self.setting.units.gap[contact])
            .collect()
    }

    fn read(&self, replay: &Simulation, path: &Path) -> Sequence {
        let intervals = self.setting.problem.intervals;
        let forces = replay.trajectory.contact_force.first();
        let initially = forces.map(|forces| forces.iter().map(|&f| f > 0.0).collect());
        Sequence::read(
            initially.unwrap_or_default(),
            &replay.events,
            path.horizon / intervals as f64,
            intervals,
        )
    }

    /// Solves the program of a sequence with its cuts and keeps it if it is the best; says whether it is.
    fn attempt(
        &mut self,
        sequence: &Sequence,
        guess: &Path,
        cuts: &[Cut],
    ) -> Result<bool, InputError> {
        self.tried.push(sequence.signature());
        let mut cuts = cuts.to_vec();
        let mut guess = guess.clone();
        let mut sequence = sequence.clone();
        for round in 0..ROUNDS {
            let barriers = if round > 0 {
                &BARRIERS_AFTER_CUT[..]
            } else if self.best.is_some() {
                &NEIGHBOUR_BARRIERS[..]
            } else {
                &BARRIERS[..]
            };
            let Some((program, solution)) = self.solve(&sequence, &guess, &cuts, barriers)? else {
                self.undecided |= !matches!(self.failure, Some((nlp::Status::Infeasible, _)));
                return Ok(false);
            };
            let objective = solution.objective;
            if let Some(best) = &self.best
                && objective > best.solution.objective - IMPROVEMENT * objective.abs().max(1.0)
            {
                return Ok(false);
            }
            let limits = Limits {
                gap: TOUCHING * self.settings.gap_margin,
                margin: self.settings.gap_margin,
                bound: self.settings.tolerance,
                bounds: self.setting.bounds,
            };
            let new = between_stages(&program, &solution.x, self.setting.parabolas, limits);
            (guess, sequence) = program.result(&solution.x);
            // What is left after the last round is for the re-simulation to judge.
            if new.is_empty() || round + 1 == ROUNDS {
                self.best = Some(Local {
                    program,
                    solution,
                    path: guess,
                    sequence,
                    cuts,
                });
                return Ok(true);
            }
            cuts.extend(new);
        }
        Ok(false)
    }

    /// Solves one program from the first barrier parameter that works.
    fn solve(
        &mut self,
        sequence: &Sequence,
        guess: &Path,
        cuts: &[Cut],
        barriers: &[f64],
    ) -> Result<Option<(Collocation<'a>, nlp::Solution)>, InputError> {
        for &barrier in barriers {
            let mut program = Collocation::new(self.setting, sequence, guess, cuts);
            let mut settings = nlp::Settings {
                tolerance: self.settings.tolerance,
                constraint_tolerance: self.settings.tolerance,
                initial_barrier_parameter: barrier,
                maximum_iterations: self.settings.maximum_iterations,
                ..nlp::Settings::default()
            };
            if self.best.is_some() {
                // A neighbour starts near its solution, or is not worth much.
                settings.maximum_iterations = settings.maximum_iterations.min(NEIGHBOUR_ITERATIONS);
            }
            let solution =
                nlp::solve(&mut program.program, &settings).map_err(|error| refused(&error))?;
            self.counts.programs += 1;
            self.counts.iterations += solution.counts.iterations;
            self.counts.factorizations += solution.counts.factorizations;
            self.report("collocation");
            if matches!(
                solution.status,
                nlp::Status::Solved | nlp::Status::Acceptable
            ) {
                return Ok(Some((program, solution)));
            }
            self.failure = Some((solution.status, solution.violations));
        }
        Ok(None)
    }

    /// Follows improving neighbours until there is none; says what was proved.
    fn repair(&mut self) -> Result<Stationarity, InputError> {
        let intervals = self.setting.problem.intervals;
        loop {
            let Some(best) = self.best.take() else {
                return Ok(Stationarity::None);
            };
            let pressure = Pressure {
                program: &best.program,
                solution: &best.solution,
                sequence: &best.sequence,
                intervals,
                touching: TOUCHING * self.settings.gap_margin,
            };
            let directed = pressure.directed();
            let neighbours: Vec<Sequence> =
                directed.into_iter().chain(pressure.insertions()).collect();
            let (path, cuts) = (best.path.clone(), best.cuts.clone());
            self.best = Some(best);
            let stationarity = if neighbours.is_empty() {
                Stationarity::S
            } else {
                Stationarity::B
            };
            let mut improved = false;
            self.undecided = false;
            for neighbour in neighbours {
                if self.tried.contains(&neighbour.signature()) {
                    continue;
                }
                if self.counts.programs >= self.settings.maximum_programs {
                    return Ok(Stationarity::None);
                }
                if self.attempt(&neighbour, &path, &cuts)? {
                    improved = true;
                    break;
                }
            }
            if !improved {
                return Ok(if self.undecided {
                    Stationarity::None
                } else {
                    stationarity
                });
            }
            self.counts.repairs += 1;
        }
    }

    /// A result without a motion.
    fn failed(&mut self) -> Solution {
        let (status, violations) = self
            .failure
            .take()
            .unwrap_or((nlp::Status::IterationLimit, Vec::new()));
        let status = match status {
            nlp::Status::Infeasible => Status::Infeasible,
            status => Status::Failed(status),
        };
        Solution::without_motion(status, violations, self.counts)
    }

    /// Re-simulates a motion and compares.
    fn finish(
        &mut self,
        best: Local<'a>,
        stationarity: Stationarity,
    ) -> Result<Solution, InputError> {
        let replay = self.simulate(&best.path, self.settings.resimulation_tolerance)?;
        self.report("re-simulation");
        let n = self.setting.problem.q.len();
        let planned = best.path.at(best.path.horizon, true);
        let reached = replay.trajectory.q.last();
        let distance = match (&replay.status, reached) {
            (SimulationStatus::Solved, Some(q)) => q
                .iter()
                .zip(&planned[..n])
                .fold(0.0, |largest: f64, (a, b)| largest.max((a - b).abs())),
            _ => f64::INFINITY,
        };
        let read = self.read(&replay, &best.path);
        let kinds = |sequence: &Sequence| -> Vec<(usize, bool)> {
            let switches = sequence.switches.iter();
            switches.map(|s| (s.contact, s.closes)).collect()
        };
        let agrees =
            distance <= self.settings.largest_distance && kinds(&read) == kinds(&best.sequence);
        let status = if !agrees {
            Status::Unconfirmed
        } else if stationarity == Stationarity::None {
            Status::Uncertified
        } else {
            Status::Solved
        };
        let complementarity = complementarity(&best);
        let residuals = simulation::Residuals {
            primal: best.solution.residuals.primal,
            dual: best.solution.residuals.dual,
            complementarity,
        };
        let (equalities, inequalities) = best.program.program.row_counts();
        let size = Size {
            variables: best.program.program.variables(),
            equalities,
            inequalities,
            jacobian_nonzeros: best.program.program.jacobian_pattern().len(),
            hessian_nonzeros: best.program.program.hessian_pattern().len(),
        };
        let planned_events = best.sequence.switches.iter().map(|switch| {
            let time = switch.time * best.path.horizon / self.setting.problem.intervals as f64;
            let kind = if switch.closes {
                EventKind::Impact
            } else {
                EventKind::LiftOff
            };
            (time, kind, switch.contact)
        });
        Ok(Solution {
            status,
            objective: best.solution.objective,
            horizon: best.path.horizon,
            stationarity,
            resimulation_error: distance,
            residuals,
            planned_events: planned_events.collect(),
            controls: best.path.controls,
            motion: Some(replay),
            violations: best.solution.violations,
            size,
            counts: self.counts,
            seconds: 0.0,
        })
    }
}

/// Largest `min(g, r)` over all stages and contacts: 0 by construction wherever one of them is fixed.
fn complementarity(best: &Local) -> f64 {
    let x = best.program.program.physical(&best.solution.x);
    let model = best.program.model;
    let mut input = vec![0.0; model.declaration().inputs()];
    let mut largest: f64 = 0.0;
    for phase in &best.program.phases {
        for stage in &phase.stages {
            for (slot, &variable) in input.iter_mut().zip(&stage.state) {
                *slot = x[variable];
            }
            for (&contact, &force) in phase.closed.iter().zip(&stage.forces) {
                largest = largest.max(model.gap(contact, &input).abs().min(x[force].abs()));
            }
        }
    }
    largest
}

/// Adds a motion to those sorted by objective, unless one with the same objective is there.
fn insert(motions: &mut Vec<Relaxed>, found: Option<Relaxed>) {
    let Some(found) = found else { return };
    let objective = found.objective;
    let tolerance = SAME * objective.abs().max(f64::MIN_POSITIVE);
    let same = |other: &Relaxed| (other.objective - objective).abs() <= tolerance;
    if !motions.iter().any(same) {
        let place = motions.partition_point(|other| other.objective < objective);
        motions.insert(place, found);
    }
}

/// A refusal of the interior point method: the programs here are built to be accepted, except where the
/// model's functions are not finite.
fn refused(error: &nlp::InputError) -> InputError {
    InputError::NotFinite {
        what: format!("optimal control: {error}; a number there"),
        value: f64::NAN,
    }
}
