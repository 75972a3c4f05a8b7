//! The commands as calls on texts, for hosts without files and terminals, such as a page in a browser.
//!
//! A request and its answer are JSON texts. What a command prints with `--json` is the `result` of an answer, number
//! for number.

use clap::Parser as _;
use hangtime::model::{Declaration, Model as _};
use hangtime::simulation::Simulation;
use hangtime_scene_files::{SceneError, TextMistake};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use crate::Scene;
use crate::animation::motion;
use crate::arguments::{Arguments, Command};
use crate::drawing::Drawing;
use crate::ending::Ending;
use crate::explain;
use crate::failure::{BadInput, did_you_mean};
use crate::json::to_line;
use crate::scene_file::{EXTENSION, entry};
use crate::settings::ChosenScene;
use crate::task::{OptimumTask, SimulationTask, optimum_facts, simulation_facts};

/// Progress is told this often [s].
const PATIENCE: f64 = 0.1;
/// The calls, by name.
const CALLS: [&str; 5] = ["check", "explain", "fmt", "simulate", "solve"];

/// Answers calls, one after the other.
///
/// | call | answer |
/// |---|---|
/// | `check` | `scene` (names, units, values and equations) and `warnings`, or `mistakes` and `report` |
/// | `explain` | `text`, as the command prints it |
/// | `fmt` | `text`, the scene in the settled style |
/// | `simulate`, `solve` | `result` (the JSON of the command), `facts` (what its page tells), `motion` (what it plays) |
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
}

/// What a host gets.
#[derive(Serialize)]
#[serde(untagged)]
enum Answer {
    Checked {
        scene: Box<SceneEntry>,
        warnings: String,
    },
    Mistaken {
        mistakes: Vec<MistakeEntry>,
        report: String,
    },
    Text {
        text: String,
    },
    Done {
        result: Box<RawValue>,
        facts: Vec<[String; 2]>,
        motion: Option<Box<RawValue>>,
    },
    Refused {
        refusal: String,
    },
}

impl From<BadInput> for Answer {
    fn from(refusal: BadInput) -> Self {
        Self::Refused {
            refusal: refusal.to_string(),
        }
    }
}

#[derive(Serialize)]
struct MistakeEntry {
    code: Option<&'static str>,
    message: String,
    warning: bool,
    /// First and last place in the text, in the units in which browsers count: UTF-16.
    place: [usize; 2],
    line: usize,
    column: usize,
}

impl MistakeEntry {
    fn new(text: &str, mistake: &TextMistake) -> Self {
        let before = |at: usize| text.get(..at).unwrap_or(text);
        let units = |at: usize| before(at).encode_utf16().count();
        let start = before(mistake.place.start);
        Self {
            code: mistake.code,
            message: mistake.message.clone(),
            warning: mistake.warning,
            place: [units(mistake.place.start), units(mistake.place.end)],
            line: start.matches('\n').count() + 1,
            column: start.chars().rev().take_while(|&c| c != '\n').count() + 1,
        }
    }
}

#[derive(Serialize)]
struct SceneEntry {
    name: &'static str,
    title: &'static str,
    parameters: Vec<NumberEntry>,
    coordinates: Vec<NameEntry>,
    controls: Vec<NameEntry>,
    contacts: Vec<NameEntry>,
    /// Whether there is an optimal control problem.
    solvable: bool,
    equations: Vec<[&'static str; 2]>,
}

#[derive(Serialize)]
struct NumberEntry {
    #[serde(flatten)]
    name: NameEntry,
    default: f64,
    positive: bool,
}

#[derive(Serialize)]
struct NameEntry {
    name: &'static str,
    unit: &'static str,
    documentation: &'static str,
}

impl SceneEntry {
    fn new(scene: &Scene, declaration: &Declaration) -> Self {
        let variables = |list: &[hangtime::model::VariableDeclaration]| {
            let entries = list.iter().map(|v| NameEntry {
                name: v.name,
                unit: v.unit,
                documentation: v.documentation,
            });
            entries.collect()
        };
        let parameters = declaration.parameters.iter().map(|p| NumberEntry {
            name: NameEntry {
                name: p.name,
                unit: p.unit,
                documentation: p.documentation,
            },
            default: p.default,
            positive: p.positive,
        });
        let contacts = declaration.contacts.iter().map(|c| NameEntry {
            name: c.name,
            unit: c.unit,
            documentation: c.documentation,
        });
        let equations = declaration.equations.iter();
        Self {
            name: scene.name,
            title: scene.title,
            parameters: parameters.collect(),
            coordinates: variables(&declaration.coordinates[..declaration.mechanical()]),
            controls: variables(declaration.controls),
            contacts: contacts.collect(),
            solvable: declaration.optimal_control.is_some(),
            equations: equations.map(|e| [e.left, e.right]).collect(),
        }
    }
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
        let mut line = to_line(&answer.unwrap_or_else(|refused| refused));
        line.pop();
        line
    }

    fn dispatch(
        &mut self,
        request: &Request<'_>,
        progress: &mut (dyn FnMut(Option<f64>, &str) + Send),
    ) -> Result<Answer, Answer> {
        if !CALLS.contains(&request.call) {
            return Err(BadInput::new(format!(
                "there is no call `{}`{} (calls: {})",
                request.call,
                did_you_mean(request.call, CALLS.into_iter()),
                CALLS.join(", ")
            ))
            .into());
        }
        if request.call == "fmt" {
            let file = format!("{}.{EXTENSION}", request.name);
            let formatted = hangtime_scene_files::format_text(&file, &request.text);
            let text = formatted.map_err(|error| refusal(&request.text, error))?;
            return Ok(Answer::Text { text });
        }
        let scene = self.scene(request)?;
        let file = format!("scene.{EXTENSION}");
        let words = ["hangtime", request.call, &file].map(str::to_owned);
        let words = words.into_iter().chain(request.settings.iter().cloned());
        let arguments = Arguments::try_parse_from(words).map_err(BadInput::from)?;
        match arguments.command {
            Some(Command::Simulate(arguments)) => {
                let chosen = ChosenScene::new(scene, &arguments.scene.settings)?;
                let task = SimulationTask::new(chosen, &arguments)?;
                Ok(simulated(&task, progress)?)
            }
            Some(Command::Solve(arguments)) => {
                let chosen = ChosenScene::new(scene, &arguments.scene.settings)?;
                let mut task = OptimumTask::new(chosen, &arguments)?;
                Ok(solved(&mut task, progress)?)
            }
            Some(Command::Explain(arguments)) => {
                let chosen = ChosenScene::new(scene, &arguments.scene.settings)?;
                let text = explain::answer(&chosen, &arguments);
                Ok(Answer::Text { text })
            }
            _ => {
                let text = scene.text.ok_or_else(|| BadInput::new("no scene"))?;
                Ok(Answer::Checked {
                    scene: Box::new(SceneEntry::new(scene, text.declaration())),
                    warnings: text.warnings().to_owned(),
                })
            }
        }
    }

    /// The scene of a request.
    fn scene(&mut self, request: &Request<'_>) -> Result<&'static Scene, Answer> {
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

/// Why a text is no scene.
fn refusal(text: &str, error: SceneError) -> Answer {
    match error {
        SceneError::Mistakes { mistakes, report } => {
            let mistakes = mistakes.iter();
            let mistakes = mistakes.map(|mistake| MistakeEntry::new(text, mistake));
            Answer::Mistaken {
                mistakes: mistakes.collect(),
                report,
            }
        }
        other => BadInput::new(other.to_string()).into(),
    }
}

fn simulated(
    task: &SimulationTask,
    progress: &mut (dyn FnMut(Option<f64>, &str) + Send),
) -> Result<Answer, BadInput> {
    let horizon = task.problem.horizon;
    let mut next = PATIENCE;
    let simulation = task.run(&mut |now| {
        if now.seconds >= next {
            next = now.seconds + PATIENCE;
            progress(Some(now.time / horizon), &now.to_string());
        }
        true
    })?;
    let gradient = task.gradient(&simulation)?;
    let ending = Ending::of_whole(&simulation);
    Ok(Answer::Done {
        result: raw(task.json(&simulation, gradient.as_ref(), &ending)),
        facts: simulation_facts(&task.method, &simulation, &ending),
        motion: drawn(&task.chosen, Some(&simulation)),
    })
}

fn solved(
    task: &mut OptimumTask,
    progress: &mut (dyn FnMut(Option<f64>, &str) + Send),
) -> Result<Answer, BadInput> {
    let mut next = PATIENCE;
    let solution = task.run(&mut |now| {
        if now.seconds >= next {
            next = now.seconds + PATIENCE;
            progress(None, &now.to_string());
        }
        true
    })?;
    let ending = Ending::of(&solution);
    Ok(Answer::Done {
        result: raw(task.json(&solution, &ending)),
        facts: optimum_facts(&task.method, &solution, &ending),
        motion: drawn(&task.chosen, solution.motion.as_ref()),
    })
}

fn drawn(chosen: &ChosenScene, simulation: Option<&Simulation>) -> Option<Box<RawValue>> {
    let model = chosen.model.as_ref();
    let drawing = Drawing::of(model, chosen.scene.name);
    motion(drawing.as_ref(), model, simulation?).map(raw)
}

/// A document as a part of another one, digit for digit.
fn raw(document: String) -> Box<RawValue> {
    // Documents are JSON.
    RawValue::from_string(document.trim_end().to_owned()).unwrap_or_default()
}
