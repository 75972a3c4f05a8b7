//! The JSON documents of a simulation and of a solution.
//!
//! Field names and their order are a contract. A number is written as the shortest decimal text
//! that reads back as exactly the same double (at most 17 significant digits), so nothing is lost
//! and `10.2759` stays `10.2759`. What is not finite is never written: the rows of a trajectory end
//! before the first such number, and elsewhere `null` stands in its place.

mod solution;

use hangtime::model::{ContactDeclaration, Model};
use hangtime::simulation::{
    Counts, Diagnosis, Event, ProblemSize, Residuals, Seconds, Simulation, Trajectory,
};
use serde::{Serialize, Serializer};

use crate::method::MethodSettings;
use crate::settings::ChosenScene;

pub(crate) use solution::{SolutionDocument, SolverSettings};

/// Version of the document's layout.
pub(crate) const SCHEMA: u32 = 1;

/// The document.
#[derive(Serialize)]
pub(crate) struct Document<'a> {
    schema: u32,
    scene: &'static str,
    parameters: ParameterValues<'a>,
    horizon: f64,
    method: MethodSettings,
    status: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    diagnosis: Option<DiagnosisEntry<'a>>,
    events: Vec<EventEntry<'a>>,
    trajectory: TrajectoryEntry<'a>,
    #[serde(rename = "final")]
    last: Option<FinalEntry<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error_estimate: Option<f64>,
    #[serde(with = "ResidualsEntry")]
    residuals: Residuals,
    #[serde(with = "SizeEntry")]
    size: ProblemSize,
    #[serde(with = "IterationsEntry")]
    iterations: Counts,
    #[serde(with = "SecondsEntry")]
    seconds: Seconds,
    notes: &'a [String],
}

impl<'a> Document<'a> {
    /// The document of one simulation of `chosen` over `horizon`.
    pub(crate) fn new(
        chosen: &'a ChosenScene,
        horizon: f64,
        method: &'a MethodSettings,
        simulation: &'a Simulation,
    ) -> Self {
        let contacts = chosen.model.declaration().contacts;
        let trajectory = TrajectoryEntry::new(&simulation.trajectory);
        Self {
            schema: SCHEMA,
            scene: chosen.scene.name,
            parameters: ParameterValues::of(chosen),
            horizon,
            method: method.with_steps_of(simulation),
            status: simulation.status.name(),
            diagnosis: simulation
                .status
                .diagnosis()
                .map(|diagnosis| DiagnosisEntry::new(diagnosis, contacts)),
            events: simulation
                .events
                .iter()
                .map(|event| EventEntry::new(event, contacts))
                .collect(),
            last: trajectory.last(),
            trajectory,
            error_estimate: simulation.error_estimate,
            residuals: simulation.residuals,
            size: simulation.size,
            iterations: simulation.counts,
            seconds: simulation.seconds,
            notes: &simulation.notes,
        }
    }

    /// The document as one line of text.
    pub(crate) fn text(&self) -> String {
        to_line(self)
    }
}

/// One line of JSON with its line end.
pub(crate) fn to_line(value: &impl Serialize) -> String {
    // Maps with keys that are not text and failing writers are the only errors of this writer; the
    // documents have neither.
    serde_json::to_string(value).unwrap_or_default() + "\n"
}

/// Parameter values by name, in order of declaration, then the choices of the scene's form.
pub(crate) struct ParameterValues<'a> {
    model: &'a dyn Model,
    choices: &'static [(&'static str, &'static str)],
}

impl<'a> ParameterValues<'a> {
    /// The values of a scene with its settings applied.
    pub(crate) fn of(chosen: &'a ChosenScene) -> Self {
        Self {
            model: chosen.model.as_ref(),
            choices: chosen.choices,
        }
    }
}

impl Serialize for ParameterValues<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeMap as _;
        let mut map = serializer.serialize_map(None)?;
        for (index, parameter) in self.model.declaration().parameters.iter().enumerate() {
            map.serialize_entry(parameter.name, &self.model.parameter(index))?;
        }
        for (name, choice) in self.choices {
            map.serialize_entry(name, choice)?;
        }
        map.end()
    }
}

#[derive(Serialize)]
struct DiagnosisEntry<'a> {
    time: f64,
    step: usize,
    contact: Option<&'static str>,
    message: &'a str,
}

impl<'a> DiagnosisEntry<'a> {
    fn new(diagnosis: &'a Diagnosis, contacts: &[ContactDeclaration]) -> Self {
        Self {
            time: diagnosis.time,
            step: diagnosis.step,
            contact: diagnosis.contact.map(|contact| contacts[contact].name),
            message: &diagnosis.message,
        }
    }
}

#[derive(Serialize)]
struct EventEntry<'a> {
    time: f64,
    kind: &'static str,
    contact: &'static str,
    q: &'a [f64],
    v_before: &'a [f64],
    v_after: &'a [f64],
}

impl<'a> EventEntry<'a> {
    fn new(event: &'a Event, contacts: &[ContactDeclaration]) -> Self {
        Self {
            time: event.time,
            kind: event.kind.name(),
            contact: contacts[event.contact].name,
            q: &event.q,
            v_before: &event.v_before,
            v_after: &event.v_after,
        }
    }
}

#[derive(Default, Serialize)]
struct TrajectoryEntry<'a> {
    time: &'a [f64],
    numerical_time: &'a [f64],
    q: &'a [Vec<f64>],
    v: &'a [Vec<f64>],
    u: &'a [Vec<f64>],
    contact_force: &'a [Vec<f64>],
    /// Only for scenes with friction.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    friction_force: &'a [Vec<f64>],
}

impl<'a> TrajectoryEntry<'a> {
    /// The rows before the first number that is not finite.
    fn new(trajectory: &'a Trajectory) -> Self {
        let finite = |row: &[f64]| row.iter().all(|value| value.is_finite());
        let rows = (0..trajectory.time.len())
            .take_while(|&k| {
                trajectory.time[k].is_finite()
                    && trajectory.numerical_time[k].is_finite()
                    && [
                        &trajectory.q[k],
                        &trajectory.v[k],
                        &trajectory.u[k],
                        &trajectory.contact_force[k],
                    ]
                    .into_iter()
                    .chain(trajectory.friction_force.get(k))
                    .all(|row| finite(row))
            })
            .count();
        Self {
            time: &trajectory.time[..rows],
            numerical_time: &trajectory.numerical_time[..rows],
            q: &trajectory.q[..rows],
            v: &trajectory.v[..rows],
            u: &trajectory.u[..rows],
            contact_force: &trajectory.contact_force[..rows],
            friction_force: trajectory.friction_force.get(..rows).unwrap_or_default(),
        }
    }

    fn last(&self) -> Option<FinalEntry<'a>> {
        Some(FinalEntry {
            time: *self.time.last()?,
            q: self.q.last()?,
            v: self.v.last()?,
        })
    }
}

#[derive(Serialize)]
struct FinalEntry<'a> {
    time: f64,
    q: &'a [f64],
    v: &'a [f64],
}

#[derive(Serialize)]
#[serde(remote = "Residuals")]
struct ResidualsEntry {
    primal: f64,
    dual: f64,
    complementarity: f64,
}

#[derive(Serialize)]
#[serde(remote = "ProblemSize")]
struct SizeEntry {
    variables: usize,
    equalities: usize,
    inequalities: usize,
    complementarities: usize,
    jacobian_nonzeros: usize,
    hessian_nonzeros: usize,
}

#[derive(Serialize)]
#[serde(remote = "Counts")]
struct IterationsEntry {
    interior_point: usize,
    crossover: usize,
    newton: usize,
    factorizations: usize,
    evaluations: usize,
    elements: usize,
    fallbacks: usize,
}

#[derive(Serialize)]
#[serde(remote = "Seconds")]
struct SecondsEntry {
    total: f64,
    evaluate: f64,
    factorize: f64,
    solve: f64,
}

#[cfg(test)]
mod tests {
    use hangtime::simulation::{Diagnosis, Simulation, SimulationStatus, Trajectory};

    use super::Document;
    use crate::method::MethodSettings;
    use crate::settings::{ChosenScene, find};

    #[test]
    fn document_of_a_run_that_became_infinite_ends_before_the_first_infinite_row() {
        let chosen = ChosenScene::new(find(crate::testing::SCENES, "slide").unwrap(), &[]).unwrap();
        let mut trajectory = Trajectory::default();
        trajectory.push(0.0, 0.0, &[1.0, 0.1], &[0.0, 0.0], &[], &[0.0, 0.0]);
        trajectory.push(0.5, 0.5, &[2.0, 0.2], &[1e300, 0.0], &[], &[0.0, 0.0]);
        trajectory.push(
            1.0,
            1.0,
            &[3.0, 0.3],
            &[f64::INFINITY, 0.0],
            &[],
            &[0.0, 0.0],
        );
        let simulation = Simulation {
            declaration: chosen.model.declaration(),
            initial_modes: Vec::new(),
            status: SimulationStatus::NotFinite(Diagnosis {
                time: 1.0,
                step: 2,
                contact: Some(1),
                message: "velocity is infinite".into(),
            }),
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
            notes: Vec::new(),
        };
        let settings = MethodSettings::default();
        let text = Document::new(&chosen, 5.0, &settings, &simulation).text();
        let document: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(document["status"], "not_finite");
        assert_eq!(document["diagnosis"]["contact"], "slope");
        assert_eq!(document["trajectory"]["time"].as_array().unwrap().len(), 2);
        assert_eq!(document["final"]["q"], serde_json::json!([2.0, 0.2]));
        assert!(document["residuals"]["primal"].is_null());
        assert!(text.contains("1e+300") && text.contains("0.1"), "{text}");
    }
}
