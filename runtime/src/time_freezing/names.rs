//! What the places of a local vector are called, and what they are there for.

use hangtime_solver::mpcc::Mpcc as _;

use super::field::Field;
use super::layout::Layout;
use crate::program::sparse_program::Program;
use crate::size::Purpose;

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

/// What a state is there for.
pub(super) fn purpose_of_state(layout: &Layout, place: usize) -> Purpose {
    let time = layout.time();
    match place {
        place if place < time => Purpose::State,
        place if place == time => Purpose::Clock,
        place if layout.dip_of(place).is_some() => Purpose::Restitution,
        _ => Purpose::Gap,
    }
}

/// What a place is there for.
pub(super) fn purpose(layout: &Layout, place: usize) -> Purpose {
    if place < layout.states() {
        return purpose_of_state(layout, place);
    }
    if place < layout.first_algebraic() {
        return Purpose::Control;
    }
    match layout.algebraic_symbol(place) {
        Some(("alpha" | "beta" | "lp" | "ln" | "p" | "w", _)) => Purpose::StepFunction,
        Some(("f" | "r", _)) => Purpose::Restitution,
        Some(("ahead" | "behind", _)) => Purpose::Edge,
        Some(_) => Purpose::Friction,
        None => Purpose::SeveralContacts,
    }
}

/// What the sums of a group are there for.
pub(super) fn purpose_of_sums(layout: &Layout, group: usize) -> Purpose {
    match group.checked_sub(layout.contacts()) {
        None => Purpose::CrossComplementarity,
        Some(rough) if rough < layout.frictions() => Purpose::Friction,
        Some(_) => Purpose::Restitution,
    }
}
