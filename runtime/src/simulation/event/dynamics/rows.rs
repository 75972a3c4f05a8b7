//! The linear system of a contact mode for the contact accelerations: dense, or of many contacts by the couplings that do not vanish.

use super::sparse::Sparse;
use super::{Dynamics, dot};
use crate::contact::Line;
use crate::contact::shares::{self, Shares};
use crate::linalg::banded::Unfactorized;
use crate::linalg::small_system;

/// Number of coordinates from which on rows are looked through for zeros. Chosen: below, looking takes as long as adding them.
const LARGE: usize = 16;
/// Number of rows from which on those couplings alone are kept that do not vanish, and share of the largest of a column up to which a pivot
/// counts as zero, as in [`small_system`]. Chosen: fewer rows take as long either way.
const MANY: usize = 32;
const SINGULAR: f64 = 1e-12;

/// The line that a row holds: the normals of active contacts, then the tangents of sticking ones.
fn line(dynamics: &Dynamics<'_>, row: usize) -> Line {
    let mode = &dynamics.mode;
    match mode.active.get(row) {
        Some(&i) => Line::normal(i),
        None => mode.sticking[row - mode.active.len()],
    }
}

/// Covector of a row.
pub(super) fn constraint<'a>(dynamics: &'a Dynamics<'_>, row: usize) -> &'a [f64] {
    dynamics.row(line(dynamics, row)).0
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
        _ => dynamics.line_direction(line(dynamics, row)),
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
            let other = match active.get(column) {
                Some(&contact) => {
                    let frictions = dynamics.frictions(contact);
                    let ratio = dynamics.mode.states[contact].force_ratio(frictions);
                    let slope = if slipping { ratio } else { 0.0 };
                    Line::Normal { contact, slope }
                }
                None => dynamics.mode.sticking[column - active.len()],
            };
            *coupling = dynamics.coupling(Line::normal(active[row]), other);
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

/// Writes the couplings of the first `rows` rows that do not vanish: a contact is between two bodies, however many there are.
fn couple_sparsely(dynamics: &Dynamics<'_>, (rows, slipping): (usize, bool), sparse: &mut Sparse) {
    sparse.entries.clear();
    sparse.starts.clear();
    sparse.columns.resize(dynamics.n, Vec::new());
    sparse.columns.iter_mut().for_each(Vec::clear);
    sparse.sums.clear();
    sparse.sums.resize(rows, 0.0);
    let nonzeros = |values: &[f64], of: &mut dyn FnMut(usize, f64)| {
        for (k, &value) in values.iter().enumerate() {
            if value != 0.0 {
                of(k, value);
            }
        }
    };
    for column in 0..rows {
        let direction = force_direction(dynamics, column, slipping);
        nonzeros(direction, &mut |k, d| sparse.columns[k].push((column, d)));
    }
    let mut dense = Vec::new();
    for row in 0..rows {
        sparse.starts.push(sparse.entries.len());
        if is_given(dynamics, row) {
            dense.resize(rows, 0.0);
            couple(dynamics, (row, slipping), &mut Vec::new(), &mut dense);
            nonzeros(&dense, &mut |column, value| {
                sparse.entries.push((row, column, value));
            });
            continue;
        }
        nonzeros(constraint(dynamics, row), &mut |k, c| {
            for &(column, d) in &sparse.columns[k] {
                if sparse.sums[column] == 0.0 {
                    sparse.touched.push(column);
                }
                sparse.sums[column] += c * d;
            }
        });
        sparse.touched.sort_unstable();
        for column in sparse.touched.drain(..) {
            // A sum may vanish on its way, and be met again.
            let sum = std::mem::take(&mut sparse.sums[column]);
            if sum != 0.0 {
                sparse.entries.push((row, column, sum));
            }
        }
        if acts_by_nothing(dynamics, row) {
            sparse.entries.push((row, row, 1.0));
        }
    }
    sparse.starts.push(sparse.entries.len());
}

/// Whether the force of a row that holds a switch changes nothing, as where its jump begins to grow: any force solves its row there.
fn acts_by_nothing(dynamics: &Dynamics<'_>, row: usize) -> bool {
    let normals = dynamics.mode.active.len();
    let Some(&Line::Tangent { contact, .. }) =
        dynamics.mode.sticking.get(row.wrapping_sub(normals))
    else {
        return false;
    };
    let still = |d: &f64| *d == 0.0;
    dynamics.switch_of(contact).is_some() && dynamics.friction_direction(contact).iter().all(still)
}

/// Solves many rows by those of their couplings that do not vanish; `None` where they are not few, or depend on each other.
fn solve_sparsely(dynamics: &mut Dynamics<'_>, rows: usize, slipping: bool) -> Option<f64> {
    let mut sparse = std::mem::take(&mut dynamics.equations.sparse);
    sparse.holds = rows >= MANY;
    let mut solved = None;
    if sparse.holds {
        couple_sparsely(dynamics, (rows, slipping), &mut sparse);
        match sparse.factors.factorize(rows, &sparse.entries, SINGULAR) {
            Ok(()) => {
                sparse.factors.solve(&mut dynamics.equations.right[..rows]);
                solved = Some(sparse.factors.sign());
            }
            Err(Unfactorized::Singular | Unfactorized::Wide) => sparse.holds = false,
        }
    }
    dynamics.equations.sparse = sparse;
    solved
}

/// Solves for the unknowns of the first `rows` rows. Returns the sign of the determinant, 1 where rows follow from others, and `None` where
/// they contradict each other.
pub(super) fn solve_rows(dynamics: &mut Dynamics<'_>, rows: usize, slipping: bool) -> Option<f64> {
    dynamics.equations.shares = None;
    if let Some(solved) = solve_sparsely(dynamics, rows, slipping) {
        return Some(solved);
    }
    let mut couplings = std::mem::take(&mut dynamics.equations.couplings);
    let mut support = std::mem::take(&mut dynamics.equations.support);
    couplings.resize(rows * rows, 0.0);
    for (row, couplings) in couplings.chunks_exact_mut(rows.max(1)).enumerate() {
        couple(dynamics, (row, slipping), &mut support, couplings);
        if acts_by_nothing(dynamics, row) {
            couplings[row] = 1.0;
        }
    }
    dynamics.equations.couplings = couplings;
    dynamics.equations.support = support;
    let solved = solve_again(dynamics, (rows, slipping))?;
    if let Some(shares) = &dynamics.equations.shares
        && slipping
        && shares.contradict(&dynamics.view, &lines(dynamics, (rows, slipping)))
    {
        return None;
    }
    Some(solved)
}

/// Solves the rows of the last solution for other right-hand sides.
fn solve_again(dynamics: &mut Dynamics<'_>, (rows, slipping): (usize, bool)) -> Option<f64> {
    let equations = &mut dynamics.equations;
    if equations.sparse.holds {
        equations.sparse.factors.solve(&mut equations.right[..rows]);
        return Some(equations.sparse.factors.sign());
    }
    equations.matrix.clone_from(&equations.couplings);
    equations.wanted.clear();
    equations.wanted.extend(&equations.right[..rows]);
    let solved = small_system::solve(&mut equations.matrix, &mut equations.right[..rows]);
    if solved.is_some() {
        return solved;
    }
    let lines = lines(dynamics, (rows, slipping));
    let (view, equations) = (&dynamics.view, &mut dynamics.equations);
    let shares = Shares::of(view, &lines, &equations.couplings, &equations.wanted).ok()?;
    equations.right[..rows].copy_from_slice(&shares.forces);
    equations.shares = Some(shares);
    Some(1.0)
}

/// The lines of the first rows, of which those that slide carry friction where they are `slipping`.
fn lines(dynamics: &Dynamics<'_>, (rows, slipping): (usize, bool)) -> Vec<Line> {
    let own = |row: usize| match dynamics.mode.active.get(row) {
        Some(&contact) if slipping => {
            let slope = dynamics.mode.states[contact].force_ratio(dynamics.frictions(contact));
            Line::Normal { contact, slope }
        }
        _ => line(dynamics, row),
    };
    (0..rows).map(own).collect()
}

/// Takes the forces of the last solution that the farthest inside of their laws, where there are several with the same motion.
pub(super) fn share(dynamics: &mut Dynamics<'_>, rows: usize) {
    let Some(shares) = dynamics.equations.shares.take() else {
        return;
    };
    if shares.are_many() {
        let rooms = shares::rooms(&dynamics.view, &lines(dynamics, (rows, true)));
        dynamics.equations.right[..rows].copy_from_slice(&shares.inside(&rooms));
    }
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
        let (view, columns) = (&dynamics.view, &mut dynamics.equations.columns);
        columns[column.clone()].copy_from_slice(view.direction(i));
        let ratio = dynamics.mode.states[i].force_ratio(view.frictions(i));
        if ratio != 0.0 {
            for (d, e) in columns[column].iter_mut().zip(view.slip_direction(i)) {
                *d += ratio * e;
            }
        }
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
        dynamics.equations.right[slot] = -match held {
            Line::Across { .. } => dynamics.line_acceleration(held, a),
            _ => dynamics.contact_accelerations(held.contact(), a).1,
        };
    }
    if solve_again(dynamics, (rows, true)).is_some() {
        add_columns(dynamics, rows, true, a);
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
    let (sparse, forces) = (&dynamics.equations.sparse, &dynamics.equations.right);
    if sparse.holds {
        let own = &sparse.entries[sparse.starts[row]..sparse.starts[row + 1]];
        let others = own.iter().filter(|(_, column, _)| *column != row);
        return others.fold(free, |sum, &(_, column, coupling)| {
            sum + (coupling * forces[column]).abs()
        });
    }
    let couplings = &dynamics.equations.couplings[row * rows..][..rows];
    let terms = couplings.iter().zip(&dynamics.equations.right).enumerate();
    terms
        .filter(|&(other, _)| other != row)
        .fold(free, |sum, (_, (coupling, force))| {
            sum + (coupling * force).abs()
        })
}
