//! A motion that was found earlier, as a start for a neighbouring problem.

use super::global::Relaxed;
use super::path::Path;
use super::problem::{Horizon, Problem};
use super::sequence::{Place, Sequence};
use crate::model::Model;
use crate::simulation::InputError;

/// Switches nearer to an interval end than this share of the interval keep to it.
const AT_THE_END: f64 = 1e-9;

/// Controls, states and contact sequence of an earlier solution; see
/// [`Guess::Previous`](super::Guess::Previous).
#[derive(Debug, Clone, PartialEq)]
pub struct Previous {
    path: Path,
    sequence: Sequence,
}

impl Previous {
    pub(super) fn new(path: Path, sequence: Sequence) -> Self {
        Self { path, sequence }
    }

    /// The motion over the intervals of a problem, over its horizon if that is given.
    pub(super) fn path(&self, model: &dyn Model, problem: &Problem) -> Result<Path, InputError> {
        let declaration = model.declaration();
        let states = 2 * declaration.coordinates.len() + declaration.contacts.len();
        let lengths = [
            ("states", self.path.states.first(), states),
            (
                "controls",
                self.path.controls.values().first(),
                declaration.controls.len(),
            ),
        ];
        for (what, values, expected) in lengths {
            let found = values.map_or(0, Vec::len);
            if found != expected {
                return Err(InputError::WrongLength {
                    what: format!("the {what} of the previous motion, which is of another scene,"),
                    found,
                    expected,
                });
            }
        }
        let mut path = self.path.clone();
        let shape = path.controls.shape();
        path.controls = path.controls.resampled(shape, problem.intervals);
        if let Horizon::Fixed(horizon) = problem.horizon {
            let factor = horizon / path.horizon;
            path.time.iter_mut().for_each(|time| *time *= factor);
            path.horizon = horizon;
        }
        Ok(path)
    }

    /// Number of control intervals.
    pub(super) fn intervals(&self) -> usize {
        self.path.controls.intervals()
    }

    /// Controls of each interval, or at the nodes.
    pub(super) fn controls(&self) -> Vec<Vec<f64>> {
        self.path.controls.values().to_vec()
    }

    /// The motion on another number of intervals.
    pub(super) fn resampled(&self, intervals: usize) -> Self {
        let mut path = self.path.clone();
        path.controls = path.controls.resampled(path.controls.shape(), intervals);
        let relaxed = self.relaxed(&path, intervals);
        Self::new(relaxed.path, relaxed.sequence)
    }

    /// `path` with the contact sequence on that many intervals.
    pub(super) fn relaxed(&self, path: &Path, intervals: usize) -> Relaxed {
        let factor = intervals as f64 / self.path.controls.intervals() as f64;
        let mut sequence = self.sequence.clone();
        for switch in &mut sequence.switches {
            let time = switch.time * factor;
            let whole = (time - time.round()).abs() < AT_THE_END;
            switch.time = time;
            if switch.place == Place::Start && whole {
                switch.interval = (time.round() as usize).min(intervals);
            } else {
                switch.place = Place::Inside;
                switch.interval = (time as usize).min(intervals - 1);
            }
        }
        Relaxed {
            objective: f64::INFINITY,
            path: path.clone(),
            sequence,
        }
    }
}
