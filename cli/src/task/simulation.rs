//! One simulation.

use hangtime::Observer;
use hangtime::simulation::{InitialValueProblem, Simulation};

use crate::arguments::SimulateArguments;
use crate::ending::Ending;
use crate::failure::BadInput;
use crate::json::Document;
use crate::kept;
use crate::method::ChosenMethod;
use crate::settings::ChosenScene;
use crate::table::seconds;

/// A scene that is to be simulated.
pub(crate) struct SimulationTask {
    /// The scene with its settings.
    pub(crate) chosen: ChosenScene,
    /// How it is simulated.
    pub(crate) method: ChosenMethod,
    /// Start and horizon.
    pub(crate) problem: InitialValueProblem,
    rows: usize,
}

impl SimulationTask {
    /// Refuses arguments that do not fit the scene.
    pub(crate) fn new(
        chosen: ChosenScene,
        arguments: &SimulateArguments,
    ) -> Result<Self, BadInput> {
        let method = ChosenMethod::from_arguments(&arguments.method)?;
        let problem = InitialValueProblem::of(chosen.model.as_ref(), arguments.horizon)
            .and_then(|problem| problem.check(chosen.model.as_ref()).map(|()| problem))
            .map_err(|error| chosen.refuse(&error))?;
        Ok(Self {
            chosen,
            method,
            problem,
            rows: arguments.result.rows(),
        })
    }

    /// The motion.
    pub(crate) fn run(&self, observer: &mut Observer<'_>) -> Result<Simulation, BadInput> {
        let model = self.chosen.model.as_ref();
        let simulated = self.method.simulate(model, &self.problem, observer);
        let mut simulation = simulated.map_err(|error| self.chosen.refuse(&error))?;
        simulation.notes.extend(kept::notes(model, &simulation));
        Ok(simulation)
    }

    /// The JSON document of a motion that ended as `ending` tells.
    pub(crate) fn json(&self, simulation: &Simulation, ending: &Ending) -> String {
        let (horizon, method) = (self.problem.horizon, &self.method.settings);
        Document::new(&self.chosen, horizon, method, simulation, ending, self.rows).text()
    }
}

/// What a page tells about a simulation.
pub(crate) fn facts(
    method: &ChosenMethod,
    simulation: &Simulation,
    ending: &Ending,
) -> Vec<[String; 2]> {
    let residuals = simulation.residuals;
    [
        ("method", method.settings.to_string()),
        ("status", ending.status.to_owned()),
        (
            "largest primal residual",
            format!("{:.1e}", residuals.primal),
        ),
        ("largest dual residual", format!("{:.1e}", residuals.dual)),
        (
            "largest complementarity",
            format!("{:.1e}", residuals.complementarity),
        ),
        ("CPU time", seconds(simulation.seconds.total)),
    ]
    .map(|(name, value)| [name.to_owned(), value])
    .into()
}
