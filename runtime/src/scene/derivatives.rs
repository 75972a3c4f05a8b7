//! Derivatives of a scene by its parameters.

use super::data::{OptimalControl, Structure};
use super::functions::{Function, Order};
use super::places::{self, contact_point, scatter};
use super::text::TextScene;
use hangtime_dsl::declaration::{OptimalControlDeclaration, SparsityPattern};
use hangtime_dsl::description::{Derivative, Kernels, Sensitivity};

/// Derivatives of the functions of a [`Model`](super::Model) by its inputs `x` and by some of its parameters, at the values that
/// these had when this was made.
///
/// All are dense matrices, row-major, with a row for each value of the function and a column for each component of `x`; the
/// columns of the `p` parameters stand behind those.
pub struct ParameterDerivatives {
    /// A scene whose Jacobians have columns for parameters.
    scene: TextScene,
    sensitivity: Sensitivity,
}

impl ParameterDerivatives {
    /// Those that a scene knows that was derived with parameters; none of one that was derived without.
    pub(super) fn of(scene: TextScene) -> Option<Self> {
        let sensitivity = scene.shared.declared.structure.sensitivity?;
        Some(Self { scene, sensitivity })
    }

    fn structure(&self) -> &'static Structure {
        self.scene.shared.declared.structure
    }

    fn columns(&self) -> usize {
        self.structure().columns()
    }

    /// Evaluates a Jacobian and puts its values into the rows that `row` names, of a matrix of zeros otherwise.
    fn rows(
        &self,
        (function, pattern): (Function, SparsityPattern),
        x: &[f64],
        row: impl Fn(usize) -> usize,
        out: &mut [f64],
    ) {
        let mut nonzeros = vec![0.0; pattern.entries.len()];
        let jacobian = (function, Order::Jacobian);
        self.scene
            .view(|view| view.evaluate(jacobian, (x, &[]), &mut nonzeros));
        out.fill(0.0);
        scatter(pattern, &nonzeros, row, out);
    }

    /// Evaluates a kernel and puts its values into the rows that `row` names, of a matrix of zeros.
    fn put(
        &self,
        derivative: &Derivative,
        (x, weights): (&[f64], &[f64]),
        row: impl Fn(usize) -> usize,
        out: &mut [f64],
    ) {
        let mut values = vec![0.0; derivative.pattern.entries.len()];
        self.scene
            .kernel(derivative.kernel, x, weights, &mut values);
        scatter(derivative.pattern, &values, row, out);
    }

    /// The derivatives of the first of some functions of optimal control.
    fn first_of(
        &self,
        kernels: fn(&OptimalControl) -> Option<Kernels>,
        pattern: fn(&OptimalControlDeclaration) -> SparsityPattern,
        x: &[f64],
        out: &mut [f64],
    ) {
        out.fill(0.0);
        let structure = self.structure();
        let kernels = structure.optimal_control.as_ref().and_then(kernels);
        let declared = structure.declaration.optimal_control.as_ref();
        let (Some(declared), Some((_, kernel, _))) = (declared, kernels) else {
            return;
        };
        let entries = pattern(declared).entries;
        let mut values = vec![0.0; entries.len()];
        self.scene.kernel(kernel, x, &[], &mut values);
        for (&(row, column), value) in entries.iter().zip(&values) {
            if row == 0 {
                out[column as usize] = *value;
            }
        }
    }

    /// The derivatives of something that parameters alone decide.
    fn of_parameters(&self, derivative: Option<&Derivative>, out: &mut [f64]) {
        out.fill(0.0);
        if let Some(derivative) = derivative {
            self.put(derivative, (&[], &[]), |row| row, out);
        }
    }

    /// Of the initial coordinates and then velocities, by the parameters: `2 n_q` rows and `p` columns.
    pub fn start(&self, values: &mut [f64]) {
        let own = self
            .scene
            .experiment
            .and_then(|index| self.sensitivity.starts.get(index)?.as_ref());
        self.of_parameters(Some(own.unwrap_or(&self.sensitivity.start)), values);
    }

    /// Of the declared length of a simulation, by the parameters: `p` numbers, 0 where none is declared.
    pub fn horizon(&self, values: &mut [f64]) {
        self.of_parameters(self.sensitivity.horizon.as_ref(), values);
    }

    /// Of [`Function::Motion`].
    pub fn free_acceleration(&self, x: &[f64], values: &mut [f64]) {
        let pattern = self.structure().declaration.free_jacobian;
        self.rows((Function::Motion, pattern), x, |row| row, values);
    }

    /// Of [`Function::Contact`], with rows in the layout of [`contact_point`]. Where the inverse inertia has no derivative its row is
    /// not a number.
    pub fn contact(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        let declaration = &self.structure().declaration;
        let (Some(known), Some(derived)) = (
            declaration.contacts.get(contact),
            self.sensitivity.contacts.get(contact),
        ) else {
            return values.fill(f64::NAN);
        };
        let n = declaration.coordinates.len();
        let rows = (Function::Contact(contact), known.jacobian);
        self.rows(rows, x, |row| places::of_contact(n, row), values);
        let columns = self.columns();
        if known.dry {
            // What stands there is the given normal acceleration.
            values[contact_point::NORMAL_VELOCITY * columns..][..columns].fill(0.0);
        }
        self.put(&derived.geometry, (x, &[]), places::of_geometry, values);
        if !derived.knows_inertia {
            values[contact_point::INVERSE_INERTIA * columns..][..columns].fill(f64::NAN);
        }
    }

    /// Of [`Function::Tangent`], with rows in the layout of [`tangent_point`](super::tangent_point).
    pub fn tangent(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        let declaration = &self.structure().declaration;
        let known = declaration.contacts.get(contact);
        let derived = self.sensitivity.contacts.get(contact);
        let (Some(known), Some(derived)) = (
            known.and_then(|known| known.friction.as_ref()),
            derived.and_then(|derived| derived.friction.as_ref()),
        ) else {
            return values.fill(f64::NAN);
        };
        let n = declaration.coordinates.len();
        let rows = (Function::Tangent(contact), known.jacobian);
        self.rows(rows, x, |row| places::of_friction(n, row), values);
        let place = places::of_tangent_geometry;
        self.put(&derived.geometry, (x, &[]), place, values);
    }

    /// Of [`Function::Joints`]. Only for scenes with joints.
    pub fn joints(&self, x: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        if let Some(joints) = &self.structure().declaration.joints {
            let rows = (Function::Joints, joints.jacobian);
            self.rows(rows, x, |row| row, values);
        }
    }

    /// Of [`Model::restitution`](super::Model::restitution), by the parameters.
    pub fn restitution(&self, contact: usize, values: &mut [f64]) {
        let known = self.sensitivity.contacts.get(contact);
        self.of_parameters(known.and_then(|known| known.restitution.as_ref()), values);
    }

    /// Of [`Model::friction`](super::Model::friction), by the parameters.
    pub fn friction(&self, contact: usize, values: &mut [f64]) {
        let known = self.sensitivity.contacts.get(contact);
        let friction = known.and_then(|known| known.friction.as_ref());
        self.of_parameters(friction.map(|friction| &friction.coefficient), values);
    }

    /// Of [`Model::reset`](super::Model::reset), of all velocities. Only for conditions that set something.
    pub fn reset(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        let known = self.sensitivity.contacts.get(contact);
        if let Some(reset) = known.and_then(|known| known.reset.as_ref()) {
            self.put(reset, (x, &[]), |row| row, values);
        }
    }

    /// Of [`Model::output_values`](super::Model::output_values), by `(q, v, u, t)`, by the forces and impulses of `contacts`,
    /// by the forces of joints behind them, and by the parameters.
    pub fn outputs(&self, x: &[f64], contacts: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        if let Some(outputs) = &self.sensitivity.outputs {
            self.put(outputs, (x, contacts), |row| row, values);
        }
    }

    /// Of the running cost. Only for scenes whose costs read nothing of contacts.
    pub fn running_cost(&self, x: &[f64], values: &mut [f64]) {
        self.first_of(|task| task.path, |task| task.path_jacobian, x, values);
    }

    /// Of the final cost, by `z = (q, v, T)` and by the parameters. Only for scenes whose costs read nothing of contacts.
    pub fn final_cost(&self, z: &[f64], values: &mut [f64]) {
        self.first_of(
            |task| task.terminal,
            |task| task.terminal_jacobian,
            z,
            values,
        );
    }
}
