//! Directions of forces by an inertia that all contacts of a scene share, and their derivatives.
//!
//! With vectors `c_1, .., c_m`, the last of them the normal `n`, the unknowns `Y = (y_1, .., y_m, r)` of a contact solve
//! `G(x, Y) = 0`,
//!
//! ```text
//! G_k = K y_k - c_k r      G_last = n' y_m - 1
//! ```
//!
//! and those of the direction of a force `K y_1 - c_1 = 0`. With `K = L D L'` and `z_k = K^-1 c_k`, `r = 1/(n' z_m)` and `y_k = z_k r`.
//! For multipliers `lambda` of the first direction and `mu = G_Y^-T lambda`,
//!
//! ```text
//! A = dY/dx = -G_Y^-1 G_x          d2(lambda' y_1)/dx2 = -(mu' G)_xx - P' A - A' P          P = d(G_Y' mu)/dx
//! ```
//!
//! which needs `d(K y)/dx` and `(mu' K y)_xx` of the scene, and the derivatives of the vectors alone.

use std::cell::Cell;

/// A kernel: input vector, second vector, values.
pub type Kernel<'a> = &'a dyn Fn(&[f64], &[f64], &mut [f64]);

/// Position of a structural nonzero: row, column.
pub type Place = (usize, usize);

/// The nonzeros of a matrix.
#[derive(Clone, Copy)]
pub struct Nonzeros<'a> {
    /// Their kernel.
    pub kernel: Kernel<'a>,
    /// Their positions.
    pub places: &'a [Place],
}

/// The inertia `K(x)` of a scene.
#[derive(Clone, Copy)]
pub struct Inertia<'a> {
    /// For each row of the lower triangle, the first column that elimination may fill; as many as `K` has rows.
    pub envelope: &'a [usize],
    /// `K`, row-major.
    pub matrix: Kernel<'a>,
    /// `d(K y)/dx` with the second vector `y`.
    pub product: Nonzeros<'a>,
    /// `(mu' K y)_xx`, lower triangle, with the second vector `(mu, y)`.
    pub curvature: Nonzeros<'a>,
    /// Number of columns of derivatives.
    pub inputs: usize,
}

/// The vectors of a direction.
#[derive(Clone, Copy)]
pub struct Columns<'a> {
    /// Number of vectors.
    pub count: usize,
    /// Whether the last one is the normal that scales all.
    pub bordered: bool,
    /// All components, of one vector after the other.
    pub values: Kernel<'a>,
    /// Their derivatives.
    pub jacobian: Nonzeros<'a>,
    /// Second derivatives of their sum weighted by the second vector, lower triangle.
    pub hessian: Nonzeros<'a>,
}

/// The memory of a thread, so that no call allocates after the first ones.
#[derive(Default)]
struct Workspace {
    /// The last `K`, and its factors: unit lower triangle, and pivots on the diagonal.
    matrix: Vec<f64>,
    factors: Vec<f64>,
    other: Vec<f64>,
    /// `c_k`, `z_k` and `y_k` of all vectors, and `r`.
    columns: Vec<f64>,
    along: Vec<f64>,
    solution: Vec<f64>,
    r: f64,
    /// `mu`, its last component behind all others.
    multipliers: Vec<f64>,
    /// `A`, row-major, with the row of `r` last.
    sensitivity: Vec<f64>,
    values: Vec<f64>,
    weights: Vec<f64>,
    product: Vec<f64>,
}

thread_local! {
    static WORKSPACE: Cell<Option<Box<Workspace>>> = const { Cell::new(None) };
}

fn lend<T>(work: impl FnOnce(&mut Workspace) -> T) -> T {
    let mut workspace = WORKSPACE.take().unwrap_or_default();
    let result = work(&mut workspace);
    WORKSPACE.set(Some(workspace));
    result
}

/// The first direction, as far as there is room for it, and `1/r`, the inverse inertia along the normal; 1 where no normal
/// scales it.
pub fn direction(
    inertia: &Inertia<'_>,
    columns: &Columns<'_>,
    x: &[f64],
    direction: &mut [f64],
) -> f64 {
    lend(|workspace| {
        workspace.solve(inertia, columns, x);
        for (component, value) in direction.iter_mut().zip(&workspace.solution) {
            *component = *value;
        }
        1.0 / workspace.r
    })
}

/// Derivatives of the first direction at some places, from whose rows `above` is subtracted.
pub fn direction_jacobian(
    inertia: &Inertia<'_>,
    columns: &Columns<'_>,
    x: &[f64],
    (places, above): (&[Place], usize),
    values: &mut [f64],
) {
    lend(|workspace| {
        workspace.solve(inertia, columns, x);
        workspace.differentiate(inertia, columns, x);
        for (&(row, column), value) in places.iter().zip(values) {
            *value = workspace.sensitivity[(row - above) * inertia.inputs + column];
        }
    });
}

/// Second derivatives of the first direction weighted by `multipliers`, at some places of the lower triangle.
pub fn direction_hessian(
    inertia: &Inertia<'_>,
    columns: &Columns<'_>,
    (x, multipliers): (&[f64], &[f64]),
    places: &[Place],
    values: &mut [f64],
) {
    lend(|workspace| {
        workspace.solve(inertia, columns, x);
        workspace.differentiate(inertia, columns, x);
        workspace.transposed(columns, multipliers, inertia.envelope);
        workspace.second(inertia, columns, x);
        let (product, n) = (&workspace.product, inertia.inputs);
        for (&(i, j), value) in places.iter().zip(values) {
            *value = -(product[i * n + j] + product[j * n + i]);
        }
    });
}

impl Workspace {
    /// Factorizes `K` unless it is the one of the last call, and solves for `Y`.
    fn solve(&mut self, inertia: &Inertia<'_>, columns: &Columns<'_>, x: &[f64]) {
        let size = inertia.envelope.len();
        zeros(&mut self.other, size * size);
        (inertia.matrix)(x, &[], &mut self.other);
        // One that is not a number is never equal to itself.
        if self.other != self.matrix {
            std::mem::swap(&mut self.matrix, &mut self.other);
            self.factors.clear();
            self.factors.extend_from_slice(&self.matrix);
            factorize(&mut self.factors, inertia.envelope);
        }
        zeros(&mut self.columns, columns.count * size);
        (columns.values)(x, &[], &mut self.columns);
        self.along.clear();
        self.along.extend_from_slice(&self.columns);
        for block in self.along.chunks_exact_mut(size) {
            back_substitute(&self.factors, inertia.envelope, block);
        }
        self.r = if columns.bordered {
            1.0 / inner(last(&self.columns, size), last(&self.along, size))
        } else {
            1.0
        };
        self.solution.clear();
        let scaled = self.along.iter().map(|z| z * self.r);
        self.solution.extend(scaled);
    }

    /// `A = -G_Y^-1 G_x`: `y_k' = K^-1 (c_k' r - (K y_k)') + z_k r'`, and `r'` from `n' y_m = 1`.
    fn differentiate(&mut self, inertia: &Inertia<'_>, columns: &Columns<'_>, x: &[f64]) {
        let (size, inputs) = (inertia.envelope.len(), inertia.inputs);
        let count = columns.count * size;
        zeros(&mut self.sensitivity, (count + 1) * inputs);
        zeros(&mut self.values, inertia.product.places.len());
        for k in 0..columns.count {
            let y = &self.solution[k * size..][..size];
            (inertia.product.kernel)(x, y, &mut self.values);
            for (&(row, column), value) in inertia.product.places.iter().zip(&self.values) {
                self.sensitivity[(k * size + row) * inputs + column] -= value;
            }
        }
        zeros(&mut self.values, columns.jacobian.places.len());
        (columns.jacobian.kernel)(x, &[], &mut self.values);
        let normal = count - size;
        let (a, closing) = self.sensitivity.split_at_mut(count * inputs);
        for (&(row, column), value) in columns.jacobian.places.iter().zip(&self.values) {
            a[row * inputs + column] += value * self.r;
            if columns.bordered && row >= normal {
                closing[column] -= value * self.solution[row];
            }
        }
        for block in a.chunks_exact_mut(size * inputs) {
            back_substitute_rows(&self.factors, inertia.envelope, block, inputs);
        }
        if !columns.bordered {
            return;
        }
        // The rate of `r`, and what it makes of all.
        let rows = a[normal * inputs..].chunks_exact(inputs);
        for (row, component) in rows.zip(last(&self.columns, size)) {
            subtract(closing, row, *component);
        }
        for value in closing.iter_mut() {
            *value *= self.r;
        }
        for (row, along) in a.chunks_exact_mut(inputs).zip(&self.along) {
            subtract(row, closing, -along);
        }
    }

    /// `mu = G_Y^-T lambda` for multipliers of the first direction.
    fn transposed(&mut self, columns: &Columns<'_>, lambda: &[f64], envelope: &[usize]) {
        let size = envelope.len();
        zeros(&mut self.multipliers, columns.count * size + 1);
        self.multipliers[..lambda.len()].copy_from_slice(lambda);
        back_substitute(&self.factors, envelope, &mut self.multipliers[..size]);
        if !columns.bordered {
            return;
        }
        let (mu, closing) = self.multipliers.split_at_mut(columns.count * size);
        closing[0] = inner(&self.columns[..size], &mu[..size]) * self.r;
        let normal = mu.len() - size;
        for (mu, along) in mu[normal..].iter_mut().zip(last(&self.along, size)) {
            *mu -= along * closing[0];
        }
    }

    /// `P' A` and half of `(mu' G)_xx`, in the place of which that with its transpose is minus the Hessian.
    fn second(&mut self, inertia: &Inertia<'_>, columns: &Columns<'_>, x: &[f64]) {
        let (size, inputs) = (inertia.envelope.len(), inertia.inputs);
        let count = columns.count * size;
        zeros(&mut self.product, inputs * inputs);
        let (mu, closing) = self.multipliers.split_at(count);
        for k in 0..columns.count {
            let own = k * size..(k + 1) * size;
            self.weights.clear();
            self.weights.extend_from_slice(&mu[own.clone()]);
            self.weights.extend_from_slice(&self.solution[own.clone()]);
            zeros(&mut self.values, inertia.curvature.places.len());
            (inertia.curvature.kernel)(x, &self.weights, &mut self.values);
            add(
                &mut self.product,
                inputs,
                inertia.curvature.places,
                &self.values,
            );
            zeros(&mut self.values, inertia.product.places.len());
            (inertia.product.kernel)(x, &mu[own], &mut self.values);
            for (&(row, i), &value) in inertia.product.places.iter().zip(&self.values) {
                let from = &self.sensitivity[(k * size + row) * inputs..][..inputs];
                subtract(&mut self.product[i * inputs..][..inputs], from, -value);
            }
        }
        // The vectors: `-r mu_k' c_k`, and `mu_last y_m' n`.
        let normal = count - size;
        let closing = if columns.bordered { closing[0] } else { 0.0 };
        self.weights.clear();
        self.weights.extend(mu.iter().map(|mu| -mu * self.r));
        for (weight, y) in self.weights[normal..]
            .iter_mut()
            .zip(&self.solution[normal..])
        {
            *weight += closing * y;
        }
        zeros(&mut self.values, columns.hessian.places.len());
        (columns.hessian.kernel)(x, &self.weights, &mut self.values);
        add(
            &mut self.product,
            inputs,
            columns.hessian.places,
            &self.values,
        );
        if !columns.bordered {
            return;
        }
        zeros(&mut self.values, columns.jacobian.places.len());
        (columns.jacobian.kernel)(x, &[], &mut self.values);
        let of_r = &self.sensitivity[count * inputs..];
        for (&(row, i), &value) in columns.jacobian.places.iter().zip(&self.values) {
            let to = &mut self.product[i * inputs..][..inputs];
            subtract(to, of_r, value * mu[row]);
            if row >= normal {
                let from = &self.sensitivity[row * inputs..][..inputs];
                subtract(to, from, -value * closing);
            }
        }
    }
}

/// Adds a symmetric matrix of which the lower triangle is given, half of it, so that the sum with the transpose is all of it.
fn add(product: &mut [f64], inputs: usize, places: &[Place], values: &[f64]) {
    for (&(i, j), &value) in places.iter().zip(values) {
        product[i * inputs + j] += if i == j { 0.5 * value } else { value };
    }
}

/// `K = L D L'` within its envelope, without exchanges: a mass matrix is positive definite, and behind it the rows of
/// joints that hold are not dependent.
fn factorize(factors: &mut [f64], envelope: &[usize]) {
    let n = envelope.len();
    for (i, &first) in envelope.iter().enumerate() {
        let (above, row) = factors.split_at_mut(i * n);
        let row = &mut row[..=i];
        // The entries of L D, then of L.
        for j in first..i {
            let from = first.max(envelope[j]);
            row[j] -= inner(&row[from..j], &above[j * n..][from..j]);
        }
        let mut pivot = row[i];
        for j in first..i {
            let scaled = row[j];
            row[j] = scaled / above[j * n + j];
            pivot -= scaled * row[j];
        }
        row[i] = pivot;
    }
}

/// Solution of `K x = b` in the place of `b`.
fn back_substitute(factors: &[f64], envelope: &[usize], x: &mut [f64]) {
    let n = envelope.len();
    for (i, &first) in envelope.iter().enumerate() {
        x[i] -= inner(&factors[i * n..][first..i], &x[first..i]);
    }
    for (i, x) in x.iter_mut().enumerate() {
        *x /= factors[i * n + i];
    }
    for (i, &first) in envelope.iter().enumerate().rev() {
        let (before, own) = x.split_at_mut(i);
        subtract(&mut before[first..], &factors[i * n..][first..i], own[0]);
    }
}

/// The same for all columns of a matrix with `columns` of them, row-major.
fn back_substitute_rows(factors: &[f64], envelope: &[usize], x: &mut [f64], columns: usize) {
    let n = envelope.len();
    for (i, &first) in envelope.iter().enumerate() {
        let (before, own) = x.split_at_mut(i * columns);
        for j in first..i {
            let row = &before[j * columns..][..columns];
            subtract(&mut own[..columns], row, factors[i * n + j]);
        }
    }
    for (i, row) in x.chunks_exact_mut(columns).enumerate() {
        let inverse = 1.0 / factors[i * n + i];
        for value in row {
            *value *= inverse;
        }
    }
    for (i, &first) in envelope.iter().enumerate().rev() {
        let (before, own) = x.split_at_mut(i * columns);
        for j in first..i {
            let row = &mut before[j * columns..][..columns];
            subtract(row, &own[..columns], factors[i * n + j]);
        }
    }
}

/// The last block of a vector.
fn last(vector: &[f64], size: usize) -> &[f64] {
    &vector[vector.len() - size..]
}

fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `y -= factor * x`.
fn subtract(y: &mut [f64], x: &[f64], factor: f64) {
    if factor != 0.0 {
        for (y, x) in y.iter_mut().zip(x) {
            *y -= factor * x;
        }
    }
}

/// The vector with this length, of zeros.
fn zeros(vector: &mut Vec<f64>, length: usize) {
    vector.clear();
    vector.resize(length, 0.0);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step of central differences: 1e-16/1e-5 of rounding and 1e-10 of the third derivatives.
    const STEP: f64 = 1e-5;
    const TOLERANCE: f64 = 1e-9;

    /// `K = [[2 + sin x, y, 0], [y, 3 + x^2, x y], [0, x y, 4]]`, with vectors `(x, 1, y^2)` and `n = (1, x y, sin y)`.
    fn with<T>(bordered: bool, work: impl FnOnce(&Inertia<'_>, &Columns<'_>) -> T) -> T {
        let matrix = |x: &[f64], _: &[f64], k: &mut [f64]| {
            let (x, y) = (x[0], x[1]);
            let values = [
                2.0 + x.sin(),
                y,
                0.0,
                y,
                3.0 + x * x,
                x * y,
                0.0,
                x * y,
                4.0,
            ];
            k.copy_from_slice(&values);
        };
        let product = |x: &[f64], v: &[f64], out: &mut [f64]| {
            let (x, y) = (x[0], x[1]);
            let values = [
                x.cos() * v[0],
                v[1],
                2.0 * x * v[1] + y * v[2],
                v[0] + x * v[2],
                y * v[1],
                x * v[1],
            ];
            out.copy_from_slice(&values);
        };
        let curvature = |x: &[f64], v: &[f64], out: &mut [f64]| {
            let (mu, v) = v.split_at(3);
            out[0] = -x[0].sin() * mu[0] * v[0] + 2.0 * mu[1] * v[1];
            out[1] = mu[1] * v[2] + mu[2] * v[1];
        };
        let values = |x: &[f64], _: &[f64], out: &mut [f64]| {
            let all = [x[0], 1.0, x[1] * x[1], 1.0, x[0] * x[1], x[1].sin()];
            out.copy_from_slice(&all[..out.len()]);
        };
        let jacobian = |x: &[f64], _: &[f64], out: &mut [f64]| {
            let all = [1.0, 2.0 * x[1], x[1], x[0], x[1].cos()];
            out.copy_from_slice(&all[..out.len()]);
        };
        let hessian = |x: &[f64], w: &[f64], out: &mut [f64]| {
            let normal = w.get(3..).map_or([0.0; 2], |w| [w[1], -x[1].sin() * w[2]]);
            out.copy_from_slice(&[normal[0], 2.0 * w[2] + normal[1]]);
        };
        let count = if bordered { 2 } else { 1 };
        work(
            &Inertia {
                envelope: &[0, 0, 1],
                matrix: &matrix,
                product: Nonzeros {
                    kernel: &product,
                    places: &[(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)],
                },
                curvature: Nonzeros {
                    kernel: &curvature,
                    places: &[(0, 0), (1, 0)],
                },
                inputs: 2,
            },
            &Columns {
                count,
                bordered,
                values: &values,
                jacobian: Nonzeros {
                    kernel: &jacobian,
                    places: &[(0, 0), (2, 1), (4, 0), (4, 1), (5, 1)]
                        [..if bordered { 5 } else { 2 }],
                },
                hessian: Nonzeros {
                    kernel: &hessian,
                    places: &[(1, 0), (1, 1)],
                },
            },
        )
    }

    fn value(bordered: bool, x: &[f64]) -> ([f64; 3], f64) {
        let mut found = [0.0; 3];
        let inverse = with(bordered, |inertia, columns| {
            direction(inertia, columns, x, &mut found)
        });
        (found, inverse)
    }

    fn slopes(bordered: bool, x: &[f64]) -> [f64; 6] {
        let places = [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)];
        let mut found = [0.0; 6];
        with(bordered, |inertia, columns| {
            direction_jacobian(inertia, columns, x, (&places, 0), &mut found);
        });
        found
    }

    /// A point and the two beside it along an input.
    fn beside(x: [f64; 2], input: usize) -> [[f64; 2]; 2] {
        [STEP, -STEP].map(|step| {
            let mut moved = x;
            moved[input] += step;
            moved
        })
    }

    #[test]
    fn directions_solve_their_equations() {
        let x = [0.7, -0.4];
        let k = [
            [2.0 + 0.7_f64.sin(), -0.4, 0.0],
            [-0.4, 3.49, -0.28],
            [0.0, -0.28, 4.0],
        ];
        let (c, n) = ([0.7, 1.0, 0.16], [1.0, -0.28, (-0.4_f64).sin()]);
        let (alone, _) = value(false, &x);
        let (scaled, inverse) = value(true, &x);
        for i in 0..3 {
            let rows = |v: &[f64; 3]| inner(&k[i], v);
            // A handful of roundings of numbers near one.
            assert!((rows(&alone) - c[i]).abs() < 1e-14);
            assert!((rows(&scaled) * inverse - c[i]).abs() < 1e-14);
        }
        // 1/r = n' K^-1 n, by what solves for the normal alone.
        let mut z = n;
        let mut factors = k.concat();
        factorize(&mut factors, &[0, 0, 1]);
        back_substitute(&factors, &[0, 0, 1], &mut z);
        assert!((inner(&z, &n) - inverse).abs() < 1e-14);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let (x, lambda) = ([0.7, -0.4], [0.3, -1.1, 0.8]);
        for bordered in [false, true] {
            let found = slopes(bordered, &x);
            let mut second = [0.0; 3];
            with(bordered, |inertia, columns| {
                let places = [(0, 0), (1, 0), (1, 1)];
                direction_hessian(inertia, columns, (&x, &lambda), &places, &mut second);
            });
            let second = [[second[0], second[1]], [second[1], second[2]]];
            for input in 0..2 {
                let [ahead, behind] = beside(x, input);
                let (ahead_value, behind_value) =
                    (value(bordered, &ahead).0, value(bordered, &behind).0);
                for i in 0..3 {
                    let slope = (ahead_value[i] - behind_value[i]) / (2.0 * STEP);
                    assert!((slope - found[2 * i + input]).abs() < TOLERANCE);
                }
                let (ahead, behind) = (slopes(bordered, &ahead), slopes(bordered, &behind));
                for j in 0..2 {
                    let change = |i: usize| (ahead[2 * i + j] - behind[2 * i + j]) / (2.0 * STEP);
                    let wanted: f64 = (0..3).map(|i| lambda[i] * change(i)).sum();
                    let error = (wanted - second[input][j]).abs();
                    assert!(error < TOLERANCE, "{bordered} {input} {j}: {wanted}");
                }
            }
        }
    }
}
