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
use crate::settings::ChosenScene;

/// The parameters that were found, by name.
struct FoundEntries<'a>(&'a [EstimatedParameter]);

#[derive(Serialize)]
struct FoundEntry {
    value: f64,
    unit: &'static str,
    /// Null where the measurements do not determine it, and at a bound.
    deviation: Option<f64>,
    range: (f64, f64),
    at_bound: Option<&'static str>,
    /// Of the misfit by it.
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
    parameters: Vec<&'static str>,
    covariance: &'a [Vec<f64>],
    correlation: Vec<Vec<f64>>,
}

/// A direction in which nothing is determined.
#[derive(Serialize)]
struct DirectionEntry<'a> {
    text: &'a str,
    parameters: Vec<&'static str>,
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
    name: &'static str,
    file: &'static str,
    time: &'a [f64],
    quantities: Vec<MeasuredEntry>,
    events: Vec<EventEntry<'a>>,
}

#[derive(Serialize)]
struct MeasuredEntry {
    name: &'static str,
    unit: &'static str,
    within: f64,
    /// Null where nothing was measured.
    measured: Vec<f64>,
    computed: Vec<f64>,
    /// In standard deviations.
    residuals: Vec<f64>,
}

impl<'a> ExperimentEntry<'a> {
    fn new(fitted: &'a FittedExperiment, declaration: &'a Declaration) -> Self {
        let column = |rows: &[Vec<f64>], k: usize| rows.iter().map(|row| row[k]).collect();
        let quantities = fitted.declared.quantities.iter().enumerate();
        Self {
            name: fitted.declared.name,
            file: fitted.declared.file,
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

/// Where searches ended.
#[derive(Serialize)]
struct LocalEntry<'a> {
    objective: f64,
    values: &'a [f64],
    optimal: bool,
    starts: usize,
}

impl<'a> LocalEntry<'a> {
    fn new(local: &'a LocalFit) -> Self {
        Self {
            objective: local.misfit,
            values: &local.values,
            optimal: local.optimal,
            starts: local.starts,
        }
    }
}

#[derive(Serialize)]
struct EstimateCounts {
    steps: usize,
    simulations: usize,
}

#[derive(Serialize)]
struct TotalSeconds {
    total: f64,
}

/// The document of an estimation: the motion of its first experiment, and what belongs to the estimate; its fields are those of
/// the contract, in their order.
// Many fields: the names of the JSON contract.
#[derive(Serialize)]
pub(crate) struct EstimateDocument<'a> {
    schema: u32,
    scene: &'static str,
    parameters: ParameterValues<'a>,
    free: FoundEntries<'a>,
    horizon: Option<f64>,
    status: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    diagnosis: Option<&'a str>,
    events: Vec<EventEntry<'a>>,
    trajectory: TrajectoryEntry<'a>,
    #[serde(rename = "final")]
    last: Option<FinalEntry<'a>>,
    objective: f64,
    measurements: usize,
    spread: f64,
    distance: f64,
    knowledge: MatricesEntry<'a>,
    undetermined: Vec<DirectionEntry<'a>>,
    experiments: Vec<ExperimentEntry<'a>>,
    starts: usize,
    optima: Vec<LocalEntry<'a>>,
    iterations: EstimateCounts,
    seconds: TotalSeconds,
    notes: Vec<String>,
    quantities: QuantitiesEntry,
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
            optima: estimate.optima.iter().map(LocalEntry::new).collect(),
            iterations: EstimateCounts {
                steps: estimate.steps,
                simulations: estimate.simulations,
            },
            seconds: TotalSeconds {
                total: estimate.seconds,
            },
            notes: estimate.notes.iter().cloned().chain(note).collect(),
            quantities: QuantitiesEntry::of(chosen.model.as_ref()),
        }
    }

    /// The document as one line of text.
    pub(crate) fn text(&self) -> String {
        to_line(self)
    }
}
