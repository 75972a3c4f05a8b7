//! A motion that was found earlier, as a start for a neighbouring problem.

use super::problem::{Horizon, Problem};
use crate::model::Model;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::sequence::{Place, Sequence};
use crate::ocp::motion::trajectory::Trajectory;
use crate::refusal;
use crate::simulation::InputError;
use crate::yardstick;

/// Controls, states and contact sequence of an earlier solution; see
/// [`Guess::Previous`](super::Guess::Previous).
#[derive(Debug, Clone, PartialEq)]
pub struct Previous {
    trajectory: Trajectory,
    sequence: Sequence,
}

impl Previous {
    pub(in crate::ocp) fn new(trajectory: Trajectory, sequence: Sequence) -> Self {
        Self {
            trajectory,
            sequence,
        }
    }

    /// The motion over the intervals of a problem, over its horizon if that is given.
    pub(in crate::ocp) fn trajectory(
        &self,
        model: &dyn Model,
        problem: &Problem,
    ) -> Result<Trajectory, InputError> {
        let declaration = model.declaration();
        let states = 2 * declaration.coordinates.len() + declaration.contacts.len();
        let lengths = [
            ("states", self.trajectory.states.first(), states),
            (
                "controls",
                self.trajectory.controls.values().first(),
                declaration.controls.len(),
            ),
        ];
        for (what, values, expected) in lengths {
            let found = values.map_or(0, Vec::len);
            if found != expected {
                return Err(refusal::wrong_length(
                    format!("the {what} of the previous motion, which is of another scene,"),
                    found,
                    expected,
                ));
            }
        }
        let mut trajectory = self.trajectory.clone();
        let shape = trajectory.controls.shape;
        trajectory.controls = trajectory.controls.resampled(shape, problem.intervals);
        Ok(match problem.horizon {
            Horizon::Fixed(horizon) => trajectory.stretched(horizon),
            Horizon::Free { .. } => trajectory,
        })
    }

    /// Number of control intervals.
    pub(in crate::ocp) fn intervals(&self) -> usize {
        self.trajectory.controls.intervals()
    }

    /// Controls of each interval, or at the nodes.
    pub(in crate::ocp) fn controls(&self) -> Vec<Vec<f64>> {
        self.trajectory.controls.values().to_vec()
    }

    /// When each interval begins and the last one ends \[s\].
    pub(in crate::ocp) fn control_times(&self) -> Vec<f64> {
        self.trajectory.controls.times(self.trajectory.horizon)
    }

    /// Whether its intervals are divided among phases instead of being of equal length.
    pub(in crate::ocp) fn is_aligned(&self) -> bool {
        self.trajectory.controls.is_aligned()
    }

    /// The motion on another number of intervals, a multiple where they are aligned with phases.
    pub(in crate::ocp) fn resampled(&self, intervals: usize) -> Self {
        let mut trajectory = self.trajectory.clone();
        let controls = &trajectory.controls;
        trajectory.controls = match controls.is_aligned() {
            true => controls.divided(intervals / controls.intervals()),
            false => controls.resampled(controls.shape, intervals),
        };
        let candidate = self.candidate(&trajectory, intervals);
        Self::new(candidate.trajectory, candidate.sequence)
    }

    /// `trajectory` with the contact sequence on that many intervals.
    pub(in crate::ocp) fn candidate(&self, trajectory: &Trajectory, intervals: usize) -> Candidate {
        let factor = intervals as f64 / self.trajectory.controls.intervals() as f64;
        let mut sequence = self.sequence.clone();
        for switch in &mut sequence.switches {
            let time = switch.time * factor;
            let whole = (time - time.round()).abs() < yardstick::NOTHING;
            switch.time = time;
            if switch.place == Place::Start && whole {
                switch.interval = (time.round() as usize).min(intervals);
            } else {
                switch.place = Place::Inside;
                switch.interval = (time as usize).min(intervals - 1);
            }
        }
        Candidate {
            objective: f64::INFINITY,
            trajectory: trajectory.clone(),
            sequence,
        }
    }
}
