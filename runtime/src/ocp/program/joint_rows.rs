//! Joints in programs: the components of the state that they decide, and their rows.
//!
//! Accelerations of a scene with joints are those with which the joints hold, so that `g = 0` and `w = 0` follow from a start that
//! fulfils them, but for the error of the scheme. So that nothing drifts, their rows stand in the place of as many differential
//! equations: the joints *decide* components of the state that have independent columns in `dg/dq` and `dw/dv`, and the scheme moves the
//! others (coordinate partitioning: Wehage and Haug 1982). That is the scheme in minimal coordinates, of its full order, and the program has neither unknowns nor
//! rows more than one without joints. The columns are chosen at the guess, for each part of the motion by itself, with the largest
//! pivots in the units of the state.
//!
//! Where the start is free, it fulfils the joints by rows of its own, those that do not follow from each other and from what parameters
//! decide.

use super::kernel::Kernel;
use super::sparse_program::Program;
use super::units::{THOUSAND, nearest_power};
use crate::joints::partition::{Jacobian, NOTHING, deciding, eliminate};
use crate::model::held::is_held;
use crate::model::{Given, JointsDeclaration, Model};
use crate::ocp::problem::Problem;

/// The components of `(q, v)` that joints decide in a part of a motion; none in a scene without joints.
pub(in crate::ocp) struct Decided {
    /// Whether each component is one; empty without joints.
    components: Vec<bool>,
    /// Rows `(g, w)` that decide them, as outputs of the kernel, with their names and units.
    rows: Vec<(usize, String, f64)>,
}

impl Decided {
    /// Those with the largest pivots at the state that begins `sample`, at a time, where components have these units.
    pub(in crate::ocp) fn at(model: &dyn Model, units: &[f64], sample: &[f64], time: f64) -> Self {
        let mut decided = Self {
            components: Vec::new(),
            rows: Vec::new(),
        };
        let Some(joints) = model.declaration().joints else {
            return decided;
        };
        let n = units.len() / 2;
        decided.components.resize(2 * n, false);
        let jacobian = Jacobian::at(model, joints, &sample[..2 * n], time);
        for pair in deciding(model, joints, &jacobian, &units[n..]) {
            decided.components[n + pair.column] = true;
            if pair.holonomic {
                decided.components[pair.column] = true;
                decided.rows.push(named(&jacobian, joints, pair.row, units));
            }
            let of_velocity = jacobian.count + pair.row;
            decided
                .rows
                .push(named(&jacobian, joints, of_velocity, units));
        }
        decided.rows.sort_by_key(|row| row.0);
        decided
    }

    /// Whether joints decide component `k`.
    pub(in crate::ocp) fn contains(&self, k: usize) -> bool {
        self.components.get(k).copied().unwrap_or(false)
    }

    /// Adds the rows that decide them at a state.
    pub(in crate::ocp) fn add_rows(&self, program: &mut Program, at: [&[usize]; 3], place: &str) {
        add(program, &self.rows, at, place);
    }
}

/// Adds rows of joints.
fn add(
    program: &mut Program,
    rows: &[(usize, String, f64)],
    [q, v, u]: [&[usize]; 3],
    place: &str,
) {
    let add = |(output, name, unit): &(usize, String, f64)| {
        let row = program.row_in(*unit, format!("{name}, {place}"), 0.0, 0.0);
        (row, *output, 1.0)
    };
    let uses: Vec<(usize, usize, f64)> = rows.iter().map(add).collect();
    if !uses.is_empty() {
        program.block(&Kernel::Joints, [q, v, u, &[]], None, uses);
    }
}

/// An output of the kernel with its name, and what it changes by where a component changes by its unit.
fn named(
    jacobian: &Jacobian,
    joints: JointsDeclaration,
    output: usize,
    units: &[f64],
) -> (usize, String, f64) {
    let of_velocities = output >= jacobian.count;
    let name = joints.equations().nth(output % jacobian.count);
    let name = name.map_or(String::new(), |(joint, row)| joint.equation(row));
    let name = if of_velocities {
        format!("velocity of joint {name}")
    } else {
        format!("joint {name}")
    };
    // The rate of a joint by what its velocities are, whatever its positions do.
    let first = if of_velocities {
        jacobian.columns / 2
    } else {
        0
    };
    let terms = jacobian.of(output)[first..].iter().zip(&units[first..]);
    let size = terms.fold(0.0_f64, |most, (entry, unit)| {
        most.max((entry * unit).abs())
    });
    (output, name, nearest_power(THOUSAND, size))
}

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
        let says = |column: &usize| row[*column].abs() > NOTHING * size;
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
    model.given_jacobian(&x, &mut values);
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
