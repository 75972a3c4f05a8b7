//! What the dynamics remember of an evaluation: mode, switching functions, equations.

use crate::contact::shares::Shares;
use crate::contact::{ContactState, Line};
use crate::linalg::banded::{Banded, Entry};

/// The contact mode.
pub(in crate::simulation) struct Mode {
    /// State of each contact.
    pub(super) states: Vec<ContactState>,
    /// Active contacts, increasing: those that are not open.
    pub(in crate::simulation) active: Vec<usize>,
    /// Sliding velocities of contacts that stick.
    pub(super) sticking: Vec<Line>,
}

/// The switching functions: one for each contact, then two for each contact with friction.
pub(in crate::simulation) struct SwitchingFunctions {
    /// Their values at the last evaluation.
    pub(in crate::simulation) values: Vec<f64>,
    /// Smallest of `values` since the first sample of a step.
    pub(in crate::simulation) lowest: Vec<f64>,
    /// Largest of `values` since the first sample of a step.
    pub(in crate::simulation) highest: Vec<f64>,
    /// Whether nobody looks at the gaps of open contacts, on which the motion does not depend.
    pub(in crate::simulation) gaps_are_idle: bool,
    /// A contact one of whose functions could not be evaluated since the first sample of a step.
    pub(in crate::simulation) undefined: Option<usize>,
    /// Sizes of the terms that a switching function balances if it is a force,
    /// `|curvature| + sum_k |n_k a_k| + sum_j |D_ij r_j|` for a normal one: rounding error is a share of it.
    pub(in crate::simulation) force_scale: Vec<f64>,
    /// Accelerations that are nothing to a contact: `sqrt(D_i a'M a)`, the largest normal acceleration that
    /// forces of the size of those present could give, at the last change of the mode.
    pub(super) force_floor: Vec<f64>,
    /// Forces that pull no more than this are zero: so much was accepted with the mode.
    pub(super) accepted_pull: Vec<f64>,
}

impl SwitchingFunctions {
    pub(super) fn new(count: usize) -> Self {
        let zeros = || vec![0.0; count];
        Self {
            values: zeros(),
            lowest: zeros(),
            highest: zeros(),
            gaps_are_idle: false,
            undefined: None,
            force_scale: zeros(),
            force_floor: zeros(),
            accepted_pull: zeros(),
        }
    }

    /// Makes `values` the first sample of a step.
    pub(super) fn sample_from(&mut self, values: &[f64]) {
        self.lowest.copy_from_slice(values);
        self.highest.copy_from_slice(values);
        self.undefined = None;
    }
}

/// The equations for the contact accelerations of a mode.
pub(super) struct Equations {
    /// The lines of the last solution.
    pub(super) lines: Vec<Line>,
    /// What the unknowns add to the rows, row-major, as of the last solution.
    pub(super) couplings: Vec<f64>,
    /// The matrix of the couplings, taken apart where it is solved.
    pub(super) matrix: Vec<f64>,
    /// The couplings of many rows that do not vanish, row by row, and their factors; whether the last solution was by them.
    pub(super) entries: Vec<Entry>,
    pub(super) band: Banded,
    pub(super) banded: bool,
    pub(super) right: Vec<f64>,
    /// The right-hand sides of the last solution.
    pub(super) wanted: Vec<f64>,
    /// Where its rows follow from each other, the ways to share its forces.
    pub(super) shares: Option<Shares>,
    /// Normal and tangential contact accelerations at the last evaluation.
    pub(super) r: Vec<f64>,
    pub(super) s: Vec<f64>,
    /// Along the second sliding velocities.
    pub(super) across: Vec<f64>,
}

impl Equations {
    /// Of that many contacts and rows.
    pub(super) fn new(contacts: usize, rows: usize) -> Self {
        Self {
            lines: Vec::new(),
            couplings: Vec::new(),
            matrix: Vec::new(),
            entries: Vec::new(),
            band: Banded::default(),
            banded: false,
            right: vec![0.0; rows],
            wanted: Vec::new(),
            shares: None,
            r: vec![0.0; contacts],
            s: vec![0.0; contacts],
            across: vec![0.0; contacts],
        }
    }
}
