//! Which contacts may close within the next steps, in scenes with many.
//!
//! Most pairs of many bodies are far apart. Around the present state lies a box that the motion leaves after some steps at the earliest;
//! where the gap of a contact stays above zero in the whole box ([`Model::least_gap`]), neither its gap nor what counts as zero of
//! it is looked at until the motion leaves the box. In place of its gap stands that bound.

use crate::model::Model;

/// Number of surfaces from which on it is told which are far. Chosen: of fewer, all gaps take less time than a step without them.
const MANY: usize = 48;
/// Lengths of the next step that the box is made for.
const STEPS: f64 = 8.0;
/// By how much farther than at the present velocity and acceleration the motion may go.
const FARTHER: f64 = 1.5;
/// Least room of a coordinate, such as one that rests, as a share of that of the fastest and of rounding errors.
const LEAST: f64 = 0.02;
const ROUNDINGS: f64 = 1e4;

/// The contacts that are looked at.
#[derive(Debug, Clone)]
pub(in crate::simulation) struct Near {
    /// Whether it is told at all.
    told: bool,
    /// Number of surfaces; other contacts touch always.
    surfaces: usize,
    /// Length of the step that is expected.
    step: f64,
    /// Where inputs lie as long as what is known holds.
    low: Vec<f64>,
    high: Vec<f64>,
    /// Those that may close, increasing; all where it is not told.
    contacts: Vec<usize>,
    /// Whether each is too far to close.
    far: Vec<bool>,
}

impl Near {
    /// All contacts of a scene, of which `surfaces` are surfaces.
    pub(super) fn new(model: &dyn Model, surfaces: usize) -> Self {
        let contacts = model.declaration().contacts;
        let edges = contacts.iter().any(|known| !known.alternatives.is_empty());
        Self {
            told: surfaces >= MANY && !edges,
            surfaces,
            step: 0.0,
            low: Vec::new(),
            high: Vec::new(),
            contacts: (0..contacts.len()).collect(),
            far: vec![false; contacts.len()],
        }
    }

    /// Those that may close, increasing.
    pub(in crate::simulation) fn contacts(&self) -> &[usize] {
        &self.contacts
    }

    /// Whether what is known does not hold at an input vector whose first `n` numbers are coordinates, and at the `time` in it.
    pub(super) fn is_left(&self, x: &[f64], n: usize, time: Option<f64>) -> bool {
        if !self.told {
            return false;
        }
        let within = |(k, x): (usize, f64)| match (self.low.get(k), self.high.get(k)) {
            (Some(low), Some(high)) => *low <= x && x <= *high,
            _ => false,
        };
        let last = x.len() - 1;
        let mut coordinates = x[..n].iter().copied().enumerate();
        !(coordinates.all(within) && time.is_none_or(|time| within((last, time))))
    }

    /// Expects steps of about that length.
    pub(super) fn expect_step(&mut self, h: f64) {
        self.step = h;
    }

    /// Whether it does not hold for the step that is expected, from the input vector `x` with accelerations `a`.
    pub(super) fn is_left_within(&self, x: &[f64], a: &[f64], timed: bool) -> bool {
        if !self.told {
            return false;
        }
        let n = a.len();
        let mut end = x.to_vec();
        [1.0, -1.0].iter().any(|sign| {
            for k in 0..n {
                end[k] = x[k] + sign * way(x[n + k], a[k], self.step);
            }
            let time = timed.then(|| x[x.len() - 1] + self.step);
            self.is_left(&end, n, time)
        })
    }

    /// Makes the box for some of the steps that are expected from the input vector `x` with accelerations `a`, and finds the contacts that
    /// may close in it. Calls `place` with those that may not and their bounds, and with those of which that is news.
    pub(super) fn look(
        &mut self,
        model: &dyn Model,
        (x, a): (&[f64], &[f64]),
        timed: bool,
        mut place: impl FnMut(usize, Option<f64>),
    ) {
        let n = a.len();
        let time = STEPS * self.step;
        self.low.clear();
        self.high.clear();
        // Gaps read no velocities, and of controls it is not known how they go on.
        self.low.resize(x.len(), f64::NEG_INFINITY);
        self.high.resize(x.len(), f64::INFINITY);
        let ways = (0..n).map(|k| way(x[n + k], a[k], time));
        let least = LEAST * ways.fold(0.0, f64::max);
        for k in 0..n {
            let rounding = ROUNDINGS * f64::EPSILON * x[k].abs();
            let way = way(x[n + k], a[k], time).max(least).max(rounding);
            (self.low[k], self.high[k]) = (x[k] - way, x[k] + way);
        }
        if timed && let (Some(low), Some(high)) = (self.low.last_mut(), self.high.last_mut()) {
            let now = x[x.len() - 1];
            (*low, *high) = (now - time, now + time);
        }
        self.contacts.clear();
        // Rounding of a bound is some 1e-16 of the coordinates.
        let rounding = 64.0 * f64::EPSILON * largest(&x[..n]);
        for (contact, far) in self.far.iter_mut().enumerate() {
            let least =
                (contact < self.surfaces).then(|| model.least_gap(contact, &self.low, &self.high));
            let bound = least.flatten().filter(|least| *least > rounding);
            if bound.is_none() {
                self.contacts.push(contact);
            }
            if bound.is_some() || *far {
                place(contact, bound);
            }
            *far = bound.is_some();
        }
    }
}

/// How far a coordinate goes at most in a time, about.
fn way(v: f64, a: f64, time: f64) -> f64 {
    FARTHER * time * (v.abs() + 0.5 * time * a.abs())
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}
