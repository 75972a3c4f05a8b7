//! The static description of a scene.

use super::equations;
use super::kernel::literal;
use super::plan::{Pattern, Plan};
use super::structure::text;
use crate::ast::WrittenUnit;
use crate::derive::Equations;
use crate::scene::{CheckedScene, Condition};
use hangtime_units::Unit;
use std::fmt::Write;

/// Writes `static DECLARATION`.
pub(super) fn write(scene: &CheckedScene, derived: &Equations, plan: &Plan, code: &mut String) {
    let _ = write!(
        code,
        "static DECLARATION: ::hangtime::model::Declaration = ::hangtime::model::Declaration {{ name: \
         {:?}, documentation: {:?}, parameters: &[",
        scene.name.text,
        text(&scene.documentation)
    );
    for parameter in &scene.parameters {
        let _ = write!(
            code,
            "::hangtime::model::ParameterDeclaration {{ name: {:?}, unit: {:?}, default: {}, positive: \
             {}, documentation: {:?} }},",
            parameter.name.text,
            unit(parameter.unit.as_ref()),
            literal(parameter.default),
            is_inertia(parameter.unit.as_ref()),
            text(&parameter.documentation)
        );
    }
    for (field, list) in [
        ("coordinates", &scene.coordinates),
        ("controls", &scene.controls),
    ] {
        let _ = write!(code, "], {field}: &[");
        for quantity in list {
            let _ = write!(
                code,
                "::hangtime::model::VariableDeclaration {{ name: {:?}, unit: {:?}, documentation: {:?} }},",
                quantity.name.text,
                unit(quantity.unit.as_ref()),
                text(&quantity.documentation)
            );
        }
    }
    code.push_str("], contacts: &[");
    contacts(scene, plan, code);
    let _ = write!(
        code,
        "], explicit_time: {}, free_jacobian: {}, free_hessian: {}, optimal_control: {}, kernels: &[",
        scene.explicit_time,
        pattern(&plan.free_patterns[0]),
        pattern(&plan.free_patterns[1]),
        optimal_control(scene, plan)
    );
    for kernel in plan.listed() {
        let _ = write!(
            code,
            "::hangtime::model::Kernel {{ name: {:?}, operations: {}, outputs: {} }},",
            kernel.name,
            kernel.tape.operations(),
            kernel.tape.outputs.len()
        );
    }
    code.push_str("], equations: &[");
    for (left, right) in equations::readable(scene, derived) {
        let _ = write!(
            code,
            "::hangtime::model::Equation {{ left: {left:?}, right: {right:?} }},"
        );
    }
    code.push_str("] };");
}

fn contacts(scene: &CheckedScene, plan: &Plan, code: &mut String) {
    for (contact, plan) in scene.contacts.iter().zip(&plan.contacts) {
        let friction = match &plan.friction {
            None => "__Option::None".to_owned(),
            Some(friction) => format!(
                "__Option::Some(::hangtime::model::FrictionDeclaration {{ jacobian: {}, hessian: {} }})",
                pattern(&friction.derivatives.jacobian_pattern),
                pattern(&friction.derivatives.hessian_pattern)
            ),
        };
        let _ = write!(
            code,
            "::hangtime::model::ContactDeclaration {{ name: {:?}, unit: {:?}, law: \
             ::hangtime::model::ImpactLaw::{}, friction: {friction}, custom_direction: {}, held: &{:?}, \
             jacobian: {}, hessian: {}, documentation: {:?} }},",
            contact.name.text,
            inferred(contact.unit),
            if contact.restitution.is_some() {
                "Restitution"
            } else {
                "Inelastic"
            },
            contact.along.is_some(),
            contact.held,
            pattern(&plan.derivatives.jacobian_pattern),
            pattern(&plan.derivatives.hessian_pattern),
            text(&contact.documentation)
        );
    }
}

fn optimal_control(scene: &CheckedScene, plan: &Plan) -> String {
    let (Some(task), Some(plan)) = (&scene.optimal_control, &plan.optimal_control) else {
        return "__Option::None".to_owned();
    };
    let free_start: Vec<usize> = task.free_start.iter().map(|&(index, _)| index).collect();
    format!(
        "__Option::Some(::hangtime::model::OptimalControlDeclaration {{ running_cost: {}, final_cost: {}, \
         constraints: &[{}], goals: &[{}], free_time: {}, free_start: &{free_start:?}, path_jacobian: {}, \
         path_hessian: {}, terminal_jacobian: {}, terminal_hessian: {} }})",
        task.running_cost.is_some(),
        task.final_cost.is_some(),
        conditions(&task.constraints),
        conditions(&task.goals),
        task.free_time,
        pattern(&plan.path.jacobian_pattern),
        pattern(&plan.path.hessian_pattern),
        pattern(&plan.terminal.jacobian_pattern),
        pattern(&plan.terminal.hessian_pattern)
    )
}

fn conditions(conditions: &[Condition]) -> String {
    let mut code = String::new();
    for condition in conditions {
        let _ = write!(
            code,
            "::hangtime::model::ConstraintDeclaration {{ name: {:?}, unit: {:?}, relation: \
             ::hangtime::model::ConstraintRelation::{}, documentation: {:?} }},",
            condition.name,
            inferred(condition.unit),
            if condition.equality {
                "Zero"
            } else {
                "NonNegative"
            },
            text(&condition.documentation)
        );
    }
    code
}

fn unit(written: Option<&WrittenUnit>) -> &str {
    written.map_or("", |unit| unit.text.as_str())
}

/// A unit that follows from others; empty for pure numbers, as where none is declared.
fn inferred(unit: Option<Unit>) -> String {
    unit.filter(|unit| !unit.same_dimension(Unit::ONE))
        .map_or_else(String::new, |unit| unit.to_string())
}

/// Masses and moments of inertia, which must be positive.
fn is_inertia(written: Option<&WrittenUnit>) -> bool {
    written.is_some_and(|written| {
        written.unit.same_dimension(Unit::mechanical(0, 1, 0))
            || written.unit.same_dimension(Unit::mechanical(2, 1, 0))
    })
}

fn pattern(pattern: &Pattern) -> String {
    format!(
        "::hangtime::model::SparsityPattern {{ rows: {}, columns: {}, entries: {} }}",
        pattern.rows,
        pattern.columns,
        pattern.entries()
    )
}
