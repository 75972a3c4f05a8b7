//! What the dynamics remember of an evaluation: mode, switching functions, what the model has given, equations.

use crate::model::{Loads, Model, Space, contact_point, tangent_point};
use crate::simulation::event::contact_state::ContactState;

/// The contact mode.
pub(in crate::simulation) struct Mode {
    /// State of each contact.
    pub(super) states: Vec<ContactState>,
    /// Active contacts, increasing: those that are not open.
    pub(in crate::simulation) active: Vec<usize>,
    /// Sliding velocities of contacts that stick.
    pub(super) sticking: Vec<Stuck>,
}

/// A sliding velocity that is held: in space each contact has two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stuck {
    pub(super) contact: usize,
    /// Whether it is the second one.
    pub(super) across: bool,
}

/// The switching functions: one for each contact, then two for each contact with friction.
pub(in crate::simulation) struct SwitchingFunctions {
    /// Their values at the last evaluation.
    pub(in crate::simulation) values: Vec<f64>,
    /// Smallest of `values` since the first sample of a step.
    pub(in crate::simulation) lowest: Vec<f64>,
    /// Largest of `values` since the first sample of a step.
    pub(in crate::simulation) highest: Vec<f64>,
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

/// What the model has given at the state loaded.
pub(super) struct Evaluated {
    /// Input vector of the model, `(q, v, u[, t])`.
    pub(super) x: Vec<f64>,
    /// Acceleration without contact.
    pub(super) acceleration: Vec<f64>,
    /// The contacts, each laid out as in `contact_point`.
    pub(super) points: Vec<f64>,
    /// Their tangential sides, each laid out as in `tangent_point`.
    pub(super) tangents: Vec<f64>,
    /// What contacts in space have besides.
    pub(super) space: Option<Space>,
    /// What dry frictions follow of the forces of surfaces.
    pub(super) loads: Loads,
    /// Mass matrix, row-major.
    pub(super) mass: Vec<f64>,
}

impl Evaluated {
    pub(super) fn new(model: &dyn Model) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let contacts = declaration.contacts.len();
        Self {
            x: vec![0.0; declaration.inputs()],
            acceleration: vec![0.0; n],
            points: vec![0.0; contacts * contact_point::length(n)],
            tangents: vec![0.0; contacts * tangent_point::length(n)],
            space: Space::of(model),
            loads: Loads::default(),
            mass: vec![0.0; n * n],
        }
    }

    /// Contacts in space, if this is one.
    pub(super) fn space(&self, contact: usize) -> Option<&Space> {
        let space = self.space.as_ref();
        space.filter(|space| space.contains(contact))
    }

    /// Turns the frame of a contact in space so that it points along what is `to` in it, or along its sliding velocity where that
    /// has a direction.
    pub(super) fn align(&mut self, contact: usize, to: Option<(f64, f64)>) {
        let Some(space) = self.space.as_mut().filter(|space| space.contains(contact)) else {
            return;
        };
        let length = space.across(contact).len();
        let tangent = &mut self.tangents[contact * length..(contact + 1) * length];
        match to {
            Some(to) => space.align(contact, to, tangent),
            None => space.align_with_sliding(contact, tangent),
        }
    }
}

/// The equations for the contact accelerations of a mode.
pub(super) struct Equations {
    /// `d_i`, or `d_i - mu e_i` and `d_i + mu e_i` for a contact that slips.
    pub(super) columns: Vec<f64>,
    /// What the unknowns add to the rows, row-major, as of the last solution.
    pub(super) couplings: Vec<f64>,
    /// The same, taken apart where it is solved.
    pub(super) matrix: Vec<f64>,
    /// Where a row has components.
    pub(super) support: Vec<usize>,
    pub(super) right: Vec<f64>,
    /// Normal and tangential contact accelerations at the last evaluation.
    pub(super) r: Vec<f64>,
    pub(super) s: Vec<f64>,
    /// Along the second sliding velocities.
    pub(super) across: Vec<f64>,
}

impl Equations {
    /// Of that many coordinates, contacts and rows.
    pub(super) fn new((n, contacts): (usize, usize), rows: usize) -> Self {
        Self {
            columns: vec![0.0; contacts * n],
            couplings: Vec::new(),
            matrix: Vec::new(),
            support: Vec::new(),
            right: vec![0.0; rows],
            r: vec![0.0; contacts],
            s: vec![0.0; contacts],
            across: vec![0.0; contacts],
        }
    }
}
