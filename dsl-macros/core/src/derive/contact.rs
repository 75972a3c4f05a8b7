//! Gap, normal and tangent of a contact, and the directions in which its forces act.
//!
//! With `H` the inverse of the mass matrix, or that of the system with the held coordinates locked (zero
//! in their rows and columns), `n = dg/dq`, `b = d v_t/dv`, `D = n' H n`:
//!
//! ```text
//! d = w / (n' w),   w = H n or declared          e = H b / D
//! ```

use super::alike::Alike;
use super::contact_equations::{ContactEquations, FrictionEquations, InverseInertia};
use super::contacts::{Contacts, Derived};
use super::held::along_motion;
use super::implicit::{self, Implicit, WRITTEN_OUT};
use super::ldl::Factorization;
use super::residual::{self, Bordered, Elimination};
use super::shared::{Columns, Directed};
use super::{Explicit, Failure, simplify};
use crate::check::normal;
use crate::graph::{self, Compose, Stage, Sym, Variable};
use crate::scene::{Action, Contact, Friction};

/// Square of an acceleration that is none.
const NOTHING: f64 = 1e-200;

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
    ///
    /// # Errors
    /// The row whose pivot is structurally zero.
    fn locked(mass: &[Sym], n: usize, held: &[usize]) -> Result<Self, usize> {
        let free: Vec<usize> = (0..n).filter(|i| !held.contains(i)).collect();
        let part: Vec<Sym> = free
            .iter()
            .flat_map(|i| free.iter().map(move |j| mass[i * n + j]))
            .collect();
        let factorization = Factorization::of(&part, free.len()).map_err(|pivot| free[pivot])?;
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
fn slip(sliding: Sym, (n, moving): (usize, usize)) -> (Sym, Sym, Vec<Sym>) {
    let velocities = Variable::velocities(n);
    let sliding = simplify(sliding);
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

/// What the directions of all contacts are derived from: the whole mechanism, or the part of it that a contact moves.
pub(super) struct Mechanism<'a> {
    /// Its inertia, without locked coordinates.
    pub(super) inertia: implicit::Locked<'a>,
    /// Number of coordinates of the scene.
    pub(super) all: usize,
    /// The inverse mass matrix by formulas, of few coordinates.
    pub(super) formulas: Option<&'a Inertia>,
    /// The mass matrix by factors, unless it is solved with at run time.
    pub(super) written_out: Option<&'a Factorization>,
    /// Number of coordinates that move.
    pub(super) moving: usize,
    pub(super) inputs: &'a [Variable],
}

impl Mechanism<'_> {
    /// All contacts of a scene.
    pub(super) fn contacts(&self, declared: &[Contact]) -> Result<Contacts, Failure> {
        let mut contacts = Contacts::default();
        let mut alike = Alike::default();
        for contact in declared {
            graph::begin(Stage::Contact(contacts.len()));
            let mut derived = self.contact(contact, contacts.len(), &mut alike)?;
            if let Derived::Own(own) = &mut derived {
                for &(surface, factor) in &contact.loads {
                    // A force `r / D` of the surface adds its share to the bound, which is measured by `D` of the friction.
                    let surface = usize::from(surface);
                    let of_surface = contacts.get(surface);
                    let inertia = self.inverse_inertia(&declared[surface], &of_surface)?;
                    let scale = self.inverse_inertia(contact, own)?;
                    own.followed.push(surface);
                    own.loads.push(simplify(factor * scale * inertia.power(-2)));
                }
            }
            contacts.push(derived);
        }
        Ok(contacts)
    }

    /// Adds to a dry friction what it follows of forces of friction, each with a factor.
    pub(super) fn follow_frictions(
        &self,
        contacts: &mut Contacts,
        declared: &[Contact],
        (following, factors): (usize, &[(u16, Sym)]),
    ) -> Result<(), Failure> {
        let own = self.inverse_inertia(&declared[following], &contacts.get(following))?;
        for &(i, factor) in factors {
            let other = usize::from(i);
            let inertia = self.inverse_inertia(&declared[other], &contacts.get(other))?;
            let friction = declared[other].friction.as_ref();
            let share = friction.and_then(|law| law.share).unwrap_or(Sym::ONE);
            let load = simplify(factor * own * share * inertia.power(-2));
            contacts.follow(following, declared.len() + other, load);
        }
        Ok(())
    }

    /// The contact with this number, behind those that are derived.
    fn contact(
        &self,
        contact: &Contact,
        number: usize,
        alike: &mut Alike,
    ) -> Result<Derived, Failure> {
        let own = |equations: ContactEquations| Derived::Own(Box::new(equations));
        match (contact.bound, &contact.friction, &contact.switch) {
            (Some(_), Some(friction), Some(action)) => {
                return Ok(own(self.switch(action, friction)));
            }
            (Some(bound), Some(friction), None) => return Ok(own(self.dry(bound, friction))),
            _ => {}
        }
        let read = self.read_part(contact);
        let key = read.map(|part| (Alike::key(&self.defining(contact, &part), &part), part));
        if let Some((key, part)) = &key
            && let Some((like, names)) = alike.find(key, part, self.all)
        {
            return Ok(Derived::Like(like, names));
        }
        let geometry = geometry(contact, (self.all, self.moving));
        let Some(part) = self.part_of(contact, &geometry.2) else {
            let equations = self.with_geometry(contact, &contact.held, geometry)?;
            return Ok(own(equations));
        };
        let equations = self.by_part(contact, geometry, &part)?;
        if let Some((key, part)) = key {
            alike.insert(key, part, number);
        }
        Ok(own(equations))
    }

    /// The coordinates that the functions of a contact read, with those that inertia couples to them, where they are few and there are
    /// too many others for formulas.
    fn read_part(&self, contact: &Contact) -> Option<Vec<usize>> {
        if !self.may_have_parts(contact) {
            return None;
        }
        let sides = contact.friction.as_ref();
        let sides = sides.map(|law| {
            [Some(law.sliding), law.across, law.share]
                .into_iter()
                .flatten()
        });
        let mut functions = vec![contact.gap];
        functions.extend(sides.into_iter().flatten());
        let mut moved = vec![false; self.all];
        for variable in graph::variables(&functions) {
            if let Variable::Coordinate(i) | Variable::Velocity(i) = variable {
                moved[usize::from(i)] = true;
            }
        }
        self.coupled(moved)
    }

    /// Whether contacts may be derived by the part of the mechanism that they move.
    fn may_have_parts(&self, contact: &Contact) -> bool {
        self.written_out.is_none() && contact.along.is_none() && self.inertia.joints.is_empty()
    }

    /// All that a contact of a part of the mechanism is derived from.
    fn defining(&self, contact: &Contact, part: &[usize]) -> Vec<Sym> {
        let number = |value: usize| Sym::number(value as f64);
        let mut formulas = vec![contact.gap, number(part.len())];
        let friction = contact.friction.as_ref();
        formulas.extend(friction.map(|friction| friction.sliding));
        formulas.extend(friction.and_then(|friction| friction.share));
        formulas.extend(friction.and_then(|friction| friction.across));
        formulas.push(number(usize::from(friction.is_some())));
        let held = contact.held.iter();
        formulas.extend(held.filter_map(|i| part.binary_search(i).ok().map(number)));
        formulas.push(Sym::ZERO);
        for &i in part {
            formulas.push(number(usize::from(i < self.moving)));
            formulas.push(self.inertia.momenta[i]);
            formulas.extend(part.iter().map(|&j| self.inertia.mass[i * self.all + j]));
        }
        formulas
    }

    /// The coordinates that the forces of a contact move, where inertia does not couple them to the others, they are few, and
    /// there are too many others for formulas.
    fn part_of(&self, contact: &Contact, normal: &[Sym]) -> Option<Vec<usize>> {
        if !self.may_have_parts(contact) {
            return None;
        }
        let mut moved: Vec<bool> = normal.iter().map(|n| !n.is_structural_zero()).collect();
        if let Some(friction) = &contact.friction {
            for sliding in [Some(friction.sliding), friction.across]
                .into_iter()
                .flatten()
            {
                let (_, _, tangent) = slip(sliding, (self.all, self.moving));
                for (moved, component) in moved.iter_mut().zip(tangent) {
                    *moved |= !component.is_structural_zero();
                }
            }
        }
        self.coupled(moved)
    }

    /// The coordinates that are moved, with those that inertia couples to them, where they are few.
    fn coupled(&self, mut moved: Vec<bool>) -> Option<Vec<usize>> {
        let n = self.all;
        let mut part: Vec<usize> = (0..n).filter(|&i| moved[i]).collect();
        let mut next = 0;
        while let Some(&i) = part.get(next) {
            next += 1;
            let coupled = &self.inertia.mass[i * n..(i + 1) * n];
            for (j, (moved, mass)) in moved.iter_mut().zip(coupled).enumerate() {
                if !*moved && !mass.is_structural_zero() {
                    *moved = true;
                    part.push(j);
                }
            }
            if part.len() > WRITTEN_OUT {
                return None;
            }
        }
        part.sort_unstable();
        (!part.is_empty()).then_some(part)
    }

    /// A contact by the part of the mechanism that it moves.
    fn by_part(
        &self,
        contact: &Contact,
        geometry: (Vec<Sym>, Sym, Vec<Sym>),
        coordinates: &[usize],
    ) -> Result<ContactEquations, Failure> {
        let (n, size) = (self.all, coordinates.len());
        let rows = coordinates.iter();
        let mass: Vec<Sym> = rows
            .flat_map(|&i| {
                coordinates
                    .iter()
                    .map(move |&j| self.inertia.mass[i * n + j])
            })
            .collect();
        let momenta: Vec<Sym> = coordinates
            .iter()
            .map(|&i| self.inertia.momenta[i])
            .collect();
        let factors =
            Factorization::stepwise(&mass, size).map_err(|row| Failure::SingularMass {
                coordinate: coordinates[row],
            })?;
        let part = Mechanism {
            inertia: implicit::Locked {
                mass: &mass,
                momenta: &momenta,
                coordinates,
                joints: &[],
                ..self.inertia
            },
            all: n,
            // Simplified formulas are for reading; of many contacts they take long.
            formulas: None,
            written_out: Some(&factors),
            moving: self.moving,
            inputs: self.inputs,
        };
        let place = |i: &usize| coordinates.binary_search(i).ok();
        let held: Vec<usize> = contact.held.iter().filter_map(place).collect();
        part.with_geometry(contact, &held, geometry)
    }

    /// The components of a vector that belong to this part.
    fn own(&self, vector: &[Sym]) -> Vec<Sym> {
        self.inertia
            .coordinates
            .iter()
            .map(|&i| vector[i])
            .collect()
    }

    /// A contact with these gap, normal velocity, curvature and normal; `held` are rows of this part.
    fn with_geometry(
        &self,
        contact: &Contact,
        held: &[usize],
        (mut rows, curvature, normal): (Vec<Sym>, Sym, Vec<Sym>),
    ) -> Result<ContactEquations, Failure> {
        let n = self.inertia.momenta.len();
        let own_normal = self.own(&normal);
        let singular = |row: usize| Failure::SingularMass {
            coordinate: self.inertia.coordinates[row],
        };
        let inertia = self.holding(held);
        let shares = held.is_empty();
        let (locked, locked_factors) = match (self.formulas, self.written_out) {
            _ if held.is_empty() => (None, None),
            (formulas, factors) => (
                formulas
                    .map(|_| Inertia::locked(self.inertia.mass, n, held))
                    .transpose()
                    .map_err(singular)?,
                factors
                    .map(|_| inertia.factorized())
                    .transpose()
                    .map_err(singular)?,
            ),
        };
        let formulas = locked.as_ref().or(self.formulas);
        let factors = locked_factors.as_ref().or(self.written_out);

        let inverse = formulas.map(|formulas| formulas.solve(&own_normal));
        let divisor = inverse.as_ref().map(|inverse| inner(&own_normal, inverse));
        let inverse_inertia = match (divisor, factors) {
            (Some(formula), _) => InverseInertia::Formula(formula),
            (None, Some(factors)) => InverseInertia::Formula(
                Bordered::new(factors, vec![inertia.free_part(&own_normal)]).inverse_inertia(),
            ),
            (None, None) => InverseInertia::Solved,
        };
        let friction = contact.friction.as_ref();
        let along = |law: &Friction, sliding: Sym| {
            self.friction(
                (sliding, law.share),
                &inertia,
                &own_normal,
                (formulas, factors),
            )
        };
        let across = friction.and_then(|law| law.across.map(|across| along(law, across)));
        let friction = friction.map(|law| along(law, law.sliding));
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
                || implicit::direction(&inertia, &own_normal, self.inputs),
                shares.then(|| (vec![inertia.free_part(&own_normal)], true)),
                factors
                    .map(|factors| Bordered::new(factors, vec![inertia.free_part(&own_normal)]))
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
            across,
            ..ContactEquations::default()
        })
    }

    /// The tangential side of a contact with this normal, by the inverse of its inertia: by formulas, or by factors.
    fn friction(
        &self,
        (sliding, share): (Sym, Option<Sym>),
        inertia: &implicit::Locked<'_>,
        normal: &[Sym],
        (formulas, factors): (Option<&Inertia>, Option<&Factorization>),
    ) -> FrictionEquations {
        let (sliding, curvature, tangent) = slip(sliding, (self.all, self.moving));
        let mut own = self.own(&tangent);
        if let Some(share) = share {
            own.iter_mut()
                .for_each(|component| *component = simplify(share * *component));
        }
        let formula = formulas.map(|formulas| {
            let divisor = inner(normal, &formulas.solve(normal));
            over(&formulas.solve(&own), divisor)
        });
        let columns = [&own[..], normal].map(|vector| inertia.free_part(vector));
        let (rows, direction) = self.directed(
            vec![sliding],
            formula,
            || implicit::friction(inertia, normal, &own, self.inputs),
            inertia.held.is_empty().then(|| (columns.to_vec(), true)),
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
            held,
            ..self.inertia
        }
    }

    /// Dry friction: no gap and no normal, the given normal acceleration `D f` for a force `f`, and the direction
    /// `e = M^-1 b / D`, with the scale `D = sum_k b_k^2 / M_kk`, which is `b' M^-1 b` for one coordinate.
    fn dry(&self, bound: Sym, friction: &Friction) -> ContactEquations {
        let slip = slip(friction.sliding, (self.inertia.momenta.len(), self.moving));
        let scale = simplify(self.size_of_force(&slip.2));
        let action = slip.2.clone();
        self.given(slip, &action, scale, simplify(scale * bound))
    }

    /// `sum_k f_k^2 / M_kk`, about the square of the acceleration by a force of that size.
    fn size_of_force(&self, force: &[Sym]) -> Sym {
        let n = force.len();
        let terms = force.iter().enumerate();
        terms
            .map(|(k, &f)| f * f * self.inertia.mass[k * n + k].power(-2))
            .sum()
    }

    /// A switch: the friction direction is `M^-1 a / D` for what it acts by, `a`, and the given normal acceleration `D`, about what
    /// the switch changes the rate of its function by. Where it does not change that, as a kink never does, the function is only passed,
    /// and `D` is 1.
    fn switch(&self, action: &Action, friction: &Friction) -> ContactEquations {
        let slip = slip(friction.sliding, (self.inertia.momenta.len(), self.moving));
        let passes = action.kink || !self.couples(&slip.2, &action.force);
        let scale = if passes {
            Sym::ONE
        } else {
            let size = simplify(self.size_of_force(&slip.2) * self.size_of_force(&action.usual));
            // Where nothing acts the direction is none instead of not a number.
            match size.as_number() {
                Some(size) => Sym::number(size.sqrt()),
                None => (size + Sym::number(NOTHING)).kept().power(1),
            }
        };
        let mut equations = self.given(slip, &action.force, scale, scale);
        equations.passes = passes;
        equations
    }

    /// Whether a force along `action` may change a velocity with this gradient: some entries of both belong to one block of the
    /// mass matrix.
    fn couples(&self, gradient: &[Sym], action: &[Sym]) -> bool {
        let n = gradient.len();
        let block = implicit::blocks(self.inertia.mass, n);
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
        let n = self.inertia.momenta.len();
        let inertia = self.holding(&[]);
        let (rows, direction) = self.directed(
            vec![sliding],
            self.formulas
                .map(|formulas| over(&formulas.solve(action), scale)),
            || implicit::of_force(&inertia, over(action, scale), self.inputs),
            Some((vec![inertia.free_part(&over(action, scale))], false)),
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
            friction: Some(friction),
            ..ContactEquations::default()
        }
    }

    /// Some rows followed by a direction: a formula, or the first part of the solution of a system. What
    /// has no formulas at all is left to be solved at run time, with the inertia of the scene by the vectors in `shared` (and
    /// whether the last of them is the normal) where there are such.
    fn directed(
        &self,
        rows: Vec<Sym>,
        formula: Option<Vec<Sym>>,
        system: impl Fn() -> Implicit,
        shared: Option<(Vec<Vec<Sym>>, bool)>,
        elimination: Option<&impl Elimination>,
    ) -> (Explicit, Option<Directed>) {
        let Some(elimination) = elimination else {
            let direction = match shared {
                Some((columns, bordered)) => {
                    Directed::Columns(Columns::new(&columns, bordered, self.inputs))
                }
                None => Directed::System(system()),
            };
            return (Explicit::new(rows, self.inputs), Some(direction));
        };
        let first = rows.len();
        let written_out = || {
            let weight = |&i: &usize| Implicit::multiplier(first + i);
            let weights: Vec<Sym> = self.inertia.coordinates.iter().map(weight).collect();
            let direction = residual::derivatives(&system(), elimination, &weights, self.inputs);
            let rows = Explicit::new(rows.clone(), self.inputs).followed_by(direction);
            rows.spread(first, self.all, self.inertia.coordinates)
        };
        let rows = match formula {
            Some(direction) => {
                let mut values = rows.clone();
                values.resize(first + self.all, Sym::ZERO);
                for (&i, component) in self.inertia.coordinates.iter().zip(direction) {
                    values[first + i] = component;
                }
                Explicit::cheapest(values, written_out, self.inputs)
            }
            None => written_out(),
        };
        (rows, None)
    }
}
