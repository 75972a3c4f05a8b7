//! Which contacts may close within the next steps, in scenes with many.
//!
//! Most pairs of many bodies are far apart. Around the present state lies a box that the motion leaves after some steps at the earliest;
//! where the gap of a contact stays above zero in the whole box ([`Bounds::least_gap`](crate::enclosure::Bounds::least_gap)), neither its gap nor what counts as zero of
//! it is looked at until the motion leaves the box. In place of its gap stands that bound. The pieces of an edge are far together, where one
//! of them is: the largest of their gaps acts.

use crate::enclosure::Range;
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
    /// The other pieces of the edge of each.
    others: Vec<&'static [usize]>,
    /// Bound of the gap of each in the box, where there is one.
    least: Vec<Option<f64>>,
}

impl Near {
    /// All contacts of a scene, of which `surfaces` are surfaces.
    pub(in crate::simulation) fn new(model: &dyn Model, surfaces: usize) -> Self {
        let contacts = model.declaration().contacts.iter();
        let others = contacts.map(|known| known.alternatives).collect();
        Self::of(others, surfaces, surfaces >= MANY)
    }

    /// Contacts with these `others`, of which it is `told` or not which are far.
    fn of(others: Vec<&'static [usize]>, surfaces: usize, told: bool) -> Self {
        let contacts = others.len();
        Self {
            told,
            surfaces,
            step: 0.0,
            low: Vec::new(),
            high: Vec::new(),
            contacts: (0..contacts).collect(),
            far: vec![false; contacts],
            others,
            least: vec![None; contacts],
        }
    }

    /// Those that may close, increasing.
    pub(in crate::simulation) fn contacts(&self) -> &[usize] {
        &self.contacts
    }

    /// Whether what is known does not hold at an input vector whose first `n` numbers are coordinates, and at the `time` in it.
    pub(in crate::simulation) fn is_left(&self, x: &[f64], n: usize, time: Option<f64>) -> bool {
        // Methods that expect no steps look at all.
        if !self.told || self.step == 0.0 {
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

    /// Whether what is known holds for a piece of a motion, by what each coordinate is in there.
    pub(in crate::simulation) fn holds(&self, mut coordinate: impl FnMut(usize) -> Range) -> bool {
        let bounds = self.low.iter().zip(&self.high).enumerate();
        bounds
            .filter(|(_, (low, _))| **low > f64::NEG_INFINITY)
            .all(|(k, (low, high))| {
                let range = coordinate(k);
                *low <= range.low && range.high <= *high
            })
    }

    /// Expects steps of about that length.
    pub(in crate::simulation) fn expect_step(&mut self, h: f64) {
        self.step = h;
    }

    /// Whether it does not hold for the step that is expected, from the input vector `x` with accelerations `a`.
    pub(in crate::simulation) fn is_left_within(&self, x: &[f64], a: &[f64], timed: bool) -> bool {
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
    /// may close in it by their `least_gap` there. Calls `place` with those that may not and their bounds; returns those of which it is news
    /// that they may.
    pub(in crate::simulation) fn look(
        &mut self,
        mut least_gap: impl FnMut(usize, &[f64], &[f64]) -> Option<f64>,
        (x, a): (&[f64], &[f64]),
        timed: bool,
        mut place: impl FnMut(usize, f64),
    ) -> Vec<usize> {
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
        for contact in 0..self.surfaces {
            let least = least_gap(contact, &self.low, &self.high);
            self.least[contact] = least.filter(|least| *least > rounding);
        }
        let mut news = Vec::new();
        for contact in 0..self.far.len() {
            let others = self.others[contact].iter().map(|&other| self.least[other]);
            let bound = others.fold(self.least[contact], |most, least| {
                least.map_or(most, |least| {
                    Some(most.map_or(least, |most| most.max(least)))
                })
            });
            match bound {
                Some(bound) => place(contact, bound),
                None => {
                    self.contacts.push(contact);
                    if self.far[contact] {
                        news.push(contact);
                    }
                }
            }
            self.far[contact] = bound.is_some();
        }
        news
    }
}

/// How far a coordinate goes at most in a time, about.
fn way(v: f64, a: f64, time: f64) -> f64 {
    FARTHER * time * (v.abs() + 0.5 * time * a.abs())
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two points on a line, walls at 0 and 10 m for each, and the distance between them less 0.5 m.
    fn least_gap(contact: usize, low: &[f64], high: &[f64]) -> Option<f64> {
        match contact {
            0 | 1 => Some(low[contact]),
            2 | 3 => Some(10.0 - high[contact - 2]),
            4 => Some(low[1] - high[0] - 0.5),
            _ => None,
        }
    }

    /// All contacts and one more, of which nothing is known, after a look from `(q, v)` with steps of 0.1 s.
    fn look(near: &mut Near, x: &[f64; 4]) -> Vec<(usize, bool)> {
        let mut placed = Vec::new();
        near.expect_step(0.1);
        let place = |contact: usize, _: f64| placed.push((contact, true));
        let news = near.look(least_gap, (x, &[0.0, 0.0]), false, place);
        placed.extend(news.into_iter().map(|contact| (contact, false)));
        placed
    }

    #[test]
    fn contacts_that_steps_cannot_reach_are_far() {
        let mut near = Near::of(vec![&[]; 6], 6, true);
        // The first goes 1.2 m to either side at most, the other one rests.
        let placed = look(&mut near, &[1.0, 4.0, 1.0, 0.0]);
        assert_eq!(near.contacts(), [0, 5]);
        assert_eq!(placed, [(1, true), (2, true), (3, true), (4, true)]);
    }

    #[test]
    fn box_holds_until_the_motion_leaves_it_and_what_comes_near_is_news() {
        let mut near = Near::of(vec![&[]; 6], 6, true);
        look(&mut near, &[1.0, 4.0, 1.0, 0.0]);
        assert!(!near.is_left(&[2.1, 4.0, 1.0, 0.0], 2, None));
        assert!(near.is_left(&[2.3, 4.0, 1.0, 0.0], 2, None));
        assert!(!near.is_left_within(&[2.0, 4.0, 1.0, 0.0], &[0.0, 0.0], false));
        assert!(near.is_left_within(&[2.1, 4.0, 1.0, 0.0], &[0.0, 0.0], false));
        let placed = look(&mut near, &[2.3, 4.0, 1.0, 0.0]);
        assert_eq!(near.contacts(), [4, 5]);
        assert_eq!(
            placed,
            [(0, true), (1, true), (2, true), (3, true), (4, false)]
        );
    }

    #[test]
    fn pieces_of_an_edge_are_far_where_one_is() {
        let others: Vec<&[usize]> = vec![&[1], &[0], &[], &[], &[], &[]];
        let mut near = Near::of(others, 6, true);
        look(&mut near, &[1.0, 4.0, 1.0, 0.0]);
        assert_eq!(near.contacts(), [5]);
        assert_eq!(look(&mut near, &[1.0, 0.1, 1.0, 1.0])[..1], [(2, true)]);
        assert_eq!(near.contacts(), [0, 1, 4, 5]);
    }

    #[test]
    fn nothing_is_far_where_it_is_not_told() {
        let near = Near::of(vec![&[]; 6], 6, false);
        assert!(!near.is_left(&[1e9, 4.0, 1.0, 0.0], 2, None));
        assert_eq!(near.contacts(), [0, 1, 2, 3, 4, 5]);
    }
}
