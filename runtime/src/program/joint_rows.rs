//! Joints in programs: the components of the state that they decide, and their rows.
//!
//! Accelerations of a scene with joints are those with which the joints hold, so that `g = 0` and `w = 0` follow from a start that
//! fulfils them, but for the error of the scheme. So that nothing drifts, their rows stand in the place of as many differential
//! equations: the joints *decide* components of the state that have independent columns in `dg/dq` and `dw/dv`, and the scheme moves the
//! others (coordinate partitioning: Wehage and Haug 1982). That is the scheme in minimal coordinates, of its full order, and the program has neither unknowns nor
//! rows more than one without joints. The columns are chosen at the guess, for each part of the motion by itself, with the largest
//! pivots in the units of the state.

use super::kernel::Kernel;
use super::powers::{THOUSAND, nearest_power};
use super::sparse_program::Program;
use crate::joints::partition::{Jacobian, deciding};
use crate::model::{Function, JointsDeclaration, Model};

/// The components of `(q, v)` that joints decide in a part of a motion; none in a scene without joints.
pub(crate) struct Decided {
    /// Whether each component is one; empty without joints.
    components: Vec<bool>,
    /// Rows `(g, w)` that decide them, as outputs of the kernel, with their names and units.
    rows: Vec<(usize, String, f64)>,
}

impl Decided {
    /// Those with the largest pivots at the state that begins `sample`, at a time, where components have these units.
    pub(crate) fn at(model: &dyn Model, units: &[f64], sample: &[f64], time: f64) -> Self {
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

    /// The coordinates whose velocities joints decide.
    pub(crate) fn velocities(&self) -> Vec<usize> {
        let n = self.components.len() / 2;
        (0..n).filter(|k| self.components[n + k]).collect()
    }

    /// Whether joints decide component `k`.
    pub(crate) fn contains(&self, k: usize) -> bool {
        self.components.get(k).copied().unwrap_or(false)
    }

    /// Adds the rows that decide them at a state.
    pub(crate) fn add_rows(&self, program: &mut Program, at: [&[usize]; 3], place: &str) {
        add(program, &self.rows, at, place);
    }
}

/// Adds rows of joints.
pub(crate) fn add(
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
        program.block(&Kernel::Whole(Function::Joints), [q, v, u, &[]], None, uses);
    }
}

/// An output of the kernel with its name, and what it changes by where a component changes by its unit.
pub(crate) fn named(
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
