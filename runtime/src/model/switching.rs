//! How large the terms of the function of a switch are.

use super::Model;

/// Share of the terms of a function that is less than it is anywhere but beside its zeros and beside a pole, where they grow like the square
/// of it.
const NEAR: f64 = 1e-3;

/// Whether a function of a switch, whose terms were as large as `so_far`, has this `value` of these `terms` beside a pole: they say nothing of
/// its zeros.
pub(crate) fn is_beside_pole(value: f64, terms: f64, so_far: f64) -> bool {
    so_far > 0.0 && value.abs() > so_far && value.abs() < NEAR * terms
}

/// Sum of the sizes of the terms of the function of a switch at `x`, which its rounding error is a share of; 0 for other contacts.
pub(crate) fn terms(model: &dyn Model, contact: usize, x: &[f64]) -> f64 {
    let declared = &model.declaration().contacts[contact];
    let (Some(_), Some(friction)) = (declared.switch, declared.friction) else {
        return 0.0;
    };
    let entries = friction.jacobian.entries;
    let mut values = vec![0.0; entries.len()];
    model.tangent_jacobian(contact, x, &mut values);
    let of_function = entries
        .iter()
        .zip(&values)
        .filter(|(entry, _)| entry.0 == 0);
    of_function
        .map(|(&(_, column), slope)| (slope * x[column as usize]).abs())
        .sum()
}
