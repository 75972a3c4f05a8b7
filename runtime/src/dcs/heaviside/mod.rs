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
//! A contact with *friction* splits its weight `beta_i` by the sign of the sliding velocity:
//!
//! ```text
//! f_aux,i = (0, a_bar (beta_i d_i + (b-_i - b+_i) mu_i e_i), 0)    b+_i + b-_i = beta_i
//! v_t,i = c+_i - c-_i      0 <= c+_i _|_ c-_i >= 0     0 <= b+_i _|_ c-_i >= 0,  0 <= b-_i _|_ c+_i >= 0
//! ```
//!
//! The split is linear, and in flight, where `b+ = b- = 0`, the sliding velocity may change its sign without
//! a switch: a step function of `v_t` times `beta` would have neither property. A contact with *restitution*
//! has the step function of `m_i = G_i` and splits its weight by the sign of the normal velocity, into a fall
//! at the rate `a_bar` and a rise at `e^2 a_bar`, which press and rub with `f_i + e_i^2 r_i` instead of `beta_i`:
//!
//! ```text
//! G_i' = (theta + beta_i) v_n,i     f_i + r_i = beta_i    v_n,i = p_i - w_i
//! 0 <= f_i _|_ p_i >= 0,  0 <= r_i _|_ w_i >= 0
//! ```
//!
//! The *local vector* of a stage is `xi = (q, v, t, G, u, z)`, with `z = (alpha, beta, lp, ln, p, w)` of each
//! contact, `(b+, b-, c+, c-)` of each with friction, `(f, r)` of each with restitution and then the lifted
//! products `P_2..P_nc`. The *local rows* are the right-hand side `F = (q', v', t', G')` and then the
//! algebraic equations: three a contact, two a friction, one a restitution and one a lifted product.

mod derivatives;
mod layout;

pub(crate) use layout::{ALPHA, Group, LAMBDA_PLUS, P, W};

use crate::time_freezing::TimeFreezingSystem;
use layout::{BETA, C_MINUS, C_PLUS, FALL, LAMBDA_MINUS, RISE, SLIP_MINUS, SLIP_PLUS};

/// The step form of a time-freezing system; evaluates local rows and their derivatives.
#[derive(Clone)]
pub(crate) struct HeavisideSystem<'a> {
    pub(crate) system: TimeFreezingSystem<'a>,
    n: usize,
    contacts: usize,
    controls: usize,
    /// Contacts with friction.
    rough: Vec<usize>,
    /// Contacts with restitution.
    elastic: Vec<usize>,
    input: Vec<f64>,
    force_weights: Vec<f64>,
    /// Time at which the controls have their values, and their rates, empty where they are constant.
    drive: (f64, Vec<f64>),
}

impl<'a> HeavisideSystem<'a> {
    pub(crate) fn new(system: TimeFreezingSystem<'a>) -> Self {
        let declaration = system.model.declaration();
        let contacts = 0..system.contacts();
        Self {
            n: system.coordinates(),
            contacts: system.contacts(),
            controls: declaration.controls.len(),
            rough: contacts
                .clone()
                .filter(|&i| system.friction(i) > 0.0)
                .collect(),
            elastic: contacts.filter(|&i| system.restitution(i) > 0.0).collect(),
            input: vec![0.0; declaration.inputs()],
            force_weights: vec![0.0; system.coordinates()],
            drive: (0.0, Vec::new()),
            system,
        }
    }

    /// The system under controls that change at given rates of physical time: those in `xi` hold at `time`.
    pub(crate) fn driven(mut self, time: f64, slopes: &[f64]) -> Self {
        self.drive = (time, slopes.to_vec());
        self
    }

    /// Input vector of the model from `xi`.
    fn write_input(&mut self, xi: &[f64]) {
        let (n, states) = (self.n, self.states());
        self.input[..2 * n].copy_from_slice(&xi[..2 * n]);
        self.input[2 * n..2 * n + self.controls]
            .copy_from_slice(&xi[states..states + self.controls]);
        let elapsed = xi[2 * n] - self.drive.0;
        for (control, slope) in self.input[2 * n..].iter_mut().zip(&self.drive.1) {
            *control += slope * elapsed;
        }
        if let Some(time) = self.input.get_mut(2 * n + self.controls) {
            *time = xi[2 * n];
        }
    }

    /// Weight with which a contact presses, in units of `a_bar`.
    pub(crate) fn pressure(&self, xi: &[f64], contact: usize) -> f64 {
        let terms = self.pressing(contact).into_iter().flatten();
        terms.map(|(place, factor)| factor * xi[place]).sum()
    }

    /// Sum over the contacts of the auxiliary acceleration in direction `k`.
    fn auxiliary(&self, xi: &[f64], k: usize) -> f64 {
        let normal: f64 = (0..self.contacts)
            .map(|contact| self.pressure(xi, contact) * self.system.auxiliary(contact, k))
            .sum();
        let tangential: f64 = self
            .rough
            .iter()
            .enumerate()
            .map(|(r, &contact)| {
                self.friction_share(xi, r) * self.system.auxiliary_friction(contact, k)
            })
            .sum();
        normal + tangential
    }

    /// Friction `b- - b+` of friction `r`, in units of its bound for `beta = 1`.
    fn friction_share(&self, xi: &[f64], r: usize) -> f64 {
        xi[self.friction_place(r, SLIP_MINUS)] - xi[self.friction_place(r, SLIP_PLUS)]
    }

    /// Rate of the lifted gap for a unit normal velocity.
    fn gap_rate(&self, xi: &[f64], contact: usize) -> f64 {
        let theta = self.theta().map_or(1.0, |place| xi[place]);
        if self.rebound(contact).is_some() {
            theta + xi[self.algebraic(contact, BETA)]
        } else {
            theta
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
            rows[n + k] = theta * self.system.acceleration[k] + self.auxiliary(xi, k);
        }
        rows[self.time()] = theta;
        for contact in 0..self.contacts {
            let row = self.contact_row(contact);
            let z = |offset: usize| xi[self.algebraic(contact, offset)];
            let (gap, velocity) = (
                xi[self.lifted_gap(contact)],
                self.system.normal_velocity(contact),
            );
            rows[self.lifted_gap(contact)] = self.gap_rate(xi, contact) * velocity;
            rows[row] = z(ALPHA) + z(BETA) - 1.0;
            rows[row + 1] = z(P) - z(W) - velocity;
            rows[row + 2] = gap - z(LAMBDA_PLUS) + z(LAMBDA_MINUS);
            if self.rebound(contact).is_none() {
                rows[row + 1] += gap;
                rows[row + 2] += z(P);
            }
        }
        for (r, &contact) in self.rough.iter().enumerate() {
            let row = self.friction_row(r);
            let z = |offset: usize| xi[self.friction_place(r, offset)];
            rows[row] = z(SLIP_PLUS) + z(SLIP_MINUS) - self.pressure(xi, contact);
            rows[row + 1] = self.system.sliding_velocity(contact) - z(C_PLUS) + z(C_MINUS);
        }
        for (j, &contact) in self.elastic.iter().enumerate() {
            let z = |offset: usize| xi[self.rebound_place(j, offset)];
            rows[self.rebound_row(j)] = z(FALL) + z(RISE) - xi[self.algebraic(contact, BETA)];
        }
        for count in 2..=self.contacts {
            rows[self.product_row(count)] = xi[self.product(count)]
                - xi[self.product(count - 1)] * xi[self.algebraic(count - 1, ALPHA)];
        }
    }
}
