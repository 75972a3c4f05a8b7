//! Gap, normal and tangent of a contact, and the directions in which its forces act.
//!
//! With `H` the inverse of the mass matrix, or that of the system with the held coordinates locked (zero
//! in their rows and columns), `n = dg/dq`, `b = d v_t/dv`, `D = n' H n`:
//!
//! ```text
//! d = w / (n' w),   w = H n or declared          e = H b / D
//! ```

use super::implicit::{self, Implicit};
use super::ldl::Factorization;
use super::{Explicit, Failure, simplify};
use crate::check::normal;
use crate::evaluate::velocity_direction;
use crate::graph::{self, Sym, Variable};
use crate::scene::{Contact, Friction};

/// What belongs to one contact.
pub(crate) struct ContactEquations {
    /// Gap, normal velocity, and if it is a formula, the contact direction.
    pub(crate) rows: Explicit,
    pub(crate) curvature: Sym,
    pub(crate) normal: Vec<Sym>,
    pub(crate) inverse_inertia: InverseInertia,
    /// The contact direction, unless it is among the `rows`.
    pub(crate) direction: Option<Implicit>,
    pub(crate) friction: Option<FrictionEquations>,
}

/// `D = n' H n`.
pub(crate) enum InverseInertia {
    Formula(Sym),
    /// From a linear system at run time: with the mass matrix, or with that of the direction.
    Solved,
}

/// The tangential side of a contact.
pub(crate) struct FrictionEquations {
    /// Sliding velocity, and if it is a formula, the friction direction.
    pub(crate) rows: Explicit,
    pub(crate) curvature: Sym,
    pub(crate) tangent: Vec<Sym>,
    /// The friction direction, unless it is among the `rows`.
    pub(crate) direction: Option<Implicit>,
}

/// `H` by factors.
pub(super) struct Inertia {
    n: usize,
    /// Coordinates that are not locked.
    free: Vec<usize>,
    factorization: Factorization,
}

impl Inertia {
    /// Of the whole system.
    pub(super) fn whole(factorization: Factorization, n: usize) -> Self {
        Self {
            n,
            free: (0..n).collect(),
            factorization,
        }
    }

    /// Of the system with some coordinates locked.
    fn locked(mass: &[Sym], n: usize, held: &[usize]) -> Result<Self, Failure> {
        let free: Vec<usize> = (0..n).filter(|i| !held.contains(i)).collect();
        let part: Vec<Sym> = free
            .iter()
            .flat_map(|i| free.iter().map(move |j| mass[i * n + j]))
            .collect();
        let factorization =
            Factorization::of(&part, free.len()).map_err(|pivot| Failure::SingularMass {
                coordinate: free[pivot],
            })?;
        Ok(Self {
            n,
            free,
            factorization,
        })
    }

    fn solve(&self, right: &[Sym]) -> Vec<Sym> {
        let part: Vec<Sym> = self.free.iter().map(|&i| right[i]).collect();
        let mut solution = vec![Sym::ZERO; self.n];
        for (value, &i) in self.factorization.solve(&part).into_iter().zip(&self.free) {
            solution[i] = value;
        }
        solution
    }
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

/// Sliding velocity, its curvature and the tangent.
fn slip(friction: &Friction, n: usize) -> (Sym, Sym, Vec<Sym>) {
    let velocities: Vec<Variable> = (0..n).map(|i| Variable::Velocity(i as u16)).collect();
    let sliding = simplify(friction.sliding);
    let curvature = graph::directional(&[sliding], velocity_direction)[0];
    let tangent = graph::gradient(sliding, &velocities);
    (
        sliding,
        simplify(curvature),
        tangent.into_iter().map(simplify).collect(),
    )
}

/// `w` divided by a number.
fn over(w: &[Sym], divisor: Sym) -> Vec<Sym> {
    let scale = divisor.power(-2);
    w.iter().map(|&w| simplify(w * scale)).collect()
}

/// Contact of a scene whose mass matrix is inverted by formulas.
pub(super) fn explicit(
    contact: &Contact,
    mass: &[Sym],
    whole: &Inertia,
    inputs: &[Variable],
) -> Result<ContactEquations, Failure> {
    let n = whole.n;
    let locked = if contact.held.is_empty() {
        None
    } else {
        Some(Inertia::locked(mass, n, &contact.held)?)
    };
    let inertia = locked.as_ref().unwrap_or(whole);
    let (mut rows, curvature, normal) = geometry(contact, n);
    let inverse = inertia.solve(&normal);
    let inverse_inertia = inner(&normal, &inverse);
    let along = contact.along.as_ref().unwrap_or(&inverse);
    rows.extend(over(along, inner(&normal, along)));
    let friction = contact.friction.as_ref().map(|friction| {
        let (sliding, curvature, tangent) = slip(friction, n);
        let mut rows = vec![sliding];
        rows.extend(over(&inertia.solve(&tangent), inverse_inertia));
        FrictionEquations {
            rows: Explicit::new(rows, inputs),
            curvature,
            tangent,
            direction: None,
        }
    });
    Ok(ContactEquations {
        rows: Explicit::new(rows, inputs),
        curvature,
        inverse_inertia: InverseInertia::Formula(inverse_inertia),
        normal,
        direction: None,
        friction,
    })
}

/// Contact of a scene whose directions are solutions of linear systems at run time.
pub(super) fn implicit(
    contact: &Contact,
    mass: &[Sym],
    momenta: &[Sym],
    inputs: &[Variable],
) -> ContactEquations {
    let n = momenta.len();
    let (mut rows, curvature, normal) = geometry(contact, n);
    let inertia = implicit::Locked {
        mass,
        momenta,
        held: &contact.held,
    };
    let direction = match &contact.along {
        Some(along) => {
            rows.extend(over(along, inner(&normal, along)));
            None
        }
        None => Some(implicit::direction(&inertia, &normal, inputs)),
    };
    let friction = contact.friction.as_ref().map(|friction| {
        let (sliding, curvature, tangent) = slip(friction, n);
        FrictionEquations {
            rows: Explicit::new(vec![sliding], inputs),
            curvature,
            direction: Some(implicit::friction(&inertia, &normal, &tangent, inputs)),
            tangent,
        }
    });
    ContactEquations {
        rows: Explicit::new(rows, inputs),
        curvature,
        inverse_inertia: InverseInertia::Solved,
        normal,
        direction,
        friction,
    }
}
