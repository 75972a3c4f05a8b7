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
mod residual;
mod simplify;

pub(crate) use contact::{ContactEquations, FrictionEquations, InverseInertia};
pub(crate) use implicit::Implicit;
pub(crate) use simplify::simplify;

use crate::evaluate::velocity_direction;
use crate::graph::{self, Sym, Variable};
use crate::scene::{CheckedScene, Condition, OptimalControl};
use crate::tape::{self, Tape};
use ldl::Factorization;
use simplify::{simplify_all, simplify_equation};
use std::collections::{BTreeMap, BTreeSet};

/// Largest number of coordinates whose acceleration is simplified as one formula; above, formulas
/// through the inverse of the mass matrix explode.
const EXPLICIT: usize = 4;

/// Largest number of coordinates for which elimination is written out; above, loops over dense matrices
/// are faster, and much shorter to compile.
const WRITTEN_OUT: usize = 8;

/// Most operations of formulas whose derivatives are tried as formulas; those of longer ones were never the
/// cheaper ones.
const DIFFERENTIATED: usize = 120;

/// Most operations of derivatives for which no second way of deriving them is tried.
const SHORT: usize = 40;

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

impl Sparse {
    /// The structural nonzeros of a matrix.
    fn nonzeros(
        rows: usize,
        columns: usize,
        entries: impl Iterator<Item = ((usize, usize), Sym)>,
    ) -> Self {
        let (entries, values) = entries
            .filter(|(_, value)| !value.is_structural_zero())
            .unzip();
        Self {
            rows,
            columns,
            entries,
            values,
        }
    }

    /// Of two forms of the same matrix the cheaper one, at the positions that are nonzero in both.
    fn cheaper(self, other: Self) -> Self {
        let common = |one: Self, other: &Self| {
            let positions: BTreeSet<(usize, usize)> = other.entries.iter().copied().collect();
            let entries = one.entries.into_iter().zip(one.values);
            let kept = entries.filter(|(entry, _)| positions.contains(entry));
            Self::nonzeros(one.rows, one.columns, kept)
        };
        let first = common(self, &other);
        let second = common(other, &first);
        let (own, its) = (tape::cost(&first.values), tape::cost(&second.values));
        if its < own { second } else { first }
    }
}

impl Explicit {
    fn new(values: Vec<Sym>, inputs: &[Variable]) -> Self {
        Self {
            jacobian: jacobian(&values, inputs),
            hessian: hessian(&values, inputs),
            values,
        }
    }

    /// The components of both; the Hessians are those of weighted sums, and add up.
    fn followed_by(mut self, other: Self) -> Self {
        let rows = self.values.len();
        let below = other.jacobian.entries.iter();
        let below = below.map(|&(row, column)| (rows + row, column));
        self.jacobian.entries.extend(below);
        self.jacobian.values.extend(other.jacobian.values);
        self.jacobian.rows += other.jacobian.rows;
        self.values.extend(other.values);
        let own = self.hessian.entries.into_iter().zip(self.hessian.values);
        let mut sums: BTreeMap<(usize, usize), Sym> = own.collect();
        for (entry, value) in other.hessian.entries.into_iter().zip(other.hessian.values) {
            *sums.entry(entry).or_insert(Sym::ZERO) += value;
        }
        self.hessian =
            Sparse::nonzeros(other.hessian.rows, other.hessian.columns, sums.into_iter());
        self
    }

    /// Formulas whose derivatives are taken of themselves or from `written_out`, the same function by
    /// elimination, whichever takes fewer operations.
    fn cheapest(values: Vec<Sym>, written_out: impl FnOnce() -> Self, inputs: &[Variable]) -> Self {
        if tape::operations(&values) > DIFFERENTIATED {
            return Self {
                values,
                ..written_out()
            };
        }
        let formulas = Self::new(values, inputs);
        let length = tape::operations(&formulas.jacobian.values)
            + tape::operations(&formulas.hessian.values);
        if length <= SHORT {
            return formulas;
        }
        let written_out = written_out();
        Self {
            values: formulas.values,
            jacobian: formulas.jacobian.cheaper(written_out.jacobian),
            hessian: formulas.hessian.cheaper(written_out.hessian),
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
    /// `r` of `M a = r`.
    pub(crate) right: Vec<Sym>,
    /// Whether acceleration and contact directions are formulas that a person can read.
    pub(crate) readable: bool,
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
    let inputs = inputs(scene);
    let (coordinates, velocities) = (&inputs[..n], &inputs[n..2 * n]);
    let lagrangian = scene.lagrangian;
    let momenta = graph::gradient(lagrangian, velocities);
    let mass = mass_matrix(&momenta, velocities)?;
    let conservative = graph::gradient(lagrangian, coordinates);
    let applied: Vec<Sym> = conservative
        .iter()
        .zip(&scene.forces)
        .map(|(&conservative, &force)| conservative + force)
        .collect();
    let transport = graph::directional(&momenta, velocity_direction);
    let right: Vec<Sym> = conservative
        .iter()
        .zip(&transport)
        .zip(&scene.forces)
        // Each part by itself: the terms of both rarely cancel, and long sums are not simplified.
        .map(|((&conservative, &transport), &force)| {
            simplify(simplify_equation(conservative - transport) + simplify_equation(force))
        })
        .collect();
    let energy = energy(lagrangian, &momenta, velocities);
    let singular = |coordinate| Failure::SingularMass { coordinate };
    let formulas = (n <= EXPLICIT)
        .then(|| Factorization::of(&mass, n))
        .transpose()
        .map_err(singular)?;
    let stepwise = (n <= implicit::FORMULAS)
        .then(|| Factorization::stepwise(&mass, n))
        .transpose()
        .map_err(singular)?;
    let written_out = stepwise.as_ref().filter(|_| n <= WRITTEN_OUT);
    let motion = || {
        let (mass, right, factors) = (mass.clone(), right.clone(), stepwise.as_ref());
        implicit::motion(mass, right, factors, &momenta, &applied, &inputs)
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
    let formulas = formulas.map(|factorization| contact::Inertia::whole(factorization, n));
    let inertia = contact::Mechanism {
        mass: &mass,
        momenta: &momenta,
        formulas: formulas.as_ref(),
        written_out,
        inputs: &inputs,
    };
    let contacts = scene
        .contacts
        .iter()
        .map(|contact| inertia.contact(contact))
        .collect::<Result<_, _>>()?;
    Ok(Equations {
        inputs: inputs.len(),
        right,
        readable: n <= EXPLICIT,
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

/// The input vector `(q, v, u[, t])`.
fn inputs(scene: &CheckedScene) -> Vec<Variable> {
    let n = scene.coordinates.len() as u16;
    let controls = scene.controls.len() as u16;
    let mut inputs: Vec<Variable> = (0..n).map(Variable::Coordinate).collect();
    inputs.extend((0..n).map(Variable::Velocity));
    inputs.extend((0..controls).map(Variable::Control));
    if scene.explicit_time {
        inputs.push(Variable::Time);
    }
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
    let at_rest = |values: &[Sym]| {
        graph::substitute(values, |variable| {
            matches!(variable, Variable::Velocity(_)).then_some(Sym::ZERO)
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

/// Nonzero second derivatives (lower triangle) of the outputs weighted by multipliers, by two ways of which
/// now one and now the other takes fewer operations: adjoints, then a sweep of dual numbers for
/// each input; or one sweep that carries second derivatives, over the shortest evaluation.
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
    let by_columns = sparse(inputs.len(), inputs.len(), entries);
    if tape::operations(&by_columns.values) < SHORT {
        return by_columns;
    }
    let evaluation = Tape::of(&[weighted]).stepwise();
    let entries = graph::hessian(evaluation[0], inputs);
    let at_once = Sparse::nonzeros(inputs.len(), inputs.len(), entries.into_iter());
    by_columns.cheaper(at_once)
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
