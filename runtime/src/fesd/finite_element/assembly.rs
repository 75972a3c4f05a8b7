//! The Newton matrix of an element.

use super::{FiniteElement, numerical_time};

/// The Newton matrix at the present stages.
pub(super) fn assemble(element: &mut FiniteElement<'_>) {
    let (n, h, block) = (element.n, element.length, element.block());
    let (positions, forces) = (element.constraints.positions(), element.constraints.count());
    let stages = element.tableau.stages();
    let size = stages * block;
    element.matrix.clear();
    element.matrix.resize(size * size, 0.0);
    numerical_time::differentiate(element);
    for m in 0..stages {
        evaluate_stage_jacobian(element, m);
        let constraints = &element.constraints;
        for j in 0..stages {
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
                for i in 0..positions {
                    let terms = by_q.iter().zip(&element.corrections[i * n..]);
                    let correction: f64 = terms.map(|(q, c)| q * c).sum();
                    line[n + forces + i] -= h * shift * correction;
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
                    for other in 0..positions {
                        let correction = &element.corrections[other * n..(other + 1) * n];
                        let turned: f64 = turning.iter().zip(correction).map(|(a, b)| a * b).sum();
                        element.matrix[velocity_row + n + forces + other] = -h * shift * turned;
                    }
                    if m == j {
                        element.matrix[velocity_row + n + i] = 1.0;
                    }
                    continue;
                }
                for k in 0..n {
                    element.matrix[velocity_row + k] =
                        (second * turning[k] + first * gradient[k]) / h;
                }
                for other in 0..positions {
                    let correction = &element.corrections[other * n..(other + 1) * n];
                    let turned: f64 = turning.iter().zip(correction).map(|(a, b)| a * b).sum();
                    element.matrix[velocity_row + n + forces + other] = shift * turned;
                }
            }
            for i in 0..positions {
                let row = constraints.of_position(i);
                let normal = &constraints.gradients[row * n..(row + 1) * n];
                let gap_row = (rows + n + forces + i) * size + columns;
                for (entry, gradient) in element.matrix[gap_row..].iter_mut().zip(normal) {
                    *entry = second * gradient / (h * h);
                }
                for other in 0..positions {
                    let correction = &element.corrections[other * n..(other + 1) * n];
                    let along: f64 = normal.iter().zip(correction).map(|(a, b)| a * b).sum();
                    element.matrix[gap_row + n + forces + other] = element.tableau.a(m, j) * along;
                }
            }
        }
        numerical_time::add_to_rows(element, m);
    }
}

/// Derivatives of the right-hand side and the constraints at stage `m`.
fn evaluate_stage_jacobian(element: &mut FiniteElement<'_>, m: usize) {
    let (n, block) = (element.n, element.block());
    let declaration = element.model.declaration();
    let x = &element.inputs_of_stages[m * element.inputs..(m + 1) * element.inputs];
    element.by_q.fill(0.0);
    element.by_v.fill(0.0);
    element.model.free_jacobian(x, &mut element.free_jacobian);
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
