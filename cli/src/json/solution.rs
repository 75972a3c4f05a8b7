//! The JSON document of an optimal control problem.

use hangtime::model::Model;
use hangtime::ocp::{
    ControlNodes, Excess, Formulation, FoundParameter, Improvement, Margin, Optimum, Settings,
    Solution, Source, TimeFreezingReport,
};
use hangtime::rk::Scheme;
use hangtime::simulation::{ProblemSize, Residuals, Seconds};
use serde::{Serialize, Serializer};

use crate::table::counted;

use super::parts::{
    EventEntry, FinalEntry, InitialEntry, ParameterValues, QuantitiesEntry, ResidualsEntry, SCHEMA,
    SecondsEntry, SizeEntry, TrajectoryEntry, to_line,
};
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
    /// Whether intervals are divided among phases.
    #[serde(skip)]
    aligned: bool,
    /// Finite elements: of a phase, or of an interval with time-freezing.
    pub(crate) elements: usize,
    /// Starts that may be solved side by side.
    pub(crate) starts: usize,
    /// Whether words are searched before.
    #[serde(skip)]
    words: bool,
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
            words: settings.searches_words(),
            of_a_phase: settings.elements,
        }
    }

    /// Where motions were looked for: among words, and from how many starts.
    pub(crate) fn searched(&self, solution: &Solution) -> String {
        let starts = counted(solution.starts, "start");
        match (self.words, solution.starts) {
            (true, 0) => "words".to_owned(),
            (true, _) => format!("words, then {starts}"),
            (false, _) => starts,
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
    status: String,
    objective: f64,
    horizon: f64,
    residuals: TimeFreezingResiduals,
    left_out: Vec<&'static str>,
    relaxed: RelaxedEntry,
    #[serde(with = "SizeEntry")]
    size: ProblemSize,
    iterations: usize,
    seconds: f64,
}

#[derive(Serialize)]
struct TimeFreezingResiduals {
    primal: f64,
    complementarity: f64,
}

/// Its relaxed solution, before the motion was polished.
#[derive(Serialize)]
struct RelaxedEntry {
    objective: f64,
    complementarity: f64,
    iterations: usize,
    led_to_motion: bool,
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
            relaxed: RelaxedEntry {
                objective: report.relaxed.objective,
                complementarity: report.relaxed.complementarity,
                iterations: report.relaxed.iterations,
                led_to_motion: report.relaxed.led_to_motion,
            },
            size: report.size,
            iterations: report.iterations,
            seconds: report.seconds,
        }
    }
}

/// The free parameters that were found, by name.
struct FoundEntries<'a>(&'a [FoundParameter]);

#[derive(Serialize)]
struct FoundEntry {
    value: f64,
    unit: &'static str,
    range: (f64, f64),
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
    with_respect_to: &'a [&'static str],
    objective: &'a [f64],
    final_time: &'a [Option<f64>],
}

/// A violation between the places where a condition is imposed.
#[derive(Serialize)]
struct ExcessEntry<'a> {
    name: &'a str,
    amount: f64,
    unit: &'a str,
    time: f64,
}

impl<'a> ExcessEntry<'a> {
    fn new(excess: &'a Excess) -> Self {
        Self {
            name: &excess.name,
            amount: excess.amount,
            unit: &excess.unit,
            time: excess.time,
        }
    }
}

/// A distance that the method keeps, and that costs something.
#[derive(Serialize)]
struct MarginEntry<'a> {
    name: &'a str,
    amount: f64,
    unit: &'a str,
    cost: f64,
    chosen: bool,
}

impl<'a> MarginEntry<'a> {
    fn new(margin: &'a Margin) -> Self {
        Self {
            name: &margin.name,
            amount: margin.amount,
            unit: &margin.unit,
            cost: margin.cost,
            chosen: margin.chosen,
        }
    }
}

/// A distinct local optimum.
#[derive(Serialize)]
struct OptimumEntry<'a> {
    objective: f64,
    horizon: f64,
    status: &'static str,
    stationarity: &'static str,
    switches: usize,
    intervals: usize,
    starts: &'a [usize],
    sources: Vec<String>,
}

/// A motion that was confirmed and better than all before it.
#[derive(Serialize)]
struct ImprovementEntry {
    cpu: f64,
    objective: f64,
    status: &'static str,
    source: String,
}

impl ImprovementEntry {
    fn new(improvement: &Improvement) -> Self {
        Self {
            cpu: improvement.cpu,
            objective: improvement.objective,
            status: improvement.status.name(),
            source: improvement.source.to_string(),
        }
    }
}

impl<'a> OptimumEntry<'a> {
    fn new(optimum: &'a Optimum) -> Self {
        Self {
            objective: optimum.objective,
            horizon: optimum.horizon,
            status: optimum.status.name(),
            stationarity: optimum.stationarity.name(),
            switches: optimum.switches,
            intervals: optimum.intervals,
            starts: &optimum.starts,
            sources: optimum.sources.iter().map(Source::to_string).collect(),
        }
    }
}

/// The document of an optimal control problem: that of the re-simulated motion, and what belongs to the plan; its
/// fields are those of the contract, in their order.
// Many fields: the names of the JSON contract.
#[derive(Serialize)]
pub(crate) struct SolutionDocument<'a> {
    schema: u32,
    scene: &'static str,
    parameters: ParameterValues<'a>,
    #[serde(skip_serializing_if = "FoundEntries::is_empty")]
    free: FoundEntries<'a>,
    horizon: f64,
    method: &'a SolverSettings,
    status: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    diagnosis: Option<&'a str>,
    events: Vec<EventEntry<'a>>,
    trajectory: TrajectoryEntry<'a>,
    #[serde(rename = "final")]
    last: Option<FinalEntry<'a>>,
    objective: f64,
    stationarity: &'static str,
    resimulation_error: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    resimulated_objective: Option<f64>,
    starts: usize,
    controls: &'a [Vec<f64>],
    /// Where they are not of equal length.
    #[serde(skip_serializing_if = "Option::is_none")]
    control_times: Option<&'a [f64]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gradient: Option<OptimumGradientEntry<'a>>,
    #[serde(with = "ResidualsEntry")]
    residuals: Residuals,
    #[serde(with = "SizeEntry")]
    size: ProblemSize,
    iterations: SolutionCounts,
    #[serde(with = "SecondsEntry")]
    seconds: Seconds,
    #[serde(skip_serializing_if = "Option::is_none")]
    time_freezing: Option<TimeFreezingEntry>,
    optima: Vec<OptimumEntry<'a>>,
    improvements: Vec<ImprovementEntry>,
    excess: Vec<ExcessEntry<'a>>,
    margins: Vec<MarginEntry<'a>>,
    notes: Vec<String>,
    quantities: QuantitiesEntry,
    initially: Vec<InitialEntry>,
}

#[derive(Serialize)]
struct SolutionCounts {
    /// Of all phases; `contact_implicit` is the share of the global one.
    interior_point: usize,
    /// The phases fix the contact sequence instead of crossing over from a relaxed point.
    crossover: usize,
    newton: usize,
    factorizations: usize,
    programs: usize,
    contact_implicit: usize,
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
            gradient: solution
                .gradient
                .as_ref()
                .map(|gradient| OptimumGradientEntry {
                    with_respect_to: &gradient.names,
                    objective: &gradient.objective,
                    final_time: &gradient.final_time,
                }),
            residuals: solution.residuals,
            size: solution.size,
            iterations: SolutionCounts {
                interior_point: solution.counts.global_iterations + solution.counts.iterations,
                crossover: 0,
                newton: 0,
                factorizations: solution.counts.factorizations,
                programs: solution.counts.programs,
                contact_implicit: solution.counts.global_iterations,
                repairs: solution.counts.repairs,
            },
            seconds: solution.seconds,
            time_freezing: solution.time_freezing.as_ref().map(TimeFreezingEntry::new),
            optima: solution.optima.iter().map(OptimumEntry::new).collect(),
            improvements: solution
                .improvements
                .iter()
                .map(ImprovementEntry::new)
                .collect(),
            excess: solution.excess.iter().map(ExcessEntry::new).collect(),
            margins: solution.margins.iter().map(MarginEntry::new).collect(),
            notes: (method.finer(solution).into_iter())
                .chain(struck_after_the_end(chosen.model.as_ref(), solution))
                .chain(note)
                .chain(at_bounds(solution))
                .collect(),
            quantities: QuantitiesEntry::of(chosen.model.as_ref()),
        }
    }

    /// The document as one line of text.
    pub(crate) fn text(&self) -> String {
        to_line(self)
    }
}
