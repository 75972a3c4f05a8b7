//! What the construction of a collocation program has come to: the program so far and where it stands.

use super::discretization::Setting;
use super::layout::{Cut, Distance, Phase, Tangential};
use crate::model::Pieces;
use crate::ocp::motion::sequence::Switch;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::frame::Frame;
use crate::program::sparse_program::Program;
use crate::simulation::ContactMode;

/// State of the construction. The rows themselves are added by the functions of the other files.
pub(super) struct Builder<'a, 's> {
    pub(super) setting: Setting<'a>,
    pub(super) program: Program<'a>,
    pub(super) guess: &'s Trajectory,
    pub(super) cuts: &'s [Cut],
    /// Finite elements of a phase in each interval.
    pub(super) elements: &'s [usize],
    pub(super) frame: Frame<'a>,
    pub(super) phases: Vec<Phase>,
    /// Contacts with friction in the impacts, by the index of the switch.
    pub(super) impacts: Vec<(usize, Tangential)>,
    /// ContactMode of each contact now.
    pub(super) modes: Vec<ContactMode>,
    /// The pieces of edges that act now.
    pub(super) pieces: Pieces,
    pub(super) touches: Vec<(Switch, usize)>,
    pub(super) distances: Vec<Distance>,
    /// Variables of the state `(q, v)` now.
    pub(super) state: Vec<usize>,
    /// What drove the motion at the end of the phase before; nothing at the start, at time 0.
    pub(super) before: Vec<usize>,
    /// The variable of the length of the present phase between two switches.
    pub(super) duration: Option<usize>,
    /// Number of coordinates.
    pub(super) n: usize,
}

impl Builder<'_, '_> {
    /// The closed contacts.
    pub(super) fn closed(&self) -> Vec<usize> {
        let modes = self.modes.iter().enumerate();
        modes
            .filter(|(_, m)| !m.is_open())
            .map(|(i, _)| i)
            .collect()
    }

    /// The time that the phases before an interval take, as a sum of `coefficient variable`.
    pub(super) fn passed(&self, interval: usize) -> Vec<(usize, f64)> {
        let phases = self.phases.iter();
        let before = phases.take_while(|phase| phase.interval < interval);
        before.map(|phase| (phase.scale, phase.factor)).collect()
    }

    /// Length of an interval in the guess \[s\], if all are equal.
    pub(super) fn interval_length(&self) -> f64 {
        self.guess.horizon / self.setting.problem.intervals as f64
    }

    /// Time in the guess at a share of an interval \[s\].
    pub(super) fn guessed_time(&self, interval: usize, share: f64) -> f64 {
        match self.setting.lengths.span(interval) {
            Some((span, place)) => {
                span.from + (span.to - span.from) * (place as f64 + share) / span.pieces as f64
            }
            None => (interval as f64 + share) * self.interval_length(),
        }
    }
}
