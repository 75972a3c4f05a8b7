//! How the objective of a scene changes: the integral of its running cost, and its final cost.

use std::sync::Arc;

use super::tangent::{Layout, Tangent, add};
use crate::model::{Function, Model, OptimalControlDeclaration, ParameterDerivatives};

/// An objective that reads nothing of contacts.
pub(super) struct Cost<'c> {
    model: &'c dyn Model,
    derivatives: Arc<ParameterDerivatives>,
    layout: Layout,
    task: OptimalControlDeclaration,
}

impl<'c> Cost<'c> {
    /// That of a scene, if it declares one.
    pub(super) fn of(
        model: &'c dyn Model,
        derivatives: &Arc<ParameterDerivatives>,
        layout: Layout,
    ) -> Option<Self> {
        let task = model.declaration().optimal_control?;
        let declared = task.running_cost || task.final_cost;
        (declared && !task.contacts.any()).then(|| Self {
            model,
            derivatives: Arc::clone(derivatives),
            layout,
            task,
        })
    }

    /// The running cost at a place, 0 without one.
    pub(super) fn rate(&self, x: &[f64]) -> f64 {
        if !self.task.running_cost {
            return 0.0;
        }
        let mut values = vec![0.0; self.task.path_functions()];
        self.model.values(Function::Path, x, &mut values);
        values[0]
    }

    /// Derivatives of the running cost at a place, if there is one.
    pub(super) fn running(&self, x: &[f64]) -> Option<Vec<f64>> {
        self.task.running_cost.then(|| {
            let mut by = vec![0.0; self.layout.columns()];
            self.derivatives.running_cost(x, &mut by);
            by
        })
    }

    /// The derivatives of the whole objective, of a motion that ends at `z = (q, v, T)` with these derivatives, at an end that moves.
    pub(super) fn at_the_end(&self, z: &[f64], end: &Tangent) -> Vec<f64> {
        let mut sum = end.all.row(self.layout.cost()).to_vec();
        if self.task.final_cost {
            let states = z.len() - 1;
            let mut by = vec![0.0; z.len() + self.layout.parameters];
            self.derivatives.final_cost(z, &mut by);
            let rows = (0..states).chain(self.layout.time()..self.layout.impulses());
            for (row, by) in rows.zip(&by) {
                add(&mut sum, *by, end.all.row(row));
            }
        }
        sum
    }
}
