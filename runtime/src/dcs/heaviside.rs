//! The lean Heaviside step form: one step function a contact.
//!
//! With `m_i = max(g_i, v_n,i)` and `alpha_i = H(m_i)` (1 free, 0 jump, between in sustained contact):
//!
//! ```text
//! (q, v, t)' = theta f_free + sum_i beta_i f_aux,i   theta = prod alpha_i,  beta_i = 1 - alpha_i
//! G_i' = theta v_n,i                              G_i = g_i(q) at the start
//! p_i - w_i + G_i - v_n,i = 0                     0 <= p_i _|_ w_i >= 0      (m_i = G_i + p_i)
//! G_i + p_i - lp_i + ln_i = 0                     0 <= ln_i _|_ alpha_i >= 0,  0 <= lp_i _|_ beta_i >= 0
//! ```
//!
//! The *lifted gap* `G_i` is a state of its own, so that it is linear in the states whatever the surface is.
//! The gap itself would be an invariant of contact that a Runge-Kutta scheme keeps on flat ground only:
//! with `v_n = 0` at the stages, `g` leaves zero there by the error of the scheme, with either sign, and
//! contact has one condition more than unknowns. `G` stays exactly zero, and differs from `g` by the error
//! that the scheme makes in all states.
//!
//! Products of more than two step functions are lifted, `P_k = P_{k-1} alpha_k`, so that every equation is
//! bilinear in them. Two contacts that jump at the same time receive impulses at the same rate until each
//! has stopped; this is Moreau's law where the contacts do not push each other apart (`D_12 <= 0`).
//!
//! The *local vector* of a stage is `xi = (q, v, t, G, u, z)`, with `z = (alpha, beta, lp, ln, p, w)` of each
//! contact and then the lifted products `P_2..P_nc`. The *local rows* are the right-hand side
//! `F = (q', v', t', G')` and then the algebraic equations: three a contact, one a lifted product.

use crate::time_freezing::TimeFreezingSystem;

/// Algebraic variables of one contact.
pub(crate) const PER_CONTACT: usize = 6;
/// Offsets of the algebraic variables of one contact.
pub(crate) const ALPHA: usize = 0;
pub(crate) const BETA: usize = 1;
pub(crate) const LAMBDA_PLUS: usize = 2;
pub(crate) const LAMBDA_MINUS: usize = 3;
pub(crate) const P: usize = 4;
pub(crate) const W: usize = 5;

/// The step form of a time-freezing system; evaluates local rows and their derivatives.
pub(crate) struct HeavisideSystem<'a> {
    pub(crate) system: TimeFreezingSystem<'a>,
    n: usize,
    contacts: usize,
    controls: usize,
    input: Vec<f64>,
    force_weights: Vec<f64>,
}

impl<'a> HeavisideSystem<'a> {
    pub(crate) fn new(system: TimeFreezingSystem<'a>) -> Self {
        let declaration = system.model.declaration();
        Self {
            n: system.coordinates(),
            contacts: system.contacts(),
            controls: declaration.controls.len(),
            input: vec![0.0; declaration.inputs()],
            force_weights: vec![0.0; system.coordinates()],
            system,
        }
    }

    /// Length of `y = (q, v, t, G)`.
    pub(crate) fn states(&self) -> usize {
        2 * self.n + 1 + self.contacts
    }

    /// Number of controls.
    pub(crate) fn controls(&self) -> usize {
        self.controls
    }

    /// Number of contacts.
    pub(crate) fn contacts(&self) -> usize {
        self.contacts
    }

    /// Length of `z`.
    pub(crate) fn algebraics(&self) -> usize {
        PER_CONTACT * self.contacts + self.contacts.saturating_sub(1)
    }

    /// Number of algebraic equations.
    pub(crate) fn algebraic_equations(&self) -> usize {
        3 * self.contacts + self.contacts.saturating_sub(1)
    }

    /// Length of the local vector `xi`.
    pub(crate) fn local_variables(&self) -> usize {
        self.states() + self.controls + self.algebraics()
    }

    /// Place in `xi` of algebraic variable `offset` of `contact`.
    pub(crate) fn algebraic(&self, contact: usize, offset: usize) -> usize {
        self.states() + self.controls + PER_CONTACT * contact + offset
    }

    /// Place in `xi` of the physical time.
    pub(crate) fn time(&self) -> usize {
        2 * self.n
    }

    /// Place in `xi` of the lifted gap of `contact`.
    pub(crate) fn lifted_gap(&self, contact: usize) -> usize {
        2 * self.n + 1 + contact
    }

    /// Place in `xi` of the product of the first `count >= 1` step functions.
    fn product(&self, count: usize) -> usize {
        if count == 1 {
            self.algebraic(0, ALPHA)
        } else {
            self.states() + self.controls + PER_CONTACT * self.contacts + count - 2
        }
    }

    /// Place in `xi` of `theta`, unless there is no contact and `theta = 1`.
    fn theta(&self) -> Option<usize> {
        (self.contacts > 0).then(|| self.product(self.contacts))
    }

    /// Sets the lifted products from the step functions in `xi`.
    pub(crate) fn set_products(&self, xi: &mut [f64]) {
        for count in 2..=self.contacts {
            xi[self.product(count)] =
                xi[self.product(count - 1)] * xi[self.algebraic(count - 1, ALPHA)];
        }
    }

    /// Input vector of the model from `xi`.
    fn write_input(&mut self, xi: &[f64]) {
        let (n, states) = (self.n, self.states());
        self.input[..2 * n].copy_from_slice(&xi[..2 * n]);
        self.input[2 * n..2 * n + self.controls]
            .copy_from_slice(&xi[states..states + self.controls]);
        if let Some(time) = self.input.get_mut(2 * n + self.controls) {
            *time = xi[2 * n];
        }
    }

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

    /// Local rows at `xi`.
    pub(crate) fn rows(&mut self, xi: &[f64], rows: &mut [f64]) {
        self.write_input(xi);
        self.system.evaluate(&self.input);
        let n = self.n;
        let theta = self.theta().map_or(1.0, |place| xi[place]);
        for k in 0..n {
            rows[k] = theta * xi[n + k];
            rows[n + k] = theta * self.system.acceleration[k];
            for contact in 0..self.contacts {
                rows[n + k] +=
                    xi[self.algebraic(contact, BETA)] * self.system.auxiliary(contact, k);
            }
        }
        rows[self.time()] = theta;
        for contact in 0..self.contacts {
            let row = self.states() + 3 * contact;
            let z = |offset: usize| xi[self.algebraic(contact, offset)];
            let (gap, velocity) = (
                xi[self.lifted_gap(contact)],
                self.system.normal_velocity(contact),
            );
            rows[self.lifted_gap(contact)] = theta * velocity;
            rows[row] = z(ALPHA) + z(BETA) - 1.0;
            rows[row + 1] = z(P) - z(W) + gap - velocity;
            rows[row + 2] = gap + z(P) - z(LAMBDA_PLUS) + z(LAMBDA_MINUS);
        }
        for count in 2..=self.contacts {
            rows[self.states() + 3 * self.contacts + count - 2] = xi[self.product(count)]
                - xi[self.product(count - 1)] * xi[self.algebraic(count - 1, ALPHA)];
        }
    }

    /// Entries (row, column, value) of the Jacobian of the local rows at `xi`, always in the same order.
    pub(crate) fn jacobian(&mut self, xi: &[f64], mut add: impl FnMut(usize, usize, f64)) {
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
            let beta = self.algebraic(contact, BETA);
            let row = self.states() + 3 * contact;
            let gap = self.lifted_gap(contact);
            for k in 0..n {
                add(n + k, beta, self.system.auxiliary(contact, k));
            }
            if let Some(place) = self.theta() {
                add(gap, place, self.system.normal_velocity(contact));
            }
            add(row + 1, gap, 1.0);
            add(row + 2, gap, 1.0);
            let a_bar = self.system.auxiliary_acceleration;
            for (entry, column, value) in self.system.contact_jacobian(contact) {
                let column = self.local_of_input(column);
                match entry {
                    0 => {}
                    1 => {
                        add(gap, column, theta * value);
                        add(row + 1, column, -value);
                    }
                    _ => add(n + entry - 2, column, xi[beta] * a_bar * value),
                }
            }
            add(row, self.algebraic(contact, ALPHA), 1.0);
            add(row, beta, 1.0);
            add(row + 1, self.algebraic(contact, P), 1.0);
            add(row + 1, self.algebraic(contact, W), -1.0);
            add(row + 2, self.algebraic(contact, P), 1.0);
            add(row + 2, self.algebraic(contact, LAMBDA_PLUS), -1.0);
            add(row + 2, self.algebraic(contact, LAMBDA_MINUS), 1.0);
        }
        for count in 2..=self.contacts {
            let row = self.states() + 3 * self.contacts + count - 2;
            let (before, alpha) = (self.product(count - 1), self.algebraic(count - 1, ALPHA));
            add(row, self.product(count), 1.0);
            add(row, before, -xi[alpha]);
            add(row, alpha, -xi[before]);
        }
    }

    /// Entries (one of (i, j) and (j, i) each) of the Hessian of `weights' rows` at `xi`, always in the
    /// same order. An entry with `i = j` is a diagonal one.
    pub(crate) fn hessian(
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
        for (&(i, j), &value) in declaration
            .free_hessian
            .entries
            .iter()
            .zip(&self.system.acceleration_hessian)
        {
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
        let a_bar = self.system.auxiliary_acceleration;
        for contact in 0..self.contacts {
            let beta = self.algebraic(contact, BETA);
            let row = self.states() + 3 * contact;
            let scale = xi[beta] * a_bar;
            self.system.evaluate_contact_hessian(
                contact,
                &self.input,
                theta * weights[self.lifted_gap(contact)] - weights[row + 1],
                weights[n..2 * n].iter().map(|weight| scale * weight),
            );
            let entries = declaration.contacts[contact].hessian.entries;
            for (&(i, j), &value) in entries.iter().zip(&self.system.contact_hessians[contact]) {
                add(
                    self.local_of_input(i as usize),
                    self.local_of_input(j as usize),
                    value,
                );
            }
            for (entry, column, value) in self.system.contact_jacobian(contact) {
                if entry == 1
                    && let Some(place) = self.theta()
                {
                    let weight = weights[self.lifted_gap(contact)];
                    add(place, self.local_of_input(column), weight * value);
                }
                if entry >= 2 {
                    add(
                        beta,
                        self.local_of_input(column),
                        a_bar * weights[n + entry - 2] * value,
                    );
                }
            }
        }
        for count in 2..=self.contacts {
            let row = self.states() + 3 * self.contacts + count - 2;
            add(
                self.product(count - 1),
                self.algebraic(count - 1, ALPHA),
                -weights[row],
            );
        }
    }
}
