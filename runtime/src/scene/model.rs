//! The trait by which solvers know a scene; `hangtime::model` states its equations.

use super::again;
use super::data::Structure;
use super::derivatives::ParameterDerivatives;
use super::functions::{Function, Order, Signature, contact_of, friction_of, signature};
use super::solved::View;
use super::tape::{Explicit, Tape};
use super::text::{Again, Declared, Shared, TextScene};
use super::variants::{Kernels, Solved};
use hangtime_dsl::declaration::{Declaration, Held, Picture, VariableDeclaration};
use std::sync::Arc;

/// A Lagrangian system with unilateral contacts: the interface between scenes and solvers.
///
/// [`model!`](crate::model!) implements its first methods, and [`TextScene`] does for scenes that were read; all others follow from these.
/// All slices have exactly the length stated; kernels are pure arithmetic and do not allocate.
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A ball above a floor.
/// #     pub Ball {
/// #         parameters { m: kg = 1, g: m/s^2 = 9.81, height: m = 1 }
/// #         coordinates { z: m }
/// #         lagrangian m/2*dot(z)^2 - m*g*z
/// #         surface floor: z >= 0
/// #         impact floor: inelastic
/// #         start { z: height }
/// #         horizon 1 [s]
/// #     }
/// # }
/// let mut ball = Ball::default();
/// ball.set_parameter(2, 0.5);
/// assert_eq!((ball.declaration().parameters[2].name, ball.height), ("height", 0.5));
/// let mut energy = [0.0; 2]; // kinetic, potential
/// ball.energy(&[0.5, 2.0], &mut energy);
/// assert_eq!(energy, [2.0, 9.81 * 0.5]);
/// # Ok::<(), InputError>(())
/// ```
pub trait Model: Send + Sync {
    /// What it declares, and of which kernels it consists. Of a compiled scene it is a constant, so that kernels are called by their names.
    fn structure(&self) -> &'static Structure;

    /// The declaration with the text that it follows from.
    fn declared(&self) -> &Declared;

    /// A number that kernels read besides their inputs: a parameter, in its unit, and behind those for each equation of a joint
    /// whether it is held, 1 or 0. Not a number where there is none.
    fn number(&self, index: usize) -> f64;

    /// Sets one of the [numbers](Self::number).
    fn set_number(&mut self, index: usize, value: f64);

    /// Evaluates a kernel at an input vector `x`, with multipliers or unknowns `y`.
    fn kernel(&self, kernel: usize, x: &[f64], y: &[f64], out: &mut [f64]);

    /// The operations of an explicit function, by which its range is bounded where its inputs lie in ranges; `None` where it has no
    /// such function. Events of functions that are known so are never missed, and contacts that cannot close are left out of account,
    /// in scenes with many.
    fn tape(&self, function: Explicit) -> Option<Tape<'_>>;

    /// A copy behind a fresh box.
    fn boxed(&self) -> Box<dyn Model>;

    /// The experiment whose start it has, if it is in one.
    fn experiment(&self) -> Option<usize> {
        None
    }

    /// What its copies share, if it was read from a text.
    fn shared(&self) -> Option<&Arc<Shared>> {
        None
    }

    /// What the scene declares: names, units, sparsity patterns, operation counts.
    fn declaration(&self) -> &'static Declaration {
        &self.structure().declaration
    }

    /// The declaration as it may stand in a scene file, without its documentation.
    fn text(&self) -> &str {
        &self.declared().text
    }

    /// Value of parameter `index`, in the unit of its declaration.
    fn parameter(&self, index: usize) -> f64 {
        match self.declaration().parameters.get(index) {
            Some(_) => self.number(index),
            None => f64::NAN,
        }
    }

    /// Sets parameter `index`, in the unit of its declaration.
    fn set_parameter(&mut self, index: usize, value: f64) {
        if index < self.declaration().parameters.len() {
            self.set_number(index, value);
        }
    }

    /// The declared initial coordinates `q` and velocities `v`, each of length `n_q`.
    fn start(&self, q: &mut [f64], v: &mut [f64]) {
        let structure = self.structure();
        let own = self
            .experiment()
            .and_then(|known| *structure.starts.get(known)?);
        bounds(self, own.unwrap_or(structure.given.start), q, v);
    }

    /// The declared length of a simulation \[s\], if the scene declares one.
    fn horizon(&self) -> Option<f64> {
        let kernel = self.structure().given.horizon?;
        Some(value(self, kernel, &[]))
    }

    /// Functions of parameters without which the scene has no meaning unless they are above zero, such as sizes of shapes: what each is, its
    /// unit, and its value.
    fn positive(&self) -> Vec<(&'static str, &'static str, f64)> {
        let Some((kernel, named)) = self.structure().given.positive else {
            return Vec::new();
        };
        let mut values = vec![0.0; named.len()];
        self.kernel(kernel, &[], &[], &mut values);
        let named = named.iter().zip(values);
        named
            .map(|(&(what, unit), value)| (what, unit, value))
            .collect()
    }

    /// Declared bounds of the coordinates and then the controls; infinite where none is declared.
    /// Both slices have length `n_q + n_u`.
    fn bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        bounds(self, self.structure().given.bounds, lower, upper);
    }

    /// Lengths and patterns of a function; none where the scene has no such function.
    fn signature(&self, function: Function) -> Option<Signature> {
        signature(self.structure(), function)
    }

    /// Values of a function at `x`. Those that the scene does not have are not written.
    fn values(&self, function: Function, x: &[f64], values: &mut [f64]) {
        view(self, |view| {
            view.evaluate((function, Order::Value), (x, &[]), values)
        });
    }

    /// Jacobian of a function with respect to its inputs: the values of its [pattern](Signature::jacobian), in that order.
    fn jacobian(&self, function: Function, x: &[f64], values: &mut [f64]) {
        view(self, |view| {
            view.evaluate((function, Order::Jacobian), (x, &[]), values)
        });
    }

    /// Hessian of the values, or rows, of a function weighted by `multipliers`: the values of its [pattern](Signature::hessian) (lower
    /// triangle), in that order.
    fn hessian(&self, function: Function, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        view(self, |view| {
            view.evaluate((function, Order::Hessian), (x, multipliers), values)
        });
    }

    /// [`Function::Motion`].
    fn free_acceleration(&self, x: &[f64], a: &mut [f64]) {
        self.values(Function::Motion, x, a);
    }

    /// [`Function::Contact`].
    fn contact(&self, contact: usize, x: &[f64], point: &mut [f64]) {
        self.values(Function::Contact(contact), x, point);
    }

    /// [`Function::Tangent`].
    fn tangent(&self, contact: usize, x: &[f64], point: &mut [f64]) {
        self.values(Function::Tangent(contact), x, point);
    }

    /// Mass matrix `M(q)`, row-major, length `n_q * n_q`.
    fn mass_matrix(&self, x: &[f64], m: &mut [f64]) {
        self.kernel(self.structure().motion.mass_matrix, x, &[], m);
    }

    /// Kinetic and potential energy, `(v' dL/dv - L_0, ...)`: length 2. The potential is the part of
    /// `-L` that remains at `v = 0`; the kinetic energy is the rest of `v' dL/dv - L`.
    fn energy(&self, x: &[f64], energy: &mut [f64]) {
        self.kernel(self.structure().motion.energy, x, &[], energy);
    }

    /// Gap `g_i(q)` of one contact.
    fn gap(&self, contact: usize, x: &[f64]) -> f64 {
        contact_of(self.structure(), contact)
            .map_or(f64::NAN, |(_, known)| value(self, known.gap, x))
    }

    /// Coefficient of restitution `e` of one contact, in `0..=1`; 0 for an inelastic one.
    fn restitution(&self, contact: usize) -> f64 {
        let known = contact_of(self.structure(), contact);
        let kernel = known.and_then(|(_, known)| known.restitution);
        kernel.map_or(0.0, |kernel| value(self, kernel, &[]))
    }

    /// Coefficient of friction `mu` of one contact, at least 0; 0 for one without friction. Where sliding has another one, it is
    /// that at rest.
    fn friction(&self, contact: usize) -> f64 {
        let known = friction_of(self.structure(), contact);
        known.map_or(0.0, |(_, known)| value(self, known.coefficient, &[]))
    }

    /// Coefficient of friction of one contact while it slides, at most that at rest.
    fn kinetic_friction(&self, contact: usize) -> f64 {
        let kinetic = friction_of(self.structure(), contact).and_then(|(_, known)| known.kinetic);
        kinetic.map_or_else(|| self.friction(contact), |kernel| value(self, kernel, &[]))
    }

    /// The factor that the friction direction of one contact carries at `x`, by which friction changes with the sliding velocity
    /// and the place: the tangential force is this times `s / D`. 1 for most contacts. An impact has that of the velocities
    /// before it.
    fn friction_share(&self, contact: usize, x: &[f64]) -> f64 {
        let share = friction_of(self.structure(), contact).and_then(|(_, known)| known.share);
        share.map_or(1.0, |kernel| value(self, kernel, x))
    }

    /// What a unit of the normal or tangential acceleration `r` of each entry of [`loads`](hangtime_dsl::declaration::ContactDeclaration::loads) of a dry friction adds to
    /// its given one: `r_dry = D f + sum_i load_i r_i`, which is the bound `f + sum_i c_i lambda_i`, `load_i = c_i D / D_i`.
    fn loads(&self, contact: usize, x: &[f64], loads: &mut [f64]) {
        let known = contact_of(self.structure(), contact);
        if let Some(kernel) = known.and_then(|(_, known)| known.loads) {
            self.kernel(kernel, x, &[], loads);
        }
    }

    /// The velocities `v`, states of first order among them, right after the function of a contact with
    /// [`Switching::Resets`](hangtime_dsl::declaration::Switching::Resets) has come to be positive at `x`.
    fn reset(&self, contact: usize, x: &[f64], v: &mut [f64]) {
        let known = contact_of(self.structure(), contact);
        if let Some(kernel) = known.and_then(|(_, known)| known.reset) {
            self.kernel(kernel, x, &[], v);
        }
    }

    /// Whether an equation of a joint is held; one that follows from others is not, and carries no force. All are at first.
    /// Equations are counted over all joints.
    fn hold_joint_row(&mut self, row: usize, held: bool) {
        let first = self.declaration().parameters.len();
        self.set_number(first + row, if held { 1.0 } else { 0.0 });
    }

    /// Whether an equation of a joint is [held](Self::hold_joint_row).
    fn joint_row_held(&self, row: usize) -> bool {
        let first = self.declaration().parameters.len();
        // One that there is not is not a number.
        self.number(first + row) != 0.0
    }

    /// Forces `lambda` of all equations of joints where nothing is in contact, in `M v' = f + G' lambda`.
    fn joint_forces(&self, x: &[f64], forces: &mut [f64]) {
        let structure = self.structure();
        let kernel = structure.joints.and_then(|joints| joints.forces);
        match (kernel, structure.motion.derivatives) {
            (Some(kernel), _) => self.kernel(kernel, x, &[], forces),
            (None, Solved(system)) => view(self, |view| view.joint_forces(system, x, forces)),
            (None, Kernels(..)) => forces.fill(f64::NAN),
        }
    }

    /// Bounds of the free initial values, in the order of
    /// [`free_start`](hangtime_dsl::declaration::OptimalControlDeclaration::free_start); infinite where none is declared.
    fn free_start_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        let task = self.structure().optimal_control;
        if let Some(kernels) = task.and_then(|task| task.free_start_bounds) {
            bounds(self, kernels, lower, upper);
        }
    }

    /// The quantities that are recorded along every motion, in order of declaration; none unless the scene declares
    /// `outputs`.
    fn outputs(&self) -> &'static [VariableDeclaration] {
        let outputs = self.structure().outputs;
        outputs.map_or(&[], |outputs| outputs.quantities)
    }

    /// Values of [`outputs`](Self::outputs), in their units, where the motion is at `x = (q, v, u, t)`; the physical
    /// time `t` stands there in every scene. `contacts` holds the normal forces of all contacts, then their tangential
    /// forces, and then the same two of the impulses of all impacts until now; its length is `4 n_c`, and behind that stand
    /// the forces of all equations of joints.
    fn output_values(&self, x: &[f64], contacts: &[f64], values: &mut [f64]) {
        if let Some(outputs) = self.structure().outputs {
            self.kernel(outputs.kernel, x, contacts, values);
        }
    }

    /// How the motion is drawn; `None` unless the scene declares a `picture`.
    fn picture(&self) -> Option<Picture> {
        self.structure().picture.map(|(picture, _)| picture)
    }

    /// Values of all shapes of the [`picture`](Self::picture), one after the other, where the motion is at
    /// `x = (q, v, u, t)`, the physical time `t` in every scene; `along` is the number along every curve. Length
    /// [`Picture::values`].
    fn picture_values(&self, x: &[f64], along: f64, values: &mut [f64]) {
        if let Some((_, kernel)) = self.structure().picture {
            self.kernel(kernel, x, &[along], values);
        }
    }

    /// Derivatives of the functions of the scene by some of its `parameters` (indices, increasing), at their present values.
    /// None where they are too large.
    fn parameter_derivatives(&self, parameters: &[usize]) -> Option<ParameterDerivatives> {
        let scene = derived(self, Again::Differentiated, parameters).ok()?;
        ParameterDerivatives::of(scene)
    }

    /// Parameters (indices, increasing) that optimal control is to find; none unless the scene declares them.
    fn free_parameters(&self) -> &'static [usize] {
        let free = self.structure().free_parameters;
        free.map_or(&[], |free| free.parameters)
    }

    /// The ranges in which the [`free_parameters`](Self::free_parameters) are looked for, in their units.
    fn free_parameter_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        if let Some(free) = self.structure().free_parameters {
            bounds(self, free.bounds, lower, upper);
        }
    }

    /// The scene as it is in one of its [`experiments`](Structure::experiments), at the present values of its parameters: with the
    /// start of that.
    ///
    /// # Errors
    /// Why it cannot be derived once more, in one line.
    fn in_experiment(&self, experiment: usize) -> Result<TextScene, String> {
        let scene = derived(self, Again::Same, &[])?;
        Ok(scene.in_start_of(experiment))
    }

    /// The scene with some of its parameters (indices, increasing) as coordinates without motion behind all others, at their
    /// present values, so that every function is differentiated by them twice: `p'' = 0`, and no contact acts on them. Those
    /// that are free are free at the start, within their ranges. What is [`remembered`](Structure::remembered) of the start stands
    /// behind them.
    ///
    /// # Errors
    /// Why the scene cannot be so, in one line.
    fn with_held(&self, parameters: &[usize]) -> Result<TextScene, String> {
        derived(self, Again::Held, parameters)
    }

    /// The parameters that are coordinates without motion in this scene, see [`with_held`](Self::with_held).
    fn held(&self) -> Option<Held> {
        self.structure().held.map(|held| held.declared)
    }
}

/// Does what needs linear algebra on the kernels of a scene.
fn view<T>(scene: &(impl Model + ?Sized), work: impl FnOnce(View<'_>) -> T) -> T {
    work(View {
        structure: scene.structure(),
        evaluate: &|kernel, x, y, out| scene.kernel(kernel, x, y, out),
    })
}

/// The value of a kernel that has one.
fn value(scene: &(impl Model + ?Sized), kernel: usize, x: &[f64]) -> f64 {
    let mut out = [f64::NAN];
    scene.kernel(kernel, x, &[], &mut out);
    out[0]
}

/// Evaluates both kernels of bounds.
fn bounds(
    scene: &(impl Model + ?Sized),
    kernels: (usize, usize),
    lower: &mut [f64],
    upper: &mut [f64],
) {
    scene.kernel(kernels.0, &[], &[], lower);
    scene.kernel(kernels.1, &[], &[], upper);
}

/// The scene at its present values, derived once more from its text with those parameters (indices).
fn derived(
    scene: &(impl Model + ?Sized),
    again: Again,
    parameters: &[usize],
) -> Result<TextScene, String> {
    let known = scene.shared().filter(|_| again == Again::Same);
    let shared = match known {
        Some(shared) => Arc::clone(shared),
        None => again::derived(scene.declared(), again, parameters)?,
    };
    let structure = scene.structure();
    let numbers = structure.declaration.parameters.len() + structure.joint_rows();
    let numbers = (0..numbers).map(|index| scene.number(index)).collect();
    Ok(TextScene::at(shared, numbers, scene.experiment()))
}

impl Model for TextScene {
    fn structure(&self) -> &'static Structure {
        self.shared.declared.structure
    }

    fn declared(&self) -> &Declared {
        &self.shared.declared
    }

    fn number(&self, index: usize) -> f64 {
        self.number(index)
    }

    fn set_number(&mut self, index: usize, value: f64) {
        self.set_number(index, value);
    }

    #[inline]
    fn kernel(&self, kernel: usize, x: &[f64], y: &[f64], out: &mut [f64]) {
        self.kernel(kernel, x, y, out);
    }

    fn tape(&self, function: Explicit) -> Option<Tape<'_>> {
        self.tape(function)
    }

    fn boxed(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }

    fn experiment(&self) -> Option<usize> {
        self.experiment
    }

    fn shared(&self) -> Option<&Arc<Shared>> {
        Some(&self.shared)
    }
}
