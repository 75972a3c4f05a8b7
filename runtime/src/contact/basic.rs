//! Forces that the equations of the states determine: those of redundant contacts are moved to others.

use super::active_set::{Equations, forces_of};
use super::problem::{Problem, Solution, Tangent};
use super::state::ContactState;
use crate::linalg::dense;

/// Pivots below this share of the largest entry are those of dependent lines, see [`small_system`](crate::linalg::small_system).
const DEPENDENT: f64 = 1e-11;

/// Moves forces that do nothing together until one of the contacts opens or reaches the edge of its cone, until the others are
/// independent, and solves their equations. `None` where nothing ends that.
pub(super) fn reduced(
    problem: &Problem<'_>,
    tangents: &[Option<Tangent>],
    mut states: Vec<ContactState>,
    mut forces: Vec<f64>,
) -> Option<Solution> {
    for _ in 0..=2 * states.len() {
        let equations = Equations::of(problem, tangents, &states);
        let Some(null) = null_vector(&equations) else {
            let x = exact(&equations)?;
            let forces = forces_of(problem, tangents, &states, (&equations.unknown, &x));
            return Some(Solution { states, forces });
        };
        let direction = forces_of(problem, tangents, &states, (&equations.unknown, &null));
        let ahead = first_stop(tangents, &states, &forces, (&direction, 1.0));
        let behind = first_stop(tangents, &states, &forces, (&direction, -1.0));
        let (sign, stop) = match (ahead, behind) {
            (Some(a), Some(b)) if b.0 < a.0 => (-1.0, b),
            (Some(a), _) => (1.0, a),
            (None, Some(b)) => (-1.0, b),
            (None, None) => return None,
        };
        for (force, direction) in forces.iter_mut().zip(&direction) {
            *force += sign * stop.0 * direction;
        }
        let (_, contact, state) = stop;
        states[contact] = state;
        if state == ContactState::Open {
            forces[contact] = 0.0;
            if let Some(tangent) = tangents[contact] {
                forces[tangent.line] = 0.0;
            }
        }
    }
    None
}

/// How far the forces go along a direction until a contact opens or reaches the edge of its cone; that contact, and its
/// state there.
fn first_stop(
    tangents: &[Option<Tangent>],
    states: &[ContactState],
    forces: &[f64],
    (direction, sign): (&[f64], f64),
) -> Option<(f64, usize, ContactState)> {
    let mut first: Option<(f64, usize, ContactState)> = None;
    let mut meet = |room: f64, rate: f64, contact: usize, state: ContactState| {
        if rate > 0.0 {
            let length = room.max(0.0) / rate;
            if first.is_none_or(|(known, ..)| length < known) {
                first = Some((length, contact, state));
            }
        }
    };
    let largest = direction.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
    let of = |line: usize| {
        let d = sign * direction[line];
        if d.abs() <= DEPENDENT * largest {
            0.0
        } else {
            d
        }
    };
    for (i, state) in states.iter().enumerate() {
        if *state == ContactState::Open {
            continue;
        }
        meet(forces[i], -of(i), i, ContactState::Open);
        if let (ContactState::Stick, Some(known)) = (state, tangents[i]) {
            let Tangent {
                line: tangent,
                friction,
                ..
            } = known;
            for side in [1.0, -1.0] {
                let room = friction * forces[i] - side * forces[tangent];
                let rate = side * of(tangent) - friction * of(i);
                meet(room, rate, i, ContactState::slip(-side));
            }
        }
    }
    first
}

/// A vector that the matrix maps to zero, by elimination with complete pivoting; `None` if there is none.
fn null_vector(equations: &Equations) -> Option<Vec<f64>> {
    let order = equations.unknown.len();
    let mut a = equations.matrix.clone();
    let mut columns: Vec<usize> = (0..order).collect();
    let largest = a.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
    for k in 0..order {
        let (mut best, mut size) = ((k, k), 0.0);
        for row in k..order {
            for column in k..order {
                let entry = a[row * order + column].abs();
                if entry > size {
                    (best, size) = ((row, column), entry);
                }
            }
        }
        if size <= DEPENDENT * largest {
            return Some(back_substituted(&a, &columns, k));
        }
        for column in 0..order {
            a.swap(k * order + column, best.0 * order + column);
        }
        for row in 0..order {
            a.swap(row * order + k, row * order + best.1);
        }
        columns.swap(k, best.1);
        for row in k + 1..order {
            let factor = a[row * order + k] / a[k * order + k];
            if factor != 0.0 {
                for column in k..order {
                    a[row * order + column] -= factor * a[k * order + column];
                }
            }
        }
    }
    None
}

/// The null vector with a one at the first column behind the `rank` that have pivots.
fn back_substituted(a: &[f64], columns: &[usize], rank: usize) -> Vec<f64> {
    let order = columns.len();
    let mut x = vec![0.0; order];
    x[rank] = 1.0;
    for k in (0..rank).rev() {
        let sum: f64 = (k + 1..=rank).map(|j| a[k * order + j] * x[j]).sum();
        x[k] = -sum / a[k * order + k];
    }
    let mut null = vec![0.0; order];
    for (&column, value) in columns.iter().zip(x) {
        null[column] = value;
    }
    null
}

/// The solution of independent equations, refined once.
fn exact(equations: &Equations) -> Option<Vec<f64>> {
    let mut factors = equations.matrix.clone();
    let mut pivots = vec![0; equations.unknown.len()];
    dense::factorize(&mut factors, &mut pivots).ok()?;
    let mut x = equations.right.clone();
    dense::solve(&factors, &pivots, &mut x);
    let mut step = equations.residual(&x);
    dense::solve(&factors, &pivots, &mut step);
    for (x, step) in x.iter_mut().zip(step) {
        *x += step;
    }
    Some(x)
}
