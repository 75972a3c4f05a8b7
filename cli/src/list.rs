//! `hangtime list`: the scenes and their parameters.

use std::fmt::Write as _;

use crate::Scene;
use hangtime::model::Declaration;
use serde::Serialize;

use crate::arguments::ListArguments;
use crate::json::{SCHEMA, to_line};
use crate::report::Report;
use crate::table::{described, headed};

#[derive(Serialize)]
struct Document {
    schema: u32,
    scenes: Vec<SceneEntry>,
}

#[derive(Serialize)]
struct SceneEntry {
    name: &'static str,
    title: &'static str,
    parameters: Vec<ParameterEntry>,
    variants: Vec<Vec<VariantEntry>>,
    /// The commands that work on the scene.
    commands: Vec<&'static str>,
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
    /// `None` for a scene without a variant.
    fn of(scene: &Scene) -> Option<Self> {
        let model = (scene.variants.first()?.model)();
        let declaration = model.declaration();
        Some(Self {
            name: scene.name,
            title: scene.title,
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
            commands: commands(scene, declaration),
        })
    }
}

/// What can be done with a scene.
fn commands(scene: &Scene, declaration: &Declaration) -> Vec<&'static str> {
    [
        ("simulate", true),
        ("solve", declaration.optimal_control.is_some()),
        ("chart", true),
        ("explain", true),
        ("reproduce", !scene.published.is_empty()),
    ]
    .into_iter()
    .filter_map(|(command, possible)| possible.then_some(command))
    .collect()
}

pub(crate) fn run(scenes: &[Scene], arguments: &ListArguments) -> Report {
    let scenes: Vec<SceneEntry> = scenes.iter().filter_map(SceneEntry::of).collect();
    let text = if arguments.json {
        to_line(&Document {
            schema: SCHEMA,
            scenes,
        })
    } else {
        scenes.iter().fold(String::new(), |mut text, scene| {
            let _ = writeln!(
                text,
                "{}\n  {}\n  for {}\n\n{}",
                scene.name,
                scene.title,
                scene.commands.join(", "),
                parameters(scene)
            );
            text
        })
    };
    Report::of(text)
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
