//! One estimation: the parameters by which the motions of a scene are most like measured ones.

use hangtime::Observer;
use hangtime::estimation::{self, Estimate, Measurements, Settings};
use std::path::Path;

use crate::arguments::{ControlsName, GridName, SolveArguments, SolveFormulation};
use crate::ending::Ending;
use crate::failure::BadInput;
use crate::json::estimate_document;
use crate::measured;
use crate::settings::ChosenScene;
use crate::table::seconds;

/// A scene whose parameters are to be estimated.
pub(crate) struct FitTask {
    /// The scene with its settings.
    pub(crate) chosen: ChosenScene,
    measurements: Vec<Measurements>,
    settings: Settings,
    pub(crate) rows: usize,
}

impl FitTask {
    /// Refuses arguments that do not fit the scene, and reads the measurements.
    pub(crate) fn new(chosen: ChosenScene, arguments: &SolveArguments) -> Result<Self, BadInput> {
        refuse_others(arguments)?;
        let mut settings = Settings::default();
        settings.starts = arguments.starts;
        settings.given_parameters.clone_from(&chosen.given);
        let folder = Path::new(chosen.scene.folder);
        let experiments = chosen.model.structure().experiments.iter();
        let controls = chosen.model.declaration().controls;
        let measurements =
            experiments.map(|experiment| measured::read(folder, experiment, controls));
        Ok(Self {
            measurements: measurements.collect::<Result<_, _>>()?,
            chosen,
            settings,
            rows: arguments.result.rows(),
        })
    }

    /// The estimate; the scene has its values from there on, and the start of the first experiment.
    pub(crate) fn run(&mut self, observer: &mut Observer<'_>) -> Result<Estimate, BadInput> {
        let model = self.chosen.model.as_ref();
        let estimate = estimation::estimate(model, &self.measurements, &self.settings, observer)
            .map_err(|error| self.chosen.refuse(&error))?;
        for found in &estimate.parameters {
            self.chosen.model.set_parameter(found.index, found.value);
        }
        Ok(estimate)
    }

    /// The JSON document of an estimate that ended as `ending` tells.
    pub(crate) fn json(&self, estimate: &Estimate, ending: &Ending) -> String {
        estimate_document(&self.chosen, estimate, ending, self.rows).text()
    }
}

/// Refuses what belongs to a plan.
fn refuse_others(arguments: &SolveArguments) -> Result<(), BadInput> {
    let given = [
        ("--gradient", !arguments.gradient.is_empty()),
        ("--horizon", arguments.horizon.is_some()),
        ("--intervals", arguments.intervals.is_some()),
        ("--grid", arguments.grid != GridName::default()),
        ("--controls", arguments.controls != ControlsName::default()),
        (
            "--formulation",
            arguments.formulation != SolveFormulation::default(),
        ),
        ("--scheme", arguments.scheme.is_some()),
        ("--stages", arguments.stages.is_some()),
        ("--elements", arguments.elements.is_some()),
    ];
    match given.iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(BadInput::new(format!(
            "{option} has no meaning for a scene that compares with measurements, which has no controls to plan; leave it out"
        ))),
        None => Ok(()),
    }
}

/// What a page tells about an estimate.
pub(crate) fn facts(estimate: &Estimate, ending: &Ending) -> Vec<[String; 2]> {
    let mut facts = vec![
        ("method".to_owned(), METHOD.to_owned()),
        ("status".to_owned(), ending.status.to_owned()),
    ];
    for known in &estimate.parameters {
        let value = match known.deviation {
            Some(deviation) => format!("{:.10} +- {deviation:.2e} {}", known.value, known.unit),
            None => format!("{:.10} {}", known.value, known.unit),
        };
        facts.push((known.name.to_owned(), value.trim_end().to_owned()));
    }
    facts.push((
        "misfit".to_owned(),
        format!(
            "{:.6} of {} measurements",
            estimate.misfit, estimate.measurements
        ),
    ));
    facts.push(("CPU time".to_owned(), seconds(estimate.seconds)));
    facts
        .into_iter()
        .map(|(name, value)| [name, value])
        .collect()
}

/// What the method is called.
pub(crate) const METHOD: &str =
    "least squares (Levenberg, Marquardt) within ranges, exact derivatives through events";
