//! `SCENE` and `--set NAME=VALUE[UNIT]`: from words to a model.

use std::path::Path;

use crate::Scene;
use hangtime::model::Model;
use hangtime::simulation::InputError;
use hangtime_scene_files::TextScene;
use hangtime_units::{Quantity, UnitError};

use crate::arguments::SceneArguments;
use crate::failure::{BadInput, did_you_mean};
use crate::scene_file::{EXTENSION, is_path, load, load_changed, load_unread};
use crate::table::number;

/// A scene with its settings applied.
pub(crate) struct ChosenScene {
    /// The entry in the list of scenes.
    pub(crate) scene: &'static Scene,
    /// Its model.
    pub(crate) model: Box<dyn Model>,
    /// The settings that chose the form of the scene.
    pub(crate) choices: &'static [(&'static str, &'static str)],
    /// The parameters (indices) that the settings gave a value.
    pub(crate) given: Vec<usize>,
}

impl ChosenScene {
    /// Finds the scene and applies the settings.
    pub(crate) fn from_arguments(
        scenes: &'static [Scene],
        arguments: &SceneArguments,
    ) -> Result<Self, BadInput> {
        Self::new(find(scenes, &arguments.scene)?, &arguments.settings)
    }

    /// Applies `settings`, each `NAME=VALUE[UNIT]`, to a scene.
    pub(crate) fn new(scene: &'static Scene, settings: &[String]) -> Result<Self, BadInput> {
        let mut pairs = split_all(settings)?;
        let scene = with_counts(scene, &mut pairs)?;
        let (choices, model) = choose(scene, &pairs)?;
        let mut chosen = Self {
            scene,
            model,
            choices,
            given: Vec::new(),
        };
        for (name, value) in pairs {
            if !choices.iter().any(|&(choice, _)| choice == name) {
                chosen.set(name, value)?;
            }
        }
        chosen.check_bounds()?;
        chosen.check_coefficients()?;
        Ok(chosen)
    }

    /// Refuses coefficients that the laws of contact do not allow.
    fn check_coefficients(&self) -> Result<(), BadInput> {
        for (index, contact) in self.model.declaration().contacts.iter().enumerate() {
            let laws = [
                ("restitution", self.model.restitution(index), 1.0),
                (
                    "coefficient of friction",
                    self.model.friction(index),
                    f64::MAX,
                ),
            ];
            for (what, value, most) in laws {
                if !(0.0..=most).contains(&value) {
                    let range = if most == 1.0 {
                        "in 0..=1"
                    } else {
                        "at least 0"
                    };
                    return Err(BadInput::new(format!(
                        "scene `{}`: {what} of `{}` (E10) = {value}: must be {range}, for these parameters",
                        self.scene.name, contact.name
                    )));
                }
            }
        }
        Ok(())
    }

    /// What the language checks for the defaults of the parameters: bounds that leave something, and a start within them.
    fn check_bounds(&self) -> Result<(), BadInput> {
        let declaration = self.model.declaration();
        let coordinates = declaration.coordinates.iter().map(|q| (q.name, q.unit));
        let controls = declaration.controls.iter().map(|u| (u.name, u.unit));
        let (mut q, mut v) = [(); 2].map(|()| vec![0.0; coordinates.len()]).into();
        self.model.start(&mut q, &mut v);
        let length = coordinates.len() + controls.len();
        let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; length], vec![f64::INFINITY; length]);
        self.model.bounds(&mut lower, &mut upper);
        for (k, (name, unit)) in coordinates.chain(controls).enumerate() {
            let [low, high] = [lower[k], upper[k]].map(number);
            let refuse = |what: &str| {
                let what = format!("scene `{}`: {what}, for these parameters", self.scene.name);
                Err(BadInput::new(what))
            };
            if lower[k] > upper[k] || lower[k].is_nan() || upper[k].is_nan() {
                return refuse(&format!(
                    "lower bound of `{name}` = {low} {unit}: must be at most the upper one, {high}"
                ));
            }
            if let Some(&start) = q.get(k)
                && !(lower[k]..=upper[k]).contains(&start)
            {
                return refuse(&format!(
                    "start of `{name}` = {} {unit}: must be within its bounds {low}..={high}",
                    number(start)
                ));
            }
        }
        Ok(())
    }

    /// A refusal of the solvers, with the name of the scene.
    pub(crate) fn refuse(&self, error: &InputError) -> BadInput {
        BadInput::new(format!("scene `{}`: {error}", self.scene.name))
    }

    /// Parameter values and choices for people: `m = 80 kg`.
    pub(crate) fn parameters(&self) -> Vec<String> {
        let numbers = self.model.declaration().parameters.iter().enumerate();
        numbers
            .map(|(index, parameter)| {
                let value = self.model.parameter(index);
                format!("{} = {} {}", parameter.name, number(value), parameter.unit)
                    .trim_end()
                    .to_owned()
            })
            .chain(
                self.choices
                    .iter()
                    .map(|(name, choice)| format!("{name} = {choice}")),
            )
            .collect()
    }

    fn set(&mut self, name: &str, text: &str) -> Result<(), BadInput> {
        let parameters = self.model.declaration().parameters;
        let Some(index) = parameters.iter().position(|known| known.name == name) else {
            let names: Vec<&str> = parameters
                .iter()
                .map(|known| known.name)
                .chain(self.choices.iter().map(|&(choice, _)| choice))
                .collect();
            return Err(BadInput::new(format!(
                "scene `{}` has no parameter `{name}`{} (it has: {})",
                self.scene.name,
                did_you_mean(name, names.iter().copied()),
                names.join(", ")
            )));
        };
        let value = quantity(name, text, parameters[index].unit)?;
        self.model.set_parameter(index, value);
        self.given.push(index);
        Ok(())
    }
}

/// The file of a scene that is no scene of the list: the path itself, or that of the file beside it which has the ending of scene files.
pub(crate) fn file_of(scenes: &[Scene], name: &str) -> Option<String> {
    if is_path(name) {
        return Some(name.to_owned());
    }
    let beside = format!("{name}.{EXTENSION}");
    let known = scenes.iter().any(|scene| scene.name == name);
    (!known && Path::new(&beside).is_file()).then_some(beside)
}

/// The scene called `name`, or that of the file with this path, which may be given without its ending.
pub(crate) fn find(scenes: &'static [Scene], name: &str) -> Result<&'static Scene, BadInput> {
    if let Some(file) = file_of(scenes, name) {
        return load(&file);
    }
    let named = scenes.iter().find(|scene| scene.name == name);
    let known = named.ok_or_else(|| {
        let names: Vec<&str> = scenes.iter().map(|scene| scene.name).collect();
        BadInput::new(format!(
            "unknown scene `{name}`{} (scenes: {}; a scene file ends with .{EXTENSION})",
            did_you_mean(name, names.iter().copied()),
            names.join(", ")
        ))
    })?;
    match known.unread {
        Some(text) => load_unread(known, text),
        None => Ok(known),
    }
}

/// The scene with these numbers in the place of its counts, which are no settings of its model then.
fn with_counts(
    scene: &'static Scene,
    pairs: &mut Vec<(&str, &str)>,
) -> Result<&'static Scene, BadInput> {
    let mut changed: Option<String> = None;
    let mut kept = Vec::new();
    for &(name, value) in &*pairs {
        let text = changed.as_deref().or(scene.text.map(TextScene::source));
        let text = text.filter(|text| is_count(text, name));
        let Some(text) = text else {
            kept.push((name, value));
            continue;
        };
        let number = value.parse().ok();
        let with_number = number.and_then(|number| hangtime_dsl::with_count(text, name, number));
        let refusal = || {
            let message =
                format!("--set {name}={value}: count `{name}` is a whole number, as in {name}=3");
            BadInput::new(message)
        };
        changed = Some(with_number.ok_or_else(refusal)?);
    }
    *pairs = kept;
    match changed {
        Some(text) => load_changed(scene, &text),
        None => Ok(scene),
    }
}

/// Whether a text has a count of that name.
pub(crate) fn is_count(text: &str, name: &str) -> bool {
    text.contains("count") && hangtime_dsl::with_count(text, name, 1).is_some()
}

/// Splits every setting at its first `=` and refuses repeated names.
fn split_all(settings: &[String]) -> Result<Vec<(&str, &str)>, BadInput> {
    let mut pairs: Vec<(&str, &str)> = Vec::with_capacity(settings.len());
    for setting in settings {
        let (name, value) = setting
            .split_once('=')
            .map(|(name, value)| (name.trim(), value.trim()))
            .filter(|(name, value)| !name.is_empty() && !value.is_empty())
            .ok_or_else(|| {
                BadInput::new(format!(
                    "setting `{setting}` of --set: write NAME=VALUE or NAME=VALUE[UNIT], such as \
                     g=9.81 or g=9.81m/s^2"
                ))
            })?;
        if pairs.iter().any(|&(earlier, _)| earlier == name) {
            return Err(BadInput::new(format!(
                "setting `{name}` of --set is given twice; keep one of them"
            )));
        }
        pairs.push((name, value));
    }
    Ok(pairs)
}

/// The form of a scene and a fresh model of it.
type Form = (&'static [(&'static str, &'static str)], Box<dyn Model>);

/// The first variant of the scene that agrees with the settings.
fn choose(scene: &'static Scene, pairs: &[(&str, &str)]) -> Result<Form, BadInput> {
    if let Some(text) = scene.text {
        return Ok((&[], text.boxed()));
    }
    let given = |name: &str| pairs.iter().find(|&&(given, _)| given == name);
    scene
        .variants
        .iter()
        .find(|variant| {
            variant
                .settings
                .iter()
                .all(|&(name, choice)| given(name).is_none_or(|&(_, wanted)| wanted == choice))
        })
        .map(|variant| (variant.settings, (variant.model)()))
        .ok_or_else(|| {
            let forms: Vec<String> = scene
                .variants
                .iter()
                .map(|variant| {
                    let words: Vec<String> = variant
                        .settings
                        .iter()
                        .map(|(name, choice)| format!("{name}={choice}"))
                        .collect();
                    words.join(" ")
                })
                .collect();
            let names = scene.variants.iter().flat_map(|variant| variant.settings);
            let given: Vec<String> = pairs
                .iter()
                .filter(|(name, _)| names.clone().any(|(choice, _)| choice == name))
                .map(|(name, value)| format!("{name}={value}"))
                .collect();
            BadInput::new(format!(
                "scene `{}` has no form `{}`; choose one of: {}",
                scene.name,
                given.join(" "),
                forms.join(", ")
            ))
        })
}

/// Reads `VALUE[UNIT]` as a number in the declared unit.
fn quantity(name: &str, text: &str, declared: &str) -> Result<f64, BadInput> {
    let not_finite = || {
        BadInput::new(format!(
            "parameter `{name}` = `{text}` is not finite; give a finite number"
        ))
    };
    if text.parse::<f64>().is_ok_and(|value| !value.is_finite()) {
        return Err(not_finite());
    }
    let value = Quantity::parse(text)
        .and_then(|quantity| quantity.in_unit(declared))
        .map_err(|error| {
            let unit = if declared.is_empty() { "1" } else { declared };
            let remedy = match &error {
                UnitError::Different { .. } => {
                    format!("; leave the unit out, or write one that converts to {unit}")
                }
                _ => String::new(),
            };
            BadInput::new(format!("parameter `{name}` [{unit}]: {error}{remedy}"))
        })?;
    if value.is_finite() {
        Ok(value)
    } else {
        Err(not_finite())
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::Slide;
    use crate::{Scene, Variant};

    use super::{choose, split_all};

    /// A scene in two forms that differ in a parameter.
    static TWO_FORMS: Scene = Scene::new(
        "two-forms",
        "",
        &[
            Variant {
                settings: &[("law", "paper")],
                model: || Box::new(Slide::default()),
            },
            Variant {
                settings: &[("law", "holding")],
                model: || {
                    Box::new(Slide {
                        start_y: 4.0,
                        ..Slide::default()
                    })
                },
            },
        ],
    );

    fn chosen(settings: &[&str]) -> Result<&'static str, String> {
        let settings: Vec<String> = settings.iter().map(|&setting| setting.into()).collect();
        let pairs = split_all(&settings).unwrap();
        let (choices, model) = choose(&TWO_FORMS, &pairs).map_err(|refusal| refusal.to_string())?;
        let parameters = model.declaration().parameters;
        let start_y = parameters.iter().position(|p| p.name == "start_y").unwrap();
        let holding = model.parameter(start_y) == 4.0;
        assert_eq!(holding, choices == [("law", "holding")]);
        Ok(choices[0].1)
    }

    #[test]
    fn choose_without_a_setting_takes_the_first_form() {
        assert_eq!(chosen(&[]), Ok("paper"));
        assert_eq!(chosen(&["start_y=3"]), Ok("paper"));
    }

    #[test]
    fn choose_with_a_setting_takes_its_form() {
        assert_eq!(chosen(&["start_y=3", "law=holding"]), Ok("holding"));
    }

    #[test]
    fn choose_unknown_form_names_those_that_exist() {
        let refusal = chosen(&["law=other"]).unwrap_err();
        assert_eq!(
            refusal,
            "scene `two-forms` has no form `law=other`; choose one of: law=paper, law=holding"
        );
    }
}
