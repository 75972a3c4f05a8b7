//! What is linear along a motion: its steps, and what events change of derivatives.

use super::acceleration::Acceleration;
use super::arc::{Arc, Linear};
use super::cost::Cost;
use super::front::Front;
use super::matrix::{Covector, Matrix, add};
use super::wanted::Wanted;
use crate::model::Model;

/// The linear parts of a walk, in their order.
pub(super) struct Tape<'w> {
    /// The quantities that are asked for.
    pub(super) asked: &'w Wanted,
    /// The same behind every component of the state and of the impulses.
    present: &'w Wanted,
    /// Acceleration that knows its derivatives by the state only, for Newton's method.
    pub(super) lean: Acceleration<'w>,
    model: &'w dyn Model,
    passed: Vec<Passed>,
    /// Of each event, how many parts there are before it, and how its time changes with the [`present`](Self::present) there.
    times: Vec<(usize, Vec<f64>)>,
}

/// A linear part.
enum Passed {
    Step(Linear),
    /// Rows of the derivatives right behind an event, of `(q, v)`, of the impulses and of the running cost, with a column for each
    /// component of the state and of the impulses before, and for each quantity.
    Event(Matrix),
}

impl<'w> Tape<'w> {
    /// How many changes of the state and of the impulses there are.
    pub(super) fn present_changes(model: &dyn Model) -> usize {
        let declaration = model.declaration();
        2 * (declaration.coordinates.len() + declaration.contacts.len())
    }

    pub(super) fn new(
        model: &'w dyn Model,
        (asked, present): (&'w Wanted, &'w Wanted),
        lean: &'w Wanted,
    ) -> Self {
        Self {
            asked,
            present,
            lean: Acceleration::new(model, lean),
            model,
            passed: Vec::new(),
            times: Vec::new(),
        }
    }

    /// The derivatives of the present by itself.
    pub(super) fn present(&self) -> Front<'w> {
        let columns = self.present.count();
        let declaration = self.model.declaration();
        let (n, contacts) = (declaration.coordinates.len(), declaration.contacts.len());
        let mut state = Matrix::zeros(2 * n, columns);
        for i in 0..2 * n {
            state.row_mut(i)[i] = 1.0;
        }
        let mut impulses = Matrix::zeros(2 * contacts, columns);
        for i in 0..2 * contacts {
            impulses.row_mut(i)[2 * n + i] = 1.0;
        }
        Front {
            wanted: self.present,
            state,
            impulses,
            cost: Cost::of(self.model, self.present),
        }
    }

    /// Keeps a step.
    pub(super) fn step(&mut self, linear: Linear) {
        self.passed.push(Passed::Step(linear));
    }

    /// Keeps what has become of the derivatives of the [`present`](Self::present).
    pub(super) fn event(&mut self, front: Front<'_>) {
        let mut values = front.state.values;
        values.extend(front.impulses.values);
        let columns = front.state.columns;
        values.extend(
            front
                .cost
                .map_or_else(|| vec![0.0; columns], |cost| cost.sum),
        );
        self.passed.push(Passed::Event(Matrix { columns, values }));
    }

    /// Keeps how the times of the events that come next change with the [`present`](Self::present).
    pub(super) fn times(&mut self, times: &[Vec<f64>]) {
        let before = self.passed.len();
        let events = times.iter().map(|by| (before, by.clone()));
        self.times.extend(events);
    }

    /// What the end depends on by this row of derivatives by the [`present`](Self::present), and how many parts are before that.
    pub(super) fn at_end(&self, by: &[f64], cost: f64) -> (usize, Covector) {
        (self.passed.len(), self.covector(by, cost))
    }

    /// The same of the time of an event; none of one that was not passed.
    pub(super) fn at_event(&self, event: usize) -> Option<(usize, Covector)> {
        let (before, by) = self.times.get(event)?;
        Some((*before, self.covector(by, 0.0)))
    }

    fn covector(&self, by: &[f64], cost: f64) -> Covector {
        let changes = Self::present_changes(self.model);
        let states = 2 * self.model.declaration().coordinates.len();
        Covector {
            state: by[..states].to_vec(),
            impulses: by[states..changes].to_vec(),
            cost,
            by: by[changes..].to_vec(),
        }
    }

    /// Carries what depends on the present behind that many parts back to the start.
    pub(super) fn back(&self, arc: &Arc, behind: usize, to: &mut Covector) {
        for passed in self.passed[..behind].iter().rev() {
            match passed {
                Passed::Step(linear) => arc.back(linear, self.asked, to),
                Passed::Event(rows) => through(rows, to),
            }
        }
    }
}

/// Carries what depends on the present behind an event to that before it.
fn through(rows: &Matrix, to: &mut Covector) {
    let weights = to.state.iter().chain(&to.impulses).chain([&to.cost]);
    let mut sum = vec![0.0; rows.columns];
    for (i, weight) in weights.enumerate() {
        add(&mut sum, *weight, rows.row(i));
    }
    let (state, rest) = sum.split_at(to.state.len());
    let (impulses, by) = rest.split_at(to.impulses.len());
    to.state.copy_from_slice(state);
    to.impulses.copy_from_slice(impulses);
    add(&mut to.by, 1.0, by);
}
