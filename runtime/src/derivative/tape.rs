//! What is linear along a motion: its steps, and what events change of derivatives.

use super::step::{Linear, Steps};
use super::tangent::{Layout, Matrix, add};
use crate::linalg::products::dot;

/// The linear parts of a walk, in their order.
#[derive(Default)]
pub(super) struct Tape {
    passed: Vec<Passed>,
    /// Of each event, how many parts there are before it, and how its time changes with everything there.
    times: Vec<(usize, Vec<f64>)>,
}

/// A linear part.
enum Passed {
    Step(Linear),
    /// Rows that an event has changed, with a column for each row before it.
    Change(Vec<(usize, Vec<f64>)>),
    /// What each row gains for a change of the time of the last event.
    Moved(Vec<f64>),
}

impl Tape {
    /// Keeps a step.
    pub(super) fn step(&mut self, linear: Linear) {
        self.passed.push(Passed::Step(linear));
    }

    /// Keeps what has become of the derivatives of everything by itself.
    pub(super) fn change(&mut self, change: Matrix) {
        let own = |i: usize| {
            let row = change.row(i);
            let is_kept = |(column, by): (usize, &f64)| *by == f64::from(u8::from(column == i));
            (!row.iter().enumerate().all(is_kept)).then(|| (i, row.to_vec()))
        };
        let rows = (0..change.columns).filter_map(own);
        self.passed.push(Passed::Change(rows.collect()));
    }

    /// Keeps what each row has gained for a change of the time of the last event.
    pub(super) fn moved(&mut self, by: Vec<f64>) {
        self.passed.push(Passed::Moved(by));
    }

    /// Keeps how the time of the event that comes next changes with everything.
    pub(super) fn time(&mut self, by: Vec<f64>) {
        self.times.push((self.passed.len(), by));
    }

    /// Carries what a value depends on, a number for each row of a [`Tangent`](super::tangent::Tangent), back to the start: at the end of the
    /// motion, or at an `event`, whose numbers are known. None of an event that was not passed.
    pub(super) fn back(
        &self,
        steps: &Steps,
        layout: Layout,
        (at_end, event): (&[f64], Option<usize>),
    ) -> Option<Vec<f64>> {
        let (behind, mut to) = match event {
            Some(event) => self.times.get(event)?.clone(),
            None => (self.passed.len(), at_end.to_vec()),
        };
        for passed in self.passed[..behind].iter().rev() {
            match passed {
                Passed::Step(linear) => steps.back(linear, layout, &mut to),
                Passed::Moved(by) => to[layout.last_event()] += dot(by, &to),
                Passed::Change(rows) => {
                    let take = |(i, _): &(usize, Vec<f64>)| std::mem::take(&mut to[*i]);
                    let weights: Vec<f64> = rows.iter().map(take).collect();
                    for (weight, (_, row)) in weights.iter().zip(rows) {
                        // What is not read may be unknown.
                        if *weight != 0.0 {
                            add(&mut to, *weight, row);
                        }
                    }
                }
            }
        }
        Some(to)
    }
}
