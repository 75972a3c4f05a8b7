//! Scenes in the hands of another program, such as an interpreter: one object a scene, one a run.
//!
//! Words are those of the command line, and so are the numbers: [`HostRun::json`] is what `--json` prints.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::panic::{self, AssertUnwindSafe};
use std::sync::{Arc, Mutex};

use clap::{Args, CommandFactory as _};
use hangtime::Progress;
use hangtime::estimation::Estimate;
use hangtime::ocp::{Previous, Solution};
use hangtime::simulation::{EventKind, Gradient, Simulation};

use crate::arguments::{
    Arguments, ExplainArguments, LimitArguments, SimulateArguments, SolveArguments,
};
use crate::drawing::Drawing;
use crate::ending::{Ending, Stop};
use crate::failure::BadInput;
use crate::files::ResultFiles;
use crate::fit;
use crate::json::{Columns, part, quantities};
use crate::numbers::ROWS;
use crate::sampling::{Side, State, extreme, largest_joint_force};
use crate::scene_file::{EXTENSION, entry, read_text};
use crate::settings::{ChosenScene, file_of, find};
use crate::task::{FitTask, OptimumTask, SimulationTask, optimum_facts, simulation_facts};
use crate::thumbnail::thumbnail;
use crate::{PublishedData, Quantity, Scene};

/// Why something was refused: what the command line prints on its standard error stream, without the last line end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal(String);

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refusal {}

impl From<BadInput> for Refusal {
    fn from(refusal: BadInput) -> Self {
        Self(match refusal {
            BadInput::Line(line) => format!("error: {line}"),
            BadInput::Report(report) => report,
        })
    }
}

/// A scene, derived once; copies are cheap.
#[derive(Debug, Clone)]
pub struct HostScene {
    scene: &'static Scene,
    /// The text of the scene, or the name of a shipped one: equal scenes have the same.
    identity: String,
    simulated: Recent<SimulateArguments>,
    solved: Recent<SolveArguments>,
}

/// The options of the last run and what they mean: those of the next one are mostly the same, and reading them takes as long as a
/// short run.
#[derive(Debug, Clone)]
struct Recent<A>(Arc<Mutex<Option<Known<A>>>>);

/// Options as words, and what they mean.
#[derive(Debug)]
struct Known<A> {
    options: Vec<String>,
    arguments: A,
}

impl<A> Default for Recent<A> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

/// How a setting begins that is one word.
const SETTING: &str = "--set=";

impl<A: Args + Clone> Recent<A> {
    /// The options among `words`, read, and the settings among them.
    fn read(
        &self,
        scene: &HostScene,
        command: &'static str,
        words: &[String],
    ) -> Result<(A, Vec<String>), BadInput> {
        let (settings, options): (Vec<&String>, Vec<&String>) =
            words.iter().partition(|word| word.starts_with(SETTING));
        let settings = settings.iter().map(|word| word[SETTING.len()..].to_owned());
        let settings = settings.collect();
        let mut recent = match self.0.lock() {
            Ok(recent) => recent,
            // A panic leaves what was there before.
            Err(poisoned) => poisoned.into_inner(),
        };
        if let Some(known) = &*recent
            && known.options.iter().eq(options.iter().copied())
        {
            return Ok((known.arguments.clone(), settings));
        }
        let options: Vec<String> = options.into_iter().cloned().collect();
        let arguments: A = scene.arguments(command, &options)?;
        *recent = Some(Known {
            options,
            arguments: arguments.clone(),
        });
        Ok((arguments, settings))
    }
}

/// Scenes that were derived, by file name and text: they stay in memory until the program ends, each once.
static DERIVED: Mutex<BTreeMap<(String, String), &'static Scene>> = Mutex::new(BTreeMap::new());

impl HostScene {
    /// The scene `name` of a list, or that of the file with this path.
    ///
    /// # Errors
    /// Where there is none, or its text has mistakes.
    pub fn open(scenes: &'static [Scene], name: &str) -> Result<Self, Refusal> {
        Ok(Self::find(scenes, name)?)
    }

    pub(crate) fn find(scenes: &'static [Scene], name: &str) -> Result<Self, BadInput> {
        if let Some(file) = file_of(scenes, name) {
            return Self::derive(&file, read_text(&file)?);
        }
        if let Some(text) = scenes
            .iter()
            .find(|scene| scene.name == name)
            .and_then(|scene| scene.unread)
        {
            return Self::derive(&format!("{name}.{EXTENSION}"), text.to_owned());
        }
        Ok(Self::new(find(scenes, name)?, name.to_owned()))
    }

    /// The scene of a text, as [`HostScene::open`] gives that of the file `name.hang`.
    ///
    /// # Errors
    /// The report on its mistakes.
    pub fn of_text(name: &str, text: &str) -> Result<Self, Refusal> {
        Ok(Self::derive(
            &format!("{name}.{EXTENSION}"),
            text.to_owned(),
        )?)
    }

    fn derive(file: &str, text: String) -> Result<Self, BadInput> {
        let key = (file.to_owned(), text.clone());
        let mut derived = match DERIVED.lock() {
            Ok(derived) => derived,
            // A panic while a scene was derived leaves the map as it was.
            Err(poisoned) => poisoned.into_inner(),
        };
        let scene = match derived.get(&key) {
            Some(scene) => scene,
            None => {
                let scene = guarded(|| {
                    hangtime_scene_files::of_text(file, &text).map_err(crate::scene_file::refusal)
                })?;
                let scene = entry(file, scene);
                derived.insert(key, scene);
                scene
            }
        };
        Ok(Self::new(scene, text))
    }

    fn new(scene: &'static Scene, identity: String) -> Self {
        Self {
            scene,
            identity,
            simulated: Recent::default(),
            solved: Recent::default(),
        }
    }

    /// Name of the scene.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.scene.name
    }

    /// What the scene is, in one line.
    #[must_use]
    pub fn title(&self) -> &'static str {
        self.scene.title
    }

    /// Warnings about its text, as the command line prints them; empty if there are none.
    #[must_use]
    pub fn warnings(&self) -> &'static str {
        self.scene.text.map_or("", |text| text.warnings())
    }

    /// The text of the scene, or the name of a shipped one.
    pub(crate) fn identity(&self) -> &str {
        &self.identity
    }

    /// The scene with settings `NAME=VALUE[UNIT]`.
    pub(crate) fn chosen(&self, settings: &[String]) -> Result<ChosenScene, BadInput> {
        ChosenScene::new(self.scene, settings)
    }

    /// Name, unit, value without settings, and documentation of every parameter.
    ///
    /// # Errors
    /// Where the scene cannot be made.
    pub fn parameters(
        &self,
    ) -> Result<Vec<(&'static str, &'static str, f64, &'static str)>, Refusal> {
        let chosen = self.chosen(&[])?;
        let parameters = chosen.model.declaration().parameters.iter().enumerate();
        let entry = |(index, p): (usize, &hangtime::model::ParameterDeclaration)| {
            (
                p.name,
                p.unit,
                chosen.model.parameter(index),
                p.documentation,
            )
        };
        Ok(parameters.map(entry).collect())
    }

    /// What `explain` prints, with the words behind the scene.
    ///
    /// # Errors
    /// Words that the command refuses.
    pub fn explain(&self, words: &[String]) -> Result<String, Refusal> {
        let arguments: ExplainArguments = self.arguments("explain", words)?;
        let chosen = self.chosen(&arguments.scene.settings)?;
        Ok(crate::explain::answer(&chosen, &arguments))
    }

    /// Simulates the scene with the words that stand behind it on the command line. The run goes on while `observer`
    /// answers true.
    ///
    /// # Errors
    /// Words and values that the command refuses.
    pub fn simulate(
        &self,
        words: &[String],
        observer: &mut (dyn FnMut(&Progress) -> bool + Send),
    ) -> Result<HostRun, Refusal> {
        let (mut arguments, settings) = self.simulated.read(self, "simulate", words)?;
        arguments.scene.settings.extend(settings);
        let chosen = self.chosen(&arguments.scene.settings)?;
        let task = SimulationTask::new(chosen, &arguments)?;
        let mut bound = Bound::new(&arguments.limits);
        let simulation = guarded(|| task.run(&mut |now| bound.goes_on(now, observer)))?;
        let gradient = task.gradient(&simulation)?;
        let ending = Ending::of_simulation(&simulation, bound.stop, &arguments.limits);
        Ok(HostRun {
            work: Work::Simulated(task, Box::new(simulation), gradient),
            ending,
        })
    }

    /// Solves its problem of optimal control, likewise.
    ///
    /// # Errors
    /// Words and values that the command refuses, and scenes without an objective.
    pub fn solve(
        &self,
        words: &[String],
        observer: &mut (dyn FnMut(&Progress) -> bool + Send),
    ) -> Result<HostRun, Refusal> {
        self.planned(words, None, observer)
    }

    /// As [`HostScene::solve`], from the motion of an earlier solve of the same scene, for other parameters or another number of
    /// intervals: its contact sequence is tried first, and contact-implicit programs where it leads to nothing.
    ///
    /// # Errors
    /// As [`HostScene::solve`], and where the earlier run has no plan, or one of another scene.
    pub fn solve_from(
        &self,
        words: &[String],
        before: &HostRun,
        observer: &mut (dyn FnMut(&Progress) -> bool + Send),
    ) -> Result<HostRun, Refusal> {
        let none = || {
            BadInput::new(
                "the start is a run without a plan; give the result of a solve that found a motion",
            )
        };
        let previous = before.previous().ok_or_else(none)?;
        self.planned(words, Some(previous), observer)
    }

    fn planned(
        &self,
        words: &[String],
        previous: Option<&Previous>,
        observer: &mut (dyn FnMut(&Progress) -> bool + Send),
    ) -> Result<HostRun, Refusal> {
        let (mut arguments, settings) = self.solved.read(self, "solve", words)?;
        arguments.scene.settings.extend(settings);
        let chosen = self.chosen(&arguments.scene.settings)?;
        if !chosen.model.experiments().is_empty() {
            return Ok(fitted(
                FitTask::new(chosen, &arguments)?,
                &arguments,
                observer,
            )?);
        }
        let mut task = OptimumTask::new(chosen, &arguments)?;
        if let Some(previous) = previous {
            task.start_from(previous);
        }
        let mut bound = Bound::new(&arguments.limits);
        let solution = guarded(|| task.run(&mut |now| bound.goes_on(now, observer)))?;
        let ending = Ending::of_bounded(&solution, bound.stop, &arguments.limits);
        Ok(HostRun {
            work: Work::Planned(task, Box::new(solution)),
            ending,
        })
    }

    /// The words behind the scene, read as the command reads them.
    pub(crate) fn arguments<A: Args>(
        &self,
        command: &'static str,
        words: &[String],
    ) -> Result<A, BadInput> {
        let parser = A::augment_args(clap::Command::new(command).no_binary_name(true));
        let scene = std::iter::once(self.scene.name);
        let words = scene.chain(words.iter().map(String::as_str));
        let matches = parser.try_get_matches_from(words)?;
        Ok(A::from_arg_matches(&matches)?)
    }
}

/// Names of the options of a command that take a value or stand alone, without dashes: what a host offers as keywords.
#[must_use]
pub fn options(command: &str) -> Vec<String> {
    let parser = Arguments::command();
    let options = parser.find_subcommand(command).into_iter();
    let options = options.flat_map(clap::Command::get_arguments);
    let names = options.filter_map(|option| option.get_long());
    names
        .filter(|name| !matches!(*name, "set" | "json" | "out" | "memory-limit" | "watch"))
        .map(str::to_owned)
        .collect()
}

/// What ends a run before its own end.
struct Bound {
    time_limit: Option<f64>,
    stop: Option<Stop>,
}

impl Bound {
    fn new(limits: &LimitArguments) -> Self {
        Self {
            time_limit: limits.time_limit,
            stop: None,
        }
    }

    fn goes_on(&mut self, now: &Progress, observer: &mut dyn FnMut(&Progress) -> bool) -> bool {
        if self.time_limit.is_some_and(|limit| now.seconds >= limit) {
            self.stop.get_or_insert(Stop::Time);
        } else if !observer(now) {
            self.stop.get_or_insert(Stop::Interrupt);
        }
        self.stop.is_none()
    }
}

/// A mistake in this program must not end the host.
pub(crate) fn guarded<T>(work: impl FnOnce() -> Result<T, BadInput>) -> Result<T, BadInput> {
    panic::catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        Err(BadInput::new(
            "internal_error: a mistake in this program, at the place above; please report it",
        ))
    })
}

/// The estimate of a scene that compares with measurements.
fn fitted(
    mut task: FitTask,
    arguments: &SolveArguments,
    observer: &mut (dyn FnMut(&Progress) -> bool + Send),
) -> Result<HostRun, BadInput> {
    let mut bound = Bound::new(&arguments.limits);
    let estimate = guarded(|| task.run(&mut |now| bound.goes_on(now, observer)))?;
    let ending = Ending::of_estimate(&estimate, bound.stop, &arguments.limits);
    Ok(HostRun {
        work: Work::Fitted(task, Box::new(estimate)),
        ending,
    })
}

enum Work {
    Simulated(SimulationTask, Box<Simulation>, Option<Gradient>),
    Planned(OptimumTask, Box<Solution>),
    Fitted(FitTask, Box<Estimate>),
}

/// A run that has ended.
pub struct HostRun {
    work: Work,
    ending: Ending,
}

impl fmt::Debug for HostRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HostRun")
            .field("ending", &self.ending)
            .finish_non_exhaustive()
    }
}

impl HostRun {
    /// Name of the status.
    #[must_use]
    pub fn status(&self) -> &'static str {
        self.ending.status
    }

    /// Why it did not end with a solution, in one line.
    #[must_use]
    pub fn diagnosis(&self) -> Option<&str> {
        self.ending.diagnosis.as_deref()
    }

    /// Whether parameters were estimated.
    #[must_use]
    pub fn is_estimate(&self) -> bool {
        matches!(self.work, Work::Fitted(..))
    }

    /// Whether there is a motion; a simulation always has one.
    #[must_use]
    pub fn has_motion(&self) -> bool {
        self.motion().is_some()
    }

    /// Whether the run ended with a solution.
    #[must_use]
    pub fn is_solved(&self) -> bool {
        match &self.work {
            Work::Simulated(_, simulation, _) => simulation.status.is_solved(),
            Work::Planned(_, solution) => solution.status.is_solved(),
            Work::Fitted(_, estimate) => estimate.status.is_solved(),
        }
    }

    /// Whether another solve can start from it: whether it is a solve that found a motion.
    #[must_use]
    pub fn is_start(&self) -> bool {
        self.previous().is_some()
    }

    fn previous(&self) -> Option<&Previous> {
        match &self.work {
            Work::Simulated(..) | Work::Fitted(..) => None,
            Work::Planned(_, solution) => solution.previous.as_ref(),
        }
    }

    /// A part of the trajectory by its name in the document, such as `q`, at the instants that the document has: numbers row after
    /// row. `None` where there is no such part, or no motion.
    #[must_use]
    pub fn part(&self, name: &str) -> Option<Columns> {
        let motion = self.motion()?;
        let (model, rows) = match &self.work {
            Work::Simulated(task, ..) => (&task.chosen.model, task.rows()),
            Work::Planned(task, _) => (&task.chosen.model, task.rows()),
            Work::Fitted(task, _) => (&task.chosen.model, task.rows()),
        };
        part(model.as_ref(), &motion.trajectory, rows, name)
    }

    /// Name and unit of every column of a part; a number has an empty unit.
    #[must_use]
    pub fn quantities(&self, part: &str) -> Vec<(String, String)> {
        quantities(self.chosen().model.as_ref(), part)
    }

    fn chosen(&self) -> &ChosenScene {
        match &self.work {
            Work::Simulated(task, ..) => &task.chosen,
            Work::Planned(task, _) => &task.chosen,
            Work::Fitted(task, _) => &task.chosen,
        }
    }

    fn motion(&self) -> Option<&Simulation> {
        match &self.work {
            Work::Simulated(_, simulation, _) => Some(simulation),
            Work::Planned(_, solution) => solution.motion.as_ref(),
            Work::Fitted(_, estimate) => estimate.experiments.first().map(|known| &known.motion),
        }
    }

    /// The value of a quantity at the end of the motion.
    pub(crate) fn last(&self, quantity: Quantity) -> Option<f64> {
        let trajectory = &self.motion()?.trajectory;
        let last = trajectory.time.len().checked_sub(1)?;
        State::of(self.chosen().model.as_ref(), trajectory, last).value(quantity)
    }

    /// Its largest or its smallest value along the motion.
    pub(crate) fn extreme(&self, quantity: Quantity, side: Side) -> Option<f64> {
        let model = self.chosen().model.as_ref();
        extreme(model, &self.motion()?.trajectory, quantity, side)
    }

    /// When an event of a kind happens at a contact for the `count`-th time, from 1 \[s\].
    pub(crate) fn event_time(&self, kind: EventKind, contact: usize, count: usize) -> Option<f64> {
        let events = self.motion()?.events.iter();
        let mut events = events.filter(|event| event.kind == kind && event.contact == contact);
        events.nth(count.checked_sub(1)?).map(|event| event.time)
    }

    /// The largest force of a joint along the motion, by its equations among those of all joints.
    pub(crate) fn joint_force(&self, rows: &Range<usize>) -> Option<f64> {
        let model = self.chosen().model.as_ref();
        largest_joint_force(model, &self.motion()?.trajectory, rows)
    }

    /// A small picture of the motion as SVG, for lists of scenes; `None` where nothing moved.
    #[must_use]
    pub fn thumbnail(&self) -> Option<String> {
        let chosen = self.chosen();
        let model = chosen.model.as_ref();
        let drawing = Drawing::of(model, chosen.scene.name);
        thumbnail(drawing.as_ref(), model, self.motion()?)
    }

    /// What the command prints with `--json`, in one line.
    #[must_use]
    pub fn json(&self) -> String {
        match &self.work {
            Work::Simulated(task, simulation, gradient) => {
                task.json(simulation, gradient.as_ref(), &self.ending)
            }
            Work::Planned(task, solution) => task.json(solution, &self.ending),
            Work::Fitted(task, estimate) => task.json(estimate, &self.ending),
        }
    }

    /// The files that the command writes with `--out`, as (name, content): data, figures, and a page that plays the
    /// motion. Without a motion only the JSON document.
    #[must_use]
    pub fn files(&self) -> Vec<(String, String)> {
        let json = self.json();
        let (chosen, title, facts) = match &self.work {
            Work::Simulated(task, simulation, _) => (
                &task.chosen,
                task.method.settings.name().to_owned(),
                simulation_facts(&task.method, simulation, &self.ending),
            ),
            Work::Planned(task, solution) => (
                &task.chosen,
                "optimal".to_owned(),
                optimum_facts(&task.method, solution, &self.ending),
            ),
            Work::Fitted(task, estimate) => {
                return fit::files(&task.chosen, estimate, (&json, &self.ending), ROWS);
            }
        };
        let stem = chosen.scene.name.to_owned();
        let Some(simulation) = self.motion() else {
            return vec![(format!("{stem}.json"), json)];
        };
        ResultFiles {
            title: format!("{stem}, {title}"),
            stem,
            chosen,
            simulation,
            json: &json,
            published: &PublishedData::default(),
            rows: ROWS,
            index: None,
            facts,
            charts: Vec::new(),
            further: Vec::new(),
        }
        .contents()
    }
}

#[cfg(test)]
mod tests {
    use super::HostScene;

    const BALL: &str = "coordinates { z: m } lagrangian 1[kg]/2*dot(z)^2 - 9.81[N]*z \
        surface floor: z >= 0 impact floor: inelastic start { z: 1 } horizon 1[s]";

    #[test]
    fn run_of_a_host_lands_at_the_time_of_the_formula_and_gives_all_files() {
        let ball = HostScene::of_text("ball", BALL).unwrap();
        let run = ball
            .simulate(&["--method".into(), "event".into()], &mut |_| true)
            .unwrap();
        let json: serde_json::Value = serde_json::from_str(&run.json()).unwrap();
        let fall = json["events"][0]["time"].as_f64().unwrap();
        assert!((fall - (2.0 / 9.81_f64).sqrt()).abs() < 1e-9);
        let files = run.files();
        assert!(files.iter().any(|(name, _)| name == "ball.html"));
    }

    #[test]
    fn host_that_says_stop_gets_what_there_is_and_a_refusal_reads_as_printed() {
        let ball = HostScene::of_text("ball", BALL).unwrap();
        let run = ball.simulate(&[], &mut |_| false).unwrap();
        assert_eq!(run.status(), "interrupted");
        let words = ["--set".to_owned(), "mass=2".to_owned()];
        let refusal = ball
            .simulate(&words, &mut |_| true)
            .unwrap_err()
            .to_string();
        assert!(
            refusal.starts_with("error: scene `ball` has no parameter `mass`"),
            "{refusal}"
        );
        let again = HostScene::of_text("ball", BALL).unwrap();
        assert!(std::ptr::eq(again.scene, ball.scene), "derived twice");
    }
}
