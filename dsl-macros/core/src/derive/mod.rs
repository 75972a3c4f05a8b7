//! Checked scene to equations of motion, contact quantities and their derivatives.
//!
//! With `L(q, v, t)` the Lagrangian and `Q` the generalized forces,
//!
//! ```text
//! M = d2L/dv2          r = dL/dq + Q - (d2L/dv dq) v - d2L/dv dt          M a = r
//! ```
//!
//! A state of first order, `z' = f`, is the velocity of a coordinate of unit mass that nothing reads, and `f` the force on it: a
//! row `1 z' = f` that no other one is coupled to by the mass matrix.

mod alike;
mod bias;
mod contact;
mod contact_equations;
mod contacts;
mod control;
mod explicit;
mod failure;
mod held;
mod implicit;
mod joint;
mod joint_row;
mod ldl;
mod loaded;
mod residual;
mod shared;
mod simplify;
mod stepwise;

pub(crate) use alike::Names;
pub(crate) use contact_equations::{ContactEquations, FrictionEquations, InverseInertia};
pub(crate) use contacts::{Contacts, Derived};
pub(crate) use control::{ControlEquations, resets};
pub(crate) use explicit::{Explicit, Sparse, jacobian};
pub(crate) use failure::Failure;
pub(crate) use held::{at_declared_start, given, with_held};
pub(crate) use implicit::{Implicit, WRITTEN_OUT};
pub(crate) use joint::JointEquations;
pub(crate) use shared::{Columns, Directed, SharedInertia};
pub(crate) use simplify::simplify;

use crate::graph::{self, Stage, Sym, Variable};
use crate::scene::{CheckedScene, OptimalControl};
use crate::tape;
use ldl::Factorization;
use simplify::simplify_equation;

/// Largest number of coordinates whose acceleration is simplified as one formula; above, formulas
/// through the inverse of the mass matrix explode.
const EXPLICIT: usize = 4;

/// Fewest operations of a right-hand side for which the second way of deriving it is tried.
const SHORT_MOTION: usize = 20;

/// What the second way has to save, one of so many parts: derivatives of a form that is a little shorter may be longer.
const MUCH: usize = 4;

/// A vector-valued function of the inputs.
pub(crate) enum Solution {
    /// As formulas.
    Explicit(Explicit),
    /// As the solution of a linear system.
    Implicit(Implicit),
}

/// Everything derived from a scene.
pub(crate) struct Equations {
    /// What all functions are differentiated by: the input vector `x`, and parameters where that was asked for.
    pub(crate) inputs: Vec<Variable>,
    /// Mass matrix, row-major.
    pub(crate) mass: Vec<Sym>,
    /// `r` of `M a = r`.
    pub(crate) right: Vec<Sym>,
    /// Whether acceleration and contact directions are formulas that a person can read.
    pub(crate) readable: bool,
    /// Kinetic and potential energy.
    pub(crate) energy: [Sym; 2],
    pub(crate) acceleration: Solution,
    pub(crate) contacts: Contacts,
    /// The inertia that directions of contacts are solved for with; `None` where those are formulas.
    pub(crate) inertia: Option<SharedInertia>,
    /// None without joints.
    pub(crate) joints: Option<JointEquations>,
    pub(crate) optimal_control: Option<ControlEquations>,
}

/// Derives all equations of a scene.
pub(crate) fn equations(scene: &CheckedScene) -> Result<Equations, Failure> {
    let (n, inputs) = (scene.coordinates.len(), inputs(scene));
    let velocities = &inputs[n..2 * n];
    graph::begin(Stage::Inertia);
    let (momenta, energy) = momenta_and_energy(scene, velocities);
    let moving = held::moving(scene);
    let Motion {
        momenta,
        mass,
        applied,
        right,
        in_steps,
    } = motion_of(scene, momenta, &inputs, moving)?;
    graph::begin(Stage::Motion);
    let joints = joint_row::rows(scene);
    let all: Vec<usize> = (0..n).collect();
    let by_entries = !in_steps && implicit::is_simpler_than(&mass, &momenta);
    let inertia = implicit::Locked {
        mass: &mass,
        momenta: &momenta,
        by_entries,
        in_steps,
        coordinates: &all,
        held: &[],
        joints: &joints,
    };
    let (formulas, stepwise) = factors(&inertia, n)?;
    let order = inertia.size();
    let singular = |coordinate| Failure::SingularMass { coordinate };
    let written_out = stepwise.as_ref().filter(|_| order <= WRITTEN_OUT);
    let motion = || {
        implicit::motion(
            &inertia,
            right.clone(),
            stepwise.as_ref(),
            (&applied, moving),
            &inputs,
        )
    };
    let acceleration = accelerated(motion, (&formulas, written_out), &right, &inputs);
    let forces = joint::equations(scene, &inertia, (stepwise.as_ref(), &right), &inputs);
    let formulas = formulas.map(|factorization| contact::Inertia::whole(factorization, n));
    let mechanism = contact::Mechanism {
        inertia,
        all: n,
        formulas: formulas.as_ref(),
        written_out,
        moving,
        inputs: &inputs,
    };
    let contacts = loaded::contacts(&mechanism, &scene.contacts, (&inertia, &right))?;
    graph::begin(Stage::Motion);
    let shared = contacts.own().any(ContactEquations::shares_inertia);
    let shared = shared.then(|| SharedInertia::new(&inertia, &inputs));
    graph::begin(Stage::OptimalControl);
    let joint_forces = || joint::forces(&inertia, &right, &contacts, &scene.contacts);
    let task = scene.optimal_control.clone();
    let task = task.map(|task| with_joint_forces(task, || joint_forces().map_err(singular)));
    let optimal_control = task
        .map(|task| control::equations(&task?, scene, &contacts, &mechanism))
        .transpose()?;
    Ok(Equations {
        inputs,
        right,
        readable: n <= EXPLICIT && joints.is_empty(),
        mass,
        energy,
        acceleration,
        contacts,
        inertia: shared,
        joints: forces,
        optimal_control,
    })
}

/// The inertia by factors: of few coordinates as formulas, of more with every intermediate result as one quantity.
fn factors(
    inertia: &implicit::Locked<'_>,
    n: usize,
) -> Result<(Option<Factorization>, Option<Factorization>), Failure> {
    let singular = |coordinate| Failure::SingularMass { coordinate };
    let formulas = (n <= EXPLICIT && inertia.joints.is_empty())
        .then(|| Factorization::of(inertia.mass, n))
        .transpose()
        .map_err(singular)?;
    let stepwise = inertia.cheaply_factorized().map_err(singular)?;
    Ok((formulas, stepwise))
}

/// The acceleration, of a `motion` with this right-hand side, by formulas or by factors where there are such.
fn accelerated(
    motion: impl Fn() -> Implicit,
    (formulas, written_out): (&Option<Factorization>, Option<&Factorization>),
    right: &[Sym],
    inputs: &[Variable],
) -> Solution {
    let weights: Vec<Sym> = (0..right.len()).map(Implicit::multiplier).collect();
    let by_elimination =
        |factors: &Factorization| residual::derivatives(&motion(), factors, &weights, inputs);
    match (formulas, written_out) {
        (Some(formulas), Some(factors)) => {
            let values = formulas.solve(right);
            let written_out = || by_elimination(factors);
            Solution::Explicit(Explicit::cheapest(values, written_out, inputs))
        }
        (None, Some(factors)) => Solution::Explicit(by_elimination(factors)),
        (_, None) => Solution::Implicit(motion()),
    }
}

/// What the motion without contact is made of.
struct Motion {
    momenta: Vec<Sym>,
    /// Mass matrix, row-major.
    mass: Vec<Sym>,
    /// What acts on each coordinate, `dL/dq + Q`.
    applied: Vec<Sym>,
    /// `r` of `M a = r`.
    right: Vec<Sym>,
    /// Whether all that is evaluated in steps.
    in_steps: bool,
}

/// The motion by its formulas, or by an evaluation in steps where that is much shorter.
fn motion_of(
    scene: &CheckedScene,
    momenta: Vec<Sym>,
    inputs: &[Variable],
    moving: usize,
) -> Result<Motion, Failure> {
    let n = momenta.len();
    let (coordinates, velocities) = (&inputs[..n], &inputs[n..2 * n]);
    if n > WRITTEN_OUT
        && let Some(motion) = motion_in_steps(scene, &momenta, inputs, moving)
    {
        return motion;
    }
    let mass = mass_matrix(&momenta, velocities)?;
    graph::begin(Stage::Forces);
    let mut conservative = graph::gradient(scene.lagrangian, coordinates);
    conservative[moving..].fill(Sym::ZERO);
    let bias = bias::Bias {
        lagrangian: scene.lagrangian,
        momenta: &momenta,
        mass: &mass,
        moving,
    };
    Ok(Motion {
        applied: sums(&conservative, &scene.forces),
        right: right_hand_side(&bias, &conservative, &scene.forces),
        momenta,
        mass,
        in_steps: false,
    })
}

/// The motion by an evaluation in steps, if that is worth it.
fn motion_in_steps(
    scene: &CheckedScene,
    momenta: &[Sym],
    inputs: &[Variable],
    moving: usize,
) -> Option<Result<Motion, Failure>> {
    let (n, mechanical) = (momenta.len(), scene.mechanical());
    let (coordinates, velocities) = (&inputs[..n], &inputs[n..2 * n]);
    let (own, states) = momenta.split_at(mechanical);
    let mut evaluation = stepwise::evaluation(scene.lagrangian, own, &velocities[..mechanical])?;
    evaluation.momenta.extend_from_slice(states);
    let mut conservative = graph::stepwise::gradient(evaluation.lagrangian, coordinates);
    conservative[moving..].fill(Sym::ZERO);
    let applied = sums(&conservative, &scene.forces);
    if !evaluation.is_worth_it(&applied, moving, inputs) {
        return None;
    }
    let sweeps = graph::stepwise::sweeps(&evaluation.momenta);
    let transport = sweeps.directional(held::along_motion(moving));
    let pairs = applied.iter().zip(transport);
    let right = pairs.map(|(&acts, transport)| acts - transport).collect();
    let column = |velocity| sweeps.partial(velocity);
    let mass = entries_of_mass(velocities, column, |entry| entry);
    Some(mass.map(|mass| Motion {
        momenta: evaluation.momenta,
        mass,
        applied,
        right,
        in_steps: true,
    }))
}

/// The task with the forces of joints that it reads as formulas.
fn with_joint_forces(
    task: OptimalControl,
    forces: impl FnOnce() -> Result<Vec<Sym>, Failure>,
) -> Result<OptimalControl, Failure> {
    let of_joint = |variable| matches!(variable, Variable::JointForce(_));
    let running = task.running_cost.into_iter();
    let mut read = running.chain(task.constraints.iter().map(|known| known.function));
    if !read.any(|function| graph::depends_on(function, of_joint)) {
        return Ok(task);
    }
    let (forces, mut task) = (forces()?, task);
    task.map_functions(|value| {
        graph::substitute(&[value], |variable| match variable {
            Variable::JointForce(i) => forces.get(usize::from(i)).copied(),
            _ => None,
        })[0]
    });
    Ok(task)
}

/// Momenta of all coordinates, and the energies.
fn momenta_and_energy(scene: &CheckedScene, velocities: &[Variable]) -> (Vec<Sym>, [Sym; 2]) {
    let (lagrangian, mechanical) = (scene.lagrangian, scene.mechanical());
    let mut momenta = graph::gradient(lagrangian, &velocities[..mechanical]);
    let energy = energy(lagrangian, &momenta, &velocities[..mechanical]);
    // A state is the velocity of a coordinate of unit mass.
    let states = &velocities[mechanical..];
    momenta.extend(states.iter().copied().map(Sym::variable));
    (momenta, energy)
}

/// The sums of the components of two vectors.
fn sums(one: &[Sym], other: &[Sym]) -> Vec<Sym> {
    let pairs = one.iter().zip(other);
    pairs.map(|(&one, &other)| one + other).collect()
}

/// `r` by the momenta, or by the entries of the mass matrix where that takes far fewer operations.
fn right_hand_side(bias: &bias::Bias<'_>, conservative: &[Sym], forces: &[Sym]) -> Vec<Sym> {
    let transport = graph::directional(bias.momenta, held::along_motion(bias.moving));
    let with_forces = |inertial: Vec<Sym>| -> Vec<Sym> {
        let pairs = inertial.into_iter().zip(forces);
        // Each part by itself: the terms of both rarely cancel, and long sums are not simplified.
        pairs
            .map(|(inertial, &force)| simplify(inertial + simplify_equation(force)))
            .collect()
    };
    let pairs = conservative.iter().zip(&transport);
    let by_momenta = pairs.map(|(&acts, &transport)| simplify_equation(acts - transport));
    let by_momenta = with_forces(by_momenta.collect());
    if tape::operations(&by_momenta) < SHORT_MOTION {
        return by_momenta;
    }
    let by_entries = with_forces(bias.forces().into_iter().map(simplify_equation).collect());
    if MUCH * tape::operations(&by_entries) <= (MUCH - 1) * tape::operations(&by_momenta) {
        by_entries
    } else {
        by_momenta
    }
}

/// The input vector `(q, v, u[, t])`, and behind it the parameters by which all is differentiated.
fn inputs(scene: &CheckedScene) -> Vec<Variable> {
    let n = scene.coordinates.len() as u16;
    let controls = scene.controls.len() as u16;
    let mut inputs: Vec<Variable> = (0..n).map(Variable::Coordinate).collect();
    inputs.extend((0..n).map(Variable::Velocity));
    inputs.extend((0..controls).map(Variable::Control));
    if scene.explicit_time {
        inputs.push(Variable::Time);
    }
    inputs.extend(
        scene
            .differentiated
            .iter()
            .copied()
            .map(Variable::Parameter),
    );
    inputs
}

/// `d2L/dv2`, row-major, from the momenta; every coordinate has inertia.
fn mass_matrix(momenta: &[Sym], velocities: &[Variable]) -> Result<Vec<Sym>, Failure> {
    let column = |velocity| graph::partial(momenta, velocity);
    entries_of_mass(velocities, column, simplify_equation)
}

/// The mass matrix, row-major, from its columns; `simple` is the form of an entry.
fn entries_of_mass(
    velocities: &[Variable],
    column: impl Fn(Variable) -> Vec<Sym>,
    simple: fn(Sym) -> Sym,
) -> Result<Vec<Sym>, Failure> {
    let n = velocities.len();
    let mut mass = vec![Sym::ZERO; n * n];
    for (j, &velocity) in velocities.iter().enumerate() {
        for (i, entry) in column(velocity).into_iter().enumerate() {
            // Lower and upper entries are the same formula, whatever form the sweeps gave them.
            if i >= j {
                let entry = simple(entry);
                (mass[i * n + j], mass[j * n + i]) = (entry, entry);
            }
        }
    }
    let mut rows = mass.chunks(n);
    match rows.position(|row| row.iter().all(|entry| entry.is_structural_zero())) {
        Some(coordinate) => Err(Failure::SingularMass { coordinate }),
        None => Ok(mass),
    }
}

/// `v' dL/dv - L` split into the part that vanishes at rest and the rest.
fn energy(lagrangian: Sym, momenta: &[Sym], velocities: &[Variable]) -> [Sym; 2] {
    let at_rest = |values: &[Sym]| {
        graph::substitute(values, |variable| {
            velocities.contains(&variable).then_some(Sym::ZERO)
        })
    };
    let rest = at_rest(&[lagrangian])[0];
    // Without terms linear in the velocities, the kinetic energy is what the Lagrangian says.
    let quadratic = at_rest(momenta)
        .into_iter()
        .all(|momentum| simplify(momentum).is_structural_zero());
    let kinetic = if quadratic {
        lagrangian - rest
    } else {
        let power: Sym = momenta
            .iter()
            .zip(velocities)
            .map(|(&momentum, &velocity)| momentum * Sym::variable(velocity))
            .sum();
        power - lagrangian + rest
    };
    [simplify(kinetic), -rest]
}
