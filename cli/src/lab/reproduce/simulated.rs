//! A published simulation by several methods.

use hangtime::simulation::{InitialValueProblem, Simulation};

use super::case::{Case, Reproduced};
use super::column::Column;
use super::comparison::{comparison, rows};
use super::motion::player;
use super::overview::{INDEX, section_of};
use crate::arguments::{Method, MethodArguments, SchemeName};
use crate::bounds::Bounds;
use crate::drawing::{Body, Drawing};
use crate::ending::Ending;
use crate::failure::BadInput;
use crate::files::ResultFiles;
use crate::json::simulation_document;
use crate::method::ChosenMethod;
use crate::sampling::dense;
use crate::spreadsheet::{csv_text, trajectory_csv};
use crate::task::simulation_facts;
use crate::timing::{EXACT_TOLERANCE, fastest};

/// The methods beside the published numbers: name, file, settings. The first one is ours, the second one the measure
/// of the published positions.
fn methods() -> [(&'static str, &'static str, MethodArguments); 4] {
    [
        (
            "FESD defaults",
            "fesd",
            MethodArguments {
                method: Some(Method::Fesd),
                ..MethodArguments::default()
            },
        ),
        (
            "event-driven, 1e-13",
            "exact",
            MethodArguments {
                method: Some(Method::Event),
                tolerance: Some(EXACT_TOLERANCE),
                ..MethodArguments::default()
            },
        ),
        (
            "FESD as in the paper",
            "fesd-paper",
            MethodArguments {
                scheme: Some(SchemeName::GaussLegendre),
                stages: Some(2),
                steps: Some(30),
                elements: Some(3),
                ..MethodArguments::default()
            },
        ),
        (
            "FESD to 1e-9",
            "fesd-1e-9",
            MethodArguments {
                stages: Some(6),
                steps: Some(5),
                tolerance: Some(1e-9),
                ..MethodArguments::default()
            },
        ),
    ]
}

/// Simulates the case by every method.
pub(super) fn reproduce(case: Case, horizon: f64, bounds: &Bounds) -> Result<Reproduced, BadInput> {
    let (chosen, published) = (&case.chosen, case.published);
    let model = chosen.model.as_ref();
    let refuse = |error| chosen.refuse(&error);
    let problem = InitialValueProblem::of(model, Some(horizon)).map_err(refuse)?;
    let (mut columns, mut diagnoses, mut files) = (Vec::new(), Vec::new(), Vec::new());
    for (index, (name, file, arguments)) in methods().into_iter().enumerate() {
        let method = ChosenMethod::from_arguments(&arguments)?;
        let simulation =
            fastest(chosen, &method, &problem, &|| bounds.asked().is_none()).map_err(refuse)?;
        let ending = Ending::of_whole(&simulation);
        diagnoses.extend(ending.line_of(chosen.scene.name, &simulation));
        let settings = &method.settings;
        let rows = usize::MAX;
        let json = simulation_document(
            chosen,
            (horizon, settings),
            (&simulation, None),
            &ending,
            rows,
        )
        .text();
        if index == 0 {
            let result = ResultFiles {
                stem: published.name.to_owned(),
                title: published.title.to_owned(),
                chosen,
                simulation: &simulation,
                json: &json,
                published: &case.data,
                rows: usize::MAX,
                index: Some(INDEX),
                facts: simulation_facts(&method, &simulation, &ending),
                charts: Vec::new(),
                further: Vec::new(),
            };
            files.extend(result.contents());
        } else {
            let stem = format!("{}_{file}", published.name);
            let csv = trajectory_csv(model, &simulation.trajectory, usize::MAX);
            files.push((format!("{stem}.json"), json));
            files.push((format!("{stem}-trajectory.csv"), csv));
        }
        columns.push(Column {
            name,
            residual: largest_residual(&simulation),
            // Controlled steps are long: ending a run at the instant loses nothing to interpolation.
            rerun: arguments.tolerance.map(|_| (method, problem.clone())),
            simulation,
        });
    }
    let ours = &columns[0];
    let exact = &columns[1];
    let rows = rows(&case, ours);
    let (header, table) = comparison(&case, &rows, &columns);
    let (remark, positions) = positions(&case, exact);
    files.push((format!("{}_positions.csv", published.name), positions));
    let remarks: Vec<String> = remark.into_iter().collect();
    let seconds = ours.simulation.seconds.total;
    let states = dense(model, &ours.simulation.trajectory);
    let residual = ours.residual;
    Ok(Reproduced {
        player: player(&case, &ours.simulation),
        section: section_of(published, &remarks, &files, header, table),
        case,
        states,
        rows,
        seconds,
        residual,
        remarks,
        diagnoses,
        files,
    })
}

fn largest_residual(simulation: &Simulation) -> f64 {
    let residuals = simulation.residuals;
    residuals
        .primal
        .max(residuals.dual)
        .max(residuals.complementarity)
}

/// How far the published positions are from the exact motion, in words and as a table.
fn positions(case: &Case, exact: &Column) -> (Option<String>, String) {
    let (model, name) = (case.chosen.model.as_ref(), case.chosen.scene.name);
    let Some(drawing) = Drawing::of(model, name) else {
        return (None, String::new());
    };
    let mut header = vec!["time [s]".to_owned()];
    for source in ["published", "exact"] {
        for Body { name, .. } in &drawing.bodies {
            let axes = drawing.axes.iter();
            header.extend(axes.map(|axis| format!("{source} {name} {axis}")));
        }
    }
    let mut largest: Option<(f64, f64)> = None;
    let mut rows = Vec::with_capacity(case.data.points.len());
    for point in &case.data.points {
        let mut row = vec![point.time.to_string()];
        row.extend(point.positions.as_flattened().iter().map(f64::to_string));
        if let Some(state) = exact.state_at(case, point.time) {
            let positions = drawing.at(&state).places;
            row.extend(positions.as_flattened().iter().map(f64::to_string));
            for (a, b) in positions.iter().zip(&point.positions) {
                let distance = (a[0] - b[0]).hypot(a[1] - b[1]);
                if largest.is_none_or(|(most, _)| distance > most) {
                    largest = Some((distance, point.time));
                }
            }
        }
        rows.push(row);
    }
    let remark = largest.map(|(distance, time)| {
        format!(
            "published positions are up to {distance:.1e} {} away from the exact motion (at t = {time:.2} s)",
            drawing.unit
        )
    });
    (remark, csv_text(&header, rows))
}
