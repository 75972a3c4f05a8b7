//! The acceleration in a contact mode, and its derivatives.
//!
//! With the directions `C_j` of the forces `y_j` and the velocities `rho_i' v` that they hold,
//!
//! ```text
//! A = a + G + sum_j C_j y_j        rho_i' A + kappa_i = 0
//! ```
//!
//! where `G` is the given friction of contacts without a surface. Each column of the derivatives solves the same system:
//!
//! ```text
//! dA = w + C dy,   w = da + dG + sum_j dC_j y_j        rho' C dy = -(rho' w + drho' A + dkappa)
//! ```

use std::sync::Arc;

use super::tangent::{Layout, Matrix, add};
use crate::linalg::dense;
use crate::model::{
    Model, ParameterDerivatives, contact_point, friction_coefficients, tangent_point,
};
use crate::simulation::ContactMode;

/// What a force of a mode holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Hold {
    /// The normal velocity, along `d + slope e`; the slope is `-mu` forward.
    Normal { contact: usize, sense: f64 },
    /// The sliding velocity.
    Tangent { contact: usize },
}

/// Values and derivatives of one contact at a point.
struct Sides {
    point: Vec<f64>,
    point_by: Matrix,
    /// Empty without friction.
    tangent: Vec<f64>,
    tangent_by: Matrix,
}

/// Evaluates accelerations and their derivatives in one contact mode.
// Many fields: the memory of an evaluation.
pub(super) struct Acceleration<'a> {
    pub(super) model: &'a dyn Model,
    pub(super) derivatives: Arc<dyn ParameterDerivatives>,
    pub(super) layout: Layout,
    pub(super) n: usize,
    pub(super) columns: usize,
    friction: Vec<f64>,
    friction_by: Matrix,
    /// The forces of the mode.
    pub(super) holds: Vec<Hold>,
    /// Dry frictions that slide, with the factor of their given force.
    pub(super) given: Vec<(usize, f64)>,
    sides: Vec<Option<Sides>>,
    pub(super) free: Vec<f64>,
    /// The acceleration, and its derivatives by inputs and parameters.
    pub(super) value: Vec<f64>,
    pub(super) by: Matrix,
    /// The forces, and their derivatives.
    pub(super) forces: Vec<f64>,
    pub(super) forces_by: Matrix,
}

impl<'a> Acceleration<'a> {
    pub(super) fn new(
        model: &'a dyn Model,
        (derivatives, layout): (Arc<dyn ParameterDerivatives>, Layout),
    ) -> Self {
        let contacts = model.declaration().contacts.len();
        let mut friction_by = Matrix::zeros(contacts, layout.parameters);
        for i in 0..contacts {
            derivatives.friction(i, friction_by.row_mut(i));
        }
        let (n, columns) = (layout.n, layout.columns());
        Self {
            model,
            derivatives,
            layout,
            n,
            columns,
            friction: friction_coefficients(model),
            friction_by,
            holds: Vec::new(),
            given: Vec::new(),
            sides: (0..contacts).map(|_| None).collect(),
            free: vec![0.0; n],
            value: vec![0.0; n],
            by: Matrix::zeros(n, columns),
            forces: Vec::new(),
            forces_by: Matrix::default(),
        }
    }

    /// Coefficient of friction of a contact, and its derivatives by the parameters.
    pub(super) fn friction(&self, contact: usize) -> (f64, &[f64]) {
        (self.friction[contact], self.friction_by.row(contact))
    }

    fn is_dry(&self, contact: usize) -> bool {
        self.model.declaration().contacts[contact].dry
    }

    /// The forces of another mode from now on.
    pub(super) fn set_mode(&mut self, modes: &[ContactMode]) {
        self.holds.clear();
        self.given.clear();
        let mut tangents = Vec::new();
        for (contact, &mode) in modes.iter().enumerate() {
            let sense = match mode {
                ContactMode::Open => continue,
                ContactMode::Slip(direction) => -direction.sign(),
                ContactMode::Frictionless | ContactMode::Stick => 0.0,
            };
            match (self.is_dry(contact), sense == 0.0) {
                (true, false) => self.given.push((contact, sense)),
                (true, true) => {}
                (false, _) => self.holds.push(Hold::Normal { contact, sense }),
            }
            if mode == ContactMode::Stick {
                tangents.push(Hold::Tangent { contact });
            }
        }
        self.holds.extend(tangents);
    }

    /// Has the forces of another one from now on.
    pub(super) fn take_mode(&mut self, of: &Acceleration<'_>) {
        self.holds.clone_from(&of.holds);
        self.given.clone_from(&of.given);
    }

    /// Leaves out forces that hold what others hold already, at `x`: the motion is that of the others.
    pub(super) fn keep_independent(&mut self, x: &[f64]) {
        let all = std::mem::take(&mut self.holds);
        for hold in all {
            self.holds.push(hold);
            self.load(x);
            let mut matrix = self.coupling();
            let mut pivots = vec![0; self.holds.len()];
            if dense::factorize(&mut matrix.values, &mut pivots).is_err() {
                self.holds.pop();
            }
        }
    }

    /// Evaluates the contacts of the mode at `x`.
    pub(super) fn load(&mut self, x: &[f64]) {
        self.load_values(x, true);
    }

    fn load_values(&mut self, x: &[f64], derivatives: bool) {
        for slot in 0..self.holds.len() {
            match self.holds[slot] {
                Hold::Tangent { contact } if !self.is_dry(contact) => {}
                Hold::Normal { contact, .. } | Hold::Tangent { contact } => {
                    self.load_sides(contact, x, derivatives);
                }
            }
        }
        for slot in 0..self.given.len() {
            self.load_sides(self.given[slot].0, x, derivatives);
        }
    }

    /// Evaluates one contact at `x`.
    pub(super) fn load_contact(&mut self, contact: usize, x: &[f64]) {
        self.load_sides(contact, x, true);
    }

    fn load_sides(&mut self, contact: usize, x: &[f64], derivatives: bool) {
        let (n, columns) = (self.n, self.columns);
        let declared = &self.model.declaration().contacts[contact];
        let rough = declared.friction.is_some();
        let tangents = if rough { tangent_point::length(n) } else { 0 };
        let sides = self.sides[contact].get_or_insert_with(|| Sides {
            point: vec![0.0; contact_point::length(n)],
            point_by: Matrix::zeros(contact_point::length(n), columns),
            tangent: vec![0.0; tangents],
            tangent_by: Matrix::zeros(tangents, columns),
        });
        self.model.contact(contact, x, &mut sides.point);
        if rough {
            self.model.tangent(contact, x, &mut sides.tangent);
        }
        if derivatives {
            let known = &self.derivatives;
            known.contact(contact, x, &mut sides.point_by.values);
            if rough {
                known.tangent(contact, x, &mut sides.tangent_by.values);
            }
        }
    }

    /// A component of [`Model::contact`] where that was last evaluated, and its derivatives.
    pub(super) fn point(&self, contact: usize, component: usize) -> (f64, &[f64]) {
        match &self.sides[contact] {
            Some(sides) => (sides.point[component], sides.point_by.row(component)),
            None => (f64::NAN, &[]),
        }
    }

    /// A component of [`Model::tangent`] where that was last evaluated, and its derivatives.
    pub(super) fn tangent(&self, contact: usize, component: usize) -> (f64, &[f64]) {
        match &self.sides[contact] {
            Some(sides) => (sides.tangent[component], sides.tangent_by.row(component)),
            None => (f64::NAN, &[]),
        }
    }

    /// Component `k` of what a force holds, and its derivatives.
    pub(super) fn covector(&self, hold: Hold, k: usize) -> (f64, &[f64]) {
        match hold {
            Hold::Normal { contact, .. } => self.point(contact, contact_point::NORMAL + k),
            Hold::Tangent { contact } => self.tangent(contact, tangent_point::TANGENT + k),
        }
    }

    /// The velocity that a force holds, with its derivatives, where it was last evaluated.
    pub(super) fn velocity(&self, hold: Hold) -> (f64, &[f64]) {
        match hold {
            Hold::Normal { contact, .. } => self.point(contact, contact_point::NORMAL_VELOCITY),
            Hold::Tangent { contact } => self.tangent(contact, tangent_point::SLIDING_VELOCITY),
        }
    }

    /// The normal velocity of a contact at `x`, with its derivatives.
    pub(super) fn normal_velocity(&mut self, contact: usize, x: &[f64]) -> (f64, &[f64]) {
        self.load_contact(contact, x);
        self.point(contact, contact_point::NORMAL_VELOCITY)
    }

    /// What a force holds of a velocity.
    pub(super) fn held(&self, hold: Hold, velocity: &[f64]) -> f64 {
        let terms = velocity.iter().enumerate();
        terms.map(|(k, v)| self.covector(hold, k).0 * v).sum()
    }

    /// What no force changes of the rate of what a force holds, and its derivatives.
    fn curvature(&self, hold: Hold) -> (f64, &[f64]) {
        match hold {
            Hold::Normal { contact, .. } => self.point(contact, contact_point::CURVATURE),
            Hold::Tangent { contact } => self.tangent(contact, tangent_point::CURVATURE),
        }
    }

    /// Component `k` of the direction of a force.
    pub(super) fn direction(&self, hold: Hold, k: usize) -> f64 {
        let n = self.n;
        match hold {
            Hold::Normal { contact, sense } => {
                let (d, _) = self.point(contact, contact_point::direction(n) + k);
                if sense == 0.0 {
                    return d;
                }
                let (e, _) = self.tangent(contact, tangent_point::direction(n) + k);
                d + sense * self.friction[contact] * e
            }
            Hold::Tangent { contact } => self.tangent(contact, tangent_point::direction(n) + k).0,
        }
    }

    /// Adds `factor` times the derivatives of component `k` of the direction of a force.
    pub(super) fn add_direction(&self, hold: Hold, k: usize, factor: f64, to: &mut [f64]) {
        let n = self.n;
        match hold {
            Hold::Normal { contact, sense } => {
                add(
                    to,
                    factor,
                    self.point(contact, contact_point::direction(n) + k).1,
                );
                if sense != 0.0 {
                    self.add_rubbing(contact, k, factor * sense, to);
                }
            }
            Hold::Tangent { contact } => {
                add(
                    to,
                    factor,
                    self.tangent(contact, tangent_point::direction(n) + k).1,
                );
            }
        }
    }

    /// Adds `factor` times the derivatives of `mu e`, component `k`.
    fn add_rubbing(&self, contact: usize, k: usize, factor: f64, to: &mut [f64]) {
        let (e, e_by) = self.tangent(contact, tangent_point::direction(self.n) + k);
        let (mu, mu_by) = self.friction(contact);
        add(to, factor * mu, e_by);
        let parameters = self.columns - self.layout.parameters;
        add(&mut to[parameters..], factor * e, mu_by);
    }

    /// `rho' C`, with a row for each velocity that is held.
    pub(super) fn coupling(&self) -> Matrix {
        let order = self.holds.len();
        let mut matrix = Matrix::zeros(order, order);
        for (i, &held) in self.holds.iter().enumerate() {
            for (j, &force) in self.holds.iter().enumerate() {
                let products =
                    (0..self.n).map(|k| self.covector(held, k).0 * self.direction(force, k));
                matrix.values[i * order + j] = products.sum();
            }
        }
        matrix
    }

    /// Evaluates acceleration and forces at `x`, without derivatives; `false` if the forces are not determined.
    pub(super) fn evaluate_values(&mut self, x: &[f64]) -> bool {
        self.load_values(x, false);
        self.balance(x).is_some()
    }

    /// Evaluates acceleration and forces with all derivatives at `x`; `false` if the forces are not determined.
    pub(super) fn evaluate(&mut self, x: &[f64]) -> bool {
        self.load(x);
        let Some((matrix, pivots)) = self.balance(x) else {
            return false;
        };
        let mut by = std::mem::take(&mut self.by);
        let known = &self.derivatives;
        known.free_acceleration(x, &mut by.values);
        self.add_given_derivatives(&mut by);
        for (&force, y) in self.holds.iter().zip(&self.forces) {
            for k in 0..self.n {
                self.add_direction(force, k, *y, by.row_mut(k));
            }
        }
        let right = self.rates_of_holds(&by);
        let forces_by = solved(&matrix, &pivots, right);
        for (j, &force) in self.holds.iter().enumerate() {
            for k in 0..self.n {
                let component = self.direction(force, k);
                add(by.row_mut(k), component, forces_by.row(j));
            }
        }
        (self.by, self.forces_by) = (by, forces_by);
        true
    }

    /// Acceleration and forces where the contacts are loaded, and the factors of what balances them.
    fn balance(&mut self, x: &[f64]) -> Option<(Matrix, Vec<usize>)> {
        let n = self.n;
        self.model.free_acceleration(x, &mut self.free);
        for &(contact, sense) in &self.given {
            // The given normal acceleration is the negative of the curvature.
            let curvature = self.point(contact, contact_point::CURVATURE).0;
            let force = -sense * self.friction[contact] * curvature;
            let first = tangent_point::direction(n);
            let components = (0..n).map(|k| force * self.tangent(contact, first + k).0);
            let components: Vec<f64> = components.collect();
            add(&mut self.free, 1.0, &components);
        }
        let order = self.holds.len();
        let mut matrix = self.coupling();
        let mut pivots = vec![0; order];
        dense::factorize(&mut matrix.values, &mut pivots).ok()?;
        let right = self
            .holds
            .iter()
            .map(|&held| -(self.held(held, &self.free) + self.curvature(held).0));
        self.forces = right.collect();
        dense::solve(&matrix.values, &pivots, &mut self.forces);
        self.value.clone_from(&self.free);
        for (&force, y) in self.holds.iter().zip(&self.forces) {
            let components: Vec<f64> = (0..n).map(|k| self.direction(force, k)).collect();
            add(&mut self.value, *y, &components);
        }
        Some((matrix, pivots))
    }

    /// Adds the derivatives of the given friction of contacts without a surface.
    fn add_given_derivatives(&self, by: &mut Matrix) {
        for &(contact, sense) in &self.given {
            let (curvature, curvature_by) = self.point(contact, contact_point::CURVATURE);
            let mu = self.friction[contact];
            for k in 0..self.n {
                let (e, _) = self.tangent(contact, tangent_point::direction(self.n) + k);
                self.add_rubbing(contact, k, -sense * curvature, by.row_mut(k));
                add(by.row_mut(k), -sense * mu * e, curvature_by);
            }
        }
    }

    /// `-(rho' w + drho' A + dkappa)`, a row for each velocity that is held.
    fn rates_of_holds(&self, w: &Matrix) -> Matrix {
        let mut right = Matrix::zeros(self.holds.len(), self.columns);
        for (i, &held) in self.holds.iter().enumerate() {
            let row = right.row_mut(i);
            add(row, -1.0, self.curvature(held).1);
            for (k, &value) in self.value.iter().enumerate() {
                let (component, by) = self.covector(held, k);
                add(row, -component, w.row(k));
                add(row, -value, by);
            }
        }
        right
    }

    /// The force that holds the normal velocity of a contact, or its sliding velocity, with its derivatives.
    pub(super) fn force(&self, contact: usize, tangential: bool) -> Option<(f64, &[f64])> {
        let place = self.holds.iter().position(|&hold| match hold {
            Hold::Normal { contact: own, .. } => own == contact && !tangential,
            Hold::Tangent { contact: own } => own == contact && tangential,
        })?;
        Some((self.forces[place], self.forces_by.row(place)))
    }
}

/// Solves for all columns of `right`.
pub(super) fn solved(factors: &Matrix, pivots: &[usize], mut right: Matrix) -> Matrix {
    let order = pivots.len();
    let mut column = vec![0.0; order];
    for c in 0..right.columns {
        for (i, value) in column.iter_mut().enumerate() {
            *value = right.values[i * right.columns + c];
        }
        dense::solve(&factors.values, pivots, &mut column);
        for (i, value) in column.iter().enumerate() {
            right.values[i * right.columns + c] = *value;
        }
    }
    right
}

/// The input vector at a state.
pub(super) fn input(model: &dyn Model, (q, v, u): (&[f64], &[f64], &[f64]), time: f64) -> Vec<f64> {
    let mut x = [q, v, u].concat();
    if model.declaration().explicit_time {
        x.push(time);
    }
    x
}
