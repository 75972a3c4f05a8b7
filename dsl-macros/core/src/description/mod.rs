//! A derived scene as data: what it declares, its functions as straight-line operations, and how the methods of the
//! model trait are made of them. The emitted Rust is written from it, and whatever evaluates a scene without a
//! compiler reads it.

mod builder;
mod contact;
mod declared;
mod design;
mod equations;
mod joint;
mod kernel;
mod measured;
mod optimal_control;
mod readable;
mod renamed;
mod sensitivity;
mod shown;

pub use crate::derive::Given as GivenBy;
pub use crate::graph::{Function, Function2, Profile};
pub use crate::scene::Measured;
pub use builder::{Inertia, Pattern, System, Vectors};
pub use contact::{Contact, Friction, Rows, SolvedRows, Solver};
pub(crate) use declared::text as documentation_text;
pub use declared::{Parameter, Variable};
pub use design::{FreeParameters, Held};
pub use joint::{Joint, Joints};
pub use kernel::{Kernel, Operation};
pub use measured::{Experiment, MeasuredQuantity};
pub use optimal_control::{Condition, ContactTerms, Functions, OptimalControl};
pub(crate) use readable::formula;
pub use sensitivity::{ContactSensitivity, Derivative, FrictionSensitivity, Sensitivity};
pub use shown::{Outputs, Picture, Shape};

use crate::derive::{Equations, Explicit, Solution};
use crate::graph::{self, Stage, Sym};
use crate::scene::CheckedScene;
use builder::Builder;
use declared::text;

/// Most operations of one kernel: some seconds of compile time.
pub(crate) const BUDGET: usize = 60_000;

// Many fields: the parts of a declaration.
/// Everything that is derived from a declaration. Kernels and systems are named by their index.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// Name of the scene, as written.
    pub name: String,
    /// Documentation, as written.
    pub documentation: String,
    /// Parameters in order of declaration.
    pub parameters: Vec<Parameter>,
    /// Coordinates in order of declaration, and behind them one for each state, whose velocity the state is.
    pub coordinates: Vec<Variable>,
    /// Controls in order of declaration.
    pub controls: Vec<Variable>,
    /// States of first order, in order of declaration.
    pub states: Vec<Variable>,
    /// Whether the physical time is the last component of the input vector.
    pub explicit_time: bool,
    /// The derived equations, left and right sides, as a person would write them.
    pub equations: Vec<[String; 2]>,
    /// Start, horizon and bounds.
    pub given: Given,
    /// The free motion.
    pub motion: Motion,
    /// The inertia that directions of contacts are solved for with; none where all of them are formulas.
    pub inertia: Option<Inertia>,
    /// Contacts in order of declaration.
    pub contacts: Vec<Contact>,
    /// Joints, if there are any.
    pub joints: Option<Joints>,
    /// What is declared for optimal control, if anything is.
    pub optimal_control: Option<OptimalControl>,
    /// What is recorded, if anything is.
    pub outputs: Option<Outputs>,
    /// What is drawn, if it is declared.
    pub picture: Option<Picture>,
    /// Derivatives by parameters; none unless they were asked for. With them, every Jacobian has a column for each of these
    /// parameters behind those of the inputs, and Hessians are empty.
    pub sensitivity: Option<Sensitivity>,
    /// The parameters that optimal control is to find, if there are any.
    pub free_parameters: Option<FreeParameters>,
    /// Measured motions that the objective compares with.
    pub experiments: Vec<Experiment>,
    /// Components of the start `(q, v)` that are to be found and that functions of optimal control read, increasing.
    pub remembered: Vec<usize>,
    /// The parameters that are coordinates without motion; none unless they were asked for.
    pub held: Option<Held>,
    /// All straight-line functions.
    pub kernels: Vec<Kernel>,
    /// All linear systems.
    pub systems: Vec<System>,
}

/// Kernels of what is declared in terms of the parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Given {
    /// Initial coordinates and velocities.
    pub start: [usize; 2],
    /// Lower and upper bounds of the coordinates and then the controls; infinite where none is declared.
    pub bounds: [usize; 2],
    /// Length of a simulation, if it is declared.
    pub horizon: Option<usize>,
}

/// Kernels of the motion without contact.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Kernel of the acceleration; without one, it is the solution of the system.
    pub acceleration: Option<usize>,
    /// Where its derivatives come from.
    pub derivatives: MotionDerivatives,
    /// Pattern of the Jacobian of the acceleration.
    pub jacobian: Pattern,
    /// Pattern (lower triangle) of the Hessian of the weighted acceleration.
    pub hessian: Pattern,
    /// Kernel of the mass matrix, row-major.
    pub mass_matrix: usize,
    /// Kernel of kinetic and potential energy.
    pub energy: usize,
}

/// How the acceleration is differentiated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionDerivatives {
    /// By the kernels of its Jacobian and its Hessian.
    Kernels([usize; 2]),
    /// As the solution of this linear system.
    System(usize),
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
    pub(crate) fn of(scene: &CheckedScene, equations: &Equations) -> Result<Self, Unfit> {
        graph::begin(Stage::Kernels);
        let inertia = equations.inertia.as_ref();
        let mut builder = Builder::new(scene, equations.inputs.len(), inertia);
        let motion = motion(&mut builder, equations);
        let inertia = builder.inertia();
        let contacts = scene
            .contacts
            .iter()
            .zip(&equations.contacts)
            .map(|(declared, contact)| contact::contact(&mut builder, declared, contact))
            .collect();
        let joints = equations.joints.as_ref();
        let joints = joints.map(|derived| joint::joints(&mut builder, derived));
        let optimal_control = scene
            .optimal_control
            .as_ref()
            .zip(equations.optimal_control.as_ref())
            .map(|(declared, derived)| {
                optimal_control::optimal_control(&mut builder, declared, derived)
            });
        let outputs = shown::outputs(&mut builder);
        let picture = shown::picture(&mut builder);
        let given = given(&mut builder);
        let sensitivity = sensitivity::sensitivity(&mut builder, equations);
        let free_parameters = design::free(&mut builder);
        let experiments = measured::experiments(&mut builder);
        let held = design::held(&mut builder, equations);
        let description = Self {
            name: scene.name.text.clone(),
            documentation: text(&scene.documentation),
            parameters: scene.parameters.iter().map(Parameter::of).collect(),
            coordinates: scene.coordinates.iter().map(Variable::of).collect(),
            controls: scene.controls.iter().map(Variable::of).collect(),
            states: scene.states.iter().map(Variable::of).collect(),
            explicit_time: scene.explicit_time,
            equations: Vec::new(),
            given,
            motion,
            inertia,
            contacts,
            joints,
            optimal_control,
            outputs,
            picture,
            sensitivity,
            free_parameters,
            experiments,
            remembered: scene.remembered.clone(),
            held,
            kernels: builder.kernels,
            systems: builder.systems,
        };
        description.check()?;
        Ok(Self {
            equations: equations::readable(scene, equations),
            ..description
        })
    }

    /// Whether all kernels can be compiled and evaluated.
    fn check(&self) -> Result<(), Unfit> {
        if graph::is_exhausted() {
            return Err(Unfit::Exhausted);
        }
        for kernel in &self.kernels {
            let operations = kernel.cost();
            if operations > BUDGET {
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

    /// The functions that are evaluated again and again.
    pub fn listed(&self) -> impl Iterator<Item = &Kernel> {
        self.kernels.iter().filter(|kernel| kernel.listed)
    }

    /// Length of the input vector: coordinates, velocities, controls and the time, where it occurs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        2 * self.coordinates.len() + self.controls.len() + usize::from(self.explicit_time)
    }

    /// Number of columns of the Jacobians: the inputs, and the parameters by which all is differentiated.
    #[must_use]
    pub fn columns(&self) -> usize {
        let parameters = self.sensitivity.as_ref();
        self.inputs() + parameters.map_or(0, |known| known.parameters.len())
    }
}

fn motion(builder: &mut Builder<'_>, equations: &Equations) -> Motion {
    let (acceleration, derivatives, jacobian, hessian) = match &equations.acceleration {
        Solution::Explicit(Explicit {
            values,
            jacobian,
            hessian,
        }) => {
            let acceleration = builder.kernel("free_acceleration", values);
            let derivatives = MotionDerivatives::Kernels([
                builder.kernel("free_jacobian", &jacobian.values),
                builder.kernel("free_hessian", &hessian.values),
            ]);
            let (jacobian, hessian) = (Pattern::of(jacobian), Pattern::of(hessian));
            (Some(acceleration), derivatives, jacobian, hessian)
        }
        Solution::Implicit(implicit) => {
            let solution = implicit.solution.as_ref();
            let n = builder.scene.coordinates.len();
            // Behind the accelerations stand forces of joints.
            let acceleration =
                solution.map(|solution| builder.kernel("free_acceleration", &solution[..n]));
            let system = builder.system("motion", implicit);
            let jacobian = Pattern {
                rows: n,
                columns: builder.inputs,
                entries: implicit.jacobian_pattern(n),
            };
            let hessian = Pattern {
                rows: builder.inputs,
                columns: builder.inputs,
                entries: implicit.hessian_pattern(),
            };
            let derivatives = MotionDerivatives::System(system);
            (acceleration, derivatives, jacobian, hessian)
        }
    };
    Motion {
        acceleration,
        derivatives,
        jacobian,
        hessian,
        mass_matrix: builder.of_motion("mass_matrix", &equations.mass),
        energy: builder.kernel("energy", &equations.energy),
    }
}

fn given(builder: &mut Builder<'_>) -> Given {
    let scene = builder.scene;
    let bound = |open: f64, pick: fn((Sym, Sym)) -> Sym| -> Vec<Sym> {
        let quantities = scene.coordinates.iter().chain(&scene.controls);
        quantities
            .map(|quantity| quantity.bounds.map_or(Sym::number(open), pick))
            .collect()
    };
    let horizon = scene.horizon;
    let horizon = horizon.map(|horizon| builder.unlisted("horizon", &[horizon]));
    Given {
        horizon,
        start: [
            builder.unlisted("start_coordinates", &scene.start.0),
            builder.unlisted("start_velocities", &scene.start.1),
        ],
        bounds: [
            builder.unlisted("lower_bounds", &bound(f64::NEG_INFINITY, |(low, _)| low)),
            builder.unlisted("upper_bounds", &bound(f64::INFINITY, |(_, high)| high)),
        ],
    }
}
