//! Names, units and bounds of the quantities of a motion.

use crate::Quantity;
use hangtime::model::Model;

use crate::table::{headed, per_second};

/// Unit of the contact forces of a gap in metres.
const FORCE: &str = "N";
/// Unit of dry friction in a joint that turns.
const TORQUE: &str = "N m";

/// Every quantity of a scene, in the order in which figures show them.
pub(crate) fn all(model: &dyn Model) -> Vec<Quantity> {
    let declaration = model.declaration();
    let coordinates = 0..declaration.mechanical();
    let states = declaration.mechanical()..declaration.coordinates.len();
    let contacts = || 0..declaration.contacts.len();
    let presses = |&contact: &usize| !declaration.contacts[contact].dry;
    let rubs = |&contact: &usize| declaration.contacts[contact].friction.is_some();
    coordinates
        .flat_map(|i| [Quantity::Coordinate(i), Quantity::Velocity(i)])
        .chain(states.map(Quantity::Velocity))
        .chain((0..declaration.controls.len()).map(Quantity::Control))
        .chain(contacts().filter(presses).map(Quantity::ContactForce))
        .chain(contacts().filter(rubs).map(Quantity::FrictionForce))
        .chain((0..model.outputs().len()).map(Quantity::Output))
        .collect()
}

/// Name of a quantity in a table of its kind: that of its coordinate, control or contact; `dy/dt` for a velocity.
pub(crate) fn name(model: &dyn Model, quantity: Quantity) -> String {
    match quantity {
        Quantity::ContactForce(i) | Quantity::FrictionForce(i) => {
            model.declaration().contacts[i].name.to_owned()
        }
        _ => symbol(model, quantity),
    }
}

/// Symbol of a quantity: `y`, `dy/dt`, `u`.
pub(crate) fn symbol(model: &dyn Model, quantity: Quantity) -> String {
    let declaration = model.declaration();
    match quantity {
        Quantity::Output(i) => model.outputs()[i].name.to_owned(),
        Quantity::Coordinate(i) => declaration.coordinates[i].name.to_owned(),
        Quantity::Velocity(i) => match declaration.state(i) {
            Some(state) => state.name.to_owned(),
            None => format!("d{}/dt", declaration.coordinates[i].name),
        },
        Quantity::Control(i) => declaration.controls[i].name.to_owned(),
        Quantity::FrictionForce(i) if declaration.contacts[i].switch.is_some() => {
            declaration.contacts[i].name.to_owned()
        }
        Quantity::ContactForce(i) if declaration.contacts[i].dry => {
            format!("friction bound {}", declaration.contacts[i].name)
        }
        Quantity::ContactForce(i) => format!("contact force {}", declaration.contacts[i].name),
        Quantity::FrictionForce(i) => format!("friction force {}", declaration.contacts[i].name),
    }
}

/// Declared unit of a quantity.
pub(crate) fn unit(model: &dyn Model, quantity: Quantity) -> String {
    let declaration = model.declaration();
    match quantity {
        Quantity::Output(i) => model.outputs()[i].unit.to_owned(),
        Quantity::Coordinate(i) => declaration.coordinates[i].unit.to_owned(),
        Quantity::Velocity(i) => match declaration.state(i) {
            Some(state) => state.unit.to_owned(),
            None => per_second(declaration.coordinates[i].unit),
        },
        Quantity::Control(i) => declaration.controls[i].unit.to_owned(),
        Quantity::ContactForce(i) | Quantity::FrictionForce(i) => {
            let contact = &declaration.contacts[i];
            if contact.switch.is_some() {
                return String::new();
            }
            let has_units = || declaration.coordinates.iter().any(|c| !c.unit.is_empty());
            if contact.unit == "m" {
                FORCE.to_owned()
            } else if contact.dry && contact.unit.is_empty() && has_units() {
                TORQUE.to_owned()
            } else {
                String::new()
            }
        }
    }
}

/// Symbol with unit, for an axis.
pub(crate) fn label(model: &dyn Model, quantity: Quantity, unit: &str) -> String {
    let symbol = match quantity {
        Quantity::ContactForce(_) | Quantity::FrictionForce(_) => "force".to_owned(),
        _ => symbol(model, quantity),
    };
    headed(&symbol, unit)
}

/// What a quantity is, in words: the first sentence of its documentation.
pub(crate) fn title(model: &dyn Model, quantity: Quantity) -> String {
    let declaration = model.declaration();
    let documentation = match quantity {
        Quantity::Coordinate(i) => declaration.coordinates[i].documentation,
        Quantity::Velocity(i) => match declaration.state(i) {
            Some(state) => state.documentation,
            None => return format!("Rate of change of {}", declaration.coordinates[i].name),
        },
        Quantity::Control(i) => declaration.controls[i].documentation,
        Quantity::Output(i) => model.outputs()[i].documentation,
        Quantity::ContactForce(i) if declaration.contacts[i].dry => {
            return format!("Bound of the friction of {}", declaration.contacts[i].name);
        }
        Quantity::FrictionForce(i) if declaration.contacts[i].switch.is_some() => {
            return format!("Switch {}", declaration.contacts[i].name);
        }
        Quantity::FrictionForce(i) if declaration.contacts[i].dry => {
            return format!("Friction of {}", declaration.contacts[i].name);
        }
        Quantity::ContactForce(i) => {
            return format!("Contact force of {}", declaration.contacts[i].name);
        }
        Quantity::FrictionForce(i) => {
            return format!("Friction force of {}", declaration.contacts[i].name);
        }
    };
    let sentence = documentation.split('.').next().unwrap_or_default();
    let words: Vec<&str> = sentence.split_whitespace().collect();
    if words.is_empty() {
        symbol(model, quantity)
    } else {
        words.join(" ")
    }
}

/// The finite declared bounds of a quantity, in its declared unit.
pub(crate) fn bounds(model: &dyn Model, quantity: Quantity) -> Vec<f64> {
    let declaration = model.declaration();
    let coordinates = declaration.coordinates.len();
    let length = coordinates + declaration.controls.len();
    let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; length], vec![f64::INFINITY; length]);
    model.bounds(&mut lower, &mut upper);
    let index = match quantity {
        Quantity::Coordinate(i) => i,
        Quantity::Control(i) => coordinates + i,
        Quantity::Velocity(_)
        | Quantity::ContactForce(_)
        | Quantity::FrictionForce(_)
        | Quantity::Output(_) => {
            return Vec::new();
        }
    };
    let both = [lower[index], upper[index]];
    both.into_iter().filter(|bound| bound.is_finite()).collect()
}

/// A value of a quantity in `to` instead of its declared unit.
pub(crate) fn converted(
    model: &dyn Model,
    quantity: Quantity,
    value: f64,
    to: &str,
) -> Option<f64> {
    let from = unit(model, quantity);
    hangtime_units::convert(value, &from, to).ok()
}
