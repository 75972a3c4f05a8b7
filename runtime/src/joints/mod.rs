//! Joints at one point: what they hold, and how a state is moved so that they do.
//!
//! With the rows `w = G v - b` of all joints, `g` of those of positions, and the mass matrix `M`, the columns of
//!
//! ```text
//! D = M^-1 G' S^-1,   S = G M^-1 G'
//! ```
//!
//! are the shortest changes in the metric of `M` that change one row by 1 and the others not. So `q - D g` and `v - D w` are
//! Newton's steps onto the joints, and `D` are directions of forces that hold them. Rows that follow from others
//! ([`Model::joint_row_held`]) have no column.

pub(crate) mod partition;

use crate::linalg::dense;
use crate::linalg::products::dot;
use crate::model::{Function, Model, contact_point, joint_rows, tangent_point};

/// Newton steps of one projection.
const STEPS: usize = 8;
/// Share of the distance before a step above which directions are computed anew.
const CONTRACTS: f64 = 0.1;
/// Roundings of a row that are none.
const ROUNDINGS: f64 = 4.0;
/// Pivot of `S`, scaled to a unit diagonal, below which a row follows from those before it.
pub(crate) const DEPENDENT: f64 = 1e-10;

/// Why a state cannot be moved onto the joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum JointError {
    /// Rows that are held depend on each other here.
    Singular,
    /// A value is infinite or not a number, or Newton's method does not get there.
    NotClosed,
}

/// The rows of all joints at a point; owns the memory for them.
pub(crate) struct Joints<'a> {
    model: &'a dyn Model,
    n: usize,
    /// Rows that are held, increasing, and which of them are positions.
    held: Vec<usize>,
    positions: Vec<bool>,
    rows: usize,
    /// `g` and `w` of all rows, held or not.
    values: Vec<f64>,
    jacobian: Vec<f64>,
    /// `dw/dv` of the rows that are held, row-major.
    gradients: Vec<f64>,
    /// Columns of `D`, one after the other.
    directions: Vec<f64>,
    mass: Vec<f64>,
    pivots: Vec<usize>,
    inner: Vec<f64>,
    inner_pivots: Vec<usize>,
    /// Of all rows.
    forces: Vec<f64>,
}

impl<'a> Joints<'a> {
    /// None for a scene without joints.
    pub(crate) fn of(model: &'a dyn Model) -> Option<Self> {
        let declaration = model.declaration();
        let joints = declaration.joints?;
        let rows = joints.rows();
        let held: Vec<usize> = (0..rows).filter(|&i| model.joint_row_held(i)).collect();
        Some(Self::with_rows(model, held))
    }

    /// With these rows held.
    pub(crate) fn with_rows(model: &'a dyn Model, held: Vec<usize>) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let joints = declaration.joints;
        let kinds: Vec<bool> = joints.map_or_else(Vec::new, |joints| {
            joints.equations().map(|(own, _)| own.holonomic).collect()
        });
        let entries = joints.map_or(0, |joints| joints.jacobian.entries.len());
        let count = held.len();
        Self {
            model,
            n,
            positions: held.iter().map(|&row| kinds[row]).collect(),
            rows: kinds.len(),
            values: vec![0.0; 2 * kinds.len()],
            jacobian: vec![0.0; entries],
            gradients: vec![0.0; count * n],
            directions: vec![0.0; count * n],
            mass: vec![0.0; n * n],
            pivots: vec![0; n],
            inner: vec![0.0; count * count],
            inner_pivots: vec![0; count],
            forces: vec![0.0; count],
            held,
        }
    }

    /// The rows that are held, increasing.
    pub(crate) fn held(&self) -> &[usize] {
        &self.held
    }

    /// Number of rows that are held.
    pub(crate) fn count(&self) -> usize {
        self.held.len()
    }

    /// Number of those that are positions.
    pub(crate) fn position_count(&self) -> usize {
        self.positions.iter().filter(|known| **known).count()
    }

    /// Which of the rows that are held are positions: their places, increasing.
    pub(crate) fn positions(&self) -> impl Iterator<Item = usize> + '_ {
        let places = self.positions.iter().enumerate();
        places.filter(|(_, known)| **known).map(|(place, _)| place)
    }

    /// `g` of a row that is held.
    pub(crate) fn position(&self, place: usize) -> f64 {
        self.values[self.held[place]]
    }

    /// `w` of a row that is held.
    pub(crate) fn velocity(&self, place: usize) -> f64 {
        self.values[self.rows + self.held[place]]
    }

    /// `g` and `w` of all rows, held or not.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// `dw/dv`, one row after the other.
    pub(crate) fn gradients(&self) -> &[f64] {
        &self.gradients
    }

    /// Columns of `D`, one after the other.
    pub(crate) fn directions(&self) -> &[f64] {
        &self.directions
    }

    /// Evaluates rows and their derivatives at the input vector `x`.
    pub(crate) fn evaluate(&mut self, x: &[f64]) {
        let n = self.n;
        self.model.values(Function::Joints, x, &mut self.values);
        self.model.jacobian(Function::Joints, x, &mut self.jacobian);
        self.gradients.fill(0.0);
        let Some(joints) = self.model.declaration().joints else {
            return;
        };
        for (&(row, column), value) in joints.jacobian.entries.iter().zip(&self.jacobian) {
            let (row, column) = (row as usize, column as usize);
            if row < self.rows || !(n..2 * n).contains(&column) {
                continue;
            }
            let Ok(place) = self.held.binary_search(&(row - self.rows)) else {
                continue;
            };
            self.gradients[place * n + column - n] = *value;
        }
    }

    /// Rounding error of a row that is held, over a time \[s\].
    pub(crate) fn rounding(&self, place: usize, x: &[f64], time: f64) -> f64 {
        let gradient = &self.gradients[place * self.n..(place + 1) * self.n];
        let terms = gradient.iter().zip(x.iter().zip(&x[self.n..]));
        let sizes = terms.map(|(g, (q, v))| g.abs() * (q.abs() + time * v.abs()));
        f64::EPSILON * sizes.sum::<f64>()
    }

    /// `M^-1 G'` of the rows last evaluated, one column after the other, into `D`; then `S`, row-major.
    fn couplings(&mut self, x: &[f64]) -> Result<(), JointError> {
        let (n, count) = (self.n, self.count());
        self.model.mass_matrix(x, &mut self.mass);
        dense::factorize(&mut self.mass, &mut self.pivots).map_err(|_| JointError::NotClosed)?;
        self.directions.copy_from_slice(&self.gradients);
        for column in self.directions.chunks_exact_mut(n) {
            dense::solve(&self.mass, &self.pivots, column);
        }
        for i in 0..count {
            for j in 0..count {
                let gradient = &self.gradients[i * n..(i + 1) * n];
                let column = &self.directions[j * n..(j + 1) * n];
                self.inner[i * count + j] = dot(gradient, column);
            }
        }
        Ok(())
    }

    /// Computes `D` at `x`, where the rows have been evaluated.
    pub(crate) fn direct(&mut self, x: &[f64]) -> Result<(), JointError> {
        let (n, count) = (self.n, self.count());
        self.couplings(x)?;
        if independent(&self.inner, count).len() < count {
            return Err(JointError::Singular);
        }
        // D' = S^-1 (M^-1 G')', component by component.
        dense::factorize(&mut self.inner, &mut self.inner_pivots)
            .map_err(|_| JointError::Singular)?;
        let mut components = vec![0.0; count];
        for k in 0..n {
            for (i, component) in components.iter_mut().enumerate() {
                *component = self.directions[i * n + k];
            }
            dense::solve(&self.inner, &self.inner_pivots, &mut components);
            for (i, component) in components.iter().enumerate() {
                self.directions[i * n + k] = *component;
            }
        }
        Ok(())
    }

    /// Places of the rows, of those that may be held, that are independent at `x`: each that does not follow from others.
    pub(crate) fn independent_rows(&mut self, x: &[f64]) -> Result<Vec<usize>, JointError> {
        self.evaluate(x);
        self.couplings(x)?;
        Ok(independent(&self.inner, self.count()))
    }

    /// Moves `q` onto `g = 0` by Newton's method in the metric of `M`, `x` being the rest of the input vector; how far it
    /// was, in the largest row by its rounding error.
    pub(crate) fn project_positions(&mut self, x: &mut [f64], time: f64) -> Result<(), JointError> {
        let n = self.n;
        if self.position_count() == 0 {
            return Ok(());
        }
        let mut previous = f64::INFINITY;
        for _ in 0..STEPS {
            self.evaluate(x);
            let places: Vec<usize> = self.positions().collect();
            let mut worst = 0.0_f64;
            for &place in &places {
                let rounding = ROUNDINGS * self.rounding(place, x, time);
                let share = self.position(place).abs() / rounding.max(f64::MIN_POSITIVE);
                // NaN is the worst.
                worst = if share <= worst { worst } else { share };
            }
            if !worst.is_finite() {
                return Err(JointError::NotClosed);
            }
            if worst <= 1.0 || worst >= previous {
                return Ok(());
            }
            previous = worst;
            self.direct(x)?;
            for &place in &places {
                let step = self.position(place);
                let direction = &self.directions[place * n..(place + 1) * n];
                for (q, d) in x.iter_mut().zip(direction) {
                    *q -= step * d;
                }
            }
        }
        Ok(())
    }

    /// Moves `q` and `v`, which nearly fulfil the joints, onto them as [`Self::project_positions`] and [`Self::project_velocities`] do, along
    /// the directions of the first point as long as they lead there: those of the next ones differ by no more than what it is moved by.
    pub(crate) fn settle(&mut self, x: &mut [f64], time: f64) -> Result<(), JointError> {
        let n = self.n;
        self.evaluate(x);
        self.couple(x)?;
        for velocities in [false, true] {
            let mut previous = f64::INFINITY;
            for _ in 0..STEPS {
                let (mut worst, mut moves) = (0.0_f64, false);
                for place in 0..self.count() {
                    if !velocities && !self.positions[place] {
                        continue;
                    }
                    let value = self.off(place, velocities).abs();
                    let gradient = &self.gradients[place * n..(place + 1) * n];
                    let terms = gradient
                        .iter()
                        .zip(&x[n..2 * n])
                        .map(|(g, v)| (g * v).abs());
                    let rounding = if velocities {
                        f64::EPSILON * terms.sum::<f64>()
                    } else {
                        self.rounding(place, x, time)
                    };
                    moves |= value > ROUNDINGS * rounding;
                    // NaN is the worst.
                    worst = if value <= worst { worst } else { value };
                }
                if !worst.is_finite() {
                    return Err(JointError::NotClosed);
                }
                if !moves || worst >= previous {
                    break;
                }
                if worst > CONTRACTS * previous {
                    self.couple(x)?;
                }
                previous = worst;
                for place in 0..self.count() {
                    let moved = velocities || self.positions[place];
                    self.forces[place] = if moved {
                        self.off(place, velocities)
                    } else {
                        0.0
                    };
                }
                solve_sparse(&self.inner, &mut self.forces);
                let part = if velocities { n..2 * n } else { 0..n };
                for (force, along) in self.forces.iter().zip(self.directions.chunks_exact(n)) {
                    for (value, d) in x[part.clone()].iter_mut().zip(along) {
                        *value -= force * d;
                    }
                }
                self.evaluate(x);
            }
        }
        Ok(())
    }

    /// `M^-1 G'` of the rows last evaluated, one column after the other, into the directions, and the factors of `S`. Few rows of a
    /// mechanism share a body, so that both matrices are mostly zeros.
    fn couple(&mut self, x: &[f64]) -> Result<(), JointError> {
        let (n, count) = (self.n, self.count());
        self.model.mass_matrix(x, &mut self.mass);
        if factorize_sparse(&mut self.mass, n) <= 0.0 {
            return Err(JointError::NotClosed);
        }
        self.directions.copy_from_slice(&self.gradients);
        for column in self.directions.chunks_exact_mut(n) {
            solve_sparse(&self.mass, column);
        }
        for i in 0..count {
            for j in 0..=i {
                let gradient = &self.gradients[i * n..(i + 1) * n];
                let column = &self.directions[j * n..(j + 1) * n];
                self.inner[i * count + j] = dot(gradient, column);
            }
        }
        if factorize_sparse(&mut self.inner, count) > DEPENDENT {
            Ok(())
        } else {
            Err(JointError::Singular)
        }
    }

    /// The smallest pivot of `S` at `x`, to the largest entry: how far the rows are from depending on each other and from vanishing, about; 0
    /// where they do.
    pub(crate) fn least_pivot(&mut self, x: &[f64]) -> f64 {
        let (n, count) = (self.n, self.count());
        self.evaluate(x);
        if self.couple(x).is_err() {
            return 0.0;
        }
        let rows = self
            .gradients
            .chunks_exact(n)
            .zip(self.directions.chunks_exact(n));
        let largest = rows.fold(0.0_f64, |most, (row, along)| most.max(dot(row, along)));
        let pivots = (0..count).map(|i| self.inner[i * count + i]);
        pivots.fold(f64::INFINITY, f64::min) / largest
    }

    /// `g` or `w` of a row that is held.
    fn off(&self, place: usize, velocity: bool) -> f64 {
        if velocity {
            self.velocity(place)
        } else {
            self.position(place)
        }
    }

    /// Moves `v` onto `w = 0`, which is linear in it.
    pub(crate) fn project_velocities(&mut self, x: &mut [f64]) -> Result<(), JointError> {
        let n = self.n;
        self.evaluate(x);
        self.direct(x)?;
        for place in 0..self.count() {
            let step = self.velocity(place);
            let direction = &self.directions[place * n..(place + 1) * n];
            for (v, d) in x[n..2 * n].iter_mut().zip(direction) {
                *v -= step * d;
            }
        }
        Ok(())
    }
}

/// Forces of all equations of joints at the input vector `x = (q, v, u[, t])`, where contacts carry these normal and tangential
/// forces; the latter may be none where there is no friction. In units of the energy over those of the joints, in the order of the
/// equations: `M v' = f + sum of forces of contacts + G' lambda`. Of equations that follow from others the smallest forces are
/// given.
///
/// Not numbers where a force of a contact is none, or acts along a direction of its own, as one that holds coordinates and a switch
/// in `forces` do.
#[must_use]
pub fn joint_forces(
    model: &dyn Model,
    x: &[f64],
    contact_force: &[f64],
    friction_force: &[f64],
) -> Vec<f64> {
    let rows = joint_rows(model);
    let mut forces = vec![0.0; rows];
    let Some(mut joints) = Joints::of(model) else {
        return forces;
    };
    let x = &x[..model.declaration().inputs()];
    model.joint_forces(x, &mut forces);
    joints.evaluate(x);
    if joints.direct(x).is_err() {
        forces.fill(f64::NAN);
        return forces;
    }
    let pushed = generalized(model, x, contact_force, friction_force);
    for (place, &row) in joints.held.iter().enumerate() {
        let direction = &joints.directions[place * joints.n..(place + 1) * joints.n];
        forces[row] -= dot(direction, &pushed);
    }
    if joints.count() < rows {
        smallest(model, x, &mut forces);
    }
    forces
}

/// Generalized forces of all contacts.
fn generalized(model: &dyn Model, x: &[f64], normal: &[f64], tangential: &[f64]) -> Vec<f64> {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let mut sum = vec![0.0; n];
    let mut point = vec![0.0; contact_point::length(n)];
    let mut tangent = vec![0.0; tangent_point::length(n)];
    for (i, contact) in declaration.contacts.iter().enumerate() {
        let own = normal.get(i).copied().unwrap_or(0.0);
        let rubs = tangential.get(i).copied().unwrap_or(0.0);
        if own != 0.0 && !contact.dry {
            let declared = contact.custom_direction || !contact.held.is_empty();
            let own = if declared { f64::NAN } else { own };
            model.contact(i, x, &mut point);
            add(&mut sum, own, &point[contact_point::NORMAL..]);
        }
        if rubs != 0.0 && contact.friction.is_some() {
            // A switch acts along a direction of its own, and of friction in space the size is recorded.
            let in_space = contact
                .friction
                .is_some_and(|friction| friction.across.is_some());
            let rubs = if contact.switch.is_some() || in_space {
                f64::NAN
            } else {
                rubs
            };
            model.tangent(i, x, &mut tangent);
            add(&mut sum, rubs, &tangent[tangent_point::TANGENT..]);
        }
    }
    sum
}

fn add(sum: &mut [f64], factor: f64, vector: &[f64]) {
    for (sum, component) in sum.iter_mut().zip(vector) {
        *sum += factor * component;
    }
}

/// The smallest forces of all rows that act like these.
fn smallest(model: &dyn Model, x: &[f64], forces: &mut [f64]) {
    let rows = forces.len();
    let mut all = Joints::with_rows(model, (0..rows).collect());
    all.evaluate(x);
    let rows = nalgebra::DMatrix::from_row_slice(rows, all.n, &all.gradients);
    let acts = rows.transpose() * nalgebra::DVector::from_column_slice(forces);
    // Of G' lambda = Q that with the least square of lambda.
    let decomposed = rows.transpose().svd(true, true);
    let least = decomposed.solve(&acts, DEPENDENT.sqrt() * decomposed.singular_values.max());
    match least {
        Ok(least) => forces.copy_from_slice(least.as_slice()),
        Err(_) => forces.fill(f64::NAN),
    }
}

/// `L D L'` of a positive definite matrix, row-major, whose lower triangle is read and becomes `L` with `D` on its diagonal; what is zero
/// costs nothing. The smallest pivot as a share of its entry; 0 where one is not positive.
fn factorize_sparse(matrix: &mut [f64], n: usize) -> f64 {
    let diagonal: Vec<f64> = (0..n).map(|i| matrix[i * n + i]).collect();
    let mut least = f64::INFINITY;
    for j in 0..n {
        let pivot = matrix[j * n + j];
        if !(pivot > 0.0 && pivot.is_finite()) {
            return 0.0;
        }
        least = least.min(pivot / diagonal[j]);
        for i in j + 1..n {
            let entry = matrix[i * n + j];
            if entry == 0.0 {
                continue;
            }
            let factor = entry / pivot;
            for k in j + 1..=i {
                // Rows before this one are divided already.
                let other = if k < i {
                    matrix[k * n + j] * pivot
                } else {
                    entry
                };
                if other != 0.0 {
                    matrix[i * n + k] -= factor * other;
                }
            }
            matrix[i * n + j] = factor;
        }
    }
    least
}

/// Solves with the factors of [`factorize_sparse`].
fn solve_sparse(factors: &[f64], x: &mut [f64]) {
    let n = x.len();
    for j in 0..n {
        let known = x[j];
        if known != 0.0 {
            for i in j + 1..n {
                x[i] -= factors[i * n + j] * known;
            }
        }
    }
    for i in 0..n {
        x[i] /= factors[i * n + i];
    }
    for i in (0..n).rev() {
        let known = x[i];
        if known != 0.0 {
            for (value, factor) in x[..i].iter_mut().zip(&factors[i * n..]) {
                *value -= factor * known;
            }
        }
    }
}

/// Indices of rows of a positive semidefinite matrix, row-major, that are independent, increasing: of dependent ones those with
/// the largest pivots.
fn independent(matrix: &[f64], count: usize) -> Vec<usize> {
    let scale: Vec<f64> = (0..count)
        .map(|i| matrix[i * count + i].max(0.0).sqrt())
        .collect();
    let mut rest: Vec<f64> = (0..count * count)
        .map(|k| matrix[k] / (scale[k / count] * scale[k % count]))
        .collect();
    let mut chosen = Vec::with_capacity(count);
    for _ in 0..count {
        let free = (0..count).filter(|i| !chosen.contains(i));
        let Some(best) = free.max_by(|&a, &b| {
            rest[a * count + a]
                .total_cmp(&rest[b * count + b])
                .then(b.cmp(&a))
        }) else {
            break;
        };
        let pivot = rest[best * count + best];
        // A row without a gradient is not a number.
        if pivot.is_nan() || pivot <= DEPENDENT {
            if pivot.is_nan() {
                for k in 0..count {
                    rest[best * count + k] = -1.0;
                    rest[k * count + best] = 0.0;
                }
                rest[best * count + best] = f64::NEG_INFINITY;
                continue;
            }
            break;
        }
        chosen.push(best);
        let row: Vec<f64> = (0..count).map(|k| rest[best * count + k]).collect();
        for i in 0..count {
            let factor = row[i] / pivot;
            for k in 0..count {
                rest[i * count + k] -= factor * row[k];
            }
        }
    }
    chosen.sort_unstable();
    chosen
}

#[cfg(test)]
mod tests {
    use super::independent;

    #[test]
    fn rows_that_follow_from_others_are_left_out() {
        // Rows (1, 0), (0, 1), (1, 1), (0, 0) in a metric of 1.
        let rows = [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.0, 0.0]];
        let gram: Vec<f64> = rows
            .iter()
            .flat_map(|a| rows.iter().map(move |b| a[0] * b[0] + a[1] * b[1]))
            .collect();
        assert_eq!(independent(&gram, 4), [0, 1]);
        assert_eq!(independent(&[4.0, 2.0, 2.0, 9.0], 2), [0, 1]);
        assert_eq!(independent(&[], 0), [0_usize; 0]);
    }
}
