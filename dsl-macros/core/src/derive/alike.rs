//! Contacts that differ in the names of their coordinates only, as pairs of discs do: derived once, and renamed.

use super::contact_equations::{ContactEquations, FrictionEquations, InverseInertia};
use super::explicit::{Explicit, Sparse};
use crate::graph::{self, Sym, Table, Variable};

/// Placeholders for the coordinates and the velocities of a part begin here; expressions of a scene have no such arguments.
const COORDINATES: u16 = u16::MAX / 2;
const VELOCITIES: u16 = COORDINATES + 1024;

/// The contacts derived so far, by what they are derived from: the place of each, and its part of the mechanism.
#[derive(Default)]
pub(super) struct Alike {
    known: Table<Vec<Sym>, (usize, Vec<usize>)>,
}

impl Alike {
    /// What a contact is derived from, `formulas` of the coordinates of a `part`, without the names of these.
    pub(super) fn key(formulas: &[Sym], part: &[usize]) -> Vec<Sym> {
        let place = |i: u16| part.binary_search(&usize::from(i)).ok();
        graph::substitute(formulas, |variable| match variable {
            Variable::Coordinate(i) => place(i).map(|k| placeholder(COORDINATES, k)),
            Variable::Velocity(i) => place(i).map(|k| placeholder(VELOCITIES, k)),
            _ => None,
        })
    }

    /// The contact that is derived from the same, and its names for those of a `part`.
    pub(super) fn find(
        &self,
        key: &Vec<Sym>,
        part: &[usize],
        all: usize,
    ) -> Option<(usize, Names)> {
        let (contact, from) = self.known.get(key)?;
        let names = Names {
            from: from.clone(),
            to: part.to_vec(),
            all,
        };
        Some((*contact, names))
    }

    /// The contact with this number is known from now on.
    pub(super) fn insert(&mut self, key: Vec<Sym>, part: Vec<usize>, contact: usize) {
        self.known.insert(key, (contact, part));
    }
}

fn placeholder(first: u16, k: usize) -> Sym {
    Sym::variable(Variable::Argument(first + k as u16))
}

/// New names of the coordinates: those of one part for those of another, in the same order.
pub(crate) struct Names {
    from: Vec<usize>,
    to: Vec<usize>,
    /// Number of coordinates of the scene.
    all: usize,
}

impl Names {
    /// A contact with the new names.
    pub(super) fn contact(&self, contact: &ContactEquations) -> ContactEquations {
        let side = |side: &FrictionEquations| FrictionEquations {
            rows: self.rows(&side.rows, 1),
            curvature: self.formulas(&[side.curvature], 0)[0],
            tangent: self.vector(&side.tangent),
            direction: None,
        };
        ContactEquations {
            rows: self.rows(&contact.rows, 2),
            curvature: self.formulas(&[contact.curvature], 0)[0],
            normal: self.vector(&contact.normal),
            inverse_inertia: match contact.inverse_inertia {
                InverseInertia::Formula(formula) => {
                    InverseInertia::Formula(self.formulas(&[formula], 0)[0])
                }
                InverseInertia::Solved => InverseInertia::Solved,
            },
            friction: contact.friction.as_ref().map(side),
            across: contact.across.as_ref().map(side),
            ..ContactEquations::default()
        }
    }

    /// Gap, normal velocity and sliding velocities of a contact with the new names, and nothing else.
    pub(super) fn values(&self, contact: &ContactEquations) -> ContactEquations {
        let first = |rows: &Explicit, count: usize| Explicit {
            values: self.formulas(&rows.values[..count], count),
            ..Explicit::default()
        };
        let side = |side: &FrictionEquations| FrictionEquations {
            rows: first(&side.rows, 1),
            ..FrictionEquations::default()
        };
        ContactEquations {
            rows: first(&contact.rows, 2),
            friction: contact.friction.as_ref().map(side),
            across: contact.across.as_ref().map(side),
            ..ContactEquations::default()
        }
    }

    /// The coordinate in the place of another one.
    pub(crate) fn name(&self, coordinate: usize) -> usize {
        match self.from.binary_search(&coordinate) {
            Ok(k) => self.to[k],
            Err(_) => coordinate,
        }
    }

    /// The component of the input vector in the place of another one.
    pub(crate) fn input(&self, input: usize) -> usize {
        match input.checked_sub(self.all) {
            None => self.name(input),
            Some(velocity) if velocity < self.all => self.all + self.name(velocity),
            Some(_) => input,
        }
    }

    /// The row in the place of another one, of some rows followed by a vector of the coordinates.
    pub(crate) fn row(&self, row: usize, first: usize) -> usize {
        match row.checked_sub(first) {
            Some(coordinate) => first + self.name(coordinate),
            None => row,
        }
    }

    /// Some values followed by vectors of the coordinates; other components of these are all the same.
    pub(crate) fn spread(&self, old: &[u32], first: usize) -> Vec<u32> {
        let mut new = old.to_vec();
        let other = (0..self.all).find(|i| self.from.binary_search(i).is_err());
        for vector in (first..old.len()).step_by(self.all) {
            for &i in &self.from {
                new[vector + i] = other.map_or(old[vector + i], |other| old[vector + other]);
            }
            for (&from, &to) in self.from.iter().zip(&self.to) {
                new[vector + to] = old[vector + from];
            }
        }
        new
    }

    /// Formulas with weights, of which those behind the first `rows` belong to coordinates.
    pub(crate) fn formulas(&self, formulas: &[Sym], rows: usize) -> Vec<Sym> {
        let name = |i: u16| self.name(usize::from(i)) as u16;
        graph::substitute(formulas, |variable| match variable {
            Variable::Coordinate(i) => Some(Sym::variable(Variable::Coordinate(name(i)))),
            Variable::Velocity(i) => Some(Sym::variable(Variable::Velocity(name(i)))),
            Variable::Multiplier(i) if usize::from(i) >= rows => {
                let first = rows as u16;
                Some(Sym::variable(Variable::Multiplier(first + name(i - first))))
            }
            _ => None,
        })
    }

    /// A vector of the coordinates.
    fn vector(&self, vector: &[Sym]) -> Vec<Sym> {
        let old: Vec<Sym> = self.from.iter().map(|&i| vector[i]).collect();
        let mut new = vec![Sym::ZERO; vector.len()];
        for (&i, value) in self.to.iter().zip(self.formulas(&old, 0)) {
            new[i] = value;
        }
        new
    }

    /// Some rows followed by a vector of the coordinates, with their derivatives.
    fn rows(&self, old: &Explicit, first: usize) -> Explicit {
        let mut values = self.formulas(&old.values[..first], first);
        values.extend(self.vector(&old.values[first..]));
        let (row, column) = (|row| self.row(row, first), |column| self.input(column));
        Explicit {
            values,
            jacobian: self.sparse(&old.jacobian, first, |(i, j)| (row(i), column(j))),
            hessian: self.sparse(&old.hessian, first, |(i, j)| (column(i), column(j))),
        }
    }

    fn sparse(
        &self,
        old: &Sparse,
        first: usize,
        place: impl Fn((usize, usize)) -> (usize, usize),
    ) -> Sparse {
        Sparse {
            rows: old.rows,
            columns: old.columns,
            entries: old.entries.iter().copied().map(place).collect(),
            values: self.formulas(&old.values, first),
        }
    }
}
