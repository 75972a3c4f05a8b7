//! Joints at a free start, which fulfils them by rows of its own: those that do not follow from each other and from what parameters
//! decide.

use crate::joints::partition::{Jacobian, eliminate};
use crate::model::held::is_held;
use crate::model::{Function, Given, Model};
use crate::ocp::problem::Problem;
use crate::program::joint_rows::{add, named};
use crate::program::sparse_program::Program;
use crate::yardstick;

/// What joints say of a free start.
pub(in crate::ocp) struct AtStart {
    /// Rows of `(g, w)` that do not follow from others, as outputs of the kernel.
    pub(in crate::ocp) kept: Vec<usize>,
    /// A row that would decide a parameter, and that (coordinate behind those that move).
    pub(in crate::ocp) decides_parameter: Option<(usize, usize)>,
}

/// What joints say of the start, near `start = (q, v)` where components have these units; nothing where it is given.
pub(in crate::ocp) fn at_start(
    model: &dyn Model,
    problem: &Problem,
    units: &[f64],
    start: &[f64],
) -> AtStart {
    let mut found = AtStart {
        kept: Vec::new(),
        decides_parameter: None,
    };
    let ranges = problem.start_ranges(model);
    let free = |k: usize| ranges[k].0 < ranges[k].1;
    let Some(joints) = model.declaration().joints else {
        return found;
    };
    if !(0..ranges.len()).any(free) {
        return found;
    }
    let jacobian = Jacobian::at(model, joints, start, 0.0);
    let mut pivots: Vec<(Vec<f64>, usize)> = given_rows(model, problem, (start, units));
    let held = (0..2 * jacobian.count).filter(|row| model.joint_row_held(row % jacobian.count));
    for output in held {
        let mut row: Vec<f64> = (0..ranges.len())
            .map(|k| match free(k) || is_held(model, k) {
                true => jacobian.of(output)[k],
                false => 0.0,
            })
            .collect();
        for (entry, unit) in row.iter_mut().zip(units) {
            *entry *= unit;
        }
        let all = jacobian.of(output).iter().zip(units);
        let size = all.fold(0.0_f64, |most, (entry, unit)| {
            most.max((entry * unit).abs())
        });
        for (pivot, column) in &pivots {
            eliminate(&mut row, pivot, *column);
        }
        let largest = |held: bool| {
            let columns = (0..row.len()).filter(|&k| is_held(model, k) == held);
            columns.max_by(|&a, &b| row[a].abs().total_cmp(&row[b].abs()))
        };
        let says = |column: &usize| row[*column].abs() > yardstick::NOTHING * size;
        let column = largest(false).filter(says).or_else(|| {
            let parameter = largest(true).filter(says)?;
            found.decides_parameter = Some((output % jacobian.count, parameter));
            Some(parameter)
        });
        if let Some(column) = column {
            found.kept.push(output);
            pivots.push((row, column));
        }
    }
    found
}

/// The rows by which parameters decide components of the start, with the columns of these.
fn given_rows(
    model: &dyn Model,
    problem: &Problem,
    (start, units): (&[f64], &[f64]),
) -> Vec<(Vec<f64>, usize)> {
    let Some(held) = model.held() else {
        return Vec::new();
    };
    let in_units = |k: usize, mut row: Vec<f64>| {
        row[k] += 1.0;
        for (entry, unit) in row.iter_mut().zip(units) {
            *entry *= unit;
        }
        (row, k)
    };
    let completed = problem.completed.iter().map(|known| {
        let mut row = vec![0.0; start.len()];
        known.by.iter().for_each(|&(by, slope)| row[by] -= slope);
        in_units(known.component, row)
    });
    let is_completed = |k: usize| problem.completed.iter().any(|known| known.component == k);
    let mut x = start.to_vec();
    x.resize(model.declaration().inputs(), 0.0);
    let mut values = vec![0.0; held.jacobian.entries.len()];
    model.jacobian(Function::Given, &x, &mut values);
    let decided = held.given.iter().enumerate();
    let rows = decided.filter_map(|(index, given)| {
        let Given::Start(k) = *given else { return None };
        if is_completed(k) {
            return None;
        }
        let mut row = vec![0.0; start.len()];
        for (&(of, by), value) in held.jacobian.entries.iter().zip(&values) {
            if of as usize == index && (by as usize) < row.len() {
                row[by as usize] -= value;
            }
        }
        Some(in_units(k, row))
    });
    completed.chain(rows).collect()
}

/// Adds the rows of joints at a free start, whose variables are these.
pub(super) fn add_at_start(
    program: &mut Program,
    model: &dyn Model,
    problem: &Problem,
    (start, units): (&[usize], &[f64]),
) {
    let Some(joints) = model.declaration().joints else {
        return;
    };
    let guess: Vec<f64> = start.iter().map(|&i| program.guessed(i)).collect();
    let kept = at_start(model, problem, units, &guess).kept;
    let jacobian = Jacobian::at(model, joints, &guess, 0.0);
    let rows = kept.iter();
    let rows: Vec<(usize, String, f64)> = rows
        .map(|&output| named(&jacobian, joints, output, units))
        .collect();
    let (q, v) = start.split_at(start.len() / 2);
    add(program, &rows, [q, v, &[]], "at the start");
}
