//! What a scene declares in `outputs`, evaluated at the states of a motion.

use std::fmt;
use std::sync::Arc;

use crate::model::{Model, VariableDeclaration};

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
}

impl Recorder {
    /// None for a scene without outputs.
    pub(super) fn of(model: &dyn Model) -> Option<Self> {
        (!model.outputs().is_empty()).then(|| Self(Arc::from(model.boxed())))
    }

    /// Names and units.
    pub(super) fn declared(&self) -> &'static [VariableDeclaration] {
        self.0.outputs()
    }

    /// The values at an instant.
    pub(super) fn values(&self, at: Instant<'_>) -> Vec<f64> {
        let x = [at.q, at.v, at.u, &[at.time]].concat();
        let mut forces = [at.contact_force, at.friction_force].concat();
        forces.resize(2 * at.contact_force.len(), 0.0);
        let mut values = vec![f64::NAN; self.declared().len()];
        self.0.output_values(&x, &forces, &mut values);
        values
    }
}

impl fmt::Debug for Recorder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.declared().iter().map(|known| known.name);
        f.debug_list().entries(names).finish()
    }
}
