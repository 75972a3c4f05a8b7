//! Second-order corrections against the Maratos effect.

use super::line_search::{Acceptance, Reference};
use super::solver::Loop;

impl Loop<'_, '_, '_, '_> {
    /// Tries at most `maximum_corrections` steps with the residual
    /// `c_soc <- alpha c_soc + c(trial)` (Waechter and Biegler 2006, section 2.4) while each lowers the
    /// violation to 99 %. An accepted point is in `trial`, its step in `correction`.
    pub(crate) fn second_order_correction(
        &mut self,
        reference: &Reference,
        alpha: f64,
    ) -> Acceptance {
        let mut previous = self.trial_values.theta;
        let mut factor = alpha;
        self.corrected_residual
            .copy_from_slice(&self.values.residual);
        for _ in 0..self.core.settings.maximum_corrections {
            for (c, trial) in self
                .corrected_residual
                .iter_mut()
                .zip(&self.trial_values.residual)
            {
                *c = factor * *c + trial;
            }
            let residual = self.core.kkt.direction(
                &self.problem,
                &self.iterate,
                &self.lagrangian,
                &self.corrected_residual,
                self.mu,
                &mut self.correction,
            );
            if residual > 1e-5 {
                return Acceptance::None;
            }
            let step = self.longest_step(&self.correction);
            if !self.take_trial(step, true) {
                return Acceptance::None;
            }
            let (acceptance, _) = self.judge(reference, alpha, alpha);
            if acceptance != Acceptance::None {
                return acceptance;
            }
            let theta = self.trial_values.theta;
            if theta > 0.99 * previous {
                return Acceptance::None;
            }
            previous = theta;
            factor = step;
        }
        Acceptance::None
    }
}
