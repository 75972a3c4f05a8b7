//! `hangtime reproduce`: the published results beside exact ones and our own.

use std::fmt::Write as _;
use std::path::Path;

use hangtime::simulation::{EventKind, InitialValueProblem, InputError, Simulation};
use hangtime_models::{Plane, PublishedFigure, PublishedMarker, Scene, scenes};

use super::Report;
use super::arguments::{Method, MethodArguments, SchemeName};
use super::failure::BadInput;
use super::json::Document;
use super::method::ChosenMethod;
use super::motion::{coordinates_at, motion};
use super::output::OutputDirectory;
use super::page::{Page, Section};
use super::progress::Progress;
use super::settings::ChosenScene;
use super::simulate::diagnosis_line;
use super::spreadsheet::{csv_text, trajectory_csv};
use super::table::{seconds, table};

/// Tolerance of the event-driven run that the others are measured against: close to rounding error.
pub(crate) const EXACT_TOLERANCE: f64 = 1e-13;
/// A run is repeated until this much CPU time is spent [s]; the fastest run counts.
const TIMED_SECONDS: f64 = 0.02;
/// What a repetition counts at least [s], so that a coarse clock ends the repetitions too.
const SHORTEST_RUN: f64 = 1e-4;

/// The methods beside the published numbers: name, file, settings. The first one is the measure of
/// the others.
fn methods() -> [(&'static str, &'static str, MethodArguments); 4] {
    [
        (
            "exact (event, 1e-13)",
            "exact",
            MethodArguments {
                method: Method::Event,
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
        ("FESD defaults", "fesd", MethodArguments::default()),
    ]
}

pub(super) fn run(out: &Path) -> Result<Report, BadInput> {
    let directory = OutputDirectory::open(out)?;
    let figures: Vec<(&'static Scene, &'static PublishedFigure)> = scenes()
        .iter()
        .flat_map(|scene| scene.published.iter().map(move |figure| (scene, figure)))
        .collect();
    let mut progress = Progress::new("reproduce", figures.len() as f64);
    let mut report = Report::default();
    let mut files = Vec::new();
    let mut sections = Vec::new();
    for (done, (scene, figure)) in figures.into_iter().enumerate() {
        let reproduced = reproduce(scene, figure, &mut |share| {
            progress.reach(done as f64 + share);
        })?;
        report.text += &reproduced.text;
        report.diagnoses.extend(reproduced.diagnoses);
        files.extend(reproduced.files);
        sections.push(reproduced.section);
    }
    drop(progress);
    let page = Page {
        title: "hangtime: published results, reproduced".to_owned(),
        introduction:
            "Each figure shows a published simulation, its published time-lapse markers, \
            and the same motion computed here. The exact values come from an event-driven \
            integration at a tolerance close to rounding error."
                .to_owned(),
        sections,
    };
    files.push(("index.html".to_owned(), page.html()));
    directory.write(&files)?;
    let index = out.join("index.html");
    let _ = writeln!(report.text, "figures and data: {}", index.display());
    Ok(report)
}

/// One published figure, reproduced.
struct Reproduced {
    text: String,
    diagnoses: Vec<String>,
    files: Vec<(String, String)>,
    section: Section,
}

/// One method's run.
struct Run {
    name: &'static str,
    file: &'static str,
    method: ChosenMethod,
    simulation: Simulation,
    /// Position at the time of each published marker.
    markers: Vec<Option<[f64; 2]>>,
    /// Position at the end.
    last: Option<[f64; 2]>,
}

/// A figure, its scene, and the initial value problem behind it.
struct Case<'a> {
    chosen: ChosenScene,
    plane: &'a Plane,
    problem: InitialValueProblem,
    markers: Vec<PublishedMarker>,
}

impl<'a> Case<'a> {
    fn new(scene: &'static Scene, figure: &PublishedFigure) -> Result<Self, BadInput> {
        let settings = figure.settings.iter();
        let settings: Vec<String> = settings
            .map(|(name, value)| format!("{name}={value}"))
            .collect();
        let chosen = ChosenScene::new(scene.name, &settings)?;
        let plane = scene.plane.as_ref().ok_or_else(|| {
            BadInput::new(format!(
                "figure `{}`: its scene has no picture",
                figure.name
            ))
        })?;
        let problem = InitialValueProblem::of(chosen.model.as_ref(), None)
            .map_err(|error| chosen.refuse(&error))?;
        let markers = figure
            .markers()
            .map_err(|error| BadInput::new(error.to_string()))?;
        Ok(Self {
            chosen,
            plane,
            problem,
            markers,
        })
    }

    /// Position of the first body.
    fn position(&self, q: &[f64]) -> Option<[f64; 2]> {
        (self.plane.positions)(self.chosen.model.as_ref(), q)
            .first()
            .copied()
    }

    fn run(
        &self,
        name: &'static str,
        file: &'static str,
        arguments: &MethodArguments,
    ) -> Result<Run, BadInput> {
        let method = ChosenMethod::from_arguments(arguments)?;
        let refuse = |error| self.chosen.refuse(&error);
        let simulation = fastest(&self.chosen, &method, &self.problem).map_err(refuse)?;
        let trajectory = &simulation.trajectory;
        let mut markers = Vec::with_capacity(self.markers.len());
        for marker in &self.markers {
            let q = if arguments.tolerance.is_some() && marker.time > 0.0 {
                // Controlled steps are long: ending a run at the marker loses nothing to
                // interpolation.
                let problem = InitialValueProblem {
                    horizon: marker.time,
                    ..self.problem.clone()
                };
                let model = self.chosen.model.as_ref();
                let run = method
                    .simulate(model, &problem, &mut |_| {})
                    .map_err(refuse)?;
                run.trajectory.q.last().cloned()
            } else {
                coordinates_at(trajectory, marker.time)
            };
            markers.push(q.and_then(|q| self.position(&q)));
        }
        Ok(Run {
            name,
            file,
            last: trajectory.q.last().and_then(|q| self.position(q)),
            markers,
            method,
            simulation,
        })
    }
}

fn reproduce(
    scene: &'static Scene,
    figure: &PublishedFigure,
    progress: &mut dyn FnMut(f64),
) -> Result<Reproduced, BadInput> {
    let case = Case::new(scene, figure)?;
    let (chosen, plane, markers) = (&case.chosen, case.plane, &case.markers);
    let model = chosen.model.as_ref();
    let mut runs = Vec::new();
    let methods = methods();
    for (index, (name, file, arguments)) in methods.iter().enumerate() {
        runs.push(case.run(name, file, arguments)?);
        progress((index + 1) as f64 / methods.len() as f64);
    }

    let (header, rows) = comparison(&case, &runs);
    let deviation = markers
        .iter()
        .zip(&runs[0].markers)
        .filter_map(|(marker, exact)| Some((distance(marker.position, (*exact)?), marker.time)))
        .fold(
            (0.0, 0.0),
            |largest: (f64, f64), next| {
                if next.0 > largest.0 { next } else { largest }
            },
        );
    let remark = format!(
        "{}. Largest distance of a published marker from the exact motion: {:.2e} {} at t = {:.1} s.",
        figure.source, deviation.0, plane.unit, deviation.1
    );
    let text = format!(
        "{} ({})\n\n{}\n  {remark}\n\n",
        figure.title,
        chosen.parameters().join(", "),
        table(header.iter().map(String::as_str), rows.clone())
    );

    let ours = &runs[runs.len() - 1].simulation;
    let title = figure.title.to_owned();
    let interval = Some(1.0 / figure.marker_rate);
    let svg = motion(title, plane, model, ours, markers.clone(), interval).svg();
    let mut files = vec![(
        format!("{}_markers.csv", figure.name),
        markers_csv(plane.axes, markers, &runs),
    )];
    for run in &runs {
        let name = format!("{}_{}", figure.name, run.file);
        let settings = &run.method.settings;
        let document = Document::new(chosen, case.problem.horizon, settings, &run.simulation);
        files.push((format!("{name}.json"), document.text()));
        files.push((
            format!("{name}.csv"),
            trajectory_csv(model.declaration(), &run.simulation.trajectory),
        ));
    }
    files.push((format!("{}.svg", figure.name), svg.clone()));
    Ok(Reproduced {
        text,
        diagnoses: runs
            .iter()
            .filter_map(|run| diagnosis_line(chosen, &run.simulation))
            .collect(),
        section: Section {
            heading: figure.title.to_owned(),
            text: remark,
            figures: vec![svg],
            header,
            rows,
            files: files
                .iter()
                .map(|(name, _)| (name.clone(), name.clone()))
                .collect(),
        },
        files,
    })
}

/// Runs a simulation a few times and keeps the one with the least CPU time; the results are equal.
pub(crate) fn fastest(
    chosen: &ChosenScene,
    method: &ChosenMethod,
    problem: &InitialValueProblem,
) -> Result<Simulation, InputError> {
    let run = || method.simulate(chosen.model.as_ref(), problem, &mut |_| {});
    let mut best = run()?;
    let mut spent = best.seconds.total;
    while spent < TIMED_SECONDS {
        let next = run()?;
        spent += next.seconds.total.max(SHORTEST_RUN);
        if next.seconds.total < best.seconds.total {
            best = next;
        }
    }
    Ok(best)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Header and rows of the comparison, a column for each source: the published marker after the
/// landing, the switches, the end.
fn comparison(case: &Case<'_>, runs: &[Run]) -> (Vec<String>, Vec<Vec<String>>) {
    let axes = case.plane.axes;
    let end = case.problem.horizon;
    let landed = case.markers.iter().position(|marker| marker.impact);
    let at = landed.map_or(end, |index| case.markers[index].time);
    let mut header = vec![String::new(), "published".to_owned()];
    header.extend(runs.iter().map(|run| run.name.to_owned()));

    let none = || "-".to_owned();
    let number = |value: Option<f64>| value.map_or_else(none, |value| format!("{value:.10}"));
    let error = |place: Option<[f64; 2]>, exact: Option<[f64; 2]>| {
        let error = place.zip(exact).map(|(a, b)| distance(a, b));
        error.map_or_else(none, |value| format!("{value:.1e}"))
    };
    let row = |name: String, published: String, cell: &dyn Fn(&Run) -> String| {
        let computed = runs.iter().map(cell);
        [name, published].into_iter().chain(computed).collect()
    };
    let marker = landed.map(|index| case.markers[index].position);
    let here = |run: &Run| landed.map_or(run.last, |index| run.markers[index]);
    let event = |run: &Run, kind: EventKind| {
        let event = run
            .simulation
            .events
            .iter()
            .find(|event| event.kind == kind)?;
        Some((event.time, case.position(&event.q)?))
    };
    let exact = &runs[0];
    let itself = |run: &Run| std::ptr::eq(run, exact);
    let [y, z] = axes;
    let unit = case.plane.unit;
    let mut rows: Vec<Vec<String>> = Vec::new();
    for (axis, label) in axes.iter().enumerate() {
        rows.push(row(
            format!("{label} at {at:.1} s"),
            number(marker.map(|place| place[axis])),
            &|run| number(here(run).map(|place| place[axis])),
        ));
    }
    rows.push(row(
        format!("distance from exact [{unit}]"),
        error(marker, here(exact)),
        &|run| {
            if itself(run) {
                none()
            } else {
                error(here(run), here(exact))
            }
        },
    ));
    rows.push(row("lift-off at [s]".to_owned(), none(), &|run| {
        number(event(run, EventKind::LiftOff).map(|(time, _)| time))
    }));
    rows.push(row("impact at [s]".to_owned(), none(), &|run| {
        number(event(run, EventKind::Impact).map(|(time, _)| time))
    }));
    for (axis, label) in [y, z].into_iter().enumerate() {
        rows.push(row(format!("impact at {label}"), none(), &|run| {
            number(event(run, EventKind::Impact).map(|(_, place)| place[axis]))
        }));
    }
    rows.push(row(format!("{y} at {end} s"), none(), &|run| {
        number(run.last.map(|place| place[0]))
    }));
    rows.push(row(
        format!("distance from exact [{unit}]"),
        none(),
        &|run| {
            if itself(run) {
                none()
            } else {
                error(run.last, exact.last)
            }
        },
    ));
    rows.push(row("CPU time".to_owned(), none(), &|run| {
        seconds(run.simulation.seconds.total)
    }));
    (header, rows)
}

/// The published markers beside the computed positions.
fn markers_csv(axes: [&str; 2], markers: &[PublishedMarker], runs: &[Run]) -> String {
    let columns = |name: &str| axes.map(|axis| format!("{name} {axis}"));
    let mut header = vec!["time [s]".to_owned()];
    header.extend(columns("published"));
    header.extend(runs.iter().flat_map(|run| columns(run.file)));
    csv_text(
        &header,
        markers.iter().enumerate().map(|(index, marker)| {
            let computed = runs.iter().flat_map(|run| match run.markers[index] {
                Some(place) => place.map(|x| x.to_string()),
                None => [String::new(), String::new()],
            });
            let published = marker.position.map(|x| x.to_string());
            [marker.time.to_string()]
                .into_iter()
                .chain(published)
                .chain(computed)
                .collect()
        }),
    )
}
