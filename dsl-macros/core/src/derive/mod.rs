//! Checked scene to equations of motion, contact quantities and their derivatives.
//!
//! With `L(q, v, t)` the Lagrangian and `Q` the generalized forces,
//!
//! ```text
//! M = d2L/dv2          r = dL/dq + Q - (d2L/dv dq) v - d2L/dv dt          M a = r
//! ```

mod implicit;
mod ldl;
mod simplify;

pub(crate) use implicit::Implicit;

use crate::check::normal;
use crate::evaluate::velocity_direction;
use crate::graph::{self, Sym, Variable};
use crate::scene::{CheckedScene, Contact};
use ldl::Factorization;
use simplify::{simplify, simplify_all};

/// Largest number of coordinates whose acceleration is written out as a formula; above, it is the
/// solution of a linear system, as formulas through the inverse of the mass matrix explode.
const EXPLICIT: usize = 4;

/// Values of a sparse matrix with their positions.
#[derive(Default)]
pub(crate) struct Sparse {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) entries: Vec<(usize, usize)>,
    pub(crate) values: Vec<Sym>,
}

/// A vector-valued function of the inputs with its derivatives.
pub(crate) struct Explicit {
    pub(crate) values: Vec<Sym>,
    pub(crate) jacobian: Sparse,
    pub(crate) hessian: Sparse,
}

impl Explicit {
    fn new(values: Vec<Sym>, inputs: &[Variable]) -> Self {
        Self {
            jacobian: jacobian(&values, inputs),
            hessian: hessian(&values, inputs),
            values,
        }
    }
}

/// A vector-valued function of the inputs.
pub(crate) enum Solution {
    /// As formulas.
    Explicit(Explicit),
    /// As the solution of a linear system.
    Implicit(Implicit),
}

/// What belongs to one contact.
pub(crate) struct ContactEquations {
    /// Gap, normal velocity, and if it is a formula, the contact direction.
    pub(crate) rows: Explicit,
    pub(crate) curvature: Sym,
    pub(crate) normal: Vec<Sym>,
    pub(crate) inverse_inertia: InverseInertia,
    /// The contact direction, unless it is among the `rows`.
    pub(crate) direction: Option<Implicit>,
}

/// `D = n' M^-1 n`.
pub(crate) enum InverseInertia {
    Formula(Sym),
    /// From a linear system at run time: with the mass matrix, or with that of the direction.
    Solved,
}

/// Why no equations could be derived.
pub(crate) enum Failure {
    /// The mass matrix is singular whatever the parameters; this coordinate's pivot vanishes.
    SingularMass { coordinate: usize },
}

/// Everything derived from a scene.
pub(crate) struct Equations {
    /// Number of components of the input vector `x`.
    pub(crate) inputs: usize,
    /// Mass matrix, row-major.
    pub(crate) mass: Vec<Sym>,
    /// Kinetic and potential energy.
    pub(crate) energy: [Sym; 2],
    pub(crate) acceleration: Solution,
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
            // Lower and upper entries are the same formula, whatever form the sweeps gave them.
            if i >= j {
                let entry = simplify(entry);
                (mass[i * n + j], mass[j * n + i]) = (entry, entry);
            }
        }
    }
    let applied: Vec<Sym> = graph::gradient(lagrangian, &coordinates)
        .into_iter()
        .zip(&scene.forces)
        .map(|(conservative, &force)| conservative + force)
        .collect();
    let transport = graph::directional(&momenta, velocity_direction);
    let right: Vec<Sym> = applied
        .iter()
        .zip(&transport)
        .map(|(&applied, &transport)| simplify(applied - transport))
        .collect();
    if let Some(coordinate) = (0..n).find(|i| {
        mass[i * n..i * n + n]
            .iter()
            .all(|m| m.is_structural_zero())
    }) {
        return Err(Failure::SingularMass { coordinate });
    }

    let energy = energy(lagrangian, &momenta, &velocities);
    let (acceleration, contacts) = if n <= EXPLICIT {
        let factorization = Factorization::of(&mass, n)
            .map_err(|coordinate| Failure::SingularMass { coordinate })?;
        let contacts = scene
            .contacts
            .iter()
            .map(|contact| explicit_contact(contact, &factorization, n, &inputs))
            .collect();
        let acceleration = factorization.solve(&right);
        (
            Solution::Explicit(Explicit::new(acceleration, &inputs)),
            contacts,
        )
    } else {
        let contacts = scene
            .contacts
            .iter()
            .map(|contact| implicit_contact(contact, &mass, &momenta, n, &inputs))
            .collect();
        let motion = implicit::motion(mass.clone(), right, &momenta, &applied, &inputs);
        (Solution::Implicit(motion), contacts)
    };
    Ok(Equations {
        inputs: inputs.len(),
        mass,
        energy,
        acceleration,
        contacts,
    })
}

fn inner(a: &[Sym], b: &[Sym]) -> Sym {
    simplify(a.iter().zip(b).map(|(&a, &b)| a * b).sum())
}

/// Gap, normal velocity, curvature and normal.
fn geometry(contact: &Contact, n: usize) -> (Vec<Sym>, Sym, Vec<Sym>) {
    let gap = contact.gap;
    let normal: Vec<Sym> = normal(gap, n).into_iter().map(simplify).collect();
    let normal_velocity = graph::directional(&[gap], velocity_direction)[0];
    let curvature = graph::directional(&[normal_velocity], velocity_direction)[0];
    (
        vec![gap, simplify(normal_velocity)],
        simplify(curvature),
        normal,
    )
}

/// `w / (n' w)`.
fn scaled_direction(along: &[Sym], normal: &[Sym]) -> Vec<Sym> {
    let scale = inner(normal, along).power(-2);
    along.iter().map(|&w| simplify(w * scale)).collect()
}

fn explicit_contact(
    contact: &Contact,
    factorization: &Factorization,
    n: usize,
    inputs: &[Variable],
) -> ContactEquations {
    let (mut rows, curvature, normal) = geometry(contact, n);
    let inverse = factorization.solve(&normal);
    let along = contact.along.as_ref().unwrap_or(&inverse);
    rows.extend(scaled_direction(along, &normal));
    ContactEquations {
        rows: Explicit::new(rows, inputs),
        curvature,
        inverse_inertia: InverseInertia::Formula(inner(&normal, &inverse)),
        normal,
        direction: None,
    }
}

fn implicit_contact(
    contact: &Contact,
    mass: &[Sym],
    momenta: &[Sym],
    n: usize,
    inputs: &[Variable],
) -> ContactEquations {
    let (mut rows, curvature, normal) = geometry(contact, n);
    let direction = match &contact.along {
        Some(along) => {
            rows.extend(scaled_direction(along, &normal));
            None
        }
        None => Some(implicit::direction(mass, momenta, &normal, inputs)),
    };
    ContactEquations {
        rows: Explicit::new(rows, inputs),
        curvature,
        inverse_inertia: InverseInertia::Solved,
        normal,
        direction,
    }
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
    [simplify(power - lagrangian + at_rest), -at_rest]
}

/// Nonzero derivatives of `outputs` with respect to `inputs`, row by row.
fn jacobian(outputs: &[Sym], inputs: &[Variable]) -> Sparse {
    let columns: Vec<Vec<Sym>> = inputs
        .iter()
        .map(|&input| graph::partial(outputs, input))
        .collect();
    let entries = (0..outputs.len())
        .flat_map(|i| (0..inputs.len()).map(move |j| (i, j)))
        .map(|(i, j)| ((i, j), columns[j][i]));
    sparse(outputs.len(), inputs.len(), entries)
}

/// Nonzero second derivatives (lower triangle) of the outputs weighted by multipliers: adjoints
/// first, then a sweep of dual numbers for each input.
fn hessian(outputs: &[Sym], inputs: &[Variable]) -> Sparse {
    let weighted: Sym = outputs
        .iter()
        .enumerate()
        .map(|(i, &output)| Sym::variable(Variable::Multiplier(i as u16)) * output)
        .sum();
    let gradient = simplify_all(&graph::gradient(weighted, inputs));
    let columns: Vec<Vec<Sym>> = inputs
        .iter()
        .map(|&input| graph::partial(&gradient, input))
        .collect();
    let entries = (0..inputs.len())
        .flat_map(|i| (0..=i).map(move |j| (i, j)))
        .map(|(i, j)| ((i, j), columns[j][i]));
    sparse(inputs.len(), inputs.len(), entries)
}

/// The nonzeros of a matrix, in their cheapest common form.
fn sparse(
    rows: usize,
    columns: usize,
    entries: impl Iterator<Item = ((usize, usize), Sym)>,
) -> Sparse {
    let (positions, values): (Vec<_>, Vec<_>) = entries
        .filter(|(_, value)| !value.is_structural_zero())
        .unzip();
    let (entries, values) = positions
        .into_iter()
        .zip(simplify_all(&values))
        .filter(|(_, value)| !value.is_structural_zero())
        .unzip();
    Sparse {
        rows,
        columns,
        entries,
        values,
    }
}
