//! Checked scene to equations of motion, contact quantities and their derivatives.
//!
//! With `L(q, v, t)` the Lagrangian and `Q` the generalized forces,
//!
//! ```text
//! M = d2L/dv2          r = dL/dq + Q - (d2L/dv dq) v - d2L/dv dt          M a = r
//! ```

mod implicit;
mod ldl;
mod residual;
mod simplify;

pub(crate) use implicit::Implicit;

use crate::check::normal;
use crate::evaluate::velocity_direction;
use crate::graph::{self, Sym, Variable};
use crate::scene::{CheckedScene, Contact};
use crate::tape::{self, Tape};
use ldl::Factorization;
use residual::Bordered;
use simplify::{simplify, simplify_all, simplify_equation};
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

/// Fewest operations of a Hessian for which a second way of deriving it is tried.
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
    fn with_cheaper_derivatives(values: Vec<Sym>, written_out: Self, inputs: &[Variable]) -> Self {
        if tape::operations(&values) > DIFFERENTIATED {
            return Self {
                values,
                ..written_out
            };
        }
        let formulas = Self::new(values, inputs);
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
    /// `r` of `M a = r`.
    pub(crate) right: Vec<Sym>,
    /// Whether acceleration and contact directions are formulas that a person can read.
    pub(crate) readable: bool,
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
                let entry = simplify_equation(entry);
                (mass[i * n + j], mass[j * n + i]) = (entry, entry);
            }
        }
    }
    let conservative = graph::gradient(lagrangian, &coordinates);
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
    if let Some(coordinate) = (0..n).find(|i| {
        mass[i * n..i * n + n]
            .iter()
            .all(|m| m.is_structural_zero())
    }) {
        return Err(Failure::SingularMass { coordinate });
    }

    let energy = energy(lagrangian, &momenta, &velocities);
    let singular = |coordinate| Failure::SingularMass { coordinate };
    let formulas = (n <= EXPLICIT)
        .then(|| Factorization::of(&mass, n))
        .transpose()
        .map_err(singular)?;
    let stepwise = Factorization::stepwise(&mass, n).map_err(singular)?;
    let contacts = scene
        .contacts
        .iter()
        .map(|contact| {
            let elimination = (n <= WRITTEN_OUT).then_some(&stepwise);
            contact_equations(
                contact,
                &mass,
                &momenta,
                formulas.as_ref(),
                elimination,
                &inputs,
            )
        })
        .collect();
    let motion = implicit::motion(
        mass.clone(),
        right.clone(),
        &stepwise,
        &momenta,
        &applied,
        &inputs,
    );
    let acceleration = if n <= WRITTEN_OUT {
        let weights: Vec<Sym> = (0..n).map(Implicit::multiplier).collect();
        let written = residual::derivatives(&motion, &stepwise, &weights, &inputs);
        Solution::Explicit(match &formulas {
            Some(formulas) => {
                Explicit::with_cheaper_derivatives(formulas.solve(&right), written, &inputs)
            }
            None => written,
        })
    } else {
        Solution::Implicit(motion)
    };
    Ok(Equations {
        inputs: inputs.len(),
        right,
        readable: n <= EXPLICIT,
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

/// Contact quantities: as formulas, with elimination written out, or with a system that is solved at run
/// time, as far as each is to be had.
fn contact_equations(
    contact: &Contact,
    mass: &[Sym],
    momenta: &[Sym],
    formulas: Option<&Factorization>,
    elimination: Option<&Factorization>,
    inputs: &[Variable],
) -> ContactEquations {
    let n = momenta.len();
    let (mut rows, curvature, normal) = geometry(contact, n);
    let finish = |rows, inverse_inertia, direction, normal| ContactEquations {
        rows,
        curvature,
        inverse_inertia,
        direction,
        normal,
    };
    if let Some(along) = &contact.along {
        rows.extend(scaled_direction(along, &normal));
        let rows = Explicit::new(rows, inputs);
        let inverse_inertia = match (formulas, elimination) {
            (Some(factorization), _) => {
                InverseInertia::Formula(inner(&normal, &factorization.solve(&normal)))
            }
            (None, Some(factorization)) => {
                InverseInertia::Formula(Bordered::new(factorization, &normal).inverse_inertia())
            }
            (None, None) => InverseInertia::Solved,
        };
        return finish(rows, inverse_inertia, None, normal);
    }
    let direction = implicit::direction(mass, momenta, &normal, inputs);
    let geometry = Explicit::new(rows.clone(), inputs);
    let Some(elimination) = elimination else {
        return finish(geometry, InverseInertia::Solved, Some(direction), normal);
    };
    let bordered = Bordered::new(elimination, &normal);
    let weights: Vec<Sym> = (0..n).map(|i| Implicit::multiplier(2 + i)).collect();
    let written = geometry.followed_by(residual::derivatives(
        &direction, &bordered, &weights, inputs,
    ));
    let (rows, inverse_inertia) = match formulas {
        Some(formulas) => {
            let inverse = formulas.solve(&normal);
            rows.extend(scaled_direction(&inverse, &normal));
            (
                Explicit::with_cheaper_derivatives(rows, written, inputs),
                inner(&normal, &inverse),
            )
        }
        None => (written, bordered.inverse_inertia()),
    };
    finish(rows, InverseInertia::Formula(inverse_inertia), None, normal)
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
