//! The search for contact sequences: contact-implicit programs from coarse to fine.

use hangtime_solver::mpcc;
use hangtime_solver::mpcc::RelaxationRule;
use hangtime_solver::nlp;

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
use crate::ocp::tuning::equal::MOTION;
use crate::ocp::tuning::off_grid::TOLERANCE;
use crate::ocp::tuning::relaxed::{
    COARSE_LAST, COARSE_PROGRAMS, FINE_BARRIER, FINE_RELAXED, INFEASIBLE, LEAST_ELEMENTS,
    LEAST_FINE_ELEMENTS, SAME_BETWEEN_STARTS,
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

/// The relaxed motions on a grid that searches came through.
#[derive(Clone, Default)]
pub(in crate::ocp) struct RelaxedMotions {
    /// Start of the present search.
    start: usize,
    motions: Vec<RelaxedMotion>,
}

/// A relaxed motion.
#[derive(Clone)]
struct RelaxedMotion {
    /// Start of the search.
    start: usize,
    /// Which of the first programs it solves; none if a refined one.
    program: Option<usize>,
    objective: f64,
}

impl RelaxedMotions {
    /// The same for the search from another start.
    pub(in crate::ocp) fn from(mut self, start: usize) -> Self {
        self.start = start;
        self
    }

    /// Whether no search came through any.
    pub(in crate::ocp) fn are_none(&self) -> bool {
        self.motions.is_empty()
    }

    /// Adds those of another search.
    pub(in crate::ocp) fn extend(&mut self, other: Self) {
        let new = other.motions.into_iter().filter(|m| m.start == other.start);
        self.motions.extend(new);
    }

    /// Adds a motion; the start of an earlier search that came to it.
    fn visit(&mut self, program: Option<usize>, objective: f64) -> Option<usize> {
        let mut before = self.motions.iter().filter(|m| m.start != self.start);
        let visited = before
            .find(|m| m.program == program && is_same(m.objective, objective, SAME_BETWEEN_STARTS));
        let visited = visited.map(|motion| motion.start);
        self.motions.push(RelaxedMotion {
            start: self.start,
            program,
            objective,
        });
        visited
    }
}

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
    /// How many of them were infeasible, or left as they restored feasibility.
    infeasible: usize,
    /// Objectives of the distinct motions of the first programs, and of the refined ones.
    coarse: Vec<f64>,
    fine: Vec<f64>,
    /// The start of a search before this one to whose motions it came, too.
    pub(in crate::ocp) repeats: Option<usize>,
}

impl<'a, 'g> CoarseToFine<'a, 'g> {
    pub(in crate::ocp) fn new(setting: Setting<'a>, guess: &'g Trajectory) -> Self {
        Self {
            setting,
            guess,
            programs: 0,
            infeasible: 0,
            coarse: Vec::new(),
            fine: Vec::new(),
            repeats: None,
        }
    }

    /// The next distinct motion; at last the guess itself, if no program could be solved. Motions that other searches came
    /// through are not refined again.
    pub(in crate::ocp) fn next(
        &mut self,
        runner: &mut Runner,
        known: &mut RelaxedMotions,
    ) -> Result<Option<Candidate>, InputError> {
        let intervals = self.setting.problem.intervals;
        let elements = refined_elements(runner.settings, intervals);
        while let Some(&(per_interval, rule)) = COARSE_PROGRAMS.get(self.programs) {
            if runner.stopped() {
                return Ok(None);
            }
            if self.leaves_the_rest(runner) {
                break;
            }
            let program = self.programs;
            self.programs += 1;
            let coarse = LEAST_ELEMENTS.div_ceil(intervals) * per_interval;
            let found = relaxed(runner, self.setting, self.guess, coarse, rule, COARSE)?;
            let found = match found {
                Ok(found) => found,
                Err(status) => {
                    let infeasible = [nlp::Status::Infeasible, nlp::Status::RestorationFailed];
                    self.infeasible += usize::from(infeasible.contains(&status));
                    continue;
                }
            };
            let visited = known.visit(Some(program), found.objective);
            if !is_new(&mut self.coarse, found.objective) {
                continue;
            }
            if visited.is_some() {
                self.repeats = visited;
                continue;
            }
            let start = &found.trajectory;
            let Some(refined) = refined(runner, self.setting, start, elements)? else {
                continue;
            };
            let visited = known.visit(None, refined.objective);
            let new = is_new(&mut self.fine, refined.objective);
            // Two programs that lead to the same motion leave little doubt.
            if !new || visited.is_some() {
                self.programs = COARSE_PROGRAMS.len();
            }
            if new {
                return Ok(Some(refined));
            }
        }
        self.last(runner, elements)
    }

    /// Whether enough programs are infeasible for one of several starts; a single one is solved with all of them.
    fn leaves_the_rest(&self, runner: &Runner) -> bool {
        runner.effort == Effort::Explore && self.infeasible >= INFEASIBLE
    }

    /// What is left where the programs came to nothing.
    fn last(
        &mut self,
        runner: &mut Runner,
        elements: usize,
    ) -> Result<Option<Candidate>, InputError> {
        let none = self.fine.is_empty() && self.repeats.is_none();
        if !none || runner.stopped() {
            return Ok(None);
        }
        let (setting, guess) = (self.setting, self.guess);
        let refined = if self.coarse.is_empty() && !self.leaves_the_rest(runner) {
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
        Effort::Carry | Effort::Certify | Effort::Conclude => &FINE_RULES,
    };
    for &rule in rules {
        if runner.stopped() {
            break;
        }
        if let Ok(found) = relaxed(runner, setting, start, elements, rule, FINE)? {
            return Ok(Some(found));
        }
    }
    Ok(None)
}

/// One contact-implicit program with that many elements an interval, relaxed by one rule; the status that it ends with if that is no
/// motion.
fn relaxed(
    runner: &mut Runner,
    setting: Setting,
    start: &Trajectory,
    elements: usize,
    rule: RelaxationRule,
    relaxation: Relaxation,
) -> Result<Result<Candidate, nlp::Status>, InputError> {
    let step = runner.settings.step;
    let mut program = ContactImplicit::new(setting, elements, start, step);
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
    let solution = match runner.relax(&mut program.program, &settings, step, unit) {
        Ok(solution) => solution,
        Err(status) => return Ok(Err(status)),
    };
    let trajectory = program.trajectory(&solution.x);
    if let Some(failure) = Failure::of_relaxed(&solution, trajectory.horizon) {
        let status = failure.status;
        runner.note(failure);
        return Ok(Err(status));
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
    Ok(Ok(Candidate {
        objective: unit * solution.objective,
        sequence: with_passages(setting.model, sequence, &trajectory, false),
        trajectory,
    }))
}

/// Adds the objective of a motion to others, unless it is there; says whether it did.
fn is_new(objectives: &mut Vec<f64>, objective: f64) -> bool {
    let new = !objectives
        .iter()
        .any(|&other| is_same(other, objective, MOTION));
    if new {
        objectives.push(objective);
    }
    new
}

fn is_same(one: f64, objective: f64, tolerance: f64) -> bool {
    (one - objective).abs() <= tolerance * objective.abs().max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motion_of_another_start_is_known_and_an_own_one_or_that_of_another_program_is_not() {
        let mut first = RelaxedMotions::default().from(0);
        assert_eq!(first.visit(Some(0), 2.0), None);
        assert_eq!(first.visit(Some(0), 2.0), None);
        let mut known = RelaxedMotions::default();
        known.extend(first);
        let mut second = known.clone().from(1);
        assert_eq!(second.visit(Some(0), 2.0 + 1e-6), Some(0));
        assert_eq!(second.visit(Some(1), 2.0), None);
        assert_eq!(second.visit(None, 2.0), None);
        assert_eq!(second.visit(Some(0), 2.001), None);
        // What a search was given is not counted twice.
        known.extend(second);
        assert_eq!(known.motions.len(), 6);
    }
}
