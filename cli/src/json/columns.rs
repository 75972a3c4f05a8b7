//! The parts of a trajectory as lists of numbers, for hosts that need no text: the numbers are those of the document.

use std::ops::Range;

use hangtime::model::Model;
use hangtime::simulation::Trajectory;
use serde::{Serialize, Serializer};

use crate::published::Quantity;
use crate::quantity;
use crate::sampling::State;
use crate::thinning;

/// A part of a trajectory, row after row. In a document it is a list of rows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Columns {
    /// Rows.
    pub rows: usize,
    /// Numbers of a row.
    pub width: usize,
    /// The numbers; what is not finite is not a number (NaN), where the document has `null`.
    pub values: Vec<f64>,
}

/// The part `name` of the document's trajectory at most `most` instants; `None` where the document has no such part.
pub(crate) fn part(
    model: &dyn Model,
    trajectory: &Trajectory,
    most: usize,
    name: &str,
) -> Option<Columns> {
    of_kept(model, trajectory, &kept_instants(trajectory, most), name)
}

/// The columns of a name at chosen instants.
pub(super) fn of_kept(
    model: &dyn Model,
    trajectory: &Trajectory,
    kept: &[usize],
    name: &str,
) -> Option<Columns> {
    let declaration = model.declaration();
    let (mechanical, coordinates) = (declaration.mechanical(), declaration.coordinates.len());
    let contacts = declaration.contacts.len();
    let numbers = |column: &[f64]| Columns::of(1, kept.iter().map(|&k| &column[k..=k]));
    let vectors = |column: &[Vec<f64>], places: Range<usize>| {
        let rows = kept
            .iter()
            .filter_map(|&k| column.get(k)?.get(places.clone()));
        Columns::of(places.len(), rows)
    };
    let columns = match name {
        "time" => numbers(&trajectory.time),
        "numerical_time" => numbers(&trajectory.numerical_time),
        "q" => vectors(&trajectory.q, 0..mechanical),
        "v" => vectors(&trajectory.v, 0..mechanical),
        "states" => vectors(&trajectory.v, mechanical..coordinates),
        "u" => vectors(&trajectory.u, 0..declaration.controls.len()),
        "contact_force" => vectors(&trajectory.contact_force, 0..contacts),
        "friction_force" => vectors(&trajectory.friction_force, 0..contacts),
        "outputs" => {
            let recorded = kept.iter().filter(|_| !model.outputs().is_empty());
            let rows = recorded.map(|&k| State::of(model, trajectory, k).outputs);
            let rows: Vec<Vec<f64>> = rows.collect();
            Columns::of(model.outputs().len(), rows.iter().map(Vec::as_slice))
        }
        _ => return None,
    };
    Some(columns)
}

impl Columns {
    fn of<'a>(width: usize, rows: impl Iterator<Item = &'a [f64]>) -> Self {
        let finite = |value: &f64| if value.is_finite() { *value } else { f64::NAN };
        let (mut count, mut values) = (0, Vec::new());
        for row in rows {
            count += 1;
            values.extend(row.iter().map(finite));
        }
        Self {
            rows: count,
            width,
            values,
        }
    }

    /// Whether there is no row, as of what a scene does not have.
    pub(super) fn is_empty(&self) -> bool {
        self.rows == 0
    }

    /// A row below [`Columns::rows`].
    fn row(&self, k: usize) -> &[f64] {
        &self.values[k * self.width..(k + 1) * self.width]
    }

    /// The last row, if there is one.
    pub(super) fn last(&self) -> Option<&[f64]> {
        Some(self.row(self.rows.checked_sub(1)?))
    }
}

impl Serialize for Columns {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq((0..self.rows).map(|k| self.row(k)))
    }
}

/// Name and unit of every column of a part, as in the document.
pub(crate) fn quantities(model: &dyn Model, name: &str) -> Vec<(String, String)> {
    let declaration = model.declaration();
    let (mechanical, coordinates) = (declaration.mechanical(), declaration.coordinates.len());
    let contacts = declaration.contacts.len();
    let rub = declaration.contacts.iter().any(|c| c.friction.is_some());
    let (places, quantity): (Range<usize>, fn(usize) -> Quantity) = match name {
        "q" => (0..mechanical, Quantity::Coordinate),
        "v" => (0..mechanical, Quantity::Velocity),
        "states" => (mechanical..coordinates, Quantity::Velocity),
        "u" => (0..declaration.controls.len(), Quantity::Control),
        "contact_force" => (0..contacts, Quantity::ContactForce),
        "friction_force" => (0..if rub { contacts } else { 0 }, Quantity::FrictionForce),
        "outputs" => (0..model.outputs().len(), Quantity::Output),
        _ => (0..0, Quantity::Coordinate),
    };
    let quantities = places.map(quantity);
    quantities
        .map(|quantity| {
            (
                quantity::name(model, quantity),
                quantity::unit(model, quantity),
            )
        })
        .collect()
}

/// At most `most` of the instants before the first whose state is not finite.
pub(super) fn kept_instants(trajectory: &Trajectory, most: usize) -> Vec<usize> {
    thinning::kept(&trajectory.time[..finite_instants(trajectory)], most)
}

/// Instants before the first whose state is not finite. Forces may be infinite where the motion goes on.
pub(super) fn finite_instants(trajectory: &Trajectory) -> usize {
    let finite = |row: &[f64]| row.iter().all(|value| value.is_finite());
    (0..trajectory.time.len())
        .take_while(|&k| {
            trajectory.time[k].is_finite()
                && trajectory.numerical_time[k].is_finite()
                && [&trajectory.q[k], &trajectory.v[k], &trajectory.u[k]]
                    .into_iter()
                    .all(|row| finite(row))
        })
        .count()
}
