//! Checked scene to equations of motion, contact quantities and their derivatives.
//!
//! With `L(q, v, t)` the Lagrangian and `Q` the generalized forces,
//!
//! ```text
//! M = d2L/dv2          r = dL/dq + Q - (d2L/dv dq) v - d2L/dv dt          M a = r
//! ```

mod contact;
mod implicit;
mod ldl;
mod simplify;

pub(crate) use contact::{ContactEquations, FrictionEquations, InverseInertia};
pub(crate) use implicit::Implicit;
pub(crate) use simplify::simplify;

use crate::evaluate::velocity_direction;
use crate::graph::{self, Sym, Variable};
use crate::scene::{CheckedScene, Condition, OptimalControl};
use ldl::Factorization;
use simplify::simplify_all;

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
    pub(crate) optimal_control: Option<ControlEquations>,
}

/// Functions of optimal control.
pub(crate) struct ControlEquations {
    /// Running cost, then path constraints; functions of the input vector.
    pub(crate) path: Explicit,
    /// Final cost, then terminal conditions; functions of coordinates, velocities and final time.
    pub(crate) terminal: Explicit,
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
        let acceleration = factorization.solve(&right);
        let whole = contact::Inertia::whole(factorization, n);
        let contacts = scene
            .contacts
            .iter()
            .map(|contact| contact::explicit(contact, &mass, &whole, &inputs))
            .collect::<Result<_, _>>()?;
        (
            Solution::Explicit(Explicit::new(acceleration, &inputs)),
            contacts,
        )
    } else {
        let contacts = scene
            .contacts
            .iter()
            .map(|contact| contact::implicit(contact, &mass, &momenta, &inputs))
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
        optimal_control: scene
            .optimal_control
            .as_ref()
            .map(|task| optimal_control(task, n, &inputs)),
    })
}

fn optimal_control(task: &OptimalControl, n: usize, inputs: &[Variable]) -> ControlEquations {
    let functions = |cost: Option<Sym>, conditions: &[Condition], inputs: &[Variable]| {
        let functions = conditions.iter().map(|condition| condition.function);
        let values: Vec<Sym> = cost.into_iter().chain(functions).map(simplify).collect();
        Explicit::new(values, inputs)
    };
    let mut at_the_end = inputs[..2 * n].to_vec();
    at_the_end.push(Variable::Time);
    ControlEquations {
        path: functions(task.running_cost, &task.constraints, inputs),
        terminal: functions(task.final_cost, &task.goals, &at_the_end),
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
