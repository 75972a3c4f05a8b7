//! `--method` and its settings: from words to a simulator.

use std::fmt;

use clap::ValueEnum;
use hangtime::Observer;
use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    EventDriven, Fesd, InitialValueProblem, InputError, Simulation, Simulator, StepFormulation,
};
use serde::Serialize;

use crate::arguments::{FormulationName, Method, MethodArguments, SchemeName};
use crate::failure::BadInput;
use crate::numbers::MOST_STEPS;
use crate::table::counted;

/// The settings of a method, as JSON and people read them; what the method does not have is absent.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct MethodSettings {
    /// Name of the method.
    pub(crate) name: &'static str,
    /// Runge-Kutta scheme.
    #[serde(skip_serializing_if = "Option::is_none")]
    scheme: Option<&'static str>,
    /// Its stages.
    #[serde(skip_serializing_if = "Option::is_none")]
    stages: Option<usize>,
    /// Steps over the horizon.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) steps: Option<usize>,
    /// Finite elements of a step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) elements: Option<usize>,
    /// Whether contacts end where their forces vanish.
    #[serde(skip_serializing_if = "Option::is_none")]
    exit_condition: Option<bool>,
    /// How the equations of a step are solved.
    #[serde(skip_serializing_if = "Option::is_none")]
    formulation: Option<String>,
    /// Tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) tolerance: Option<f64>,
    /// Longest step \[s\].
    #[serde(skip_serializing_if = "Option::is_none")]
    max_step: Option<f64>,
    /// Width of the smoothed step functions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) width: Option<f64>,
}

impl MethodSettings {
    /// The settings with the number of steps that `simulation` took, where the method chose it itself.
    pub(crate) fn with_steps_of(&self, simulation: &Simulation) -> Self {
        let mut settings = self.clone();
        if self.stages.is_some() && self.steps.is_none() {
            settings.steps = Some(simulation.counts.elements);
        }
        settings
    }

    /// Refuses more elements in all than states fit into memory.
    fn refuse_too_many_elements(&self) -> Result<(), BadInput> {
        let (Some(steps), Some(elements)) = (self.steps, self.elements) else {
            return Ok(());
        };
        if steps.saturating_mul(elements) <= MOST_STEPS {
            return Ok(());
        }
        Err(BadInput::new(format!(
            "--steps {steps} of --elements {elements} are {} elements, more than {MOST_STEPS}, whose states stay in memory; \
             lower one of them, simulate a part of the horizon, or give a tolerance",
            steps.saturating_mul(elements)
        )))
    }
}

impl fmt::Display for MethodSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.name)?;
        if let Some(scheme) = self.scheme {
            write!(f, ", {scheme}")?;
        }
        if let Some(stages) = self.stages {
            write!(f, ", {}", counted(stages, "stage"))?;
        }
        if let Some(steps) = self.steps {
            write!(f, ", {}", counted(steps, "step"))?;
        }
        if let Some(elements) = self.elements {
            write!(f, " of {}", counted(elements, "element"))?;
        }
        if let Some(tolerance) = self.tolerance {
            write!(f, ", tolerance {tolerance:e}")?;
        }
        if let Some(longest) = self.max_step {
            write!(f, ", steps of {longest:e} s at most")?;
        }
        if let Some(width) = self.width {
            write!(f, ", width {width:e}")?;
        }
        if let Some(formulation) = &self.formulation {
            write!(f, ", {formulation}")?;
        }
        match self.exit_condition {
            Some(false) => write!(f, ", no exit condition"),
            _ => Ok(()),
        }
    }
}

/// A method with its settings.
pub(crate) struct ChosenMethod {
    /// Its settings.
    pub(crate) settings: MethodSettings,
    simulator: Box<dyn Simulator + Send + Sync>,
}

impl ChosenMethod {
    /// Makes the simulator; settings left out take the method's defaults.
    pub(crate) fn from_arguments(arguments: &MethodArguments) -> Result<Self, BadInput> {
        refuse_foreign_settings(arguments)?;
        refuse_idle_settings(arguments)?;
        let chosen = match arguments.method.unwrap_or_default() {
            Method::Fesd => fesd(arguments),
            Method::Event => {
                let mut event = EventDriven::default();
                event.tolerance = arguments.tolerance.unwrap_or(event.tolerance);
                event.max_step = arguments.max_step;
                let settings = MethodSettings {
                    tolerance: Some(event.tolerance),
                    max_step: arguments.max_step,
                    ..MethodSettings::default()
                };
                Self::new(settings, event)
            }
            Method::Moreau => {
                let mut moreau = Moreau::default();
                moreau.steps = arguments.steps.unwrap_or(moreau.steps);
                Self::new(stepping(moreau.steps), moreau)
            }
            Method::Smooth => {
                let mut smooth = Smooth::default();
                smooth.width = arguments.width.unwrap_or(smooth.width);
                smooth.tolerance = arguments.tolerance.unwrap_or(smooth.tolerance);
                let settings = MethodSettings {
                    tolerance: Some(smooth.tolerance),
                    width: Some(smooth.width),
                    ..MethodSettings::default()
                };
                Self::new(settings, smooth)
            }
            Method::Fixed => {
                let mut fixed = FixedStep::default();
                fixed.steps = arguments.steps.unwrap_or(fixed.steps);
                Self::new(stepping(fixed.steps), fixed)
            }
        };
        chosen.settings.refuse_too_many_elements()?;
        Ok(chosen)
    }

    fn new(settings: MethodSettings, simulator: impl Simulator + Send + Sync + 'static) -> Self {
        Self {
            settings: MethodSettings {
                name: simulator.name(),
                ..settings
            },
            simulator: Box::new(simulator),
        }
    }

    /// Simulates, and measures the CPU time of the whole process from the first to the last step.
    pub(crate) fn simulate(
        &self,
        model: &dyn Model,
        problem: &InitialValueProblem,
        observer: &mut Observer<'_>,
    ) -> Result<Simulation, InputError> {
        let start = processor_seconds();
        let mut simulation = self.simulator.simulate(model, problem, observer)?;
        if let (Some(start), Some(end)) = (start, processor_seconds()) {
            simulation.seconds.total = end - start;
        }
        Ok(simulation)
    }
}

/// CPU time of the whole process so far \[s\], where the system tells.
fn processor_seconds() -> Option<f64> {
    #[cfg(feature = "terminal")]
    if let Ok(now) = cpu_time::ProcessTime::try_now() {
        return Some(now.as_duration().as_secs_f64());
    }
    None
}

fn stepping(steps: usize) -> MethodSettings {
    MethodSettings {
        steps: Some(steps),
        ..MethodSettings::default()
    }
}

fn fesd(arguments: &MethodArguments) -> ChosenMethod {
    let mut fesd = Fesd::default();
    fesd.hands_over = any_will_do(arguments);
    fesd.scheme = match arguments.scheme {
        Some(SchemeName::RadauIia) => Scheme::RadauIia,
        Some(SchemeName::GaussLegendre) => Scheme::GaussLegendre,
        None => fesd.scheme,
    };
    fesd.stages = arguments.stages;
    // Whoever names the elements of a step wants steps.
    let grid = arguments.elements.map(|_| Fesd::DEFAULT_STEPS);
    fesd.steps = arguments.steps.or(grid);
    fesd.elements = arguments.elements.unwrap_or(fesd.elements);
    // A grid that is asked for may be used up, and its elements divided at switches.
    let asked = fesd.steps.unwrap_or(0).saturating_mul(fesd.elements);
    if asked <= MOST_STEPS {
        fesd.most_elements = fesd.most_elements.max(2 * asked);
    }
    fesd.tolerance = arguments.tolerance;
    fesd.max_step = arguments.max_step;
    fesd.exit_condition = !arguments.no_exit_condition;
    let formulation = arguments.formulation.unwrap_or(FormulationName::ActiveSet);
    fesd.formulation = match formulation {
        FormulationName::ActiveSet => StepFormulation::ActiveSet,
        FormulationName::TimeFreezing => StepFormulation::TimeFreezing,
    };
    let promise = fesd.promise();
    let grid = promise.is_none();
    let settings = MethodSettings {
        formulation: Some(name_of(formulation)),
        scheme: Some(fesd.scheme.name()),
        stages: Some(fesd.stage_count()),
        steps: fesd.steps.or(grid.then_some(Fesd::DEFAULT_STEPS)),
        elements: grid.then_some(fesd.elements),
        // Two grids are compared to it where nothing is promised.
        tolerance: promise.or(fesd.tolerance),
        max_step: fesd.max_step,
        exit_condition: Some(fesd.exit_condition),
        ..MethodSettings::default()
    };
    ChosenMethod::new(settings, fesd)
}

/// Whether nothing is said but how accurate the motion has to be, so that any method will do.
fn any_will_do(arguments: &MethodArguments) -> bool {
    arguments.method.is_none()
        && arguments.scheme.is_none()
        && arguments.stages.is_none()
        && arguments.steps.is_none()
        && arguments.elements.is_none()
        && arguments.formulation.is_none()
        && !arguments.no_exit_condition
}

/// Refuses a setting that the method does not have.
fn refuse_foreign_settings(arguments: &MethodArguments) -> Result<(), BadInput> {
    use Method::{Event, Fesd, Fixed, Moreau, Smooth};
    let given: [(&str, bool, &[Method]); 9] = [
        ("--scheme", arguments.scheme.is_some(), &[Fesd]),
        ("--stages", arguments.stages.is_some(), &[Fesd]),
        ("--steps", arguments.steps.is_some(), &[Fesd, Moreau, Fixed]),
        ("--elements", arguments.elements.is_some(), &[Fesd]),
        ("--formulation", arguments.formulation.is_some(), &[Fesd]),
        (
            "--tolerance",
            arguments.tolerance.is_some(),
            &[Fesd, Event, Smooth],
        ),
        ("--max-step", arguments.max_step.is_some(), &[Fesd, Event]),
        ("--width", arguments.width.is_some(), &[Smooth]),
        ("--no-exit-condition", arguments.no_exit_condition, &[Fesd]),
    ];
    let foreign = given.iter().find(|(_, given, methods)| {
        *given && !methods.contains(&arguments.method.unwrap_or_default())
    });
    let Some((option, _, methods)) = foreign else {
        return Ok(());
    };
    let methods: Vec<String> = methods.iter().map(|method| name_of(*method)).collect();
    let method = name_of(arguments.method.unwrap_or_default());
    Err(BadInput::new(format!(
        "{option} has no meaning for --method {method}; leave it out, or choose the method: {}",
        methods.join(", ")
    )))
}

/// Refuses settings of the method that leave nothing to each other.
fn refuse_idle_settings(arguments: &MethodArguments) -> Result<(), BadInput> {
    if arguments.elements.is_some() && arguments.tolerance.is_some() {
        return Err(BadInput::new(
            "--elements and --tolerance exclude each other: the tolerance sets the length of \
             the elements; leave one of them out",
        ));
    }
    let grid = arguments.steps.is_some() || arguments.elements.is_some();
    if arguments.max_step.is_some() && grid {
        return Err(BadInput::new(
            "--max-step has no meaning for --steps and --elements, which set the length of all elements; leave it out",
        ));
    }
    if arguments.no_exit_condition && arguments.steps.is_some() && arguments.tolerance.is_some() {
        return Err(BadInput::new(
            "--tolerance has no meaning for --steps with --no-exit-condition, which controls no errors; leave out one of the two",
        ));
    }
    Ok(())
}

/// Name of a choice on the command line; none of them is hidden.
pub(crate) fn name_of(choice: impl ValueEnum) -> String {
    choice
        .to_possible_value()
        .map(|value| value.get_name().to_owned())
        .unwrap_or_default()
}
