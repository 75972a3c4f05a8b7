//! What the places of a local vector are called.

use hangtime_solver::mpcc::Mpcc as _;

use super::field::Field;
use crate::program::sparse_program::Program;

/// Name of a contact.
pub(super) fn contact(field: &Field<'_>, contact: usize) -> &'static str {
    field.model.declaration().contacts[contact].name
}

/// A place in the words of the model.
pub(super) fn local(field: &Field<'_>, place: usize) -> String {
    let declaration = field.model.declaration();
    let (n, layout) = (field.coordinates(), &field.layout);
    let (coordinates, controls) = (declaration.coordinates, declaration.controls);
    if place < 2 * n {
        let name = coordinates[place % n].name;
        return match place < n {
            true => name.to_owned(),
            false => format!("dot({name})"),
        };
    }
    if place == layout.time() {
        return "clock".to_owned();
    }
    if let Some(own) = layout.dip_of(place) {
        return format!("dip of {}", contact(field, own));
    }
    if let Some(control) = place.checked_sub(layout.states()) {
        return match (controls.get(control), layout.algebraic_symbol(place)) {
            (Some(control), _) => control.name.to_owned(),
            (None, Some((symbol, own))) => format!("{symbol} of {}", contact(field, own)),
            (None, None) => "product of step functions".to_owned(),
        };
    }
    let own = place - layout.lifted_gap(0);
    format!("lifted gap of {}", contact(field, own))
}

/// Name of a complementarity pair: what complements each other, and where.
pub(super) fn pair(program: &Program<'_>, index: usize) -> String {
    let (i, j) = program.complementarities()[index];
    let [first, second] = [i, j].map(|i| {
        let name = program.name(i);
        name.strip_prefix("sum of ").unwrap_or(name)
    });
    match (first.split_once(' '), second.split_once(' ')) {
        (Some((one, place)), Some((other, same))) if place == same => {
            format!("{one} _|_ {other} {place}")
        }
        _ => format!("{first} _|_ {second}"),
    }
}
