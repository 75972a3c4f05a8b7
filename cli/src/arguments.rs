//! The arguments, as the user types them.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

/// Simulation and optimal control of mechanical systems with impacts.
#[derive(Debug, Parser)]
#[command(name = "hangtime", version, propagate_version = true)]
#[command(after_help = "Without a command, `hangtime reproduce` runs.\n\
    Exit status: 0 solved, 2 bad input (one line on the standard error stream), 3 not converged.")]
pub(crate) struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// List the scenes with their parameters.
    List(ListArguments),
    /// Simulate a scene over its horizon.
    Simulate(SimulateArguments),
    /// Solve the optimal control problem of a scene.
    Solve(SolveArguments),
    /// Measure the error of every method against its step size and its CPU time.
    Chart(ChartArguments),
    /// Show what was derived from a scene: equations, sparsity patterns, operation counts. Given the code
    /// of a mistake, as in `hangtime explain E07`, show its page.
    Explain(ExplainArguments),
    /// Reproduce the published results and write figures, data and a page.
    Reproduce(ReproduceArguments),
}

/// Arguments of `list`.
#[derive(Debug, Args)]
pub(crate) struct ListArguments {
    /// Print one JSON object.
    #[arg(long)]
    pub(crate) json: bool,
}

/// The scene and its parameters.
#[derive(Debug, Args)]
pub(crate) struct SceneArguments {
    /// Name of the scene; `hangtime list` shows them.
    #[arg(value_name = "SCENE")]
    pub(crate) scene: String,
    /// Set a parameter, in its declared unit or in the unit given: `--set start_y=8.264m`.
    #[arg(long = "set", value_name = "NAME=VALUE[UNIT]")]
    pub(crate) settings: Vec<String>,
}

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub(crate) struct SimulateArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
    #[command(flatten)]
    pub(crate) method: MethodArguments,
    /// Length of the simulation [s]; default: what the scene declares.
    #[arg(long, value_name = "SECONDS", value_parser = above_zero, allow_negative_numbers = true)]
    pub(crate) horizon: Option<f64>,
    /// Directory for data and figures; made if it does not exist.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    pub(crate) json: bool,
}

/// The simulation method and its settings. A setting that the method does not have is refused.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct MethodArguments {
    /// How to simulate.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) method: Method,
    /// Runge-Kutta scheme (fesd) [default: radau-iia].
    #[arg(long, value_enum)]
    pub(crate) scheme: Option<SchemeName>,
    /// Runge-Kutta stages of a finite element, 1 to 9 (fesd).
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub(crate) stages: Option<usize>,
    /// Steps over the horizon (moreau, fixed; fesd: instead of error control).
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub(crate) steps: Option<usize>,
    /// Finite elements of a step (fesd).
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub(crate) elements: Option<usize>,
    /// How the equations of a step are solved (fesd) [default: active-set].
    #[arg(long, value_enum)]
    pub(crate) formulation: Option<FormulationName>,
    /// Relative and absolute error tolerance of a step (event, smooth); error relative to the largest values
    /// that is promised and checked (fesd) [default: 1e-6, unless steps or elements are named].
    #[arg(long, value_name = "TOLERANCE", value_parser = above_zero, allow_negative_numbers = true)]
    pub(crate) tolerance: Option<f64>,
    /// Width of the smoothed step functions (smooth).
    #[arg(long, value_name = "WIDTH", value_parser = above_zero, allow_negative_numbers = true)]
    pub(crate) width: Option<f64>,
    /// Leave out the condition that ends a contact where its force vanishes, as published (fesd).
    #[arg(long)]
    pub(crate) no_exit_condition: bool,
}

/// Simulation methods.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// Finite elements with switch detection, on the time-freezing reformulation.
    #[default]
    Fesd,
    /// Event-driven integration with dense output and polished event times.
    Event,
    /// Moreau-Jean time stepping.
    Moreau,
    /// Smoothed step functions.
    Smooth,
    /// Runge-Kutta steps without switch detection.
    Fixed,
}

/// Runge-Kutta schemes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SchemeName {
    /// Radau IIA: stiffly accurate, order 2 n - 1.
    RadauIia,
    /// Gauss-Legendre: order 2 n in free motion, less on contact arcs.
    GaussLegendre,
}

/// Formulations of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FormulationName {
    /// Newton's method in a fixed contact mode, switches located.
    ActiveSet,
    /// The complementarity problem of the time-freezing system: slower, with events known to the
    /// length of an element.
    TimeFreezing,
}

/// Arguments of `solve`.
#[derive(Debug, Args)]
pub(crate) struct SolveArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
    /// Control intervals of equal physical length [default: 30].
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub(crate) intervals: Option<usize>,
    /// Controls on each interval.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) controls: ControlsName,
    /// How the contact sequence is found.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) formulation: SolveFormulation,
    /// Runge-Kutta scheme (time-freezing) [default: radau-iia].
    #[arg(long, value_enum)]
    pub(crate) scheme: Option<SchemeName>,
    /// Runge-Kutta stages: of a phase, 2 to 9, more where the re-simulation asks for them [default: 4]; of a finite
    /// element with time-freezing, 1 to 9 [default: 2].
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub(crate) stages: Option<usize>,
    /// Finite elements: of a phase between two switches [default: 1], of an interval with time-freezing
    /// [default: 3].
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub(crate) elements: Option<usize>,
    /// Guesses and discretizations that are solved side by side; the best is returned, and the distinct
    /// local optima are listed [default: 1].
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub(crate) starts: Option<usize>,
    /// Directory for data and figures; made if it does not exist.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    pub(crate) json: bool,
}

/// What the controls of `solve` are on an interval.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ControlsName {
    /// Constant; they may jump between intervals.
    #[default]
    Constant,
    /// Linear, and continuous over the ends of the intervals.
    Linear,
}

/// How `solve` finds the contact sequence.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum SolveFormulation {
    /// Small contact-implicit programs, from coarse to fine.
    #[default]
    Auto,
    /// The complementarity problem of finite elements with switch detection on the time-freezing system.
    TimeFreezing,
}

/// Arguments of `chart`.
#[derive(Debug, Args)]
pub(crate) struct ChartArguments {
    /// Name of the scene; default: all scenes.
    #[arg(value_name = "SCENE")]
    pub(crate) scene: Option<String>,
    /// Set a parameter, in its declared unit or in the unit given.
    #[arg(long = "set", value_name = "NAME=VALUE[UNIT]", requires = "scene")]
    pub(crate) settings: Vec<String>,
    /// Directory for data and figures; made if it does not exist.
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub(crate) out: PathBuf,
}

/// Arguments of `explain`.
#[derive(Debug, Args)]
pub(crate) struct ExplainArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
}

/// Arguments of `reproduce`.
#[derive(Debug, Args)]
pub(crate) struct ReproduceArguments {
    /// Directory for data and figures; made if it does not exist.
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub(crate) out: PathBuf,
}

/// Largest number of steps, elements or stages: a trajectory is kept in memory.
const MANY: usize = 10_000_000;

fn count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(number) if (1..=MANY).contains(&number) => Ok(number),
        _ => Err(format!("give a whole number from 1 to {MANY}")),
    }
}

fn above_zero(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err("give a finite number above 0".into()),
    }
}
