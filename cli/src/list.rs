//! `hangtime list`: the scenes by groups, and all about those that are named.

use std::fmt::Write as _;

use crate::{Question, Scene};
use hangtime::model::Model;
use serde::Serialize;

use crate::arguments::ListArguments;
use crate::failure::{BadInput, did_you_mean};
use crate::json::{SCHEMA, to_line};
use crate::report::Report;
use crate::scene_file::load_unread;
use crate::settings::{ChosenScene, find};
use crate::table::{described, headed, number};

#[derive(Serialize)]
struct Document {
    schema: u32,
    scenes: Vec<SceneEntry>,
}

#[derive(Serialize)]
struct SceneEntry {
    name: &'static str,
    title: &'static str,
    group: &'static str,
    #[serde(skip_serializing_if = "String::is_empty")]
    about: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    question: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    answer: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    known: Option<Known>,
    parameters: Vec<ParameterEntry>,
    variants: Vec<Vec<VariantEntry>>,
    /// The commands that work on the scene.
    commands: Vec<&'static str>,
}

/// The least objective known on a grid.
#[derive(Serialize)]
struct Known {
    intervals: usize,
    objective: f64,
}

#[derive(Serialize)]
struct ParameterEntry {
    name: &'static str,
    unit: &'static str,
    default: f64,
    documentation: &'static str,
}

#[derive(Serialize)]
struct VariantEntry {
    name: &'static str,
    choice: &'static str,
}

impl SceneEntry {
    fn of(scene: &'static Scene) -> Result<Self, BadInput> {
        let chosen = ChosenScene::new(scene, &[])?;
        let declaration = chosen.model.declaration();
        let question = scene.question;
        Ok(Self {
            name: scene.name,
            title: scene.title,
            group: scene.group,
            about: scene.about(),
            question: question.map(|question| question.asked),
            answer: question.map(|question| question.answer),
            known: question.map(|Question { known, .. }| Known {
                intervals: known.0,
                objective: known.1,
            }),
            parameters: declaration
                .parameters
                .iter()
                .map(|parameter| ParameterEntry {
                    name: parameter.name,
                    unit: parameter.unit,
                    default: parameter.default,
                    documentation: parameter.documentation,
                })
                .collect(),
            variants: scene
                .variants
                .iter()
                .filter(|variant| !variant.settings.is_empty())
                .map(|variant| {
                    variant
                        .settings
                        .iter()
                        .map(|&(name, choice)| VariantEntry { name, choice })
                        .collect()
                })
                .collect(),
            commands: commands(scene, &*chosen.model),
        })
    }
}

/// What can be done with a scene.
fn commands(scene: &Scene, model: &dyn Model) -> Vec<&'static str> {
    let planned = model.declaration().optimal_control.is_some();
    [
        ("simulate", true),
        (
            "solve",
            planned || !model.structure().experiments.is_empty(),
        ),
        ("chart", true),
        ("explain", true),
        ("reproduce", !scene.published.is_empty()),
    ]
    .into_iter()
    .filter_map(|(command, possible)| possible.then_some(command))
    .collect()
}

/// The scenes that are asked for: all without names and without a group.
fn asked(
    scenes: &'static [Scene],
    arguments: &ListArguments,
) -> Result<Vec<&'static Scene>, BadInput> {
    if let Some(group) = &arguments.group {
        let groups = groups(scenes.iter());
        if !groups.contains(&group.as_str()) {
            return Err(BadInput::new(format!(
                "--group {group}: no scene is in it{} (groups: {})",
                did_you_mean(group, groups.iter().copied()),
                groups.join(", ")
            )));
        }
    }
    let in_group = |scene: &&Scene| {
        let group = arguments.group.as_deref();
        group.is_none_or(|group| scene.group == group)
    };
    let named: Result<Vec<&Scene>, BadInput> = if arguments.scenes.is_empty() {
        Ok(scenes.iter().collect())
    } else {
        let names = arguments.scenes.iter();
        names.map(|name| find(scenes, name)).collect()
    };
    Ok(named?.into_iter().filter(in_group).collect())
}

/// The groups of scenes, in the order of the list.
fn groups<'s>(scenes: impl Iterator<Item = &'s Scene>) -> Vec<&'static str> {
    let mut groups = Vec::new();
    for scene in scenes {
        if !groups.contains(&scene.group) {
            groups.push(scene.group);
        }
    }
    groups
}

pub(crate) fn run(scenes: &'static [Scene], arguments: &ListArguments) -> Result<Report, BadInput> {
    let asked = asked(scenes, arguments)?;
    if !arguments.json && arguments.scenes.is_empty() {
        return Ok(Report::of(by_groups(&asked)));
    }
    let entries = asked.into_iter().map(|scene| {
        let read = match scene.unread {
            Some(text) => load_unread(scene, text)?,
            None => scene,
        };
        Ok(SceneEntry {
            // A scene that is read no longer has its text.
            about: scene.about(),
            ..SceneEntry::of(read)?
        })
    });
    let scenes: Vec<SceneEntry> = entries.collect::<Result<_, BadInput>>()?;
    let text = if arguments.json {
        to_line(&Document {
            schema: SCHEMA,
            scenes,
        })
    } else {
        scenes.iter().map(told).collect()
    };
    Ok(Report::of(text))
}

/// Names and titles of scenes, a table for each group.
fn by_groups(scenes: &[&'static Scene]) -> String {
    let mut text = String::new();
    for group in groups(scenes.iter().copied()) {
        let members = scenes.iter().filter(|scene| scene.group == group);
        let rows = members.map(|scene| vec![scene.name.to_owned(), scene.title.to_owned()]);
        let heading = if group.is_empty() { "scenes" } else { group };
        text += &described([heading, ""], rows);
        text.push('\n');
    }
    text + "hangtime list SCENE tells what a scene asks, its parameters, and what can be done with it\n"
}

/// All about a scene.
fn told(scene: &SceneEntry) -> String {
    let mut text = format!("{}\n  {}\n", scene.name, scene.title);
    for line in wrapped(&scene.about) {
        let _ = writeln!(text, "  {line}");
    }
    if let Some((question, answer)) = scene.question.zip(scene.answer) {
        let _ = writeln!(text, "  {question} {answer}");
    }
    if let Some(Known {
        intervals,
        objective,
    }) = scene.known
    {
        let objective = number(objective);
        let _ = match intervals {
            0 => writeln!(text, "  least misfit known: {objective}"),
            _ => writeln!(
                text,
                "  least objective known on {intervals} intervals: {objective}"
            ),
        };
    }
    let commands = scene.commands.join(", ");
    let _ = writeln!(text, "  for {commands}\n\n{}", parameters(scene));
    text
}

/// Lines of at most 100 letters, if no word is longer.
fn wrapped(text: &str) -> Vec<String> {
    const WIDTH: usize = 100;
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < WIDTH => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

fn parameters(scene: &SceneEntry) -> String {
    let numbers = scene.parameters.iter().map(|parameter| {
        vec![
            headed(parameter.name, parameter.unit),
            parameter.default.to_string(),
            parameter.documentation.trim().to_owned(),
        ]
    });
    let mut choices: Vec<Vec<String>> = Vec::new();
    for variant in scene.variants.iter().flatten() {
        match choices.iter_mut().find(|row| row[0] == variant.name) {
            Some(row) => row[2] = format!("{} or {}", row[2], variant.choice),
            None => choices.push(vec![
                variant.name.to_owned(),
                variant.choice.to_owned(),
                format!("Form of the scene: {}", variant.choice),
            ]),
        }
    }
    described(["parameter", "default", ""], numbers.chain(choices))
}
