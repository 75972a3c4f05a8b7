//! Names of what a result holds, and how its numbers are written.

use crate::model::{Declaration, VariableDeclaration};

/// Digits of a number for people.
const DIGITS: usize = 7;

/// Something that a state holds, by its index in the declaration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    Time,
    Coordinate(usize),
    /// Velocity of a coordinate; those of the last coordinates are the states of first order.
    Velocity(usize),
    Control(usize),
    /// Normal force of a contact.
    Force(usize),
    /// Tangential force of a contact.
    Friction(usize),
    /// Normal impulse of all impacts of a contact so far.
    Impulse(usize),
    /// Tangential impulse of all impacts of a contact so far.
    FrictionImpulse(usize),
    /// What the scene declares in `outputs`.
    Output(usize),
}

impl Quantity {
    /// The quantity with a name such as `z`, `dot(z)`, `u`, `force(floor)`, `friction_force(floor)` or `friction(floor)`,
    /// `impulse(floor)`, `friction_impulse(floor)`, `time`, or that of one of the `outputs`.
    pub(crate) fn named(
        declaration: &Declaration,
        outputs: &[VariableDeclaration],
        name: &str,
    ) -> Option<Self> {
        let argument = |function: &str| {
            let rest = name.strip_prefix(function)?.trim_start();
            Some(rest.strip_prefix('(')?.strip_suffix(')')?.trim())
        };
        let coordinate = |name: &str| declaration.coordinates.iter().position(|c| c.name == name);
        let state = || {
            let mut states = declaration.states.iter();
            let state = states.position(|known| known.name == name);
            state.map(|state| Self::Velocity(declaration.mechanical() + state))
        };
        let contact = |name: &str| declaration.contacts.iter().position(|c| c.name == name);
        if let Some(name) = argument("dot") {
            return coordinate(name).map(Self::Velocity);
        }
        let of_contact = |function: &str| argument(function).and_then(contact);
        let quantity = (of_contact("force").map(Self::Force))
            .or_else(|| of_contact("friction").map(Self::Friction))
            .or_else(|| of_contact("friction_force").map(Self::Friction))
            .or_else(|| of_contact("impulse").map(Self::Impulse))
            .or_else(|| of_contact("friction_impulse").map(Self::FrictionImpulse));
        if quantity.is_some() {
            return quantity;
        }
        let control = || declaration.controls.iter().position(|c| c.name == name);
        let time = (name == "time").then_some(Self::Time);
        coordinate(name)
            .map(Self::Coordinate)
            .or_else(state)
            .or_else(|| control().map(Self::Control))
            .or(time)
            .or_else(|| {
                outputs
                    .iter()
                    .position(|o| o.name == name)
                    .map(Self::Output)
            })
    }

    /// Why `name` is none, with the names that there are.
    pub(super) fn unknown(
        declaration: &Declaration,
        outputs: &[VariableDeclaration],
        name: &str,
    ) -> String {
        let mechanical = &declaration.coordinates[..declaration.mechanical()];
        let coordinates = mechanical.iter().map(|c| c.name.to_owned());
        let velocities = mechanical.iter().map(|c| format!("dot({})", c.name));
        let states = declaration.states.iter().map(|known| known.name.to_owned());
        let controls = declaration.controls.iter().map(|c| c.name.to_owned());
        let forces = declaration
            .contacts
            .iter()
            .map(|c| format!("force({})", c.name));
        let rubbing = declaration.contacts.iter().filter(|c| c.friction.is_some());
        let frictions = rubbing.map(|c| format!("friction_force({})", c.name));
        let striking = declaration.contacts.iter().filter(|c| !c.dry);
        let impulses = striking.map(|c| format!("impulse({})", c.name));
        let all = coordinates
            .chain(velocities)
            .chain(states)
            .chain(controls)
            .chain(forces)
            .chain(frictions)
            .chain(impulses)
            .chain(outputs.iter().map(|o| o.name.to_owned()));
        let names: Vec<String> = all.collect();
        format!(
            "`{}` has no `{name}`; it has {}, time",
            declaration.name,
            names.join(", ")
        )
    }
}

/// The unit of a velocity whose coordinate has `unit`, or of an angle's.
pub(crate) fn per_second(unit: &str) -> String {
    format!("{}/s", if unit.is_empty() { "1" } else { unit })
}

/// A number for people: up to seven digits.
pub(crate) fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        return "0".into();
    }
    if !(1e-4..1e7).contains(&size) {
        return format!("{value:.*e}", DIGITS - 1);
    }
    let whole = size.log10().floor() as i32 + 1;
    let decimals = (DIGITS as i32 - whole.max(1)).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if decimals == 0 {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn number_has_up_to_seven_digits_whatever_its_size() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1000.0, "1000"),
            (-1.2 - 1e-12, "-1.2"),
            (9_999_999.0, "9999999"),
            (1.406_262_14, "1.406262"),
            (-123.456_789, "-123.4568"),
            (0.012_345_678, "0.012346"),
            (2.5e-7, "2.500000e-7"),
            (1e9, "1.000000e9"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
