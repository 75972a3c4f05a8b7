//! Which components of a state joints decide.
//!
//! Where rows of joints stand in the place of differential equations, they *decide* components of the state that have independent
//! columns in `dw/dv`, and a scheme moves the others (coordinate partitioning: Wehage and Haug 1982). Columns have the largest pivots
//! in given units.

use crate::model::held::moving;
use crate::model::{Function, JointsDeclaration, Model};
use crate::yardstick;

/// An equation and the component that it decides.
pub(crate) struct Pair {
    /// Equation, counted over all joints.
    pub(crate) row: usize,
    /// Coordinate: its velocity is decided, and it itself by an equation of positions.
    pub(crate) column: usize,
    pub(crate) holonomic: bool,
}

/// The equations that are held with the components that they decide, where velocities have these `units`.
pub(crate) fn deciding(
    model: &dyn Model,
    joints: JointsDeclaration,
    jacobian: &Jacobian,
    units: &[f64],
) -> Vec<Pair> {
    among(model, joints, jacobian, units, (0..moving(model)).collect()).0
}

/// How well these components are decided: their pivots, multiplied, as a share of those of the ones that are decided best.
pub(crate) fn share(
    model: &dyn Model,
    joints: JointsDeclaration,
    jacobian: &Jacobian,
    units: &[f64],
    components: &[usize],
) -> f64 {
    let best = among(model, joints, jacobian, units, (0..moving(model)).collect());
    let own = among(model, joints, jacobian, units, components.to_vec());
    match own.0.len() < best.0.len() {
        true => 0.0,
        false => own.1 / best.1,
    }
}

/// The equations that are held with those of some components that they decide, and the product of their pivots.
fn among(
    model: &dyn Model,
    joints: JointsDeclaration,
    jacobian: &Jacobian,
    units: &[f64],
    mut free: Vec<usize>,
) -> (Vec<Pair>, f64) {
    let n = units.len();
    let mut matrix: Vec<Vec<f64>> = (0..jacobian.count)
        .map(|row| {
            let of_velocities = &jacobian.of(jacobian.count + row)[n..];
            let scaled = of_velocities.iter().zip(units);
            scaled.map(|(entry, unit)| entry * unit).collect()
        })
        .collect();
    for row in &mut matrix {
        scale(row);
    }
    let kinds: Vec<bool> = joints.equations().map(|(own, _)| own.holonomic).collect();
    let mut open: Vec<usize> = (0..jacobian.count)
        .filter(|&row| model.joint_row_held(row))
        .collect();
    // Positions first, so that they have the best columns.
    open.sort_by_key(|&row| !kinds[row]);
    let (mut pairs, mut product) = (Vec::new(), 1.0);
    while let Some((place, column)) = largest_pivot(&matrix, &open, &free, &kinds) {
        let row = open.remove(place);
        free.retain(|&other| other != column);
        let pivot = matrix[row].clone();
        product *= pivot[column].abs();
        for &other in &open {
            eliminate(&mut matrix[other], &pivot, column);
        }
        pairs.push(Pair {
            row,
            column,
            holonomic: kinds[row],
        });
    }
    (pairs, product)
}

/// The largest entry in the open rows of one kind, those of positions while there are any: its place among them and its column.
fn largest_pivot(
    matrix: &[Vec<f64>],
    open: &[usize],
    free: &[usize],
    kinds: &[bool],
) -> Option<(usize, usize)> {
    let positions = open
        .iter()
        .any(|&row| kinds[row] && has_pivot(&matrix[row], free));
    let mut best: Option<(usize, usize)> = None;
    let mut most = yardstick::NOTHING;
    for (place, &row) in open.iter().enumerate() {
        if positions && !kinds[row] {
            continue;
        }
        for &column in free {
            let size = matrix[row][column].abs();
            if size > most {
                (best, most) = (Some((place, column)), size);
            }
        }
    }
    best
}

fn has_pivot(row: &[f64], free: &[usize]) -> bool {
    free.iter()
        .any(|&column| row[column].abs() > yardstick::NOTHING)
}

/// Divides a row by its largest entry.
fn scale(row: &mut [f64]) {
    let largest = row
        .iter()
        .fold(0.0_f64, |most, entry| most.max(entry.abs()));
    if largest > 0.0 {
        for entry in row {
            *entry /= largest;
        }
    }
}

/// Takes the multiple of another row off that leaves nothing in a column.
pub(crate) fn eliminate(row: &mut [f64], pivot: &[f64], column: usize) {
    let factor = row[column] / pivot[column];
    if factor != 0.0 {
        for (entry, pivot) in row.iter_mut().zip(pivot) {
            *entry -= factor * pivot;
        }
        row[column] = 0.0;
    }
}

/// The derivatives of `(g, w)` by `(q, v)` at one point, row-major.
pub(crate) struct Jacobian {
    /// Number of equations.
    pub(crate) count: usize,
    pub(crate) columns: usize,
    entries: Vec<f64>,
}

impl Jacobian {
    pub(crate) fn at(
        model: &dyn Model,
        joints: JointsDeclaration,
        state: &[f64],
        time: f64,
    ) -> Self {
        let (count, columns) = (joints.rows(), state.len());
        let mut x = state.to_vec();
        x.resize(model.declaration().inputs(), 0.0);
        if model.declaration().explicit_time
            && let Some(last) = x.last_mut()
        {
            *last = time;
        }
        let mut values = vec![0.0; joints.jacobian.entries.len()];
        model.jacobian(Function::Joints, &x, &mut values);
        let mut entries = vec![0.0; 2 * count * columns];
        for (&(row, column), value) in joints.jacobian.entries.iter().zip(values) {
            if (column as usize) < columns {
                entries[row as usize * columns + column as usize] = value;
            }
        }
        Self {
            count,
            columns,
            entries,
        }
    }

    /// One of the rows.
    pub(crate) fn of(&self, row: usize) -> &[f64] {
        &self.entries[row * self.columns..(row + 1) * self.columns]
    }
}
