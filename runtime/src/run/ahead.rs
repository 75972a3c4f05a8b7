//! A motion followed a little way ahead, with given sides of switches, by the law of contact at each place.

use super::place::{Place, sizes};
use crate::contact::{Balance, Line, ModeError, Touching, View, sum_of_sizes};
use crate::model::{pair_size, switching_terms};

/// Rounding errors of a function up to which it has no sign, and share of the terms of its rate that is rounding.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
const NOISE: f64 = 1e-13;
/// Multiple of what is left of a rate that counts as none, up to which it explains the function.
const EXPLAINED: f64 = 4.0;

/// Lets these sides of the `open` switches act.
pub(super) fn set_sides(view: &mut View<'_>, open: &[usize], side: impl Fn(usize) -> f64) {
    for (k, &contact) in open.iter().enumerate() {
        view.sides[contact] = side(k);
    }
}

/// A function of a switch where a motion begins.
pub(super) struct Begun {
    value: f64,
    /// Its rate as far as that counts as none, and what of it is rounding at least.
    rate: f64,
    noise: f64,
}

impl Begun {
    /// That of a switch that is evaluated, under an acceleration with terms of these `sizes`, whose rate up to `none` counts as none.
    pub(super) fn of(
        view: &View<'_>,
        contact: usize,
        (acceleration, sizes): (&[f64], &[f64]),
        none: f64,
    ) -> Self {
        let rate = view.line_acceleration(Line::tangent(contact), acceleration);
        Self {
            value: view.sliding_velocity(contact),
            rate: if rate.abs() > none { 0.0 } else { rate },
            noise: NOISE * sum_of_sizes(view.tangent(contact), sizes),
        }
    }

    /// How far the function has come at `x`, where it is evaluated and terms of accelerations have these `sizes`, a time `h` later; none
    /// where that is rounding, or the rate that counts as none.
    pub(super) fn way(
        &self,
        view: &View<'_>,
        contact: usize,
        (x, sizes): (&[f64], &[f64]),
        h: f64,
    ) -> Option<f64> {
        let way = view.sliding_velocity(contact) - self.value;
        let rounding = ROUNDING * switching_terms(view.model, contact, x).max(self.value.abs());
        let noise = self
            .noise
            .max(NOISE * sum_of_sizes(view.tangent(contact), sizes));
        let explained = h * (EXPLAINED * self.rate.abs()).max(noise);
        (way.abs() > rounding + explained).then_some(way)
    }
}

/// The input vector after a time `h` with the sides of the view, in so many steps.
pub(super) fn ahead(
    view: &mut View<'_>,
    at: &Place<'_>,
    (h, steps): (f64, usize),
) -> Result<Vec<f64>, ModeError> {
    let mut later = at.x.to_vec();
    for _ in 0..steps {
        later = after(view, at, &later, h / steps as f64, false)?;
    }
    Ok(later)
}

/// The acceleration at `x` with the sides of the view; contacts without one stick where they are at rest, unless all are `fixed`.
pub(super) fn acceleration(
    view: &mut View<'_>,
    at: &Place<'_>,
    x: &[f64],
    fixed: bool,
) -> Result<Vec<f64>, ModeError> {
    view.evaluate_free_acceleration(x);
    for &i in at.touching {
        view.evaluate_sides(i, x);
    }
    let in_cone = |i: usize| {
        let free = !fixed && !view.passes(i) && view.sides[i] == 0.0;
        free && pair_size(view.sliding(i)) <= at.zeros[i]
    };
    let touching = Touching::new(view, at.touching, in_cone);
    let lines = touching.lines.iter();
    let offsets: Vec<f64> = lines
        .map(|&line| view.free_line_acceleration(line))
        .collect();
    let balance = Balance::first(touching, view, &offsets)?;
    let mut acceleration = view.free_acceleration().to_vec();
    balance.push(view, &balance.forces, &mut acceleration);
    // What is held moves by rounding, which what only that moves would take for a sign.
    let sizes = sizes(view, &at.columns(view));
    for (a, size) in acceleration.iter_mut().zip(sizes) {
        if a.abs() <= NOISE * size {
            *a = 0.0;
        }
    }
    Ok(acceleration)
}

/// The input vector after a time `h` from `x`, by one step of the classical Runge-Kutta method.
pub(super) fn after(
    view: &mut View<'_>,
    at: &Place<'_>,
    x: &[f64],
    h: f64,
    fixed: bool,
) -> Result<Vec<f64>, ModeError> {
    let n = view.n;
    let mut sum = vec![0.0; 2 * n];
    let mut slope = vec![0.0; 2 * n];
    for (node, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
        let stage = at.moved(x, &slope, node * h);
        slope[..n].copy_from_slice(&stage[n..2 * n]);
        slope[n..].copy_from_slice(&acceleration(view, at, &stage, fixed)?);
        for (sum, slope) in sum.iter_mut().zip(&slope) {
            *sum += weight / 6.0 * slope;
        }
    }
    Ok(at.moved(x, &sum, h))
}
