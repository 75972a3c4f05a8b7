//! A place at which functions of switches vanish, and what acts there.

use crate::contact::{Line, View};

/// Where functions vanish.
pub(crate) struct Place<'p> {
    /// Input vector, `(q, v, u[, t])`.
    pub(crate) x: &'p [f64],
    /// Rates of its part behind the velocities; empty where they are zero.
    pub(crate) rates: &'p [f64],
    /// Contacts that touch.
    pub(crate) touching: &'p [usize],
    /// Sliding velocities of all contacts up to which they are at rest.
    pub(crate) zeros: &'p [f64],
    /// A time over which the motion is smooth \[s\].
    pub(crate) moment: f64,
    /// A time beyond which nothing is foreseen \[s\].
    pub(crate) longest: f64,
}

/// Share of a smooth time that is short beside those in which what acts varies: the square of it is far above rounding.
const LATER: f64 = 1e-3;

impl Place<'_> {
    /// A time that is short beside those in which what acts varies \[s\].
    pub(super) fn later(&self) -> f64 {
        LATER * self.moment
    }

    /// `from` after a time `h` in which coordinates and velocities have this `slope`.
    pub(super) fn moved(&self, from: &[f64], slope: &[f64], h: f64) -> Vec<f64> {
        let mut moved = from.to_vec();
        for (value, slope) in moved.iter_mut().zip(slope) {
            *value += h * slope;
        }
        for (value, rate) in moved[slope.len()..].iter_mut().zip(self.rates) {
            *value += h * rate;
        }
        moved
    }

    /// What the side 1 of each contact that touches takes from the acceleration, as last evaluated.
    pub(super) fn columns(&self, view: &View<'_>) -> Vec<Vec<f64>> {
        let column = |&i: &usize| {
            let force = -view.free_line_acceleration(Line::normal(i)) * view.friction(i);
            let direction = view.slip_direction(i).iter();
            direction.map(|e| force * e).collect()
        };
        self.touching.iter().map(column).collect()
    }
}

/// Sizes of the terms of each acceleration with these columns.
pub(super) fn sizes(view: &View<'_>, columns: &[Vec<f64>]) -> Vec<f64> {
    let free = view.free_acceleration().iter().enumerate();
    free.map(|(row, a)| columns.iter().map(|column| column[row].abs()).sum::<f64>() + a.abs())
        .collect()
}
