//! Jacobian and Hessian of the local rows.

use super::HeavisideSystem;
use super::layout::{
    ALPHA, BETA, C_MINUS, C_PLUS, FALL, LAMBDA_MINUS, LAMBDA_PLUS, P, RISE, SLIP_MINUS, SLIP_PLUS,
    W,
};

/// Rate of the control at a place of `xi`, if there is one; the controls begin at `first`.
fn slope_of(drive: &[f64], first: usize, place: usize) -> Option<f64> {
    drive.get(place.checked_sub(first)?).copied()
}

impl HeavisideSystem<'_> {
    /// Place in `xi` of component `k` of the model's input vector.
    fn local_of_input(&self, k: usize) -> usize {
        let n = self.n;
        if k < 2 * n {
            k
        } else if k < 2 * n + self.controls {
            self.states() + k - 2 * n
        } else {
            2 * n
        }
    }

    /// Entries (row, column, value) of the Jacobian of the local rows at `xi`, always in the same order.
    pub(crate) fn jacobian(&mut self, xi: &[f64], mut add: impl FnMut(usize, usize, f64)) {
        if self.drive.1.is_empty() {
            self.undriven_jacobian(xi, add);
            return;
        }
        let (drive, time) = (self.drive.1.clone(), self.time());
        let first = self.states();
        self.undriven_jacobian(xi, |row, column, value| {
            add(row, column, value);
            if let Some(slope) = slope_of(&drive, first, column) {
                add(row, time, value * slope);
            }
        });
    }

    fn undriven_jacobian(&mut self, xi: &[f64], mut add: impl FnMut(usize, usize, f64)) {
        self.write_input(xi);
        self.system.evaluate(&self.input);
        self.system.evaluate_jacobians(&self.input);
        let n = self.n;
        let theta = self.theta().map_or(1.0, |place| xi[place]);
        for k in 0..n {
            add(k, n + k, theta);
            if let Some(place) = self.theta() {
                add(k, place, xi[n + k]);
                add(n + k, place, self.system.acceleration[k]);
            }
        }
        if let Some(place) = self.theta() {
            add(self.time(), place, 1.0);
        }
        let entries = self.system.model.declaration().free_jacobian.entries;
        for (&(row, column), value) in entries.iter().zip(&self.system.acceleration_jacobian) {
            add(
                n + row as usize,
                self.local_of_input(column as usize),
                theta * value,
            );
        }
        for contact in 0..self.contacts {
            self.contact_entries(xi, contact, &mut add);
        }
        for r in 0..self.rough.len() {
            self.friction_entries(xi, r, &mut add);
        }
        for (j, &contact) in self.elastic.iter().enumerate() {
            let row = self.rebound_row(j);
            add(row, self.rebound_place(j, FALL), 1.0);
            add(row, self.rebound_place(j, RISE), 1.0);
            add(row, self.algebraic(contact, BETA), -1.0);
        }
        for count in 2..=self.contacts {
            let row = self.product_row(count);
            let (before, alpha) = (self.product(count - 1), self.algebraic(count - 1, ALPHA));
            add(row, self.product(count), 1.0);
            add(row, before, -xi[alpha]);
            add(row, alpha, -xi[before]);
        }
    }

    fn contact_entries(&self, xi: &[f64], contact: usize, add: &mut impl FnMut(usize, usize, f64)) {
        let n = self.n;
        let beta = self.algebraic(contact, BETA);
        let row = self.contact_row(contact);
        let gap = self.lifted_gap(contact);
        let bounces = self.rebound(contact).is_some();
        for (place, factor) in self.pressing(contact).into_iter().flatten() {
            for k in 0..n {
                add(n + k, place, factor * self.system.auxiliary(contact, k));
            }
        }
        let velocity = self.system.normal_velocity(contact);
        if let Some(place) = self.theta() {
            add(gap, place, velocity);
        }
        if bounces {
            add(gap, beta, velocity);
        } else {
            add(row + 1, gap, 1.0);
        }
        add(row + 2, gap, 1.0);
        let push = self.pressure(xi, contact) * self.system.auxiliary_acceleration;
        let rate = self.gap_rate(xi, contact);
        for (entry, column, value) in self.system.contact_jacobian(contact) {
            let column = self.local_of_input(column);
            match entry {
                0 => {}
                1 => {
                    add(gap, column, rate * value);
                    add(row + 1, column, -value);
                }
                _ => add(n + entry - 2, column, push * value),
            }
        }
        add(row, self.algebraic(contact, ALPHA), 1.0);
        add(row, beta, 1.0);
        add(row + 1, self.algebraic(contact, P), 1.0);
        add(row + 1, self.algebraic(contact, W), -1.0);
        if !bounces {
            add(row + 2, self.algebraic(contact, P), 1.0);
        }
        add(row + 2, self.algebraic(contact, LAMBDA_PLUS), -1.0);
        add(row + 2, self.algebraic(contact, LAMBDA_MINUS), 1.0);
    }

    fn friction_entries(&self, xi: &[f64], r: usize, add: &mut impl FnMut(usize, usize, f64)) {
        let n = self.n;
        let contact = self.rough[r];
        let row = self.friction_row(r);
        let place = |offset: usize| self.friction_place(r, offset);
        for k in 0..n {
            let push = self.system.auxiliary_friction(contact, k);
            add(n + k, place(SLIP_PLUS), -push);
            add(n + k, place(SLIP_MINUS), push);
        }
        let share = self.friction_share(xi, r) * self.friction_unit(contact);
        for (entry, column, value) in self.system.tangent_jacobian(contact) {
            let column = self.local_of_input(column);
            if entry == 0 {
                add(row + 1, column, value);
            } else {
                add(n + entry - 1, column, share * value);
            }
        }
        add(row, place(SLIP_PLUS), 1.0);
        add(row, place(SLIP_MINUS), 1.0);
        for (pressing, factor) in self.pressing(contact).into_iter().flatten() {
            add(row, pressing, -factor);
        }
        add(row + 1, place(C_PLUS), -1.0);
        add(row + 1, place(C_MINUS), 1.0);
    }

    /// `a_bar mu` of a contact.
    fn friction_unit(&self, contact: usize) -> f64 {
        self.system.auxiliary_acceleration * self.system.friction(contact)
    }

    /// Entries (one of (i, j) and (j, i) each) of the Hessian of `weights' rows` at `xi`, always in the
    /// same order. An entry with `i = j` is a diagonal one.
    pub(crate) fn hessian(
        &mut self,
        xi: &[f64],
        weights: &[f64],
        mut add: impl FnMut(usize, usize, f64),
    ) {
        if self.drive.1.is_empty() {
            self.undriven_hessian(xi, weights, add);
            return;
        }
        let (drive, time) = (self.drive.1.clone(), self.time());
        let first = self.states();
        self.undriven_hessian(xi, weights, |i, j, value| {
            add(i, j, value);
            let (by_i, by_j) = (slope_of(&drive, first, i), slope_of(&drive, first, j));
            // An entry off the diagonal stands for two; where it moves onto the diagonal it is both.
            let mut moved = |a: usize, factor: f64| {
                let both = if a == time && i != j { 2.0 } else { 1.0 };
                add(a.max(time), a.min(time), both * factor * value);
            };
            if let Some(slope) = by_i {
                moved(j, slope);
            }
            if let Some(slope) = by_j.filter(|_| i != j) {
                moved(i, slope);
            }
            if let (Some(a), Some(b)) = (by_i, by_j) {
                moved(time, a * b);
            }
        });
    }

    fn undriven_hessian(
        &mut self,
        xi: &[f64],
        weights: &[f64],
        mut add: impl FnMut(usize, usize, f64),
    ) {
        self.write_input(xi);
        self.system.evaluate_jacobians(&self.input);
        let n = self.n;
        let theta = self.theta().map_or(1.0, |place| xi[place]);
        let declaration = self.system.model.declaration();
        for k in 0..n {
            self.force_weights[k] = theta * weights[n + k];
        }
        self.system
            .evaluate_acceleration_hessian(&self.input, &self.force_weights);
        let entries = declaration.free_hessian.entries;
        for (&(i, j), &value) in entries.iter().zip(&self.system.acceleration_hessian) {
            add(
                self.local_of_input(i as usize),
                self.local_of_input(j as usize),
                value,
            );
        }
        if let Some(place) = self.theta() {
            for (k, &weight) in weights[..n].iter().enumerate() {
                add(place, n + k, weight);
            }
            for (&(row, column), value) in declaration
                .free_jacobian
                .entries
                .iter()
                .zip(&self.system.acceleration_jacobian)
            {
                add(
                    place,
                    self.local_of_input(column as usize),
                    weights[n + row as usize] * value,
                );
            }
        }
        for contact in 0..self.contacts {
            self.contact_curvature(xi, weights, contact, &mut add);
        }
        for r in 0..self.rough.len() {
            self.friction_curvature(xi, weights, r, &mut add);
        }
        for count in 2..=self.contacts {
            add(
                self.product(count - 1),
                self.algebraic(count - 1, ALPHA),
                -weights[self.product_row(count)],
            );
        }
    }

    fn contact_curvature(
        &mut self,
        xi: &[f64],
        weights: &[f64],
        contact: usize,
        add: &mut impl FnMut(usize, usize, f64),
    ) {
        let n = self.n;
        let a_bar = self.system.auxiliary_acceleration;
        let row = self.contact_row(contact);
        let by_gap = weights[self.lifted_gap(contact)];
        let push = self.pressure(xi, contact) * a_bar;
        let by_velocity = self.gap_rate(xi, contact) * by_gap - weights[row + 1];
        self.system.evaluate_contact_hessian(
            contact,
            &self.input,
            by_velocity,
            weights[n..2 * n].iter().map(|weight| push * weight),
        );
        let entries = self.system.model.declaration().contacts[contact]
            .hessian
            .entries;
        for (&(i, j), &value) in entries.iter().zip(&self.system.contact_hessians[contact]) {
            add(
                self.local_of_input(i as usize),
                self.local_of_input(j as usize),
                value,
            );
        }
        let beta = self.rebound(contact).map(|_| self.algebraic(contact, BETA));
        for (entry, column, value) in self.system.contact_jacobian(contact) {
            let column = self.local_of_input(column);
            if entry == 1 {
                for place in self.theta().into_iter().chain(beta) {
                    add(place, column, by_gap * value);
                }
            }
            if entry >= 2 {
                for (place, factor) in self.pressing(contact).into_iter().flatten() {
                    let weight = factor * a_bar * weights[n + entry - 2];
                    add(place, column, weight * value);
                }
            }
        }
    }

    fn friction_curvature(
        &mut self,
        xi: &[f64],
        weights: &[f64],
        r: usize,
        add: &mut impl FnMut(usize, usize, f64),
    ) {
        let n = self.n;
        let contact = self.rough[r];
        let unit = self.friction_unit(contact);
        let share = self.friction_share(xi, r) * unit;
        let by_velocity = weights[self.friction_row(r) + 1];
        self.system.evaluate_tangent_hessian(
            contact,
            &self.input,
            by_velocity,
            weights[n..2 * n].iter().map(|weight| share * weight),
        );
        let friction = self.system.model.declaration().contacts[contact].friction;
        let entries = friction.map_or(&[][..], |friction| friction.hessian.entries);
        for (&(i, j), &value) in entries.iter().zip(&self.system.tangent_hessians[contact]) {
            add(
                self.local_of_input(i as usize),
                self.local_of_input(j as usize),
                value,
            );
        }
        for (entry, column, value) in self.system.tangent_jacobian(contact) {
            if entry > 0 {
                let column = self.local_of_input(column);
                let weight = unit * weights[n + entry - 1] * value;
                add(self.friction_place(r, SLIP_PLUS), column, -weight);
                add(self.friction_place(r, SLIP_MINUS), column, weight);
            }
        }
    }
}
