//! What to do when no step is found: larger shifts, restoration, or the end.

use super::Status;
use super::restoration::Restored;
use super::solver::{Loop, Outcome};

impl Loop<'_, '_, '_, '_> {
    /// After a failed line search or factorization: restoration, or a larger shift at points that are
    /// feasible already. `Some` ends the run.
    pub(crate) fn rescue(&mut self, had_direction: bool) -> Option<Outcome> {
        self.info.acceptance = ' ';
        self.info.step_length_primal = 0.0;
        let settings = &self.core.settings;
        let error = self.error(0.0);
        let feasible = self.values.infeasibility() <= 1e-2 * settings.tolerance;
        if self.is_restoration || feasible {
            if self.stalls < 6 {
                self.stalls += 1;
                self.filter.clear();
                self.shift_floor = (100.0 * self.shift_floor.max(self.inertia.delta_w)).max(1e-4);
                return None;
            }
            let acceptable = error.scaled() <= settings.acceptable_tolerance
                && self.sigma <= self.path.final_sigma();
            let status = if acceptable {
                Status::Acceptable
            } else if !had_direction {
                Status::FactorizationFailed
            } else if self.is_restoration {
                Status::RestorationFailed
            } else {
                Status::StepTooSmall
            };
            return Some(self.outcome(status));
        }
        self.restore(0.9)
    }

    /// Runs the restoration phase until the violation has fallen by `factor`.
    pub(crate) fn restore(&mut self, factor: f64) -> Option<Outcome> {
        if self.is_restoration {
            return None;
        }
        if self.values.infeasibility() <= 1e-2 * self.core.settings.tolerance {
            return None;
        }
        if self.last_restoration == Some(self.core.iterations) {
            return Some(self.outcome(Status::RestorationFailed));
        }
        let restored = self.restoration_phase(factor);
        // where the violation came back, it may not grow again: the phases to come end at a feasible point, or at the
        // least violation there is
        let reached = self.values.theta;
        if self.problem.products.is_empty() && reached >= self.restored_theta {
            self.filter.theta_max = self.filter.theta_max.min(reached);
        }
        self.restored_theta = self.restored_theta.min(reached);
        self.last_restoration = Some(self.core.iterations);
        self.info.acceptance = 'R';
        match restored {
            Restored::Continue => None,
            Restored::Ended(status) => {
                self.evaluate_first_derivatives();
                self.update_lagrangian();
                Some(self.outcome(status))
            }
        }
    }
}
