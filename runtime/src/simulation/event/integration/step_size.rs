//! What tells how long steps may be, and how many there are: how accelerations change, and what rounding leaves of the errors of steps.

use super::outputs::Outputs;
use crate::simulation::event::dop853::System;
use crate::simulation::event::dynamics::{Dynamics, motion};
use crate::simulation::event::error_scale::ErrorScale;
use crate::simulation::verdict::Verdict;

/// Power of the length of a step with which errors of steps fall much faster.
const SLOWLY: i32 = 3;
/// Share of the error that a step may have above which what joints are off counts.
const TELLS: f64 = 0.1;

/// What is limited.
#[derive(Default)]
pub(super) struct Attempts {
    pub(super) steps: usize,
    /// Steps at the same instant.
    pub(super) repeats: usize,
}

/// The last step that was rejected.
#[derive(Default)]
pub(super) struct Rejected {
    /// Its time \[s\], length \[s\] and error.
    last: Option<(f64, f64, f64)>,
}

impl Rejected {
    /// Takes note of another one, at the time `t` with the length `h`; whether its `error` has hardly fallen with the length, other than those of
    /// a method of order 8 do.
    pub(super) fn hardly_falls(&mut self, (t, h): (f64, f64), error: f64) -> bool {
        let last = self.last.replace((t, h, error));
        last.is_some_and(|(time, length, before)| {
            time == t && h < length && error > before * (h / length).powi(SLOWLY)
        })
    }
}

/// What is known at the two ends of a step.
pub(super) struct StepEnds {
    /// By which its error is measured.
    pub(super) error_scale: ErrorScale,
    /// Values of the switching functions.
    pub(super) start_values: Vec<f64>,
    pub(super) end_values: Vec<f64>,
    /// Conditions at the end of the last step, which count unless it turns out to contain an event.
    pub(super) at_end: Verdict,
    /// Sign of the determinant of the equations of the mode.
    pub(super) orientation: f64,
    pub(super) rejected: Rejected,
}

/// By how much accelerations change within a `moment` after the state `y`, whose derivative is `slope`.
fn change(
    dynamics: &mut Dynamics<'_>,
    dense: &mut Outputs,
    (t, y, slope): (f64, &[f64], &[f64]),
    moment: f64,
) -> Vec<f64> {
    let n = dynamics.n;
    for ((later, y), slope) in dense.state.iter_mut().zip(y).zip(slope) {
        *later = y + moment * slope;
    }
    dynamics.derivative(t + moment, &dense.state, &mut dense.slope);
    let accelerations = dense.slope[n..2 * n].iter().zip(&slope[n..2 * n]);
    accelerations.map(|(later, now)| later - now).collect()
}

/// Lets the measure of errors know what rounding leaves at the state `y` with the derivative `slope`.
pub(super) fn observe_rounding(
    dynamics: &mut Dynamics<'_>,
    dense: &mut Outputs,
    scale: &mut ErrorScale,
    (t, y, slope): (f64, &[f64], &[f64]),
) {
    let change = rounding(dynamics, dense, (t, y, slope));
    scale.observe_rounding(dynamics.mass(t, y), &change);
}

/// The larger one of the `error` of a step from `t` on and of how far joints were from holding at its end, which has been `moved` from the one
/// to the other. Where that tells, rounding of the accelerations that joints take away is none of it: a mechanism that rests has no other motion.
pub(super) fn with_joints(
    dynamics: &mut Dynamics<'_>,
    scale: &mut ErrorScale,
    (error, tolerance): (f64, f64),
    (before, after): (&[f64], &[f64]),
    (t, y, h): (f64, &[f64], f64),
) -> f64 {
    let moved = |scale: &ErrorScale| {
        let pairs = before.iter().zip(after).enumerate();
        pairs.fold(0.0_f64, |most, (k, (before, after))| {
            most.max((after - before).abs() / scale.allowed(k, h, tolerance))
        })
    };
    if moved(scale) > error.max(TELLS)
        && let Some(held) = motion::held_by_joints(dynamics, t, y)
    {
        scale.observe_held(dynamics.mass(t, y), &held);
    }
    error.max(moved(scale))
}

/// By how much the last digits of the state `y` change its accelerations, which are those of `slope`.
fn rounding(
    dynamics: &mut Dynamics<'_>,
    dense: &mut Outputs,
    (t, y, slope): (f64, &[f64], &[f64]),
) -> Vec<f64> {
    let n = dynamics.n;
    let mut change = vec![0.0_f64; n];
    // All digits one way, and neighbours against each other: what one choice hides in a difference shows in the other.
    for other in [1.0, -1.0] {
        for (k, (moved, y)) in dense.state.iter_mut().zip(y).enumerate() {
            let sense = if k % 2 == 0 { 1.0 } else { other };
            *moved = y * (1.0 + sense * f64::EPSILON);
        }
        dynamics.derivative(t, &dense.state, &mut dense.slope);
        let accelerations = dense.slope[n..2 * n].iter().zip(&slope[n..2 * n]);
        for (change, (moved, now)) in change.iter_mut().zip(accelerations) {
            *change = change.max((moved - now).abs());
        }
    }
    change
}

/// Expects a first step by the free accelerations, to which those of the first contact mode are compared: beside what
/// would give the velocities in a glance `h`, any of them would be small.
pub(super) fn expect(
    dynamics: &mut Dynamics<'_>,
    scale: &ErrorScale,
    (t, y, h): (f64, &[f64], f64),
    longest: f64,
) {
    let n = dynamics.n;
    dynamics.observe(t, y, h);
    let a = dynamics.free_acceleration().to_vec();
    let mass = dynamics.mass(t, y);
    let time = scale.time_at_start(mass, &y[n..2 * n], &a);
    dynamics.expect_moment(time.min(longest));
}

/// A first step size after the state `y` with the derivative `slope`: a share of the shortest time in which velocities or accelerations
/// change, these within a `moment`.
pub(super) fn first(
    dynamics: &mut Dynamics<'_>,
    dense: &mut Outputs,
    scale: &ErrorScale,
    (t, y, slope): (f64, &[f64], &[f64]),
    (moment, longest, tolerance): (f64, f64, f64),
) -> f64 {
    let change = change(dynamics, dense, (t, y, slope), moment);
    let mass = dynamics.mass(t, y);
    let time = scale.shortest_time(mass, &change, moment);
    let h = (tolerance.powf(1.0 / 8.0) * time).min(longest);
    dynamics.expect_moment(h);
    h
}
