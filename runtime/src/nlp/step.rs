//! From an accepted step to the next iterate.

use super::iterate::safeguarded;
use super::line_search::{Acceptance, Search};
use super::solver::Loop;

impl Loop<'_, '_, '_, '_> {
    /// Takes over the trial point and updates multipliers, filter and shift.
    pub(crate) fn accept(&mut self, search: &Search) {
        let alpha = search.alpha;
        let direction = if search.corrected {
            &self.correction
        } else {
            &self.direction
        };
        self.info.step_norm = direction.v.iter().fold(0.0, |a: f64, d| a.max(d.abs()));
        let alpha_dual = self.longest_dual_step(direction);
        std::mem::swap(&mut self.iterate.v, &mut self.trial);
        std::mem::swap(&mut self.values, &mut self.trial_values);
        let m = self.problem.m;
        for (row, (y, d)) in self.iterate.y.iter_mut().zip(&direction.y).enumerate() {
            *y += if row < m { alpha } else { alpha_dual } * d;
        }
        for (z, d) in self.iterate.z_lower.iter_mut().zip(&direction.z_lower) {
            *z += alpha_dual * d;
        }
        for (z, d) in self.iterate.z_upper.iter_mut().zip(&direction.z_upper) {
            *z += alpha_dual * d;
        }
        self.safeguard();
        self.info.hessian_shift = self.inertia.delta_w;
        self.info.step_length_primal = alpha;
        self.info.step_length_dual = alpha_dual;
        self.info.trials = search.trials;
        self.info.acceptance = search.acceptance.letter(search.corrected);
        self.stalls = 0;
        self.soft_steps = 0;
        if search.acceptance == Acceptance::Tiny {
            self.tiny_steps += 1;
        } else {
            self.tiny_steps = 0;
        }
        if search.filter_rejected {
            self.filter_rejections += 1;
            if self.filter_rejections >= 5 && self.filter_resets < 5 {
                self.filter.clear();
                self.filter_rejections = 0;
                self.filter_resets += 1;
            }
        } else {
            self.filter_rejections = 0;
        }
        self.adapt_shift_floor(search);
    }

    /// Products make flat, curved valleys in which the line search would cut every step; a shift in
    /// proportion turns the direction instead.
    fn adapt_shift_floor(&mut self, search: &Search) {
        if self.problem.products.is_empty() {
            return;
        }
        if search.alpha < 0.3 * search.alpha_max {
            let shift = self.shift_floor.max(self.inertia.delta_w);
            self.shift_floor = (8.0 * shift).clamp(1e-4, 1e10);
        } else if search.alpha >= search.alpha_max {
            self.shift_floor /= 3.0;
            if self.shift_floor < 1e-7 {
                self.shift_floor = 0.0;
            }
        }
    }

    /// Six short steps in a row at an infeasible point: the iterates jam at their bounds, and Newton's method
    /// for the optimality conditions has lost its way. Product problems jam more easily.
    pub(crate) fn is_jammed(&mut self, search: &Search) -> bool {
        let short = if self.problem.products.is_empty() {
            0.01
        } else {
            0.05
        };
        if search.alpha < short && self.values.theta() > 1e-6 {
            self.jams += 1;
        } else {
            self.jams = 0;
        }
        if self.is_restoration || self.jams < 6 {
            return false;
        }
        self.jams = 0;
        true
    }

    /// Fifteen steps at infeasible points far out that lowered the objective only: it is unbounded below
    /// along directions that leave the violation as it is, and the violation has to be looked at alone.
    pub(crate) fn is_drifting(&mut self) -> bool {
        let theta = self.values.theta();
        let far = self.iterate.v.iter().any(|v| v.abs() > 1e8);
        if !far || theta <= 0.9 * self.drift_theta || theta <= self.core.settings.tolerance {
            self.drift_theta = theta;
            self.drift_steps = 0;
            return false;
        }
        self.drift_steps += 1;
        if self.is_restoration || self.drift_steps < 15 {
            return false;
        }
        self.drift_steps = 0;
        true
    }

    /// Bound multipliers near `mu / distance`; bounds moved away from points that reached them by
    /// rounding.
    pub(crate) fn safeguard(&mut self) {
        let mu = self.mu;
        for i in 0..self.iterate.v.len() {
            let v = self.iterate.v[i];
            if self.problem.lower[i].is_finite() {
                let smallest = f64::EPSILON * self.problem.lower[i].abs().max(mu.min(1.0) * 1e-4);
                if v - self.problem.lower[i] <= smallest {
                    let room = f64::EPSILON.powf(0.75) * self.problem.lower[i].abs().max(1.0);
                    self.problem.lower[i] = v - room.max(smallest);
                }
                let distance = v - self.problem.lower[i];
                self.iterate.z_lower[i] = safeguarded(self.iterate.z_lower[i], distance, mu);
            }
            if self.problem.upper[i].is_finite() {
                let smallest = f64::EPSILON * self.problem.upper[i].abs().max(mu.min(1.0) * 1e-4);
                if self.problem.upper[i] - v <= smallest {
                    let room = f64::EPSILON.powf(0.75) * self.problem.upper[i].abs().max(1.0);
                    self.problem.upper[i] = v + room.max(smallest);
                }
                let distance = self.problem.upper[i] - v;
                self.iterate.z_upper[i] = safeguarded(self.iterate.z_upper[i], distance, mu);
            }
        }
        if !self.is_restoration {
            for (k, slack) in self.problem.slacks.iter().enumerate() {
                if slack.row >= self.problem.m {
                    self.iterate.y[slack.row] = self.iterate.z_lower[self.problem.n + k];
                }
            }
        }
    }
}
