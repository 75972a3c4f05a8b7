//! The JSON document of a simulation.

use hangtime::derivative::Gradient;
use hangtime::simulation::Simulation;
use serde_json::json;

use super::columns::kept_instants;
use super::gradient::gradient;
use super::joints::joints;
use super::parts::{Motion, Object, begun};
use crate::ending::Ending;
use crate::method::MethodSettings;
use crate::settings::ChosenScene;

/// The document of one simulation of `chosen` over `horizon`, with at most `rows` rows of its trajectory, and with `derivatives` if there
/// are any.
pub(crate) fn simulation_document(
    chosen: &ChosenScene,
    (horizon, method): (f64, &MethodSettings),
    (simulation, derivatives): (&Simulation, Option<&Gradient>),
    ending: &Ending,
    rows: usize,
) -> Object {
    let model = chosen.model.as_ref();
    let motion = Motion::new(chosen, Some(simulation), rows);
    let diagnosis = simulation.status.diagnosis().map(|known| {
        let contact = known
            .contact
            .map(|contact| model.declaration().contacts[contact].name);
        Object::default()
            // Time that was reached \[s\].
            .with("time", known.time)
            // Step in which it ended, from 0.
            .with("step", known.step)
            // The contact concerned, if one can be named.
            .with("contact", contact)
            // What happened, and what to change.
            .with("message", ending.diagnosis.as_deref().unwrap_or_default())
    });
    let enclosed = simulation.interpolated.as_deref().map(|names| match names {
        [] => json!(true),
        names => json!(names),
    });
    let kept = || kept_instants(&simulation.trajectory, rows);
    let derivatives = derivatives.map(|known| gradient(model, known, &kept()));
    let begin = begun(chosen)
        // Length of the motion \[s\].
        .with("horizon", horizon)
        // The method and its settings.
        .with("method", method.with_steps_of(simulation));
    let document = motion
        .told(begin, ending, diagnosis)
        // Estimated largest error, relative to the largest values of each unit.
        .some("error_estimate", simulation.error_estimate)
        // Whether every function whose zeros are events was bounded between the places that were looked at; otherwise the names of those
        // that were interpolated there. Only for methods that locate events.
        .some("enclosed", enclosed)
        // How well the equations of the steps hold.
        .with("residuals", simulation.residuals)
        // Size of the largest system or program.
        .with("size", simulation.size)
        // What the run took, counted.
        .with("iterations", simulation.counts)
        // CPU time \[s\].
        .with("seconds", simulation.seconds);
    motion
        .ended(document, simulation.notes.iter().cloned(), None)
        // Only for scenes with joints.
        .some("joints", joints(model, &simulation.trajectory, rows))
        // Only where it was asked for.
        .some("gradient", derivatives)
}

#[cfg(test)]
mod tests {
    use hangtime::simulation::{Diagnosis, Simulation, SimulationStatus, Trajectory};

    use super::simulation_document;
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
            doubts: Default::default(),
        };
        let settings = MethodSettings::default();
        let ending = Ending::of_whole(&simulation);
        simulation_document(&chosen, (5.0, &settings), (&simulation, None), &ending, 100).text()
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
