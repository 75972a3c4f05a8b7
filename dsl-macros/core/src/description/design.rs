//! Parameters that optimal control is to find, and parameters as coordinates without motion.

use super::builder::Builder;
use super::optimal_control::{Kernels, functions};
use crate::declaration::{self, Epigraph, list, text};
use crate::derive::{Equations, given};
use crate::scene::CheckedScene;

/// The parameters that are to be found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeParameters {
    /// Their indices, increasing.
    pub parameters: &'static [usize],
    /// Kernels of the lower and the upper ends of their ranges.
    pub bounds: (usize, usize),
}

/// Parameters that stand behind the coordinates as coordinates without motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Held {
    /// What is declared so.
    pub declared: declaration::Held,
    /// Kernels of [the values that they give](declaration::Held::given), which read these coordinates alone; none if there are no
    /// such values.
    pub given: Option<Kernels>,
}

pub(super) fn epigraphs(scene: &CheckedScene) -> &'static [Epigraph] {
    let task = scene.optimal_control.iter();
    list(task.flat_map(|task| &task.epigraphs).map(|known| Epigraph {
        name: text(&known.shown),
        over: known.over,
        rows: known.rows.len(),
    }))
}

pub(super) fn free(builder: &mut Builder<'_>) -> Option<FreeParameters> {
    let scene = builder.scene;
    let free = &scene.free_parameters;
    if free.is_empty() {
        return None;
    }
    Some(FreeParameters {
        parameters: list(free.iter().map(|free| usize::from(free.index))),
        bounds: builder.bounds(
            ["free_parameters_lower", "free_parameters_upper"],
            free.iter().map(|free| Some(free.bounds)),
        ),
    })
}

pub(super) fn held(builder: &mut Builder<'_>, equations: &Equations) -> Option<Held> {
    let scene = builder.scene;
    if scene.held.is_empty() && !scene.remembers && scene.lifted.is_none() {
        return None;
    }
    let lifted = scene.lifted.clone().unwrap_or_default();
    let (given, derived) = given(scene, &equations.inputs);
    let (kernels, [jacobian, hessian]) = functions(builder, "given", &derived);
    Some(Held {
        declared: declaration::Held {
            parameters: list(scene.held.iter().copied().map(usize::from)),
            starts: list(scene.remembered.iter().copied()),
            largest: lifted.coordinates,
            at_stages: list(lifted.controls),
            given: list(given),
            jacobian,
            hessian,
        },
        given: kernels,
    })
}
