//! Parameters that optimal control is to find, and parameters as coordinates without motion.

use super::builder::Builder;
use super::optimal_control::{Functions, functions};
use crate::derive::{Equations, Given, given};
use crate::graph::Sym;
use crate::scene::CheckedScene;
pub use crate::scene::Over;

/// The parameters that are to be found.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeParameters {
    /// Their indices, increasing.
    pub parameters: Vec<usize>,
    /// Kernels of the lower and the upper ends of their ranges.
    pub bounds: [usize; 2],
}

/// Parameters that stand behind the coordinates as coordinates without motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// Their indices among the parameters, in the order of these coordinates.
    pub parameters: Vec<usize>,
    /// Components of the start `(q, v)` of the scene that the coordinates behind those are, and decide.
    pub starts: Vec<usize>,
    /// Number of coordinates behind those that are largest values.
    pub largest: usize,
    /// Of the last controls, which are largest values of each instant, the numbers of their conditions, the last constraints.
    pub at_stages: Vec<usize>,
    /// What of start, horizon and laws depends on them.
    pub given: Vec<Given>,
    /// The values of that as functions of the input vector, which read these coordinates alone.
    pub functions: Functions,
}

/// A largest value that optimal control has as an unknown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Epigraph {
    /// What it stands for, or the term that it stands in, as written.
    pub name: String,
    /// When the values are of which it is the largest.
    pub over: Over,
    /// How many conditions say what it is at least, at each place where it is stated.
    pub rows: usize,
}

pub(super) fn epigraphs(scene: &CheckedScene) -> Vec<Epigraph> {
    let task = scene.optimal_control.iter();
    let known = task.flat_map(|task| &task.epigraphs);
    let described = known.map(|known| Epigraph {
        name: known.shown.clone(),
        over: known.over,
        rows: known.rows.len(),
    });
    described.collect()
}

pub(super) fn free(builder: &mut Builder<'_>) -> Option<FreeParameters> {
    let free = &builder.scene.free_parameters;
    if free.is_empty() {
        return None;
    }
    let lower: Vec<Sym> = free.iter().map(|free| free.bounds.0).collect();
    let upper: Vec<Sym> = free.iter().map(|free| free.bounds.1).collect();
    Some(FreeParameters {
        parameters: free.iter().map(|free| usize::from(free.index)).collect(),
        bounds: [
            builder.unlisted("free_parameters_lower", &lower),
            builder.unlisted("free_parameters_upper", &upper),
        ],
    })
}

pub(super) fn held(builder: &mut Builder<'_>, equations: &Equations) -> Option<Held> {
    let scene = builder.scene;
    if scene.held.is_empty() && !scene.remembers && scene.lifted.is_none() {
        return None;
    }
    let lifted = scene.lifted.clone().unwrap_or_default();
    let (given, derived) = given(scene, &equations.inputs);
    Some(Held {
        parameters: scene.held.iter().copied().map(usize::from).collect(),
        starts: scene.remembered.clone(),
        largest: lifted.coordinates,
        at_stages: lifted.controls,
        given,
        functions: functions(builder, "given", &derived),
    })
}
