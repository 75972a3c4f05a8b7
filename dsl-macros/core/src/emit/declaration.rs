//! The static description of a scene.

use super::inertia::positions;
use super::kernel::literal;
use crate::description::{
    Condition, Contact, ContactTerms, Description, Experiment, Measured, OptimalControl, Pattern,
    Picture, Shape, Variable,
};
use std::fmt::Write;

/// Measured motions.
pub(super) fn experiments(list: &[Experiment]) -> String {
    let mut code = String::new();
    for known in list {
        let _ = write!(
            code,
            "::hangtime::model::Experiment {{ name: {:?}, documentation: {:?}, file: {:?}, own_start: {}, huber: {}, \
             quantities: &[",
            known.name,
            known.documentation,
            known.file,
            known.start.is_some(),
            known.huber.map_or_else(
                || "__Option::None".to_owned(),
                |bound| format!("__Option::Some({})", literal(bound))
            )
        );
        for quantity in &known.quantities {
            let (kind, index) = match quantity.measured {
                Measured::Coordinate(k) => ("Coordinate", k),
                Measured::Velocity(k) => ("Velocity", k),
                Measured::Output(k) => ("Output", k),
            };
            let _ = write!(
                code,
                "::hangtime::model::MeasuredQuantity {{ name: {:?}, unit: {:?}, measured: \
                 ::hangtime::model::Measured::{kind}({index}), within: {} }},",
                quantity.name,
                quantity.unit,
                literal(quantity.within)
            );
        }
        code.push_str("] },");
    }
    code
}

/// Writes `static DECLARATION`.
pub(super) fn write(scene: &Description, code: &mut String) {
    let _ = write!(
        code,
        "static DECLARATION: ::hangtime::model::Declaration = ::hangtime::model::Declaration {{ name: \
         {:?}, documentation: {:?}, parameters: &[",
        scene.name, scene.documentation
    );
    for parameter in &scene.parameters {
        let _ = write!(
            code,
            "::hangtime::model::ParameterDeclaration {{ name: {:?}, unit: {:?}, default: {}, positive: \
             {}, documentation: {:?} }},",
            parameter.name,
            parameter.unit,
            literal(parameter.default),
            parameter.positive,
            parameter.documentation
        );
    }
    for (field, list) in [
        ("coordinates", &scene.coordinates),
        ("controls", &scene.controls),
        ("states", &scene.states),
    ] {
        let _ = write!(code, "], {field}: &[{}", variables(list));
    }
    code.push_str("], contacts: &[");
    contacts(&scene.contacts, code);
    code.push_str("], joints: ");
    joints(scene, code);
    let _ = write!(
        code,
        ", explicit_time: {}, free_jacobian: {}, free_hessian: {}, optimal_control: {}, kernels: &[",
        scene.explicit_time,
        pattern(&scene.motion.jacobian),
        pattern(&scene.motion.hessian),
        optimal_control(scene.optimal_control.as_ref())
    );
    for kernel in scene.listed() {
        let _ = write!(
            code,
            "::hangtime::model::Kernel {{ name: {:?}, operations: {}, outputs: {} }},",
            kernel.name,
            kernel.cost(),
            kernel.outputs.len()
        );
    }
    code.push_str("], equations: &[");
    for [left, right] in &scene.equations {
        let _ = write!(
            code,
            "::hangtime::model::Equation {{ left: {left:?}, right: {right:?} }},"
        );
    }
    code.push_str("] };");
}

/// Names, units and documentation, one after the other.
pub(super) fn variables(list: &[Variable]) -> String {
    let mut code = String::new();
    for quantity in list {
        let _ = write!(
            code,
            "::hangtime::model::VariableDeclaration {{ name: {:?}, unit: {:?}, documentation: {:?} }},",
            quantity.name, quantity.unit, quantity.documentation
        );
    }
    code
}

/// What is drawn.
pub(super) fn picture(picture: &Picture) -> String {
    let shapes = picture.shapes.iter().map(|shape| {
        let shape = match shape {
            Shape::Point(name) => format!("Point({name:?})"),
            Shape::Circle(name) => format!("Circle({name:?})"),
            Shape::Rectangle(name) => format!("Rectangle({name:?})"),
            Shape::Polygon(name, corners) => format!("Polygon({name:?}, {corners})"),
            Shape::Link => "Link".to_owned(),
            Shape::Spring => "Spring".to_owned(),
            Shape::Curve(name) => format!("Curve({name:?})"),
            Shape::Arc(name) => format!("Arc({name:?})"),
        };
        format!("::hangtime::model::Shape::{shape},")
    });
    let [across, up] = &picture.axes;
    let ground = match picture.ground {
        Some(ground) => format!("__Option::Some({ground:?})"),
        None => "__Option::None".to_owned(),
    };
    format!(
        "::hangtime::model::Picture {{ unit: {:?}, axes: [{across:?}, {up:?}], ground: {ground}, shapes: &[{}] }}",
        picture.unit,
        shapes.collect::<String>()
    )
}

fn contacts(contacts: &[Contact], code: &mut String) {
    for contact in contacts {
        let friction = match &contact.friction {
            None => "__Option::None".to_owned(),
            Some(friction) => format!(
                "__Option::Some(::hangtime::model::FrictionDeclaration {{ jacobian: {}, hessian: {}, kinetic: {}, share: {}, across: {} }})",
                pattern(&friction.rows.jacobian),
                pattern(&friction.rows.hessian),
                friction.kinetic.is_some(),
                friction.share.is_some(),
                match &friction.across {
                    None => "__Option::None".to_owned(),
                    Some((_, rows)) => format!("__Option::Some({})", pattern(&rows.jacobian)),
                }
            ),
        };
        let _ = write!(
            code,
            "::hangtime::model::ContactDeclaration {{ name: {:?}, unit: {:?}, law: \
             ::hangtime::model::ImpactLaw::{}, friction: {friction}, dry: {}, loads: &{:?}, switch: {}, custom_direction: {}, held: &{:?}, \
             sequence: {}, alternatives: &{:?}, jacobian: {}, hessian: {}, documentation: {:?} }},",
            contact.name,
            contact.unit,
            if contact.restitution.is_some() {
                "Restitution"
            } else {
                "Inelastic"
            },
            contact.dry,
            contact
                .loads
                .as_ref()
                .map_or(&[][..], |(surfaces, _)| surfaces),
            match contact.switch {
                _ if contact.reset.is_some() => {
                    "__Option::Some(::hangtime::model::Switching::Resets)"
                }
                None => "__Option::None",
                Some(true) => "__Option::Some(::hangtime::model::Switching::Passes)",
                Some(false) => "__Option::Some(::hangtime::model::Switching::Slides)",
            },
            contact.custom_direction,
            contact.held,
            contact.sequence,
            contact.alternatives,
            pattern(&contact.rows.jacobian),
            pattern(&contact.rows.hessian),
            contact.documentation
        );
    }
}

fn joints(scene: &Description, code: &mut String) {
    let Some(joints) = &scene.joints else {
        return code.push_str("__Option::None");
    };
    code.push_str("__Option::Some(::hangtime::model::JointsDeclaration { list: &[");
    for joint in &joints.list {
        let _ = write!(
            code,
            "::hangtime::model::JointDeclaration {{ name: {:?}, unit: {:?}, rows: {}, holonomic: {}, documentation: \
             {:?} }},",
            joint.name, joint.unit, joint.rows, joint.holonomic, joint.documentation
        );
    }
    let _ = write!(
        code,
        "], jacobian: {}, hessian: {} }})",
        pattern(&joints.pattern),
        pattern(&joints.hessian_pattern)
    );
}

fn optimal_control(task: Option<&OptimalControl>) -> String {
    let Some(task) = task else {
        return "__Option::None".to_owned();
    };
    format!(
        "__Option::Some(::hangtime::model::OptimalControlDeclaration {{ running_cost: {}, final_cost: {}, \
         constraints: &[{}], goals: &[{}], free_time: {}, free_start: &{:?}, path_jacobian: {}, \
         path_hessian: {}, terminal_jacobian: {}, terminal_hessian: {}, contacts: {} }})",
        task.running_cost,
        task.final_cost,
        conditions(&task.constraints),
        conditions(&task.goals),
        task.free_time,
        task.free_start,
        pattern(&task.path.jacobian),
        pattern(&task.path.hessian),
        pattern(&task.terminal.jacobian),
        pattern(&task.terminal.hessian),
        contact_terms(&task.contacts)
    )
}

fn contact_terms(terms: &ContactTerms) -> String {
    format!(
        "::hangtime::model::ContactTerms {{ path: {}, terminal: {}, sums: {}, constraints: &[{}], impact_jacobian: {}, \
         impact_hessian: {} }}",
        terms.path,
        terms.terminal,
        terms.sums,
        conditions(&terms.constraints),
        pattern(&terms.impact.jacobian),
        pattern(&terms.impact.hessian)
    )
}

fn conditions(conditions: &[Condition]) -> String {
    let mut code = String::new();
    for condition in conditions {
        let _ = write!(
            code,
            "::hangtime::model::ConstraintDeclaration {{ name: {:?}, unit: {:?}, equality: {}, \
             documentation: {:?} }},",
            condition.name, condition.unit, condition.equality, condition.documentation
        );
    }
    code
}

fn pattern(pattern: &Pattern) -> String {
    format!(
        "::hangtime::model::SparsityPattern {{ rows: {}, columns: {}, entries: {} }}",
        pattern.rows,
        pattern.columns,
        positions(&pattern.entries)
    )
}
