//! The acceleration in a contact mode, and its derivatives.
//!
//! With the directions `C_j` of the forces `y_j` of the lines that the mode holds ([`Line`]) and the velocities `rho_i' v` along these,
//!
//! ```text
//! A = a + sum_j C_j y_j        rho_i' A + kappa_i = 0
//! ```
//!
//! where the line of a dry friction gives its bound. Each column of the derivatives solves the same system:
//!
//! ```text
//! dA = w + C dy,   w = da + sum_j dC_j y_j        rho' C dy = -(rho' w + drho' A + dkappa)
//! ```

use std::ops::Deref;
use std::sync::Arc;

use super::tangent::{Factors, Layout, Matrix, add};
use crate::contact::{Line, View};
use crate::model::{Model, ParameterDerivatives, contact_point, tangent_point};
use crate::simulation::ContactMode;

/// Evaluates accelerations and their derivatives in one contact mode.
pub(super) struct Acceleration<'a> {
    view: View<'a>,
    pub(super) derivatives: Arc<ParameterDerivatives>,
    pub(super) layout: Layout,
    pub(super) columns: usize,
    friction_by: Matrix,
    /// What the forces of the mode hold: normals, and then tangents.
    pub(super) lines: Vec<Line>,
    /// Derivatives of each contact, and of its tangential side; without rows where there is no friction.
    sides: Vec<Option<[Matrix; 2]>>,
    /// The acceleration, and its derivatives by inputs and parameters.
    pub(super) value: Vec<f64>,
    pub(super) by: Matrix,
    /// The forces, and their derivatives.
    pub(super) forces: Vec<f64>,
    pub(super) forces_by: Matrix,
}

impl<'a> Deref for Acceleration<'a> {
    type Target = View<'a>;

    fn deref(&self) -> &View<'a> {
        &self.view
    }
}

impl<'a> Acceleration<'a> {
    pub(super) fn new(
        model: &'a dyn Model,
        (derivatives, layout): (Arc<ParameterDerivatives>, Layout),
    ) -> Self {
        let contacts = model.declaration().contacts.len();
        let mut friction_by = Matrix::zeros(contacts, layout.parameters);
        for i in 0..contacts {
            derivatives.friction(i, friction_by.row_mut(i));
        }
        let (n, columns) = (layout.n, layout.columns());
        Self {
            view: View::new(model),
            derivatives,
            layout,
            columns,
            friction_by,
            lines: Vec::new(),
            sides: (0..contacts).map(|_| None).collect(),
            value: vec![0.0; n],
            by: Matrix::zeros(n, columns),
            forces: Vec::new(),
            forces_by: Matrix::default(),
        }
    }

    /// Coefficient of friction of a contact, and its derivatives by the parameters.
    pub(super) fn friction(&self, contact: usize) -> (f64, &[f64]) {
        (self.view.friction(contact), self.friction_by.row(contact))
    }

    /// The forces of another mode from now on.
    pub(super) fn set_mode(&mut self, modes: &[ContactMode]) {
        let closed = modes.iter().enumerate();
        let closed = closed.filter(|(_, mode)| **mode != ContactMode::Open);
        let normals = closed.clone().map(|(contact, mode)| {
            let slope = match mode {
                ContactMode::Slip(direction) => -direction.sign() * self.view.friction(contact),
                _ => 0.0,
            };
            Line::Normal { contact, slope }
        });
        let stuck = closed.filter(|(_, mode)| **mode == ContactMode::Stick);
        let tangents = stuck.map(|(contact, _)| Line::tangent(contact));
        self.lines = normals.chain(tangents).collect();
    }

    /// Leaves out forces that hold what others hold already, at `x`: the motion is that of the others.
    pub(super) fn keep_independent(&mut self, x: &[f64]) {
        self.load(x, false);
        for line in std::mem::take(&mut self.lines) {
            self.lines.push(line);
            if self.factors().is_none() {
                self.lines.pop();
            }
        }
    }

    /// Evaluates the contacts of the mode at `x`, with derivatives if these are asked for.
    pub(super) fn load(&mut self, x: &[f64], derivatives: bool) {
        for slot in 0..self.lines.len() {
            if let Line::Normal { contact, .. } = self.lines[slot] {
                self.load_sides(contact, x, derivatives);
            }
        }
    }

    /// Evaluates one contact at `x`.
    pub(super) fn load_contact(&mut self, contact: usize, x: &[f64]) {
        self.load_sides(contact, x, true);
    }

    fn load_sides(&mut self, contact: usize, x: &[f64], derivatives: bool) {
        let (n, columns) = (self.n, self.columns);
        let rough = self.model.declaration().contacts[contact]
            .friction
            .is_some();
        self.view.evaluate_normal(contact, x);
        if rough {
            self.view.evaluate_tangent(contact, x);
        }
        if derivatives {
            let tangents = if rough { tangent_point::length(n) } else { 0 };
            let rows = [contact_point::length(n), tangents];
            let sides = self.sides[contact]
                .get_or_insert_with(|| rows.map(|rows| Matrix::zeros(rows, columns)));
            let known = &self.derivatives;
            known.contact(contact, x, &mut sides[0].values);
            if rough {
                known.tangent(contact, x, &mut sides[1].values);
            }
        }
    }

    /// A component of [`Model::contact`] where that was last evaluated, and its derivatives.
    pub(super) fn point(&self, contact: usize, component: usize) -> (f64, &[f64]) {
        let by = self.sides[contact]
            .as_ref()
            .map(|[by, _]| by.row(component));
        (self.view.point(contact)[component], by.unwrap_or_default())
    }

    /// A component of [`Model::tangent`] where that was last evaluated, and its derivatives.
    pub(super) fn tangent(&self, contact: usize, component: usize) -> (f64, &[f64]) {
        let by = self.sides[contact]
            .as_ref()
            .map(|[_, by]| by.row(component));
        (
            self.view.tangent_point(contact)[component],
            by.unwrap_or_default(),
        )
    }

    /// A component of a line, at its place in [`contact_point`] or in [`tangent_point`], and its derivatives.
    fn component(&self, line: Line, [normal, tangent]: [usize; 2]) -> (f64, &[f64]) {
        match line {
            Line::Normal { contact, .. } => self.point(contact, normal),
            _ => self.tangent(line.contact(), tangent),
        }
    }

    /// Component `k` of the gradient of the velocity of a line, and its derivatives.
    pub(super) fn gradient(&self, line: Line, k: usize) -> (f64, &[f64]) {
        self.component(
            line,
            [contact_point::NORMAL + k, tangent_point::TANGENT + k],
        )
    }

    /// The velocity of a line, with its derivatives, where it was last evaluated.
    pub(super) fn velocity(&self, line: Line) -> (f64, &[f64]) {
        self.component(
            line,
            [
                contact_point::NORMAL_VELOCITY,
                tangent_point::SLIDING_VELOCITY,
            ],
        )
    }

    /// The normal velocity of a contact at `x`, with its derivatives.
    pub(super) fn normal_velocity(&mut self, contact: usize, x: &[f64]) -> (f64, &[f64]) {
        self.load_contact(contact, x);
        self.point(contact, contact_point::NORMAL_VELOCITY)
    }

    /// Adds `factor` times the derivatives of component `k` of the direction of the force of a line.
    pub(super) fn add_direction(&self, line: Line, k: usize, factor: f64, to: &mut [f64]) {
        let n = self.n;
        let places = [
            contact_point::direction(n) + k,
            tangent_point::direction(n) + k,
        ];
        add(to, factor, self.component(line, places).1);
        if let Line::Normal { contact, slope } = line
            && slope != 0.0
        {
            let (e, e_by) = self.tangent(contact, places[1]);
            let (mu, mu_by) = self.friction(contact);
            add(to, factor * slope, e_by);
            let parameters = self.columns - self.layout.parameters;
            add(&mut to[parameters..], factor * slope / mu * e, mu_by);
        }
    }

    /// Adds what forces of the first lines, a row each, push with this factor to the rows of `to` from `first` on.
    pub(super) fn push_rows(
        &self,
        forces: &Matrix,
        factor: f64,
        (to, first): (&mut Matrix, usize),
    ) {
        let rows = forces.values.chunks_exact(forces.columns.max(1));
        for (&line, force) in self.lines.iter().zip(rows) {
            let mut direction = vec![0.0; self.n];
            self.view.push(line, factor, &mut direction);
            for (k, component) in direction.into_iter().enumerate() {
                add(to.row_mut(first + k), component, force);
            }
        }
    }

    /// Factors of `rho' C`; `None` where the lines depend on each other.
    pub(super) fn factors(&self) -> Option<Factors> {
        Factors::of(self.view.couplings(&self.lines))
    }

    /// Evaluates acceleration and forces at `x`, without derivatives; `false` if the forces are not determined.
    pub(super) fn evaluate_values(&mut self, x: &[f64]) -> bool {
        self.load(x, false);
        self.balance(x).is_some()
    }

    /// Evaluates acceleration and forces with all derivatives at `x`; `false` if the forces are not determined.
    pub(super) fn evaluate(&mut self, x: &[f64]) -> bool {
        self.load(x, true);
        let Some(factors) = self.balance(x) else {
            return false;
        };
        let mut by = std::mem::take(&mut self.by);
        let known = &self.derivatives;
        known.free_acceleration(x, &mut by.values);
        for (&line, y) in self.lines.iter().zip(&self.forces) {
            for k in 0..self.n {
                self.add_direction(line, k, *y, by.row_mut(k));
            }
        }
        let forces_by = factors.solve_all(self.rates_of_lines(&by));
        self.push_rows(&forces_by, 1.0, (&mut by, 0));
        (self.by, self.forces_by) = (by, forces_by);
        true
    }

    /// Acceleration and forces where the contacts are loaded, and the factors of what balances them.
    fn balance(&mut self, x: &[f64]) -> Option<Factors> {
        self.view.evaluate_free_acceleration(x);
        let factors = self.factors()?;
        let (view, lines) = (&self.view, self.lines.iter());
        self.forces.clear();
        self.forces
            .extend(lines.map(|&line| -view.free_line_acceleration(line)));
        factors.solve(&mut self.forces);
        self.value.copy_from_slice(view.free_acceleration());
        for (&line, y) in self.lines.iter().zip(&self.forces) {
            view.push(line, *y, &mut self.value);
        }
        Some(factors)
    }

    /// `-(rho' w + drho' A + dkappa)`, a row for each line.
    fn rates_of_lines(&self, w: &Matrix) -> Matrix {
        let mut right = Matrix::zeros(self.lines.len(), self.columns);
        for (i, &line) in self.lines.iter().enumerate() {
            let row = right.row_mut(i);
            let curvature = [contact_point::CURVATURE, tangent_point::CURVATURE];
            add(row, -1.0, self.component(line, curvature).1);
            for (k, &value) in self.value.iter().enumerate() {
                let (component, by) = self.gradient(line, k);
                add(row, -component, w.row(k));
                add(row, -value, by);
            }
        }
        right
    }

    /// The force that holds the normal velocity of a contact, or its sliding velocity, with its derivatives.
    pub(super) fn force(&self, contact: usize, tangential: bool) -> Option<(f64, &[f64])> {
        let is_normal = |line: &Line| matches!(line, Line::Normal { .. });
        let mut lines = self.lines.iter();
        let place =
            lines.position(|line| line.contact() == contact && is_normal(line) != tangential)?;
        Some((self.forces[place], self.forces_by.row(place)))
    }
}

/// The input vector at a state.
pub(super) fn input(model: &dyn Model, (q, v, u): (&[f64], &[f64], &[f64]), time: f64) -> Vec<f64> {
    let mut x = [q, v, u].concat();
    if model.declaration().explicit_time {
        x.push(time);
    }
    x
}
