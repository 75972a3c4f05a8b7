//! What a scene declares in `outputs`, evaluated at the states of a motion, and the impulses for it.

use std::fmt;
use std::sync::Arc;

use crate::joints::joint_forces;
use crate::model::{Model, VariableDeclaration, joint_rows};

/// The scene of a motion, with its parameters.
#[derive(Clone)]
pub(super) struct Recorder(Arc<dyn Model>);

/// One instant of a motion.
#[derive(Clone, Copy)]
pub(super) struct Instant<'a> {
    pub(super) time: f64,
    pub(super) q: &'a [f64],
    pub(super) v: &'a [f64],
    pub(super) u: &'a [f64],
    pub(super) contact_force: &'a [f64],
    pub(super) friction_force: &'a [f64],
    pub(super) impulses: &'a [f64],
}

/// Impulses of all contacts over a motion.
#[derive(Debug, Clone, Default)]
pub(super) struct Impulses {
    /// Impacts until each instant of the trajectory, as far as there are any.
    pub(super) done: Vec<usize>,
    /// Sums of their impulses, the normal ones of all contacts and then the tangential ones: after none of them, after
    /// the first, and so on.
    pub(super) sums: Vec<Vec<f64>>,
}

impl Impulses {
    /// The sums at instant `k`; `None` before the first impact.
    pub(super) fn at(&self, k: usize) -> Option<&[f64]> {
        let done = self.done.get(k).or(self.done.last()).copied()?;
        self.sums.get(done).map(Vec::as_slice)
    }
}

impl Recorder {
    /// None for a scene without outputs.
    pub(super) fn of(model: &dyn Model) -> Option<Self> {
        (!model.outputs().is_empty()).then(|| Self(Arc::from(model.boxed())))
    }

    /// Whether an output depends on the impulses at an instant that does not know them.
    pub(super) fn misses_impulses(&self, at: Instant<'_>) -> bool {
        let zeros = vec![0.0; at.impulses.len()];
        let impulses = &zeros[..];
        let with = self.values(Instant { impulses, ..at });
        let without = self.values(at);
        without
            .iter()
            .zip(with)
            .any(|(without, with)| without.is_nan() && !with.is_nan())
    }

    /// Names and units.
    pub(super) fn declared(&self) -> &'static [VariableDeclaration] {
        self.0.outputs()
    }

    /// The values at an instant.
    pub(super) fn values(&self, at: Instant<'_>) -> Vec<f64> {
        let x = [at.q, at.v, at.u, &[at.time]].concat();
        let mut contacts = [at.contact_force, at.friction_force].concat();
        contacts.resize(2 * at.contact_force.len(), 0.0);
        contacts.extend(at.impulses);
        if joint_rows(&*self.0) > 0 {
            contacts.resize(4 * at.contact_force.len(), 0.0);
            let forces = joint_forces(&*self.0, &x, at.contact_force, at.friction_force);
            contacts.extend(forces);
        }
        let mut values = vec![f64::NAN; self.declared().len()];
        self.0.output_values(&x, &contacts, &mut values);
        values
    }
}

impl fmt::Debug for Recorder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.declared().iter().map(|known| known.name);
        f.debug_list().entries(names).finish()
    }
}
