//! The JSON document of an estimation.

use hangtime::estimation::{Direction, Estimate, EstimatedParameter, FittedExperiment, LocalFit};
use hangtime::model::Declaration;
use hangtime::simulation::Simulation;
use serde::{Serialize, Serializer};

use super::parts::{
    EventEntry, FinalEntry, InitialEntry, ParameterValues, QuantitiesEntry, SCHEMA,
    TrajectoryEntry, to_line,
};
use crate::ending::Ending;
use crate::scene_file::warned;
use crate::settings::ChosenScene;

/// The parameters that were found, by name.
struct FoundEntries<'a>(&'a [EstimatedParameter]);

/// A parameter that was found.
#[derive(Serialize)]
struct FoundEntry {
    /// The value that was found.
    value: f64,
    /// Its unit.
    unit: &'static str,
    /// Its standard deviation. Null where the measurements do not determine it, and at a bound.
    deviation: Option<f64>,
    /// The range in which it was looked for.
    range: (f64, f64),
    /// The end of the range at which it is, `lower` or `upper`; null within it.
    at_bound: Option<&'static str>,
    /// Derivative of the misfit by it.
    gradient: f64,
}

impl Serialize for FoundEntries<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let entry = |found: &EstimatedParameter| FoundEntry {
            value: found.value,
            unit: found.unit,
            deviation: found.deviation,
            range: found.range,
            at_bound: found
                .at_bound
                .then_some(match found.value <= found.range.0 {
                    true => "lower",
                    false => "upper",
                }),
            gradient: found.gradient,
        };
        serializer.collect_map(self.0.iter().map(|found| (found.name, entry(found))))
    }
}

/// Two symmetric matrices over the parameters.
#[derive(Serialize)]
struct MatricesEntry<'a> {
    /// Names of rows and columns.
    parameters: Vec<&'static str>,
    /// Covariance.
    covariance: &'a [Vec<f64>],
    /// Correlation.
    correlation: Vec<Vec<f64>>,
}

/// A direction in which nothing is determined.
#[derive(Serialize)]
struct DirectionEntry<'a> {
    /// The direction in words.
    text: &'a str,
    /// The parameters that change along it.
    parameters: Vec<&'static str>,
    /// By how much.
    changes: Vec<f64>,
}

impl<'a> DirectionEntry<'a> {
    fn new(direction: &'a Direction, parameters: &[EstimatedParameter]) -> Self {
        let changes = direction.changes.iter();
        Self {
            text: &direction.text,
            parameters: changes.clone().map(|&(j, _)| parameters[j].name).collect(),
            changes: changes.map(|&(_, change)| change).collect(),
        }
    }
}

/// One experiment beside its motion.
#[derive(Serialize)]
struct ExperimentEntry<'a> {
    /// Name of the experiment.
    name: &'static str,
    /// File of its measurements. Null where the scene has them itself.
    file: Option<&'static str>,
    /// When something was measured \[s\].
    time: &'a [f64],
    /// What was measured.
    quantities: Vec<MeasuredEntry>,
    /// What happens in the motion that was found.
    events: Vec<EventEntry<'a>>,
}

/// A measured quantity.
#[derive(Serialize)]
struct MeasuredEntry {
    /// What was measured.
    name: &'static str,
    /// Its unit.
    unit: &'static str,
    /// Standard deviation of a measurement.
    within: f64,
    /// Measured values. Null where nothing was measured.
    measured: Vec<f64>,
    /// Values of the motion that was found.
    computed: Vec<f64>,
    /// Their difference, in standard deviations.
    residuals: Vec<f64>,
}

impl<'a> ExperimentEntry<'a> {
    fn new(fitted: &'a FittedExperiment, declaration: &'a Declaration) -> Self {
        let column = |rows: &[Vec<f64>], k: usize| rows.iter().map(|row| row[k]).collect();
        let quantities = fitted.declared.quantities.iter().enumerate();
        Self {
            name: fitted.declared.name,
            file: match fitted.declared.table() {
                Some(_) => None,
                None => Some(fitted.declared.file),
            },
            time: &fitted.times,
            quantities: quantities
                .map(|(k, quantity)| MeasuredEntry {
                    name: quantity.name,
                    unit: quantity.unit,
                    within: quantity.within,
                    measured: column(&fitted.measured, k),
                    computed: column(&fitted.computed, k),
                    residuals: fitted.residuals(k),
                })
                .collect(),
            events: EventEntry::all(&fitted.motion.events, declaration),
        }
    }
}

/// Counts.
#[derive(Serialize)]
struct EstimateCounts {
    /// Steps of Levenberg and Marquardt.
    steps: usize,
    /// Simulations.
    simulations: usize,
}

/// CPU times \[s\].
#[derive(Serialize)]
struct TotalSeconds {
    /// All.
    total: f64,
}

/// The document of an estimation: the motion of its first experiment, and what belongs to the estimate; its fields are those of
/// the contract, in their order.
// Many fields: the names of the JSON contract.
#[derive(Serialize)]
pub(crate) struct EstimateDocument<'a> {
    /// Version of the layout of the document.
    schema: u32,
    /// Name of the scene.
    scene: &'static str,
    /// Values of the parameters in their declared units, by name, and the choice of the form of the scene.
    parameters: ParameterValues<'a>,
    /// The parameters that were found, by name.
    free: FoundEntries<'a>,
    /// Length of the motion \[s\].
    horizon: Option<f64>,
    /// How the run ended.
    status: &'static str,
    /// Where and why it ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    diagnosis: Option<&'a str>,
    /// What happened, in the order of time.
    events: Vec<EventEntry<'a>>,
    /// The instants of the motion, at most as many as `--rows` allows.
    trajectory: TrajectoryEntry,
    /// The last of them.
    #[serde(rename = "final")]
    last: Option<FinalEntry>,
    /// The misfit.
    objective: f64,
    /// How many numbers were measured.
    measurements: usize,
    /// Root mean square of the residuals with the degrees of freedom that are left: about 1 where deviations are declared as they are.
    spread: f64,
    /// Distance from the optimum of the linear problem there, in standard deviations of what was found.
    distance: f64,
    /// What the measurements tell of the parameters.
    knowledge: MatricesEntry<'a>,
    /// Directions in which they tell nothing.
    undetermined: Vec<DirectionEntry<'a>>,
    /// Measurements beside the motion that was found.
    experiments: Vec<ExperimentEntry<'a>>,
    /// From how many values it was looked for.
    starts: usize,
    /// Where the searches ended, best first.
    optima: &'a [LocalFit],
    /// What the run took, counted.
    iterations: EstimateCounts,
    /// CPU time \[s\].
    seconds: TotalSeconds,
    /// What one might want to know about this run, in sentences.
    notes: Vec<String>,
    /// Name and unit of every column of the trajectory.
    quantities: QuantitiesEntry,
    /// What contacts do from the start on.
    initially: Vec<InitialEntry>,
}

impl<'a> EstimateDocument<'a> {
    /// The document of an estimate of `chosen` that ended as `ending` tells, with at most `rows` rows of its trajectory.
    pub(crate) fn new(
        chosen: &'a ChosenScene,
        estimate: &'a Estimate,
        ending: &'a Ending,
        rows: usize,
    ) -> Self {
        let declaration = chosen.model.declaration();
        let motion: Option<&Simulation> = estimate.experiments.first().map(|known| &known.motion);
        let trajectory = motion.map_or_else(TrajectoryEntry::default, |motion| {
            TrajectoryEntry::new(chosen.model.as_ref(), &motion.trajectory, rows)
        });
        let note = motion.and_then(|motion| trajectory.note(&motion.trajectory));
        let events = motion.map_or(&[][..], |motion| &motion.events);
        let found = &estimate.parameters;
        let count = 0..found.len();
        Self {
            schema: SCHEMA,
            scene: chosen.scene.name,
            parameters: ParameterValues::of(chosen),
            free: FoundEntries(found),
            horizon: motion.and_then(|motion| motion.trajectory.time.last().copied()),
            status: ending.status,
            diagnosis: ending.diagnosis.as_deref(),
            initially: motion.map_or_else(Vec::new, InitialEntry::all),
            events: EventEntry::all(events, declaration),
            last: trajectory.last(),
            trajectory,
            objective: estimate.misfit,
            measurements: estimate.measurements,
            spread: estimate.spread(),
            distance: estimate.distance,
            knowledge: MatricesEntry {
                parameters: found.iter().map(|known| known.name).collect(),
                covariance: &estimate.covariance,
                correlation: count
                    .clone()
                    .map(|i| count.clone().map(|j| estimate.correlation(i, j)).collect())
                    .collect(),
            },
            undetermined: estimate
                .undetermined
                .iter()
                .map(|direction| DirectionEntry::new(direction, found))
                .collect(),
            experiments: estimate
                .experiments
                .iter()
                .map(|fitted| ExperimentEntry::new(fitted, declaration))
                .collect(),
            starts: estimate.starts,
            optima: &estimate.optima,
            iterations: EstimateCounts {
                steps: estimate.steps,
                simulations: estimate.simulations,
            },
            seconds: TotalSeconds {
                total: estimate.seconds,
            },
            notes: (estimate.notes.iter().cloned())
                .chain(note)
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
