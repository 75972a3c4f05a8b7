//! The step form with its local rows.

use super::layout::{
    AHEAD, ALPHA, BEHIND, BETA, C_MINUS, C_PLUS, FALL, LAMBDA_MINUS, LAMBDA_PLUS, Layout, P,
    PER_CONTACT, PER_FRICTION, RISE, SLIP_MINUS, SLIP_PLUS, W,
};
use crate::time_freezing::TimeFreezingSystem;

/// The step form of a time-freezing system; evaluates local rows and their derivatives.
#[derive(Clone)]
pub(crate) struct HeavisideSystem<'a> {
    pub(crate) system: TimeFreezingSystem<'a>,
    /// Where variables and rows stand.
    pub(crate) layout: Layout,
    pub(super) input: Vec<f64>,
    pub(super) force_weights: Vec<f64>,
    /// Time at which the controls have their values, and their rates, empty where they are constant.
    pub(super) drive: (f64, Vec<f64>),
}

impl<'a> HeavisideSystem<'a> {
    pub(crate) fn new(system: TimeFreezingSystem<'a>) -> Self {
        let declaration = system.model.declaration();
        let contacts = 0..system.contacts();
        let has_edge = |i: &usize| !declaration.contacts[*i].alternatives.is_empty();
        let bounces = |i: &usize| system.restitution(*i) > 0.0;
        Self {
            layout: Layout {
                n: system.coordinates(),
                contacts: system.surfaces(),
                controls: declaration.controls.len(),
                rough: contacts
                    .clone()
                    .filter(|&i| system.friction(i) > 0.0)
                    .collect(),
                elastic: contacts.clone().filter(bounces).collect(),
                dipping: contacts.clone().filter(bounces).filter(has_edge).collect(),
                edges: contacts
                    .flat_map(|i| {
                        declaration.contacts[i]
                            .alternatives
                            .iter()
                            .map(move |&j| (i, j))
                    })
                    .collect(),
            },
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
    pub(super) fn write_input(&mut self, xi: &[f64]) {
        let (n, states) = (self.layout.n, self.layout.states());
        self.input[..2 * n].copy_from_slice(&xi[..2 * n]);
        self.input[2 * n..2 * n + self.layout.controls]
            .copy_from_slice(&xi[states..states + self.layout.controls]);
        let elapsed = xi[2 * n] - self.drive.0;
        for (control, slope) in self.input[2 * n..].iter_mut().zip(&self.drive.1) {
            *control += slope * elapsed;
        }
        if let Some(time) = self.input.get_mut(2 * n + self.layout.controls) {
            *time = xi[2 * n];
        }
    }

    /// Weight with which a contact presses, in units of `a_bar`. Dry friction presses at the speed of the clock: it
    /// belongs to the free dynamics.
    pub(crate) fn pressure(&self, xi: &[f64], contact: usize) -> f64 {
        if self.layout.is_dry(contact) {
            let theta = self.layout.theta().map_or(1.0, |place| xi[place]);
            return theta * self.system.pressed(contact) / self.system.auxiliary_acceleration;
        }
        let terms = self.pressing(contact).into_iter().flatten();
        terms.map(|(place, factor)| factor * xi[place]).sum()
    }

    /// Sum over the contacts of the auxiliary acceleration in direction `k`.
    fn auxiliary(&self, xi: &[f64], k: usize) -> f64 {
        let normal: f64 = (0..self.layout.contacts)
            .map(|contact| self.pressure(xi, contact) * self.system.auxiliary(contact, k))
            .sum();
        let tangential: f64 = self
            .layout
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
    pub(super) fn friction_share(&self, xi: &[f64], r: usize) -> f64 {
        xi[self.layout.friction_place(r, SLIP_MINUS)] - xi[self.layout.friction_place(r, SLIP_PLUS)]
    }

    /// Rates of the lifted gap and of the dip for a unit normal velocity.
    pub(super) fn gap_rates(&self, xi: &[f64], contact: usize) -> [f64; 2] {
        let theta = self.layout.theta().map_or(1.0, |place| xi[place]);
        let beta = xi[self.layout.algebraic(contact, BETA)];
        if self.layout.moves_in_jumps(contact) {
            [theta + beta, 0.0]
        } else {
            [theta, beta]
        }
    }

    /// How far a contact is dipped into the ground, if it bounces at an edge.
    fn dip(&self, xi: &[f64], contact: usize) -> f64 {
        self.layout.dip(contact).map_or(0.0, |place| xi[place])
    }

    /// Local rows at `xi`.
    pub(crate) fn rows(&mut self, xi: &[f64], rows: &mut [f64]) {
        self.write_input(xi);
        self.system.evaluate(&self.input);
        let n = self.layout.n;
        let theta = self.layout.theta().map_or(1.0, |place| xi[place]);
        for k in 0..n {
            rows[k] = theta * xi[n + k];
            rows[n + k] = theta * self.system.acceleration[k] + self.auxiliary(xi, k);
        }
        rows[self.layout.time()] = theta;
        for contact in 0..self.layout.contacts {
            let row = self.layout.contact_row(contact);
            let z = |offset: usize| xi[self.layout.algebraic(contact, offset)];
            let gap = xi[self.layout.lifted_gap(contact)];
            let velocity = self.system.normal_velocity(contact);
            for (place, rate) in self
                .layout
                .heights(contact)
                .zip(self.gap_rates(xi, contact))
            {
                rows[place] = rate * velocity;
            }
            rows[row] = z(ALPHA) + z(BETA) - 1.0;
            rows[row + 1] = z(P) - z(W) - velocity;
            rows[row + 2] = gap + self.dip(xi, contact) - z(LAMBDA_PLUS) + z(LAMBDA_MINUS);
            if self.layout.rebound(contact).is_none() {
                rows[row + 1] += gap;
                rows[row + 2] += z(P);
            }
            self.edge_rows(xi, contact, rows);
        }
        for (r, &contact) in self.layout.rough.iter().enumerate() {
            let row = self.layout.friction_row(r);
            let z = |offset: usize| xi[self.layout.friction_place(r, offset)];
            rows[row] = z(SLIP_PLUS) + z(SLIP_MINUS) - self.pressure(xi, contact);
            rows[row + 1] = self.system.sliding_velocity(contact) - z(C_PLUS) + z(C_MINUS);
        }
        for (j, &contact) in self.layout.elastic.iter().enumerate() {
            let z = |offset: usize| xi[self.layout.rebound_place(j, offset)];
            rows[self.layout.rebound_row(j)] =
                z(FALL) + z(RISE) - xi[self.layout.algebraic(contact, BETA)];
        }
        for count in 2..=self.layout.contacts {
            rows[self.layout.product_row(count)] = xi[self.layout.product(count)]
                - xi[self.layout.product(count - 1)] * xi[self.layout.algebraic(count - 1, ALPHA)];
        }
    }

    /// Rows of the comparisons of a contact with the other pieces of its edge, and what they add to its margin.
    fn edge_rows(&self, xi: &[f64], contact: usize, rows: &mut [f64]) {
        let row = self.layout.contact_row(contact);
        let mut margin = xi[self.layout.lifted_gap(contact)];
        if !self.layout.bounces(contact) {
            margin += xi[self.layout.algebraic(contact, P)];
        }
        for (k, other) in self.layout.edges_of(contact) {
            let z = |offset: usize| xi[self.layout.edge_place(k, offset)];
            let lead = self.lead(xi, contact, other);
            rows[self.layout.edge_row(k)] = z(AHEAD) - z(BEHIND) + margin - lead;
            rows[row + 2] += z(AHEAD);
            margin += z(AHEAD);
        }
    }

    /// How far another piece of an edge is ahead of a contact.
    fn lead(&self, xi: &[f64], contact: usize, other: usize) -> f64 {
        xi[self.layout.lifted_gap(other)] - xi[self.layout.lifted_gap(contact)]
    }

    /// Terms (place, factor) of the weight with which a contact presses.
    pub(super) fn pressing(&self, contact: usize) -> [Option<(usize, f64)>; 2] {
        match self.layout.rebound(contact) {
            None => [Some((self.layout.algebraic(contact, BETA), 1.0)), None],
            Some(j) => {
                let e = self.system.restitution(contact);
                [
                    Some((self.layout.rebound_place(j, FALL), 1.0)),
                    Some((self.layout.rebound_place(j, RISE), e * e)),
                ]
            }
        }
    }

    /// What contacts provide over the speed of the clock, by number, the normal accelerations first and then those along the sliding
    /// velocities: a unit, and terms (place, factor) of weights.
    pub(crate) fn provision(&self, number: usize) -> (f64, Vec<(usize, f64)>) {
        let contacts = self.system.contacts();
        let a_bar = self.system.auxiliary_acceleration;
        if number < self.layout.contacts {
            let terms = self.pressing(number).into_iter().flatten();
            return (a_bar, terms.collect());
        }
        let sliding = number.checked_sub(contacts);
        let friction = sliding.and_then(|i| self.layout.rough.iter().position(|&rough| rough == i));
        match (sliding, friction) {
            (Some(contact), Some(r)) => {
                let place = |offset: usize| self.layout.friction_place(r, offset);
                let terms = vec![(place(SLIP_MINUS), 1.0), (place(SLIP_PLUS), -1.0)];
                (a_bar * self.system.friction(contact), terms)
            }
            _ => (a_bar, Vec::new()),
        }
    }

    /// Sets all algebraic variables in `xi` from the shares of the groups: `alpha` of each contact, the part
    /// of its friction that opposes forward sliding, the part of its jump that falls. Leaves what
    /// [`rows`](Self::rows) evaluated at `xi`.
    pub(crate) fn complete(&mut self, xi: &mut [f64], shares: &[f64]) {
        let mut rows = vec![0.0; self.layout.states() + self.layout.algebraic_equations()];
        self.rows(xi, &mut rows);
        let parts = |value: f64| (value.max(0.0), (-value).max(0.0));
        let rebounds = self.layout.contacts + self.layout.rough.len();
        for contact in 0..self.layout.contacts {
            let velocity = self.system.normal_velocity(contact);
            let gap = xi[self.layout.lifted_gap(contact)];
            let bounces = self.layout.rebound(contact);
            let mut margin = if bounces.is_some() {
                gap
            } else {
                gap.max(velocity)
            };
            for (k, other) in self.layout.edges_of(contact) {
                let (ahead, behind) = parts(self.lead(xi, contact, other) - margin);
                xi[self.layout.edge_place(k, AHEAD)] = ahead;
                xi[self.layout.edge_place(k, BEHIND)] = behind;
                margin += ahead;
            }
            let (plus, minus) = parts(margin + self.dip(xi, contact));
            let (p, w) = parts(if bounces.is_some() {
                velocity
            } else {
                velocity - gap
            });
            let alpha = shares[contact];
            let first = self.layout.algebraic(contact, ALPHA);
            xi[first..first + PER_CONTACT].copy_from_slice(&[
                alpha,
                1.0 - alpha,
                plus,
                minus,
                p,
                w,
            ]);
            if let Some(j) = bounces {
                let fall = shares[rebounds + j] * (1.0 - alpha);
                xi[self.layout.rebound_place(j, FALL)] = fall;
                xi[self.layout.rebound_place(j, RISE)] = 1.0 - alpha - fall;
            }
        }
        for count in 2..=self.layout.contacts {
            xi[self.layout.product(count)] =
                xi[self.layout.product(count - 1)] * xi[self.layout.algebraic(count - 1, ALPHA)];
        }
        for r in 0..self.layout.rough.len() {
            let contact = self.layout.rough[r];
            let pressure = self.pressure(xi, contact);
            let slip = shares[self.layout.contacts + r] * pressure;
            let (plus, minus) = parts(self.system.sliding_velocity(contact));
            let first = self.layout.friction_place(r, SLIP_PLUS);
            xi[first..first + PER_FRICTION].copy_from_slice(&[slip, pressure - slip, plus, minus]);
        }
        self.rows(xi, &mut rows);
    }

    /// Shares of the groups as the signs at `xi` demand them; 0.5 where a weight is zero.
    pub(crate) fn shares(&mut self, xi: &[f64]) -> Vec<f64> {
        self.write_input(xi);
        self.system.evaluate(&self.input);
        let step = |value: f64| if value > 0.0 { 1.0 } else { 0.0 };
        let margin = |contact: usize| {
            let gap = xi[self.layout.lifted_gap(contact)];
            let own = if self.layout.bounces(contact) {
                gap
            } else {
                gap.max(self.system.normal_velocity(contact))
            };
            let others = self.layout.edges_of(contact);
            let largest = others.fold(own, |margin, (_, other)| {
                margin.max(self.lead(xi, contact, other))
            });
            largest + self.dip(xi, contact)
        };
        let alphas: Vec<f64> = (0..self.layout.contacts).map(|i| step(margin(i))).collect();
        let where_closed = |contact: usize, share: f64| {
            let open = alphas.get(contact).is_some_and(|alpha| *alpha == 1.0);
            if open { 0.5 } else { share }
        };
        let frictions = self
            .layout
            .rough
            .iter()
            .map(|&i| where_closed(i, step(self.system.sliding_velocity(i))));
        let rebounds = self
            .layout
            .elastic
            .iter()
            .map(|&i| where_closed(i, step(-self.system.normal_velocity(i))));
        let others: Vec<f64> = frictions.chain(rebounds).collect();
        alphas.into_iter().chain(others).collect()
    }
}
