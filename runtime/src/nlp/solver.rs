//! The main loop of the filter line-search interior point method.

use std::time::Instant;

use super::barrier::{BarrierPath, Level, PathStep};
use super::barrier_problem::{BarrierProblem, Values};
use super::filter::Filter;
use super::formulation::Formulation;
use super::inertia_correction::InertiaCorrection;
use super::iterate::{Iterate, longest_dual_step, longest_primal_step};
use super::kkt_system::KktSystem;
use super::line_search::{Acceptance, Search};
use super::residuals::{Optimality, OptimalityError, lagrangian_gradient};
use super::{InputError, IterationInfo, Settings, Status};
use crate::linalg::norms::{is_finite, norm_inf};

/// Receives each line of the log as it is made; `false` stops the run.
pub type Observer<'a> = dyn FnMut(&IterationInfo) -> bool + 'a;

/// What main loop and restoration phase share.
pub(crate) struct Core<'a, 'o> {
    pub(crate) formulation: Formulation<'a>,
    pub(crate) kkt: KktSystem,
    pub(crate) settings: Settings,
    pub(crate) history: Vec<IterationInfo>,
    pub(crate) iterations: usize,
    pub(crate) restoration_iterations: usize,
    pub(crate) observer: Option<&'o mut Observer<'o>>,
    start: Instant,
}

impl<'a, 'o> Core<'a, 'o> {
    pub(crate) fn new(
        formulation: Formulation<'a>,
        settings: &Settings,
        observer: Option<&'o mut Observer<'o>>,
    ) -> Result<Self, InputError> {
        let kkt = KktSystem::new(&formulation)?;
        Ok(Self {
            formulation,
            kkt,
            settings: settings.clone(),
            history: Vec::with_capacity(settings.maximum_iterations.min(1000) + 1),
            iterations: 0,
            restoration_iterations: 0,
            observer,
            start: Instant::now(),
        })
    }

    pub(crate) fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }
}

/// How a loop ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Outcome {
    pub(crate) status: Status,
    pub(crate) error: f64,
    /// Whether the test for leaving the restoration phase succeeded.
    pub(crate) left: bool,
}

/// Test at an accepted point of the restoration phase: is it good enough to go on with?
pub(crate) type LeaveTest<'t> =
    dyn FnMut(&mut Formulation<'_>, &BarrierProblem, &Iterate) -> bool + 't;

/// A run of the method on one barrier problem.
pub(crate) struct Loop<'c, 'a, 'o, 'p> {
    pub(crate) core: &'c mut Core<'a, 'o>,
    pub(crate) problem: BarrierProblem,
    pub(crate) path: &'p mut dyn BarrierPath,
    pub(crate) is_restoration: bool,
    pub(crate) iterate: Iterate,
    pub(crate) values: Values,
    pub(crate) gradient: Vec<f64>,
    pub(crate) lagrangian: Vec<f64>,
    /// Measures of the point that belongs to `lagrangian`.
    optimality: Optimality,
    pub(crate) direction: Iterate,
    pub(crate) correction: Iterate,
    pub(crate) trial: Vec<f64>,
    pub(crate) trial_values: Values,
    pub(crate) corrected_residual: Vec<f64>,
    pub(crate) mu: f64,
    pub(crate) sigma: f64,
    pub(crate) tau: f64,
    pub(crate) filter: Filter,
    pub(crate) theta_min: f64,
    pub(crate) inertia: InertiaCorrection,
    /// Extra shift of the Hessian while the line search cuts steps of product problems.
    pub(crate) shift_floor: f64,
    /// Point kept by [`PathStep::Advance`].
    pub(crate) kept: Iterate,
    pub(crate) level_iterations: usize,
    pub(crate) jams: usize,
    pub(crate) filter_rejections: usize,
    pub(crate) filter_resets: usize,
    pub(crate) tiny_steps: usize,
    pub(crate) stalls: usize,
    pub(crate) drift_steps: usize,
    pub(crate) drift_theta: f64,
    pub(crate) acceptable: usize,
    pub(crate) degenerate: usize,
    pub(crate) last_restoration: Option<usize>,
    /// Least violation that a restoration phase reached.
    pub(crate) restored_theta: f64,
    pub(crate) info: IterationInfo,
}

impl<'c, 'a, 'o, 'p> Loop<'c, 'a, 'o, 'p> {
    pub(crate) fn new(
        core: &'c mut Core<'a, 'o>,
        problem: BarrierProblem,
        path: &'p mut dyn BarrierPath,
        is_restoration: bool,
    ) -> Self {
        let n = problem.variables();
        let rows = problem.rows();
        let (mu, sigma) = path.first();
        Self {
            core,
            path,
            is_restoration,
            iterate: Iterate::zeros(&problem),
            trial_values: Values::zeros(rows),
            values: Values::zeros(rows),
            gradient: vec![0.0; n],
            lagrangian: vec![0.0; n],
            optimality: Optimality::default(),
            direction: Iterate::zeros(&problem),
            correction: Iterate::zeros(&problem),
            trial: vec![0.0; n],
            corrected_residual: vec![0.0; rows],
            mu,
            sigma,
            tau: fraction_to_boundary(mu),
            filter: Filter::new(f64::INFINITY),
            theta_min: 0.0,
            inertia: InertiaCorrection::default(),
            shift_floor: 0.0,
            kept: Iterate::zeros(&problem),
            level_iterations: 0,
            jams: 0,
            filter_rejections: 0,
            filter_resets: 0,
            tiny_steps: 0,
            stalls: 0,
            drift_steps: 0,
            drift_theta: f64::INFINITY,
            acceptable: 0,
            degenerate: 0,
            last_restoration: None,
            restored_theta: f64::INFINITY,
            info: IterationInfo {
                acceptance: ' ',
                ..IterationInfo::default()
            },
            problem,
        }
    }

    /// Evaluates objective and residuals at the iterate.
    pub(crate) fn evaluate_iterate(&mut self) -> bool {
        self.problem.evaluate(
            &mut self.core.formulation,
            &self.iterate.v,
            self.sigma,
            self.mu,
            &mut self.values,
        )
    }

    /// Evaluates gradient and Jacobian at the iterate.
    pub(crate) fn evaluate_first_derivatives(&mut self) {
        self.core
            .kkt
            .evaluate_jacobian(&mut self.core.formulation, &self.iterate.v);
        self.problem.gradient(
            &mut self.core.formulation,
            &self.iterate.v,
            self.mu,
            &mut self.gradient,
        );
    }

    /// Multipliers of the rows that fit the gradient best, zeros if they exceed 1000.
    pub(crate) fn estimate_multipliers(&mut self) {
        self.core.kkt.least_squares_multipliers(
            &self.problem,
            &mut self.iterate,
            &self.gradient,
            1e3,
            &mut self.correction,
        );
    }

    /// Updates the gradient of the Lagrangian, and what the optimality error follows from.
    pub(crate) fn update_lagrangian(&mut self) {
        let values = self.core.kkt.jacobian_values.iter().copied();
        lagrangian_gradient(
            &self.problem,
            &self.iterate,
            &self.gradient,
            self.core.formulation.jacobian_entries().zip(values),
            &mut self.lagrangian,
        );
        self.optimality = Optimality::new(
            &self.problem,
            &self.iterate,
            &self.values.residual,
            &self.lagrangian,
        );
    }

    /// Error of the optimality conditions of the barrier problem with parameter `mu`.
    pub(crate) fn error(&self, mu: f64) -> OptimalityError {
        self.optimality.error(mu)
    }

    /// Largest violation of the explicit rows in the user's units.
    fn unscaled_infeasibility(&self) -> f64 {
        self.values.residual[..self.problem.m]
            .iter()
            .zip(&self.core.formulation.row_scales)
            .fold(0.0, |a: f64, (r, scale)| a.max(r.abs() / scale))
    }

    /// Sets the greatest and the switching violation of the filter from the current point.
    pub(crate) fn start_filter(&mut self) {
        let theta = self.values.theta.max(1.0);
        self.filter = Filter::new(1e4 * theta);
        self.theta_min = 1e-4 * theta;
    }

    /// Runs until a status is reached or, in the restoration phase, `leave` accepts a point.
    pub(crate) fn run(&mut self, mut leave: Option<&mut LeaveTest<'_>>) -> Outcome {
        loop {
            self.evaluate_first_derivatives();
            self.update_lagrangian();
            let error = self.error(0.0);
            if !error.scaled().is_finite() {
                return self.outcome(Status::NotFinite);
            }
            if !self.record(&error) {
                return self.outcome(Status::Interrupted);
            }
            if let Some(status) = self.stop_test(&error) {
                return self.outcome(status);
            }
            if let Some(status) = self.update_barrier() {
                return self.outcome(status);
            }
            let count = self.core.kkt.factorizations;
            let found = self.find_direction();
            self.info.factorizations = self.core.kkt.factorizations - count;
            if !self.core.kkt.is_finite() {
                return self.outcome(Status::NotFinite);
            }
            let search = if found {
                self.line_search()
            } else {
                Search::failed(0)
            };
            self.core.iterations += 1;
            if self.is_restoration {
                self.core.restoration_iterations += 1;
            }
            match search.acceptance {
                Acceptance::None => {
                    if let Some(outcome) = self.rescue(found) {
                        return outcome;
                    }
                }
                _ => {
                    self.accept(&search);
                    let factor = if self.is_jammed(&search) {
                        Some(if self.problem.products.is_empty() {
                            0.9
                        } else {
                            0.1
                        })
                    } else if self.is_drifting() {
                        Some(0.9)
                    } else {
                        None
                    };
                    if let Some(outcome) = factor.and_then(|factor| self.restore(factor)) {
                        return outcome;
                    }
                }
            }
            if let Some(leave) = leave.as_mut()
                && leave(&mut self.core.formulation, &self.problem, &self.iterate)
            {
                return Outcome {
                    status: Status::Solved,
                    error: f64::NAN,
                    left: true,
                };
            }
        }
    }

    pub(crate) fn outcome(&self, status: Status) -> Outcome {
        Outcome {
            status,
            error: self.error(0.0).scaled(),
            left: false,
        }
    }

    /// Writes the line of the log; `false` if the observer asks to stop.
    fn record(&mut self, error: &OptimalityError) -> bool {
        self.info.iteration = self.core.iterations;
        self.info.restoration = self.is_restoration;
        self.info.objective = if self.is_restoration {
            self.values.objective
        } else {
            self.values.objective / self.core.formulation.objective_scale
        };
        self.info.primal_infeasibility = error.primal;
        self.info.dual_infeasibility = error.dual;
        self.info.complementarity = error.complementarity;
        self.info.barrier_parameter = self.mu;
        self.info.relaxation_parameter = self.sigma;
        self.core.history.push(self.info);
        match self.core.observer.as_mut() {
            Some(observer) => observer(&self.info),
            None => true,
        }
    }

    fn stop_test(&mut self, error: &OptimalityError) -> Option<Status> {
        let settings = &self.core.settings;
        let scaled = error.scaled();
        let at_end = self.sigma <= self.path.final_sigma();
        let feasible = || {
            self.is_restoration || self.unscaled_infeasibility() <= settings.constraint_tolerance
        };
        if scaled <= settings.tolerance && at_end && feasible() {
            // huge multipliers scale any residual away; then the test says nothing
            let absolute = 100.0 * settings.tolerance;
            let largest = norm_inf(&self.iterate.y);
            let exist = largest <= LARGEST_MULTIPLIER || !self.problem.products.is_empty();
            let small = error.dual <= absolute && error.complementarity <= absolute;
            if self.is_restoration || (exist && small) {
                return Some(Status::Solved);
            }
            self.degenerate += 1;
            if self.degenerate > 10 {
                return Some(Status::Degenerate);
            }
        }
        if scaled <= settings.acceptable_tolerance && at_end {
            self.acceptable += 1;
        } else {
            self.acceptable = 0;
        }
        if settings.acceptable_iterations > 0 && self.acceptable >= settings.acceptable_iterations {
            return Some(Status::Acceptable);
        }
        if norm_inf(&self.iterate.v) > 1e20 {
            return Some(Status::Diverging);
        }
        if self.core.iterations >= settings.maximum_iterations {
            return Some(Status::IterationLimit);
        }
        if self.core.seconds() > settings.maximum_seconds {
            return Some(Status::TimeLimit);
        }
        None
    }

    /// Moves along the path while the current problem is solved.
    pub(crate) fn update_barrier(&mut self) -> Option<Status> {
        let mut forced = self.tiny_steps >= 2;
        if self.tiny_steps >= 2 {
            self.tiny_steps = 0;
        }
        loop {
            let level = Level {
                mu: self.mu,
                sigma: self.sigma,
                solved: forced || self.error(self.mu).scaled() <= 10.0 * self.mu,
                iterations: self.level_iterations,
                jams: self.jams,
            };
            match self.path.update(&level) {
                PathStep::Stay if forced => return Some(Status::StepTooSmall),
                PathStep::Stay => {
                    self.level_iterations += 1;
                    return None;
                }
                PathStep::Advance { mu, sigma } => {
                    self.kept.copy_from(&self.iterate);
                    if self.change_parameters(mu, sigma) {
                        return None;
                    }
                }
                PathStep::Return { mu, sigma } => {
                    self.iterate.copy_from(&self.kept);
                    self.evaluate_iterate();
                    self.evaluate_first_derivatives();
                    self.update_lagrangian();
                    self.sigma = f64::INFINITY;
                    self.change_parameters(mu, sigma);
                    return None;
                }
            }
            forced = false;
        }
    }

    /// Sets new parameters; `true` if `sigma` changed, which moves the slacks of products.
    pub(crate) fn change_parameters(&mut self, mu: f64, sigma: f64) -> bool {
        self.mu = mu;
        self.tau = fraction_to_boundary(mu);
        self.filter.clear();
        self.level_iterations = 0;
        self.jams = 0;
        let changed = sigma != self.sigma;
        if changed {
            self.sigma = sigma;
            for k in 0..self.problem.slacks.len() {
                if !self.problem.is_product_slack(k) {
                    continue;
                }
                let row = self.problem.slacks[k].row;
                let (i, j) = self.problem.products[row - self.problem.m];
                let product = self.iterate.v[i] * self.iterate.v[j];
                let index = self.problem.n + k;
                let s = (sigma - product).max((0.1 * sigma).min(self.iterate.v[index]));
                self.iterate.v[index] = s;
                let z = self.iterate.z_lower[index]
                    .min(1e4 * mu / s)
                    .max(mu / (1e4 * s));
                self.iterate.z_lower[index] = z;
                self.iterate.y[row] = z;
            }
            self.update_lagrangian();
        }
        // also the weight of the proximity term of the restoration phase depends on mu
        if changed || self.is_restoration {
            self.evaluate_iterate();
            self.problem.gradient(
                &mut self.core.formulation,
                &self.iterate.v,
                self.mu,
                &mut self.gradient,
            );
            self.update_lagrangian();
        }
        changed
    }

    /// Newton direction with the right inertia and a small residual.
    fn find_direction(&mut self) -> bool {
        let core = &mut *self.core;
        core.kkt
            .evaluate_hessian(&mut core.formulation, &self.problem, &self.iterate);
        if !core.kkt.is_finite() {
            return false;
        }
        let mut floor = self.shift_floor;
        let mut dual_shift = core.settings.permanent_dual_shift;
        for _ in 0..4 {
            let core = &mut *self.core;
            core.kkt
                .assemble(&self.problem, &self.iterate, self.mu, false);
            if !self.inertia.factorize(
                &mut core.kkt,
                &self.problem,
                &self.iterate,
                self.mu,
                floor,
                dual_shift,
            ) {
                return false;
            }
            let residual = core.kkt.direction(
                &self.problem,
                &self.iterate,
                &self.lagrangian,
                &self.values.residual,
                self.mu,
                &mut self.direction,
            );
            if residual <= 1e-5 && is_finite(&self.direction.v) {
                return true;
            }
            // as good as singular: shift both blocks
            dual_shift = dual_shift.max(1e-8) * if dual_shift >= 1e-8 { 100.0 } else { 1.0 };
            floor = (100.0 * self.inertia.delta_w).max(1e-8);
        }
        false
    }

    /// Largest primal step along `direction`.
    pub(crate) fn longest_step(&self, direction: &Iterate) -> f64 {
        longest_primal_step(&self.problem, &self.iterate.v, &direction.v, self.tau)
    }

    /// Largest step of the bound multipliers along `direction`.
    pub(crate) fn longest_dual_step(&self, direction: &Iterate) -> f64 {
        longest_dual_step(&self.iterate.z_lower, &direction.z_lower, self.tau).min(
            longest_dual_step(&self.iterate.z_upper, &direction.z_upper, self.tau),
        )
    }
}

/// Multipliers of the scaled problem, whose gradients are at most 100, beyond which none seem to exist.
const LARGEST_MULTIPLIER: f64 = 1e8;

/// Fraction to the boundary `tau = max(0.99, 1 - mu)`.
pub(crate) fn fraction_to_boundary(mu: f64) -> f64 {
    (1.0 - mu).max(0.99)
}
