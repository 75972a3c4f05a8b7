//! How the objective of a scene changes: the integral of its running cost, and its final cost.

use super::matrix::Matrix;
use super::wanted::Wanted;
use crate::model::{Model, OptimalControlDeclaration};

/// The derivatives of an objective that reads nothing of contacts, as far as the walk has come.
pub(super) struct Cost<'c> {
    wanted: &'c Wanted,
    task: OptimalControlDeclaration,
    /// Derivatives by the quantities.
    pub(super) sum: Vec<f64>,
}

impl<'c> Cost<'c> {
    /// That of a scene, if it declares one.
    pub(super) fn of(model: &dyn Model, wanted: &'c Wanted) -> Option<Self> {
        let task = model.declaration().optimal_control?;
        let declared = task.running_cost || task.final_cost;
        (declared && !task.contacts.any()).then(|| Self {
            wanted,
            task,
            sum: vec![0.0; wanted.count()],
        })
    }

    /// Adds what passes at a place `x` within a time that has this weight in the integral.
    pub(super) fn pass(&mut self, columns: usize, (x, weight): (&[f64], f64), state: &Matrix) {
        let Some(by) = self.running(columns, x) else {
            return;
        };
        for (k, sum) in self.sum.iter_mut().enumerate() {
            *sum += weight * self.wanted.along(&by, state, k);
        }
    }

    /// Derivatives of the running cost at a place, if there is one.
    pub(super) fn running(&self, columns: usize, x: &[f64]) -> Option<Vec<f64>> {
        self.task.running_cost.then(|| {
            let mut by = vec![0.0; columns];
            self.wanted.derivatives.running_cost(x, &mut by);
            by
        })
    }

    /// Adds what the integral gains where its limit at `x` moves.
    pub(super) fn move_limit(&mut self, model: &dyn Model, x: &[f64], moves: &[f64], sense: f64) {
        if !self.task.running_cost {
            return;
        }
        let mut values = vec![0.0; self.task.path_functions()];
        model.path_functions(x, &mut values);
        for (sum, moves) in self.sum.iter_mut().zip(moves) {
            *sum += sense * values[0] * moves;
        }
    }

    /// The derivatives of the whole objective, of a motion that ends at `z = (q, v, T)` with the derivatives `end` of
    /// `(q, v)` and `moves` of the time.
    pub(super) fn at_the_end(&self, z: &[f64], end: &Matrix, moves: &[f64]) -> Vec<f64> {
        let mut by = vec![0.0; z.len() + self.wanted.parameters];
        if self.task.final_cost {
            self.wanted.derivatives.final_cost(z, &mut by);
        }
        let time = z.len() - 1;
        let columns = self.sum.iter().zip(moves).enumerate();
        columns
            .map(|(k, (sum, moves))| {
                let states: f64 = (0..time).map(|i| by[i] * end.row(i)[k]).sum();
                let own = self.wanted.of_parameters(&by[time + 1..], k);
                sum + states + by[time] * moves + own
            })
            .collect()
    }
}
