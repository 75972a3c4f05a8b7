//! The functions of optimal control.

use super::builder::{Builder, Pattern};
use crate::derive::{ControlEquations, Explicit};
use crate::graph::Sym;
use crate::scene::OptimalControl;

/// Bodies of the methods that concern optimal control, and patterns.
pub(in crate::emit) struct ControlPlan {
    pub(in crate::emit) path: FunctionPlan,
    pub(in crate::emit) terminal: FunctionPlan,
    /// Lower and upper bounds of the free initial values; empty if there are none.
    pub(in crate::emit) free_start_bounds: Option<[String; 2]>,
}

/// Bodies of the methods for some functions and their derivatives.
pub(in crate::emit) struct FunctionPlan {
    /// Values, Jacobian and Hessian; `None` if there are no functions.
    pub(in crate::emit) bodies: Option<[String; 3]>,
    pub(in crate::emit) jacobian_pattern: Pattern,
    pub(in crate::emit) hessian_pattern: Pattern,
}

pub(super) fn optimal_control(
    builder: &mut Builder<'_>,
    declared: &OptimalControl,
    derived: &ControlEquations,
) -> ControlPlan {
    let path = functions(builder, "path", "x", &derived.path);
    let first = builder.kernels.len();
    let terminal = functions(builder, "terminal", "z", &derived.terminal);
    for kernel in &mut builder.kernels[first..] {
        kernel.at_the_end = true;
    }
    let free_start_bounds = (!declared.free_start.is_empty()).then(|| {
        let bound = |open: f64, pick: fn((Sym, Sym)) -> Sym| -> Vec<Sym> {
            let bounds = declared.free_start.iter();
            bounds
                .map(|&(_, bounds)| bounds.map_or(Sym::number(open), pick))
                .collect()
        };
        [
            builder.unlisted(
                "free_start_lower",
                &bound(f64::NEG_INFINITY, |(low, _)| low),
                "lower",
            ),
            builder.unlisted(
                "free_start_upper",
                &bound(f64::INFINITY, |(_, high)| high),
                "upper",
            ),
        ]
    });
    ControlPlan {
        path,
        terminal,
        free_start_bounds,
    }
}

fn functions(
    builder: &mut Builder<'_>,
    kind: &str,
    input: &str,
    functions: &Explicit,
) -> FunctionPlan {
    let Explicit {
        values,
        jacobian,
        hessian,
    } = functions;
    let bodies = (!values.is_empty()).then(|| {
        [
            builder.call(&format!("{kind}_functions"), values, input, "&[]", "values"),
            builder.call(
                &format!("{kind}_jacobian"),
                &jacobian.values,
                input,
                "&[]",
                "values",
            ),
            builder.call(
                &format!("{kind}_hessian"),
                &hessian.values,
                input,
                "multipliers",
                "values",
            ),
        ]
    });
    FunctionPlan {
        bodies,
        jacobian_pattern: Pattern::of(jacobian),
        hessian_pattern: Pattern::of(hessian),
    }
}
