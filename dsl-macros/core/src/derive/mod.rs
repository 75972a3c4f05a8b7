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
mod contact;
mod contact_equations;
mod control;
mod explicit;
mod failure;
mod held;
mod implicit;
mod joint;
mod joint_row;
mod ldl;
mod residual;
mod simplify;

pub(crate) use contact_equations::{ContactEquations, FrictionEquations, InverseInertia};
pub(crate) use control::{ControlEquations, resets};
pub(crate) use explicit::{Explicit, Sparse, jacobian};
pub(crate) use failure::Failure;
pub use held::Given;
pub(crate) use held::{at_declared_start, given, with_held};
pub(crate) use implicit::{Implicit, WRITTEN_OUT};
pub(crate) use joint::JointEquations;
pub(crate) use simplify::simplify;

use crate::graph::{self, Sym, Variable};
use crate::scene::CheckedScene;
use ldl::Factorization;
use simplify::simplify_equation;

/// Largest number of coordinates whose acceleration is simplified as one formula; above, formulas
/// through the inverse of the mass matrix explode.
const EXPLICIT: usize = 4;

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
    pub(crate) contacts: Vec<ContactEquations>,
    /// None without joints.
    pub(crate) joints: Option<JointEquations>,
    pub(crate) optimal_control: Option<ControlEquations>,
}

/// Derives all equations of a scene.
pub(crate) fn equations(scene: &CheckedScene) -> Result<Equations, Failure> {
    let (n, inputs, lagrangian) = (scene.coordinates.len(), inputs(scene), scene.lagrangian);
    let (coordinates, velocities) = (&inputs[..n], &inputs[n..2 * n]);
    let (momenta, energy) = momenta_and_energy(scene, velocities);
    let mass = mass_matrix(&momenta, velocities)?;
    let moving = held::moving(scene);
    let mut conservative = graph::gradient(lagrangian, coordinates);
    conservative[moving..].fill(Sym::ZERO);
    let [applied, right] = right_hand_side(&momenta, &conservative, &scene.forces, moving);
    let joints = joint_row::rows(scene);
    let all: Vec<usize> = (0..n).collect();
    let inertia = implicit::Locked {
        mass: &mass,
        momenta: &momenta,
        coordinates: &all,
        held: &[],
        joints: &joints,
    };
    let order = inertia.size();
    let singular = |coordinate| Failure::SingularMass { coordinate };
    let formulas = (n <= EXPLICIT && joints.is_empty())
        .then(|| Factorization::of(&mass, n))
        .transpose()
        .map_err(singular)?;
    let stepwise = (order <= implicit::FORMULAS)
        .then(|| inertia.factorized())
        .transpose()
        .map_err(singular)?;
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
    let weights: Vec<Sym> = (0..n).map(Implicit::multiplier).collect();
    let by_elimination =
        |factors: &Factorization| residual::derivatives(&motion(), factors, &weights, &inputs);
    let acceleration = match (&formulas, written_out) {
        (Some(formulas), Some(factors)) => {
            let values = formulas.solve(&right);
            let written_out = || by_elimination(factors);
            Solution::Explicit(Explicit::cheapest(values, written_out, &inputs))
        }
        (None, Some(factors)) => Solution::Explicit(by_elimination(factors)),
        (_, None) => Solution::Implicit(motion()),
    };
    let forces = joint::equations(scene, &inertia, (stepwise.as_ref(), &right), &inputs);
    let formulas = formulas.map(|factorization| contact::Inertia::whole(factorization, n));
    let inertia = contact::Mechanism {
        mass: &mass,
        momenta: &momenta,
        coordinates: &all,
        all: n,
        joints: &joints,
        formulas: formulas.as_ref(),
        written_out,
        moving,
        inputs: &inputs,
    };
    let contacts = inertia.contacts(&scene.contacts)?;
    let optimal_control = scene.optimal_control.as_ref();
    let optimal_control = optimal_control
        .map(|task| control::equations(task, scene, &contacts, &inertia))
        .transpose()?;
    Ok(Equations {
        inputs,
        right,
        readable: n <= EXPLICIT && joints.is_empty(),
        mass,
        energy,
        acceleration,
        contacts,
        joints: forces,
        optimal_control,
    })
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

/// What acts on each coordinate, `dL/dq + Q`, and `r`.
fn right_hand_side(
    momenta: &[Sym],
    conservative: &[Sym],
    forces: &[Sym],
    moving: usize,
) -> [Vec<Sym>; 2] {
    let applied: Vec<Sym> = conservative
        .iter()
        .zip(forces)
        .map(|(&conservative, &force)| conservative + force)
        .collect();
    let transport = graph::directional(momenta, held::along_motion(moving));
    let right: Vec<Sym> = conservative
        .iter()
        .zip(&transport)
        .zip(forces)
        // Each part by itself: the terms of both rarely cancel, and long sums are not simplified.
        .map(|((&conservative, &transport), &force)| {
            simplify(simplify_equation(conservative - transport) + simplify_equation(force))
        })
        .collect();
    [applied, right]
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
    let n = velocities.len();
    let mut mass = vec![Sym::ZERO; n * n];
    for (j, &velocity) in velocities.iter().enumerate() {
        for (i, entry) in graph::partial(momenta, velocity).into_iter().enumerate() {
            // Lower and upper entries are the same formula, whatever form the sweeps gave them.
            if i >= j {
                let entry = simplify_equation(entry);
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
