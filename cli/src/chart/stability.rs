//! `hangtime chart --stability`: what every method makes of scenes on which methods fail.

use cpu_time::ProcessTime;
use hangtime::simulation::{InitialValueProblem, InputError, Simulation, SimulationStatus};

use super::study::{Reference, Study, charted, distance};
use crate::arguments::{ChartArguments, FormulationName, Method, MethodArguments};
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::method::ChosenMethod;
use crate::output::OutputDirectory;
use crate::page::{Fold, Page, Section};
use crate::progress::Progress;
use crate::report::Report;
use crate::scene_file::load_text;
use crate::settings::ChosenScene;
use crate::spreadsheet::csv_text;
use crate::table::table;
use crate::{HardScene, Right, Scene};

/// An error may be this many times its estimate.
const ESTIMATED: f64 = 10.0;
/// Relative error beyond which a run is wrong of whose error nothing is known.
const UNESTIMATED: f64 = 1e-2;
/// Error that is rounding, relative to the way at the largest velocity.
const ROUNDING: f64 = 1e-11;
/// Steps of the complementarity problem, whose own grid takes minutes.
const FEW: usize = 20;
/// CPU time after which a run counts as one that does not end [s].
const PATIENCE: f64 = 2.0;

/// What a method made of a scene.
#[derive(Debug, Clone, PartialEq)]
enum Verdict {
    /// As close as it says, with its relative error.
    Right(f64),
    /// Solved, and farther off than it says, or solved where there is no solution.
    Wrong(Option<f64>),
    /// Stopped with this status where it should have gone on.
    Stopped(&'static str),
    /// Stopped with this status, as is right.
    RightlyStopped(&'static str),
    /// Solved where there is no solution, with an error that it estimates to be as large as the motion.
    Disclaimed(f64),
    /// Still running after [`PATIENCE`].
    NoEnd,
    /// The method does not know a feature of the scene.
    NotApplicable,
    /// There is nothing to compare with.
    Unknown,
}

impl Verdict {
    fn cell(&self) -> String {
        match self {
            Self::Right(error) => format!("right {error:.0e}"),
            Self::Wrong(Some(error)) => format!("WRONG {error:.0e}"),
            Self::Wrong(None) => "WRONG solved".to_owned(),
            Self::Stopped(status) => format!("stopped {status}"),
            Self::RightlyStopped(status) => format!("right {status}"),
            Self::Disclaimed(estimate) => format!("disclaimed {estimate:.0e}"),
            Self::NoEnd => "no end".to_owned(),
            Self::NotApplicable => "not applicable".to_owned(),
            Self::Unknown => "-".to_owned(),
        }
    }
}

/// The methods, as they are without settings; the formulations that are to be compared with on the grid that is
/// theirs.
fn methods() -> Vec<(&'static str, MethodArguments)> {
    let of = |method| MethodArguments {
        method,
        ..MethodArguments::default()
    };
    let formulation = |formulation| MethodArguments {
        formulation: Some(formulation),
        ..MethodArguments::default()
    };
    vec![
        ("finite elements (default)", MethodArguments::default()),
        ("time-freezing", formulation(FormulationName::TimeFreezing)),
        (
            "complementarity, 20 steps",
            MethodArguments {
                steps: Some(FEW),
                ..formulation(FormulationName::Complementarity)
            },
        ),
        (
            "60 steps",
            MethodArguments {
                steps: Some(60),
                ..MethodArguments::default()
            },
        ),
        ("event-driven", of(Method::Event)),
        ("Moreau-Jean", of(Method::Moreau)),
        ("fixed steps", of(Method::Fixed)),
        ("smoothed", of(Method::Smooth)),
    ]
}

/// A line of the table.
struct Row {
    name: String,
    phenomenon: String,
    why: String,
    verdicts: Vec<Verdict>,
}

pub(super) fn run(
    scenes: &'static [Scene],
    hard: &'static [HardScene],
    arguments: &ChartArguments,
) -> Result<Report, BadInput> {
    let tried = tried(scenes, hard, arguments)?;
    if tried.is_empty() {
        return Err(BadInput::new(
            "this program knows no hard scenes; name scenes or scene files after `chart --stability`",
        ));
    }
    let directory = OutputDirectory::open(&arguments.out)?;
    let bounds = Bounds::watch("chart", &arguments.limits);
    let mut progress = Progress::new("stability", tried.len() as f64);
    let mut rows = Vec::with_capacity(tried.len());
    for (done, tried) in tried.iter().enumerate() {
        if bounds.asked().is_some() {
            break;
        }
        progress.say(&tried.name);
        rows.push(tried.row(&bounds)?);
        progress.reach((done + 1) as f64);
    }
    drop(progress);
    let mut report = Report {
        text: format!(
            "{}\n\n{}\n{}\n",
            INTRODUCTION,
            table(header(), rows.iter().map(Row::cells)),
            table(sums_header(), sums(&rows))
        ),
        ..Report::default()
    };
    report.diagnoses.extend(
        bounds
            .asked()
            .map(|stop| stop.line("chart", &arguments.limits)),
    );
    drop(bounds);
    let files = files(&rows, directory.pages());
    let written = report.deliver(directory, &files);
    report.text += &written;
    Ok(report)
}

const INTRODUCTION: &str = "\
    What every method makes of scenes on which methods fail, each run without settings. Right: as close to the right end as ten \
    times the estimated error; the number is the error relative to the largest coordinate. WRONG: solved, and farther off. \
    Disclaimed: solved where there is no motion, with an estimated error as large as the motion. Stopped: with a name for what happened. No end: not within 2 s of CPU time.";

fn header() -> Vec<String> {
    let mut header = vec!["scene".to_owned()];
    header.extend(methods().into_iter().map(|(name, _)| name.to_owned()));
    header
}

impl Row {
    fn cells(&self) -> Vec<String> {
        let mut cells = vec![self.name.clone()];
        cells.extend(self.verdicts.iter().map(Verdict::cell));
        cells
    }
}

fn sums_header() -> [&'static str; 7] {
    [
        "method",
        "right",
        "disclaimed",
        "wrong silently",
        "stopped",
        "no end",
        "not applicable",
    ]
}

/// How often each method comes to each verdict.
fn sums(rows: &[Row]) -> Vec<Vec<String>> {
    let methods = methods().into_iter().enumerate();
    let sums = methods.map(|(index, (name, _))| {
        let count = |is: &dyn Fn(&Verdict) -> bool| {
            let all = rows.iter().filter_map(|row| row.verdicts.get(index));
            all.filter(|verdict| is(verdict)).count().to_string()
        };
        vec![
            name.to_owned(),
            count(&|verdict| matches!(verdict, Verdict::Right(_) | Verdict::RightlyStopped(_))),
            count(&|verdict| matches!(verdict, Verdict::Disclaimed(_))),
            count(&|verdict| matches!(verdict, Verdict::Wrong(_))),
            count(&|verdict| matches!(verdict, Verdict::Stopped(_))),
            count(&|verdict| matches!(verdict, Verdict::NoEnd)),
            count(&|verdict| matches!(verdict, Verdict::NotApplicable)),
        ]
    });
    sums.collect()
}

fn files(rows: &[Row], pages: Vec<String>) -> Vec<(String, String)> {
    let (csv, html) = ("stability.csv", "stability.html");
    let data = csv_text(&header(), rows.iter().map(Row::cells));
    let reasons = rows
        .iter()
        .map(|row| vec![row.name.clone(), row.phenomenon.clone(), row.why.clone()]);
    let page = Page {
        title: "What methods do where methods fail".to_owned(),
        introduction: INTRODUCTION.to_owned(),
        links: pages.into_iter().filter(|page| page != html).collect(),
        sections: vec![
            Section {
                heading: "Sums".to_owned(),
                header: sums_header().map(str::to_owned).into(),
                rows: sums(rows),
                ..Section::default()
            },
            Section {
                heading: "Scene by scene".to_owned(),
                header: header(),
                rows: rows.iter().map(Row::cells).collect(),
                folds: vec![Fold {
                    title: "What happens in each scene, and why the right outcome is right"
                        .to_owned(),
                    header: ["scene", "what happens", "why"].map(str::to_owned).into(),
                    rows: reasons.collect(),
                    ..Fold::default()
                }],
                files: vec![(csv.to_owned(), "the table".to_owned())],
                ..Section::default()
            },
        ],
    };
    vec![(csv.to_owned(), data), (html.to_owned(), page.html())]
}

/// A scene, and what is right.
struct Tried {
    name: String,
    chosen: ChosenScene,
    problem: Result<InitialValueProblem, InputError>,
    right: Right,
    why: &'static str,
    /// What the scene of a list or a file is compared with.
    study: Option<Study>,
}

/// The hard scenes, or those that the arguments name.
fn tried(
    scenes: &'static [Scene],
    hard: &'static [HardScene],
    arguments: &ChartArguments,
) -> Result<Vec<Tried>, BadInput> {
    if !arguments.scenes.is_empty() {
        let charted = charted(scenes, arguments)?;
        let studies = charted.into_iter().flat_map(|charted| charted.studies);
        return studies.map(Tried::of_study).collect();
    }
    hard.iter()
        .map(|hard| {
            let scene = load_text(hard.name, hard.text)?;
            let chosen = ChosenScene::new(scene, &[])?;
            let model = chosen.model.as_ref();
            let problem = InitialValueProblem::of(model, arguments.horizon)
                .and_then(|problem| problem.check(model).map(|()| problem));
            let study = match hard.right {
                Right::Agreed => Some(Study::new(
                    ChosenScene::new(scene, &[])?,
                    arguments.horizon,
                    None,
                )?),
                Right::Formula(_) | Right::Stop => None,
            };
            Ok(Tried {
                name: hard.name.to_owned(),
                problem,
                right: hard.right,
                why: hard.why,
                study,
                chosen,
            })
        })
        .collect()
}

impl Tried {
    fn of_study(study: Study) -> Result<Self, BadInput> {
        let again: Vec<String> = Vec::new();
        Ok(Self {
            name: study.title(),
            chosen: ChosenScene::new(study.chosen.scene, &again)?,
            problem: Ok(study.problem.clone()),
            right: Right::Agreed,
            why: "the closed form of the scene, or two methods that agree at their tightest tolerances",
            study: Some(study),
        })
    }

    fn chosen(&self) -> &ChosenScene {
        self.study
            .as_ref()
            .map_or(&self.chosen, |study| &study.chosen)
    }

    fn row(&self, bounds: &Bounds) -> Result<Row, BadInput> {
        let model = self.chosen().model.as_ref();
        let (reference, uncertainty) = match (&self.problem, self.right, &self.study) {
            (Ok(problem), Right::Formula(formula), _) => {
                (Some(formula(model, problem.horizon)), 0.0)
            }
            (Ok(_), Right::Agreed, Some(study)) => match Reference::of(study, bounds)? {
                Ok(reference) => (Some(reference.coordinates), reference.uncertainty),
                Err(_) => (None, 0.0),
            },
            _ => (None, 0.0),
        };
        let verdicts = methods()
            .into_iter()
            .map(|(_, arguments)| {
                self.verdict(&arguments, reference.as_deref(), uncertainty, bounds)
            })
            .collect::<Result<_, _>>()?;
        Ok(Row {
            name: self.name.clone(),
            phenomenon: self.chosen().scene.title.to_owned(),
            why: self.why.to_owned(),
            verdicts,
        })
    }

    fn verdict(
        &self,
        arguments: &MethodArguments,
        reference: Option<&[f64]>,
        uncertainty: f64,
        bounds: &Bounds,
    ) -> Result<Verdict, BadInput> {
        let is_stop = matches!(self.right, Right::Stop);
        let Ok(problem) = &self.problem else {
            // Every method checks the problem before its first step.
            return Ok(if is_stop {
                Verdict::RightlyStopped("refused")
            } else {
                Verdict::Stopped("refused")
            });
        };
        let chosen = self.chosen();
        let method = ChosenMethod::from_arguments(arguments)?;
        let start = ProcessTime::try_now();
        let run = method.simulate(chosen.model.as_ref(), problem, &mut |_| {
            let spent = start
                .as_ref()
                .ok()
                .and_then(|start| start.try_elapsed().ok());
            bounds.asked().is_none() && spent.is_none_or(|spent| spent.as_secs_f64() < PATIENCE)
        });
        Ok(match run {
            Err(error) if error.is_unsupported() => Verdict::NotApplicable,
            Err(_) if is_stop => Verdict::RightlyStopped("refused"),
            Err(_) => Verdict::Stopped("refused"),
            Ok(run) => match &run.status {
                SimulationStatus::Interrupted(_) => Verdict::NoEnd,
                SimulationStatus::Solved if is_stop => match run.error_estimate {
                    Some(estimate) if ESTIMATED * estimate >= 1.0 => Verdict::Disclaimed(estimate),
                    _ => Verdict::Wrong(None),
                },
                SimulationStatus::Solved => reference.map_or(Verdict::Unknown, |reference| {
                    judged(&run, problem.horizon, reference, uncertainty)
                }),
                stopped if is_stop => Verdict::RightlyStopped(stopped.name()),
                stopped => Verdict::Stopped(stopped.name()),
            },
        })
    }
}

/// What a run is that reached the end.
fn judged(run: &Simulation, horizon: f64, reference: &[f64], uncertainty: f64) -> Verdict {
    let largest = |values: &mut dyn Iterator<Item = &f64>| {
        values.fold(0.0_f64, |largest, value| largest.max(value.abs()))
    };
    let trajectory = &run.trajectory;
    let size = largest(&mut trajectory.q.iter().flatten().chain(reference));
    let way = size.max(horizon * largest(&mut trajectory.v.iter().flatten()));
    let Some(end) = trajectory.q.last().filter(|_| size > 0.0) else {
        return Verdict::Right(0.0);
    };
    let error = distance(end, reference);
    let promised = run
        .error_estimate
        .map_or(UNESTIMATED, |estimate| ESTIMATED * estimate);
    if error <= (promised * size).max(ROUNDING * way) + uncertainty {
        Verdict::Right(error / size)
    } else {
        Verdict::Wrong(Some(error / size))
    }
}
