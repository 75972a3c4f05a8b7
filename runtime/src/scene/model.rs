//! What solvers ask of a scene: the one model of all that the language derived.

use super::again;
use super::data::{Contact, Friction, OptimalControl};
use super::declared::{Again, Scene};
use super::derivatives::Derivatives;
use super::solved::{View, lend};
use super::variants::{Kernels, Solved};
use crate::model::{
    ContactDeclaration, Declaration, Epigraph, Experiment, Explicit, FrictionDeclaration, Held,
    Model, ParameterDerivatives, Picture, SparsityPattern, Tape, VariableDeclaration,
    contact_point,
};
use hangtime_dsl::description;

/// Does what needs linear algebra on the kernels of a scene.
fn with<T>(scene: &impl Scene, work: impl FnOnce(View<'_>) -> T) -> T {
    work(View {
        structure: scene.structure(),
        evaluate: &|kernel, x, y, out| scene.evaluate(kernel, x, y, out),
    })
}

/// The value of a kernel that has one.
fn value(scene: &impl Scene, kernel: usize, x: &[f64]) -> f64 {
    let mut out = [f64::NAN];
    scene.evaluate(kernel, x, &[], &mut out);
    out[0]
}

/// Evaluates both kernels of bounds.
fn bounds(scene: &impl Scene, kernels: (usize, usize), lower: &mut [f64], upper: &mut [f64]) {
    scene.evaluate(kernels.0, &[], &[], lower);
    scene.evaluate(kernels.1, &[], &[], upper);
}

/// A contact, what is declared of it and its kernels.
fn contact_of(
    scene: &impl Scene,
    contact: usize,
) -> Option<(&'static ContactDeclaration, &'static Contact)> {
    let structure = scene.structure();
    let declared = structure.declaration.contacts.get(contact)?;
    Some((declared, structure.contacts.get(contact)?))
}

/// The friction of a contact, what is declared of it and its kernels.
fn friction_of(
    scene: &impl Scene,
    contact: usize,
) -> Option<(&'static FrictionDeclaration, &'static Friction)> {
    let (declared, kernels) = contact_of(scene, contact)?;
    declared.friction.as_ref().zip(kernels.friction.as_ref())
}

/// The kernels of some functions of optimal control, if there are any.
fn functions(
    scene: &impl Scene,
    of: fn(&OptimalControl) -> Option<description::Kernels>,
) -> Option<description::Kernels> {
    scene.structure().optimal_control.as_ref().and_then(of)
}

/// What is known at a point, in formulas and behind them a direction. Gives the inverse inertia along the normal if it follows from that.
fn point(
    scene: &impl Scene,
    ((kernel, formulas), rows): ((usize, usize), &description::Rows),
    x: &[f64],
    point: &mut [f64],
) -> Option<f64> {
    scene.evaluate(kernel, x, &[], point);
    rows.solved?;
    with(scene, |view| {
        view.direction(rows, x, &mut point[formulas..])
    })
}

/// Derivatives of some rows.
fn jacobian(
    scene: &impl Scene,
    (rows, pattern): (&description::Rows, SparsityPattern),
    x: &[f64],
    values: &mut [f64],
) {
    scene.evaluate(rows.kernels.0, x, &[], values);
    if rows.solved.is_some() {
        with(scene, |view| view.rows_jacobian(rows, pattern, x, values));
    }
}

/// Second derivatives of some weighted rows.
fn hessian(
    scene: &impl Scene,
    (rows, pattern): (&description::Rows, SparsityPattern),
    x: &[f64],
    multipliers: &[f64],
    values: &mut [f64],
) {
    if rows.solved.is_some() {
        with(scene, |view| {
            view.rows_hessian(rows, pattern, (x, multipliers), values);
        });
    } else {
        scene.evaluate(rows.kernels.1, x, multipliers, values);
    }
}

impl<S: Scene> Model for S {
    fn declaration(&self) -> &'static Declaration {
        &self.structure().declaration
    }

    fn parameter(&self, index: usize) -> f64 {
        match self.structure().declaration.parameters.get(index) {
            Some(_) => self.number(index),
            None => f64::NAN,
        }
    }

    fn set_parameter(&mut self, index: usize, value: f64) {
        if index < self.structure().declaration.parameters.len() {
            self.set_number(index, value);
        }
    }

    fn start(&self, q: &mut [f64], v: &mut [f64]) {
        let structure = self.structure();
        let own = self
            .experiment()
            .and_then(|known| *structure.starts.get(known)?);
        bounds(self, own.unwrap_or(structure.given.start), q, v);
    }

    fn horizon(&self) -> Option<f64> {
        let kernel = self.structure().given.horizon?;
        Some(value(self, kernel, &[]))
    }

    fn positive(&self) -> Vec<(&'static str, &'static str, f64)> {
        let Some((kernel, named)) = self.structure().given.positive else {
            return Vec::new();
        };
        let mut values = vec![0.0; named.len()];
        self.evaluate(kernel, &[], &[], &mut values);
        let named = named.iter().zip(values);
        named
            .map(|(&(what, unit), value)| (what, unit, value))
            .collect()
    }

    fn bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        bounds(self, self.structure().given.bounds, lower, upper);
    }

    fn free_acceleration(&self, x: &[f64], a: &mut [f64]) {
        let motion = &self.structure().motion;
        match (motion.acceleration, motion.derivatives) {
            (Some(kernel), _) => self.evaluate(kernel, x, &[], a),
            (None, Solved(system)) => with(self, |view| {
                lend(|work| {
                    view.solve(work, system, x);
                    let size = view.structure.systems[system].size;
                    a.copy_from_slice(&work.solution.y[size..][..a.len()]);
                });
            }),
            (None, Kernels(..)) => a.fill(f64::NAN),
        }
    }

    fn free_jacobian(&self, x: &[f64], values: &mut [f64]) {
        match self.structure().motion.derivatives {
            Kernels(kernel, _) => self.evaluate(kernel, x, &[], values),
            Solved(system) => with(self, |view| {
                lend(|work| {
                    view.differentiate(work, system, x);
                    let pattern = view.structure.declaration.free_jacobian;
                    work.solution.gather(pattern.entries, 0, values);
                });
            }),
        }
    }

    fn free_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        match self.structure().motion.derivatives {
            Kernels(_, kernel) => self.evaluate(kernel, x, multipliers, values),
            Solved(system) => with(self, |view| {
                let pattern = view.structure.declaration.free_hessian;
                view.second((system, multipliers), x, (pattern, values));
            }),
        }
    }

    fn mass_matrix(&self, x: &[f64], m: &mut [f64]) {
        self.evaluate(self.structure().motion.mass_matrix, x, &[], m);
    }

    fn energy(&self, x: &[f64], energy: &mut [f64]) {
        self.evaluate(self.structure().motion.energy, x, &[], energy);
    }

    fn gap(&self, contact: usize, x: &[f64]) -> f64 {
        contact_of(self, contact).map_or(f64::NAN, |(_, known)| value(self, known.gap, x))
    }

    fn tape(&self, function: Explicit) -> Option<Tape<'_>> {
        Scene::tape(self, function)
    }

    fn contact(&self, contact: usize, x: &[f64], out: &mut [f64]) {
        let Some((declared, known)) = contact_of(self, contact) else {
            return out.fill(f64::NAN);
        };
        let solved = point(self, (known.point, &known.rows), x, out);
        let structure = self.structure();
        if let Some(inverse_inertia) = solved {
            // Of dry friction it is a formula.
            if !declared.dry {
                out[contact_point::INVERSE_INERTIA] = inverse_inertia;
            }
        } else if known.inertia_from_motion
            && let Solved(system) = structure.motion.derivatives
        {
            let n = structure.declaration.coordinates.len();
            let normal = &out[contact_point::NORMAL..][..n];
            let inverse = with(self, |view| view.inverse_inertia(system, x, normal));
            out[contact_point::INVERSE_INERTIA] = inverse;
        }
    }

    fn contact_jacobian(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        match contact_of(self, contact) {
            Some((declared, known)) => jacobian(self, (&known.rows, declared.jacobian), x, values),
            None => values.fill(f64::NAN),
        }
    }

    fn contact_hessian(&self, contact: usize, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        match contact_of(self, contact) {
            Some((declared, known)) => {
                let rows = (&known.rows, declared.hessian);
                hessian(self, rows, x, multipliers, values);
            }
            None => values.fill(f64::NAN),
        }
    }

    fn restitution(&self, contact: usize) -> f64 {
        let kernel = contact_of(self, contact).and_then(|(_, known)| known.restitution);
        kernel.map_or(0.0, |kernel| value(self, kernel, &[]))
    }

    fn friction(&self, contact: usize) -> f64 {
        friction_of(self, contact).map_or(0.0, |(_, known)| value(self, known.coefficient, &[]))
    }

    fn kinetic_friction(&self, contact: usize) -> f64 {
        let kinetic = friction_of(self, contact).and_then(|(_, known)| known.kinetic);
        kinetic.map_or_else(|| self.friction(contact), |kernel| value(self, kernel, &[]))
    }

    fn friction_share(&self, contact: usize, x: &[f64]) -> f64 {
        let share = friction_of(self, contact).and_then(|(_, known)| known.share);
        share.map_or(1.0, |kernel| value(self, kernel, x))
    }

    fn across(&self, contact: usize, x: &[f64], out: &mut [f64]) {
        match friction_of(self, contact).and_then(|(_, known)| known.across.as_ref()) {
            Some((kernel, rows)) => _ = point(self, (*kernel, rows), x, out),
            None => out.fill(f64::NAN),
        }
    }

    fn across_jacobian(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        let known = friction_of(self, contact);
        match known.and_then(|(declared, known)| declared.across.zip(known.across.as_ref())) {
            Some((pattern, (_, rows))) => jacobian(self, (rows, pattern), x, values),
            None => values.fill(f64::NAN),
        }
    }

    fn loads(&self, contact: usize, x: &[f64], loads: &mut [f64]) {
        if let Some(kernel) = contact_of(self, contact).and_then(|(_, known)| known.loads) {
            self.evaluate(kernel, x, &[], loads);
        }
    }

    fn tangent(&self, contact: usize, x: &[f64], out: &mut [f64]) {
        match friction_of(self, contact) {
            Some((_, known)) => _ = point(self, (known.tangent, &known.rows), x, out),
            None => out.fill(f64::NAN),
        }
    }

    fn tangent_jacobian(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        match friction_of(self, contact) {
            Some((declared, known)) => jacobian(self, (&known.rows, declared.jacobian), x, values),
            None => values.fill(f64::NAN),
        }
    }

    fn tangent_hessian(&self, contact: usize, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        match friction_of(self, contact) {
            Some((declared, known)) => {
                let rows = (&known.rows, declared.hessian);
                hessian(self, rows, x, multipliers, values);
            }
            None => values.fill(f64::NAN),
        }
    }

    fn hold_joint_row(&mut self, row: usize, held: bool) {
        let first = self.structure().declaration.parameters.len();
        self.set_number(first + row, if held { 1.0 } else { 0.0 });
    }

    fn joint_row_held(&self, row: usize) -> bool {
        let first = self.structure().declaration.parameters.len();
        // One that there is not is not a number.
        self.number(first + row) != 0.0
    }

    fn joints(&self, x: &[f64], values: &mut [f64]) {
        if let Some(joints) = &self.structure().joints {
            self.evaluate(joints.values, x, &[], values);
        }
    }

    fn joints_jacobian(&self, x: &[f64], values: &mut [f64]) {
        if let Some(joints) = &self.structure().joints {
            self.evaluate(joints.jacobian, x, &[], values);
        }
    }

    fn joints_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        if let Some(joints) = &self.structure().joints {
            self.evaluate(joints.hessian, x, multipliers, values);
        }
    }

    fn joint_forces(&self, x: &[f64], forces: &mut [f64]) {
        let structure = self.structure();
        let kernel = structure.joints.and_then(|joints| joints.forces);
        match (kernel, structure.motion.derivatives) {
            (Some(kernel), _) => self.evaluate(kernel, x, &[], forces),
            (None, Solved(system)) => with(self, |view| {
                lend(|work| {
                    view.solve(work, system, x);
                    let size = structure.systems[system].size;
                    let behind = size + structure.declaration.coordinates.len();
                    let solved = work.solution.y[behind..].iter();
                    for (force, y) in forces.iter_mut().zip(solved) {
                        *force = -y;
                    }
                });
            }),
            (None, Kernels(..)) => forces.fill(f64::NAN),
        }
    }

    fn path_functions(&self, x: &[f64], values: &mut [f64]) {
        if let Some((kernel, _, _)) = functions(self, |task| task.path) {
            self.evaluate(kernel, x, &[], values);
        }
    }

    fn path_jacobian(&self, x: &[f64], values: &mut [f64]) {
        if let Some((_, kernel, _)) = functions(self, |task| task.path) {
            self.evaluate(kernel, x, &[], values);
        }
    }

    fn path_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        if let Some((_, _, kernel)) = functions(self, |task| task.path) {
            self.evaluate(kernel, x, multipliers, values);
        }
    }

    fn terminal_functions(&self, z: &[f64], values: &mut [f64]) {
        if let Some((kernel, _, _)) = functions(self, |task| task.terminal) {
            self.evaluate(kernel, z, &[], values);
        }
    }

    fn terminal_jacobian(&self, z: &[f64], values: &mut [f64]) {
        if let Some((_, kernel, _)) = functions(self, |task| task.terminal) {
            self.evaluate(kernel, z, &[], values);
        }
    }

    fn terminal_hessian(&self, z: &[f64], multipliers: &[f64], values: &mut [f64]) {
        if let Some((_, _, kernel)) = functions(self, |task| task.terminal) {
            self.evaluate(kernel, z, multipliers, values);
        }
    }

    fn impact_functions(&self, x: &[f64], values: &mut [f64]) {
        if let Some((kernel, _, _)) = functions(self, |task| task.impact) {
            self.evaluate(kernel, x, &[], values);
        }
    }

    fn impact_jacobian(&self, x: &[f64], values: &mut [f64]) {
        if let Some((_, kernel, _)) = functions(self, |task| task.impact) {
            self.evaluate(kernel, x, &[], values);
        }
    }

    fn impact_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        if let Some((_, _, kernel)) = functions(self, |task| task.impact) {
            self.evaluate(kernel, x, multipliers, values);
        }
    }

    fn free_start_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        let task = self.structure().optimal_control;
        if let Some(kernels) = task.and_then(|task| task.free_start_bounds) {
            bounds(self, kernels, lower, upper);
        }
    }

    fn outputs(&self) -> &'static [VariableDeclaration] {
        let outputs = self.structure().outputs;
        outputs.map_or(&[], |outputs| outputs.quantities)
    }

    fn output_values(&self, x: &[f64], contacts: &[f64], values: &mut [f64]) {
        if let Some(outputs) = self.structure().outputs {
            self.evaluate(outputs.kernel, x, contacts, values);
        }
    }

    fn picture(&self) -> Option<Picture> {
        self.structure().picture.map(|(picture, _)| picture)
    }

    fn picture_values(&self, x: &[f64], along: f64, values: &mut [f64]) {
        if let Some((_, kernel)) = self.structure().picture {
            self.evaluate(kernel, x, &[along], values);
        }
    }

    fn text(&self) -> Option<&str> {
        Some(&self.declared().text)
    }

    fn parameter_derivatives(&self, parameters: &[usize]) -> Option<Box<dyn ParameterDerivatives>> {
        Some(Box::new(Derivatives::of(self, parameters)?))
    }

    fn free_parameters(&self) -> &'static [usize] {
        let free = self.structure().free_parameters;
        free.map_or(&[], |free| free.parameters)
    }

    fn free_parameter_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        if let Some(free) = self.structure().free_parameters {
            bounds(self, free.bounds, lower, upper);
        }
    }

    fn experiments(&self) -> &'static [Experiment] {
        self.structure().experiments
    }

    fn in_experiment(&self, experiment: usize) -> Option<Box<dyn Model>> {
        let scene = again::derived(self, Again::Same, &[]).ok()?;
        Some(Box::new(scene.in_start_of(experiment)))
    }

    fn with_held(&self, parameters: &[usize]) -> Option<Result<Box<dyn Model>, String>> {
        let derived = again::derived(self, Again::Held, parameters);
        Some(derived.map(|scene| Box::new(scene) as Box<dyn Model>))
    }

    fn reset(&self, contact: usize, x: &[f64], v: &mut [f64]) {
        if let Some(kernel) = contact_of(self, contact).and_then(|(_, known)| known.reset) {
            self.evaluate(kernel, x, &[], v);
        }
    }

    fn remembered(&self) -> &'static [usize] {
        self.structure().remembered
    }

    fn epigraphs(&self) -> &'static [Epigraph] {
        self.structure().epigraphs
    }

    fn held(&self) -> Option<Held> {
        self.structure().held.map(|held| held.declared)
    }

    fn given_values(&self, x: &[f64], values: &mut [f64]) {
        if let Some((kernel, _, _)) = self.structure().held.and_then(|held| held.given) {
            self.evaluate(kernel, x, &[], values);
        }
    }

    fn given_jacobian(&self, x: &[f64], values: &mut [f64]) {
        if let Some((_, kernel, _)) = self.structure().held.and_then(|held| held.given) {
            self.evaluate(kernel, x, &[], values);
        }
    }

    fn given_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        if let Some((_, _, kernel)) = self.structure().held.and_then(|held| held.given) {
            self.evaluate(kernel, x, multipliers, values);
        }
    }

    fn boxed(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }
}
