//! A scene whose functions are evaluated without a compiler.

use crate::again::{self, Again};
use crate::declaration;
use crate::inertia::Direction;
use crate::program::{Program, TooLarge};
use crate::scratch::Scratch;
use crate::system::zeros;
use hangtime::model::{Declaration, Experiment, Held, Picture, VariableDeclaration};
use hangtime_dsl::description::{
    Contact, Description, Friction, Functions, Joints, Motion, OptimalControl, Rows, Solver,
    Vectors,
};
use std::sync::{Arc, Mutex};

/// A scene from a text: a model like those that the compiler makes, with the same operations in the same order.
///
/// Copies share everything but the values of the parameters. Evaluation allocates nothing after the first one of a thread.
#[derive(Debug, Clone)]
pub struct TextScene {
    pub(crate) shared: Arc<Shared>,
    pub(crate) parameters: Vec<f64>,
    /// What depends on parameters only, of all programs.
    folded: Vec<f64>,
    /// The experiment whose start it has, if it is in one.
    pub(crate) experiment: Option<usize>,
}

#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) declaration: &'static Declaration,
    pub(crate) outputs: &'static [VariableDeclaration],
    pub(crate) picture: Option<Picture>,
    pub(crate) free_parameters: &'static [usize],
    pub(crate) experiments: &'static [Experiment],
    pub(crate) remembered: &'static [usize],
    pub(crate) held: Option<Held>,
    pub(crate) description: Description,
    programs: Vec<Program>,
    /// The text that it was derived from.
    pub(crate) text: String,
    /// The same derived once more, for all sets of parameters that were asked for.
    again: Mutex<Vec<DerivedAgain>>,
    warnings: String,
}

/// How a scene was derived once more, by which parameters (indices), and what that gave.
type DerivedAgain = (Again, Vec<usize>, Arc<Shared>);

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
            experiment: None,
            shared: Arc::new(Shared {
                declaration: declaration::of(&description),
                outputs: declaration::outputs(description.outputs.as_ref()),
                picture: description.picture.as_ref().map(declaration::picture),
                free_parameters: declaration::free_parameters(&description),
                experiments: declaration::experiments(&description),
                remembered: declaration::remembered(&description),
                held: description.held.as_ref().map(declaration::held),
                description,
                programs,
                text: text.to_owned(),
                again: Mutex::default(),
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
    pub(crate) fn fold(&mut self) {
        self.folded.clear();
        for program in &self.shared.programs {
            self.folded.extend(program.fold(&self.parameters));
        }
    }

    pub(crate) fn description(&self) -> &Description {
        &self.shared.description
    }

    pub(crate) fn motion(&self) -> &Motion {
        &self.shared.description.motion
    }

    /// Evaluates a kernel in lent memory.
    #[inline(always)]
    pub(crate) fn run(
        &self,
        scratch: &mut Scratch,
        kernel: usize,
        (x, y): (&[f64], &[f64]),
        out: &mut [f64],
    ) {
        let program = &self.shared.programs[kernel];
        let folded = &self.folded[program.folded.clone()];
        program.run(folded, x, y, out, &mut scratch.registers);
    }

    /// Evaluates a kernel.
    pub(crate) fn evaluate(&self, kernel: usize, x: &[f64], y: &[f64], out: &mut [f64]) {
        Scratch::lend(|scratch| self.run(scratch, kernel, (x, y), out));
    }

    /// The value of a kernel that has one.
    pub(crate) fn value(&self, kernel: usize, x: &[f64]) -> f64 {
        let mut out = [f64::NAN];
        self.evaluate(kernel, x, &[], &mut out);
        out[0]
    }

    /// The values of a kernel, in lent memory.
    pub(crate) fn values(
        &self,
        scratch: &mut Scratch,
        kernel: usize,
        of: (&[f64], &[f64]),
    ) -> Vec<f64> {
        let mut values = std::mem::take(&mut scratch.values);
        zeros(
            &mut values,
            self.description().kernels[kernel].outputs.len(),
        );
        self.run(scratch, kernel, of, &mut values);
        values
    }

    /// Solves a linear system.
    pub(crate) fn solve(&self, scratch: &mut Scratch, system: usize, x: &[f64]) {
        let system = &self.description().systems[system];
        let values = self.values(scratch, system.solve, (x, &[]));
        scratch.solution.solve_system(&values, system.size);
        scratch.values = values;
    }

    /// Solves a linear system and differentiates the solution.
    pub(crate) fn differentiate(&self, scratch: &mut Scratch, system: usize, x: &[f64]) {
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
    pub(crate) fn second(
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

    /// What is known at a point: a kernel, and a direction behind it that is solved for. Gives the inverse inertia along the
    /// normal if that follows from it.
    pub(crate) fn point(
        &self,
        kernel: usize,
        rows: &Rows,
        x: &[f64],
        point: &mut [f64],
    ) -> Option<f64> {
        self.evaluate(kernel, x, &[], point);
        let solved = rows.solved.as_ref()?;
        let rest = &mut point[self.description().kernels[kernel].outputs.len()..];
        match &solved.by {
            Solver::Inertia(vectors) => self.direction(vectors, x, |own| own.value(rest)),
            &Solver::System(system) => Scratch::lend(|scratch| {
                let size = self.description().systems[system].size;
                self.solve(scratch, system, x);
                rest.copy_from_slice(&scratch.solution.y[size..][..rest.len()]);
                1.0 / scratch.solution.y[2 * size - 1]
            }),
        }
    }

    /// Lends a direction that is solved for with the inertia of the scene.
    fn direction<T>(
        &self,
        vectors: &Vectors,
        x: &[f64],
        work: impl FnOnce(&Direction<'_>) -> T,
    ) -> Option<T> {
        let description = self.description();
        let shared = description.inertia.as_ref()?;
        let direction = Direction {
            shared,
            inputs: description.columns(),
            evaluate: &|kernel, x, y, out| self.evaluate(kernel, x, y, out),
            vectors,
            x,
        };
        Some(work(&direction))
    }

    pub(crate) fn rows_jacobian(&self, rows: &Rows, x: &[f64], values: &mut [f64]) {
        let kernel = rows.kernels[0];
        self.evaluate(kernel, x, &[], values);
        let Some(solved) = &rows.solved else { return };
        let first = self.description().kernels[kernel].outputs.len();
        let below = (&rows.jacobian.entries[first..], solved.formulas);
        let values = &mut values[first..];
        match &solved.by {
            Solver::Inertia(vectors) => {
                self.direction(vectors, x, |own| own.jacobian(below, values));
            }
            &Solver::System(system) => {
                Scratch::lend(|scratch| {
                    self.differentiate(scratch, system, x);
                    scratch.solution.gather(below.0, below.1, values);
                });
            }
        }
    }

    pub(crate) fn rows_hessian(
        &self,
        rows: &Rows,
        x: &[f64],
        multipliers: &[f64],
        values: &mut [f64],
    ) {
        let kernel = rows.kernels[1];
        let Some(solved) = &rows.solved else {
            return self.evaluate(kernel, x, multipliers, values);
        };
        let weights = &multipliers[solved.formulas..];
        let places = &rows.hessian.entries[..];
        match &solved.by {
            Solver::Inertia(vectors) => {
                self.direction(vectors, x, |own| own.hessian(weights, places, values));
            }
            &Solver::System(system) => {
                Scratch::lend(|scratch| {
                    self.second(scratch, (system, weights), x, (places, values));
                });
            }
        }
        Scratch::lend(|scratch| {
            let geometry = self.values(scratch, kernel, (x, multipliers));
            for (&place, value) in solved.places.iter().zip(&geometry) {
                values[place] += value;
            }
            scratch.values = geometry;
        });
    }

    pub(crate) fn contact_of(&self, contact: usize) -> Option<&Contact> {
        self.description().contacts.get(contact)
    }

    pub(crate) fn friction_of(&self, contact: usize) -> Option<&Friction> {
        self.contact_of(contact)?.friction.as_ref()
    }

    /// The kernels of what parameters decide that are coordinates, if there are any.
    pub(crate) fn given(&self) -> Option<[usize; 3]> {
        self.description().held.as_ref()?.functions.kernels
    }

    /// The kernel at one place of functions of optimal control, if there are any.
    pub(crate) fn function(
        &self,
        of: fn(&OptimalControl) -> &Functions,
        place: usize,
    ) -> Option<usize> {
        let task = self.description().optimal_control.as_ref()?;
        of(task).kernels.map(|kernels| kernels[place])
    }

    /// The scene at these values, derived once more unless that was done before.
    ///
    /// # Errors
    /// The first mistake, or that it is too large.
    pub(crate) fn derived_again(&self, again: Again, parameters: &[usize]) -> Result<Self, String> {
        let shared = match self.known_again(again, parameters) {
            Some(shared) => shared,
            None => {
                let text = self.shared.text.as_str();
                let description = again::derived(self.description(), text, (again, parameters))?;
                let derived = Self::new(description, text, String::new());
                let shared = derived.map_err(|_| TOO_LARGE.to_owned())?.shared;
                if let Ok(mut known) = self.shared.again.lock() {
                    known.push((again, parameters.to_vec(), Arc::clone(&shared)));
                }
                shared
            }
        };
        let mut derived = Self {
            parameters: self.parameters.clone(),
            folded: Vec::new(),
            experiment: self.experiment,
            shared,
        };
        derived.fold();
        Ok(derived)
    }

    fn known_again(&self, again: Again, parameters: &[usize]) -> Option<Arc<Shared>> {
        let known = self.shared.again.lock().ok()?;
        let mut known = known.iter();
        let (_, _, shared) = known.find(|(kind, of, _)| *kind == again && of == parameters)?;
        Some(Arc::clone(shared))
    }
}

/// Why a scene with unknown parameters is refused.
const TOO_LARGE: &str = "a function derived with parameters as unknowns has too many values; split the mechanism into smaller scenes";
