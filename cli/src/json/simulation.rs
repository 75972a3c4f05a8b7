//! The JSON document of a simulation.

use hangtime::derivative::Gradient;
use hangtime::model::Model;
use hangtime::simulation::{Counts, ProblemSize, Residuals, Seconds, Simulation};
use serde::Serialize;

use super::columns::kept_instants;
use super::gradient::GradientEntry;
use super::joints::JointsEntry;
use super::parts::{
    DiagnosisEntry, EventEntry, FinalEntry, InitialEntry, ParameterValues, QuantitiesEntry, SCHEMA,
    TrajectoryEntry, to_line,
};
use crate::ending::Ending;
use crate::method::MethodSettings;
use crate::scene_file::warned;
use crate::settings::ChosenScene;

/// The document; its fields are those of the contract, in their order.
// Many fields: the names of the JSON contract.
#[derive(Serialize)]
pub(crate) struct Document<'a> {
    /// Version of the layout of the document.
    schema: u32,
    /// Name of the scene.
    scene: &'static str,
    /// Values of the parameters in their declared units, by name, and the choice of the form of the scene.
    parameters: ParameterValues<'a>,
    /// Length of the motion \[s\].
    horizon: f64,
    /// The method and its settings.
    method: MethodSettings,
    /// How the run ended.
    status: &'static str,
    /// Where and why it ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    diagnosis: Option<DiagnosisEntry<'a>>,
    /// What happened, in the order of time.
    events: Vec<EventEntry<'a>>,
    /// The instants of the motion, at most as many as `--rows` allows.
    trajectory: TrajectoryEntry,
    /// The last of them.
    #[serde(rename = "final")]
    last: Option<FinalEntry>,
    /// Estimated largest error, relative to the largest values of each unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    error_estimate: Option<f64>,
    /// Whether every function whose zeros are events was bounded between the places that were looked at; otherwise the names of those that
    /// were interpolated there. Only for methods that locate events.
    #[serde(skip_serializing_if = "Option::is_none")]
    enclosed: Option<EnclosedEntry<'a>>,
    /// How well the equations of the steps hold.
    residuals: Residuals,
    /// Size of the largest system or program.
    size: ProblemSize,
    /// What the run took, counted.
    iterations: Counts,
    /// CPU time \[s\].
    seconds: Seconds,
    /// What one might want to know about this run, in sentences.
    notes: Vec<String>,
    /// Name and unit of every column of the trajectory.
    quantities: QuantitiesEntry,
    /// What contacts do from the start on.
    initially: Vec<InitialEntry>,
    /// Only for scenes with joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    joints: Option<JointsEntry>,
    /// Only where it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    gradient: Option<GradientEntry<'a>>,
}

/// Whether events were enclosed.
#[derive(Serialize)]
#[serde(untagged)]
enum EnclosedEntry<'a> {
    All(bool),
    But(&'a [String]),
}

impl<'a> EnclosedEntry<'a> {
    fn new(interpolated: &'a [String]) -> Self {
        if interpolated.is_empty() {
            Self::All(true)
        } else {
            Self::But(interpolated)
        }
    }
}

impl<'a> Document<'a> {
    /// The document of one simulation of `chosen` over `horizon`, with at most `rows` rows of its trajectory.
    pub(crate) fn new(
        chosen: &'a ChosenScene,
        horizon: f64,
        method: &'a MethodSettings,
        simulation: &'a Simulation,
        ending: &'a Ending,
        rows: usize,
    ) -> Self {
        let declaration = chosen.model.declaration();
        let contacts = declaration.contacts;
        let trajectory = TrajectoryEntry::new(chosen.model.as_ref(), &simulation.trajectory, rows);
        let notes = simulation.notes.iter().cloned();
        let notes = notes.chain(trajectory.note(&simulation.trajectory));
        let notes = notes.chain(warned(chosen.scene));
        Self {
            schema: SCHEMA,
            scene: chosen.scene.name,
            parameters: ParameterValues::of(chosen),
            horizon,
            method: method.with_steps_of(simulation),
            status: ending.status,
            diagnosis: simulation
                .status
                .diagnosis()
                .map(|diagnosis| DiagnosisEntry::new(diagnosis, ending, contacts)),
            initially: InitialEntry::all(simulation),
            events: EventEntry::all(&simulation.events, declaration),
            last: trajectory.last(),
            trajectory,
            error_estimate: simulation.error_estimate,
            enclosed: simulation.interpolated.as_deref().map(EnclosedEntry::new),
            residuals: simulation.residuals,
            size: simulation.size,
            iterations: simulation.counts,
            seconds: simulation.seconds,
            notes: notes.collect(),
            quantities: QuantitiesEntry::of(chosen.model.as_ref()),
            joints: JointsEntry::of(chosen.model.as_ref(), &simulation.trajectory, rows),
            gradient: None,
        }
    }

    /// The document with derivatives, those of outputs in the rows of the trajectory.
    pub(crate) fn with_gradient(
        self,
        model: &'a dyn Model,
        simulation: &Simulation,
        gradient: Option<&'a Gradient>,
        rows: usize,
    ) -> Self {
        let kept = || kept_instants(&simulation.trajectory, rows);
        Self {
            gradient: gradient.map(|gradient| GradientEntry::new(model, gradient, &kept())),
            ..self
        }
    }

    /// The document as one line of text.
    pub(crate) fn text(&self) -> String {
        to_line(self)
    }
}

#[cfg(test)]
mod tests {
    use hangtime::simulation::{Diagnosis, Simulation, SimulationStatus, Trajectory};

    use super::Document;
    use crate::ending::Ending;
    use crate::method::MethodSettings;
    use crate::settings::{ChosenScene, find};

    /// The document of a run of three instants, as text.
    fn document(status: SimulationStatus, speeds: [f64; 3], forces: [f64; 3]) -> String {
        let chosen = ChosenScene::new(find(crate::testing::SCENES, "slide").unwrap(), &[]).unwrap();
        let mut trajectory = Trajectory::default();
        trajectory.time = vec![0.0, 0.5, 1.0];
        trajectory.numerical_time = trajectory.time.clone();
        trajectory.q = vec![vec![1.0, 0.1], vec![2.0, 0.2], vec![3.0, 0.3]];
        trajectory.v = speeds.map(|speed| vec![speed, 0.0]).into();
        trajectory.u = vec![Vec::new(); 3];
        trajectory.contact_force = forces.map(|force| vec![force, 0.0]).into();
        let simulation = Simulation {
            declaration: chosen.model.declaration(),
            initial_modes: Vec::new(),
            status,
            events: Vec::new(),
            trajectory,
            error_estimate: None,
            residuals: hangtime::simulation::Residuals {
                primal: f64::NAN,
                ..Default::default()
            },
            size: Default::default(),
            counts: Default::default(),
            seconds: Default::default(),
            interpolated: None,
            notes: Vec::new(),
        };
        let settings = MethodSettings::default();
        let ending = Ending::of_whole(&simulation);
        Document::new(&chosen, 5.0, &settings, &simulation, &ending, 100).text()
    }

    #[test]
    fn document_of_a_run_with_an_infinite_force_is_whole() {
        let forces = [f64::NAN, f64::INFINITY, 3.0];
        let text = document(SimulationStatus::Solved, [0.0; 3], forces);
        let document: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(document["trajectory"]["time"][2], 1.0);
        assert_eq!(document["final"]["time"], 1.0);
        let rows = document["trajectory"]["contact_force"].to_string();
        assert_eq!(rows, "[[null,0.0],[null,0.0],[3.0,0.0]]");
    }

    #[test]
    fn document_of_a_run_that_became_infinite_ends_before_the_first_infinite_row() {
        let status = SimulationStatus::NotFinite(Diagnosis {
            time: 1.0,
            step: 2,
            contact: Some(1),
            message: "velocity is infinite".into(),
        });
        let text = document(status, [0.0, 1e300, f64::INFINITY], [0.0; 3]);
        let document: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(document["status"], "not_finite");
        assert_eq!(document["diagnosis"]["contact"], "slope");
        assert_eq!(document["trajectory"]["time"].as_array().unwrap().len(), 2);
        assert_eq!(document["final"]["q"], serde_json::json!([2.0, 0.2]));
        assert!(document["residuals"]["primal"].is_null());
        assert!(text.contains("1e+300") && text.contains("0.1"), "{text}");
    }
}
