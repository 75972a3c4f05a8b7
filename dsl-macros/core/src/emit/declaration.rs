//! The static description of a scene.

use super::Timing;
use super::kernel::literal;
use super::plan::{Pattern, Plan};
use super::readable::formula;
use super::structure::text;
use crate::ast::WrittenUnit;
use crate::derive::{Equations, InverseInertia, Solution};
use crate::graph::Sym;
use crate::scene::CheckedScene;
use hangtime_units::Unit;
use std::fmt::Write;

/// Writes `static DECLARATION`.
pub(super) fn write(
    scene: &CheckedScene,
    equations: &Equations,
    plan: &Plan,
    timing: &Timing,
    code: &mut String,
) {
    let expanded_at = timing
        .expanded_at
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0.0, |since| since.as_secs_f64());
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
    for (field, kind, list) in [
        ("coordinates", "CoordinateDeclaration", &scene.coordinates),
        ("controls", "ControlDeclaration", &scene.controls),
    ] {
        let _ = write!(code, "], {field}: &[");
        for quantity in list {
            let _ = write!(
                code,
                "::hangtime::model::{kind} {{ name: {:?}, unit: {:?}, documentation: {:?} }},",
                quantity.name.text,
                unit(quantity.unit.as_ref()),
                text(&quantity.documentation)
            );
        }
    }
    code.push_str("], contacts: &[");
    for (contact, [jacobian, hessian]) in scene.contacts.iter().zip(&plan.contact_patterns) {
        let _ = write!(
            code,
            "::hangtime::model::ContactDeclaration {{ name: {:?}, unit: {:?}, law: \
             ::hangtime::model::ImpactLaw::Inelastic, friction: None, custom_direction: {}, held: &[], jacobian: {}, hessian: {}, \
             documentation: {:?} }},",
            contact.name.text,
            contact
                .unit
                .map_or_else(String::new, |unit| unit.to_string()),
            contact.along.is_some(),
            pattern(jacobian),
            pattern(hessian),
            text(&contact.documentation)
        );
    }
    let _ = write!(
        code,
        "], explicit_time: {}, free_jacobian: {}, free_hessian: {}, optimal_control: None, \
         kernels: &[",
        scene.explicit_time,
        pattern(&plan.free_patterns[0]),
        pattern(&plan.free_patterns[1])
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
    for (left, right) in formulas(scene, equations) {
        let _ = write!(
            code,
            "::hangtime::model::Equation {{ left: {left:?}, right: {right:?} }},"
        );
    }
    let _ = write!(
        code,
        "], derivation_seconds: {}, expanded_at: {} }};",
        literal(timing.derivation.as_secs_f64()),
        literal(expanded_at)
    );
}

fn unit(written: Option<&WrittenUnit>) -> &str {
    written.map_or("", |unit| unit.text.as_str())
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

/// The derived equations in readable form.
fn formulas(scene: &CheckedScene, equations: &Equations) -> Vec<(String, String)> {
    let mut all = Vec::new();
    let names: Vec<&str> = scene
        .coordinates
        .iter()
        .map(|coordinate| coordinate.name.text.as_str())
        .collect();
    let n = names.len();
    let mut add = |left: String, right: Sym| all.push((left, formula(scene, right)));
    for i in 0..n {
        for j in 0..=i {
            let entry = equations.mass[i * n + j];
            if !entry.is_structural_zero() {
                add(format!("M({}, {})", names[i], names[j]), entry);
            }
        }
    }
    add("kinetic energy".to_owned(), equations.energy[0]);
    add("potential energy".to_owned(), equations.energy[1]);
    match &equations.acceleration {
        Solution::Explicit(solution) if equations.readable => {
            for (name, &acceleration) in names.iter().zip(&solution.values) {
                add(format!("{name}''"), acceleration);
            }
        }
        _ => {
            for (name, &right) in names.iter().zip(&equations.right) {
                add(format!("(M q'')({name})"), right);
            }
        }
    }
    for (contact, derived) in scene.contacts.iter().zip(&equations.contacts) {
        let contact = &contact.name.text;
        add(format!("gap({contact})"), derived.rows.values[0]);
        add(format!("gap({contact})'"), derived.rows.values[1]);
        if !equations.readable {
            continue;
        }
        if let InverseInertia::Formula(inverse_inertia) = derived.inverse_inertia {
            add(format!("D({contact})"), inverse_inertia);
        }
        for (name, &component) in names.iter().zip(&derived.rows.values[2..]) {
            add(format!("d({contact}, {name})"), component);
        }
    }
    all
}
