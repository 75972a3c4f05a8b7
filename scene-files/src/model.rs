//! What solvers ask of a scene from a text.

use crate::again::Again;
use crate::derivatives::TextDerivatives;
use crate::ranges;
use crate::scene::TextScene;
use crate::scratch::Scratch;
use crate::system::zeros;
use hangtime::model::{
    Declaration, Epigraph, Experiment, Held, Model, ParameterDerivatives, Picture,
    VariableDeclaration,
};
use hangtime_dsl::description::MotionDerivatives;

impl Model for TextScene {
    fn declaration(&self) -> &'static Declaration {
        self.shared.declaration
    }

    fn parameter(&self, index: usize) -> f64 {
        let count = self.description().parameters.len();
        let known = self.parameters[..count].get(index);
        known.copied().unwrap_or(f64::NAN)
    }

    fn set_parameter(&mut self, index: usize, value: f64) {
        let count = self.description().parameters.len();
        if let Some(parameter) = self.parameters[..count].get_mut(index) {
            *parameter = value;
            self.fold();
        }
    }

    fn start(&self, q: &mut [f64], v: &mut [f64]) {
        let description = self.description();
        let experiment = self
            .experiment
            .and_then(|index| description.experiments.get(index));
        let own = experiment.and_then(|known| known.start);
        let [coordinates, velocities] = own.unwrap_or(description.given.start);
        self.evaluate(coordinates, &[], &[], q);
        self.evaluate(velocities, &[], &[], v);
    }

    fn horizon(&self) -> Option<f64> {
        let kernel = self.description().given.horizon?;
        Some(self.value(kernel, &[]))
    }

    fn bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        let [low, high] = self.description().given.bounds;
        self.evaluate(low, &[], &[], lower);
        self.evaluate(high, &[], &[], upper);
    }

    fn free_acceleration(&self, x: &[f64], a: &mut [f64]) {
        match (self.motion().acceleration, self.motion().derivatives) {
            (Some(kernel), _) => self.evaluate(kernel, x, &[], a),
            (None, MotionDerivatives::System(system)) => {
                Scratch::lend(|scratch| {
                    self.solve(scratch, system, x);
                    let size = self.description().systems[system].size;
                    let accelerations = &scratch.solution.y[size..];
                    a.copy_from_slice(&accelerations[..a.len()]);
                });
            }
            (None, MotionDerivatives::Kernels(_)) => a.fill(f64::NAN),
        }
    }

    fn free_jacobian(&self, x: &[f64], values: &mut [f64]) {
        match self.motion().derivatives {
            MotionDerivatives::Kernels([kernel, _]) => self.evaluate(kernel, x, &[], values),
            MotionDerivatives::System(system) => {
                Scratch::lend(|scratch| {
                    self.differentiate(scratch, system, x);
                    let pattern = &self.motion().jacobian.entries;
                    scratch.solution.gather(pattern, 0, values);
                });
            }
        }
    }

    fn free_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        match self.motion().derivatives {
            MotionDerivatives::Kernels([_, kernel]) => {
                self.evaluate(kernel, x, multipliers, values);
            }
            MotionDerivatives::System(system) => {
                Scratch::lend(|scratch| {
                    let pattern = &self.motion().hessian.entries[..];
                    self.second(scratch, (system, multipliers), x, (pattern, values));
                });
            }
        }
    }

    fn mass_matrix(&self, x: &[f64], m: &mut [f64]) {
        self.evaluate(self.motion().mass_matrix, x, &[], m);
    }

    fn energy(&self, x: &[f64], energy: &mut [f64]) {
        self.evaluate(self.motion().energy, x, &[], energy);
    }

    fn gap(&self, contact: usize, x: &[f64]) -> f64 {
        self.contact_of(contact)
            .map_or(f64::NAN, |contact| self.value(contact.gap, x))
    }

    fn least_gap(&self, contact: usize, low: &[f64], high: &[f64]) -> Option<f64> {
        let kernel = self.contact_of(contact)?.gap;
        let kernel = &self.description().kernels[kernel];
        let [least, _] = ranges::of(kernel, &self.parameters, (low, high));
        (least > f64::NEG_INFINITY).then_some(least)
    }

    fn contact(&self, contact: usize, x: &[f64], point: &mut [f64]) {
        let Some(contact) = self.contact_of(contact) else {
            return point.fill(f64::NAN);
        };
        let solved = self.point(contact.point, &contact.rows, x, point);
        let n = self.description().coordinates.len();
        let normal = 4..4 + n;
        if let Some(inverse_inertia) = solved {
            // Of dry friction it is a formula.
            if !contact.dry {
                point[3] = inverse_inertia;
            }
        } else if contact.inertia_from_motion
            && let MotionDerivatives::System(system) = self.motion().derivatives
        {
            Scratch::lend(|scratch| {
                self.solve(scratch, system, x);
                let mut w = std::mem::take(&mut scratch.solution.vectors[0]);
                zeros(&mut w, n);
                scratch.solution.solve(&point[normal.clone()], &mut w);
                point[3] = w.iter().zip(&point[normal]).map(|(a, b)| a * b).sum();
                scratch.solution.vectors[0] = w;
            });
        }
    }

    fn contact_jacobian(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        match self.contact_of(contact) {
            Some(contact) => self.rows_jacobian(&contact.rows, x, values),
            None => values.fill(f64::NAN),
        }
    }

    fn contact_hessian(&self, contact: usize, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        match self.contact_of(contact) {
            Some(contact) => self.rows_hessian(&contact.rows, x, multipliers, values),
            None => values.fill(f64::NAN),
        }
    }

    fn restitution(&self, contact: usize) -> f64 {
        let kernel = self.contact_of(contact).and_then(|known| known.restitution);
        kernel.map_or(0.0, |kernel| self.value(kernel, &[]))
    }

    fn friction(&self, contact: usize) -> f64 {
        self.friction_of(contact)
            .map_or(0.0, |friction| self.value(friction.coefficient, &[]))
    }

    fn kinetic_friction(&self, contact: usize) -> f64 {
        let kinetic = self.friction_of(contact).and_then(|known| known.kinetic);
        kinetic.map_or_else(|| self.friction(contact), |kernel| self.value(kernel, &[]))
    }

    fn friction_share(&self, contact: usize, x: &[f64]) -> f64 {
        let share = self.friction_of(contact).and_then(|known| known.share);
        share.map_or(1.0, |kernel| self.value(kernel, x))
    }

    fn across(&self, contact: usize, x: &[f64], point: &mut [f64]) {
        match self
            .friction_of(contact)
            .and_then(|known| known.across.as_ref())
        {
            Some((kernel, rows)) => _ = self.point(*kernel, rows, x, point),
            None => point.fill(f64::NAN),
        }
    }

    fn across_jacobian(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        match self
            .friction_of(contact)
            .and_then(|known| known.across.as_ref())
        {
            Some((_, rows)) => self.rows_jacobian(rows, x, values),
            None => values.fill(f64::NAN),
        }
    }

    fn loads(&self, contact: usize, x: &[f64], loads: &mut [f64]) {
        if let Some((_, kernel)) = self
            .contact_of(contact)
            .and_then(|known| known.loads.as_ref())
        {
            self.evaluate(*kernel, x, &[], loads);
        }
    }

    fn tangent(&self, contact: usize, x: &[f64], point: &mut [f64]) {
        match self.friction_of(contact) {
            Some(friction) => _ = self.point(friction.tangent, &friction.rows, x, point),
            None => point.fill(f64::NAN),
        }
    }

    fn tangent_jacobian(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        match self.friction_of(contact) {
            Some(friction) => self.rows_jacobian(&friction.rows, x, values),
            None => values.fill(f64::NAN),
        }
    }

    fn tangent_hessian(&self, contact: usize, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        match self.friction_of(contact) {
            Some(friction) => self.rows_hessian(&friction.rows, x, multipliers, values),
            None => values.fill(f64::NAN),
        }
    }

    fn hold_joint_row(&mut self, row: usize, held: bool) {
        let count = self.description().parameters.len();
        if let Some(known) = self.parameters[count..].get_mut(row) {
            *known = if held { 1.0 } else { 0.0 };
            self.fold();
        }
    }

    fn joint_row_held(&self, row: usize) -> bool {
        let count = self.description().parameters.len();
        self.parameters
            .get(count + row)
            .is_none_or(|held| *held > 0.0)
    }

    fn joints(&self, x: &[f64], values: &mut [f64]) {
        if let Some(joints) = &self.description().joints {
            self.evaluate(joints.values, x, &[], values);
        }
    }

    fn joints_jacobian(&self, x: &[f64], values: &mut [f64]) {
        if let Some(joints) = &self.description().joints {
            self.evaluate(joints.jacobian, x, &[], values);
        }
    }

    fn joints_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        if let Some(joints) = &self.description().joints {
            self.evaluate(joints.hessian, x, multipliers, values);
        }
    }

    fn joint_forces(&self, x: &[f64], forces: &mut [f64]) {
        let Some(joints) = &self.description().joints else {
            return;
        };
        match (joints.forces, self.motion().derivatives) {
            (Some(kernel), _) => self.evaluate(kernel, x, &[], forces),
            (None, MotionDerivatives::System(system)) => {
                Scratch::lend(|scratch| {
                    self.solve(scratch, system, x);
                    let size = self.description().systems[system].size;
                    let behind = size + self.description().coordinates.len();
                    let solved = scratch.solution.y[behind..].iter();
                    for (force, y) in forces.iter_mut().zip(solved) {
                        *force = -y;
                    }
                });
            }
            (None, MotionDerivatives::Kernels(_)) => forces.fill(f64::NAN),
        }
    }

    fn path_functions(&self, x: &[f64], values: &mut [f64]) {
        if let Some(kernel) = self.function(|task| &task.path, 0) {
            self.evaluate(kernel, x, &[], values);
        }
    }

    fn path_jacobian(&self, x: &[f64], values: &mut [f64]) {
        if let Some(kernel) = self.function(|task| &task.path, 1) {
            self.evaluate(kernel, x, &[], values);
        }
    }

    fn path_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        if let Some(kernel) = self.function(|task| &task.path, 2) {
            self.evaluate(kernel, x, multipliers, values);
        }
    }

    fn terminal_functions(&self, z: &[f64], values: &mut [f64]) {
        if let Some(kernel) = self.function(|task| &task.terminal, 0) {
            self.evaluate(kernel, z, &[], values);
        }
    }

    fn terminal_jacobian(&self, z: &[f64], values: &mut [f64]) {
        if let Some(kernel) = self.function(|task| &task.terminal, 1) {
            self.evaluate(kernel, z, &[], values);
        }
    }

    fn terminal_hessian(&self, z: &[f64], multipliers: &[f64], values: &mut [f64]) {
        if let Some(kernel) = self.function(|task| &task.terminal, 2) {
            self.evaluate(kernel, z, multipliers, values);
        }
    }

    fn impact_functions(&self, x: &[f64], values: &mut [f64]) {
        if let Some(kernel) = self.function(|task| &task.contacts.impact, 0) {
            self.evaluate(kernel, x, &[], values);
        }
    }

    fn impact_jacobian(&self, x: &[f64], values: &mut [f64]) {
        if let Some(kernel) = self.function(|task| &task.contacts.impact, 1) {
            self.evaluate(kernel, x, &[], values);
        }
    }

    fn impact_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        if let Some(kernel) = self.function(|task| &task.contacts.impact, 2) {
            self.evaluate(kernel, x, multipliers, values);
        }
    }

    fn free_start_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        let task = self.description().optimal_control.as_ref();
        if let Some([low, high]) = task.and_then(|task| task.free_start_bounds) {
            self.evaluate(low, &[], &[], lower);
            self.evaluate(high, &[], &[], upper);
        }
    }

    fn outputs(&self) -> &'static [VariableDeclaration] {
        self.shared.outputs
    }

    fn output_values(&self, x: &[f64], contacts: &[f64], values: &mut [f64]) {
        if let Some(outputs) = &self.description().outputs {
            self.evaluate(outputs.kernel, x, contacts, values);
        }
    }

    fn picture(&self) -> Option<Picture> {
        self.shared.picture
    }

    fn picture_values(&self, x: &[f64], along: f64, values: &mut [f64]) {
        if let Some(picture) = &self.description().picture {
            self.evaluate(picture.kernel, x, &[along], values);
        }
    }

    fn text(&self) -> Option<&str> {
        Some(&self.shared.text)
    }

    fn parameter_derivatives(&self, parameters: &[usize]) -> Option<Box<dyn ParameterDerivatives>> {
        Some(Box::new(TextDerivatives::of(self, parameters)?))
    }

    fn free_parameters(&self) -> &'static [usize] {
        self.shared.free_parameters
    }

    fn free_parameter_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        if let Some(free) = &self.description().free_parameters {
            self.evaluate(free.bounds[0], &[], &[], lower);
            self.evaluate(free.bounds[1], &[], &[], upper);
        }
    }

    fn experiments(&self) -> &'static [Experiment] {
        self.shared.experiments
    }

    fn in_experiment(&self, experiment: usize) -> Option<Box<dyn Model>> {
        let mut scene = self.clone();
        scene.experiment = Some(experiment);
        Some(Box::new(scene))
    }

    fn with_held(&self, parameters: &[usize]) -> Option<Result<Box<dyn Model>, String>> {
        let derived = self.derived_again(Again::Held, parameters);
        Some(derived.map(|scene| Box::new(scene) as Box<dyn Model>))
    }

    fn reset(&self, contact: usize, x: &[f64], v: &mut [f64]) {
        if let Some(kernel) = self.description().contacts[contact].reset {
            self.evaluate(kernel, x, &[], v);
        }
    }

    fn remembered(&self) -> &'static [usize] {
        self.shared.remembered
    }

    fn epigraphs(&self) -> &'static [Epigraph] {
        self.shared.epigraphs
    }

    fn held(&self) -> Option<Held> {
        self.shared.held
    }

    fn given_values(&self, x: &[f64], values: &mut [f64]) {
        if let Some([kernel, _, _]) = self.given() {
            self.evaluate(kernel, x, &[], values);
        }
    }

    fn given_jacobian(&self, x: &[f64], values: &mut [f64]) {
        if let Some([_, kernel, _]) = self.given() {
            self.evaluate(kernel, x, &[], values);
        }
    }

    fn given_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        if let Some([_, _, kernel]) = self.given() {
            self.evaluate(kernel, x, multipliers, values);
        }
    }

    fn boxed(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }
}
