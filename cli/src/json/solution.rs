//! The JSON document of an optimal control problem.

use hangtime::model::Model;
use hangtime::ocp::{
    ControlNodes, Excess, Formulation, FoundParameter, Improvement, Margin, Optimum,
    OptimumGradient, RelaxedReport, Settings, Solution, TimeFreezingReport,
};
use hangtime::rk::Scheme;
use hangtime::simulation::{ProblemSize, Residuals, Seconds};
use serde::{Serialize, Serializer};

use super::gradient::{Existence, RangeEntry};
use super::parts::{
    EventEntry, FinalEntry, InitialEntry, ParameterValues, QuantitiesEntry, SCHEMA,
    TrajectoryEntry, to_line,
};
use crate::ending::Ending;
use crate::scene_file::warned;
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
    /// Whether intervals are divided among phases.
    #[serde(skip)]
    aligned: bool,
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
            aligned: settings.grid == ControlNodes::Aligned,
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

/// The complementarity problem of the time-freezing formulation.
#[derive(Serialize)]
struct TimeFreezingEntry {
    /// How its exact solution ended.
    status: String,
    /// Its objective, with the step equilibration.
    objective: f64,
    /// Length of its motion \[s\].
    horizon: f64,
    /// How well its equations hold.
    residuals: TimeFreezingResiduals,
    /// What of the scene it leaves out, and the motion does not.
    left_out: Vec<&'static str>,
    /// Its relaxed solution.
    relaxed: RelaxedReport,
    /// Its size.
    size: ProblemSize,
    /// Iterations of its exact solution.
    iterations: usize,
    /// CPU time \[s\].
    seconds: f64,
}

/// Its residuals.
#[derive(Serialize)]
struct TimeFreezingResiduals {
    /// Largest violation, scaled.
    primal: f64,
    /// Largest product of a pair.
    complementarity: f64,
}

impl TimeFreezingEntry {
    fn new(report: &TimeFreezingReport) -> Self {
        Self {
            status: report.status.to_string(),
            objective: report.objective,
            horizon: report.horizon,
            residuals: TimeFreezingResiduals {
                primal: report.residuals.primal,
                complementarity: report.residuals.complementarity,
            },
            left_out: report.left_out.clone(),
            relaxed: report.relaxed,
            size: report.size,
            iterations: report.iterations,
            seconds: report.seconds,
        }
    }
}

/// The free parameters that were found, by name.
struct FoundEntries<'a>(&'a [FoundParameter]);

/// A free parameter that was found.
#[derive(Serialize)]
struct FoundEntry {
    /// The value that was found.
    value: f64,
    /// Its unit.
    unit: &'static str,
    /// The range in which it was looked for.
    range: (f64, f64),
    /// The end of the range at which it is, `lower` or `upper`; null within it.
    at_bound: Option<&'static str>,
}

impl FoundEntries<'_> {
    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Serialize for FoundEntries<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let entry = |found: &FoundParameter| FoundEntry {
            value: found.value,
            unit: found.unit,
            range: found.range,
            at_bound: found.at_bound(),
        };
        serializer.collect_map(self.0.iter().map(|found| (found.name, entry(found))))
    }
}

/// Says of each free parameter at an end of its range that it is there.
fn at_bounds(solution: &Solution) -> impl Iterator<Item = String> {
    let found = solution.parameters.iter();
    let found = found.filter(|found| found.at_bound().is_some());
    found.map(|found| format!("{found}: a wider range may hold a better value"))
}

/// Derivatives of an optimum.
#[derive(Serialize)]
struct OptimumGradientEntry<'a> {
    /// The parameters.
    with_respect_to: &'a [&'static str],
    /// Derivatives of the objective; null where there is none.
    objective: &'a [f64],
    /// Derivatives of the final time.
    final_time: &'a [Option<f64>],
    /// How far each may go until other conditions of the plan hold, to first order.
    range: Vec<RangeEntry<'a>>,
    /// By parameter: `true`, or why there is no derivative.
    exists: Vec<Existence<'a>>,
    /// Derivatives towards smaller and larger values, where there is none; null by other parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    sides: Option<SidesEntry>,
}

/// Derivatives to both sides, by parameter.
#[derive(Serialize)]
struct SidesEntry {
    /// Of the objective; null to a side on which there is no plan of this kind.
    objective: Vec<Option<[f64; 2]>>,
    /// Of the final time, where the objective depends on that alone.
    final_time: Vec<Option<[f64; 2]>>,
}

impl<'a> OptimumGradientEntry<'a> {
    fn new(gradient: &'a OptimumGradient) -> Self {
        let sides = || gradient.sides.iter();
        Self {
            with_respect_to: &gradient.names,
            objective: &gradient.objective,
            final_time: &gradient.final_time,
            range: gradient.ranges.iter().map(RangeEntry::new).collect(),
            exists: gradient.obstacles.iter().map(Existence::of).collect(),
            sides: sides().any(Option::is_some).then(|| SidesEntry {
                objective: sides()
                    .map(|sides| Some(sides.as_ref()?.objective))
                    .collect(),
                final_time: sides().map(|sides| sides.as_ref()?.final_time).collect(),
            }),
        }
    }
}

/// The document of an optimal control problem: that of the re-simulated motion, and what belongs to the plan; its
/// fields are those of the contract, in their order.
// Many fields: the names of the JSON contract.
#[derive(Serialize)]
pub(crate) struct SolutionDocument<'a> {
    /// Version of the layout of the document.
    schema: u32,
    /// Name of the scene.
    scene: &'static str,
    /// Values of the parameters in their declared units, by name, and the choice of the form of the scene.
    parameters: ParameterValues<'a>,
    /// Free parameters that were found, by name.
    #[serde(skip_serializing_if = "FoundEntries::is_empty")]
    free: FoundEntries<'a>,
    /// Length of the motion \[s\].
    horizon: f64,
    /// The method and its settings.
    method: &'a SolverSettings,
    /// How the run ended.
    status: &'static str,
    /// Why it ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    diagnosis: Option<&'a str>,
    /// What happened, in the order of time.
    events: Vec<EventEntry<'a>>,
    /// The instants of the motion, at most as many as `--rows` allows.
    trajectory: TrajectoryEntry,
    /// The last of them.
    #[serde(rename = "final")]
    last: Option<FinalEntry>,
    /// What was to be least.
    objective: f64,
    /// The certificate: `S`, `B` or `none`.
    stationarity: &'static str,
    /// Largest difference of a final coordinate between plan and re-simulation.
    resimulation_error: f64,
    /// Objective of the re-simulated motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    resimulated_objective: Option<f64>,
    /// Starts on grids.
    starts: usize,
    /// Controls: a row an interval, or a row a node where they are linear.
    controls: &'a [Vec<f64>],
    /// When they change \[s\]. Only where they are not of equal length.
    #[serde(skip_serializing_if = "Option::is_none")]
    control_times: Option<&'a [f64]>,
    /// Derivatives of the optimum. Only where they were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    gradient: Option<OptimumGradientEntry<'a>>,
    /// How well the equations of the steps hold.
    residuals: Residuals,
    /// Size of the largest system or program.
    size: ProblemSize,
    /// What the run took, counted.
    iterations: SolutionCounts,
    /// CPU time \[s\].
    seconds: Seconds,
    /// The complementarity problem of `--formulation time-freezing`.
    #[serde(skip_serializing_if = "Option::is_none")]
    time_freezing: Option<TimeFreezingEntry>,
    /// The distinct local optima, best first.
    optima: &'a [Optimum],
    /// Motions that were confirmed and better than all before, in the order in which they were found.
    improvements: &'a [Improvement],
    /// Violations between the places where conditions are imposed.
    excess: &'a [Excess],
    /// Distances that the method keeps though the scene does not ask for them.
    margins: &'a [Margin],
    /// What one might want to know about this run, in sentences.
    notes: Vec<String>,
    /// Name and unit of every column of the trajectory.
    quantities: QuantitiesEntry,
    /// What contacts do from the start on.
    initially: Vec<InitialEntry>,
}

/// Counts.
#[derive(Serialize)]
struct SolutionCounts {
    /// Iterations of the interior point method in all phases.
    interior_point: usize,
    /// None: phases fix the contact sequence instead of crossing over from a relaxed point.
    crossover: usize,
    /// None: there are no steps.
    newton: usize,
    /// Factorizations.
    factorizations: usize,
    /// Programs that were solved.
    programs: usize,
    /// The share of `interior_point` in relaxed complementarity programs.
    relaxed: usize,
    /// Changes of the contact sequence that improved the objective.
    repairs: usize,
}

impl<'a> SolutionDocument<'a> {
    /// The document of one solution of `chosen` that ended as `ending` tells, with at most `rows` rows of its
    /// trajectory.
    pub(crate) fn new(
        chosen: &'a ChosenScene,
        method: &'a SolverSettings,
        solution: &'a Solution,
        ending: &'a Ending,
        rows: usize,
    ) -> Self {
        let declaration = chosen.model.declaration();
        let motion = solution.motion.as_ref();
        let trajectory = motion.map_or_else(TrajectoryEntry::default, |motion| {
            TrajectoryEntry::new(chosen.model.as_ref(), &motion.trajectory, rows)
        });
        let note = motion.and_then(|motion| trajectory.note(&motion.trajectory));
        let events = motion.map_or(&[][..], |motion| &motion.events);
        Self {
            schema: SCHEMA,
            scene: chosen.scene.name,
            parameters: ParameterValues::of(chosen),
            free: FoundEntries(&solution.parameters),
            horizon: solution.horizon,
            method,
            status: ending.status,
            diagnosis: ending.diagnosis.as_deref(),
            initially: motion.map_or_else(Vec::new, InitialEntry::all),
            events: EventEntry::all(events, declaration),
            last: trajectory.last(),
            trajectory,
            objective: solution.objective,
            stationarity: solution.stationarity.name(),
            resimulation_error: solution.resimulation_error,
            resimulated_objective: Some(solution.resimulated_objective)
                .filter(|cost| cost.is_finite()),
            starts: solution.starts,
            controls: &solution.controls,
            control_times: Some(&solution.control_times[..]).filter(|_| method.aligned),
            gradient: solution.gradient.as_ref().map(OptimumGradientEntry::new),
            residuals: solution.residuals,
            size: solution.size,
            iterations: SolutionCounts {
                interior_point: solution.counts.relaxed_iterations + solution.counts.iterations,
                crossover: 0,
                newton: 0,
                factorizations: solution.counts.factorizations,
                programs: solution.counts.programs,
                relaxed: solution.counts.relaxed_iterations,
                repairs: solution.counts.repairs,
            },
            seconds: solution.seconds,
            time_freezing: solution.time_freezing.as_ref().map(TimeFreezingEntry::new),
            optima: &solution.optima,
            improvements: &solution.improvements,
            excess: &solution.excess,
            margins: &solution.margins,
            notes: (method.finer(solution).into_iter())
                .chain(struck_after_the_end(chosen.model.as_ref(), solution))
                .chain(note)
                .chain(at_bounds(solution))
                .chain(warned(chosen.scene))
                .collect(),
            quantities: QuantitiesEntry::of(chosen.model.as_ref()),
        }
    }

    /// The document as one line of text.
    pub(crate) fn text(&self) -> String {
        to_line(self)
    }
}
