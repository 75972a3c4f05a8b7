//! The step form at a point, in numbers: what guesses are made of, and what is read off known motions.

use super::layout::{
    AHEAD, ALPHA, BEHIND, BETA, FALL, Layout, PER_CONTACT, PER_FRICTION, RISE, SLIP_MINUS,
    SLIP_PLUS,
};
use crate::model::{
    ImpactLaw, Model, Switching, contact_point, friction_coefficients, surfaces, tangent_point,
};

/// The step form of the time-freezing system of a scene, with the memory for one evaluation.
#[derive(Clone)]
pub(crate) struct Field<'a> {
    pub(crate) model: &'a dyn Model,
    /// Acceleration `a_bar` of the auxiliary dynamics.
    pub(crate) auxiliary_acceleration: f64,
    /// Where variables stand.
    pub(crate) layout: Layout,
    /// Coefficients of friction, 0 for contacts without friction.
    friction: Vec<f64>,
    /// Coefficients of restitution, 0 for contacts that do not bounce.
    restitution: Vec<f64>,
    acceleration: Vec<f64>,
    points: Vec<f64>,
    tangents: Vec<f64>,
}

impl<'a> Field<'a> {
    /// The step form.
    pub(crate) fn new(model: &'a dyn Model, auxiliary_acceleration: f64) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let count = declaration.contacts.len();
        let friction = friction_coefficients(model);
        let restitution = |i: usize| match declaration.contacts[i].law {
            ImpactLaw::Restitution => model.restitution(i),
            _ => 0.0,
        };
        let restitution: Vec<f64> = (0..count).map(restitution).collect();
        let bounces = |i: &usize| restitution[*i] > 0.0;
        let others = |i: usize| declaration.contacts[i].alternatives;
        let has_edge = |i: &usize| !others(*i).is_empty();
        let pairs = |i: usize| others(i).iter().map(move |&j| (i, j));
        let sets = |i: &usize| declaration.contacts[*i].switch == Some(Switching::Resets);
        Self {
            model,
            auxiliary_acceleration,
            layout: Layout {
                n,
                contacts: surfaces(model),
                controls: declaration.controls.len(),
                rough: (0..count).filter(|&i| friction[i] > 0.0).collect(),
                elastic: (0..count).filter(bounces).collect(),
                dipping: (0..count).filter(bounces).filter(has_edge).collect(),
                edges: (0..count).flat_map(pairs).collect(),
                conditions: (0..count).filter(sets).collect(),
            },
            friction,
            restitution,
            acceleration: vec![0.0; n],
            points: vec![0.0; count * contact_point::length(n)],
            tangents: vec![0.0; count * tangent_point::length(n)],
        }
    }

    /// Number of coordinates.
    pub(crate) fn coordinates(&self) -> usize {
        self.acceleration.len()
    }

    /// Number of contacts, dry friction among them.
    pub(crate) fn contacts(&self) -> usize {
        self.friction.len()
    }

    /// Coefficient of restitution, 0 for a contact that does not bounce.
    pub(crate) fn restitution(&self, contact: usize) -> f64 {
        self.restitution[contact]
    }

    /// Coefficient of friction, 0 for a contact without friction.
    pub(crate) fn friction(&self, contact: usize) -> f64 {
        self.friction[contact]
    }

    /// Whether the normal velocity of a contact reads more than velocities: its surface is curved or moves.
    pub(crate) fn turns(&self, contact: usize) -> bool {
        let velocities = self.coordinates()..2 * self.coordinates();
        let declared = &self.model.declaration().contacts[contact];
        let mut entries = declared.jacobian.entries.iter();
        entries.any(|&(row, input)| row == 1 && !velocities.contains(&(input as usize)))
    }

    /// Evaluates accelerations and contacts at the input vector `(q, v, u[, t])`.
    pub(crate) fn evaluate(&mut self, x: &[f64]) {
        let n = self.coordinates();
        self.model.free_acceleration(x, &mut self.acceleration);
        let points = self.points.chunks_exact_mut(contact_point::length(n));
        for (contact, point) in points.enumerate() {
            self.model.contact(contact, x, point);
        }
        let tangents = self.tangents.chunks_exact_mut(tangent_point::length(n));
        for (contact, tangent) in tangents.enumerate() {
            if self.friction[contact] > 0.0 {
                self.model.tangent(contact, x, tangent);
            }
        }
    }

    fn point(&self, contact: usize) -> &[f64] {
        let length = contact_point::length(self.coordinates());
        &self.points[contact * length..(contact + 1) * length]
    }

    fn tangent(&self, contact: usize) -> &[f64] {
        let length = tangent_point::length(self.coordinates());
        &self.tangents[contact * length..(contact + 1) * length]
    }

    /// Gap of the last evaluation.
    pub(crate) fn gap(&self, contact: usize) -> f64 {
        self.point(contact)[contact_point::GAP]
    }

    /// Normal velocity of the last evaluation.
    pub(crate) fn normal_velocity(&self, contact: usize) -> f64 {
        self.point(contact)[contact_point::NORMAL_VELOCITY]
    }

    /// Sliding velocity of the last evaluation, for a contact with friction.
    pub(crate) fn sliding_velocity(&self, contact: usize) -> f64 {
        self.tangent(contact)[tangent_point::SLIDING_VELOCITY]
    }

    /// Contact direction `d` of the last evaluation.
    pub(crate) fn direction(&self, contact: usize) -> &[f64] {
        let n = self.coordinates();
        &self.point(contact)[contact_point::direction(n)..][..n]
    }

    /// Input vector of the model from the local vector `xi`.
    pub(crate) fn input(&self, xi: &[f64]) -> Vec<f64> {
        let (n, states) = (self.layout.n, self.layout.states());
        let mut input = xi[..2 * n].to_vec();
        input.extend(&xi[states..states + self.layout.controls]);
        if self.model.declaration().explicit_time {
            input.push(xi[2 * n]);
        }
        input
    }

    /// Evaluates accelerations and contacts at `xi`.
    pub(crate) fn locate(&mut self, xi: &[f64]) {
        let input = self.input(xi);
        self.evaluate(&input);
    }

    /// The speed of the clock.
    fn speed(&self, xi: &[f64]) -> f64 {
        self.layout.theta().map_or(1.0, |place| xi[place])
    }

    /// Terms (place, factor) of the weight with which a contact presses, a factor by the coefficient of restitution.
    pub(crate) fn pressing(&self, contact: usize) -> Vec<(usize, f64)> {
        let e = self.restitution(contact);
        match self.layout.rebound(contact) {
            None => vec![(self.layout.algebraic(contact, BETA), 1.0)],
            Some(j) => vec![
                (self.layout.rebound_place(j, FALL), 1.0),
                (self.layout.rebound_place(j, RISE), e * e),
            ],
        }
    }

    /// Weight with which a contact presses, in units of `a_bar`. Dry friction presses at the speed of the clock: it
    /// belongs to the free dynamics. Nothing acts by a condition, whose weights are the shares themselves.
    fn pressure(&self, xi: &[f64], contact: usize) -> f64 {
        if self.layout.is_condition(contact) {
            return 1.0;
        }
        if self.layout.is_dry(contact) {
            let pressed = -self.point(contact)[contact_point::CURVATURE];
            return self.speed(xi) * pressed / self.auxiliary_acceleration;
        }
        let terms = self.pressing(contact).into_iter();
        terms.map(|(place, factor)| factor * xi[place]).sum()
    }

    /// Rates of `y = (q, v, t, G, D)` in numerical time at `xi`.
    pub(crate) fn rates(&mut self, xi: &[f64]) -> Vec<f64> {
        self.locate(xi);
        let (n, a_bar) = (self.layout.n, self.auxiliary_acceleration);
        let theta = self.speed(xi);
        let mut rates = vec![0.0; self.layout.states()];
        for k in 0..n {
            rates[k] = theta * xi[n + k];
            rates[n + k] = theta * self.acceleration[k];
        }
        rates[self.layout.time()] = theta;
        for contact in 0..self.layout.contacts {
            let weight = a_bar * self.pressure(xi, contact);
            for (rate, d) in rates[n..2 * n].iter_mut().zip(self.direction(contact)) {
                *rate += weight * d;
            }
            let beta = xi[self.layout.algebraic(contact, BETA)];
            let velocity = self.normal_velocity(contact);
            let falls = self.layout.moves_in_jumps(contact);
            let sinks = if falls { theta + beta } else { theta };
            rates[self.layout.lifted_gap(contact)] = sinks * velocity;
            if let Some(dip) = self.layout.dip(contact) {
                rates[dip] = beta * velocity;
            }
        }
        for (r, &contact) in self.layout.rough.iter().enumerate() {
            let part = |offset: usize| xi[self.layout.friction_place(r, offset)];
            let weight = a_bar * self.friction[contact] * (part(SLIP_MINUS) - part(SLIP_PLUS));
            let direction = &self.tangent(contact)[tangent_point::direction(n)..];
            for (rate, e) in rates[n..2 * n].iter_mut().zip(direction) {
                *rate += weight * e;
            }
        }
        rates
    }

    /// How far another piece of an edge is ahead of a contact.
    fn lead(&self, xi: &[f64], contact: usize, other: usize) -> f64 {
        xi[self.layout.lifted_gap(other)] - xi[self.layout.lifted_gap(contact)]
    }

    /// What the margin of a contact is before edges and dips count.
    fn own_margin(&self, xi: &[f64], contact: usize) -> f64 {
        let gap = xi[self.layout.lifted_gap(contact)];
        if self.layout.bounces(contact) {
            gap
        } else {
            gap.max(self.normal_velocity(contact))
        }
    }

    /// How far a contact is dipped into the ground, if it bounces at an edge.
    fn dip(&self, xi: &[f64], contact: usize) -> f64 {
        self.layout.dip(contact).map_or(0.0, |place| xi[place])
    }

    /// Sets all algebraic variables in `xi` from the shares of the groups: `alpha` of each contact, the part
    /// of its friction that opposes forward sliding, the part of its jump that falls.
    pub(crate) fn complete(&mut self, xi: &mut [f64], shares: &[f64]) {
        self.locate(xi);
        let parts = |value: f64| (value.max(0.0), (-value).max(0.0));
        let rebounds = self.layout.contacts + self.layout.rough.len();
        for contact in 0..self.layout.contacts {
            let mut margin = self.own_margin(xi, contact);
            for (k, other) in self.layout.edges_of(contact) {
                let (ahead, behind) = parts(self.lead(xi, contact, other) - margin);
                xi[self.layout.edge_place(k, AHEAD)] = ahead;
                xi[self.layout.edge_place(k, BEHIND)] = behind;
                margin += ahead;
            }
            let (plus, minus) = parts(margin + self.dip(xi, contact));
            let velocity = self.normal_velocity(contact);
            let bounces = self.layout.rebound(contact);
            let (p, w) = parts(match bounces {
                Some(_) => velocity,
                None => velocity - xi[self.layout.lifted_gap(contact)],
            });
            let alpha = shares[contact];
            let first = self.layout.algebraic(contact, ALPHA);
            let own = [alpha, 1.0 - alpha, plus, minus, p, w];
            xi[first..first + PER_CONTACT].copy_from_slice(&own);
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
            let (plus, minus) = parts(self.sliding_velocity(contact));
            let first = self.layout.friction_place(r, SLIP_PLUS);
            xi[first..first + PER_FRICTION].copy_from_slice(&[slip, pressure - slip, plus, minus]);
        }
    }

    /// Sets in `y` what conditions ask for at `xi` that have come true between two choices of shares.
    pub(crate) fn set(&self, xi: &[f64], before: &[f64], now: &[f64], y: &mut [f64]) {
        let (n, input) = (self.layout.n, self.input(xi));
        for &contact in &self.layout.conditions {
            let group = self.layout.slip_group(contact).unwrap_or(0);
            if before[group] > now[group] {
                self.model.reset(contact, &input, &mut y[n..2 * n]);
            }
        }
    }

    /// Shares of the groups as the signs at `xi` demand them; 0.5 where a weight is zero.
    pub(crate) fn shares(&mut self, xi: &[f64]) -> Vec<f64> {
        self.locate(xi);
        let step = |value: f64| if value > 0.0 { 1.0 } else { 0.0 };
        let margin = |contact: usize| {
            let others = self.layout.edges_of(contact);
            let largest = others.fold(self.own_margin(xi, contact), |margin, (_, other)| {
                margin.max(self.lead(xi, contact, other))
            });
            largest + self.dip(xi, contact)
        };
        let alphas: Vec<f64> = (0..self.layout.contacts).map(|i| step(margin(i))).collect();
        let where_closed = |contact: usize, share: f64| {
            let open = alphas.get(contact).is_some_and(|alpha| *alpha == 1.0);
            if open { 0.5 } else { share }
        };
        let rough = self.layout.rough.iter();
        let frictions = rough.map(|&i| where_closed(i, step(self.sliding_velocity(i))));
        let elastic = self.layout.elastic.iter();
        let rebounds = elastic.map(|&i| where_closed(i, step(-self.normal_velocity(i))));
        let others: Vec<f64> = frictions.chain(rebounds).collect();
        alphas.into_iter().chain(others).collect()
    }
}
