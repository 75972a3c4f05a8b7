//! Scenes in the hands of another program, such as an interpreter: one object a scene, one a run.
//!
//! Words are those of the command line, and so are the numbers: [`HostRun::json`] is what `--json` prints.

use std::collections::BTreeMap;
use std::fmt;
use std::panic::{self, AssertUnwindSafe};
use std::sync::{Arc, Mutex};

use clap::{Args, CommandFactory as _};
use hangtime::Progress;
use hangtime::ocp::Previous;

use crate::Scene;
use crate::arguments::{Arguments, ExplainArguments, SimulateArguments, SolveArguments};
use crate::ending::Stop;
use crate::failure::BadInput;
use crate::job::{Job, Run as HostRun};
use crate::scene_file::{EXTENSION, entry, read_text};
use crate::settings::{ChosenScene, file_of, find};

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
        Ok(hosted(Job::simulate(chosen, &arguments)?, observer)?)
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
    /// intervals: its contact sequence is tried first, and the edits of its word where it leads to nothing.
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
        let mut job = Job::solve(chosen, &arguments)?;
        if let Some(previous) = previous {
            job.start_from(previous);
        }
        Ok(hosted(job, observer)?)
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

/// Runs a job in the hands of a host, until its limit on time and as long as the host answers true.
fn hosted(
    job: Job,
    observer: &mut (dyn FnMut(&Progress) -> bool + Send),
) -> Result<HostRun, BadInput> {
    let limit = job.limits().time_limit;
    guarded(|| {
        job.run(&mut |now| match limit {
            Some(limit) if now.seconds >= limit => Some(Stop::Time),
            _ => (!observer(now)).then_some(Stop::Interrupt),
        })
    })
}

/// A mistake in this program must not end the host.
pub(crate) fn guarded<T>(work: impl FnOnce() -> Result<T, BadInput>) -> Result<T, BadInput> {
    panic::catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        Err(BadInput::new(
            "internal_error: a mistake in this program, at the place above; please report it",
        ))
    })
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
        // As the command names them.
        assert!(files.iter().any(|(name, _)| name == "ball-event.html"));
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
