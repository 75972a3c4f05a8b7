//! Fields and switching functions of the time-freezing system at a point, with derivatives.

use crate::model::{
    FrictionDeclaration, ImpactLaw, Model, contact_point, friction_coefficients, surfaces,
    tangent_point,
};

/// The time-freezing system of a scene, with the memory for one evaluation.
#[derive(Clone)]
pub(crate) struct TimeFreezingSystem<'a> {
    pub(crate) model: &'a dyn Model,
    /// Acceleration `a_bar` of the auxiliary dynamics.
    pub(crate) auxiliary_acceleration: f64,
    /// Free acceleration `a`, length `n_q`.
    pub(crate) acceleration: Vec<f64>,
    /// Values of the Jacobian of `a`, in the order of the declaration.
    pub(crate) acceleration_jacobian: Vec<f64>,
    /// Values of the Hessian of a weighted `a`.
    pub(crate) acceleration_hessian: Vec<f64>,
    points: Vec<f64>,
    contact_jacobians: Vec<Vec<f64>>,
    /// Values of the Hessian of the weighted rows of each contact.
    pub(crate) contact_hessians: Vec<Vec<f64>>,
    /// Coefficients of friction, 0 for contacts without friction.
    friction: Vec<f64>,
    /// Coefficients of restitution, 0 for contacts that do not bounce.
    restitution: Vec<f64>,
    tangents: Vec<f64>,
    tangent_jacobians: Vec<Vec<f64>>,
    /// Values of the Hessian of the weighted tangential rows of each contact.
    pub(crate) tangent_hessians: Vec<Vec<f64>>,
    weights: Vec<f64>,
}

impl<'a> TimeFreezingSystem<'a> {
    pub(crate) fn new(model: &'a dyn Model, auxiliary_acceleration: f64) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let contacts = declaration.contacts;
        let restitution = |i: usize| match contacts[i].law {
            ImpactLaw::Inelastic => 0.0,
            ImpactLaw::Restitution => model.restitution(i),
        };
        let tangential = |pattern: fn(&FrictionDeclaration) -> usize| {
            let sides = contacts.iter().map(|contact| contact.friction.as_ref());
            sides
                .map(|side| vec![0.0; side.map_or(0, pattern)])
                .collect()
        };
        Self {
            model,
            auxiliary_acceleration,
            acceleration: vec![0.0; n],
            acceleration_jacobian: vec![0.0; declaration.free_jacobian.entries.len()],
            acceleration_hessian: vec![0.0; declaration.free_hessian.entries.len()],
            points: vec![0.0; contacts.len() * contact_point::length(n)],
            contact_jacobians: contacts
                .iter()
                .map(|contact| vec![0.0; contact.jacobian.entries.len()])
                .collect(),
            contact_hessians: contacts
                .iter()
                .map(|contact| vec![0.0; contact.hessian.entries.len()])
                .collect(),
            friction: friction_coefficients(model),
            restitution: (0..contacts.len()).map(restitution).collect(),
            tangents: vec![0.0; contacts.len() * tangent_point::length(n)],
            tangent_jacobians: tangential(|side| side.jacobian.entries.len()),
            tangent_hessians: tangential(|side| side.hessian.entries.len()),
            weights: vec![0.0; 2 + n],
        }
    }

    /// This system, in which the contacts in `resting` do not bounce.
    pub(crate) fn without_bounces(mut self, resting: &[usize]) -> Self {
        for &i in resting {
            self.restitution[i] = 0.0;
        }
        self
    }

    /// Coefficient of friction, 0 for a contact without friction.
    pub(crate) fn friction(&self, contact: usize) -> f64 {
        self.friction[contact]
    }

    /// Coefficient of restitution, 0 for a contact that does not bounce.
    pub(crate) fn restitution(&self, contact: usize) -> f64 {
        self.restitution[contact]
    }

    /// Number of coordinates.
    pub(crate) fn coordinates(&self) -> usize {
        self.acceleration.len()
    }

    /// Number of contacts, dry friction among them.
    pub(crate) fn contacts(&self) -> usize {
        self.contact_jacobians.len()
    }

    /// Number of contacts that are surfaces; the others, behind them, are dry friction.
    pub(crate) fn surfaces(&self) -> usize {
        surfaces(self.model)
    }

    /// The given normal acceleration of a dry friction at the last evaluation.
    pub(crate) fn pressed(&self, contact: usize) -> f64 {
        -self.point(contact)[contact_point::CURVATURE]
    }

    fn point(&self, contact: usize) -> &[f64] {
        let length = contact_point::length(self.coordinates());
        &self.points[contact * length..(contact + 1) * length]
    }

    /// Gap of the last evaluation.
    pub(crate) fn gap(&self, contact: usize) -> f64 {
        self.point(contact)[contact_point::GAP]
    }

    /// Normal velocity of the last evaluation.
    pub(crate) fn normal_velocity(&self, contact: usize) -> f64 {
        self.point(contact)[contact_point::NORMAL_VELOCITY]
    }

    /// Auxiliary acceleration `a_bar d_i` in direction `k` at the last evaluation.
    pub(crate) fn auxiliary(&self, contact: usize, k: usize) -> f64 {
        self.auxiliary_acceleration
            * self.point(contact)[contact_point::direction(self.coordinates()) + k]
    }

    /// Whether the normal velocity of a contact reads more than velocities: its surface is curved or moves.
    pub(crate) fn turns(&self, contact: usize) -> bool {
        let velocities = self.coordinates()..2 * self.coordinates();
        let declared = &self.model.declaration().contacts[contact];
        let mut entries = declared.jacobian.entries.iter();
        entries.any(|&(row, input)| row == 1 && !velocities.contains(&(input as usize)))
    }

    fn tangent(&self, contact: usize) -> &[f64] {
        let length = tangent_point::length(self.coordinates());
        &self.tangents[contact * length..(contact + 1) * length]
    }

    /// Sliding velocity of the last evaluation, for a contact with friction.
    pub(crate) fn sliding_velocity(&self, contact: usize) -> f64 {
        self.tangent(contact)[tangent_point::SLIDING_VELOCITY]
    }

    /// Auxiliary friction `a_bar mu_i e_i` in direction `k` at the last evaluation.
    pub(crate) fn auxiliary_friction(&self, contact: usize, k: usize) -> f64 {
        self.auxiliary_acceleration
            * self.friction[contact]
            * self.tangent(contact)[tangent_point::direction(self.coordinates()) + k]
    }

    /// Entries (row, column, value) of the Jacobian of `(v_t, e)` of one contact with friction.
    pub(crate) fn tangent_jacobian(
        &self,
        contact: usize,
    ) -> impl Iterator<Item = (usize, usize, f64)> {
        let declaration = &self.model.declaration().contacts[contact];
        let entries = declaration.friction.map_or(&[][..], |f| f.jacobian.entries);
        entries
            .iter()
            .zip(&self.tangent_jacobians[contact])
            .map(|(&(row, column), &value)| (row as usize, column as usize, value))
    }

    /// Entries (row, column, value) of the Jacobian of `(g, v_n, d)` of one contact.
    pub(crate) fn contact_jacobian(
        &self,
        contact: usize,
    ) -> impl Iterator<Item = (usize, usize, f64)> {
        let entries = self.model.declaration().contacts[contact].jacobian.entries;
        entries
            .iter()
            .zip(&self.contact_jacobians[contact])
            .map(|(&(row, column), &value)| (row as usize, column as usize, value))
    }

    /// Evaluates fields and switching functions at the input vector `x = (q, v, u[, t])`.
    pub(crate) fn evaluate(&mut self, x: &[f64]) {
        let length = contact_point::length(self.coordinates());
        self.model.free_acceleration(x, &mut self.acceleration);
        for (contact, point) in self.points.chunks_exact_mut(length).enumerate() {
            self.model.contact(contact, x, point);
        }
        let length = tangent_point::length(self.coordinates());
        for (contact, tangent) in self.tangents.chunks_exact_mut(length).enumerate() {
            if self.friction[contact] > 0.0 {
                self.model.tangent(contact, x, tangent);
            }
        }
    }

    /// Evaluates the first derivatives at `x`.
    pub(crate) fn evaluate_jacobians(&mut self, x: &[f64]) {
        self.model.free_jacobian(x, &mut self.acceleration_jacobian);
        for (contact, values) in self.contact_jacobians.iter_mut().enumerate() {
            self.model.contact_jacobian(contact, x, values);
        }
        for (contact, values) in self.tangent_jacobians.iter_mut().enumerate() {
            if self.friction[contact] > 0.0 {
                self.model.tangent_jacobian(contact, x, values);
            }
        }
    }

    /// Hessian values of `weights' a` at `x`.
    pub(crate) fn evaluate_acceleration_hessian(&mut self, x: &[f64], weights: &[f64]) {
        self.model
            .free_hessian(x, weights, &mut self.acceleration_hessian);
    }

    /// Hessian values of `gap g + velocity v_n + direction' d` of one contact at `x`.
    pub(crate) fn evaluate_contact_hessian(
        &mut self,
        contact: usize,
        x: &[f64],
        [gap, velocity]: [f64; 2],
        direction: impl Iterator<Item = f64>,
    ) {
        self.weights[..2].copy_from_slice(&[gap, velocity]);
        for (weight, value) in self.weights[2..].iter_mut().zip(direction) {
            *weight = value;
        }
        self.model.contact_hessian(
            contact,
            x,
            &self.weights,
            &mut self.contact_hessians[contact],
        );
    }

    /// Hessian values of `velocity v_t + direction' e` of one contact with friction at `x`.
    pub(crate) fn evaluate_tangent_hessian(
        &mut self,
        contact: usize,
        x: &[f64],
        velocity: f64,
        direction: impl Iterator<Item = f64>,
    ) {
        let length = 1 + self.acceleration.len();
        let weights = &mut self.weights[..length];
        weights[0] = velocity;
        for (weight, value) in weights[1..].iter_mut().zip(direction) {
            *weight = value;
        }
        let values = &mut self.tangent_hessians[contact];
        self.model.tangent_hessian(contact, x, weights, values);
    }
}
