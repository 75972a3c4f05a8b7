//! Contact sequences from contact-implicit programs, from coarse to fine.

use hangtime_solver::mpcc;
use hangtime_solver::mpcc::RelaxationRule;

use super::contact_implicit::ContactImplicit;
use super::start_modes::modes_at_start;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::passages::with_passages;
use crate::ocp::motion::read_sequence::{Elements, of_elements};
use crate::ocp::motion::sequence::Sequence;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::{Failure, Runner};
use crate::ocp::settings::Settings;
use crate::ocp::tuning::equal::MOTION;
use crate::ocp::tuning::off_grid::TOLERANCE;
use crate::ocp::tuning::relaxed::{
    COARSE_LAST, COARSE_PROGRAMS, FINE_BARRIER, FINE_RELAXED, LEAST_ELEMENTS,
};
use crate::simulation::InputError;

/// The first programs.
const COARSE: Relaxation = Relaxation {
    last: COARSE_LAST,
    tolerance: TOLERANCE,
    barrier: None,
};

/// The refined ones, which start at solutions of the first ones.
const FINE: Relaxation = Relaxation {
    last: FINE_RELAXED,
    tolerance: FINE_RELAXED,
    barrier: Some(FINE_BARRIER),
};

/// Rules of the refined programs, in the order in which they are tried.
const FINE_RULES: [RelaxationRule; 3] = [
    RelaxationRule::Proportional,
    RelaxationRule::RollOff,
    RelaxationRule::Continuation,
];

/// How far a program is relaxed: only which contacts close when is read from it.
#[derive(Clone, Copy)]
struct Relaxation {
    /// Last relaxation parameter.
    last: f64,
    /// Tolerance of the interior point method.
    tolerance: f64,
    /// First barrier parameter, unless it is that of the settings.
    barrier: Option<f64>,
}

/// Elements of an interval in the refined programs.
pub(in crate::ocp) fn refined_elements(settings: &Settings, intervals: usize) -> usize {
    LEAST_ELEMENTS.div_ceil(intervals) * settings.refined_elements
}

/// The contact-implicit phase from a guess.
pub(in crate::ocp) struct CoarseToFine<'a, 'g> {
    setting: Setting<'a>,
    guess: &'g Trajectory,
    /// How many of the first programs were solved.
    programs: usize,
    /// Objectives of the distinct motions of the first programs, and of the refined ones.
    coarse: Vec<f64>,
    fine: Vec<f64>,
}

impl<'a, 'g> CoarseToFine<'a, 'g> {
    pub(in crate::ocp) fn new(setting: Setting<'a>, guess: &'g Trajectory) -> Self {
        Self {
            setting,
            guess,
            programs: 0,
            coarse: Vec::new(),
            fine: Vec::new(),
        }
    }

    /// The next distinct motion; at last the guess itself, if no program could be solved.
    pub(in crate::ocp) fn next(
        &mut self,
        runner: &mut Runner,
    ) -> Result<Option<Candidate>, InputError> {
        let intervals = self.setting.problem.intervals;
        let elements = refined_elements(runner.settings, intervals);
        while let Some(&(per_interval, rule)) = COARSE_PROGRAMS.get(self.programs) {
            if runner.stopped() {
                return Ok(None);
            }
            self.programs += 1;
            let coarse = LEAST_ELEMENTS.div_ceil(intervals) * per_interval;
            let found = relaxed(runner, self.setting, self.guess, coarse, rule, COARSE)?;
            let Some(found) = found else {
                continue;
            };
            if !is_new(&mut self.coarse, found.objective) {
                continue;
            }
            let start = &found.trajectory;
            let Some(refined) = refined(runner, self.setting, start, elements)? else {
                continue;
            };
            let new = is_new(&mut self.fine, refined.objective);
            // Two programs that lead to the same motion leave little doubt.
            if !new {
                self.programs = COARSE_PROGRAMS.len();
            }
            if new {
                return Ok(Some(refined));
            }
        }
        self.last(runner, elements)
    }

    /// What is left where the programs came to nothing.
    fn last(
        &mut self,
        runner: &mut Runner,
        elements: usize,
    ) -> Result<Option<Candidate>, InputError> {
        if !self.fine.is_empty() || runner.stopped() {
            return Ok(None);
        }
        let (setting, guess) = (self.setting, self.guess);
        let refined = if self.coarse.is_empty() {
            refined(runner, setting, guess, elements)?
        } else {
            None
        };
        let last = refined.unwrap_or_else(|| {
            // Too few elements for the motion, perhaps: the next phase starts from the guess.
            let sequence = Sequence::without_switches(modes_at_start(setting, guess));
            Candidate {
                objective: f64::INFINITY,
                sequence: with_passages(setting.model, sequence, guess, false),
                trajectory: guess.clone(),
            }
        });
        self.fine.push(last.objective);
        Ok(Some(last))
    }
}

/// The program with many elements from a relaxed motion, by the first rule that works.
fn refined(
    runner: &mut Runner,
    setting: Setting,
    start: &Trajectory,
    elements: usize,
) -> Result<Option<Candidate>, InputError> {
    for rule in FINE_RULES {
        if runner.stopped() {
            break;
        }
        let found = relaxed(runner, setting, start, elements, rule, FINE)?;
        if found.is_some() {
            return Ok(found);
        }
    }
    Ok(None)
}

/// The motion of one contact-implicit program with that many elements an interval, relaxed by one rule.
fn relaxed(
    runner: &mut Runner,
    setting: Setting,
    start: &Trajectory,
    elements: usize,
    rule: RelaxationRule,
    relaxation: Relaxation,
) -> Result<Option<Candidate>, InputError> {
    let mut program = ContactImplicit::new(setting, elements, start);
    let mut settings = mpcc::Settings::default();
    settings.rules = vec![rule];
    settings.crossover = false;
    settings.interior_point.objective_unit = Some(1.0);
    settings.final_relaxation = relaxation.last;
    settings.interior_point.initial_barrier_parameter =
        relaxation.barrier.unwrap_or(runner.settings.first_barrier);
    settings.interior_point.tolerance = relaxation.tolerance;
    settings.interior_point.maximum_iterations = runner.settings.maximum_iterations;
    let unit = program.program.objective_unit();
    let step = "contact-implicit programs";
    let Ok(solution) = runner.relax(&mut program.program, &settings, (step, usize::MAX), unit)
    else {
        return Ok(None);
    };
    let trajectory = program.trajectory(&solution.x);
    if let Some(failure) = Failure::of_relaxed(&solution) {
        runner.note(failure);
        return Ok(None);
    }
    let modes = program.modes(&solution.x);
    let count = modes.len();
    let elements = Elements {
        ends: (1..=count)
            .map(|end| end as f64 / elements as f64)
            .collect(),
        per_interval: elements,
        modes,
    };
    let initially = modes_at_start(setting, &trajectory);
    // In the middle of its element: an Euler step says no more.
    let sequence = of_elements(initially, &elements, 0.5);
    Ok(Some(Candidate {
        objective: unit * solution.objective,
        sequence: with_passages(setting.model, sequence, &trajectory, false),
        trajectory,
    }))
}

/// Adds the objective of a motion to others, unless it is there; says whether it did.
fn is_new(objectives: &mut Vec<f64>, objective: f64) -> bool {
    let new = !objectives.iter().any(|&other| is_same(other, objective));
    if new {
        objectives.push(objective);
    }
    new
}

fn is_same(one: f64, objective: f64) -> bool {
    (one - objective).abs() <= MOTION * objective.abs().max(f64::MIN_POSITIVE)
}
