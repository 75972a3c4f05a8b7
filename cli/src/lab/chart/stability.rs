//! `hangtime chart --stability`: what every method makes of scenes on which methods fail.

use cpu_time::ThreadTime;
use hangtime::simulation::{InitialValueProblem, InputError, Simulation, SimulationStatus};

use super::hard_optima;
use super::side_by_side::side_by_side;
use super::study::{Reference, Study, charted, distance, end};
use super::verdict::{Row, Verdict, reading, sums, sums_header};
use crate::arguments::{ChartArguments, FormulationName, Method, MethodArguments};
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::method::ChosenMethod;
use crate::output::OutputDirectory;
use crate::page::{Block, Page, Section};
use crate::report::Report;
use crate::scene::about;
use crate::scene_file::load_text;
use crate::settings::ChosenScene;
use crate::spreadsheet::csv_text;
use crate::table::table;
use crate::{HardOptimum, HardScene, Right, Scene};

/// A run is right whose error at the end is at most this share of the largest coordinate: a tenth of a millimetre a metre, which
/// a figure would not show, and ten times what the default tolerances ask for.
const BOUND: f64 = 1e-4;
/// A run says that it is rough where so many times its estimated error covers the error.
const ESTIMATED: f64 = 10.0;
/// Error that is rounding, relative to the way at the largest velocity.
const ROUNDING: f64 = 1e-11;
/// CPU time after which a run counts as one that does not end [s].
const PATIENCE: f64 = 2.0;

/// The methods, as they are without settings; the formulations that are to be compared with on the grid that is
/// theirs.
fn methods() -> Vec<(&'static str, MethodArguments)> {
    let of = |method| MethodArguments {
        method: Some(method),
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

pub(super) fn run(
    scenes: &'static [Scene],
    hard: &'static [HardScene],
    optima: &'static [HardOptimum],
    arguments: &ChartArguments,
) -> Result<Report, BadInput> {
    let tried = tried(scenes, hard, arguments)?;
    if tried.is_empty() {
        return Err(BadInput::new(
            "this program knows no hard scenes; name scenes or scene files after `chart --stability`",
        ));
    }
    let bounds = Bounds::watch("chart", &arguments.limits);
    let directory = OutputDirectory::open(&arguments.out)?;
    let mut tables = Tables {
        motions: side_by_side(
            "stability",
            &tried,
            &bounds,
            |tried| tried.name.clone(),
            |tried| tried.row(&bounds),
        )?,
        ..Tables::default()
    };
    if arguments.scenes.is_empty() {
        tables.optima = hard_optima::rows(optima, &bounds)?;
    }
    let mut report = Report {
        text: tables.text(),
        ..Report::default()
    };
    report.diagnoses.extend(
        bounds
            .asked()
            .map(|stop| stop.line("chart", &arguments.limits)),
    );
    drop(bounds);
    let files = files(&tables, directory.pages());
    let written = report.deliver(directory, &files);
    report.text += &written;
    Ok(report)
}

/// What was tried.
#[derive(Default)]
struct Tables {
    motions: Vec<Row>,
    optima: Vec<Row>,
}

impl Tables {
    fn text(&self) -> String {
        let of = |introduction, header: Vec<String>, rows: &[Row], sums| {
            format!(
                "{introduction}\n\n{}\n{}\n",
                table(header, rows.iter().map(Row::cells)),
                table(sums_header(), sums)
            )
        };
        let motions = of(INTRODUCTION, header(), &self.motions, self.motion_sums());
        if self.optima.is_empty() {
            return motions;
        }
        let header = hard_optima::header();
        let optima = of(
            hard_optima::INTRODUCTION,
            header,
            &self.optima,
            self.optimum_sums(),
        );
        format!("{motions}\n{optima}")
    }

    fn motion_sums(&self) -> Vec<Vec<String>> {
        sums(methods().into_iter().map(|(name, _)| name), &self.motions)
    }

    fn optimum_sums(&self) -> Vec<Vec<String>> {
        sums(hard_optima::names(), &self.optima)
    }
}

const INTRODUCTION: &str = "\
    What every method makes of scenes on which methods fail, each run without settings. Right: the end is within 1e-4 of the largest \
    coordinate of a reference, which is a closed form, or two methods at their tightest tolerances that agree; the number is the \
    error in the same measure. Handed over: right, by another method that takes over. Rough: farther off, and ten times the estimated error says so. WRONG: solved, and farther off than both. \
    Disclaimed: solved where there is no motion, with an estimated error as large as the motion. Stopped: with a name for what happened. No end: not within 2 s of CPU time. \
    A dash: no reference, since the two methods do not agree.";

fn header() -> Vec<String> {
    let mut header = vec!["scene".to_owned()];
    header.extend(methods().into_iter().map(|(name, _)| name.to_owned()));
    header
}

fn files(tables: &Tables, pages: Vec<String>) -> Vec<(String, String)> {
    let (csv, html) = ("stability.csv", "stability.html");
    let optima_csv = "stability-optima.csv";
    let optimum_header = hard_optima::header();
    let motions = (&header()[..], &tables.motions[..]);
    let mut lead = section("Motions", motions, tables.motion_sums(), INTRODUCTION);
    lead.files = vec![(csv.to_owned(), "the table".to_owned())];
    let data = csv_text(&header(), tables.motions.iter().map(Row::cells));
    let mut files = vec![(csv.to_owned(), data)];
    let mut sections = Vec::new();
    if !tables.optima.is_empty() {
        let data = csv_text(&optimum_header, tables.optima.iter().map(Row::cells));
        files.push((optima_csv.to_owned(), data));
        let rows = (&optimum_header[..], &tables.optima[..]);
        let about = hard_optima::INTRODUCTION;
        let mut own = section("Optima", rows, tables.optimum_sums(), about);
        own.files = vec![(optima_csv.to_owned(), "the table".to_owned())];
        sections.push(own);
    }
    let page = Page {
        title: "What methods do where methods fail".to_owned(),
        lead: vec![lead],
        sections,
        notes: Vec::new(),
        links: pages.into_iter().filter(|page| page != html).collect(),
    };
    files.push((html.to_owned(), page.html()));
    files
}

/// What to read off a table, its sums, the table, and what its words mean.
fn section(
    what: &str,
    (header, rows): (&[String], &[Row]),
    sums: Vec<Vec<String>>,
    about: &str,
) -> Section {
    let default = header.get(1).map_or("", String::as_str);
    Section {
        heading: what.to_owned(),
        blocks: vec![
            Block::Text(reading(default, 0, rows)),
            Block::table(sums_header(), sums),
            Block::Text(about.to_owned()),
            Block::table(header.to_vec(), rows.iter().map(Row::cells).collect()),
            Block::folded(
                "What happens in each scene, and why the right outcome is right",
                Block::table(
                    ["scene", "what happens", "why"],
                    rows.iter().map(Row::reason).collect(),
                ),
            ),
        ],
        ..Section::default()
    }
}

/// A scene, and what is right.
struct Tried {
    name: String,
    chosen: ChosenScene,
    problem: Result<InitialValueProblem, InputError>,
    right: Right,
    why: String,
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
                why: about(hard.text),
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
            why: "the closed form of the scene, or two methods that agree at their tightest tolerances".to_owned(),
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
            why: self.why.clone(),
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
        // The clock of this thread: other scenes run beside this one.
        let clock = || ThreadTime::try_now().map(|now| now.as_duration());
        let start = clock();
        let run = method.simulate(chosen.model.as_ref(), problem, &mut |_| {
            let spent = match (&start, clock()) {
                (Ok(start), Ok(now)) => Some(now.saturating_sub(*start)),
                _ => None,
            };
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
    let mechanical = run.declaration.mechanical();
    let coordinates = trajectory.q.iter().flat_map(|q| &q[..mechanical]);
    let states = trajectory.v.iter().flat_map(|v| &v[mechanical..]);
    let speeds = trajectory.v.iter().flat_map(|v| &v[..mechanical]);
    let size = largest(&mut coordinates.chain(states).chain(reference));
    let way = size.max(horizon * largest(&mut speeds.into_iter()));
    let Some(end) = end(run).filter(|_| size > 0.0) else {
        return Verdict::Right(0.0);
    };
    // What is not known as well as that says nothing of who is right.
    if uncertainty > BOUND * size {
        return Verdict::Unknown;
    }
    let error = distance(&end, reference);
    let kept = |share: f64| error <= (share * size).max(ROUNDING * way) + uncertainty;
    let relative = error / size;
    let estimated = run.error_estimate.map(|estimate| ESTIMATED * estimate);
    if kept(BOUND) && run.doubts.handed_over {
        Verdict::HandedOver(relative)
    } else if kept(BOUND) {
        Verdict::Right(relative)
    } else if estimated.is_some_and(kept) {
        Verdict::Rough(relative)
    } else {
        Verdict::Wrong(Some(relative))
    }
}
