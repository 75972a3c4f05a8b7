//! The functions of optimal control.

use super::builder::{Builder, pattern};
use super::declared::inferred;
use crate::declaration::{
    ConstraintDeclaration, ContactTerms, OptimalControlDeclaration, SparsityPattern, list, text,
};
use crate::derive::{ControlEquations, Explicit, resets};
use crate::scene;

/// Kernels of some functions: values, Jacobian, and Hessian (lower triangle) of their weighted sum.
pub type Kernels = (usize, usize, usize);

/// Kernels of objective, constraints, terminal conditions and free initial values; none of what has no functions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OptimalControl {
    /// Lower and upper bounds of initial values that are to be found.
    pub free_start_bounds: Option<(usize, usize)>,
    /// Running cost and path constraints.
    pub path: Option<Kernels>,
    /// Final cost and terminal conditions.
    pub terminal: Option<Kernels>,
    /// What is added up over impacts, conditions on them, and what conditions set.
    pub impact: Option<Kernels>,
}

pub(super) fn optimal_control(
    builder: &mut Builder<'_>,
    declared: &scene::OptimalControl,
    derived: &ControlEquations,
) -> (OptimalControlDeclaration, OptimalControl) {
    let (path, [path_jacobian, path_hessian]) = functions(builder, "path", &derived.path);
    builder.at_the_end = true;
    let (terminal, [terminal_jacobian, terminal_hessian]) =
        functions(builder, "terminal", &derived.terminal);
    builder.at_the_end = false;
    let (impact, [impact_jacobian, impact_hessian]) = functions(builder, "impact", &derived.impact);
    let free_start_bounds = (!declared.free_start.is_empty()).then(|| {
        let bounds = declared.free_start.iter().map(|&(_, bounds)| bounds);
        builder.bounds(["free_start_lower", "free_start_upper"], bounds)
    });
    let declared = OptimalControlDeclaration {
        running_cost: declared.running_cost.is_some(),
        final_cost: declared.final_cost.is_some(),
        constraints: conditions(&declared.constraints),
        goals: conditions(&declared.goals),
        free_time: declared.free_time,
        free_start: list(declared.free_start.iter().map(|&(index, _)| index)),
        path_jacobian,
        path_hessian,
        terminal_jacobian,
        terminal_hessian,
        contacts: ContactTerms {
            path: derived.path_reads_forces,
            terminal: derived.terminal_reads_forces,
            sums: declared.sums.len(),
            constraints: conditions(&declared.at_impacts),
            resets: list(resets(builder.scene).map(|(contact, velocity, _)| (contact, velocity))),
            impact_jacobian,
            impact_hessian,
        },
    };
    let kernels = OptimalControl {
        free_start_bounds,
        path,
        terminal,
        impact,
    };
    (declared, kernels)
}

fn conditions(conditions: &[scene::Condition]) -> &'static [ConstraintDeclaration] {
    list(conditions.iter().map(|condition| ConstraintDeclaration {
        name: text(&condition.name),
        unit: inferred(condition.unit),
        documentation: text(&condition.documentation),
        equality: condition.equality,
    }))
}

/// The kernels of some functions, if there are any, and the patterns of their Jacobian and Hessian.
pub(super) fn functions(
    builder: &mut Builder<'_>,
    kind: &str,
    functions: &Explicit,
) -> (Option<Kernels>, [SparsityPattern; 2]) {
    let Explicit {
        values,
        jacobian,
        hessian,
    } = functions;
    let kernels = (!values.is_empty()).then(|| {
        (
            builder.kernel(&format!("{kind}_functions"), values),
            builder.kernel(&format!("{kind}_jacobian"), &jacobian.values),
            builder.kernel(&format!("{kind}_hessian"), &hessian.values),
        )
    });
    (kernels, [pattern(jacobian), pattern(hessian)])
}
