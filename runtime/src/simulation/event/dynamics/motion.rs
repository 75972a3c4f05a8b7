//! The linear system of a contact mode: contact accelerations, the motion they give, projection.

use super::{Dynamics, dot};
use crate::model::{contact_point, tangent_point};
use crate::simulation::event::dop853::System;
use crate::simulation::event::small_system;

/// Newton steps of one projection; the second already meets rounding error after a step that passed
/// the error test.
const PROJECTIONS: usize = 6;

impl Dynamics<'_> {
    /// Whether the sliding velocity of a closed contact vanishes with those that the mode keeps zero, at the
    /// points last evaluated.
    pub(in crate::simulation) fn holds(&mut self, contact: usize) -> bool {
        let rows = self.active.len() + self.sticking.len();
        let order = rows + 1;
        let mut matrix = vec![0.0; order * order];
        for row in 0..order {
            for column in 0..order {
                let covector = if row < rows {
                    self.covector(row)
                } else {
                    self.tangent(contact)
                };
                let direction = if column < rows {
                    self.column(column, false)
                } else {
                    self.friction_direction(contact)
                };
                matrix[row * order + column] = dot(covector, direction);
            }
        }
        small_system::solve(&mut matrix, &mut vec![0.0; order]).is_none()
    }

    /// Row of the constraints that the mode keeps: the normals of active contacts, then the tangents of
    /// sticking ones.
    fn covector(&self, row: usize) -> &[f64] {
        match self.active.get(row) {
            Some(&i) => self.normal(i),
            None => self.tangent(self.sticking[row - self.active.len()]),
        }
    }

    /// Direction of the unknown of a row; with `slipping` that of a sliding contact is the direction of its
    /// whole force.
    fn column(&self, row: usize, slipping: bool) -> &[f64] {
        match self.active.get(row) {
            Some(&i) if slipping => &self.columns[i * self.n..(i + 1) * self.n],
            Some(&i) => self.direction(i),
            None => self.friction_direction(self.sticking[row - self.active.len()]),
        }
    }

    /// Solves for the unknowns of the first `rows` rows. Returns the sign of the determinant, `None` if they are
    /// dependent.
    fn solve_rows(&mut self, rows: usize, slipping: bool) -> Option<f64> {
        for row in 0..rows {
            for column in 0..rows {
                self.matrix[row * rows + column] =
                    dot(self.covector(row), self.column(column, slipping));
            }
        }
        small_system::solve(&mut self.matrix[..rows * rows], &mut self.right[..rows])
    }

    /// `to += sum_row column_row right_row` over the first rows.
    fn add_columns(&self, rows: usize, slipping: bool, to: &mut [f64]) {
        for (row, factor) in self.right[..rows].iter().enumerate() {
            for (to, d) in to.iter_mut().zip(self.column(row, slipping)) {
                *to += d * factor;
            }
        }
    }

    /// Moves the state onto `g = 0`, `v_n = 0` of the active contacts and `v_t = 0` of the sticking ones,
    /// along their directions `d` and `e`. `false` if it cannot.
    pub(in crate::simulation) fn project(&mut self, t: f64, y: &mut [f64]) -> bool {
        if self.active.is_empty() {
            return true;
        }
        let n = self.n;
        let normals = self.active.len();
        let mut previous = f64::INFINITY;
        for _ in 0..PROJECTIONS {
            self.load(t, y);
            // Largest gap in units of what rounding leaves of it.
            let mut worst = 0.0_f64;
            for slot in 0..normals {
                let i = self.active[slot];
                self.evaluate_contact(i);
                let gap = self.point(i)[contact_point::GAP];
                self.right[slot] = -gap;
                if gap.is_nan() {
                    return false;
                }
                let rounding = self.gap_rounding(i).max(f64::MIN_POSITIVE);
                worst = worst.max(gap.abs() / rounding);
            }
            if worst <= 1.0 || worst >= previous {
                break;
            }
            previous = worst;
            if self.solve_rows(normals, false).is_none() {
                return false;
            }
            self.add_columns(normals, false, &mut y[..n]);
        }
        for slot in 0..normals {
            self.right[slot] = -self.point(self.active[slot])[contact_point::NORMAL_VELOCITY];
        }
        if !self.sticking.is_empty() {
            self.load(t, y);
        }
        for slot in 0..self.sticking.len() {
            let i = self.sticking[slot];
            self.evaluate_tangent(i);
            self.right[normals + slot] = -self.sliding_velocity(i);
        }
        let rows = normals + self.sticking.len();
        if self.solve_rows(rows, false).is_none() {
            return false;
        }
        self.add_columns(rows, false, &mut y[n..2 * n]);
        self.load(t, y);
        true
    }

    /// Evaluates the active contacts, the right-hand sides of the rows of the mode, and the directions of the
    /// contact forces. Returns the number of rows.
    fn evaluate_rows(&mut self) -> usize {
        let n = self.n;
        let normals = self.active.len();
        for slot in 0..normals {
            let i = self.active[slot];
            self.evaluate_sides(i);
            self.right[slot] = -self.free_normal_acceleration(i).0;
            let column = i * n..(i + 1) * n;
            self.columns[column.clone()].copy_from_slice(
                &self.points[i * contact_point::length(n)..][contact_point::direction(n)..][..n],
            );
            let ratio = self.mode[i].force_ratio(self.friction[i]);
            if ratio != 0.0 {
                let e = &self.tangents[i * tangent_point::length(n)..]
                    [tangent_point::direction(n)..][..n];
                for (d, e) in self.columns[column].iter_mut().zip(e) {
                    *d += ratio * e;
                }
            }
        }
        for slot in 0..self.sticking.len() {
            self.right[normals + slot] = -self.free_sliding_acceleration(self.sticking[slot]).0;
        }
        normals + self.sticking.len()
    }

    /// Takes the contact accelerations over from the solution of the rows.
    fn store_forces(&mut self, rows: usize) {
        let normals = self.active.len();
        for slot in 0..normals {
            let i = self.active[slot];
            self.r[i] = self.right[slot];
            self.s[i] = self.mode[i].force_ratio(self.friction[i]) * self.right[slot];
        }
        for slot in normals..rows {
            self.s[self.sticking[slot - normals]] = self.right[slot];
        }
    }

    /// Size of the terms that the equation of a row balances.
    pub(super) fn row_scale(&self, row: usize, rows: usize) -> f64 {
        let (_, free) = match self.active.get(row) {
            Some(&i) => self.free_normal_acceleration(i),
            None => self.free_sliding_acceleration(self.sticking[row - self.active.len()]),
        };
        (0..rows)
            .filter(|&other| other != row)
            .fold(free, |sum, other| {
                let coupling = dot(self.covector(row), self.column(other, true));
                sum + (coupling * self.right[other]).abs()
            })
    }

    /// `dtau/dt = 1/p` of the time-freezing system with `a_bar`, `p = prod_i (1 - s_i p)`,
    /// `s_i = r_i / a_bar` over the active contacts: the weight of the free dynamics is `p`, those of
    /// the auxiliary dynamics `gamma_i = s_i p`.
    fn speed_of_numerical_time(&self) -> f64 {
        let shares = || self.active.iter().map(|&i| self.r[i]);
        let sum: f64 = shares().map(|r| r / self.auxiliary_acceleration).sum();
        if self.active.len() < 2 {
            return 1.0 + sum;
        }
        // The residual p - prod(1 - s p) increases with p and 1 / (1 + sum s) lies below its root.
        let mut p = 1.0 / (1.0 + sum);
        for _ in 0..20 {
            let (mut product, mut slope) = (1.0, 0.0);
            for r in shares() {
                let s = r / self.auxiliary_acceleration;
                slope = slope * (1.0 - s * p) - s * product;
                product *= 1.0 - s * p;
            }
            let step = (p - product) / (1.0 - slope);
            p -= step;
            if step.abs() <= 1e-15 {
                break;
            }
        }
        1.0 / p
    }
}

impl System for Dynamics<'_> {
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) {
        let n = self.n;
        self.load(t, y);
        self.evaluate_free_acceleration();
        dy[..n].copy_from_slice(&y[n..2 * n]);
        dy[n..2 * n].copy_from_slice(&self.acceleration);
        dy[2 * n] = 1.0;
        let rows = self.evaluate_rows();
        if rows > 0 {
            if let Some(sign) = self.solve_rows(rows, true) {
                self.orientation = sign;
                self.add_columns(rows, true, &mut dy[n..2 * n]);
            } else {
                self.right[..rows].fill(f64::NAN);
                dy[n..2 * n].fill(f64::NAN);
            }
            self.store_forces(rows);
            dy[2 * n] = self.speed_of_numerical_time();
        }
        self.evaluate_switches(rows);
        if let Some(function) = self.values.iter().position(|value| value.is_nan()) {
            self.undefined = Some(self.switch(function).contact());
        }
        for ((value, lowest), highest) in self
            .values
            .iter()
            .zip(&mut self.lowest)
            .zip(&mut self.highest)
        {
            *lowest = lowest.min(*value);
            *highest = highest.max(*value);
        }
    }
}
