//! What the list of scenes knows about each one.

use hangtime::model::Model;
use hangtime_scene_files::TextScene;

use crate::failure::BadInput;
use crate::published::{PublishedCase, PublishedSize};

/// A scene as the command line knows it.
#[derive(Debug, Clone, Copy)]
pub struct Scene {
    /// Name on the command line, in kebab case.
    pub name: &'static str,
    /// What it is, in one line.
    pub title: &'static str,
    /// The forms in which the scene exists; the first one is the default. Empty only if the scene is one from a file.
    pub variants: &'static [Variant],
    /// The scene itself, if it is one from a file.
    pub text: Option<&'static TextScene>,
    /// The text of its file, if it is one that is read only where it is asked for.
    pub unread: Option<&'static str>,
    /// The text of the file from which it was compiled or read, if it was.
    pub source: Option<&'static str>,
    /// Where the files that it names are looked for; empty for the present folder.
    pub folder: &'static str,
    /// The group in which it is listed.
    pub group: &'static str,
    /// What one may ask of it, if it is there to be looked at.
    pub question: Option<Question>,
    /// A small picture of its motion, as [`HostRun::thumbnail`](crate::HostRun::thumbnail) makes it; empty if there is none.
    pub picture: &'static str,
    /// Published results that the scene reproduces.
    pub published: &'static [PublishedCase],
    /// Published sizes of its optimal control problem, as other programs transcribe it.
    pub published_sizes: &'static [PublishedSize],
    /// The simulations that its charts show; empty: the one that it declares.
    pub charted: &'static [Charted],
    /// Its motion as a formula, if there is one: the coordinates at a time, `None` where the formula does not hold.
    /// Charts measure errors against it.
    pub closed_form: Option<ClosedForm>,
    /// The least objective seen on any grid with the default parameters, if the scene has one. Charts measure from it.
    pub best_known: Option<f64>,
}

/// What one may ask of a scene.
#[derive(Debug, Clone, Copy)]
pub struct Question {
    /// The question.
    pub asked: &'static str,
    /// Its answer in words.
    pub answer: &'static str,
    /// A number of control intervals, and the least objective that is known on them; 0 and the least misfit where measurements are
    /// compared with.
    pub known: (usize, f64),
}

/// The coordinates at a time, where a formula gives them.
pub type ClosedForm = fn(model: &dyn Model, time: f64) -> Option<Vec<f64>>;

/// A simulation that is worth a chart.
#[derive(Debug, Clone, Copy)]
pub struct Charted {
    /// What is special about it, in few words.
    pub what: &'static str,
    /// Settings as on the command line, such as `speed=10km/h`.
    pub settings: &'static [&'static str],
    /// Its horizon in seconds, if it is not that of the scene.
    pub horizon: Option<f64>,
}

/// One form of a scene: a model of its own, chosen by settings that are words instead of numbers.
#[derive(Debug, Clone, Copy)]
pub struct Variant {
    /// The settings that select this form, as (name, choice); every variant of a scene has the same
    /// names. Empty if the scene has a single form.
    pub settings: &'static [(&'static str, &'static str)],
    /// Makes the model with default parameters.
    pub model: fn() -> Box<dyn Model>,
}

/// A scene on which a method of simulation may fail, in one respect, and what is right there.
#[derive(Debug, Clone, Copy)]
pub struct HardScene {
    /// Its name, in kebab case.
    pub name: &'static str,
    /// The scene, as it would stand in a file; the comment below its head holds the reason of what is right, a derivation or a
    /// source.
    pub text: &'static str,
    /// What is right.
    pub right: Right,
}

/// A problem of optimal control on which a method may fail, in one respect, and what is right there.
#[derive(Debug, Clone, Copy)]
pub struct HardOptimum {
    /// Its name, in kebab case.
    pub name: &'static str,
    /// The scene, as it would stand in a file, with a comment as that of a [`HardScene`].
    pub text: &'static str,
    /// What is right.
    pub right: RightOptimum,
}

/// What a method has to say about a problem of optimal control.
#[derive(Debug, Clone, Copy)]
pub enum RightOptimum {
    /// The least objective on a grid of 12 control intervals.
    Least(f64),
    /// That there is no optimum, by one of these names: a status, or `refused`.
    None(&'static [&'static str]),
}

/// A ride that is solved and played on the page of all published results, before anything else.
#[derive(Debug, Clone, Copy)]
pub struct OpeningRide {
    /// Name of its scene.
    pub scene: &'static str,
    /// Control intervals.
    pub intervals: usize,
    /// Starts of the search.
    pub starts: usize,
}

/// What a method has to say about a scene.
#[derive(Debug, Clone, Copy)]
pub enum Right {
    /// The coordinates at a time, as a formula.
    Formula(fn(model: &dyn Model, time: f64) -> Vec<f64>),
    /// The motion on which two methods agree at their tightest tolerances.
    Agreed,
    /// That there is no motion up to the horizon: a refusal, or a status that is not `solved`.
    Stop,
}

impl Variant {
    /// The only form of a scene.
    #[must_use]
    pub const fn new(model: fn() -> Box<dyn Model>) -> Self {
        Self {
            settings: &[],
            model,
        }
    }
}

impl Scene {
    /// A scene without published results.
    #[must_use]
    pub const fn new(
        name: &'static str,
        title: &'static str,
        variants: &'static [Variant],
    ) -> Self {
        Self {
            name,
            title,
            variants,
            text: None,
            unread: None,
            source: None,
            folder: "",
            group: "",
            question: None,
            picture: "",
            published: &[],
            published_sizes: &[],
            charted: &[],
            closed_form: None,
            best_known: None,
        }
    }

    /// A scene whose file has this text, which is read where the scene is asked for.
    #[must_use]
    pub const fn unread(name: &'static str, title: &'static str, text: &'static str) -> Self {
        Self {
            unread: Some(text),
            ..Self::new(name, title, &[])
        }
    }

    /// The scene with the text of the file from which it was compiled.
    #[must_use]
    pub const fn compiled_from(self, source: &'static str) -> Self {
        Self {
            source: Some(source),
            ..self
        }
    }

    /// The scene in a group of the list.
    #[must_use]
    pub const fn in_group(self, group: &'static str) -> Self {
        Self { group, ..self }
    }

    /// The scene with a picture of its motion.
    #[must_use]
    pub const fn pictured(self, picture: &'static str) -> Self {
        Self { picture, ..self }
    }

    /// The scene with what one may ask of it.
    #[must_use]
    pub const fn asking(self, question: Question) -> Self {
        Self {
            question: Some(question),
            ..self
        }
    }

    /// What is worth knowing about the scene, a paragraph: the comment below the documentation of its text; empty where there is none.
    ///
    /// ```
    /// let text = "//! A stone falls.\n//\n// It falls freely,\n// into a well.\n\ncoordinates { z: m }";
    /// let scene = hangtime_cli::Scene::unread("stone", "a stone falls", text);
    /// assert_eq!(scene.about(), "It falls freely, into a well.");
    /// ```
    #[must_use]
    pub fn about(&self) -> String {
        about(self.unread.or(self.source).unwrap_or_default())
    }
}

/// The comment below the head of a text, as one line.
pub(crate) fn about(text: &str) -> String {
    let below = text.lines().skip_while(|line| line.starts_with("//!"));
    let comment = below.map_while(|line| line.strip_prefix("//"));
    let words: Vec<&str> = comment
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .collect();
    words.join(" ")
}

/// Whether a list of scenes can be told apart by their names, and each scene made.
pub(crate) fn check(scenes: &[Scene]) -> Result<(), BadInput> {
    let refuse = |name: &str, what: &str| Err(BadInput::new(format!("scene `{name}`: {what}")));
    for (index, scene) in scenes.iter().enumerate() {
        // The name becomes a part of file names.
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        let starts = scene.name.starts_with(|c: char| c.is_ascii_alphanumeric());
        if !starts || !scene.name.chars().all(fits) {
            return refuse(
                scene.name,
                "name it with ASCII letters, digits, `-` and `_`, a letter or digit first",
            );
        }
        if scenes[..index].iter().any(|other| other.name == scene.name) {
            return refuse(
                scene.name,
                "another scene has this name; rename one of them",
            );
        }
        if scene.variants.is_empty() && scene.text.is_none() && scene.unread.is_none() {
            return refuse(scene.name, "it has no variant; give it at least one model");
        }
        for variant in scene.variants {
            let model = (variant.model)();
            let parameters = model.declaration().parameters;
            for (place, (setting, _)) in variant.settings.iter().enumerate() {
                let twice = variant.settings[..place]
                    .iter()
                    .any(|(earlier, _)| earlier == setting);
                if twice || parameters.iter().any(|known| known.name == *setting) {
                    return refuse(
                        scene.name,
                        &format!(
                            "the name `{setting}` stands for two things in --set; rename one of them"
                        ),
                    );
                }
            }
        }
    }
    Ok(())
}

/// The value of the parameter called `name`; not a number if there is none.
#[must_use]
pub fn parameter(model: &dyn Model, name: &str) -> f64 {
    let parameters = model.declaration().parameters;
    let index = parameters.iter().position(|known| known.name == name);
    index.map_or(f64::NAN, |index| model.parameter(index))
}

#[cfg(test)]
mod tests {
    use crate::testing::{Slide, Wave};
    use crate::{Scene, Variant};

    use super::check;

    const SLIDE: &[Variant] = &[Variant::new(|| Box::new(Slide::default()))];

    fn refusal(scenes: &[Scene]) -> String {
        check(scenes).unwrap_err().to_string()
    }

    #[test]
    fn list_of_scenes_that_cannot_be_told_apart_is_refused() {
        let scene = Scene::new("one", "", SLIDE);
        assert_eq!(check(&[scene]), Ok(()));
        assert!(refusal(&[scene, scene]).contains("another scene has this name"));
        for name in ["", "-x", "../x", "a b", "a/b", "\u{e4}"] {
            let refusal = refusal(&[Scene::new(name, "", SLIDE)]);
            assert!(refusal.contains("ASCII letters"), "{refusal}");
        }
        assert!(refusal(&[Scene::new("none", "", &[])]).contains("no variant"));
        for settings in [&[("g", "x")][..], &[("law", "x"), ("law", "y")]] {
            let variants = Box::new([Variant {
                settings,
                model: || Box::new(Wave::default()),
            }]);
            let refusal = refusal(&[Scene::new("two", "", Box::leak(variants))]);
            assert!(refusal.contains("stands for two things"), "{refusal}");
        }
    }
}
