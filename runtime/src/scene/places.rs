//! Where derivatives of described rows stand in the layouts of the model trait.

use crate::model::{SparsityPattern, contact_point, tangent_point};

/// Puts the nonzeros of a matrix into the rows that `row` names, of a dense one with as many columns.
pub(super) fn scatter(
    pattern: SparsityPattern,
    values: &[f64],
    row: impl Fn(usize) -> usize,
    out: &mut [f64],
) {
    for (&(from, column), value) in pattern.entries.iter().zip(values) {
        out[row(from as usize) * pattern.columns + column as usize] = *value;
    }
}

/// Gap, normal velocity and direction, of `n` coordinates.
pub(super) fn of_contact(n: usize, row: usize) -> usize {
    match row {
        0 => contact_point::GAP,
        1 => contact_point::NORMAL_VELOCITY,
        row => contact_point::direction(n) + row - 2,
    }
}

/// Curvature, inverse inertia and normal.
pub(super) fn of_geometry(row: usize) -> usize {
    match row {
        0 => contact_point::CURVATURE,
        1 => contact_point::INVERSE_INERTIA,
        row => contact_point::NORMAL + row - 2,
    }
}

/// Sliding velocity and direction, of `n` coordinates.
pub(super) fn of_friction(n: usize, row: usize) -> usize {
    match row {
        0 => tangent_point::SLIDING_VELOCITY,
        row => tangent_point::direction(n) + row - 1,
    }
}

/// Curvature and tangent.
pub(super) fn of_tangent_geometry(row: usize) -> usize {
    match row {
        0 => tangent_point::CURVATURE,
        row => tangent_point::TANGENT + row - 1,
    }
}
