//! The JSON document of an optimal control problem.

use hangtime::model::Model;
use hangtime::ocp::{Formulation, OptimumGradient, Settings, Solution};
use hangtime::rk::Scheme;
use serde::Serialize;

use super::gradient::existence;
use super::parts::{Motion, Object, begun, found};
use crate::ending::Ending;
use crate::settings::ChosenScene;
use crate::table::per_second;

/// The method of a solution.
#[derive(Serialize)]
pub(crate) struct SolverSettings {
    /// Name of the method.
    pub(crate) name: &'static str,
    /// Runge-Kutta scheme of the last phase.
    pub(crate) scheme: &'static str,
    /// Its stages.
    pub(crate) stages: usize,
    /// Control intervals.
    pub(crate) intervals: usize,
    /// What the controls are on an interval: constant or linear.
    pub(crate) control_shape: &'static str,
    /// Finite elements: of a phase, or of an interval with time-freezing.
    pub(crate) elements: usize,
    /// Starts of the best order of contacts, or that may be solved side by side.
    pub(crate) starts: usize,
    /// Finite elements of a phase, also of the motion that a time-freezing program leads to.
    #[serde(skip)]
    of_a_phase: usize,
}

impl SolverSettings {
    /// The settings of a solve of a scene with `intervals` control intervals.
    pub(crate) fn new(model: &dyn Model, settings: &Settings, intervals: usize) -> Self {
        let (name, scheme, stages, elements) = match &settings.formulation {
            Formulation::Phases => (
                "phases",
                Scheme::RadauIia,
                settings.stages,
                settings.elements,
            ),
            Formulation::TimeFreezing(grid) => {
                let elements = grid.elements_of(model);
                ("time-freezing", grid.scheme, grid.stages, elements)
            }
        };
        Self {
            name,
            scheme: scheme.name(),
            stages,
            intervals,
            control_shape: settings.controls.name(),
            elements,
            starts: settings.starts(),
            of_a_phase: settings.elements,
        }
    }

    /// Says so where a solution has more finite elements than were asked for.
    pub(crate) fn finer(&self, solution: &Solution) -> Option<String> {
        let (asked, most) = (self.of_a_phase, solution.elements.iter().copied().max()?);
        (most > asked)
            .then(|| format!("up to {most} finite elements of a phase instead of {asked}"))
    }
}

/// Says of each contact that is struck right after the end that it is.
pub(crate) fn struck_after_the_end(model: &dyn Model, solution: &Solution) -> Vec<String> {
    let contacts = model.declaration().contacts;
    let struck = solution.struck_after_the_end(model).into_iter();
    let note = |(contact, velocity): (usize, f64)| {
        let contact = &contacts[contact];
        let unit = per_second(contact.unit);
        format!(
            "the motion ends right before `{}` is struck at {:.6} {unit}; that impact is no part of it",
            contact.name, -velocity,
        )
    };
    struck.map(note).collect()
}

/// Says of each free parameter at an end of its range that it is there.
fn at_bounds(solution: &Solution) -> impl Iterator<Item = String> {
    let found = solution.parameters.iter();
    let found = found.filter(|found| found.at_bound().is_some());
    found.map(|found| format!("{found}: a wider range may hold a better value"))
}

/// Derivatives of an optimum by parameter: of the objective and the final time, null where there is none; how far each may go until other
/// conditions of the plan hold, to first order; `true`, or why there is no derivative; and those towards smaller and larger values, where
/// there is none, null by other parameters and to a side on which there is no plan of this kind.
fn gradient(gradient: &OptimumGradient) -> Object {
    let sides = || gradient.sides.iter();
    let to_sides = || {
        let objective = sides().map(|sides| Some(sides.as_ref()?.objective));
        let time = sides().map(|sides| sides.as_ref()?.final_time);
        Object::default()
            // Derivatives of the objective; null where there is none.
            .with("objective", objective.collect::<Vec<_>>())
            // Derivatives of the final time.
            .with("final_time", time.collect::<Vec<_>>())
    };
    let existences = gradient.obstacles.iter().map(existence);
    Object::default()
        // The parameters.
        .with("with_respect_to", &gradient.names)
        // Derivatives of the objective; null where there is none.
        .with("objective", &gradient.objective)
        // Derivatives of the final time.
        .with("final_time", &gradient.final_time)
        // How far each may go until other conditions of the plan hold, to first order.
        .with("range", &gradient.ranges)
        // By parameter: `true`, or why there is no derivative.
        .with("exists", existences.collect::<Vec<_>>())
        // Derivatives towards smaller and larger values, where there is none; null by other parameters.
        .some("sides", sides().any(Option::is_some).then(to_sides))
}

/// What a solve took, counted.
fn counts(solution: &Solution) -> Object {
    let counts = &solution.counts;
    let all = counts.global_iterations + counts.iterations;
    Object::default()
        // Iterations of the interior point method in all phases.
        .with("interior_point", all)
        // None: phases fix the contact sequence instead of crossing over from a relaxed point.
        .with("crossover", 0)
        // None: there are no steps.
        .with("newton", 0)
        // Factorizations.
        .with("factorizations", counts.factorizations)
        // Programs that were solved.
        .with("programs", counts.programs)
        // The share of `interior_point` that looked for which contacts happen.
        .with("contact_implicit", counts.global_iterations)
        // Changes of the contact sequence that improved the objective.
        .with("repairs", counts.repairs)
}

/// The document of one solution of `chosen` that ended as `ending` tells: that of the re-simulated motion, with at most `rows` rows of its
/// trajectory, and what belongs to the plan.
pub(crate) fn solution_document(
    chosen: &ChosenScene,
    method: &SolverSettings,
    solution: &Solution,
    ending: &Ending,
    rows: usize,
) -> Object {
    let motion = Motion::new(chosen, solution.motion.as_ref(), rows);
    let mut free = Object::default();
    for known in &solution.parameters {
        let value = (known.value, known.unit);
        free = free.with(
            known.name,
            found(value, None, known.range, known.at_bound()),
        );
    }
    let free = Some(free).filter(|_| !solution.parameters.is_empty());
    let objective = Some(solution.resimulated_objective).filter(|cost| cost.is_finite());
    let begin = begun(chosen)
        // Free parameters that were found, by name.
        .some("free", free)
        // Length of the motion \[s\].
        .with("horizon", solution.horizon)
        // The method and its settings.
        .with("method", method);
    let document = motion
        .told(begin, ending, ending.diagnosis.as_deref())
        // What was to be least.
        .with("objective", solution.objective)
        // The certificate: `S`, `B` or `none`.
        .with("stationarity", solution.stationarity.name())
        // Largest difference of a final coordinate between plan and re-simulation.
        .with("resimulation_error", solution.resimulation_error)
        // Objective of the re-simulated motion.
        .some("resimulated_objective", objective)
        // The least objective of an order of contacts that reaches the goals off the grid; null where none does.
        .with("bound", solution.bound)
        // Orders of contacts that were tried off the grid, and those that are undecided, as their programs have no solution.
        .with("words", solution.words)
        // Motions from which the best order of contacts was solved.
        .with("starts", solution.starts)
        // Controls: a row an interval, or a row a node where they are linear.
        .with("controls", &solution.controls)
        // When each interval begins and the last one ends \[s\].
        .with("control_times", &solution.control_times)
        // Derivatives of the optimum. Only where they were asked for.
        .some("gradient", solution.gradient.as_ref().map(gradient))
        // How well the equations of the steps hold.
        .with("residuals", solution.residuals)
        // Size of the largest system or program.
        .with("size", solution.size)
        // What the run took, counted.
        .with("iterations", counts(solution))
        // CPU time \[s\].
        .with("seconds", solution.seconds)
        // The complementarity problem of `--formulation time-freezing`.
        .some("time_freezing", solution.time_freezing.as_ref())
        // The distinct local optima, best first.
        .with("optima", &solution.optima)
        // Motions that were confirmed and better than all before, in the order in which they were found.
        .with("improvements", &solution.improvements)
        // Violations between the places where conditions are imposed.
        .with("excess", &solution.excess)
        // Distances that the method keeps though the scene does not ask for them.
        .with("margins", &solution.margins);
    let notes = solution
        .motion
        .iter()
        .flat_map(|motion| motion.notes.iter().cloned());
    let notes = notes.chain(method.finer(solution));
    let struck = struck_after_the_end(chosen.model.as_ref(), solution);
    motion.ended(document, notes.chain(struck), at_bounds(solution))
}
