//! `hangtime simulate`: one simulation, as tables, as JSON, and as files.

use std::fmt::Write as _;

use crate::{PublishedData, Scene};
use hangtime::simulation::{InitialValueProblem, Simulation};

use crate::arguments::SimulateArguments;
use crate::failure::BadInput;
use crate::files::ResultFiles;
use crate::json::Document;
use crate::method::ChosenMethod;
use crate::output::OutputDirectory;
use crate::progress::Progress;
use crate::report::Report;
use crate::settings::ChosenScene;
use crate::table::{counted, headed, per_second, seconds, table};

pub(crate) fn run(
    scenes: &'static [Scene],
    arguments: &SimulateArguments,
) -> Result<Report, BadInput> {
    let chosen = ChosenScene::from_arguments(scenes, &arguments.scene)?;
    let method = ChosenMethod::from_arguments(&arguments.method)?;
    let problem = InitialValueProblem::of(chosen.model.as_ref(), arguments.horizon)
        .and_then(|problem| problem.check(chosen.model.as_ref()).map(|()| problem))
        .map_err(|error| chosen.refuse(&error))?;
    let directory = arguments
        .out
        .as_deref()
        .map(OutputDirectory::open)
        .transpose()?;
    let mut progress = Progress::new(chosen.scene.name, problem.horizon);
    let simulation = method
        .simulate(chosen.model.as_ref(), &problem, &mut |now| {
            progress.reach(now.time);
            true
        })
        .map_err(|error| chosen.refuse(&error))?;
    drop(progress);
    let json = Document::new(&chosen, problem.horizon, &method.settings, &simulation).text();
    let mut written = String::new();
    if let Some(directory) = directory {
        let files = ResultFiles {
            stem: chosen.scene.name.to_owned(),
            title: format!("{}, {}", chosen.scene.name, method.settings.name()),
            chosen: &chosen,
            simulation: &simulation,
            json: &json,
            published: &PublishedData::default(),
            facts: facts(&method, &simulation),
        };
        for path in directory.write(&files.contents())? {
            let _ = writeln!(written, "wrote {}", path.display());
        }
    }
    let diagnoses = diagnosis_line(&chosen, &simulation).into_iter().collect();
    let text = if arguments.json {
        json
    } else {
        tables(&chosen, problem.horizon, &method, &simulation) + &written
    };
    Ok(Report { text, diagnoses })
}

/// Why a simulation stopped early, in one line, if it did.
pub(crate) fn diagnosis_line(chosen: &ChosenScene, simulation: &Simulation) -> Option<String> {
    let diagnosis = simulation.status.diagnosis()?;
    let text = format!(
        "{}: {} at t = {} s: {}",
        chosen.scene.name,
        simulation.status.name(),
        diagnosis.time,
        diagnosis.message
    );
    Some(text.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// What a page tells about a simulation.
pub(crate) fn facts(method: &ChosenMethod, simulation: &Simulation) -> Vec<[String; 2]> {
    let residuals = simulation.residuals;
    [
        ("method", method.settings.to_string()),
        ("status", simulation.status.name().to_owned()),
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

/// A number for people: ten decimals, or an exponent where they would fill the line.
fn digits(value: f64) -> String {
    if value.abs() < 5e-11 {
        // Rounding has a sign that means nothing.
        format!("{:.10}", 0.0)
    } else if value.abs() < 1e7 {
        format!("{value:.10}")
    } else {
        format!("{value:.10e}")
    }
}

/// The result for people.
fn tables(
    chosen: &ChosenScene,
    horizon: f64,
    method: &ChosenMethod,
    simulation: &Simulation,
) -> String {
    let declaration = chosen.model.declaration();
    let mut text = format!("{}: {}\n\n", chosen.scene.name, chosen.scene.title);
    let parameters = chosen.parameters();
    let _ = writeln!(text, "parameters  {}", parameters.join(", "));
    let _ = writeln!(text, "method      {}", method.settings);
    let _ = writeln!(text, "horizon     {horizon} s");
    let _ = writeln!(text, "status      {}\n", simulation.status.name());

    let mut header: Vec<String> = ["event", "contact", "time [s]"].map(str::to_owned).into();
    header.extend(
        declaration
            .coordinates
            .iter()
            .map(|c| headed(c.name, c.unit)),
    );
    header.extend(
        declaration
            .coordinates
            .iter()
            .map(|c| headed(&format!("d{}/dt", c.name), &per_second(c.unit))),
    );
    let rows = simulation.events.iter().map(|event| {
        let names = [
            event.kind.name().replace('_', " "),
            declaration.contacts[event.contact].name.to_owned(),
            digits(event.time),
        ];
        let states = event.q.iter().chain(&event.v_after).copied().map(digits);
        names.into_iter().chain(states).collect()
    });
    if simulation.events.is_empty() {
        text += "no events\n\n";
    } else {
        text += &table(header, rows);
        text += "  (velocities right after the event)\n\n";
    }

    let trajectory = &simulation.trajectory;
    if let (Some(&time), Some(q), Some(v)) = (
        trajectory.time.last(),
        trajectory.q.last(),
        trajectory.v.last(),
    ) {
        let _ = writeln!(text, "state at t = {time} s");
        let rows = declaration.coordinates.iter().enumerate().map(|(i, c)| {
            let unit = if c.unit.is_empty() { "1" } else { c.unit };
            vec![
                c.name.to_owned(),
                digits(q[i]),
                unit.to_owned(),
                digits(v[i]),
                per_second(c.unit),
            ]
        });
        text += &table(["coordinate", "value", "", "velocity", ""], rows);
        text += "\n";
    }

    let residuals = simulation.residuals;
    let _ = writeln!(
        text,
        "residuals   primal {:.1e}, dual {:.1e}, complementarity {:.1e}",
        residuals.primal, residuals.dual, residuals.complementarity
    );
    let counts = simulation.counts;
    let _ = writeln!(
        text,
        "counts      {}, {}, {}, {}, {} in {}",
        counted(counts.elements, "element"),
        counted(counts.newton, "Newton iteration"),
        counted(counts.factorizations, "factorization"),
        counted(counts.evaluations, "evaluation"),
        counted(counts.interior_point, "interior point iteration"),
        counted(counts.fallbacks, "fallback")
    );
    let _ = writeln!(text, "CPU time    {}", seconds(simulation.seconds.total));
    for note in &simulation.notes {
        let _ = writeln!(text, "note        {note}");
    }
    text
}
