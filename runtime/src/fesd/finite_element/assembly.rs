//! The Newton matrix of an element.

use super::{FiniteElement, numerical_time};
use crate::model::Function;

/// Products of rows with the directions of all position corrections, of which each has few components that
/// are not zero.
struct Products {
    /// Components of each direction that are not zero, with their places.
    directions: Vec<Vec<(usize, f64)>>,
    values: Vec<f64>,
}

impl Products {
    fn new(element: &FiniteElement<'_>, positions: usize) -> Self {
        let n = element.n;
        let direction = |i: usize| {
            let components = element.corrections[i * n..(i + 1) * n].iter();
            let components = components.copied().enumerate();
            components.filter(|(_, d)| *d != 0.0).collect()
        };
        Self {
            directions: (0..positions).map(direction).collect(),
            values: Vec::new(),
        }
    }

    /// Multiplies rows of a row-major matrix with `n` columns.
    fn multiply(&mut self, matrix: &[f64], n: usize) {
        self.values.clear();
        for row in matrix.chunks_exact(n) {
            for direction in &self.directions {
                let terms = direction.iter().map(|&(k, d)| row[k] * d);
                self.values.push(terms.sum());
            }
        }
    }

    /// Of one row, a product for each correction.
    fn of_row(&self, row: usize) -> &[f64] {
        let count = self.directions.len();
        &self.values[row * count..(row + 1) * count]
    }
}

/// The Newton matrix at the present stages.
pub(super) fn assemble(element: &mut FiniteElement<'_>) {
    let (n, h, block) = (element.n, element.length, element.block());
    let (positions, forces) = (element.constraints.positions(), element.constraints.count());
    let stages = element.tableau.stages();
    let size = stages * block;
    element.matrix.clear();
    element.matrix.resize(size * size, 0.0);
    numerical_time::differentiate(element);
    let new = || Products::new(element, positions);
    let (mut corrected, mut turned, mut along) = (new(), new(), new());
    for m in 0..stages {
        evaluate_stage_jacobian(element, m);
        let constraints = &element.constraints;
        corrected.multiply(&element.by_q, n);
        turned.multiply(&constraints.turning[..forces * n], n);
        along.multiply(&constraints.gradients[..forces * n], n);
        for j in 0..stages {
            let constraints = &element.constraints;
            let (first, second) = numerical_time::weights(element, m, j);
            let shift = h * element.tableau.a(m, j);
            let (rows, columns) = (m * block, j * block);
            for row in 0..n {
                let line = &mut element.matrix[(rows + row) * size + columns..][..block];
                let by_q = &element.by_q[row * n..(row + 1) * n];
                let by_v = &element.by_v[row * n..(row + 1) * n];
                for (entry, (q, v)) in line.iter_mut().zip(by_q.iter().zip(by_v)) {
                    *entry -= second * q + first * v;
                }
                for (entry, correction) in line[n + forces..].iter_mut().zip(corrected.of_row(row))
                {
                    *entry -= h * shift * correction;
                }
                if m == j {
                    line[row] += 1.0;
                    for i in 0..forces {
                        line[n + i] -= constraints.directions[i * n + row];
                    }
                }
            }
            for i in 0..forces {
                let gradient = &constraints.gradients[i * n..(i + 1) * n];
                let turning = &constraints.turning[i * n..(i + 1) * n];
                let velocity_row = (rows + n + i) * size + columns;
                if constraints.is_given(i) {
                    for k in 0..n {
                        let by_state = second * turning[k] + first * gradient[k];
                        element.matrix[velocity_row + k] = -by_state;
                    }
                    for (other, turned) in turned.of_row(i).iter().enumerate() {
                        element.matrix[velocity_row + n + forces + other] = -h * shift * turned;
                    }
                    if m == j {
                        element.matrix[velocity_row + n + i] = 1.0;
                        // Of what it follows the factors change with the state, which Newton's method learns by iterating.
                        for &(_, surface, factor) in
                            constraints.loads.iter().filter(|load| load.0 == i)
                        {
                            element.matrix[velocity_row + n + surface] -= factor;
                        }
                    }
                    continue;
                }
                for k in 0..n {
                    element.matrix[velocity_row + k] =
                        (second * turning[k] + first * gradient[k]) / h;
                }
                for (other, turned) in turned.of_row(i).iter().enumerate() {
                    element.matrix[velocity_row + n + forces + other] = shift * turned;
                }
                if m == j {
                    let own = &mut element.matrix[velocity_row + n..][..forces];
                    constraints.redundancy[0].add_row(i, own);
                }
            }
            hold_positions(element, (m, j), second, &along);
        }
        numerical_time::add_to_rows(element, m);
    }
}

/// The rows of positions of stage `m` in the columns of stage `j`, of whose accelerations `second` makes coordinates.
fn hold_positions(
    element: &mut FiniteElement<'_>,
    (m, j): (usize, usize),
    second: f64,
    along: &Products,
) {
    let (n, h, block) = (element.n, element.length, element.block());
    let (constraints, size) = (&element.constraints, element.tableau.stages() * block);
    let (forces, positions) = (constraints.count(), constraints.positions());
    let (rows, columns) = (m * block, j * block);
    for i in 0..positions {
        let normal = &constraints.gradients[i * n..(i + 1) * n];
        let gap_row = (rows + n + forces + i) * size + columns;
        for (entry, gradient) in element.matrix[gap_row..].iter_mut().zip(normal) {
            *entry = second * gradient / (h * h);
        }
        for (other, along) in along.of_row(i).iter().enumerate() {
            element.matrix[gap_row + n + forces + other] = element.tableau.a(m, j) * along;
        }
        if m == j {
            let own = &mut element.matrix[gap_row + n + forces..][..positions];
            constraints.redundancy[1].add_row(i, own);
        }
    }
}

/// Derivatives of the right-hand side and the constraints at stage `m`.
pub(super) fn evaluate_stage_jacobian(element: &mut FiniteElement<'_>, m: usize) {
    let (n, block) = (element.n, element.block());
    let declaration = element.model.declaration();
    let x = &element.inputs_of_stages[m * element.inputs..(m + 1) * element.inputs];
    element.by_q.fill(0.0);
    element.by_v.fill(0.0);
    element
        .model
        .jacobian(Function::Motion, x, &mut element.free_jacobian);
    for (&(row, column), value) in declaration
        .free_jacobian
        .entries
        .iter()
        .zip(&element.free_jacobian)
    {
        let (row, column) = (row as usize, column as usize);
        if column < n {
            element.by_q[row * n + column] += value;
        } else if column < 2 * n {
            element.by_v[row * n + column - n] += value;
        }
    }
    let forces = &element.unknowns[m * block + n..(m + 1) * block];
    element
        .constraints
        .differentiate(x, forces, (&mut element.by_q, &mut element.by_v));
}
