//! Forces that the equations of the states determine: those of redundant contacts are moved to others.

use super::active_set::{Equations, forces_of};
use super::problem::{Problem, Solution, Tangent};
use super::state::ContactState;
use crate::linalg::dense;
use crate::linalg::least_norm::LeastNorm;

/// Components of a direction below this share of the largest one are rounding error, see [`small_system`](crate::linalg::small_system).
const IDLE: f64 = 1e-11;

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
        let order = equations.unknown.len();
        let idle = LeastNorm::of(&equations.matrix, order).map(|known| known.idle());
        let Some(null) = idle.and_then(|idle| idle.into_iter().next()) else {
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
        if d.abs() <= IDLE * largest { 0.0 } else { d }
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
