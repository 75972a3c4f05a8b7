//! The functions of optimal control.

use super::builder::{Builder, Pattern};
use super::declared::{inferred, text};
use crate::derive::{ControlEquations, Explicit, resets};
use crate::graph::Sym;
use crate::scene;

/// Objective, constraints, terminal conditions and free initial values: what is declared, and its kernels.
#[derive(Debug, Clone, PartialEq)]
pub struct OptimalControl {
    /// Whether the first path function is a running cost.
    pub running_cost: bool,
    /// Whether the first terminal function is a final cost.
    pub final_cost: bool,
    /// Path constraints, in the order of their functions.
    pub constraints: Vec<Condition>,
    /// Terminal conditions, in the order of their functions.
    pub goals: Vec<Condition>,
    /// Whether the final time is to be found.
    pub free_time: bool,
    /// Initial values that are to be found: indices into `(q, v)`, increasing.
    pub free_start: Vec<usize>,
    /// Kernels of their lower and upper bounds; none if there are no such values.
    pub free_start_bounds: Option<[usize; 2]>,
    /// Running cost and path constraints.
    pub path: Functions,
    /// Final cost and terminal conditions, of `(q, v, T)` with the final time `T`.
    pub terminal: Functions,
    /// What they read of contacts.
    pub contacts: ContactTerms,
}

/// What the functions of optimal control read of contacts: `(r, s)`, what all contacts provide along their normals and
/// then along their sliding velocities.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactTerms {
    /// Whether path functions read accelerations `(r, s)` behind the input vector.
    pub path: bool,
    /// Whether terminal functions read those at the end, last.
    pub terminal: bool,
    /// Number of sums over impacts, which terminal functions read behind the final time.
    pub sums: usize,
    /// Conditions on impacts, in the order of their functions.
    pub constraints: Vec<Condition>,
    /// What conditions that come true set, in the order of their functions behind those of impacts: the contact that each is, and the velocity.
    pub resets: Vec<(usize, usize)>,
    /// What is added up, and the conditions, of the input vector with the velocities `(r, s)` that an impact provides
    /// behind it.
    pub impact: Functions,
}

/// A condition on one scalar function.
#[derive(Debug, Clone, PartialEq)]
pub struct Condition {
    /// Its name, or the condition as written.
    pub name: String,
    /// Unit of the function; empty for a pure number.
    pub unit: String,
    /// Documentation, as written.
    pub documentation: String,
    /// Whether the function must vanish; otherwise it must not be negative.
    pub equality: bool,
}

/// Some functions with their derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct Functions {
    /// Kernels of values, Jacobian and Hessian; none if there are no functions.
    pub kernels: Option<[usize; 3]>,
    /// Pattern of the Jacobian.
    pub jacobian: Pattern,
    /// Pattern (lower triangle) of the Hessian of the weighted functions.
    pub hessian: Pattern,
}

pub(super) fn optimal_control(
    builder: &mut Builder<'_>,
    declared: &scene::OptimalControl,
    derived: &ControlEquations,
) -> OptimalControl {
    let path = functions(builder, "path", &derived.path);
    builder.at_the_end = true;
    let terminal = functions(builder, "terminal", &derived.terminal);
    builder.at_the_end = false;
    let impact = functions(builder, "impact", &derived.impact);
    let free_start_bounds = (!declared.free_start.is_empty()).then(|| {
        let bound = |open: f64, pick: fn((Sym, Sym)) -> Sym| -> Vec<Sym> {
            let bounds = declared.free_start.iter();
            bounds
                .map(|&(_, bounds)| bounds.map_or(Sym::number(open), pick))
                .collect()
        };
        let lower = bound(f64::NEG_INFINITY, |(low, _)| low);
        let upper = bound(f64::INFINITY, |(_, high)| high);
        [
            builder.unlisted("free_start_lower", &lower),
            builder.unlisted("free_start_upper", &upper),
        ]
    });
    let conditions = |list: &[scene::Condition]| {
        let described = list.iter().map(|condition| Condition {
            name: condition.name.clone(),
            unit: inferred(condition.unit),
            documentation: text(&condition.documentation),
            equality: condition.equality,
        });
        described.collect()
    };
    OptimalControl {
        running_cost: declared.running_cost.is_some(),
        final_cost: declared.final_cost.is_some(),
        constraints: conditions(&declared.constraints),
        goals: conditions(&declared.goals),
        free_time: declared.free_time,
        free_start: declared
            .free_start
            .iter()
            .map(|&(index, _)| index)
            .collect(),
        free_start_bounds,
        path,
        terminal,
        contacts: ContactTerms {
            path: derived.path_reads_forces,
            terminal: derived.terminal_reads_forces,
            sums: declared.sums.len(),
            constraints: conditions(&declared.at_impacts),
            resets: resets(builder.scene)
                .map(|(contact, velocity, _)| (contact, velocity))
                .collect(),
            impact,
        },
    }
}

pub(super) fn functions(builder: &mut Builder<'_>, kind: &str, functions: &Explicit) -> Functions {
    let Explicit {
        values,
        jacobian,
        hessian,
    } = functions;
    let kernels = (!values.is_empty()).then(|| {
        [
            builder.kernel(&format!("{kind}_functions"), values),
            builder.kernel(&format!("{kind}_jacobian"), &jacobian.values),
            builder.kernel(&format!("{kind}_hessian"), &hessian.values),
        ]
    });
    Functions {
        kernels,
        jacobian: Pattern::of(jacobian),
        hessian: Pattern::of(hessian),
    }
}
