//! Directions that are solved for with the inertia of the scene: calls, and the functions that they are of.

use super::kernel::function;
use crate::description::{Description, Inertia, Rows, Solver, Vectors};
use std::fmt::Write;

/// What emitted code needs of the runtime.
pub(super) const PRIVATE: &str = "::hangtime::__private";

/// The call that writes a direction and gives the inverse inertia along its normal.
pub(super) fn direction(name: &str, out: &str) -> String {
    format!(
        "__{name}_with(self, |inertia, vectors| {PRIVATE}::direction(inertia, vectors, x, {out}))"
    )
}

/// The call that writes derivatives of a direction at these places.
pub(super) fn jacobian(name: &str, places: &str, out: &str) -> String {
    format!(
        "__{name}_with(self, |inertia, vectors| {PRIVATE}::direction_jacobian(inertia, vectors, x, ({places}, 0), \
         {out}))"
    )
}

/// The call that writes second derivatives of a weighted direction at these places.
pub(super) fn hessian(name: &str, weights: &str, places: &str, out: &str) -> String {
    format!(
        "__{name}_with(self, |inertia, vectors| {PRIVATE}::direction_hessian(inertia, vectors, (x, {weights}), {places}, \
         {out}))"
    )
}

/// The functions that lend the inertia and the vectors of each direction, for the scene called `scene`.
pub(super) fn helpers(description: &Description, scene: &str, code: &mut String) {
    let Some(inertia) = &description.inertia else {
        return;
    };
    of_inertia(description, inertia, scene, code);
    for contact in &description.contacts {
        let friction = contact.friction.iter();
        let sides = friction.flat_map(|friction| {
            let across = friction.across.iter().map(|(_, rows)| rows);
            std::iter::once(&friction.rows).chain(across)
        });
        for rows in std::iter::once(&contact.rows).chain(sides) {
            if let Some(vectors) = vectors(rows) {
                of_vectors(description, vectors, scene, code);
            }
        }
    }
}

fn vectors(rows: &Rows) -> Option<&Vectors> {
    match &rows.solved.as_ref()?.by {
        Solver::Inertia(vectors) => Some(vectors),
        Solver::System(_) => None,
    }
}

/// A kernel as a closure over the scene `p`.
fn closure(description: &Description, kernel: usize) -> String {
    let kernel = function(description, kernel);
    format!("&|x: &[__f64], y: &[__f64], out: &mut [__f64]| {kernel}(p, x, y, out)")
}

fn nonzeros(description: &Description, (kernel, places): &(usize, Vec<(usize, usize)>)) -> String {
    format!(
        "{PRIVATE}::Nonzeros {{ kernel: {}, places: {} }}",
        closure(description, *kernel),
        positions(places)
    )
}

fn of_inertia(description: &Description, inertia: &Inertia, scene: &str, code: &mut String) {
    let _ = write!(
        code,
        "fn __inertia_with<T>(p: &{scene}, work: impl ::core::ops::FnOnce(&{PRIVATE}::Inertia<'_>) -> T) -> T {{
            work(&{PRIVATE}::Inertia {{ envelope: &{:?}, matrix: {}, product: {}, curvature: {}, inputs: {} }})
        }}",
        inertia.envelope,
        closure(description, inertia.matrix),
        nonzeros(description, &inertia.product),
        nonzeros(description, &inertia.curvature),
        description.columns(),
    );
}

fn of_vectors(description: &Description, vectors: &Vectors, scene: &str, code: &mut String) {
    let _ = write!(
        code,
        "fn __{}_with<T>(p: &{scene}, work: impl ::core::ops::FnOnce(&{PRIVATE}::Inertia<'_>, &{PRIVATE}::Columns<'_>) \
         -> T) -> T {{
            __inertia_with(p, |inertia| work(inertia, &{PRIVATE}::Columns {{ count: {}, bordered: {}, values: {}, \
         jacobian: {}, hessian: {} }}))
        }}",
        vectors.name,
        vectors.count,
        vectors.bordered,
        closure(description, vectors.values),
        nonzeros(description, &vectors.jacobian),
        nonzeros(description, &vectors.hessian),
    );
}

/// Positions of a matrix as a Rust slice.
pub(super) fn positions(entries: &[(usize, usize)]) -> String {
    let mut text = String::from("&[");
    for (row, column) in entries {
        let _ = write!(text, "({row}, {column}),");
    }
    text.push(']');
    text
}
