//! The search for contact sequences: contact-implicit programs from coarse to fine.

use super::collocation::Setting;
use super::contact_implicit::ContactImplicit;
use super::mode::{Mode, is_rough, sliding_velocity, zero_velocity};
use super::path::Path;
use super::search::{Search, refused};
use super::sequence::Sequence;
use crate::mpcc::{self, RelaxationRule};
use crate::nlp;
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
    barrier: 1e-1,
};
/// The refined ones, which start at solutions of the first ones.
const FINE: Relaxation = Relaxation {
    last: 1e-6,
    tolerance: 1e-6,
    barrier: 1e-4,
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
/// Gap below which a motion starts on a surface, in its unit.
const AT_START: f64 = 1e-9;
/// The same where initial values are free: as far as a relaxed program may hold it off.
const NEAR_START: f64 = 1e-3;

/// How far a program is relaxed: only which contacts close when is read from it.
#[derive(Clone, Copy)]
struct Relaxation {
    /// Last relaxation parameter.
    last: f64,
    /// Tolerance of the interior point method.
    tolerance: f64,
    /// First barrier parameter.
    barrier: f64,
}

/// A motion of the global phase.
pub(super) struct Relaxed {
    pub(super) objective: f64,
    pub(super) path: Path,
    pub(super) sequence: Sequence,
}

impl Search<'_, '_> {
    /// The contact-implicit phase: distinct motions, the best first; the guess itself if no program could be solved.
    pub(super) fn global(&mut self, guess: &Path) -> Result<Vec<Relaxed>, InputError> {
        let finer = LEAST_ELEMENTS.div_ceil(self.setting.problem.intervals);
        let elements = finer * self.settings.refined_elements;
        let mut coarse: Vec<Relaxed> = Vec::new();
        let mut fine: Vec<Relaxed> = Vec::new();
        for (per_interval, rule) in COARSE_PROGRAMS {
            if self.watch.stopped {
                return Ok(Vec::new());
            }
            let Some(found) = self.relaxed(guess, finer * per_interval, rule, COARSE)? else {
                continue;
            };
            let start = found.path.clone();
            if !insert(&mut coarse, found) {
                continue;
            }
            // Two programs that lead to the same motion leave little doubt.
            if let Some(refined) = self.refined(&start, elements)?
                && !insert(&mut fine, refined)
            {
                break;
            }
        }
        if coarse.is_empty()
            && let Some(refined) = self.refined(guess, elements)?
        {
            fine.push(refined);
        }
        if fine.is_empty() {
            // Too few elements for the motion, perhaps: the next phase starts from the guess.
            fine.push(Relaxed {
                objective: f64::INFINITY,
                path: guess.clone(),
                sequence: Sequence {
                    initially: self.modes_at_start(guess),
                    switches: Vec::new(),
                },
            });
        }
        Ok(fine)
    }

    /// The contact-implicit motion on the grid of the problem that a motion on a coarser grid leads to.
    pub(super) fn on_this_grid(&mut self, coarser: &Path) -> Result<Option<Relaxed>, InputError> {
        let intervals = self.setting.problem.intervals;
        let elements = LEAST_FINE_ELEMENTS.div_ceil(intervals);
        self.refined(coarser, elements)
    }

    /// The program with many elements from a relaxed motion, by the first rule that works.
    fn refined(&mut self, start: &Path, elements: usize) -> Result<Option<Relaxed>, InputError> {
        for rule in FINE_RULES {
            if self.watch.stopped {
                break;
            }
            let found = self.relaxed(start, elements, rule, FINE)?;
            if found.is_some() {
                return Ok(found);
            }
        }
        Ok(None)
    }

    /// One contact-implicit program, relaxed by one rule.
    fn relaxed(
        &mut self,
        start: &Path,
        elements: usize,
        rule: RelaxationRule,
        relaxation: Relaxation,
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
            final_relaxation: relaxation.last,
            ..mpcc::Settings::default()
        };
        settings.interior_point.initial_barrier_parameter = relaxation.barrier;
        settings.interior_point.tolerance = relaxation.tolerance;
        settings.interior_point.maximum_iterations = self.settings.maximum_iterations;
        self.watch
            .begin("contact-implicit search", &self.counts, None);
        let unit = program.program.objective_unit();
        let mut observer = |info: &nlp::IterationInfo| self.watch.iteration(info, unit);
        let solution = mpcc::solve_observed(&mut program.program, &settings, &mut observer)
            .map_err(|error| refused(&error))?;
        self.counts.programs += 1;
        self.counts.global_iterations += solution.iterations;
        self.counts.factorizations += solution.factorizations;
        if solution.status == mpcc::Status::Relaxed {
            let modes = program.modes(&solution.x);
            let ends: Vec<f64> = (1..=modes.len())
                .map(|end| end as f64 / elements as f64)
                .collect();
            let path = program.path(&solution.x);
            let initially = self.modes_at_start(&path);
            return Ok(Some(Relaxed {
                objective: unit * solution.objective,
                path,
                sequence: Sequence::of_elements(initially, &modes, (elements, &ends), CLOSING),
            }));
        }
        let status = match solution.status {
            mpcc::Status::Failed(status) => status,
            _ => nlp::Status::Infeasible,
        };
        self.note_failure(status, solution.violations);
        Ok(None)
    }

    /// What the contacts do at the start of a path.
    pub(super) fn modes_at_start(&self, path: &Path) -> Vec<Mode> {
        let Setting { model, units, .. } = self.setting;
        let mut input = self.setting.problem.start_of(model, path);
        let zero = zero_velocity(&input[input.len() / 2..]);
        input.resize(model.declaration().inputs(), 0.0);
        let free = self.setting.problem.has_free_start(model);
        let near = if free { NEAR_START } else { AT_START };
        (0..model.declaration().contacts.len())
            .map(|contact| {
                if model.gap(contact, &input) > near * units.gap[contact] {
                    return Mode::Open;
                }
                let rough = is_rough(model, contact);
                let slides = rough.then(|| sliding_velocity(model, contact, &input, 0.0));
                Mode::closed(rough, slides.unwrap_or(0.0), zero)
            })
            .collect()
    }
}

/// Adds a motion to those sorted by objective, unless one with the same objective is there; says whether it did.
fn insert(motions: &mut Vec<Relaxed>, found: Relaxed) -> bool {
    let objective = found.objective;
    let tolerance = SAME * objective.abs().max(f64::MIN_POSITIVE);
    let same = |other: &Relaxed| (other.objective - objective).abs() <= tolerance;
    if motions.iter().any(same) {
        return false;
    }
    let place = motions.partition_point(|other| other.objective < objective);
    motions.insert(place, found);
    true
}
