//! Where the unknowns and rows of a collocation program are, and the conditions between its stages.

use crate::model::Pieces;
use crate::simulation::{ContactMode, Direction};

/// Bounds of a variable that has none.
pub(in crate::ocp) const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// What must hold between the stages of a phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::ocp) enum CutKind {
    /// `g_i >= margin`.
    Gap(usize, f64),
    /// The coordinate stays within its bounds.
    Bounds(usize),
    /// The path constraint holds.
    Path(usize),
    /// The normal acceleration of a contact is at least 0, at the start of the phase or right after it.
    Departure(usize),
    /// The normal velocity of a contact is at most 0, right before it closes.
    Approach(usize),
    /// A sticking contact's force stays on its side of the edge from which it would slip that way.
    Cone(usize, Direction),
    /// A slipping contact does not slip back.
    Slip(usize),
}

/// A condition inside a phase, at the share `theta` of its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::ocp) struct Cut {
    pub(in crate::ocp) interval: usize,
    /// Index of the phase in its interval, and the number of phases there.
    pub(in crate::ocp) phase: (usize, usize),
    pub(in crate::ocp) theta: f64,
    pub(in crate::ocp) kind: CutKind,
}

/// Where a distance is kept.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::ocp) enum Kept {
    /// By the bound of a row that is not infinite.
    Row(usize),
    /// By the lower bound of a variable.
    Variable(usize),
    /// By the row of the time that a contact needs to come to rest: the amount is a sum of variables with these factors.
    Settling {
        row: usize,
        contact: usize,
        impulse: Vec<(usize, f64)>,
    },
}

/// A distance that a plan keeps for the sake of the method, though the scene does not ask for it.
#[derive(Debug, Clone)]
pub(in crate::ocp) struct Distance {
    pub(in crate::ocp) name: String,
    pub(in crate::ocp) kept: Kept,
    /// How much is kept; of a contact that comes to rest the unit of that, as it depends on the motion.
    pub(in crate::ocp) amount: f64,
    /// Unit of that; empty where the scene has none.
    pub(in crate::ocp) unit: String,
    /// Whether the caller chooses it, as the gap margin.
    pub(in crate::ocp) chosen: bool,
}

impl Phase {
    /// Whether a contact bounces from the start on until it rests.
    pub(in crate::ocp) fn settles(&self, contact: usize) -> bool {
        self.settling
            .iter()
            .any(|&(settling, _)| settling == contact)
    }
}

/// Variables of a stage.
pub(in crate::ocp) struct Stage {
    /// `q` then `v`.
    pub(in crate::ocp) state: Vec<usize>,
    /// Controls at the stage, those of the interval where they are constant, and the time where the model reads it.
    pub(in crate::ocp) drive: Vec<usize>,
    /// Normal accelerations of the closed contacts times the length of the phase, in the order of
    /// [`Phase::closed`].
    pub(in crate::ocp) forces: Vec<usize>,
    /// Row of each contact's gap; none of most pieces of edges that do not act.
    pub(in crate::ocp) gap_rows: Vec<Option<usize>>,
    /// The closed contacts with friction.
    pub(in crate::ocp) tangential: Vec<Tangential>,
    /// Normal and then tangential accelerations that all contacts provide, as far as the scene reads their forces; none
    /// where they are 0, and nothing at all in scenes that read no forces.
    pub(in crate::ocp) provided: Vec<Option<usize>>,
}

/// A closed contact with friction at a stage or in an impact: where its unknown and its conditions are.
pub(in crate::ocp) struct Tangential {
    pub(in crate::ocp) contact: usize,
    pub(in crate::ocp) mode: ContactMode,
    /// Normal force or impulse.
    pub(in crate::ocp) normal: usize,
    /// Unit of its velocities, and of accelerations times lengths.
    pub(in crate::ocp) unit: f64,
    /// Tangential force or impulse, if the contact sticks.
    pub(in crate::ocp) force: Option<usize>,
    /// Tangential force or impulse of a contact that slips, where its coefficient of friction is an unknown.
    pub(in crate::ocp) slipping: Option<usize>,
    /// Rows that hold on both sides: of the friction cone, towards the direction in which the contact would slip; or
    /// of the sliding velocity in the direction of the slip.
    pub(in crate::ocp) rows: Vec<(Direction, usize)>,
}

/// One element of a phase and where its unknowns are.
pub(in crate::ocp) struct Phase {
    pub(in crate::ocp) interval: usize,
    /// Index in its interval, and the number of elements there.
    pub(in crate::ocp) index: (usize, usize),
    pub(in crate::ocp) closed: Vec<usize>,
    /// ContactMode of each contact.
    pub(in crate::ocp) modes: Vec<ContactMode>,
    /// The pieces of edges that act.
    pub(in crate::ocp) pieces: Pieces,
    /// State `(q, v)` at the start, after any jump.
    pub(in crate::ocp) start: Vec<usize>,
    pub(in crate::ocp) stages: Vec<Stage>,
    /// Its rows.
    pub(in crate::ocp) rows: std::ops::Range<usize>,
    /// Length: `factor` times this variable.
    pub(in crate::ocp) scale: usize,
    pub(in crate::ocp) factor: f64,
    /// (contact, row) of the normal acceleration after an opening at a jump of the controls.
    pub(in crate::ocp) openings: Vec<(usize, usize)>,
    /// (contact, row) of the sliding acceleration of contacts that are pulled into slip at the start.
    pub(in crate::ocp) pulled: Vec<(usize, usize)>,
    /// (contact, direction of the slip beyond, row) of the friction cones of sticking contacts at the start, or over the element of those
    /// that bounce until they rest.
    pub(in crate::ocp) cones: Vec<(usize, Direction, usize)>,
    /// (contact, row) of the time that contacts need to come to rest which bounce from the start on.
    pub(in crate::ocp) settling: Vec<(usize, usize)>,
    /// (share of the length, contact, direction, row) of the cones and sliding velocities that are kept between the stages, as in
    /// [`Tangential::rows`].
    pub(in crate::ocp) between: Vec<(f64, usize, Direction, usize)>,
    /// Contacts that begin to slip at the start with no acceleration.
    pub(in crate::ocp) yielded: Vec<usize>,
    /// The coordinates whose velocities joints decide.
    pub(in crate::ocp) decided: Vec<usize>,
    /// The switch at the end inside the interval, as an index into the sequence.
    pub(in crate::ocp) ends_with: Option<usize>,
    /// The contacts that close or are touched at the end.
    pub(in crate::ocp) closing: Vec<usize>,
}

/// A phase with its numbers.
pub(in crate::ocp) struct SolvedPhase {
    /// Start and length \[s\].
    pub(in crate::ocp) start: f64,
    pub(in crate::ocp) length: f64,
    /// Input vectors of the model at the start and the stages.
    pub(in crate::ocp) inputs: Vec<Vec<f64>>,
}
