//! The filter line search.

use super::barrier_problem::{BarrierProblem, Values};
use super::filter::{is_armijo, is_sufficient, is_switching, smallest_step};
use super::formulation::Formulation;
use super::iterate::Iterate;
use super::restoration::raise_product_slacks;
use super::solver::Loop;
use crate::linalg::norms::norm_one;

/// Why a trial point was accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Acceptance {
    None,
    /// Descent of the objective (Armijo).
    Objective,
    /// Progress in violation or objective; the point left behind enters the filter.
    Filter,
    /// The step is below the resolution of the numbers.
    Tiny,
}

impl Acceptance {
    /// Letter of the log.
    pub(crate) fn letter(self, corrected: bool) -> char {
        match (self, corrected) {
            (Self::None, _) => ' ',
            (Self::Objective, false) => 'f',
            (Self::Objective, true) => 'F',
            (Self::Filter, false) => 'h',
            (Self::Filter, true) => 'H',
            (Self::Tiny, _) => 't',
        }
    }
}

/// Result of a line search; the accepted point is in `trial`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Search {
    pub(crate) acceptance: Acceptance,
    pub(crate) alpha: f64,
    pub(crate) alpha_max: f64,
    pub(crate) trials: usize,
    /// Whether the step is the second-order correction.
    pub(crate) corrected: bool,
    /// Whether the filter was what rejected the last trial before acceptance.
    pub(crate) filter_rejected: bool,
}

impl Search {
    pub(crate) fn failed(trials: usize) -> Self {
        Self {
            acceptance: Acceptance::None,
            alpha: 0.0,
            alpha_max: 0.0,
            trials,
            corrected: false,
            filter_rejected: false,
        }
    }
}

/// Quantities of the current point that trial points are compared with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reference {
    pub(crate) theta: f64,
    pub(crate) phi: f64,
    pub(crate) slope: f64,
}

impl Loop<'_, '_, '_, '_> {
    /// Barrier function at the iterate.
    pub(crate) fn barrier_function(&mut self) -> f64 {
        self.problem
            .barrier_function(&self.iterate.v, &mut self.values, self.mu)
    }

    /// Directional derivative of the barrier function along `d`.
    fn slope(&self, d: &[f64]) -> f64 {
        let problem = &self.problem;
        let mut slope = 0.0;
        for (i, d) in d.iter().enumerate() {
            let mut g = self.gradient[i] + self.mu * problem.damping(i);
            if problem.lower[i].is_finite() {
                g -= self.mu / (self.iterate.v[i] - problem.lower[i]);
            }
            if problem.upper[i].is_finite() {
                g += self.mu / (problem.upper[i] - self.iterate.v[i]);
            }
            slope += g * d;
        }
        slope
    }

    /// Whether no component of the step exceeds ten units of rounding.
    fn is_tiny(&self) -> bool {
        self.values.infeasibility() <= 1e-4
            && self
                .direction
                .v
                .iter()
                .zip(&self.iterate.v)
                .all(|(d, v)| d.abs() <= 10.0 * f64::EPSILON * (1.0 + v.abs()))
    }

    pub(crate) fn line_search(&mut self) -> Search {
        let alpha_max = self.longest_step(&self.direction);
        let reference = Reference {
            theta: self.values.theta,
            phi: self.barrier_function(),
            slope: self.slope(&self.direction.v),
        };
        if self.is_tiny() && self.take_trial(alpha_max, false) {
            return Search {
                acceptance: Acceptance::Tiny,
                alpha: alpha_max,
                alpha_max,
                trials: 0,
                corrected: false,
                filter_rejected: false,
            };
        }
        self.backtrack(&reference, alpha_max)
    }

    /// Halves the step until the point is acceptable; a second-order correction belongs to the longest step only.
    fn backtrack(&mut self, reference: &Reference, alpha_max: f64) -> Search {
        let mut search = Search::failed(0);
        search.alpha_max = alpha_max;
        let alpha_min = smallest_step(reference.theta, reference.slope, self.theta_min);
        let mut alpha = alpha_max;
        loop {
            search.trials += 1;
            if self.take_trial(alpha, false) {
                let (acceptance, filter_rejected) = self.judge(reference, alpha, alpha);
                if acceptance != Acceptance::None {
                    self.augment_filter(acceptance, reference);
                    search.acceptance = acceptance;
                    search.alpha = alpha;
                    return search;
                }
                search.filter_rejected = filter_rejected;
                if alpha == alpha_max && self.trial_values.theta >= reference.theta {
                    let acceptance = self.second_order_correction(reference, alpha);
                    if acceptance != Acceptance::None {
                        self.augment_filter(acceptance, reference);
                        search.acceptance = acceptance;
                        search.alpha = self.longest_step(&self.correction);
                        search.corrected = true;
                        return search;
                    }
                }
            }
            alpha *= 0.5;
            if alpha < alpha_min || alpha < 1e-16 {
                return Search::failed(search.trials);
            }
        }
    }

    /// Evaluates the point at `alpha` along the direction, or its correction, into `trial`.
    pub(crate) fn take_trial(&mut self, alpha: f64, corrected: bool) -> bool {
        let direction = if corrected {
            &self.correction
        } else {
            &self.direction
        };
        trial_point(
            &self.problem,
            &mut self.core.formulation,
            &self.iterate,
            &direction.v,
            alpha,
            (self.mu, self.sigma),
            !self.is_restoration,
            &mut self.trial,
            &mut self.trial_values,
        )
    }

    /// Judges the trial point; `alpha_test` is the step length that Armijo and switching use.
    pub(crate) fn judge(
        &mut self,
        reference: &Reference,
        alpha: f64,
        alpha_test: f64,
    ) -> (Acceptance, bool) {
        let theta = self.trial_values.theta;
        let phi = self
            .problem
            .barrier_function(&self.trial, &mut self.trial_values, self.mu);
        if !phi.is_finite() || theta > self.filter.theta_max {
            return (Acceptance::None, false);
        }
        let switching = reference.theta <= self.theta_min
            && is_switching(reference.slope, alpha, reference.theta);
        let acceptance = if switching {
            if is_armijo(phi, reference.phi, alpha_test, reference.slope) {
                Acceptance::Objective
            } else {
                Acceptance::None
            }
        } else if is_sufficient(theta, phi, reference.theta, reference.phi)
            && !increases_too_much(phi, reference.phi)
        {
            if is_switching(reference.slope, alpha, reference.theta)
                && is_armijo(phi, reference.phi, alpha_test, reference.slope)
            {
                Acceptance::Objective
            } else {
                Acceptance::Filter
            }
        } else {
            Acceptance::None
        };
        if acceptance == Acceptance::None {
            return (Acceptance::None, false);
        }
        if self.filter.accepts(theta, phi) {
            (acceptance, false)
        } else {
            (Acceptance::None, true)
        }
    }

    pub(crate) fn augment_filter(&mut self, acceptance: Acceptance, reference: &Reference) {
        if acceptance == Acceptance::Filter {
            self.filter.add(reference.theta, reference.phi);
        }
    }
}

/// Increase of the objective by more than five orders of magnitude.
fn increases_too_much(trial: f64, phi: f64) -> bool {
    trial > phi && (trial - phi).log10() > 5.0 + phi.abs().log10().max(1.0)
}

/// Point `v + alpha d`, where `raise_slacks` lifts slacks of products to `sigma - x_i x_j`; `false` if a
/// function is not finite there.
#[expect(clippy::too_many_arguments, reason = "the parts of one definition")]
fn trial_point(
    problem: &BarrierProblem,
    formulation: &mut Formulation<'_>,
    iterate: &Iterate,
    d: &[f64],
    alpha: f64,
    (mu, sigma): (f64, f64),
    raise_slacks: bool,
    trial: &mut [f64],
    values: &mut Values,
) -> bool {
    for ((t, v), d) in trial.iter_mut().zip(&iterate.v).zip(d) {
        *t = v + alpha * d;
    }
    if raise_slacks {
        raise_product_slacks(problem, sigma, trial);
    }
    if !problem.evaluate(formulation, trial, sigma, mu, values) {
        return false;
    }
    if raise_slacks {
        reset_range_slacks(problem, trial, values);
    }
    true
}

/// Moves slacks of ranges to the constraint values where these are not much nearer to the bounds.
fn reset_range_slacks(problem: &BarrierProblem, trial: &mut [f64], values: &mut Values) {
    if problem.slacks.len() == problem.products.len() {
        return;
    }
    for (k, slack) in problem.slacks.iter().enumerate() {
        if slack.row >= problem.m {
            continue;
        }
        let i = problem.n + k;
        let value = trial[i] + values.residual[slack.row];
        let kept = |distance: f64, old: f64| distance >= 0.5 * old;
        if kept(value - problem.lower[i], trial[i] - problem.lower[i])
            | !problem.lower[i].is_finite()
            && kept(problem.upper[i] - value, problem.upper[i] - trial[i])
                | !problem.upper[i].is_finite()
        {
            trial[i] = value;
            values.residual[slack.row] = 0.0;
        }
    }
    values.theta = norm_one(&values.residual);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn increases_too_much_compares_orders_of_magnitude() {
        assert!(!increases_too_much(1e5, 1.0));
        assert!(increases_too_much(1e7, 1.0));
        assert!(!increases_too_much(1e9, 1e5));
        assert!(!increases_too_much(-1.0, 1.0));
    }
}
