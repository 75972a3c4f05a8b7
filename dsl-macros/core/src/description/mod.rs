//! A derived scene as data: what it declares, its functions as straight-line operations, and how the methods of the
//! model trait are made of them. Solvers read the first and last of it alike of a scene from a file, whose functions are
//! evaluated as they stand, and of a compiled one, whose functions are emitted as Rust.

mod builder;
mod contact;
mod contacts;
mod declared;
mod design;
mod equations;
mod explicit;
mod joint;
mod kernel;
mod measured;
mod optimal_control;
mod readable;
mod renamed;
mod sensitivity;
mod shown;

pub use crate::graph::{Function, Function2, Profile, Spline, inverse_root, piecewise, root};
pub use builder::{Inertia, Places, System, Vectors};
pub use contact::{Contact, Friction, Rows, SolvedRows, Solver};
pub use design::{FreeParameters, Held};
pub use explicit::ExplicitFunction;
pub use joint::Joints;
pub use kernel::{Kernel, Operation, Source};
pub use optimal_control::{Kernels, OptimalControl};
pub(crate) use readable::formula;
pub use sensitivity::{ContactSensitivity, Derivative, FrictionSensitivity, Sensitivity};
pub use shown::Outputs;

use crate::declaration::{
    Declaration, Epigraph, Equation, Experiment, Picture, SparsityPattern, list, text,
};
use crate::derive::{Equations, Explicit, Solution};
use crate::graph::{self, Stage, Sym};
use crate::scene::CheckedScene;
use builder::Builder;
use declared::{parameter, variables};

/// Most operations of one kernel that is compiled: some seconds of compile time.
pub(crate) const BUDGET: usize = 60_000;

/// Everything that is derived from a declaration.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// What is declared, and what is made of the functions.
    pub structure: Structure,
    /// All straight-line functions, which the structure names by their index.
    pub kernels: Vec<Kernel>,
}

/// What a scene declares, and how what solvers ask of it is made of its kernels, which are named by their index. All of it is static
/// data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Structure {
    /// Names, units, patterns.
    pub declaration: Declaration,
    /// Start, horizon and bounds.
    pub given: Given,
    /// The free motion.
    pub motion: Motion,
    /// The inertia that directions of contacts are solved for with; `None` where all of them are formulas.
    pub inertia: Option<Inertia>,
    /// Contacts in order of declaration.
    pub contacts: &'static [Contact],
    /// Joints, if there are any.
    pub joints: Option<Joints>,
    /// What is declared for optimal control, if anything is.
    pub optimal_control: Option<OptimalControl>,
    /// What is recorded, if anything is.
    pub outputs: Option<Outputs>,
    /// What is drawn, if it is declared, and the kernel of all its values.
    pub picture: Option<(Picture, usize)>,
    /// Derivatives by parameters; none unless they were asked for. With them, every Jacobian has a column for each of these
    /// parameters behind those of the inputs, and Hessians are empty.
    pub sensitivity: Option<Sensitivity>,
    /// The parameters that optimal control is to find, if there are any.
    pub free_parameters: Option<FreeParameters>,
    /// Measured motions that the objective compares with.
    pub experiments: &'static [Experiment],
    /// Kernels of the initial coordinates and velocities of those that have a start of their own.
    pub starts: &'static [Option<(usize, usize)>],
    /// Components of the start `(q, v)` that are to be found and that functions of optimal control read, increasing.
    pub remembered: &'static [usize],
    /// Largest values that optimal control has as unknowns; where the parameters are held, none.
    pub epigraphs: &'static [Epigraph],
    /// The parameters that are coordinates without motion; none unless they were asked for.
    pub held: Option<Held>,
    /// All linear systems.
    pub systems: &'static [System],
}

/// Kernels of what is declared in terms of the parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Given {
    /// Initial coordinates and velocities.
    pub start: (usize, usize),
    /// Lower and upper bounds of the coordinates and then the controls; infinite where none is declared.
    pub bounds: (usize, usize),
    /// Length of a simulation, if it is declared.
    pub horizon: Option<usize>,
    /// Numbers that are above zero, if there are any, and what each is, with its unit.
    pub positive: Option<(usize, &'static [(&'static str, &'static str)])>,
}

/// Kernels of the motion without contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Kernel of the acceleration; without one, it is the solution of the system.
    pub acceleration: Option<usize>,
    /// Where its derivatives come from.
    pub derivatives: MotionDerivatives,
    /// Kernel of the mass matrix, row-major.
    pub mass_matrix: usize,
    /// Kernel of kinetic and potential energy.
    pub energy: usize,
}

/// How the acceleration is differentiated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionDerivatives {
    /// By the kernels of its Jacobian and its Hessian.
    Kernels(usize, usize),
    /// As the solution of this linear system.
    Solved(usize),
}

/// Why a scene is refused after all has been derived.
pub(crate) enum Unfit {
    /// A kernel has too many operations to be compiled in reasonable time.
    Long { kernel: String, operations: usize },
    /// Ordering the operations takes too much work.
    Exhausted,
    /// A constant in a kernel is not finite.
    Constant,
}

impl Description {
    /// The description of a scene with these equations, whose kernels may have so many operations.
    pub(crate) fn of(
        scene: &CheckedScene,
        equations: &Equations,
        most: usize,
    ) -> Result<Self, Unfit> {
        graph::begin(Stage::Kernels);
        let inertia = equations.inertia.as_ref();
        let mut builder = Builder::new(scene, equations.inputs.len(), inertia);
        let (motion, [free_jacobian, free_hessian]) = motion(&mut builder, equations);
        let inertia = builder.inertia();
        let (declared_contacts, contacts) = contacts::contacts(&mut builder, equations);
        let joints = equations.joints.as_ref();
        let joints = joints.map(|derived| joint::joints(&mut builder, derived));
        let task = scene.optimal_control.as_ref();
        let task = task.zip(equations.optimal_control.as_ref());
        let task = task.map(|(declared, derived)| {
            optimal_control::optimal_control(&mut builder, declared, derived)
        });
        let outputs = shown::outputs(&mut builder);
        let picture = shown::picture(&mut builder);
        let given = given(&mut builder);
        let sensitivity = sensitivity::sensitivity(&mut builder, equations);
        let free_parameters = design::free(&mut builder);
        let (experiments, starts) = measured::experiments(&mut builder);
        let held = design::held(&mut builder, equations);
        let (kernels, systems) = (builder.kernels, list(builder.systems));
        check(&kernels, most)?;
        let declaration =
            Declaration {
                name: text(&scene.name.text),
                documentation: text(&scene.documentation),
                parameters: list(scene.parameters.iter().map(parameter)),
                coordinates: variables(&scene.coordinates),
                controls: variables(&scene.controls),
                states: variables(&scene.states),
                contacts: list(declared_contacts),
                joints: joints.map(|(declared, _)| declared),
                explicit_time: scene.explicit_time,
                free_jacobian,
                free_hessian,
                optimal_control: task.map(|(declared, _)| declared),
                kernels: list(
                    kernels
                        .iter()
                        .filter(|known| known.listed)
                        .map(Kernel::declared),
                ),
                equations: list(equations::readable(scene, equations).iter().map(
                    |[left, right]| Equation {
                        left: text(left),
                        right: text(right),
                    },
                )),
            };
        let structure = Structure {
            declaration,
            given,
            motion,
            inertia,
            contacts: list(contacts),
            joints: joints.map(|(_, kernels)| kernels),
            optimal_control: task.map(|(_, kernels)| kernels),
            outputs,
            picture,
            sensitivity,
            free_parameters,
            experiments,
            starts,
            remembered: list(scene.remembered.iter().copied()),
            epigraphs: design::epigraphs(scene),
            held,
            systems,
        };
        Ok(Self { structure, kernels })
    }

    /// All explicit functions with their operations.
    #[must_use]
    pub fn explicit_functions(&self) -> Vec<(ExplicitFunction, Kernel)> {
        let Structure {
            declaration,
            motion,
            systems,
            contacts,
            ..
        } = &self.structure;
        let motion = match (motion.acceleration, motion.derivatives) {
            (None, MotionDerivatives::Solved(system)) => systems[system].solve,
            (kernel, _) => kernel.unwrap_or_default(),
        };
        let (kernels, n) = (&self.kernels[..], declaration.coordinates.len());
        let motion = (ExplicitFunction::Motion, kernels[motion].clone());
        let contacts = contacts.iter().enumerate().flat_map(|(i, contact)| {
            let dry = declaration.contacts[i].dry;
            explicit::of_contact(kernels, n, (i, dry, contact))
        });
        std::iter::once(motion).chain(contacts).collect()
    }

    /// The functions that are evaluated again and again.
    pub fn listed(&self) -> impl Iterator<Item = &Kernel> {
        self.kernels.iter().filter(|kernel| kernel.listed)
    }
}

/// Whether all kernels can be evaluated, and have no more operations than allowed.
fn check(kernels: &[Kernel], most: usize) -> Result<(), Unfit> {
    if graph::is_exhausted() {
        return Err(Unfit::Exhausted);
    }
    for kernel in kernels {
        let operations = kernel.cost();
        if operations > most {
            return Err(Unfit::Long {
                kernel: kernel.name.clone(),
                operations,
            });
        }
        // Bounds, which are not listed, may be open.
        if kernel.listed && !kernel.is_finite() {
            return Err(Unfit::Constant);
        }
    }
    Ok(())
}

impl Structure {
    /// Number of columns of the Jacobians: the inputs, and the parameters by which all is differentiated.
    #[must_use]
    pub const fn columns(&self) -> usize {
        let parameters = match self.sensitivity {
            Some(known) => known.parameters.len(),
            None => 0,
        };
        self.declaration.inputs() + parameters
    }

    /// Number of the equations of all joints.
    #[must_use]
    pub fn joint_rows(&self) -> usize {
        self.declaration.joints.map_or(0, |joints| joints.rows())
    }
}

fn motion(builder: &mut Builder<'_>, equations: &Equations) -> (Motion, [SparsityPattern; 2]) {
    let (acceleration, derivatives, patterns) = match &equations.acceleration {
        Solution::Explicit(Explicit {
            values,
            jacobian,
            hessian,
        }) => {
            let acceleration = builder.kernel("free_acceleration", values);
            let derivatives = MotionDerivatives::Kernels(
                builder.kernel("free_jacobian", &jacobian.values),
                builder.kernel("free_hessian", &hessian.values),
            );
            let patterns = [builder::pattern(jacobian), builder::pattern(hessian)];
            (Some(acceleration), derivatives, patterns)
        }
        Solution::Implicit(implicit) => {
            let solution = implicit.solution.as_ref();
            let n = builder.scene.coordinates.len();
            // Behind the accelerations stand forces of joints.
            let acceleration =
                solution.map(|solution| builder.kernel("free_acceleration", &solution[..n]));
            let derivatives = MotionDerivatives::Solved(builder.system("motion", implicit));
            let pattern = |rows, entries: &[(usize, usize)]| SparsityPattern {
                rows,
                columns: builder.inputs,
                entries: builder::places(entries),
            };
            let patterns = [
                pattern(n, &implicit.jacobian_pattern(n)),
                pattern(builder.inputs, &implicit.hessian_pattern()),
            ];
            (acceleration, derivatives, patterns)
        }
    };
    let motion = Motion {
        acceleration,
        derivatives,
        mass_matrix: builder.of_motion("mass_matrix", &equations.mass),
        energy: builder.kernel("energy", &equations.energy),
    };
    (motion, patterns)
}

fn given(builder: &mut Builder<'_>) -> Given {
    let scene = builder.scene;
    let bounded = scene.coordinates.iter().chain(&scene.controls);
    let horizon = scene.horizon;
    let horizon = horizon.map(|horizon| builder.unlisted("horizon", &[horizon]));
    let positive: Vec<Sym> = scene.positive.iter().map(|known| known.value).collect();
    let named = scene.positive.iter();
    let named = named.map(|known| (text(&known.what), declared::inferred(known.unit)));
    Given {
        horizon,
        positive: (!positive.is_empty())
            .then(|| (builder.unlisted("positive", &positive), list(named))),
        start: (
            builder.unlisted("start_coordinates", &scene.start.0),
            builder.unlisted("start_velocities", &scene.start.1),
        ),
        bounds: builder.bounds(
            ["lower_bounds", "upper_bounds"],
            bounded.map(|quantity| quantity.bounds),
        ),
    }
}
