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
pub(crate) struct Instant<'a> {
    pub(crate) time: f64,
    pub(crate) q: &'a [f64],
    pub(crate) v: &'a [f64],
    pub(crate) u: &'a [f64],
    pub(crate) contact_force: &'a [f64],
    pub(crate) friction_force: &'a [f64],
    pub(crate) impulses: &'a [f64],
}

impl Instant<'_> {
    /// What outputs read: `(q, v, u, t)`, and forces and impulses so far of all contacts with forces of joints.
    pub(crate) fn read(self, model: &dyn Model) -> [Vec<f64>; 2] {
        let x = [self.q, self.v, self.u, &[self.time]].concat();
        let contacts = self.contact_force.len();
        let mut read = [self.contact_force, self.friction_force].concat();
        read.resize(2 * contacts, 0.0);
        read.extend(self.impulses);
        read.resize(4 * contacts, 0.0);
        if joint_rows(model) > 0 {
            let forces = joint_forces(model, &x, self.contact_force, self.friction_force);
            read.extend(forces);
        }
        [x, read]
    }

    /// What a scene records there.
    pub(crate) fn outputs(self, model: &dyn Model) -> Vec<f64> {
        let [x, read] = self.read(model);
        let mut values = vec![f64::NAN; model.outputs().len()];
        model.output_values(&x, &read, &mut values);
        values
    }
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
        at.outputs(&*self.0)
    }
}

impl fmt::Debug for Recorder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.declared().iter().map(|known| known.name);
        f.debug_list().entries(names).finish()
    }
}
