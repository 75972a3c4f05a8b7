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
    /// A contact that is like the one with these `formulas` of the coordinates of a `part`; if there is none, the contact with
    /// the number `own` is known from now on.
    pub(super) fn find(
        &mut self,
        formulas: &[Sym],
        part: &[usize],
        own: usize,
    ) -> Option<(usize, Vec<usize>)> {
        let place = |i: u16| part.binary_search(&usize::from(i)).ok();
        let key = graph::substitute(formulas, |variable| match variable {
            Variable::Coordinate(i) => place(i).map(|k| placeholder(COORDINATES, k)),
            Variable::Velocity(i) => place(i).map(|k| placeholder(VELOCITIES, k)),
            _ => None,
        });
        if let Some(known) = self.known.get(&key) {
            return Some(known.clone());
        }
        self.known.insert(key, (own, part.to_vec()));
        None
    }
}

fn placeholder(first: u16, k: usize) -> Sym {
    Sym::variable(Variable::Argument(first + k as u16))
}

/// New names of the coordinates: those of one part for those of another, in the same order.
pub(super) struct Renaming<'a> {
    pub(super) from: &'a [usize],
    pub(super) to: &'a [usize],
    /// Number of coordinates of the scene.
    pub(super) all: usize,
}

impl Renaming<'_> {
    /// A contact with the new names.
    pub(super) fn contact(&self, contact: &ContactEquations) -> ContactEquations {
        let side = |side: &FrictionEquations| FrictionEquations {
            rows: self.rows(&side.rows, 1),
            curvature: self.formulas(&[side.curvature], 0)[0],
            tangent: self.vector(&side.tangent),
            direction: None,
        };
        ContactEquations {
            followed: contact.followed.clone(),
            loads: self.formulas(&contact.loads, 0),
            rows: self.rows(&contact.rows, 2),
            curvature: self.formulas(&[contact.curvature], 0)[0],
            normal: self.vector(&contact.normal),
            inverse_inertia: match contact.inverse_inertia {
                InverseInertia::Formula(formula) => {
                    InverseInertia::Formula(self.formulas(&[formula], 0)[0])
                }
                InverseInertia::Solved => InverseInertia::Solved,
            },
            direction: None,
            passes: contact.passes,
            friction: contact.friction.as_ref().map(side),
            across: contact.across.as_ref().map(side),
        }
    }

    fn name(&self, coordinate: usize) -> usize {
        match self.from.binary_search(&coordinate) {
            Ok(k) => self.to[k],
            Err(_) => coordinate,
        }
    }

    /// Formulas with weights, of which those behind the first `rows` belong to coordinates.
    fn formulas(&self, formulas: &[Sym], rows: usize) -> Vec<Sym> {
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
        let row = |row: usize| match row.checked_sub(first) {
            Some(coordinate) => first + self.name(coordinate),
            None => row,
        };
        let column = |column: usize| match column.checked_sub(self.all) {
            None => self.name(column),
            Some(velocity) if velocity < self.all => self.all + self.name(velocity),
            Some(_) => column,
        };
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
