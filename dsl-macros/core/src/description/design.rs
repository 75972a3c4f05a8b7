//! Parameters that optimal control is to find, and parameters as coordinates without motion.

use super::builder::Builder;
use super::optimal_control::{Functions, functions};
use crate::derive::{Equations, Given, given};
use crate::graph::Sym;

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
    /// What of start, horizon and laws depends on them.
    pub given: Vec<Given>,
    /// The values of that as functions of the input vector, which read these coordinates alone.
    pub functions: Functions,
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
    if scene.held.is_empty() && !scene.remembers {
        return None;
    }
    let (given, derived) = given(scene, &equations.inputs);
    Some(Held {
        parameters: scene.held.iter().copied().map(usize::from).collect(),
        starts: scene.remembered.clone(),
        given,
        functions: functions(builder, "given", &derived),
    })
}
