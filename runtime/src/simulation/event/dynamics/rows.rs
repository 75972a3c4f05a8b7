//! The linear system of a contact mode for the contact accelerations: dense, or of many contacts by the couplings that do not vanish.

use super::Dynamics;
use crate::contact::shares::{self, Shares};
use crate::contact::{Line, View};
use crate::linalg::small_system;
use crate::yardstick;

/// Number of rows from which on those couplings alone are kept that do not vanish, and share of the largest of a column up to which a pivot
/// counts as zero, as in [`small_system`]. Chosen: fewer rows take as long either way.
const MANY: usize = 32;
/// The lines of the first rows: the normals of active contacts, of which those that slide carry friction where they are `slipping`, then
/// the tangents of sticking ones.
fn lines(dynamics: &Dynamics<'_>, (rows, slipping): (usize, bool)) -> Vec<Line> {
    let mode = &dynamics.mode;
    let normals = mode.active.iter().map(|&contact| Line::Normal {
        contact,
        slope: match slipping {
            true => mode.states[contact].force_ratio(dynamics.frictions(contact)),
            false => 0.0,
        },
    });
    normals
        .chain(mode.sticking.iter().copied())
        .take(rows)
        .collect()
}

/// Whether the force of a line that holds a switch changes nothing, as where its jump begins to grow: any force solves its row there.
fn acts_by_nothing(view: &View<'_>, line: Line) -> bool {
    let Line::Tangent { contact, .. } = line else {
        return false;
    };
    let still = |d: &f64| *d == 0.0;
    view.switch_of(contact).is_some() && view.friction_direction(contact).iter().all(still)
}

/// Solves for the unknowns of the first `rows` rows. Returns the sign of the determinant, 1 where rows follow from others, and `None` where
/// they contradict each other.
pub(super) fn solve_rows(dynamics: &mut Dynamics<'_>, rows: usize, slipping: bool) -> Option<f64> {
    let lines = lines(dynamics, (rows, slipping));
    let (view, equations) = (&dynamics.view, &mut dynamics.equations);
    let idle = (0..rows).filter(|&row| acts_by_nothing(view, lines[row]));
    equations.shares = None;
    equations.banded = false;
    if rows >= MANY {
        equations.entries = view.sparse_couplings(&lines);
        equations
            .entries
            .extend(idle.clone().map(|row| (row, row, 1.0)));
        equations.entries.sort_by_key(|&(row, _, _)| row);
        let factorized = equations
            .band
            .factorize(rows, &equations.entries, yardstick::ROUNDING);
        equations.banded = factorized.is_ok();
    }
    if !equations.banded {
        equations.couplings = view.couplings(&lines);
        for row in idle {
            equations.couplings[row * (rows + 1)] = 1.0;
        }
    }
    equations.lines = lines;
    let solved = solve_again(dynamics, rows)?;
    let (view, equations) = (&dynamics.view, &dynamics.equations);
    let shares = equations.shares.as_ref().filter(|_| slipping);
    if shares.is_some_and(|shares| shares.contradict(view, &equations.lines)) {
        return None;
    }
    Some(solved)
}

/// Solves the rows of the last solution for other right-hand sides.
fn solve_again(dynamics: &mut Dynamics<'_>, rows: usize) -> Option<f64> {
    let (view, equations) = (&dynamics.view, &mut dynamics.equations);
    if equations.banded {
        equations.band.solve(&mut equations.right[..rows]);
        return Some(equations.band.sign);
    }
    equations.matrix.clone_from(&equations.couplings);
    equations.wanted.clear();
    equations.wanted.extend(&equations.right[..rows]);
    let solved = small_system::solve(&mut equations.matrix, &mut equations.right[..rows]);
    if solved.is_some() {
        return solved;
    }
    let (lines, couplings) = (&equations.lines, &equations.couplings);
    let shares = Shares::of(view, lines, couplings, &equations.wanted).ok()?;
    equations.right[..rows].copy_from_slice(&shares.forces);
    equations.shares = Some(shares);
    Some(1.0)
}

/// Takes the forces of the last solution that the farthest inside of their laws, where there are several with the same motion.
pub(super) fn share(dynamics: &mut Dynamics<'_>, rows: usize) {
    let Some(shares) = dynamics.equations.shares.take() else {
        return;
    };
    if shares.are_many() {
        let rooms = shares::rooms(&dynamics.view, &dynamics.equations.lines);
        dynamics.equations.right[..rows].copy_from_slice(&shares.inside(&rooms));
    }
}

/// Adds what the forces of the last solution do `to` accelerations, or velocities.
pub(super) fn push(dynamics: &Dynamics<'_>, to: &mut [f64]) {
    let equations = &dynamics.equations;
    for (&line, &force) in equations.lines.iter().zip(&equations.right) {
        dynamics.view.push(line, force, to);
    }
}

/// Evaluates the active contacts and the right-hand sides of the rows of the mode. Returns the number of rows.
pub(super) fn evaluate_rows(dynamics: &mut Dynamics<'_>) -> usize {
    let normals = dynamics.mode.active.len();
    for slot in 0..normals {
        let i = dynamics.mode.active[slot];
        dynamics.evaluate_sides(i);
        dynamics.equations.right[slot] = -dynamics.free_normal_acceleration(i).0;
    }
    for slot in 0..dynamics.mode.sticking.len() {
        let held = dynamics.mode.sticking[slot];
        dynamics.equations.right[normals + slot] = match held {
            Line::Across { .. } => -dynamics.free_line_acceleration(held),
            _ => -dynamics.free_sliding_acceleration(held.contact()).0,
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
        dynamics.equations.s[i] = dynamics.mode.states[i].force_ratio(dynamics.frictions(i))
            * dynamics.equations.right[slot];
        dynamics.equations.across[i] = 0.0;
    }
    for slot in normals..rows {
        let held = dynamics.mode.sticking[slot - normals];
        let force = dynamics.equations.right[slot];
        match held {
            Line::Across { contact } => dynamics.equations.across[contact] = force,
            _ => dynamics.equations.s[held.contact()] = force,
        }
    }
}

/// Takes from the accelerations `a`, those of the last solution, what rounding has left in the rows. In them terms of the size of the forces cancel:
/// a body that sticks would fall by that for as long as it rests.
pub(super) fn refine(dynamics: &mut Dynamics<'_>, rows: usize, a: &mut [f64]) {
    let normals = dynamics.mode.active.len();
    for slot in 0..normals {
        let contact = dynamics.mode.active[slot];
        // A given force leaves no rounding error.
        dynamics.equations.right[slot] = match dynamics.is_dry(contact) {
            true => 0.0,
            false => -dynamics.contact_accelerations(contact, a).0,
        };
    }
    for slot in normals..rows {
        let held = dynamics.mode.sticking[slot - normals];
        dynamics.equations.right[slot] = -match held {
            Line::Across { .. } => dynamics.line_acceleration(held, a),
            _ => dynamics.contact_accelerations(held.contact(), a).1,
        };
    }
    if solve_again(dynamics, rows).is_some() {
        push(dynamics, a);
    }
}

/// Size of the terms that the equation of a row of the last solution balances.
pub(super) fn row_scale(dynamics: &Dynamics<'_>, row: usize, rows: usize) -> f64 {
    let (_, free) = match dynamics.mode.active.get(row) {
        Some(&i) => dynamics.free_normal_acceleration(i),
        None => {
            let held = dynamics.mode.sticking[row - dynamics.mode.active.len()];
            dynamics.free_sliding_acceleration(held.contact())
        }
    };
    let equations = &dynamics.equations;
    let size = |(column, coupling): (usize, f64)| match column == row {
        true => 0.0,
        false => (coupling * equations.right[column]).abs(),
    };
    if equations.banded {
        let entries = &equations.entries;
        let own = entries.partition_point(|&(of, _, _)| of < row);
        let own = entries[own..].iter().take_while(|&&(of, _, _)| of == row);
        return own.fold(free, |sum, &(_, column, coupling)| {
            sum + size((column, coupling))
        });
    }
    let own = equations.couplings[row * rows..][..rows].iter().copied();
    own.enumerate().fold(free, |sum, entry| sum + size(entry))
}
