//! Layouts of what is known at a contact, and where derivatives of rows stand in them.

use super::data::SparsityPattern;

/// Layout of the output of `Model::contact`.
pub mod contact_point {
    /// Gap `g` [unit of the surface].
    pub const GAP: usize = 0;
    /// Normal velocity `v_n = n' v` (plus the gap's explicit time derivative).
    pub const NORMAL_VELOCITY: usize = 1;
    /// Velocity-dependent part of the normal acceleration, `v' (hess g) v` (plus explicit time
    /// terms): `v_n' = n' v' + CURVATURE`.
    pub const CURVATURE: usize = 2;
    /// Inverse inertia along the normal, `D = n' M^-1 n` [1/kg for a gap in metres].
    pub const INVERSE_INERTIA: usize = 3;
    /// First component of the normal `n = grad g`, `n_q` numbers.
    pub const NORMAL: usize = 4;

    /// First component of the contact direction `d`, `n_q` numbers.
    #[must_use]
    pub const fn direction(coordinates: usize) -> usize {
        NORMAL + coordinates
    }

    /// Length of the whole layout.
    #[must_use]
    pub const fn length(coordinates: usize) -> usize {
        NORMAL + 2 * coordinates
    }
}

/// Layout of the output of `Model::tangent`.
pub mod tangent_point {
    /// Sliding velocity `v_t = b' v` (plus what the ground moves).
    pub const SLIDING_VELOCITY: usize = 0;
    /// Part of the sliding acceleration that no force changes: `v_t' = b' v' + CURVATURE`.
    pub const CURVATURE: usize = 1;
    /// First component of the tangent `b = d v_t / dv`, `n_q` numbers.
    pub const TANGENT: usize = 2;

    /// First component of the friction direction `e = M^-1 b / D`, `n_q` numbers.
    #[must_use]
    pub const fn direction(coordinates: usize) -> usize {
        TANGENT + coordinates
    }

    /// Length of the whole layout.
    #[must_use]
    pub const fn length(coordinates: usize) -> usize {
        TANGENT + 2 * coordinates
    }
}

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
