//! The linear system of a contact mode for the contact accelerations.

use super::{Dynamics, Stuck, dot};
use crate::model::{contact_point, tangent_point};
use crate::simulation::event::small_system;

/// Number of coordinates from which on rows are looked through for zeros. Chosen: below, looking takes as long as adding them.
const LARGE: usize = 16;

/// Row of the constraints that the mode keeps: the normals of active contacts, then the tangents of
/// sticking ones.
pub(super) fn constraint<'a>(dynamics: &'a Dynamics<'_>, row: usize) -> &'a [f64] {
    match dynamics.mode.active.get(row) {
        Some(&i) => dynamics.normal(i),
        None => {
            stuck(
                dynamics,
                dynamics.mode.sticking[row - dynamics.mode.active.len()],
            )
            .0
        }
    }
}

/// Tangent and direction of the force of a sliding velocity that is held.
fn stuck<'a>(dynamics: &'a Dynamics<'_>, held: Stuck) -> (&'a [f64], &'a [f64]) {
    match held.across {
        true => dynamics.across(held.contact),
        false => (
            dynamics.tangent(held.contact),
            dynamics.friction_direction(held.contact),
        ),
    }
}

/// Rate of the second sliding velocity of a contact in space under the acceleration `a`; 0 in the plane.
pub(in crate::simulation) fn across_acceleration(
    dynamics: &Dynamics<'_>,
    contact: usize,
    a: &[f64],
) -> f64 {
    dynamics.space(contact).map_or(0.0, |space| {
        let curvature = space.across(contact)[tangent_point::CURVATURE];
        curvature + dot(dynamics.across(contact).0, a)
    })
}

/// Whether the unknown of a row is the given normal force of dry friction.
pub(super) fn is_given(dynamics: &Dynamics<'_>, row: usize) -> bool {
    let contact = dynamics.mode.active.get(row);
    contact.is_some_and(|&contact| dynamics.is_dry(contact))
}

/// Direction of the unknown of a row; with `slipping` that of a sliding contact is the direction of its
/// whole force.
pub(super) fn force_direction<'a>(
    dynamics: &'a Dynamics<'_>,
    row: usize,
    slipping: bool,
) -> &'a [f64] {
    match dynamics.mode.active.get(row) {
        Some(&i) if slipping => &dynamics.equations.columns[i * dynamics.n..(i + 1) * dynamics.n],
        Some(&i) => dynamics.direction(i),
        None => {
            stuck(
                dynamics,
                dynamics.mode.sticking[row - dynamics.mode.active.len()],
            )
            .1
        }
    }
}

/// Writes what the unknowns of the first `rows` rows add to one of them.
fn couple(
    dynamics: &Dynamics<'_>,
    (row, slipping): (usize, bool),
    support: &mut Vec<usize>,
    couplings: &mut [f64],
) {
    let active = &dynamics.mode.active;
    if is_given(dynamics, row) {
        for (column, coupling) in couplings.iter_mut().enumerate() {
            let other = active.get(column);
            *coupling = other.map_or(0.0, |&other| dynamics.coupling(active[row], other));
        }
        return;
    }
    let covector = constraint(dynamics, row);
    let columns = couplings.iter_mut().enumerate();
    if dynamics.n < LARGE {
        for (column, coupling) in columns {
            *coupling = dot(covector, force_direction(dynamics, column, slipping));
        }
        return;
    }
    // A contact is between two bodies, however many there are.
    support.clear();
    support.extend((0..dynamics.n).filter(|&k| covector[k] != 0.0));
    for (column, coupling) in columns {
        let direction = force_direction(dynamics, column, slipping);
        *coupling = support.iter().map(|&k| covector[k] * direction[k]).sum();
    }
}

/// Solves for the unknowns of the first `rows` rows. Returns the sign of the determinant, `None` if they are
/// dependent.
pub(super) fn solve_rows(dynamics: &mut Dynamics<'_>, rows: usize, slipping: bool) -> Option<f64> {
    let mut couplings = std::mem::take(&mut dynamics.equations.couplings);
    let mut support = std::mem::take(&mut dynamics.equations.support);
    couplings.resize(rows * rows, 0.0);
    for (row, couplings) in couplings.chunks_exact_mut(rows.max(1)).enumerate() {
        couple(dynamics, (row, slipping), &mut support, couplings);
    }
    dynamics.equations.couplings = couplings;
    dynamics.equations.support = support;
    solve_again(dynamics, rows)
}

/// Solves the rows of the last solution for other right-hand sides.
fn solve_again(dynamics: &mut Dynamics<'_>, rows: usize) -> Option<f64> {
    let equations = &mut dynamics.equations;
    equations.matrix.clone_from(&equations.couplings);
    small_system::solve(&mut equations.matrix, &mut equations.right[..rows])
}

/// `to += sum_row column_row right_row` over the first rows.
pub(super) fn add_columns(dynamics: &Dynamics<'_>, rows: usize, slipping: bool, to: &mut [f64]) {
    for (row, factor) in dynamics.equations.right[..rows].iter().enumerate() {
        for (to, d) in to.iter_mut().zip(force_direction(dynamics, row, slipping)) {
            *to += d * factor;
        }
    }
}

/// Evaluates the active contacts, the right-hand sides of the rows of the mode, and the directions of the
/// contact forces. Returns the number of rows.
pub(super) fn evaluate_rows(dynamics: &mut Dynamics<'_>) -> usize {
    let n = dynamics.n;
    let normals = dynamics.mode.active.len();
    for slot in 0..normals {
        let i = dynamics.mode.active[slot];
        dynamics.evaluate_sides(i);
        dynamics.equations.right[slot] = -dynamics.free_normal_acceleration(i).0;
        let column = i * n..(i + 1) * n;
        dynamics.equations.columns[column.clone()].copy_from_slice(
            &dynamics.evaluated.points[i * contact_point::length(n)..]
                [contact_point::direction(n)..][..n],
        );
        let ratio = dynamics.mode.states[i].force_ratio(dynamics.laws.frictions(i));
        if ratio != 0.0 {
            let e = match dynamics.evaluated.space.as_ref() {
                Some(space) if space.contains(i) => space.slipping(i),
                _ => {
                    &dynamics.evaluated.tangents[i * tangent_point::length(n)..]
                        [tangent_point::direction(n)..][..n]
                }
            };
            for (d, e) in dynamics.equations.columns[column].iter_mut().zip(e) {
                *d += ratio * e;
            }
        }
    }
    for slot in 0..dynamics.mode.sticking.len() {
        let held = dynamics.mode.sticking[slot];
        dynamics.equations.right[normals + slot] = match held.across {
            true => -across_acceleration(dynamics, held.contact, dynamics.free_acceleration()),
            false => -dynamics.free_sliding_acceleration(held.contact).0,
        };
    }
    normals + dynamics.mode.sticking.len()
}

/// Takes the contact accelerations over from the solution of the rows.
pub(super) fn store_forces(dynamics: &mut Dynamics<'_>, rows: usize) {
    let normals = dynamics.mode.active.len();
    for slot in 0..normals {
        let i = dynamics.mode.active[slot];
        dynamics.equations.r[i] = dynamics.equations.right[slot];
        dynamics.equations.s[i] = dynamics.mode.states[i].force_ratio(dynamics.laws.frictions(i))
            * dynamics.equations.right[slot];
        dynamics.equations.across[i] = 0.0;
    }
    for slot in normals..rows {
        let held = dynamics.mode.sticking[slot - normals];
        let force = dynamics.equations.right[slot];
        match held.across {
            true => dynamics.equations.across[held.contact] = force,
            false => dynamics.equations.s[held.contact] = force,
        }
    }
}

/// Takes from the accelerations `a`, those of the last solution, what rounding has left in the rows. In them terms of the size of the forces cancel:
/// a body that sticks would fall by that for as long as it rests.
pub(super) fn refine(dynamics: &mut Dynamics<'_>, rows: usize, a: &mut [f64]) {
    let normals = dynamics.mode.active.len();
    for slot in 0..normals {
        // A given force leaves no rounding error.
        dynamics.equations.right[slot] = if is_given(dynamics, slot) {
            0.0
        } else {
            let contact = dynamics.mode.active[slot];
            -dynamics.contact_accelerations(contact, a).0
        };
    }
    for slot in normals..rows {
        let held = dynamics.mode.sticking[slot - normals];
        dynamics.equations.right[slot] = -match held.across {
            true => across_acceleration(dynamics, held.contact, a),
            false => dynamics.contact_accelerations(held.contact, a).1,
        };
    }
    if solve_again(dynamics, rows).is_some() {
        add_columns(dynamics, rows, true, a);
    }
}

/// Size of the terms that the equation of a row of the last solution balances.
pub(super) fn row_scale(dynamics: &Dynamics<'_>, row: usize, rows: usize) -> f64 {
    let (_, free) = match dynamics.mode.active.get(row) {
        Some(&i) => dynamics.free_normal_acceleration(i),
        None => {
            let held = dynamics.mode.sticking[row - dynamics.mode.active.len()];
            dynamics.free_sliding_acceleration(held.contact)
        }
    };
    let couplings = &dynamics.equations.couplings[row * rows..][..rows];
    let terms = couplings.iter().zip(&dynamics.equations.right).enumerate();
    terms
        .filter(|&(other, _)| other != row)
        .fold(free, |sum, (_, (coupling, force))| {
            sum + (coupling * force).abs()
        })
}
