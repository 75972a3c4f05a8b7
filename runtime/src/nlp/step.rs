//! From an accepted step to the next iterate.

use super::iterate::{Iterate, safeguarded};
use super::line_search::{Acceptance, Search};
use super::solver::Loop;
use crate::linalg::norms::norm_inf;

impl Loop<'_, '_, '_, '_> {
    /// Takes over the trial point and updates multipliers, filter and shift.
    pub(crate) fn accept(&mut self, search: &Search) {
        let alpha = search.alpha;
        let direction = if search.corrected {
            &self.correction
        } else {
            &self.direction
        };
        self.info.step_norm = norm_inf(&direction.v);
        let alpha_dual = self.longest_dual_step(direction);
        std::mem::swap(&mut self.iterate.v, &mut self.trial);
        std::mem::swap(&mut self.values, &mut self.trial_values);
        let m = self.problem.m;
        let (explicit, products) = self.iterate.y.split_at_mut(m);
        let (d_explicit, d_products) = direction.y.split_at(m);
        for (y, d) in explicit.iter_mut().zip(d_explicit) {
            *y += alpha * d;
        }
        for (y, d) in products.iter_mut().zip(d_products) {
            *y += alpha_dual * d;
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
        if search.alpha < short && self.values.theta > 1e-6 {
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
        let theta = self.values.theta;
        let far = norm_inf(&self.iterate.v) > 1e8;
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
        let Iterate {
            v,
            z_lower,
            z_upper,
            ..
        } = &mut self.iterate;
        let mut moved = false;
        let lower = self.problem.lower.iter_mut().zip(z_lower);
        let upper = self.problem.upper.iter_mut().zip(z_upper);
        for ((&v, (lower, z_lower)), (upper, z_upper)) in v.iter().zip(lower).zip(upper) {
            if lower.is_finite() {
                let room = room(*lower, v - *lower, mu);
                if room > 0.0 {
                    *lower = v - room;
                    moved = true;
                }
                *z_lower = safeguarded(*z_lower, v - *lower, mu);
            }
            if upper.is_finite() {
                let room = room(*upper, *upper - v, mu);
                if room > 0.0 {
                    *upper = v + room;
                    moved = true;
                }
                *z_upper = safeguarded(*z_upper, *upper - v, mu);
            }
        }
        if moved {
            self.values.barrier = None;
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

/// Distance that a bound is moved away from a point which reached it by rounding; 0 if it did not.
fn room(bound: f64, distance: f64, mu: f64) -> f64 {
    let smallest = f64::EPSILON * bound.abs().max(mu.min(1.0) * 1e-4);
    if distance <= smallest {
        (f64::EPSILON.powf(0.75) * bound.abs().max(1.0)).max(smallest)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_is_left_where_rounding_reached_the_bound_and_nowhere_else() {
        assert_eq!(room(3.0, 1e-12, 0.1), 0.0);
        // closer than the spacing of the numbers: eps^(3/4) of the bound
        let moved = room(3.0, 1e-16, 0.1);
        assert!((moved / (3.0 * f64::EPSILON.powf(0.75)) - 1.0).abs() < 1e-12);
        assert_eq!(room(0.0, 1e-25, 1e-9), 0.0);
        assert!(room(0.0, 0.0, 1e-9) > 0.0);
    }
}
