//! What the list of scenes knows about each one.

use hangtime::model::Model;

use crate::published::PublishedCase;

/// A shipped scene.
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

impl Scene {
    /// The default form with default parameters.
    #[must_use]
    pub fn model(&self) -> Box<dyn Model> {
        (self.variants[0].model)()
    }
}
