//! Derivatives of a scene from a text by its parameters.

use crate::again::Again;
use crate::places::{self, scatter};
use crate::scene::TextScene;
use hangtime::model::{Model, ParameterDerivatives, contact_point};
use hangtime_dsl::description::{Derivative, Functions, OptimalControl, Sensitivity};

/// A scene whose Jacobians have columns for parameters.
pub(crate) struct TextDerivatives {
    scene: TextScene,
    sensitivity: Sensitivity,
}

impl TextDerivatives {
    /// Derives `scene` once more, unless that was done before; none if that is not possible.
    pub(crate) fn of(scene: &TextScene, parameters: &[usize]) -> Option<Self> {
        let scene = scene
            .derived_again(Again::Differentiated, parameters)
            .ok()?;
        let sensitivity = scene.description().sensitivity.clone()?;
        Some(Self { scene, sensitivity })
    }

    fn columns(&self) -> usize {
        self.scene.description().columns()
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
        scatter(&derivative.pattern, &values, row, out);
    }

    /// The derivatives of the first of some functions of optimal control.
    fn first_of(&self, of: fn(&OptimalControl) -> &Functions, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        let task = self.scene.description().optimal_control.as_ref();
        let (Some(task), Some(kernel)) = (task, self.scene.function(of, 1)) else {
            return;
        };
        let pattern = &of(task).jacobian;
        let mut values = vec![0.0; pattern.entries.len()];
        self.scene.evaluate(kernel, x, &[], &mut values);
        for (&(row, column), value) in pattern.entries.iter().zip(&values) {
            if row == 0 {
                out[column] = *value;
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

impl ParameterDerivatives for TextDerivatives {
    fn start(&self, values: &mut [f64]) {
        let own = self
            .scene
            .experiment
            .and_then(|index| self.sensitivity.starts.get(index)?.as_ref());
        self.of_parameters(Some(own.unwrap_or(&self.sensitivity.start)), values);
    }

    fn horizon(&self, values: &mut [f64]) {
        self.of_parameters(self.sensitivity.horizon.as_ref(), values);
    }

    fn free_acceleration(&self, x: &[f64], values: &mut [f64]) {
        let pattern = &self.scene.description().motion.jacobian;
        let mut nonzeros = vec![0.0; pattern.entries.len()];
        self.scene.free_jacobian(x, &mut nonzeros);
        values.fill(0.0);
        scatter(pattern, &nonzeros, |row| row, values);
    }

    fn contact(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        let description = self.scene.description();
        let (Some(known), Some(derived)) = (
            description.contacts.get(contact),
            self.sensitivity.contacts.get(contact),
        ) else {
            return values.fill(f64::NAN);
        };
        let n = description.coordinates.len();
        let pattern = &known.rows.jacobian;
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
        let description = self.scene.description();
        let known = description.contacts.get(contact);
        let derived = self.sensitivity.contacts.get(contact);
        let (Some(known), Some(derived)) = (
            known.and_then(|known| known.friction.as_ref()),
            derived.and_then(|derived| derived.friction.as_ref()),
        ) else {
            return values.fill(f64::NAN);
        };
        let n = description.coordinates.len();
        let pattern = &known.rows.jacobian;
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
        if let Some(joints) = &self.scene.description().joints {
            let mut nonzeros = vec![0.0; joints.pattern.entries.len()];
            self.scene.evaluate(joints.jacobian, x, &[], &mut nonzeros);
            scatter(&joints.pattern, &nonzeros, |row| row, values);
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
        self.first_of(|task| &task.path, x, values);
    }

    fn final_cost(&self, z: &[f64], values: &mut [f64]) {
        self.first_of(|task| &task.terminal, z, values);
    }
}
