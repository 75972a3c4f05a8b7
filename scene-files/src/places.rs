//! Where derivatives of described rows stand in the layouts of the model trait.

use hangtime::model::{contact_point, tangent_point};
use hangtime_dsl::description::Pattern;

/// Puts the nonzeros of a matrix into the rows that `row` names, of a dense one with as many columns.
pub(crate) fn scatter(
    pattern: &Pattern,
    values: &[f64],
    row: impl Fn(usize) -> usize,
    out: &mut [f64],
) {
    for (&(from, column), value) in pattern.entries.iter().zip(values) {
        out[row(from) * pattern.columns + column] = *value;
    }
}

/// Gap, normal velocity and direction, of `n` coordinates.
pub(crate) fn of_contact(n: usize, row: usize) -> usize {
    match row {
        0 => contact_point::GAP,
        1 => contact_point::NORMAL_VELOCITY,
        row => contact_point::direction(n) + row - 2,
    }
}

/// Curvature, inverse inertia and normal.
pub(crate) fn of_geometry(row: usize) -> usize {
    match row {
        0 => contact_point::CURVATURE,
        1 => contact_point::INVERSE_INERTIA,
        row => contact_point::NORMAL + row - 2,
    }
}

/// Sliding velocity and direction, of `n` coordinates.
pub(crate) fn of_friction(n: usize, row: usize) -> usize {
    match row {
        0 => tangent_point::SLIDING_VELOCITY,
        row => tangent_point::direction(n) + row - 1,
    }
}

/// Curvature and tangent.
pub(crate) fn of_tangent_geometry(row: usize) -> usize {
    match row {
        0 => tangent_point::CURVATURE,
        row => tangent_point::TANGENT + row - 1,
    }
}
