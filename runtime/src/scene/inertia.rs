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

use super::data::{Inertia, Places, Vectors};
use super::system::{at, inner, subtract, zeros};
use std::cell::Cell;

/// Evaluates a kernel: its index, input vector, second vector, values.
pub(super) type Evaluate<'a> = &'a dyn Fn(usize, &[f64], &[f64], &mut [f64]);

/// A direction at one point.
#[derive(Clone, Copy)]
pub(super) struct Direction<'a> {
    /// The inertia `K(x)` of the scene.
    pub(super) inertia: Inertia,
    /// The vectors of the direction.
    pub(super) vectors: Vectors,
    /// Number of columns of derivatives.
    pub(super) inputs: usize,
    /// Evaluates kernels.
    pub(super) evaluate: Evaluate<'a>,
    /// The input vector.
    pub(super) x: &'a [f64],
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

impl Direction<'_> {
    /// Writes the first direction, as far as there is room for it, and gives `1/r`, the inverse inertia along the normal; 1 where no
    /// normal scales it.
    pub(super) fn value(&self, direction: &mut [f64]) -> f64 {
        lend(|workspace| {
            workspace.solve(self);
            for (component, value) in direction.iter_mut().zip(&workspace.solution) {
                *component = *value;
            }
            1.0 / workspace.r
        })
    }

    /// Derivatives of the first direction at some places, from whose rows `above` is subtracted.
    pub(super) fn jacobian(&self, (places, above): (Places, usize), values: &mut [f64]) {
        lend(|workspace| {
            workspace.solve(self);
            workspace.differentiate(self);
            for (&(row, column), value) in places.iter().zip(values) {
                let place = (row as usize - above) * self.inputs + column as usize;
                *value = workspace.sensitivity[place];
            }
        });
    }

    /// Second derivatives of the first direction weighted by `multipliers`, at some places of the lower triangle.
    pub(super) fn hessian(&self, multipliers: &[f64], places: Places, values: &mut [f64]) {
        lend(|workspace| {
            workspace.solve(self);
            workspace.differentiate(self);
            workspace.transposed(self, multipliers);
            workspace.second(self);
            let (product, n) = (&workspace.product, self.inputs);
            for (&(i, j), value) in places.iter().zip(values) {
                let (i, j) = (i as usize, j as usize);
                *value = -(product[i * n + j] + product[j * n + i]);
            }
        });
    }

    /// Order of `K`.
    fn size(&self) -> usize {
        self.inertia.envelope.len()
    }
}

impl Workspace {
    /// Factorizes `K` unless it is the one of the last call, and solves for `Y`.
    fn solve(&mut self, of: &Direction<'_>) {
        let (size, envelope) = (of.size(), of.inertia.envelope);
        zeros(&mut self.other, size * size);
        (of.evaluate)(of.inertia.matrix, of.x, &[], &mut self.other);
        // One that is not a number is never equal to itself.
        if self.other != self.matrix {
            std::mem::swap(&mut self.matrix, &mut self.other);
            self.factors.clear();
            self.factors.extend_from_slice(&self.matrix);
            factorize(&mut self.factors, envelope);
        }
        zeros(&mut self.columns, of.vectors.count * size);
        (of.evaluate)(of.vectors.values, of.x, &[], &mut self.columns);
        self.along.clear();
        self.along.extend_from_slice(&self.columns);
        for block in self.along.chunks_exact_mut(size) {
            back_substitute(&self.factors, envelope, block);
        }
        self.r = if of.vectors.bordered {
            1.0 / inner(last(&self.columns, size), last(&self.along, size))
        } else {
            1.0
        };
        self.solution.clear();
        let scaled = self.along.iter().map(|z| z * self.r);
        self.solution.extend(scaled);
    }

    /// `A = -G_Y^-1 G_x`: `y_k' = K^-1 (c_k' r - (K y_k)') + z_k r'`, and `r'` from `n' y_m = 1`.
    fn differentiate(&mut self, of: &Direction<'_>) {
        let (size, inputs) = (of.size(), of.inputs);
        let (product, product_places) = of.inertia.product;
        let (jacobian, jacobian_places) = of.vectors.jacobian;
        let count = of.vectors.count * size;
        zeros(&mut self.sensitivity, (count + 1) * inputs);
        zeros(&mut self.values, product_places.len());
        for k in 0..of.vectors.count {
            let y = &self.solution[k * size..][..size];
            (of.evaluate)(product, of.x, y, &mut self.values);
            for (&place, value) in product_places.iter().zip(&self.values) {
                let (row, column) = at(place);
                self.sensitivity[(k * size + row) * inputs + column] -= value;
            }
        }
        zeros(&mut self.values, jacobian_places.len());
        (of.evaluate)(jacobian, of.x, &[], &mut self.values);
        let normal = count - size;
        let (a, closing) = self.sensitivity.split_at_mut(count * inputs);
        for (&place, value) in jacobian_places.iter().zip(&self.values) {
            let (row, column) = at(place);
            a[row * inputs + column] += value * self.r;
            if of.vectors.bordered && row >= normal {
                closing[column] -= value * self.solution[row];
            }
        }
        for block in a.chunks_exact_mut(size * inputs) {
            back_substitute_rows(&self.factors, of.inertia.envelope, block, inputs);
        }
        if !of.vectors.bordered {
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
    fn transposed(&mut self, of: &Direction<'_>, lambda: &[f64]) {
        let (size, envelope) = (of.size(), of.inertia.envelope);
        zeros(&mut self.multipliers, of.vectors.count * size + 1);
        self.multipliers[..lambda.len()].copy_from_slice(lambda);
        back_substitute(&self.factors, envelope, &mut self.multipliers[..size]);
        if !of.vectors.bordered {
            return;
        }
        let (mu, closing) = self.multipliers.split_at_mut(of.vectors.count * size);
        closing[0] = inner(&self.columns[..size], &mu[..size]) * self.r;
        let normal = mu.len() - size;
        for (mu, along) in mu[normal..].iter_mut().zip(last(&self.along, size)) {
            *mu -= along * closing[0];
        }
    }

    /// `P' A` and half of `(mu' G)_xx`, in the place of which that with its transpose is minus the Hessian.
    fn second(&mut self, of: &Direction<'_>) {
        let (size, inputs) = (of.size(), of.inputs);
        let (product, product_places) = of.inertia.product;
        let (curvature, curvature_places) = of.inertia.curvature;
        let (jacobian, jacobian_places) = of.vectors.jacobian;
        let (hessian, hessian_places) = of.vectors.hessian;
        let count = of.vectors.count * size;
        zeros(&mut self.product, inputs * inputs);
        let (mu, closing) = self.multipliers.split_at(count);
        for k in 0..of.vectors.count {
            let own = k * size..(k + 1) * size;
            self.weights.clear();
            self.weights.extend_from_slice(&mu[own.clone()]);
            self.weights.extend_from_slice(&self.solution[own.clone()]);
            zeros(&mut self.values, curvature_places.len());
            (of.evaluate)(curvature, of.x, &self.weights, &mut self.values);
            add(&mut self.product, inputs, curvature_places, &self.values);
            zeros(&mut self.values, product_places.len());
            (of.evaluate)(product, of.x, &mu[own], &mut self.values);
            for (&place, &value) in product_places.iter().zip(&self.values) {
                let (row, i) = at(place);
                let from = &self.sensitivity[(k * size + row) * inputs..][..inputs];
                subtract(&mut self.product[i * inputs..][..inputs], from, -value);
            }
        }
        // The vectors: `-r mu_k' c_k`, and `mu_last y_m' n`.
        let normal = count - size;
        let closing = if of.vectors.bordered { closing[0] } else { 0.0 };
        self.weights.clear();
        self.weights.extend(mu.iter().map(|mu| -mu * self.r));
        for (weight, y) in self.weights[normal..]
            .iter_mut()
            .zip(&self.solution[normal..])
        {
            *weight += closing * y;
        }
        zeros(&mut self.values, hessian_places.len());
        (of.evaluate)(hessian, of.x, &self.weights, &mut self.values);
        add(&mut self.product, inputs, hessian_places, &self.values);
        if !of.vectors.bordered {
            return;
        }
        zeros(&mut self.values, jacobian_places.len());
        (of.evaluate)(jacobian, of.x, &[], &mut self.values);
        let of_r = &self.sensitivity[count * inputs..];
        for (&place, &value) in jacobian_places.iter().zip(&self.values) {
            let (row, i) = at(place);
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
fn add(product: &mut [f64], inputs: usize, places: Places, values: &[f64]) {
    for (&place, &value) in places.iter().zip(values) {
        let (i, j) = at(place);
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

/// Back substitution for all columns of a matrix with `columns` of them, row-major.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A step of central differences: 1e-16/1e-5 of rounding and 1e-10 of the third derivatives.
    const STEP: f64 = 1e-5;
    const TOLERANCE: f64 = 1e-9;

    /// `K = [[2 + sin x, y, 0], [y, 3 + x^2, x y], [0, x y, 4]]`, with vectors `(x, 1, y^2)` and `n = (1, x y, sin y)`.
    fn with<T>(bordered: bool, x: &[f64], work: impl FnOnce(&Direction<'_>) -> T) -> T {
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
            let normal = match w.len() {
                6 => [w[4], -x[1].sin() * w[5]],
                _ => [0.0; 2],
            };
            out.copy_from_slice(&[normal[0], 2.0 * w[2] + normal[1]]);
        };
        let evaluate = |kernel: usize, x: &[f64], y: &[f64], out: &mut [f64]| match kernel {
            0 => matrix(x, y, out),
            1 => product(x, y, out),
            2 => curvature(x, y, out),
            3 => values(x, y, out),
            4 => jacobian(x, y, out),
            _ => hessian(x, y, out),
        };
        let places = &[(0, 0), (2, 1), (4, 0), (4, 1), (5, 1)];
        work(&Direction {
            inertia: Inertia {
                size: 3,
                envelope: &[0, 0, 1],
                matrix: 0,
                product: (1, &[(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)]),
                curvature: (2, &[(0, 0), (1, 0)]),
            },
            vectors: Vectors {
                count: if bordered { 2 } else { 1 },
                bordered,
                values: 3,
                jacobian: (4, if bordered { places } else { &places[..2] }),
                hessian: (5, &[(1, 0), (1, 1)]),
            },
            inputs: 2,
            evaluate: &evaluate,
            x,
        })
    }

    fn value(bordered: bool, x: &[f64]) -> ([f64; 3], f64) {
        let mut found = [0.0; 3];
        let inverse = with(bordered, x, |direction| direction.value(&mut found));
        (found, inverse)
    }

    fn slopes(bordered: bool, x: &[f64]) -> [f64; 6] {
        let places = &[(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)];
        let mut found = [0.0; 6];
        with(bordered, x, |direction| {
            direction.jacobian((places, 0), &mut found)
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
            with(bordered, &x, |direction| {
                direction.hessian(&lambda, &[(0, 0), (1, 0), (1, 1)], &mut second);
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
