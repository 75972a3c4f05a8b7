//! The search for contact sequences: contact-implicit programs from coarse to fine.

use hangtime_solver::mpcc;
use hangtime_solver::mpcc::RelaxationRule;

use super::contact_implicit::ContactImplicit;
use super::start_modes::modes_at_start;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::effort::Effort;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::passages::with_passages;
use crate::ocp::motion::read_sequence::{Elements, of_elements};
use crate::ocp::motion::sequence::Sequence;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::{Failure, Runner};
use crate::ocp::settings::Settings;
use crate::simulation::InputError;

/// Elements an interval of the first programs of the global phase, and the rules that relax them: the programs differ
/// in the local optima that they end at.
const COARSE_PROGRAMS: [(usize, RelaxationRule); 3] = [
    (1, RelaxationRule::Proportional),
    (2, RelaxationRule::Continuation),
    (2, RelaxationRule::RollOff),
];

/// Least number of elements of the whole motion in the coarsest program; with fewer intervals they are divided.
const LEAST_ELEMENTS: usize = 24;

/// The same of a program that carries a motion on to a finer grid.
const LEAST_FINE_ELEMENTS: usize = 120;

/// The first programs.
const COARSE: Relaxation = Relaxation {
    last: 1e-3,
    tolerance: 1e-4,
    barrier: None,
};

/// The refined ones, which start at solutions of the first ones.
const FINE: Relaxation = Relaxation {
    last: 1e-6,
    tolerance: 1e-6,
    barrier: Some(1e-4),
};

/// Rules of the refined programs, in the order in which they are tried.
const FINE_RULES: [RelaxationRule; 3] = [
    RelaxationRule::Proportional,
    RelaxationRule::RollOff,
    RelaxationRule::Continuation,
];

/// Relative difference of the objective within which two relaxed motions count as the same.
const SAME: f64 = 1e-3;

/// Where in an element of implicit Euler a contact closes, as a share of the element: it says no more.
const CLOSING: f64 = 0.5;

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

/// The contact-implicit phase: distinct motions, the best first; the guess itself if no program could be solved.
pub(in crate::ocp) fn candidates(
    runner: &mut Runner,
    setting: Setting,
    guess: &Trajectory,
) -> Result<Vec<Candidate>, InputError> {
    let finer = LEAST_ELEMENTS.div_ceil(setting.problem.intervals);
    let elements = refined_elements(runner.settings, setting.problem.intervals);
    let mut coarse: Vec<Candidate> = Vec::new();
    let mut fine: Vec<Candidate> = Vec::new();
    for (per_interval, rule) in COARSE_PROGRAMS {
        if runner.stopped() {
            return Ok(Vec::new());
        }
        let elements_here = finer * per_interval;
        let Some(found) = relaxed(runner, setting, guess, elements_here, rule, COARSE)? else {
            continue;
        };
        let start = found.trajectory.clone();
        if !insert(&mut coarse, found) {
            continue;
        }
        // Two programs that lead to the same motion leave little doubt.
        if let Some(refined) = refined(runner, setting, &start, elements)?
            && !insert(&mut fine, refined)
        {
            break;
        }
    }
    if coarse.is_empty()
        && let Some(refined) = refined(runner, setting, guess, elements)?
    {
        fine.push(refined);
    }
    if fine.is_empty() {
        // Too few elements for the motion, perhaps: the next phase starts from the guess.
        let sequence = Sequence::without_switches(modes_at_start(setting, guess));
        fine.push(Candidate {
            objective: f64::INFINITY,
            sequence: with_passages(setting.model, sequence, guess, false),
            trajectory: guess.clone(),
        });
    }
    Ok(fine)
}

/// The contact-implicit motion on the grid of the problem that a motion on a coarser grid leads to.
pub(in crate::ocp) fn on_this_grid(
    runner: &mut Runner,
    setting: Setting,
    coarser: &Trajectory,
) -> Result<Option<Candidate>, InputError> {
    let elements = LEAST_FINE_ELEMENTS.div_ceil(setting.problem.intervals);
    refined(runner, setting, coarser, elements)
}

/// The program with many elements from a relaxed motion, by the first rule that works.
fn refined(
    runner: &mut Runner,
    setting: Setting,
    start: &Trajectory,
    elements: usize,
) -> Result<Option<Candidate>, InputError> {
    let rules = match runner.effort {
        Effort::Explore => &FINE_RULES[..1],
        Effort::Carry | Effort::Certify => &FINE_RULES,
    };
    for &rule in rules {
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

/// One contact-implicit program with that many elements an interval, relaxed by one rule.
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
    settings.final_relaxation = relaxation.last;
    settings.interior_point.initial_barrier_parameter =
        relaxation.barrier.unwrap_or(runner.settings.first_barrier);
    settings.interior_point.tolerance = relaxation.tolerance;
    settings.interior_point.maximum_iterations = runner.settings.maximum_iterations;
    let unit = program.program.objective_unit();
    let step = "contact-implicit search";
    let solution = runner.relax(&mut program.program, &settings, step, unit)?;
    let trajectory = program.trajectory(&solution.x);
    if let Some(failure) = Failure::of_relaxed(&solution, trajectory.horizon) {
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
    let sequence = of_elements(initially, &elements, CLOSING);
    Ok(Some(Candidate {
        objective: unit * solution.objective,
        sequence: with_passages(setting.model, sequence, &trajectory, false),
        trajectory,
    }))
}

/// Adds a motion to those sorted by objective, unless one with the same objective is there; says whether it did.
fn insert(motions: &mut Vec<Candidate>, found: Candidate) -> bool {
    let objective = found.objective;
    let tolerance = SAME * objective.abs().max(f64::MIN_POSITIVE);
    let same = |other: &Candidate| (other.objective - objective).abs() <= tolerance;
    if motions.iter().any(same) {
        return false;
    }
    let place = motions.partition_point(|other| other.objective < objective);
    motions.insert(place, found);
    true
}
