//! Gap, normal and tangent of a contact, and the directions in which its forces act.
//!
//! With `H` the inverse of the mass matrix, or that of the system with the held coordinates locked (zero
//! in their rows and columns), `n = dg/dq`, `b = d v_t/dv`, `D = n' H n`:
//!
//! ```text
//! d = w / (n' w),   w = H n or declared          e = H b / D
//! ```

use super::held::along_motion;
use super::implicit::{self, Implicit};
use super::joint_row::Row;
use super::ldl::Factorization;
use super::residual::{self, Bordered, Elimination};
use super::{Explicit, Failure, simplify};
use crate::check::normal;
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene::{Contact, Friction};

/// What belongs to one contact.
pub(crate) struct ContactEquations {
    /// Gap, normal velocity, and if it is a formula, the contact direction; of dry friction zeros, with the given normal
    /// acceleration in place of the normal velocity.
    pub(crate) rows: Explicit,
    pub(crate) curvature: Sym,
    pub(crate) normal: Vec<Sym>,
    pub(crate) inverse_inertia: InverseInertia,
    /// The contact direction, unless it is among the `rows`.
    pub(crate) direction: Option<Implicit>,
    pub(crate) friction: Option<FrictionEquations>,
    /// Of a switch: whether it does not change the rate of its function, which is only passed then.
    pub(crate) passes: bool,
}

/// Square of an acceleration that is none.
const NOTHING: f64 = 1e-200;

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
fn geometry(contact: &Contact, (n, moving): (usize, usize)) -> (Vec<Sym>, Sym, Vec<Sym>) {
    let gap = contact.gap;
    let mut normal: Vec<Sym> = normal(gap, moving).into_iter().map(simplify).collect();
    normal.resize(n, Sym::ZERO);
    let along = along_motion(moving);
    let normal_velocity = graph::directional(&[gap], along)[0];
    let curvature = graph::directional(&[normal_velocity], along)[0];
    (
        vec![gap, simplify(normal_velocity)],
        simplify(curvature),
        normal,
    )
}

/// Sliding velocity, its curvature and the tangent.
fn slip(friction: &Friction, (n, moving): (usize, usize)) -> (Sym, Sym, Vec<Sym>) {
    let velocities: Vec<Variable> = (0..n).map(|i| Variable::Velocity(i as u16)).collect();
    let sliding = simplify(friction.sliding);
    let curvature = graph::directional(&[sliding], along_motion(moving))[0];
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

/// What the directions of all contacts are derived from.
pub(super) struct Mechanism<'a> {
    pub(super) mass: &'a [Sym],
    pub(super) momenta: &'a [Sym],
    pub(super) joints: &'a [Row],
    /// The inverse mass matrix by formulas, of few coordinates.
    pub(super) formulas: Option<&'a Inertia>,
    /// The mass matrix by factors, unless it is solved with at run time.
    pub(super) written_out: Option<&'a Factorization>,
    /// Number of coordinates that move.
    pub(super) moving: usize,
    pub(super) inputs: &'a [Variable],
}

impl Mechanism<'_> {
    pub(super) fn contact(&self, contact: &Contact) -> Result<ContactEquations, Failure> {
        match (contact.bound, &contact.friction, &contact.switch) {
            (Some(_), Some(friction), Some(action)) => Ok(self.switch(action, friction)),
            (Some(bound), Some(friction), None) => Ok(self.dry(bound, friction)),
            _ => self.surface(contact),
        }
    }

    fn surface(&self, contact: &Contact) -> Result<ContactEquations, Failure> {
        let n = self.momenta.len();
        let (mut rows, curvature, normal) = geometry(contact, (n, self.moving));
        let singular = |coordinate| Failure::SingularMass { coordinate };
        let inertia = self.holding(&contact.held);
        let (locked, locked_factors) = match (self.formulas, self.written_out) {
            _ if contact.held.is_empty() => (None, None),
            (formulas, factors) => (
                formulas
                    .map(|_| Inertia::locked(self.mass, n, &contact.held))
                    .transpose()?,
                factors
                    .map(|_| inertia.factorized())
                    .transpose()
                    .map_err(singular)?,
            ),
        };
        let formulas = locked.as_ref().or(self.formulas);
        let factors = locked_factors.as_ref().or(self.written_out);

        let inverse = formulas.map(|formulas| formulas.solve(&normal));
        let divisor = inverse.as_ref().map(|inverse| inner(&normal, inverse));
        let inverse_inertia = match (divisor, factors) {
            (Some(formula), _) => InverseInertia::Formula(formula),
            (None, Some(factors)) => InverseInertia::Formula(
                Bordered::new(factors, vec![inertia.free_part(&normal)]).inverse_inertia(),
            ),
            (None, None) => InverseInertia::Solved,
        };
        let friction = contact.friction.as_ref().map(|friction| {
            let (sliding, curvature, tangent) = slip(friction, (n, self.moving));
            let formula = formulas
                .zip(divisor)
                .map(|(formulas, divisor)| over(&formulas.solve(&tangent), divisor));
            let columns = [&tangent, &normal].map(|vector| inertia.free_part(vector));
            let (rows, direction) = self.directed(
                vec![sliding],
                formula,
                || implicit::friction(&inertia, &normal, &tangent, self.inputs),
                factors
                    .map(|factors| Bordered::new(factors, columns.to_vec()))
                    .as_ref(),
            );
            FrictionEquations {
                rows,
                curvature,
                tangent,
                direction,
            }
        });
        let (rows, direction) = match &contact.along {
            Some(along) => {
                rows.extend(over(along, inner(&normal, along)));
                (Explicit::new(rows, self.inputs), None)
            }
            None => self.directed(
                rows,
                inverse
                    .zip(divisor)
                    .map(|(inverse, divisor)| over(&inverse, divisor)),
                || implicit::direction(&inertia, &normal, self.inputs),
                factors
                    .map(|factors| Bordered::new(factors, vec![inertia.free_part(&normal)]))
                    .as_ref(),
            ),
        };
        Ok(ContactEquations {
            rows,
            curvature,
            inverse_inertia,
            normal,
            direction,
            friction,
            passes: false,
        })
    }

    /// `D` of a contact as a formula, however long.
    pub(super) fn inverse_inertia(
        &self,
        declared: &Contact,
        contact: &ContactEquations,
    ) -> Result<Sym, Failure> {
        if let InverseInertia::Formula(formula) = contact.inverse_inertia {
            return Ok(formula);
        }
        let inertia = self.holding(&declared.held);
        let factors = inertia
            .factorized()
            .map_err(|coordinate| Failure::SingularMass { coordinate })?;
        let normal = inertia.free_part(&contact.normal);
        Ok(Bordered::new(&factors, vec![normal]).inverse_inertia())
    }

    /// The inertia with coordinates locked.
    fn holding<'h>(&'h self, held: &'h [usize]) -> implicit::Locked<'h> {
        implicit::Locked {
            mass: self.mass,
            momenta: self.momenta,
            held,
            joints: self.joints,
        }
    }

    /// Dry friction: no gap and no normal, the given normal acceleration `D f` for a force `f`, and the direction
    /// `e = M^-1 b / D`, with the scale `D = sum_k b_k^2 / M_kk`, which is `b' M^-1 b` for one coordinate.
    fn dry(&self, bound: Sym, friction: &Friction) -> ContactEquations {
        let slip = slip(friction, (self.momenta.len(), self.moving));
        let scale = simplify(self.size_of_force(&slip.2));
        let action = slip.2.clone();
        self.given(slip, &action, scale, simplify(scale * bound))
    }

    /// `sum_k f_k^2 / M_kk`, about the square of the acceleration by a force of that size.
    fn size_of_force(&self, force: &[Sym]) -> Sym {
        let n = force.len();
        let terms = force.iter().enumerate();
        terms
            .map(|(k, &f)| f * f * self.mass[k * n + k].power(-2))
            .sum()
    }

    /// A switch: the friction direction is `M^-1 a / D` for what it acts by, `a`, and the given normal acceleration `D`, about what
    /// the switch changes the rate of its function by. Where it does not change that, the function is only passed, and `D` is 1.
    fn switch(&self, action: &[Sym], friction: &Friction) -> ContactEquations {
        let slip = slip(friction, (self.momenta.len(), self.moving));
        let passes = !self.couples(&slip.2, action);
        let scale = if passes {
            Sym::ONE
        } else {
            let size = simplify(self.size_of_force(&slip.2) * self.size_of_force(action));
            // Where nothing acts the direction is none instead of not a number.
            match size.as_number() {
                Some(size) => Sym::number(size.sqrt()),
                None => (size + Sym::number(NOTHING)).kept().power(1),
            }
        };
        let mut equations = self.given(slip, action, scale, scale);
        equations.passes = passes;
        equations
    }

    /// Whether a force along `action` may change a velocity with this gradient: some entries of both belong to one block of the
    /// mass matrix.
    fn couples(&self, gradient: &[Sym], action: &[Sym]) -> bool {
        let n = gradient.len();
        let mut block: Vec<usize> = (0..n).collect();
        for _ in 0..n {
            for (k, entry) in self.mass.iter().enumerate() {
                if !entry.is_structural_zero() {
                    let least = block[k / n].min(block[k % n]);
                    (block[k / n], block[k % n]) = (least, least);
                }
            }
        }
        let entries = |vector: &[Sym]| -> Vec<usize> {
            let nonzero = (0..n).filter(|&k| !vector[k].is_structural_zero());
            nonzero.map(|k| block[k]).collect()
        };
        let acted = entries(action);
        entries(gradient).iter().any(|block| acted.contains(block))
    }

    /// A contact without gap and normal whose normal acceleration `pressed` is given, with the friction direction
    /// `M^-1 action / scale`.
    fn given(
        &self,
        (sliding, curvature, tangent): (Sym, Sym, Vec<Sym>),
        action: &[Sym],
        scale: Sym,
        pressed: Sym,
    ) -> ContactEquations {
        let n = self.momenta.len();
        let inertia = self.holding(&[]);
        let (rows, direction) = self.directed(
            vec![sliding],
            self.formulas
                .map(|formulas| over(&formulas.solve(action), scale)),
            || implicit::of_force(&inertia, over(action, scale), self.inputs),
            self.written_out,
        );
        let friction = FrictionEquations {
            rows,
            curvature,
            tangent,
            direction,
        };
        let mut values = vec![Sym::ZERO, pressed];
        values.resize(2 + n, Sym::ZERO);
        ContactEquations {
            rows: Explicit::new(values, self.inputs),
            curvature: simplify(-pressed),
            normal: vec![Sym::ZERO; n],
            inverse_inertia: InverseInertia::Formula(scale),
            direction: None,
            friction: Some(friction),
            passes: false,
        }
    }

    /// Some rows followed by a direction: a formula, or the first part of the solution of a system. What
    /// has no formulas at all is left to be solved at run time.
    fn directed(
        &self,
        rows: Vec<Sym>,
        formula: Option<Vec<Sym>>,
        system: impl Fn() -> Implicit,
        elimination: Option<&impl Elimination>,
    ) -> (Explicit, Option<Implicit>) {
        let Some(elimination) = elimination else {
            return (Explicit::new(rows, self.inputs), Some(system()));
        };
        let written_out = || {
            let weights: Vec<Sym> = (0..self.momenta.len())
                .map(|i| Implicit::multiplier(rows.len() + i))
                .collect();
            let direction = residual::derivatives(&system(), elimination, &weights, self.inputs);
            Explicit::new(rows.clone(), self.inputs).followed_by(direction)
        };
        let rows = match formula {
            Some(direction) => {
                let values = rows.iter().copied().chain(direction).collect();
                Explicit::cheapest(values, written_out, self.inputs)
            }
            None => written_out(),
        };
        (rows, None)
    }
}
