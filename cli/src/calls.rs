//! The commands as calls on texts, for hosts without files and terminals, such as a page in a browser.
//!
//! A request and its answer are JSON texts. What a command prints with `--json` is the `result` of an answer, number
//! for number.

use clap::Parser as _;
use hangtime::model::{Model, VariableDeclaration};
use hangtime::ocp::Previous;
use hangtime_scene_files::{SceneError, TextMistake};
use serde::Deserialize;
use serde_json::value::RawValue;

use crate::Scene;
use crate::animation::motion;
use crate::arguments::{Arguments, Command};
use crate::explain;
use crate::failure::{BadInput, did_you_mean};
use crate::job::{Job, Run};
use crate::json::Object;
use crate::scene_file::{EXTENSION, entry};
use crate::settings::ChosenScene;

/// Progress is told this often [s].
const PATIENCE: f64 = 0.1;
/// The calls, by name.
const CALLS: [&str; 6] = ["check", "explain", "fmt", "page", "simulate", "solve"];

/// Answers calls, one after the other.
///
/// | call | answer |
/// |---|---|
/// | `check` | `scene` (names, units, values and equations) and `warnings`, or `mistakes` and `report` |
/// | `explain` | `text`, as the command prints it |
/// | `fmt` | `text`, the scene in the settled style |
/// | `page` | `text`, the page in Markdown about the mistake whose code is the `name` of the request |
/// | `simulate`, `solve` | `result` (the JSON of the command), `facts` (what its page tells), `motion` (what it plays), `warm` |
///
/// A `solve` whose request has `"warm": true` starts from the motion of the last one, where that was of the same scene, and says so by
/// `warm`; without it, it starts from nothing, as the command does.
///
/// A call that is refused has the answer `refusal`, one line that says what, where and how to mend it.
///
/// # Examples
/// ```
/// use hangtime_cli::Calls;
///
/// let text = "coordinates { z: m } lagrangian 1[kg]/2*dot(z)^2 - 9.81[N]*z \
///             surface floor: z >= 0 impact floor: inelastic start { z: 1 } horizon 1[s]";
/// let settings = ["--method", "event"];
/// let request = serde_json::json!({ "call": "simulate", "name": "ball", "text": text, "settings": settings });
/// let answer = Calls::default().answer(&request.to_string(), &mut |_, _| {});
/// let answer: serde_json::Value = serde_json::from_str(&answer)?;
/// let fall = answer["result"]["events"][0]["time"].as_f64().unwrap_or_default();
/// assert!((fall - (2.0 / 9.81_f64).sqrt()).abs() < 1e-9);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct Calls {
    /// The scene of the last call, so that a text is derived once while its parameters change.
    last: Option<Known>,
    /// The scene that was solved last, and its plan.
    plan: Option<(&'static Scene, Previous)>,
}

#[derive(Debug)]
struct Known {
    name: String,
    text: String,
    scene: &'static Scene,
}

/// What a host asks for.
#[derive(Deserialize)]
struct Request<'a> {
    /// One of [`CALLS`].
    call: &'a str,
    /// Name of the scene, as that of a file without its ending.
    name: String,
    /// The scene, as it would stand in a file.
    text: String,
    /// What would stand behind the scene on the command line.
    #[serde(default)]
    settings: Vec<String>,
    /// Whether a solve may start from the last plan.
    #[serde(default)]
    warm: bool,
}

impl From<BadInput> for Object {
    fn from(refusal: BadInput) -> Self {
        Self::default().with("refusal", refusal.to_string())
    }
}

/// A mistake, with its first and last place in the text in the units in which browsers count: UTF-16.
fn mistake_entry(text: &str, mistake: &TextMistake) -> Object {
    let before = |at: usize| text.get(..at).unwrap_or(text);
    let units = |at: usize| before(at).encode_utf16().count();
    let start = before(mistake.place.start);
    Object::default()
        .with("code", mistake.code)
        .with("message", &mistake.message)
        .with("warning", mistake.warning)
        .with(
            "place",
            [units(mistake.place.start), units(mistake.place.end)],
        )
        .with("line", start.matches('\n').count() + 1)
        .with(
            "column",
            start.chars().rev().take_while(|&c| c != '\n').count() + 1,
        )
}

/// What a scene declares. It is solvable where there is an objective, or are measurements to compare with.
fn scene_entry(scene: &Scene, model: &dyn Model) -> Object {
    let declaration = model.declaration();
    let entry = |name: &str, unit: &str, documentation: &str| {
        let object = Object::default().with("name", name).with("unit", unit);
        object.with("documentation", documentation)
    };
    let variables = |list: &[VariableDeclaration]| -> Vec<Object> {
        let entries = list.iter().map(|v| entry(v.name, v.unit, v.documentation));
        entries.collect()
    };
    let parameters = declaration.parameters.iter().map(|p| {
        let object = entry(p.name, p.unit, p.documentation).with("default", p.default);
        object.with("positive", p.positive)
    });
    let contacts = declaration.contacts.iter();
    let contacts = contacts.map(|c| entry(c.name, c.unit, c.documentation));
    let equations = declaration.equations.iter();
    let solvable =
        declaration.optimal_control.is_some() || !model.structure().experiments.is_empty();
    let coordinates = &declaration.coordinates[..declaration.mechanical()];
    Object::default()
        .with("name", scene.name)
        .with("title", scene.title)
        .with("parameters", parameters.collect::<Vec<_>>())
        .with("coordinates", variables(coordinates))
        .with("states", variables(declaration.states))
        .with("controls", variables(declaration.controls))
        .with("contacts", contacts.collect::<Vec<_>>())
        .with("solvable", solvable)
        .with(
            "equations",
            equations.map(|e| [e.left, e.right]).collect::<Vec<_>>(),
        )
}

fn text_entry(text: &str) -> Object {
    Object::default().with("text", text)
}

impl Calls {
    /// Answers a request. While a run goes on, `progress` is told how much of it is done, where that is known, and what
    /// is being done.
    pub fn answer(
        &mut self,
        request: &str,
        progress: &mut (dyn FnMut(Option<f64>, &str) + Send),
    ) -> String {
        let answer = match serde_json::from_str::<Request<'_>>(request) {
            Ok(request) => self.dispatch(&request, progress),
            Err(error) => Err(BadInput::new(format!(
                "the request is not understood: {error}; send call, name, text and settings as JSON"
            ))
            .into()),
        };
        let mut line = answer.unwrap_or_else(|refused| refused).text();
        line.pop();
        line
    }

    fn dispatch(
        &mut self,
        request: &Request<'_>,
        progress: &mut (dyn FnMut(Option<f64>, &str) + Send),
    ) -> Result<Object, Object> {
        if !CALLS.contains(&request.call) {
            return Err(BadInput::new(format!(
                "there is no call `{}`{} (calls: {})",
                request.call,
                did_you_mean(request.call, CALLS.into_iter()),
                CALLS.join(", ")
            ))
            .into());
        }
        if request.call == "page" {
            return mistake_page(&request.name);
        }
        if request.call == "fmt" {
            let file = format!("{}.{EXTENSION}", request.name);
            let formatted = hangtime_scene_files::format_text(&file, &request.text);
            let text = formatted.map_err(|error| refusal(&request.text, error))?;
            return Ok(text_entry(&text));
        }
        let scene = self.scene(request)?;
        let file = format!("scene.{EXTENSION}");
        let words = ["hangtime", request.call, &file].map(str::to_owned);
        let words = words.into_iter().chain(request.settings.iter().cloned());
        let arguments = Arguments::try_parse_from(words).map_err(BadInput::from)?;
        match arguments.command {
            Some(Command::Simulate(arguments)) => {
                let chosen = ChosenScene::new(scene, &arguments.scene.settings)?;
                Ok(done(Job::simulate(chosen, &arguments)?, false, progress)?.0)
            }
            Some(Command::Solve(arguments)) => {
                let chosen = ChosenScene::new(scene, &arguments.scene.settings)?;
                let mut job = Job::solve(chosen, &arguments)?;
                let warm = self.warm(scene, request.warm);
                if let Some(plan) = warm {
                    job.start_from(plan);
                }
                let (answer, run) = done(job, warm.is_some(), progress)?;
                if !run.is_estimate() {
                    self.plan = run.previous().map(|plan| (scene, plan.clone()));
                }
                Ok(answer)
            }
            Some(Command::Explain(arguments)) => {
                let chosen = ChosenScene::new(scene, &arguments.scene.settings)?;
                let text = explain::answer(&chosen, &arguments);
                Ok(text_entry(&text))
            }
            _ => {
                let text = scene.text.ok_or_else(|| BadInput::new("no scene"))?;
                let checked = Object::default().with("scene", scene_entry(scene, text));
                Ok(checked.with("warnings", text.warnings()))
            }
        }
    }

    /// The plan that a solve of a scene may start from, where it is asked to.
    fn warm(&self, scene: &'static Scene, asked: bool) -> Option<&Previous> {
        let (solved, plan) = self.plan.as_ref()?;
        (asked && std::ptr::eq(*solved, scene)).then_some(plan)
    }

    /// The scene of a request.
    fn scene(&mut self, request: &Request<'_>) -> Result<&'static Scene, Object> {
        let (name, text) = (&request.name, &request.text);
        if let Some(known) = &self.last
            && known.name == *name
            && known.text == *text
        {
            return Ok(known.scene);
        }
        let file = format!("{name}.{EXTENSION}");
        let derived = hangtime_scene_files::of_text(&file, text);
        let derived = derived.map_err(|error| refusal(text, error))?;
        let scene = entry(&file, derived);
        self.last = Some(Known {
            name: name.clone(),
            text: text.clone(),
            scene,
        });
        Ok(scene)
    }
}

/// The page about a mistake.
fn mistake_page(code: &str) -> Result<Object, Object> {
    match hangtime_dsl::explanation(code) {
        Some(page) => Ok(text_entry(page)),
        None => Err(BadInput::new(format!(
            "there is no page about `{code}`{}; give a code such as E03, or `syntax`",
            did_you_mean(code, hangtime_dsl::mistake_codes())
        ))
        .into()),
    }
}

/// Why a text is no scene.
fn refusal(text: &str, error: SceneError) -> Object {
    match error {
        SceneError::Mistakes { mistakes, report } => {
            let mistakes = mistakes.iter();
            let mistakes = mistakes.map(|mistake| mistake_entry(text, mistake));
            let mistaken = Object::default().with("mistakes", mistakes.collect::<Vec<_>>());
            mistaken.with("report", report)
        }
        other => BadInput::new(other.to_string()).into(),
    }
}

/// Runs a job and tells how far it is; what it came to.
fn done(
    job: Job,
    warm: bool,
    progress: &mut (dyn FnMut(Option<f64>, &str) + Send),
) -> Result<(Object, Run), BadInput> {
    let mut next = PATIENCE;
    let mut told = job.teller();
    let run = job.run(&mut |now| {
        if let Some((share, doing)) = told(now, now.seconds >= next) {
            next = now.seconds + PATIENCE;
            progress(share, &doing);
        }
        None
    })?;
    let model = run.chosen().model.as_ref();
    let drawn = run
        .motion()
        .and_then(|simulation| motion(run.drawing().as_ref(), model, simulation));
    let answer = Object::default()
        .with("result", raw(run.json()))
        .with("facts", run.facts())
        .with("motion", drawn.map(raw))
        .with("warm", warm);
    Ok((answer, run))
}

/// A document as a part of another one, digit for digit.
fn raw(document: String) -> Box<RawValue> {
    // Documents are JSON.
    RawValue::from_string(document.trim_end().to_owned()).unwrap_or_default()
}
