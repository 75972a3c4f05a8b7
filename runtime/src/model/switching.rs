//! How large the terms of the function of a switch are.

use super::{Function, Model};

/// Sum of the sizes of the terms of the function of a switch at `x`, which its rounding error is a share of; 0 for other contacts.
pub(crate) fn terms(model: &dyn Model, contact: usize, x: &[f64]) -> f64 {
    let declared = &model.declaration().contacts[contact];
    let (Some(_), Some(friction)) = (declared.switch, declared.friction) else {
        return 0.0;
    };
    let entries = friction.jacobian.entries;
    let mut values = vec![0.0; entries.len()];
    model.jacobian(Function::Tangent(contact), x, &mut values);
    let of_function = entries
        .iter()
        .zip(&values)
        .filter(|(entry, _)| entry.0 == 0);
    of_function
        .map(|(&(_, column), slope)| (slope * x[column as usize]).abs())
        .sum()
}
