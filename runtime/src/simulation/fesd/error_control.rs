//! The lengths of elements under error control, and the error of a run without it.

use crate::fesd::finite_element::{FiniteElement, MotionSize, local_error};
use crate::linalg::products::largest;
use crate::simulation::InitialValueProblem;

/// Largest share of the horizon that an element may take under error control: a flight has no error, but
/// passes over ground.
const LONGEST: f64 = 0.1;
/// Largest share of the horizon that the first element may take, for a tolerance of one.
const FIRST: f64 = 0.25;
/// Share of the horizon below which slow starts do not shorten the first element.
const LEAST_FIRST: f64 = 1e-9;
/// Smallest and largest change of the element length.
const LENGTH_CHANGE: (f64, f64) = (0.2, 4.0);
/// Halvings of the elements of a step before it counts as failed.
const MAX_HALVINGS: usize = 8;
/// Halvings of a step under error control, where each halves the length that lasts.
const MAX_CONTROLLED_HALVINGS: usize = 24;

/// How errors are measured and kept small.
pub(super) struct ErrorControl {
    /// Error estimate that an element may have; none: elements of equal length.
    pub(super) tolerance: Option<f64>,
    /// Element length that the error control proposes \[s\].
    pub(super) proposed_length: f64,
    /// Largest values of the motion so far.
    pub(super) motion: MotionSize,
    /// Sums of the local errors of the elements, of each coordinate and then of each velocity.
    pub(super) local_errors: Vec<f64>,
    /// Sum of the errors of steps that were solved as programs, relative to the motion.
    pub(super) estimate: f64,
    horizon: f64,
    /// Longest element \[s\].
    pub(super) longest: f64,
    stages: usize,
}

impl ErrorControl {
    /// Of a run with so many coordinates of a mechanism.
    pub(super) fn new(problem: &InitialValueProblem, mechanical: usize, stages: usize) -> Self {
        Self {
            tolerance: None,
            proposed_length: problem.horizon,
            motion: MotionSize::new(&problem.q, &problem.v, mechanical),
            local_errors: vec![0.0; problem.q.len() + problem.v.len()],
            estimate: 0.0,
            horizon: problem.horizon,
            longest: LONGEST * problem.horizon,
            stages,
        }
    }

    /// Proposes the first element length from the start's velocity and acceleration: a share of the horizon and of the
    /// time in which the velocity changes, which falls with the tolerance, so that two runs do not share their first
    /// elements.
    pub(super) fn propose_first(&mut self, v: &[f64], acceleration: &[f64]) {
        let Some(tolerance) = self.tolerance else {
            return;
        };
        let share = tolerance.powf(1.0 / (self.stages as f64 + 1.0));
        let mut length = FIRST * self.horizon;
        let (speed, acceleration) = (largest(v), largest(acceleration));
        if speed > 0.0 && acceleration > 0.0 {
            // What an impact leaves of a velocity may be rounding error, which says nothing of the motion that follows.
            length = length.min((speed / acceleration).max(LEAST_FIRST * self.horizon));
        }
        self.proposed_length = share * length;
    }

    /// Updates the proposed length from the error estimate of the solved `element`, at whose start the acceleration is
    /// given; true if the element must be shorter.
    pub(super) fn rejects(
        &mut self,
        element: &mut FiniteElement<'_>,
        acceleration: &[f64],
    ) -> bool {
        let Some(tolerance) = self.tolerance else {
            return false;
        };
        let error = element.relative_error(acceleration, &self.motion);
        let ratio = error / tolerance;
        let order = self.stages as f64 + 1.0;
        let factor = 0.9 * ratio.max(1e-12).powf(-1.0 / order);
        if factor < LENGTH_CHANGE.0 {
            // So far off, Newton's method may have found stages that have nothing to do with the motion.
            element.forget();
        }
        let proposed = element.length * factor.clamp(LENGTH_CHANGE.0, LENGTH_CHANGE.1);
        self.proposed_length = proposed.min(self.longest);
        ratio > 1.0
    }

    /// Whether an element of this `length` leaves the ground between its stages by more than its tolerance, where `drift`
    /// is by how much it does so; the next one is half as long.
    pub(super) fn strays(&mut self, drift: f64, length: f64) -> bool {
        let strays = self.tolerance.is_some_and(|tolerance| drift > tolerance);
        if strays {
            self.proposed_length = 0.5 * length;
        }
        strays
    }

    /// Adds the local error of the solved element.
    pub(super) fn add_error(&mut self, element: &FiniteElement<'_>, acceleration: &[f64]) {
        local_error::add(element, acceleration, &self.motion, &mut self.local_errors);
    }

    /// Proposes half of the `length` of a segment that failed.
    pub(super) fn shorten(&mut self, length: f64) {
        if self.tolerance.is_some() {
            self.proposed_length = 0.5 * length;
        }
    }

    /// Halvings before a segment counts as failed.
    pub(super) fn most_halvings(&self) -> usize {
        match self.tolerance {
            None => MAX_HALVINGS,
            Some(_) => MAX_CONTROLLED_HALVINGS,
        }
    }

    /// End and number of elements of the next segment, which begins at `time` and could go on until `end`: there by as many
    /// elements as `share`, that of its step times the elements of a step, says, or one of the length that is proposed.
    pub(super) fn plan(&self, time: f64, end: f64, share: f64, halvings: usize) -> (f64, usize) {
        let remaining = end - time;
        if self.tolerance.is_none() {
            return (end, (share.round() as usize).max(1) << halvings);
        }
        let length = self.proposed_length;
        if remaining <= 1.01 * length {
            (end, 1)
        } else {
            // Two nearly equal elements rather than one and a sliver.
            (time + length.min(0.5 * remaining), 1)
        }
    }
}
