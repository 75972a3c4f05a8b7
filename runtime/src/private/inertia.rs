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

/// Derivatives of the first direction at some places.
pub fn direction_jacobian(
    inertia: &Inertia<'_>,
    columns: &Columns<'_>,
    x: &[f64],
    places: &[Place],
    values: &mut [f64],
) {
    lend(|workspace| {
        workspace.solve(inertia, columns, x);
        workspace.differentiate(inertia, columns, x);
        for (&(row, column), value) in places.iter().zip(values) {
            *value = workspace.sensitivity[row * inertia.inputs + column];
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
