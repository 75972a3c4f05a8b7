//! One simulation.

use hangtime::Observer;
use hangtime::derivative::{self, Gradient, GradientMode};
use hangtime::model::Model;
use hangtime::simulation::{InitialValueProblem, Simulation};

use crate::arguments::{GradientModeName, Method, SimulateArguments};
use crate::ending::Ending;
use crate::failure::BadInput;
use crate::json::simulation_document;
use crate::kept;
use crate::method::{ChosenMethod, name_of};
use crate::settings::ChosenScene;
use crate::table::{number, seconds};

/// A scene that is to be simulated.
pub(crate) struct SimulationTask {
    /// The scene with its settings.
    pub(crate) chosen: ChosenScene,
    /// How it is simulated.
    pub(crate) method: ChosenMethod,
    /// Start and horizon.
    pub(crate) problem: InitialValueProblem,
    pub(crate) rows: usize,
    /// Names of what the motion is differentiated by; none if it is not.
    gradient: Vec<String>,
    /// Values at the end that are differentiated alone, if that is asked for, and how.
    of: Vec<String>,
    mode: Option<GradientMode>,
}

impl SimulationTask {
    /// Refuses arguments that do not fit the scene.
    pub(crate) fn new(
        chosen: ChosenScene,
        arguments: &SimulateArguments,
    ) -> Result<Self, BadInput> {
        let method = ChosenMethod::from_arguments(&arguments.method)?;
        refuse_without_events(arguments)?;
        let problem = InitialValueProblem::of(chosen.model.as_ref(), arguments.horizon)
            .and_then(|problem| problem.check(chosen.model.as_ref()).map(|()| problem))
            .map_err(|error| chosen.refuse(&error))?;
        Ok(Self {
            chosen,
            method,
            problem,
            rows: arguments.result.rows(),
            gradient: arguments.gradient.clone(),
            of: arguments.gradient_of.clone(),
            mode: arguments.gradient_mode.map(|mode| match mode {
                GradientModeName::Forward => GradientMode::Forward,
                GradientModeName::Adjoint => GradientMode::Adjoint,
            }),
        })
    }

    /// The derivatives of the motion, if they were asked for.
    pub(crate) fn gradient(&self, simulation: &Simulation) -> Result<Option<Gradient>, BadInput> {
        if self.gradient.is_empty() {
            return Ok(None);
        }
        let model = self.chosen.model.as_ref();
        let gradient = derivative::differentiate_values(
            model,
            (&self.problem, simulation),
            &self.gradient,
            (&self.of, self.mode),
        );
        let mut gradient = gradient.map_err(|error| self.chosen.refuse(&error))?;
        let mut neighbour = |model: &dyn Model, problem: &InitialValueProblem| {
            self.method.simulate(model, problem, &mut |_| true)
        };
        let scene = (model, &self.problem);
        derivative::add_one_sided(&mut gradient, scene, simulation, &mut neighbour);
        Ok(Some(gradient))
    }

    /// The motion.
    pub(crate) fn run(&self, observer: &mut Observer<'_>) -> Result<Simulation, BadInput> {
        let model = self.chosen.model.as_ref();
        let simulated = self.method.simulate(model, &self.problem, observer);
        let mut simulation = simulated.map_err(|error| self.chosen.refuse(&error))?;
        simulation.notes.extend(kept::notes(model, &simulation));
        simulation.notes.extend(begins(&self.chosen));
        Ok(simulation)
    }

    /// The JSON document of a motion that ended as `ending` tells.
    pub(crate) fn json(
        &self,
        simulation: &Simulation,
        gradient: Option<&Gradient>,
        ending: &Ending,
    ) -> String {
        let method = (self.problem.horizon, &self.method.settings);
        let run = (simulation, gradient);
        simulation_document(&self.chosen, method, run, ending, self.rows).text()
    }
}

/// Says of each free parameter that it has the value here with which `solve` begins.
fn begins(chosen: &ChosenScene) -> Vec<String> {
    let model = chosen.model.as_ref();
    let free = model.free_parameters().iter();
    let free = free.filter(|index| !chosen.given.contains(index));
    let note = |&index: &usize| {
        let known = &model.declaration().parameters[index];
        let value = format!("{} {}", number(model.parameter(index)), known.unit);
        format!(
            "the free parameter `{}` is {} here, the value with which `solve` begins",
            known.name,
            value.trim_end()
        )
    };
    free.map(note).collect()
}

/// Refuses to differentiate what a method finds that does not locate events.
fn refuse_without_events(arguments: &SimulateArguments) -> Result<(), BadInput> {
    let located = |method: &Method| matches!(method, Method::Fesd | Method::Event);
    let method = arguments.method.method.filter(|method| !located(method));
    let Some(method) = method.filter(|_| !arguments.gradient.is_empty()) else {
        return Ok(());
    };
    Err(BadInput::new(format!(
        "--gradient has no meaning for --method {}, which does not locate events; use fesd or event",
        name_of(method)
    )))
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
