//! A scene whose functions are evaluated without a compiler.

use crate::declaration;
use crate::held;
use crate::places::{self, scatter};
use crate::program::{Program, TooLarge};
use crate::scratch::Scratch;
use crate::system::zeros;
use crate::thread::on_a_thread;
use hangtime::model::{
    Declaration, Held, Model, ParameterDerivatives, Picture, VariableDeclaration, contact_point,
};
use hangtime_dsl::description::{
    Contact, Derivative, Description, Friction, Functions, Joints, Motion, MotionDerivatives,
    OptimalControl, Rows, Sensitivity,
};
use std::sync::{Arc, Mutex};

/// A scene from a text: a model like those that the compiler makes, with the same operations in the same order.
///
/// Copies share everything but the values of the parameters. Evaluation allocates nothing after the first one of a thread.
#[derive(Debug, Clone)]
pub struct TextScene {
    shared: Arc<Shared>,
    parameters: Vec<f64>,
    /// What depends on parameters only, of all programs.
    folded: Vec<f64>,
}

#[derive(Debug)]
struct Shared {
    declaration: &'static Declaration,
    outputs: &'static [VariableDeclaration],
    picture: Option<Picture>,
    free_parameters: &'static [usize],
    held: Option<Held>,
    description: Description,
    programs: Vec<Program>,
    /// The text that it was derived from.
    text: String,
    /// The same derived with derivatives by parameters, for all sets of them that were asked for.
    differentiated: Mutex<Vec<(Vec<usize>, Arc<Self>)>>,
    /// The same with parameters as coordinates without motion.
    with_held: Mutex<Vec<(Vec<usize>, Arc<Self>)>>,
    warnings: String,
}

impl TextScene {
    pub(crate) fn new(
        description: Description,
        text: &str,
        warnings: String,
    ) -> Result<Self, TooLarge> {
        let mut programs: Vec<Program> = Vec::with_capacity(description.kernels.len());
        for kernel in &description.kernels {
            let before = programs.last().map_or(0, |last| last.folded.end);
            programs.push(Program::new(kernel, before)?);
        }
        let defaults = description.parameters.iter().map(|known| known.default);
        let rows = description.joints.as_ref().map_or(0, Joints::rows);
        let mut scene = Self {
            // Which equations of joints are held stands behind the parameters.
            parameters: defaults.chain(std::iter::repeat_n(1.0, rows)).collect(),
            folded: Vec::new(),
            shared: Arc::new(Shared {
                declaration: declaration::of(&description),
                outputs: declaration::outputs(description.outputs.as_ref()),
                picture: description.picture.as_ref().map(declaration::picture),
                free_parameters: declaration::free_parameters(&description),
                held: description.held.as_ref().map(declaration::held),
                description,
                programs,
                text: text.to_owned(),
                differentiated: Mutex::default(),
                with_held: Mutex::default(),
                warnings,
            }),
        };
        scene.fold();
        Ok(scene)
    }

    /// What is accepted in its text, but most likely not meant, as a report that shows the lines; empty if there is
    /// nothing.
    ///
    /// ```
    /// let text = "parameters { m: kg = 1, k: N/m = 2 } coordinates { z: m } lagrangian m/2*dot(z)^2";
    /// let scene = hangtime_scene_files::of_text("ball.hang", text)?;
    /// assert!(scene.warnings().starts_with("warning[E16]: parameter `k` is never used"));
    /// assert!(scene.warnings().ends_with("ball.hang: 1 warning"));
    /// let scene = hangtime_scene_files::of_text("ball.hang", &text.replace(", k: N/m = 2", ""))?;
    /// assert!(scene.warnings().is_empty());
    /// # Ok::<(), hangtime_scene_files::SceneError>(())
    /// ```
    #[must_use]
    pub fn warnings(&self) -> &str {
        &self.shared.warnings
    }

    /// Computes what depends on parameters only.
    fn fold(&mut self) {
        self.folded.clear();
        for program in &self.shared.programs {
            self.folded.extend(program.fold(&self.parameters));
        }
    }

    fn description(&self) -> &Description {
        &self.shared.description
    }

    fn motion(&self) -> &Motion {
        &self.shared.description.motion
    }

    /// Evaluates a kernel in lent memory.
    #[inline(always)]
    fn run(&self, scratch: &mut Scratch, kernel: usize, (x, y): (&[f64], &[f64]), out: &mut [f64]) {
        let program = &self.shared.programs[kernel];
        let folded = &self.folded[program.folded.clone()];
        program.run(folded, x, y, out, &mut scratch.registers);
    }

    /// Evaluates a kernel.
    fn evaluate(&self, kernel: usize, x: &[f64], y: &[f64], out: &mut [f64]) {
        Scratch::lend(|scratch| self.run(scratch, kernel, (x, y), out));
    }

    /// The value of a kernel that has one.
    fn value(&self, kernel: usize, x: &[f64]) -> f64 {
        let mut out = [f64::NAN];
        self.evaluate(kernel, x, &[], &mut out);
        out[0]
    }

    /// The values of a kernel, in lent memory.
    fn values(&self, scratch: &mut Scratch, kernel: usize, of: (&[f64], &[f64])) -> Vec<f64> {
        let mut values = std::mem::take(&mut scratch.values);
        zeros(
            &mut values,
            self.description().kernels[kernel].outputs.len(),
        );
        self.run(scratch, kernel, of, &mut values);
        values
    }

    /// Solves a linear system.
    fn solve(&self, scratch: &mut Scratch, system: usize, x: &[f64]) {
        let system = &self.description().systems[system];
        let values = self.values(scratch, system.solve, (x, &[]));
        scratch.solution.solve_system(&values, system.size);
        scratch.values = values;
    }

    /// Solves a linear system and differentiates the solution.
    fn differentiate(&self, scratch: &mut Scratch, system: usize, x: &[f64]) {
        self.solve(scratch, system, x);
        let (kernel, pattern) = &self.description().systems[system].jacobian;
        let y = std::mem::take(&mut scratch.solution.y);
        let values = self.values(scratch, *kernel, (x, &y));
        scratch.solution.y = y;
        let inputs = self.description().columns();
        scratch.solution.differentiate(pattern, &values, inputs);
        scratch.values = values;
    }

    /// Second derivatives of the weighted solution of a linear system; weights behind those given are zero.
    fn second(
        &self,
        scratch: &mut Scratch,
        (system, weights): (usize, &[f64]),
        x: &[f64],
        (pattern, out): (&[(usize, usize)], &mut [f64]),
    ) {
        self.differentiate(scratch, system, x);
        let system = &self.description().systems[system];
        let mut lambda = std::mem::take(&mut scratch.solution.vectors[1]);
        lambda.clear();
        lambda.extend_from_slice(weights);
        lambda.resize(system.size, 0.0);
        scratch.solution.solve_transposed(&lambda);
        scratch.solution.vectors[1] = lambda;
        let y = std::mem::take(&mut scratch.solution.y);
        let residual = self.values(scratch, system.hessian.0, (x, &y));
        scratch.values = std::mem::take(&mut scratch.others);
        let cross = self.values(scratch, system.cross.0, (x, &y));
        scratch.solution.y = y;
        scratch.solution.pull_back(
            (&system.hessian.1, &residual),
            (&system.cross.1, &cross),
            pattern,
            out,
        );
        scratch.values = residual;
        scratch.others = cross;
    }

    /// What is known at a point: a kernel, and the solution of a linear system behind it.
    fn point(&self, kernel: usize, rows: &Rows, x: &[f64], point: &mut [f64]) {
        self.evaluate(kernel, x, &[], point);
        let Some(solved) = &rows.solved else { return };
        let first = self.description().kernels[kernel].outputs.len();
        let size = self.description().systems[solved.system].size;
        Scratch::lend(|scratch| {
            self.solve(scratch, solved.system, x);
            let rest = &mut point[first..];
            rest.copy_from_slice(&scratch.solution.y[size..][..rest.len()]);
        });
    }

    fn rows_jacobian(&self, rows: &Rows, x: &[f64], values: &mut [f64]) {
        let kernel = rows.kernels[0];
        self.evaluate(kernel, x, &[], values);
        let Some(solved) = &rows.solved else { return };
        let first = self.description().kernels[kernel].outputs.len();
        Scratch::lend(|scratch| {
            self.differentiate(scratch, solved.system, x);
            let below = &rows.jacobian.entries[first..];
            scratch
                .solution
                .gather(below, solved.formulas, &mut values[first..]);
        });
    }

    fn rows_hessian(&self, rows: &Rows, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        let kernel = rows.kernels[1];
        let Some(solved) = &rows.solved else {
            return self.evaluate(kernel, x, multipliers, values);
        };
        Scratch::lend(|scratch| {
            let weighted = (solved.system, &multipliers[solved.formulas..]);
            self.second(scratch, weighted, x, (&rows.hessian.entries, values));
            let geometry = self.values(scratch, kernel, (x, multipliers));
            for (&place, value) in solved.places.iter().zip(&geometry) {
                values[place] += value;
            }
            scratch.values = geometry;
        });
    }

    fn contact_of(&self, contact: usize) -> Option<&Contact> {
        self.description().contacts.get(contact)
    }

    fn friction_of(&self, contact: usize) -> Option<&Friction> {
        self.contact_of(contact)?.friction.as_ref()
    }

    /// The kernels of what parameters decide that are coordinates, if there are any.
    fn given(&self) -> Option<[usize; 3]> {
        self.description().held.as_ref()?.functions.kernels
    }

    /// The kernel at one place of functions of optimal control, if there are any.
    fn function(&self, of: fn(&OptimalControl) -> &Functions, place: usize) -> Option<usize> {
        let task = self.description().optimal_control.as_ref()?;
        of(task).kernels.map(|kernels| kernels[place])
    }
}

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
        let [coordinates, velocities] = self.description().given.start;
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

    fn contact(&self, contact: usize, x: &[f64], point: &mut [f64]) {
        let Some(contact) = self.contact_of(contact) else {
            return point.fill(f64::NAN);
        };
        self.point(contact.point, &contact.rows, x, point);
        let n = self.description().coordinates.len();
        let normal = 4..4 + n;
        if let Some(solved) = &contact.rows.solved {
            let size = self.description().systems[solved.system].size;
            Scratch::lend(|scratch| point[3] = 1.0 / scratch.solution.y[2 * size - 1]);
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

    fn tangent(&self, contact: usize, x: &[f64], point: &mut [f64]) {
        match self.friction_of(contact) {
            Some(friction) => self.point(friction.tangent, &friction.rows, x, point),
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
        let derivatives = differentiated(self, parameters)?;
        Some(Box::new(derivatives))
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

    fn with_held(&self, parameters: &[usize]) -> Option<Result<Box<dyn Model>, String>> {
        let derived = with_held(self, parameters);
        Some(derived.map(|scene| Box::new(scene) as Box<dyn Model>))
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

/// Derives `scene` once more with those parameters as coordinates without motion, unless that was done before.
fn with_held(scene: &TextScene, parameters: &[usize]) -> Result<TextScene, String> {
    let known = || {
        let known = scene.shared.with_held.lock().ok()?;
        let (_, shared) = known.iter().find(|(of, _)| of == parameters)?;
        Some(Arc::clone(shared))
    };
    let shared = match known() {
        Some(shared) => shared,
        None => {
            let text = scene.shared.text.as_str();
            let description = held::derived(scene.description(), text, parameters)?;
            let derived = TextScene::new(description, text, String::new());
            let shared = derived.map_err(|_| TOO_LARGE.to_owned())?.shared;
            if let Ok(mut known) = scene.shared.with_held.lock() {
                known.push((parameters.to_vec(), Arc::clone(&shared)));
            }
            shared
        }
    };
    let mut with_held = TextScene {
        parameters: scene.parameters.clone(),
        folded: Vec::new(),
        shared,
    };
    with_held.fold();
    Ok(with_held)
}

/// Why a scene with unknown parameters is refused.
const TOO_LARGE: &str = "a function derived with parameters as unknowns has too many values; split the mechanism into smaller scenes";

/// A scene whose Jacobians have columns for parameters.
struct TextDerivatives {
    scene: TextScene,
    sensitivity: Sensitivity,
}

/// Derives `scene` once more, unless that was done before; none if it is too large.
fn differentiated(scene: &TextScene, parameters: &[usize]) -> Option<TextDerivatives> {
    let known = || {
        let known = scene.shared.differentiated.lock().ok()?;
        let (_, shared) = known.iter().find(|(of, _)| of == parameters)?;
        Some(Arc::clone(shared))
    };
    let shared = match known() {
        Some(shared) => shared,
        None => {
            let derived = derive_by(scene, parameters)?;
            let mut known = scene.shared.differentiated.lock().ok()?;
            known.push((parameters.to_vec(), Arc::clone(&derived)));
            derived
        }
    };
    let sensitivity = shared.description.sensitivity.clone()?;
    let mut differentiated = TextScene {
        parameters: scene.parameters.clone(),
        folded: Vec::new(),
        shared,
    };
    differentiated.fold();
    Some(TextDerivatives {
        scene: differentiated,
        sensitivity,
    })
}

/// Derives `scene` once more, with derivatives by parameters.
fn derive_by(scene: &TextScene, parameters: &[usize]) -> Option<Arc<Shared>> {
    let declared = &scene.description().parameters;
    let names: Vec<&str> = parameters
        .iter()
        .filter_map(|&index| Some(declared.get(index)?.name.as_str()))
        .collect();
    let text = scene.shared.text.as_str();
    let derived = on_a_thread(&scene.description().name, |stem| {
        hangtime_dsl::describe_differentiated(text, stem, &names)
    });
    let (description, _) = derived.ok()?.ok()?;
    Some(
        TextScene::new(description, text, String::new())
            .ok()?
            .shared,
    )
}

impl TextDerivatives {
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
        self.of_parameters(Some(&self.sensitivity.start), values);
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

    fn restitution(&self, contact: usize, values: &mut [f64]) {
        let known = self.sensitivity.contacts.get(contact);
        self.of_parameters(known.and_then(|known| known.restitution.as_ref()), values);
    }

    fn friction(&self, contact: usize, values: &mut [f64]) {
        let known = self.sensitivity.contacts.get(contact);
        let friction = known.and_then(|known| known.friction.as_ref());
        self.of_parameters(friction.map(|friction| &friction.coefficient), values);
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
