//! Checked scene to equations of motion, contact quantities and their derivatives.
//!
//! With `L(q, v, t)` the Lagrangian and `Q` the generalized forces,
//!
//! ```text
//! M = d2L/dv2          r = dL/dq + Q - (d2L/dv dq) v - d2L/dv dt          M a = r
//! ```

mod ldl;
mod simplify;

pub(crate) use simplify::simplify;

use crate::check::normal;
use crate::evaluate::velocity_direction;
use crate::graph::{self, Sym, Variable};
use crate::scene::CheckedScene;
use ldl::Factorization;

/// Largest number of coordinates whose acceleration is written out as a formula; above, it is the
/// solution of a linear system, as formulas through the inverse of the mass matrix explode.
pub(crate) const EXPLICIT: usize = 4;

/// Values of a sparse matrix with their positions.
#[derive(Default)]
pub(crate) struct Sparse {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) entries: Vec<(usize, usize)>,
    pub(crate) values: Vec<Sym>,
}

/// What holds without contact.
pub(crate) struct Dynamics {
    /// Mass matrix, row-major.
    pub(crate) mass: Vec<Sym>,
    /// Kinetic and potential energy.
    pub(crate) energy: [Sym; 2],
    pub(crate) acceleration: Vec<Sym>,
    pub(crate) jacobian: Sparse,
    pub(crate) hessian: Sparse,
}

/// What belongs to one contact.
pub(crate) struct ContactEquations {
    pub(crate) gap: Sym,
    pub(crate) normal_velocity: Sym,
    pub(crate) curvature: Sym,
    pub(crate) inverse_inertia: Sym,
    pub(crate) normal: Vec<Sym>,
    pub(crate) direction: Vec<Sym>,
    pub(crate) jacobian: Sparse,
    pub(crate) hessian: Sparse,
}

/// Why no equations could be derived.
pub(crate) enum Failure {
    /// The mass matrix is singular whatever the parameters; this coordinate's pivot vanishes.
    SingularMass { coordinate: usize },
}

/// Everything derived from a scene.
pub(crate) struct Equations {
    /// Components of the input vector `x`.
    pub(crate) inputs: Vec<Variable>,
    pub(crate) dynamics: Dynamics,
    pub(crate) contacts: Vec<ContactEquations>,
}

/// Derives all equations of a scene.
pub(crate) fn equations(scene: &CheckedScene) -> Result<Equations, Failure> {
    let n = scene.coordinates.len();
    let coordinates: Vec<Variable> = (0..n).map(|i| Variable::Coordinate(i as u16)).collect();
    let velocities: Vec<Variable> = (0..n).map(|i| Variable::Velocity(i as u16)).collect();
    let mut inputs = coordinates.clone();
    inputs.extend(&velocities);
    inputs.extend((0..scene.controls.len()).map(|i| Variable::Control(i as u16)));
    if scene.explicit_time {
        inputs.push(Variable::Time);
    }

    let lagrangian = scene.lagrangian;
    let momenta = graph::gradient(lagrangian, &velocities);
    let mut mass = vec![Sym::ZERO; n * n];
    for (j, &velocity) in velocities.iter().enumerate() {
        for (i, entry) in graph::partial(&momenta, velocity).into_iter().enumerate() {
            mass[i * n + j] = simplify(entry);
        }
    }
    let conservative = graph::gradient(lagrangian, &coordinates);
    let transport = graph::directional(&momenta, velocity_direction);
    let right: Vec<Sym> = (0..n)
        .map(|i| simplify(conservative[i] + scene.forces[i] - transport[i]))
        .collect();

    let factorization =
        Factorization::of(&mass, n).map_err(|coordinate| Failure::SingularMass { coordinate })?;
    let acceleration = factorization.solve(&right);
    let dynamics = Dynamics {
        energy: energy(lagrangian, &momenta, &velocities),
        jacobian: jacobian(&acceleration, &inputs),
        hessian: hessian(&acceleration, &inputs),
        mass,
        acceleration,
    };
    let contacts = scene
        .contacts
        .iter()
        .map(|contact| {
            let gap = contact.gap;
            let normal: Vec<Sym> = normal(gap, n).into_iter().map(simplify).collect();
            let inverse = factorization.solve(&normal);
            let inner = |a: &[Sym], b: &[Sym]| -> Sym {
                simplify(a.iter().zip(b).map(|(&a, &b)| a * b).sum())
            };
            let along = contact.along.clone().unwrap_or_else(|| inverse.clone());
            let scale = inner(&normal, &along).power(-2);
            let direction: Vec<Sym> = along.iter().map(|&w| simplify(w * scale)).collect();
            let normal_velocity = graph::directional(&[gap], velocity_direction)[0];
            let curvature = graph::directional(&[normal_velocity], velocity_direction)[0];
            let mut rows = vec![gap, normal_velocity];
            rows.extend(&direction);
            ContactEquations {
                gap,
                normal_velocity,
                curvature: simplify(curvature),
                inverse_inertia: inner(&normal, &inverse),
                jacobian: jacobian(&rows, &inputs),
                hessian: hessian(&rows, &inputs),
                normal,
                direction,
            }
        })
        .collect();
    Ok(Equations {
        inputs,
        dynamics,
        contacts,
    })
}

/// `v' dL/dv - L` split into the part that vanishes at rest and the rest.
fn energy(lagrangian: Sym, momenta: &[Sym], velocities: &[Variable]) -> [Sym; 2] {
    let at_rest = graph::substitute(&[lagrangian], |variable| {
        matches!(variable, Variable::Velocity(_)).then_some(Sym::ZERO)
    })[0];
    let power: Sym = momenta
        .iter()
        .zip(velocities)
        .map(|(&momentum, &velocity)| momentum * Sym::variable(velocity))
        .sum();
    let potential = -at_rest;
    [simplify(power - lagrangian - potential), potential]
}

/// Nonzero derivatives of `outputs` with respect to `inputs`, row by row.
pub(crate) fn jacobian(outputs: &[Sym], inputs: &[Variable]) -> Sparse {
    let columns: Vec<Vec<Sym>> = inputs
        .iter()
        .map(|&input| graph::partial(outputs, input))
        .collect();
    let mut sparse = Sparse {
        rows: outputs.len(),
        columns: inputs.len(),
        ..Sparse::default()
    };
    for i in 0..outputs.len() {
        for (j, column) in columns.iter().enumerate() {
            let value = simplify(column[i]);
            if !value.is_structural_zero() {
                sparse.entries.push((i, j));
                sparse.values.push(value);
            }
        }
    }
    sparse
}

/// Nonzero second derivatives (lower triangle) of the outputs weighted by multipliers: adjoints
/// first, then a sweep of dual numbers for each input.
pub(crate) fn hessian(outputs: &[Sym], inputs: &[Variable]) -> Sparse {
    let weighted: Sym = outputs
        .iter()
        .enumerate()
        .map(|(i, &output)| Sym::variable(Variable::Multiplier(i as u16)) * output)
        .sum();
    let gradient: Vec<Sym> = graph::gradient(weighted, inputs)
        .into_iter()
        .map(simplify)
        .collect();
    let mut sparse = Sparse {
        rows: inputs.len(),
        columns: inputs.len(),
        ..Sparse::default()
    };
    let columns: Vec<Vec<Sym>> = inputs
        .iter()
        .map(|&input| graph::partial(&gradient, input))
        .collect();
    for i in 0..inputs.len() {
        for (j, column) in columns.iter().enumerate().take(i + 1) {
            let value = simplify(column[i]);
            if !value.is_structural_zero() {
                sparse.entries.push((i, j));
                sparse.values.push(value);
            }
        }
    }
    sparse
}
