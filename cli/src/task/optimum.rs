//! One optimal control problem.

use hangtime::Observer;
use hangtime::ocp::{
    self, ControlNodes, ControlShape, Formulation, Guess, Horizon, Previous, Problem, Settings,
    Solution, TimeFreezingSettings,
};
use hangtime::rk::Scheme;

use crate::arguments::{ControlsName, GridName, SchemeName, SolveArguments, SolveFormulation};
use crate::ending::Ending;
use crate::failure::BadInput;
use crate::json::{SolverSettings, solution_document};
use crate::settings::ChosenScene;
use crate::table::seconds;

/// Control intervals, unless others are asked for.
pub(crate) const INTERVALS: usize = 30;

/// A scene whose optimal control problem is to be solved.
pub(crate) struct OptimumTask {
    /// The scene with its settings.
    pub(crate) chosen: ChosenScene,
    /// The method, for documents.
    pub(crate) method: SolverSettings,
    problem: Problem,
    settings: Settings,
    pub(crate) rows: usize,
}

impl OptimumTask {
    /// Refuses arguments that do not fit the scene.
    pub(crate) fn new(chosen: ChosenScene, arguments: &SolveArguments) -> Result<Self, BadInput> {
        if chosen.model.declaration().optimal_control.is_none() {
            return Err(BadInput::new(format!(
                "scene `{0}` declares no objective, so there is nothing to optimize; run `simulate {0}` instead",
                chosen.scene.name
            )));
        }
        let mut settings = settings(arguments)?;
        settings.given_parameters.clone_from(&chosen.given);
        for name in &arguments.gradient {
            let found = ocp::parameter_named(chosen.model.as_ref(), name);
            settings
                .gradient
                .push(found.map_err(|error| chosen.refuse(&error))?);
        }
        let mut problem = Problem::of(
            chosen.model.as_ref(),
            arguments.intervals.unwrap_or(INTERVALS),
        );
        if let Some(length) = arguments.horizon {
            problem.horizon = match problem.horizon {
                Horizon::Fixed(_) => Horizon::Fixed(length),
                Horizon::Free { .. } => Horizon::Free {
                    guess: Some(length),
                },
            };
        }
        Ok(Self {
            method: SolverSettings::new(chosen.model.as_ref(), &settings, problem.intervals),
            chosen,
            problem,
            settings,
            rows: arguments.result.rows(),
        })
    }

    /// Starts from the motion of an earlier plan for the same scene.
    pub(crate) fn start_from(&mut self, previous: &Previous) {
        self.settings.guess = Guess::Previous(Box::new(previous.clone()));
    }

    /// The plan; the scene has the values of its free parameters from there on.
    pub(crate) fn run(&mut self, observer: &mut Observer<'_>) -> Result<Solution, BadInput> {
        let model = self.chosen.model.as_ref();
        let solution = ocp::solve(model, &self.problem, &self.settings, observer)
            .map_err(|error| self.chosen.refuse(&error))?;
        for found in &solution.parameters {
            self.chosen.model.set_parameter(found.index, found.value);
        }
        Ok(solution)
    }

    /// The JSON document of a plan that ended as `ending` tells.
    pub(crate) fn json(&self, solution: &Solution, ending: &Ending) -> String {
        solution_document(&self.chosen, &self.method, solution, ending, self.rows).text()
    }
}

/// The settings of the solver.
fn settings(arguments: &SolveArguments) -> Result<Settings, BadInput> {
    let mut settings = Settings::default();
    settings.starts = arguments.starts;
    settings.patience = arguments.patience.unwrap_or(settings.patience);
    settings.grid = match arguments.grid {
        GridName::Equal => ControlNodes::Equal,
        GridName::Aligned => ControlNodes::Aligned,
    };
    settings.controls = match arguments.controls {
        ControlsName::Constant => ControlShape::Constant,
        ControlsName::Linear => ControlShape::Linear,
    };
    match arguments.formulation {
        SolveFormulation::Auto => {
            if arguments.scheme.is_some() {
                return Err(BadInput::new(
                    "--scheme has no meaning for --formulation auto, whose phases are Radau IIA, with a stage at their \
                     end; leave it out, or add --formulation time-freezing",
                ));
            }
            settings.stages = arguments.stages.unwrap_or(settings.stages);
            settings.elements = arguments.elements.unwrap_or(settings.elements);
        }
        SolveFormulation::TimeFreezing => {
            let mut freezing = TimeFreezingSettings::default();
            freezing.scheme = match arguments.scheme {
                Some(SchemeName::GaussLegendre) => Scheme::GaussLegendre,
                Some(SchemeName::RadauIia) => Scheme::RadauIia,
                None => freezing.scheme,
            };
            freezing.stages = arguments.stages.unwrap_or(freezing.stages);
            freezing.elements = arguments.elements.unwrap_or(freezing.elements);
            settings.formulation = Formulation::TimeFreezing(freezing);
        }
    }
    Ok(settings)
}

/// What a page tells about a solution.
pub(crate) fn facts(
    method: &SolverSettings,
    solution: &Solution,
    ending: &Ending,
) -> Vec<[String; 2]> {
    [
        (
            "method",
            format!(
                "{}, {}, {} stages, {} intervals, {} controls",
                method.name, method.scheme, method.stages, method.intervals, method.control_shape
            ),
        ),
        ("status", ending.status.to_owned()),
        ("objective", format!("{:.10}", solution.objective)),
        ("final time", format!("{:.10} s", solution.horizon)),
        ("stationarity", solution.certificate()),
        (
            "distance of the re-simulation at the end",
            format!("{:.1e}", solution.resimulation_error),
        ),
        ("CPU time", seconds(solution.seconds.total)),
    ]
    .map(|(name, value)| [name.to_owned(), value])
    .into()
}
