//! Derivatives of a scene by its parameters.

use super::again;
use super::data::{OptimalControl, Structure};
use super::declared::{Again, Scene};
use super::places::{self, scatter};
use super::text::TextScene;
use crate::model::{Model, ParameterDerivatives, SparsityPattern, contact_point};
use hangtime_dsl::declaration::OptimalControlDeclaration;
use hangtime_dsl::description::{Derivative, Kernels, Sensitivity};

/// A scene whose Jacobians have columns for parameters.
pub(super) struct Derivatives {
    scene: TextScene,
    sensitivity: Sensitivity,
}

impl Derivatives {
    /// Derives `scene` once more, unless that was done before; none if that is not possible.
    pub(super) fn of(scene: &impl Scene, parameters: &[usize]) -> Option<Self> {
        let scene = again::derived(scene, Again::Differentiated, parameters).ok()?;
        let sensitivity = scene.structure().sensitivity?;
        Some(Self { scene, sensitivity })
    }

    fn structure(&self) -> &'static Structure {
        self.scene.structure()
    }

    fn columns(&self) -> usize {
        self.structure().columns()
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
            .evaluate(derivative.kernel, x, weights, &mut values);
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
        self.scene.evaluate(kernel, x, &[], &mut values);
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
}

impl ParameterDerivatives for Derivatives {
    fn start(&self, values: &mut [f64]) {
        let own = self
            .scene
            .experiment()
            .and_then(|index| self.sensitivity.starts.get(index)?.as_ref());
        self.of_parameters(Some(own.unwrap_or(&self.sensitivity.start)), values);
    }

    fn horizon(&self, values: &mut [f64]) {
        self.of_parameters(self.sensitivity.horizon.as_ref(), values);
    }

    fn free_acceleration(&self, x: &[f64], values: &mut [f64]) {
        let pattern = self.structure().declaration.free_jacobian;
        let mut nonzeros = vec![0.0; pattern.entries.len()];
        self.scene.free_jacobian(x, &mut nonzeros);
        values.fill(0.0);
        scatter(pattern, &nonzeros, |row| row, values);
    }

    fn contact(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        let declaration = &self.structure().declaration;
        let (Some(known), Some(derived)) = (
            declaration.contacts.get(contact),
            self.sensitivity.contacts.get(contact),
        ) else {
            return values.fill(f64::NAN);
        };
        let n = declaration.coordinates.len();
        let pattern = known.jacobian;
        let mut nonzeros = vec![0.0; pattern.entries.len()];
        self.scene.contact_jacobian(contact, x, &mut nonzeros);
        values.fill(0.0);
        scatter(pattern, &nonzeros, |row| places::of_contact(n, row), values);
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

    fn tangent(&self, contact: usize, x: &[f64], values: &mut [f64]) {
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
        let pattern = known.jacobian;
        let mut nonzeros = vec![0.0; pattern.entries.len()];
        self.scene.tangent_jacobian(contact, x, &mut nonzeros);
        values.fill(0.0);
        scatter(
            pattern,
            &nonzeros,
            |row| places::of_friction(n, row),
            values,
        );
        let place = places::of_tangent_geometry;
        self.put(&derived.geometry, (x, &[]), place, values);
    }

    fn joints(&self, x: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        if let Some(joints) = &self.structure().declaration.joints {
            let mut nonzeros = vec![0.0; joints.jacobian.entries.len()];
            self.scene.joints_jacobian(x, &mut nonzeros);
            scatter(joints.jacobian, &nonzeros, |row| row, values);
        }
    }

    fn restitution(&self, contact: usize, values: &mut [f64]) {
        let known = self.sensitivity.contacts.get(contact);
        self.of_parameters(known.and_then(|known| known.restitution.as_ref()), values);
    }

    fn friction(&self, contact: usize, values: &mut [f64]) {
        let known = self.sensitivity.contacts.get(contact);
        let friction = known.and_then(|known| known.friction.as_ref());
        self.of_parameters(friction.map(|friction| &friction.coefficient), values);
    }

    fn reset(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        let known = self.sensitivity.contacts.get(contact);
        if let Some(reset) = known.and_then(|known| known.reset.as_ref()) {
            self.put(reset, (x, &[]), |row| row, values);
        }
    }

    fn outputs(&self, x: &[f64], contacts: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        if let Some(outputs) = &self.sensitivity.outputs {
            self.put(outputs, (x, contacts), |row| row, values);
        }
    }

    fn running_cost(&self, x: &[f64], values: &mut [f64]) {
        self.first_of(|task| task.path, |task| task.path_jacobian, x, values);
    }

    fn final_cost(&self, z: &[f64], values: &mut [f64]) {
        self.first_of(
            |task| task.terminal,
            |task| task.terminal_jacobian,
            z,
            values,
        );
    }
}
