//! What the list of scenes knows about each one.

use hangtime::model::Model;

use crate::published::PublishedCase;

/// A scene as the command line knows it.
#[derive(Debug, Clone, Copy)]
pub struct Scene {
    /// Name on the command line, in kebab case.
    pub name: &'static str,
    /// What it is, in one line.
    pub title: &'static str,
    /// The forms in which the scene exists; the first one is the default. Never empty.
    pub variants: &'static [Variant],
    /// How to draw the scene, if it moves in a plane.
    pub plane: Option<Plane>,
    /// Published results that the scene reproduces.
    pub published: &'static [PublishedCase],
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

/// How a scene that moves in a vertical plane is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// Labels of the horizontal and the vertical axis, with units.
    pub axes: [&'static str; 2],
    /// Unit of both axes.
    pub unit: &'static str,
    /// Names of the bodies.
    pub bodies: &'static [&'static str],
    /// Pairs of bodies that are joined by a line.
    pub links: &'static [[usize; 2]],
    /// Positions of the bodies for coordinates `q`.
    pub positions: fn(model: &dyn Model, q: &[f64]) -> Vec<[f64; 2]>,
    /// The ground lines between two horizontal positions.
    pub ground: fn(model: &dyn Model, from: f64, to: f64) -> Vec<GroundLine>,
}

/// A line of ground to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct GroundLine {
    /// Name of the surface.
    pub name: &'static str,
    /// Its points, as (horizontal, vertical).
    pub points: Vec<[f64; 2]>,
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

impl Plane {
    /// A scene of one body, called `body`, whose first two coordinates are a horizontal position and a height in
    /// metres, above the ground lines of [`heights`].
    #[must_use]
    pub const fn of_one_body(body: &'static [&'static str; 1], axes: [&'static str; 2]) -> Self {
        Self {
            axes,
            unit: "m",
            bodies: body,
            links: &[],
            positions: |_, q| vec![[q[0], q[1]]],
            ground: heights,
        }
    }
}

impl Scene {
    /// A scene that is not drawn in a plane and has no published results.
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
            plane: None,
            published: &[],
        }
    }

    /// The same scene, drawn in a plane.
    #[must_use]
    pub const fn drawn(self, plane: Plane) -> Self {
        Self {
            plane: Some(plane),
            ..self
        }
    }

    /// The default form with default parameters.
    #[must_use]
    pub fn model(&self) -> Box<dyn Model> {
        (self.variants[0].model)()
    }
}

/// Points of a ground line.
const POINTS: usize = 200;

/// The value of the parameter called `name`; not a number if there is none.
#[must_use]
pub fn parameter(model: &dyn Model, name: &str) -> f64 {
    let parameters = model.declaration().parameters;
    let index = parameters.iter().position(|known| known.name == name);
    index.map_or(f64::NAN, |index| model.parameter(index))
}

/// The ground lines of a scene whose first two coordinates are a horizontal position and a height: where each gap
/// vanishes, from one horizontal position to another. Gaps must be linear in the height; all other coordinates count
/// as zero.
#[must_use]
pub fn heights(model: &dyn Model, from: f64, to: f64) -> Vec<GroundLine> {
    let declaration = model.declaration();
    let mut point = vec![0.0; declaration.inputs()];
    let mut height = |contact: usize, y: f64| {
        let [low, high] = [0.0, 1.0].map(|z| {
            point[..2].copy_from_slice(&[y, z]);
            model.gap(contact, &point)
        });
        low / (low - high)
    };
    let contacts = declaration.contacts.iter().enumerate();
    contacts
        .map(|(contact, declared)| GroundLine {
            name: declared.name,
            points: (0..=POINTS)
                .map(|i| from + (to - from) * i as f64 / POINTS as f64)
                .map(|y| [y, height(contact, y)])
                .collect(),
        })
        .collect()
}
