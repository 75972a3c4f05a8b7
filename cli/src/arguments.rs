//! The arguments, as the user types them.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::numbers::{
    ROWS, above_zero, chain, duration, elements, intervals, rows, shard, share, stages, starts,
    steps,
};

/// Simulation and optimal control of mechanical systems with impacts.
#[derive(Debug, Parser)]
#[command(name = "hangtime", version, propagate_version = true)]
#[command(
    after_help = "Exit status: 0 solved, 2 bad input or files that could not be written, 3 not converged or ended at a \
        limit; one line on the standard error stream says why (mistakes in a scene file: with the lines of the file)."
)]
pub(crate) struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    /// Run again whenever the scene file changes, until Ctrl-C.
    #[arg(long, global = true)]
    pub(crate) watch: bool,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// List the scenes by groups; of those that are named all about them: parameters, what they ask, what can be done with them.
    List(ListArguments),
    /// Simulate a scene over its horizon.
    Simulate(SimulateArguments),
    /// Solve the optimal control problem of a scene.
    Solve(SolveArguments),
    /// Solve a nonlinear program, with or without complementarity constraints, from a .nl file as AMPL, Pyomo and JuMP
    /// write it.
    Nlp(NlpArguments),
    /// Simulate or solve a scene over the values of its parameters, and write a table with a row a point.
    Sweep(SweepArguments),
    /// Measure the error of every method against its step size and its CPU time.
    Chart(ChartArguments),
    /// Show what was derived from a scene: equations, sparsity patterns, operation counts. Given the code
    /// of a mistake, as in `explain E07`, show its page.
    Explain(ExplainArguments),
    /// Report the mistakes of a scene file, and nothing else.
    Check(CheckArguments),
    /// Write scene files anew in the settled style; comments stay, and so does what they declare.
    Fmt(FormatArguments),
    /// Write a scene file to begin with, which simulates and solves as it stands.
    New(NewArguments),
    /// Print a table of measured points as a `profile`, a function of the language.
    Profile(ProfileArguments),
    /// Write a page on which scenes are written, simulated, solved and played; it opens in a browser without a server.
    Play(PlayArguments),
    /// Reproduce the published results and write figures, data and a page.
    Reproduce(ReproduceArguments),
    /// Print the script that completes commands, options and their choices in a shell.
    Completions(CompletionsArguments),
    /// Print the manual page of the program, or of one of its commands, to be read by `man -l`.
    Man(ManArguments),
}

impl Command {
    /// Name of the command that reproduces published results.
    pub(crate) const REPRODUCE: &str = "reproduce";

    /// The scene that it is about, if it is about one.
    pub(crate) fn scene(&self) -> Option<&str> {
        match self {
            Self::Simulate(arguments) => Some(&arguments.scene.scene),
            Self::Solve(arguments) => Some(&arguments.scene.scene),
            Self::Explain(arguments) => Some(&arguments.scene.scene),
            Self::Sweep(arguments) => arguments.scene.as_deref(),
            Self::Chart(arguments) => match arguments.scenes.as_slice() {
                [scene] => Some(scene),
                _ => None,
            },
            Self::Check(arguments) => Some(&arguments.file),
            _ => None,
        }
    }
}

/// Arguments of `profile`.
#[derive(Debug, Args)]
pub(crate) struct ProfileArguments {
    /// The table: two columns with a point a line, from left to right; names and units, as in `s [m]`, may stand above.
    #[arg(value_name = "FILE.csv")]
    pub(crate) file: PathBuf,
}

/// Arguments of `list`.
#[derive(Debug, Default, Args)]
pub(crate) struct ListArguments {
    /// Scenes to tell all about: what each is, asks and answers, its parameters. Without one, all are named.
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Only the scenes of this group.
    #[arg(long, value_name = "GROUP")]
    pub(crate) group: Option<String>,
    /// Print one JSON object.
    #[arg(long)]
    pub(crate) json: bool,
}

/// The scene and its parameters.
#[derive(Debug, Clone, Args)]
pub(crate) struct SceneArguments {
    /// Name of the scene; `hangtime list` shows them. Or the path of a scene file, which ends with .hang.
    #[arg(value_name = "SCENE")]
    pub(crate) scene: String,
    /// Set a parameter, in its declared unit or in the unit given: `--set start_y=8.264m`.
    #[arg(long = "set", value_name = "NAME=VALUE[UNIT]")]
    pub(crate) settings: Vec<String>,
}

/// Where the files of a result go, and how it is printed.
#[derive(Debug, Clone, Args)]
pub(crate) struct ResultArguments {
    /// Directory for data, figures and a page; made if it does not exist.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    pub(crate) json: bool,
    /// Most instants of a trajectory in JSON and CSV; of a longer one every second, third, ... is written, with all
    /// events, and the notes say so [default: 20000].
    #[arg(long, value_name = "N", value_parser = rows, allow_negative_numbers = true)]
    pub(crate) rows: Option<usize>,
}

impl ResultArguments {
    /// Most instants of a trajectory.
    pub(crate) fn rows(&self) -> usize {
        self.rows.unwrap_or(ROWS)
    }
}

/// Default of `--memory-limit` [GB].
pub(crate) const MEMORY_LIMIT: f64 = 1.5;
/// The script that measures other programs, from the root of the repository.
const PEERS: &str = "tools/peers/measure.py";
/// Default of `--out` for commands that always write.
const OUT: &str = "out";

/// What a run may take. At a limit it ends with the best result so far and status 3.
#[derive(Debug, Clone, Args)]
pub(crate) struct LimitArguments {
    /// End after this time on the clock; without it, a run takes the time that it takes.
    #[arg(long, value_name = "TIME[UNIT]", value_parser = duration, allow_negative_numbers = true)]
    pub(crate) time_limit: Option<f64>,
    /// End when the program takes this much memory [GB].
    #[arg(long, value_name = "GB", default_value_t = MEMORY_LIMIT, value_parser = above_zero, allow_negative_numbers = true)]
    pub(crate) memory_limit: f64,
}

/// Arguments of `simulate`.
#[derive(Debug, Clone, Args)]
pub(crate) struct SimulateArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
    /// Differentiate the motion by these, separated by commas: parameters, coordinates (z, dot(z)) for their initial values,
    /// controls; `all` stands for all parameters.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub(crate) gradient: Vec<String>,
    /// Differentiate these alone, at the end of the motion, separated by commas: `objective`, coordinates (z, dot(z)), states,
    /// outputs; and times of events, `event_times[0]` of the first [default: the whole motion].
    #[arg(
        long,
        value_name = "NAME",
        value_delimiter = ',',
        requires = "gradient"
    )]
    pub(crate) gradient_of: Vec<String>,
    /// How those are differentiated [default: adjoint for more quantities than values].
    #[arg(long, value_enum, value_name = "MODE", requires = "gradient_of")]
    pub(crate) gradient_mode: Option<GradientModeName>,
    #[command(flatten)]
    pub(crate) method: MethodArguments,
    /// Length of the simulation, in seconds or in the unit given: `--horizon 200ms` [default: what the scene
    /// declares].
    #[arg(long, value_name = "TIME[UNIT]", value_parser = duration, allow_negative_numbers = true)]
    pub(crate) horizon: Option<f64>,
    #[command(flatten)]
    pub(crate) result: ResultArguments,
    #[command(flatten)]
    pub(crate) limits: LimitArguments,
}

/// The simulation method and its settings. A setting that the method does not have is refused.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct MethodArguments {
    /// How to simulate [default: fesd, and event where it fails and no setting of it is named].
    #[arg(long, value_enum)]
    pub(crate) method: Option<Method>,
    /// Runge-Kutta scheme (fesd) [default: radau-iia].
    #[arg(long, value_enum)]
    pub(crate) scheme: Option<SchemeName>,
    /// Runge-Kutta stages of a finite element, 1 to 9 (fesd) [default: 6, 3 with steps or
    /// elements].
    #[arg(long, value_name = "N", value_parser = stages, allow_negative_numbers = true)]
    pub(crate) stages: Option<usize>,
    /// Steps over the horizon (moreau, fixed; fesd: instead of error control) [default: 1000 with moreau and fixed].
    #[arg(long, value_name = "N", value_parser = steps, allow_negative_numbers = true)]
    pub(crate) steps: Option<usize>,
    /// Finite elements of a step (fesd) [default: 3].
    #[arg(long, value_name = "N", value_parser = elements, allow_negative_numbers = true)]
    pub(crate) elements: Option<usize>,
    /// How the equations of a step are solved (fesd) [default: active-set].
    #[arg(long, value_enum)]
    pub(crate) formulation: Option<FormulationName>,
    /// Relative and absolute error tolerance of a step (event, smooth); error relative to the largest values
    /// that is promised and checked (fesd) [default: 1e-9 with event, 1e-6 with smooth, 1e-6 with fesd unless steps
    /// or elements are named].
    #[arg(long, value_name = "TOLERANCE", value_parser = above_zero, allow_negative_numbers = true)]
    pub(crate) tolerance: Option<f64>,
    /// Longest step, in seconds or in the unit given: `--max-step 10ms` (event, fesd). For doubt: no event is missed in
    /// longer ones but of functions that the result names under `enclosed` [default: a tenth of the horizon].
    #[arg(long, value_name = "TIME[UNIT]", value_parser = duration, allow_negative_numbers = true)]
    pub(crate) max_step: Option<f64>,
    /// Width of the smoothed step functions (smooth) [default: 0.001].
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

/// From which side derivatives of a motion are multiplied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum GradientModeName {
    /// Along the motion: the cost grows with what it is differentiated by.
    Forward,
    /// Against it: the cost grows with what is differentiated.
    Adjoint,
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
    /// The time-freezing system in numerical time, region by region, with the same switches located.
    TimeFreezing,
}

/// Arguments of `solve`.
#[derive(Debug, Clone, Args)]
pub(crate) struct SolveArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
    /// Differentiate the optimum and its final time by these parameters, separated by commas.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub(crate) gradient: Vec<String>,
    /// Length of the motion, in seconds or in the unit given, or the guess of it where the final time is free, which stays
    /// free [default: what the scene declares].
    #[arg(long, value_name = "TIME[UNIT]", value_parser = duration, allow_negative_numbers = true)]
    pub(crate) horizon: Option<f64>,
    /// Control intervals [default: 30].
    #[arg(long, value_name = "N", value_parser = intervals, allow_negative_numbers = true)]
    pub(crate) intervals: Option<usize>,
    /// Where control intervals begin and end.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) grid: GridName,
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
    #[arg(long, value_name = "N", value_parser = stages, allow_negative_numbers = true)]
    pub(crate) stages: Option<usize>,
    /// Finite elements: of a phase between two switches [default: 1], of an interval with time-freezing
    /// [default: 3], where one more is taken if a contact bounces.
    #[arg(long, value_name = "N", value_parser = elements, allow_negative_numbers = true)]
    pub(crate) elements: Option<usize>,
    /// Motions from which the best order of contacts is solved, until so many less one bring nothing [default: 3]; with
    /// time-freezing guesses and discretizations that are solved side by side [default: up to 6 until a motion is
    /// certified: 2, one of them on about ten intervals, then others one after the other].
    #[arg(long, value_name = "N", value_parser = starts, allow_negative_numbers = true)]
    pub(crate) starts: Option<usize>,
    /// Share of the work until the last gain for which the search for orders of contacts goes on without another one, once it has a
    /// plan; 0 or more [default: 0.5].
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true)]
    pub(crate) patience: Option<f64>,
    #[command(flatten)]
    pub(crate) result: ResultArguments,
    #[command(flatten)]
    pub(crate) limits: LimitArguments,
}

/// Where the control intervals of `solve` begin and end.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum GridName {
    /// At equal distances in time.
    #[default]
    Equal,
    /// Divided among the phases between contacts: controls may change where contacts do.
    Aligned,
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
    /// Orders of contacts with phases of free length, the best of them put on the grid and solved exactly.
    #[default]
    Auto,
    /// The complementarity problem of finite elements with switch detection on the time-freezing system.
    TimeFreezing,
}

/// Arguments of `nlp`.
#[derive(Debug, Args)]
pub(crate) struct NlpArguments {
    /// The program, a .nl file, text or binary; names of variables and rows are read from the .col and .row files
    /// beside it.
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Write the solution to this file, in the form that modelling languages read.
    #[arg(long, value_name = "FILE")]
    pub(crate) sol: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) limits: LimitArguments,
}

/// Points of a chain of a warm sweep, unless others are asked for: few enough that a sweep of some hundred points keeps many
/// processors busy, and a start from nothing is a tenth of the solves.
pub const WARM_CHAIN: &str = "10";

/// Arguments of `sweep`.
#[derive(Debug, Args)]
pub(crate) struct SweepArguments {
    /// Name of the scene, or the path of a scene file.
    #[arg(
        value_name = "SCENE",
        required_unless_present = "join",
        conflicts_with = "join"
    )]
    pub(crate) scene: Option<String>,
    /// The values of a parameter, at equal distances with both ends, or one by one: `--over speed=10:20:11km/h`, `--over
    /// mu=0.1,0.2`. With several, every combination is a point; the last one changes fastest.
    #[arg(
        long,
        value_name = "NAME=from:to:count[UNIT]|a,b,c",
        conflicts_with = "join"
    )]
    pub(crate) over: Vec<String>,
    /// Set a parameter for all points.
    #[arg(long = "set", value_name = "NAME=VALUE[UNIT]", conflicts_with = "join")]
    pub(crate) settings: Vec<String>,
    /// What is done at every point.
    #[arg(long, value_enum, default_value_t, conflicts_with = "join")]
    pub(crate) what: SweepTask,
    /// Numbers to record: objective, final_time, events, final.NAME and final.dot(NAME) of a coordinate, output.NAME at the end,
    /// max(NAME) and min(NAME) along the motion, force(NAME) for the largest force of a contact or joint, time(EVENT CONTACT N).
    #[arg(
        long,
        value_name = "NAME,..",
        value_delimiter = ',',
        conflicts_with = "join"
    )]
    pub(crate) record: Vec<String>,
    /// Let a point of `--what solve` start from the motion found at the point before it, in chains of N points along the last
    /// parameter (without N: 10); the first point of a chain starts from nothing, as every point does without this option.
    #[arg(long, value_name = "N", value_parser = chain, num_args = 0..=1, require_equals = true, default_missing_value = WARM_CHAIN, conflicts_with = "join")]
    pub(crate) warm: Option<usize>,
    /// The table; its columns are point, values, status, message, contact sequence, records, and a mark of the sweep.
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: PathBuf,
    /// Only every N-th point (of a warm sweep: chain), from the I-th on, for N jobs that share a sweep.
    #[arg(long, value_name = "I/N", value_parser = shard, default_value = "1/1", conflicts_with = "join")]
    pub(crate) shard: (usize, usize),
    /// Go on with a table that a run before has begun.
    #[arg(long, conflicts_with = "join")]
    pub(crate) resume: bool,
    /// Join the tables of all shards.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub(crate) join: Vec<PathBuf>,
    /// Options of `simulate` or `solve`, for all points: `-- --intervals 20`.
    #[arg(last = true, value_name = "OPTIONS", conflicts_with = "join")]
    pub(crate) options: Vec<String>,
}

/// What a sweep does at every point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum SweepTask {
    /// Simulate the scene.
    #[default]
    Simulate,
    /// Solve its problem of optimal control.
    Solve,
}

/// Arguments of `chart`.
#[derive(Debug, Args)]
pub(crate) struct ChartArguments {
    /// Names of scenes, or paths of scene files; default: all scenes, on one page.
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Set a parameter of the scene, in its declared unit or in the unit given.
    #[arg(long = "set", value_name = "NAME=VALUE[UNIT]", requires = "scenes")]
    pub(crate) settings: Vec<String>,
    /// Show what every method makes of scenes on which methods fail: right, wrong without a word, stopped with a name, or
    /// without an end. Without a scene: those that the program knows to be hard.
    #[arg(long)]
    pub(crate) stability: bool,
    /// Measure other programs in the same run, as far as they are installed, by this script of Python, instead of showing the
    /// runs that are stored (without a path: tools/peers/measure.py).
    #[arg(long, value_name = "SCRIPT", num_args = 0..=1, require_equals = true, default_missing_value = PEERS, conflicts_with = "stability")]
    pub(crate) peers: Option<PathBuf>,
    /// Length of the simulations, in seconds or in the unit given [default: what each scene declares].
    #[arg(long, value_name = "TIME[UNIT]", value_parser = duration, allow_negative_numbers = true)]
    pub(crate) horizon: Option<f64>,
    /// Directory for data and figures; made if it does not exist.
    #[arg(long, value_name = "DIR", default_value = OUT)]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) limits: LimitArguments,
}

/// Arguments of `explain`.
#[derive(Debug, Args)]
pub(crate) struct ExplainArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
    /// Show how large every formulation of the scene is, and what each part of it is there for.
    #[arg(long)]
    pub(crate) size: bool,
    /// Print the sizes as one JSON object.
    #[arg(long, requires = "size")]
    pub(crate) json: bool,
}

/// Arguments of `check`.
#[derive(Debug, Args)]
pub(crate) struct CheckArguments {
    /// The scene file, which ends with .hang.
    #[arg(value_name = "FILE")]
    pub(crate) file: String,
}

/// Arguments of `fmt`.
#[derive(Debug, Args)]
pub(crate) struct FormatArguments {
    /// The scene files, which end with .hang.
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<String>,
    /// Write nothing, and refuse files that are not in the settled style.
    #[arg(long)]
    pub(crate) check: bool,
}

/// Arguments of `new`.
#[derive(Debug, Args)]
pub(crate) struct NewArguments {
    /// Name of the scene; NAME.hang is written, unless there is such a file.
    #[arg(value_name = "NAME")]
    pub(crate) name: String,
}

/// Arguments of `play`.
#[derive(Debug, Args)]
pub(crate) struct PlayArguments {
    /// A scene file that the page opens with [default: the first shipped scene].
    #[arg(value_name = "FILE")]
    pub(crate) file: Option<String>,
    /// Directory for the page; made if it does not exist.
    #[arg(long, value_name = "DIR", default_value = OUT)]
    pub(crate) out: PathBuf,
}

/// Arguments of `reproduce`.
#[derive(Debug, Args)]
pub(crate) struct ReproduceArguments {
    /// Directory for data and figures; made if it does not exist.
    #[arg(long, value_name = "DIR", default_value = OUT)]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) limits: LimitArguments,
}

impl Default for LimitArguments {
    fn default() -> Self {
        Self {
            time_limit: None,
            memory_limit: MEMORY_LIMIT,
        }
    }
}

impl Default for ReproduceArguments {
    fn default() -> Self {
        Self {
            out: OUT.into(),
            limits: LimitArguments::default(),
        }
    }
}

/// Arguments of `completions`.
#[derive(Debug, Args)]
pub(crate) struct CompletionsArguments {
    /// The shell that reads the script.
    #[arg(value_name = "SHELL")]
    pub(crate) shell: clap_complete::Shell,
}

/// Arguments of `man`.
#[derive(Debug, Args)]
pub(crate) struct ManArguments {
    /// A command; without one, the page is that of the program.
    #[arg(value_name = "COMMAND")]
    pub(crate) command: Option<String>,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;
    use hangtime::baselines::{FixedStep, Moreau, Smooth};
    use hangtime::ocp::{Formulation, Settings, TimeFreezingSettings};
    use hangtime::simulation::{EventDriven, Fesd};

    use super::Arguments;
    use crate::task::INTERVALS;

    fn help(command: &str) -> String {
        let mut arguments = Arguments::command();
        let command = arguments.find_subcommand_mut(command).unwrap();
        command.render_long_help().to_string()
    }

    #[test]
    fn help_states_the_defaults_of_the_library() {
        let (fesd, smooth) = (Fesd::default(), Smooth::default());
        let (event, moreau) = (EventDriven::default().tolerance, Moreau::default().steps);
        assert_eq!(moreau, FixedStep::default().steps);
        let (tolerance, width, elements) = (smooth.tolerance, smooth.width, fesd.elements);
        let [stages, on_grid] =
            [fesd, Fesd::default().with_grid(1, 1)].map(|fesd| fesd.stage_count());
        assert_told(
            &help("simulate"),
            &[
                format!("[default: {event:e} with event"),
                format!("{tolerance:e} with smooth"),
                format!("(smooth) [default: {width}]"),
                format!("[default: {moreau} with moreau and fixed]"),
                format!("(fesd) [default: {stages}, {on_grid} with steps or elements]"),
                format!("Finite elements of a step (fesd) [default: {elements}]"),
            ],
        );
        let (settings, freezing) = (Settings::default(), TimeFreezingSettings::default());
        let mut frozen = Settings::default();
        frozen.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
        let [starts, tried] = [&settings, &frozen].map(Settings::starts);
        let (stages, elements) = (settings.stages, settings.elements);
        let (frozen, parts) = (freezing.stages, freezing.elements);
        assert_told(
            &help("solve"),
            &[
                format!("Control intervals [default: {INTERVALS}]"),
                format!("re-simulation asks for them [default: {stages}]"),
                format!("time-freezing, 1 to 9 [default: {frozen}]"),
                format!("between two switches [default: {elements}]"),
                format!("interval with time-freezing [default: {parts}], where one"),
                format!("until so many less one bring nothing [default: {starts}]; with"),
                format!("plan; 0 or more [default: {}]", settings.patience),
                format!("solved side by side [default: up to {tried} until a motion is"),
            ],
        );
    }

    fn assert_told(help: &str, told: &[String]) {
        for words in told {
            assert!(help.contains(words), "`{words}` is missing:\n{help}");
        }
    }
}
