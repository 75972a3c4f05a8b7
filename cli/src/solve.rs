//! `hangtime solve`: the optimal control problem of a scene, as tables, as JSON, and as files.

use std::fmt::Write as _;

use crate::{PublishedData, Scene};
use hangtime::ocp::{
    self, ControlShape, Formulation, Problem, Settings, Solution, TimeFreezingSettings,
};
use hangtime::rk::Scheme;
use hangtime::simulation::EventKind;

use crate::arguments::{ControlsName, SchemeName, SolveArguments, SolveFormulation};
use crate::failure::BadInput;
use crate::files::ResultFiles;
use crate::interrupt::Interrupt;
use crate::json::{SolutionDocument, SolverSettings};
use crate::output::OutputDirectory;
use crate::progress::SolveProgress;
use crate::report::Report;
use crate::settings::ChosenScene;
use crate::table::{counted, headed, seconds, table};

/// Control intervals, unless others are asked for.
pub(crate) const INTERVALS: usize = 30;

pub(crate) fn run(
    scenes: &'static [Scene],
    arguments: &SolveArguments,
) -> Result<Report, BadInput> {
    let chosen = ChosenScene::from_arguments(scenes, &arguments.scene)?;
    if chosen.model.declaration().optimal_control.is_none() {
        return Err(BadInput::new(format!(
            "scene `{0}` declares no objective, so there is nothing to optimize; run `hangtime \
             simulate {0}` instead",
            chosen.scene.name
        )));
    }
    let settings = settings(arguments)?;
    let model = chosen.model.as_ref();
    let problem = Problem::of(model, arguments.intervals.unwrap_or(INTERVALS));
    let interrupt = Interrupt::listen();
    let directory = arguments
        .out
        .as_deref()
        .map(OutputDirectory::open)
        .transpose()?;
    let mut display = SolveProgress::new(chosen.scene.name, interrupt);
    let solution = ocp::solve(model, &problem, &settings, &mut |progress| {
        display.report(progress)
    })
    .map_err(|error| chosen.refuse(&error))?;
    drop(display);
    let method = SolverSettings::new(&settings, problem.intervals);
    let json = SolutionDocument::new(&chosen, &method, &solution).text();
    let mut written = String::new();
    if let Some(directory) = directory {
        let stem = format!("{}-optimal", chosen.scene.name);
        let files = match &solution.motion {
            None => vec![(format!("{stem}.json"), json.clone())],
            Some(simulation) => ResultFiles {
                stem,
                title: format!("{}, optimal", chosen.scene.name),
                chosen: &chosen,
                simulation,
                json: &json,
                published: &PublishedData::default(),
                facts: facts(&method, &solution),
            }
            .contents(),
        };
        for path in directory.write(&files)? {
            let _ = writeln!(written, "wrote {}", path.display());
        }
    }
    let name = chosen.scene.name;
    let diagnosis = solution.diagnosis();
    Ok(Report {
        text: if arguments.json {
            json
        } else {
            tables(&chosen, &method, &solution) + &written
        },
        diagnoses: diagnosis
            .map(|text| format!("{name}: {}: {text}", solution.status.name()))
            .into_iter()
            .collect(),
    })
}

/// The settings of the solver.
fn settings(arguments: &SolveArguments) -> Result<Settings, BadInput> {
    let mut settings = Settings::default();
    settings.starts = arguments.starts.unwrap_or(settings.starts);
    settings.controls = match arguments.controls {
        ControlsName::Constant => ControlShape::Constant,
        ControlsName::Linear => ControlShape::Linear,
    };
    match arguments.formulation {
        SolveFormulation::Auto => {
            if arguments.scheme == Some(SchemeName::GaussLegendre) {
                return Err(BadInput::new(
                    "--scheme gauss-legendre has no meaning for --formulation auto, whose phases need a stage \
                     at their end; leave it out, or add --formulation time-freezing",
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
pub(crate) fn facts(method: &SolverSettings, solution: &Solution) -> Vec<[String; 2]> {
    [
        (
            "method",
            format!(
                "{}, {}, {} stages, {} intervals, {} controls",
                method.name, method.scheme, method.stages, method.intervals, method.control_shape
            ),
        ),
        ("status", solution.status.name().to_owned()),
        ("objective", format!("{:.10}", solution.objective)),
        ("final time", format!("{:.10} s", solution.horizon)),
        ("stationarity", solution.stationarity.name().to_owned()),
        (
            "distance of the re-simulation at the end",
            format!("{:.1e}", solution.resimulation_error),
        ),
        ("CPU time", seconds(solution.seconds)),
    ]
    .map(|(name, value)| [name.to_owned(), value])
    .into()
}

/// The result for people.
fn tables(chosen: &ChosenScene, method: &SolverSettings, solution: &Solution) -> String {
    let declaration = chosen.model.declaration();
    let mut text = format!("{}: {}\n\n", chosen.scene.name, chosen.scene.title);
    let _ = writeln!(text, "parameters    {}", chosen.parameters().join(", "));
    let _ = writeln!(
        text,
        "method        {}, {}, {}, {} of {}, {} controls, {}",
        method.name,
        method.scheme,
        counted(method.stages, "stage"),
        counted(method.intervals, "interval"),
        counted(method.elements, "element"),
        method.control_shape,
        counted(method.starts, "start")
    );
    let _ = writeln!(text, "status        {}", solution.status.name());
    if solution.motion.is_none() {
        text += &work(solution);
        return text;
    }
    let _ = writeln!(text, "objective     {:.10}", solution.objective);
    let _ = writeln!(text, "final time    {:.10} s", solution.horizon);
    let _ = writeln!(text, "stationarity  {}", solution.stationarity.name());
    let _ = writeln!(
        text,
        "re-simulated  {:.1e} away from the plan at the end\n",
        solution.resimulation_error
    );
    let rows = solution.planned_events.iter().map(|(time, kind, contact)| {
        let kind = match kind {
            EventKind::LiftOff => "lift off",
            _ => "impact",
        };
        vec![
            kind.to_owned(),
            declaration.contacts[*contact].name.to_owned(),
            format!("{time:.10}"),
        ]
    });
    text += &relaxed_and_optima(solution);
    text += &match rows.len() {
        0 => "no events\n".to_owned(),
        _ => table(["event", "contact", "time [s]"], rows),
    };
    text += "\n";
    let controls = declaration.controls.iter();
    let (place, intervals) = match solution.shape {
        ControlShape::Constant => (["interval", "from [s]"], solution.controls.len()),
        ControlShape::Linear => (["node", "at [s]"], solution.controls.len() - 1),
    };
    let header = place.map(str::to_owned).into_iter();
    let header = header.chain(controls.map(|control| headed(control.name, control.unit)));
    let length = solution.horizon / intervals.max(1) as f64;
    let rows = solution.controls.iter().enumerate().map(|(k, controls)| {
        let values = controls.iter().map(|u| format!("{u:.6}"));
        [k.to_string(), format!("{:.6}", k as f64 * length)]
            .into_iter()
            .chain(values)
            .collect()
    });
    text += &table(header, rows);
    text += "\n";
    let residuals = solution.residuals;
    let _ = writeln!(
        text,
        "residuals     primal {:.1e}, dual {:.1e}, complementarity {:.1e}",
        residuals.primal, residuals.dual, residuals.complementarity
    );
    text += &work(solution);
    text
}

/// What the result took.
fn work(solution: &Solution) -> String {
    let counts = solution.counts;
    format!(
        "counts        {}, {} + {}, {}, {}\nCPU time      {}\n",
        counted(counts.programs, "program"),
        counts.global_iterations,
        counted(counts.iterations, "interior point iteration"),
        counted(counts.factorizations, "factorization"),
        counted(counts.repairs, "repair"),
        seconds(solution.seconds)
    )
}

/// The complementarity problem before the polish, and the local optima of several starts.
fn relaxed_and_optima(solution: &Solution) -> String {
    let mut text = String::new();
    if let Some(report) = &solution.time_freezing {
        let size = report.size;
        let _ = writeln!(
            text,
            "time-freezing {}: objective {:.7}, violation {:.1e}, largest product {:.1e}; {} variables, {} rows, \
             {} pairs; {} iterations, {} of CPU time\n",
            report.status,
            report.objective,
            report.primal,
            report.complementarity,
            size.variables,
            size.equalities + size.inequalities,
            size.complementarities,
            report.iterations,
            seconds(report.seconds)
        );
    }
    if solution
        .optima
        .iter()
        .map(|o| o.starts.len())
        .sum::<usize>()
        > 1
    {
        let rows = solution.optima.iter().map(|optimum| {
            let starts: Vec<String> = optimum.starts.iter().map(usize::to_string).collect();
            vec![
                format!("{:.10}", optimum.objective),
                format!("{:.10}", optimum.horizon),
                optimum.status.name().to_owned(),
                optimum.stationarity.name().to_owned(),
                optimum.switches.to_string(),
                starts.join(" "),
            ]
        });
        let header = [
            "local optimum",
            "final time [s]",
            "status",
            "stationarity",
            "switches",
            "starts",
        ];
        text += &table(header, rows);
        text += "\n";
    }
    text
}
