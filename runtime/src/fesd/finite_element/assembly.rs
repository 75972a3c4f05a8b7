//! The Newton matrix of an element.

use super::FiniteElement;

impl FiniteElement<'_> {
    /// The Newton matrix at the present stages.
    pub(super) fn assemble(&mut self) {
        let (n, h, block) = (self.n, self.length, self.block());
        let (contacts, forces) = (self.active().len(), self.constraints.count());
        let stages = self.tableau.stages();
        let size = stages * block;
        self.matrix.clear();
        self.matrix.resize(size * size, 0.0);
        for m in 0..stages {
            self.evaluate_stage_jacobian(m);
            let constraints = &self.constraints;
            for j in 0..stages {
                let first = h * self.tableau.a(m, j);
                let second = h * h * self.tableau.a_squared(m, j);
                let rows = m * block;
                let columns = j * block;
                for row in 0..n {
                    let line = &mut self.matrix[(rows + row) * size + columns..][..block];
                    let by_q = &self.by_q[row * n..(row + 1) * n];
                    let by_v = &self.by_v[row * n..(row + 1) * n];
                    for (entry, (q, v)) in line.iter_mut().zip(by_q.iter().zip(by_v)) {
                        *entry -= second * q + first * v;
                    }
                    for i in 0..contacts {
                        let correction: f64 = (0..n)
                            .map(|k| self.by_q[row * n + k] * self.corrections[i * n + k])
                            .sum();
                        line[n + forces + i] -= h * first * correction;
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
                    for k in 0..n {
                        self.matrix[velocity_row + k] =
                            (second * turning[k] + first * gradient[k]) / h;
                    }
                    for other in 0..contacts {
                        let correction = &self.corrections[other * n..(other + 1) * n];
                        let turned: f64 = turning.iter().zip(correction).map(|(a, b)| a * b).sum();
                        self.matrix[velocity_row + n + forces + other] = first * turned;
                    }
                }
                for i in 0..contacts {
                    let normal = &constraints.gradients[i * n..(i + 1) * n];
                    let gap_row = (rows + n + forces + i) * size + columns;
                    for (entry, gradient) in self.matrix[gap_row..].iter_mut().zip(normal) {
                        *entry = second * gradient / (h * h);
                    }
                    for other in 0..contacts {
                        let correction = &self.corrections[other * n..(other + 1) * n];
                        let along: f64 = normal.iter().zip(correction).map(|(a, b)| a * b).sum();
                        self.matrix[gap_row + n + forces + other] = self.tableau.a(m, j) * along;
                    }
                }
            }
        }
    }

    /// Derivatives of the right-hand side and the constraints at stage `m`.
    fn evaluate_stage_jacobian(&mut self, m: usize) {
        let (n, block) = (self.n, self.block());
        let declaration = self.model.declaration();
        let x = &self.inputs_of_stages[m * self.inputs..(m + 1) * self.inputs];
        self.by_q.fill(0.0);
        self.by_v.fill(0.0);
        self.model.free_jacobian(x, &mut self.free_jacobian);
        for (&(row, column), value) in declaration
            .free_jacobian
            .entries
            .iter()
            .zip(&self.free_jacobian)
        {
            let (row, column) = (row as usize, column as usize);
            if column < n {
                self.by_q[row * n + column] += value;
            } else if column < 2 * n {
                self.by_v[row * n + column - n] += value;
            }
        }
        let forces = &self.unknowns[m * block + n..(m + 1) * block];
        self.constraints.differentiate(x, forces, &mut self.by_q);
    }
}
