//! All contacts of a scene, of which those that differ in the names of their coordinates only share kernels.

use super::builder::Builder;
use super::contact::{self, Contact, Friction, Rows, called, coefficients, restitution, surface};
use crate::declaration::{ContactDeclaration, FrictionDeclaration, SparsityPattern, list};
use crate::derive::{Derived, Equations, Names};
use crate::scene;

/// What is declared of all contacts, and their kernels.
pub(super) fn contacts(
    builder: &mut Builder<'_>,
    equations: &Equations,
) -> (Vec<ContactDeclaration>, Vec<Contact>) {
    let mut known: Vec<(ContactDeclaration, Contact)> = Vec::new();
    let scene = builder.scene;
    for (declared, derived) in scene.contacts.iter().zip(equations.contacts.derived()) {
        let next = match derived {
            Derived::Own(own) => contact::contact(builder, declared, own),
            Derived::Like(like, names) => renamed(builder, declared, &known[*like], names),
        };
        known.push(next);
    }
    known.into_iter().unzip()
}

/// What is declared of a contact that is like another one, and its kernels: those of that one under these names.
fn renamed(
    builder: &mut Builder<'_>,
    declared: &scene::Contact,
    (declaration, kernels): &(ContactDeclaration, Contact),
    names: &Names,
) -> (ContactDeclaration, Contact) {
    let name = &called(builder, declared);
    let gap = builder.like(kernels.gap, &format!("gap_{name}"), (names, 0));
    let point = builder.like_vectors(kernels.point, &format!("contact_{name}"), 4, names);
    let rows = rows(
        builder,
        &format!("contact_{{}}_{name}"),
        kernels.rows,
        (names, 2),
    );
    let restitution = restitution(builder, name, declared);
    let both = declared.friction.as_ref().zip(kernels.friction);
    let friction =
        both.map(|(declared, kernels)| friction(builder, name, declared, (kernels, names)));
    let contact = Contact {
        gap,
        point,
        rows,
        restitution,
        friction,
        ..*kernels
    };
    let patterns = [
        jacobian(declaration.jacobian, (names, 2)),
        hessian(declaration.hessian, names),
    ];
    let friction = declaration.friction.map(|friction| FrictionDeclaration {
        jacobian: jacobian(friction.jacobian, (names, 1)),
        hessian: hessian(friction.hessian, names),
        across: friction.across.map(|across| jacobian(across, (names, 1))),
        ..friction
    });
    (surface(declared, friction, patterns), contact)
}

fn friction(
    builder: &mut Builder<'_>,
    name: &str,
    declared: &scene::Friction,
    (kernels, names): (Friction, &Names),
) -> Friction {
    let mut side = |what: &str, point: usize, given: Rows| {
        let point = builder.like_vectors(point, &format!("{what}_{name}"), 2, names);
        let rows = rows(builder, &format!("{what}_{{}}_{name}"), given, (names, 1));
        (point, rows)
    };
    let across = kernels.across;
    let across = across.map(|(point, rows)| side("across", point, rows));
    let (tangent, rows) = side("tangent", kernels.tangent, kernels.rows);
    let (coefficient, kinetic) = coefficients(builder, name, declared);
    let share = |share| builder.like(share, &format!("friction_share_{name}"), (names, 0));
    Friction {
        coefficient,
        kinetic,
        share: kernels.share.map(share),
        tangent,
        rows,
        across,
    }
}

/// The kernels of rows, of which those behind the first few belong to coordinates.
fn rows(builder: &mut Builder<'_>, kernel: &str, rows: Rows, names: (&Names, usize)) -> Rows {
    let mut like = |what: &str, index| builder.like(index, &kernel.replace("{}", what), names);
    let (jacobian, hessian) = rows.kernels;
    Rows {
        kernels: (like("jacobian", jacobian), like("hessian", hessian)),
        ..rows
    }
}

/// The pattern of their Jacobian.
fn jacobian(pattern: SparsityPattern, (names, first): (&Names, usize)) -> SparsityPattern {
    let entries = pattern.entries.iter();
    let entries = entries.map(|&(row, column)| {
        let row = names.row(row as usize, first) as u32;
        (row, names.input(column as usize) as u32)
    });
    SparsityPattern {
        entries: list(entries),
        ..pattern
    }
}

/// The pattern of their Hessian.
fn hessian(pattern: SparsityPattern, names: &Names) -> SparsityPattern {
    let name = |i: u32| names.input(i as usize) as u32;
    let entries = pattern.entries.iter();
    SparsityPattern {
        entries: list(entries.map(|&(row, column)| (name(row), name(column)))),
        ..pattern
    }
}
