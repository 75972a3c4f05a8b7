//! The functions of one contact.

use super::builder::{Builder, PRIVATE, Pattern, positions};
use crate::derive::{ContactEquations, Explicit, FrictionEquations, Implicit, InverseInertia};
use crate::graph::Sym;
use crate::scene::Contact;
use std::fmt::Write;

/// Bodies of the methods that concern one contact, and patterns.
pub(in crate::emit) struct ContactPlan {
    pub(in crate::emit) gap: String,
    pub(in crate::emit) contact: String,
    pub(in crate::emit) derivatives: Derivatives,
    /// Value of the coefficient, if there is one.
    pub(in crate::emit) restitution: Option<String>,
    pub(in crate::emit) friction: Option<FrictionPlan>,
}

/// Bodies of the methods that concern the friction of one contact.
pub(in crate::emit) struct FrictionPlan {
    pub(in crate::emit) coefficient: String,
    pub(in crate::emit) tangent: String,
    pub(in crate::emit) derivatives: Derivatives,
}

/// Bodies of the methods for the derivatives of some rows, with their patterns.
pub(in crate::emit) struct Derivatives {
    pub(in crate::emit) jacobian: String,
    pub(in crate::emit) hessian: String,
    pub(in crate::emit) jacobian_pattern: Pattern,
    pub(in crate::emit) hessian_pattern: Pattern,
}

pub(super) fn contact(
    builder: &mut Builder<'_>,
    declared: &Contact,
    contact: &ContactEquations,
) -> ContactPlan {
    let name = &declared.name.text;
    let n = contact.normal.len();
    let rows = &contact.rows;
    let gap = builder.call(
        &format!("gap_{name}"),
        &rows.values[..1],
        "x",
        "&[]",
        "&mut out",
    );
    let mut point = vec![rows.values[0], rows.values[1], contact.curvature];
    point.push(match contact.inverse_inertia {
        InverseInertia::Formula(inverse_inertia) => inverse_inertia,
        InverseInertia::Solved => Sym::ZERO,
    });
    point.extend(&contact.normal);
    point.extend(&rows.values[2..]);
    let base = point_call(
        builder,
        &format!("contact_{name}"),
        &point,
        &contact.direction,
    );
    let system = format!("direction_{name}");
    let derivatives = derivatives(
        builder,
        &format!("contact_{{}}_{name}"),
        rows,
        contact
            .direction
            .as_ref()
            .map(|solved| (system.as_str(), solved)),
    );
    let contact_body = match (&contact.direction, &contact.inverse_inertia) {
        (None, InverseInertia::Formula(_)) => base,
        (None, InverseInertia::Solved) => format!(
            "{base}; let (lu, _) = __motion_solution(self, x); let mut n = [0.0_f64; {n}]; \
             n.copy_from_slice(&point[4..{}]); point[3] = lu.solve(&n).iter().zip(&n).map(|(a, \
             b)| a * b).sum()",
            4 + n
        ),
        (Some(solved), _) => format!(
            "{base}; let (_, y) = __{system}_solution(self, x); \
             point[{}..].copy_from_slice(&y[{}..{}]); point[3] = 1.0 / y[{}]",
            point.len(),
            solved.size,
            solved.size + n,
            2 * solved.size - 1
        ),
    };
    ContactPlan {
        gap,
        contact: contact_body,
        derivatives,
        restitution: declared.restitution.map(|coefficient| {
            coefficient_body(builder, &format!("restitution_{name}"), coefficient)
        }),
        friction: declared
            .friction
            .as_ref()
            .zip(contact.friction.as_ref())
            .map(|(declared, friction)| {
                friction_plan(builder, name, declared.coefficient, friction)
            }),
    }
}

fn friction_plan(
    builder: &mut Builder<'_>,
    name: &str,
    coefficient: Sym,
    friction: &FrictionEquations,
) -> FrictionPlan {
    let n = friction.tangent.len();
    let rows = &friction.rows;
    let mut point = vec![rows.values[0], friction.curvature];
    point.extend(&friction.tangent);
    point.extend(&rows.values[1..]);
    let base = point_call(
        builder,
        &format!("tangent_{name}"),
        &point,
        &friction.direction,
    );
    let system = format!("friction_direction_{name}");
    let derivatives = derivatives(
        builder,
        &format!("tangent_{{}}_{name}"),
        rows,
        friction
            .direction
            .as_ref()
            .map(|solved| (system.as_str(), solved)),
    );
    let tangent = match &friction.direction {
        None => base,
        Some(solved) => format!(
            "{base}; let (_, y) = __{system}_solution(self, x); \
             point[{}..].copy_from_slice(&y[{}..{}])",
            point.len(),
            solved.size,
            solved.size + n
        ),
    };
    FrictionPlan {
        coefficient: coefficient_body(builder, &format!("friction_{name}"), coefficient),
        tangent,
        derivatives,
    }
}

/// The values at one point, as far as they are formulas.
fn point_call(
    builder: &mut Builder<'_>,
    kernel: &str,
    point: &[Sym],
    solved: &Option<Implicit>,
) -> String {
    let out = match solved {
        None => "point".to_owned(),
        Some(_) => format!("&mut point[..{}]", point.len()),
    };
    builder.call(kernel, point, "x", "&[]", &out)
}

/// A number that depends on parameters only.
fn coefficient_body(builder: &mut Builder<'_>, kernel: &str, coefficient: Sym) -> String {
    let call = builder.unlisted(kernel, &[coefficient], "&mut out");
    format!("let mut out = [0.0_f64]; {call}; out[0]")
}

/// Jacobian and Hessian of rows that are formulas; `kernel` as below.
fn formulas(builder: &mut Builder<'_>, kernel: &str, rows: &Explicit) -> Derivatives {
    let (jacobian, hessian) = (&rows.jacobian, &rows.hessian);
    let kernels = ["jacobian", "hessian"].map(|what| kernel.replace("{}", what));
    Derivatives {
        jacobian: builder.call(&kernels[0], &jacobian.values, "x", "&[]", "values"),
        hessian: builder.call(&kernels[1], &hessian.values, "x", "multipliers", "values"),
        jacobian_pattern: Pattern::of(jacobian),
        hessian_pattern: Pattern::of(hessian),
    }
}

/// Jacobian and Hessian of rows that are formulas, followed by the solution of a linear system with
/// this name if there is one. `kernel` is the name of the functions, `{}` in it what they compute.
fn derivatives(
    builder: &mut Builder<'_>,
    kernel: &str,
    rows: &Explicit,
    solved: Option<(&str, &Implicit)>,
) -> Derivatives {
    let Some((system, solved)) = solved else {
        return formulas(builder, kernel, rows);
    };
    let jacobian_kernel = kernel.replace("{}", "jacobian");
    let hessian_kernel = kernel.replace("{}", "hessian");
    let first = rows.jacobian.values.len();
    let formulas = rows.values.len();
    let n = builder.scene.coordinates.len();
    let geometry_jacobian = builder.call(
        &jacobian_kernel,
        &rows.jacobian.values,
        "x",
        "&[]",
        &format!("&mut values[..{first}]"),
    );
    let size = builder.system(system, solved).size;
    let solved_entries = solved.jacobian_pattern(n);
    let mut jacobian_entries = rows.jacobian.entries.clone();
    jacobian_entries.extend(
        solved_entries
            .iter()
            .map(|&(row, column)| (row + formulas, column)),
    );
    let mut hessian_entries = solved.hessian_pattern();
    hessian_entries.extend(&rows.hessian.entries);
    hessian_entries.sort_unstable();
    hessian_entries.dedup();
    let mut scatter = String::new();
    for (k, entry) in rows.hessian.entries.iter().enumerate() {
        if let Ok(place) = hessian_entries.binary_search(entry) {
            let _ = write!(scatter, "values[{place}] += geometry[{k}];");
        }
    }
    let geometry_hessian = builder.call(
        &hessian_kernel,
        &rows.hessian.values,
        "x",
        "multipliers",
        "&mut geometry",
    );
    Derivatives {
        jacobian: format!(
            "{geometry_jacobian}; let (lu, y) = __{system}_solution(self, x); let a = \
             __{system}_sensitivity(self, x, &lu, &y); {PRIVATE}::gather(&a, {}, &mut \
             values[{first}..])",
            positions(&solved_entries)
        ),
        hessian: format!(
            "let mut lambda = [0.0_f64; {size}]; \
             lambda[..{n}].copy_from_slice(&multipliers[{formulas}..]); __{system}_second(self, x, \
             &lambda, {}, values); let mut geometry = [0.0_f64; {}]; {geometry_hessian}; {scatter}",
            positions(&hessian_entries),
            rows.hessian.values.len()
        ),
        jacobian_pattern: Pattern {
            rows: formulas + n,
            columns: builder.inputs,
            entries: jacobian_entries,
        },
        hessian_pattern: Pattern {
            rows: builder.inputs,
            columns: builder.inputs,
            entries: hessian_entries,
        },
    }
}
