//! The state of the method: the point, what was evaluated there, and the memory of its parts.

use crate::clock::{Instant, ThreadTime};
use crate::seconds::Seconds;
use crate::until::Until;

use super::barrier::BarrierPath;
use super::filter::Filter;
use crate::nlp::kkt::{InertiaCorrection, KktSystem};
use crate::nlp::program::barrier_problem::{BarrierProblem, Values};
use crate::nlp::program::formulation::Formulation;
use crate::nlp::program::iterate::{Iterate, longest_dual_step, longest_primal_step};
use crate::nlp::program::residuals::{Optimality, OptimalityError, lagrangian_gradient};
use crate::nlp::{InputError, IterationInfo, Observer, Settings, Solution, Status};

/// Shift of the dual rows that makes multipliers of dependent rows unique, beside gradients of size 1 to 100.
const DEPENDENT_SHIFT: f64 = 1e-10;

/// Distance of a bound that is near, relative to the size of the variable.
const NEAR: f64 = 1e-6;

/// What main loop and restoration phase share.
pub(crate) struct Core<'a, 'o> {
    pub(crate) formulation: Formulation<'a>,
    pub(crate) kkt: KktSystem,
    pub(crate) settings: Settings,
    pub(crate) history: Vec<IterationInfo>,
    pub(crate) iterations: usize,
    pub(crate) restoration_iterations: usize,
    /// Gradient of the least violation that the restoration phase ended at, if it ended the run.
    pub(crate) violation_stationarity: Option<f64>,
    /// Whether the run gave up at a point that is the solution but for rounding.
    pub(crate) is_close: bool,
    pub(crate) observer: Option<&'o mut Observer<'o>>,
    start: Instant,
    clock: ThreadTime,
    /// Wall-clock and CPU time of runs before this one, which belong to the same solution \[s\].
    earlier: (f64, f64),
}

impl<'a, 'o> Core<'a, 'o> {
    pub(crate) fn new(
        formulation: Formulation<'a>,
        settings: &Settings,
        observer: Option<&'o mut Observer<'o>>,
    ) -> Result<Self, InputError> {
        let kkt = KktSystem::new(&formulation)?;
        let mut core = Self {
            formulation,
            kkt,
            settings: settings.clone(),
            history: Vec::with_capacity(settings.maximum_iterations.min(1000) + 1),
            iterations: 0,
            restoration_iterations: 0,
            violation_stationarity: None,
            is_close: false,
            observer,
            start: Instant::now(),
            clock: ThreadTime::now(),
            earlier: (0.0, 0.0),
        };
        core.limit();
        Ok(core)
    }

    /// Adds the work of an earlier run on the same problem, so that counts, times and the log go on from there, and limits hold
    /// for both together.
    pub(crate) fn go_on_after(&mut self, earlier: Solution) {
        self.iterations = earlier.counts.iterations;
        self.restoration_iterations = earlier.counts.restoration_iterations;
        self.history = earlier.history;
        self.kkt.factorizations = earlier.counts.factorizations;
        self.kkt.seconds += earlier.cpu;
        self.formulation.evaluate += earlier.cpu.evaluate;
        self.earlier = (earlier.seconds, earlier.cpu.total);
        self.limit();
    }

    /// Factorizations end with the run.
    fn limit(&mut self) {
        let left = self.settings.maximum_seconds - self.seconds();
        let until = Until::new(&self.settings.interrupt, left);
        self.kkt.work_until(until);
    }

    /// How the run ends if it has to now, whatever it has come to.
    pub(super) fn is_over(&self) -> Option<Status> {
        if self.settings.interrupt.is_asked() {
            return Some(Status::Interrupted);
        }
        (self.seconds() > self.settings.maximum_seconds).then_some(Status::TimeLimit)
    }

    pub(crate) fn seconds(&self) -> f64 {
        self.earlier.0 + self.start.elapsed().as_secs_f64()
    }

    /// CPU time by kind of work \[s\].
    pub(crate) fn cpu(&self) -> Seconds {
        Seconds {
            total: self.earlier.1 + self.clock.elapsed().as_secs_f64(),
            evaluate: self.formulation.evaluate,
            ..self.kkt.seconds
        }
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

/// Where a run ended.
pub(crate) struct End {
    pub(crate) outcome: Outcome,
    /// Scaled.
    pub(super) objective: f64,
    pub(crate) iterate: Iterate,
    pub(crate) mu: f64,
    pub(crate) sigma: f64,
}

/// The current point and what was evaluated there.
pub(super) struct Point {
    pub(super) iterate: Iterate,
    pub(super) values: Values,
    pub(super) gradient: Vec<f64>,
    pub(super) lagrangian: Vec<f64>,
    /// Measures of the point that belongs to `lagrangian`.
    optimality: Optimality,
}

/// Directions and trial points.
pub(super) struct Work {
    pub(super) direction: Iterate,
    pub(super) correction: Iterate,
    pub(super) trial: Vec<f64>,
    pub(super) trial_values: Values,
    pub(super) corrected_residual: Vec<f64>,
}

/// What decides which points are acceptable.
pub(super) struct Globalization {
    pub(super) filter: Filter,
    /// Violation below which the objective may decide alone.
    pub(super) theta_min: f64,
    /// Steps in a row that the filter shortened, and how often it was emptied for that.
    pub(super) rejections: usize,
    pub(super) resets: usize,
    /// Iteration of the last restoration phase, and the least violation that one reached.
    pub(super) last_restoration: Option<usize>,
    pub(super) restored_theta: f64,
}

/// Shifts of the Newton matrix.
#[derive(Default)]
pub(super) struct Shifts {
    pub(super) inertia: InertiaCorrection,
    /// Extra shift of the Hessian while the line search cuts steps of product problems.
    pub(super) floor: f64,
}

/// What happened since the parameters changed.
pub(super) struct LevelProgress {
    /// Point kept by [`PathStep::Advance`](super::barrier::PathStep::Advance).
    pub(super) kept: Iterate,
    pub(super) iterations: usize,
    /// Short steps in a row at infeasible points.
    pub(super) jams: usize,
    pub(super) tiny_steps: usize,
}

/// Counters of iterations in a row without progress of some kind.
pub(super) struct Progress {
    /// Iterations without a step.
    pub(super) stalls: usize,
    /// Steps far out that left the violation as it is, and that violation.
    pub(super) drift_steps: usize,
    pub(super) drift_theta: f64,
    /// Steps far out that lowered an objective of huge negative values, and the last of these.
    pub(super) far_steps: usize,
    pub(super) far_objective: f64,
    /// Steps that are still to be taken without a test.
    pub(super) untested: usize,
    /// Steps that changed nothing beyond rounding, and the least error before one on this barrier problem.
    pub(super) still_steps: usize,
    pub(super) least_error: f64,
    /// Iterations within the acceptable tolerance.
    pub(super) acceptable: usize,
    /// Iterations within the tolerance only by the size of the multipliers.
    pub(super) degenerate: usize,
}

/// A run of the method on one barrier problem.
pub(super) struct State<'c, 'a, 'o, 'p> {
    pub(super) core: &'c mut Core<'a, 'o>,
    pub(super) problem: BarrierProblem,
    pub(super) path: &'p mut dyn BarrierPath,
    pub(super) is_restoration: bool,
    pub(super) point: Point,
    pub(super) work: Work,
    pub(super) mu: f64,
    pub(super) sigma: f64,
    pub(super) globalization: Globalization,
    pub(super) shifts: Shifts,
    pub(super) level: LevelProgress,
    pub(super) progress: Progress,
    pub(super) info: IterationInfo,
}

impl<'c, 'a, 'o, 'p> State<'c, 'a, 'o, 'p> {
    pub(super) fn new(
        core: &'c mut Core<'a, 'o>,
        problem: BarrierProblem,
        path: &'p mut dyn BarrierPath,
        is_restoration: bool,
    ) -> Self {
        let n = problem.variables();
        let rows = problem.rows();
        let (mu, sigma) = path.first();
        let zeros = Iterate::zeros(&problem);
        let untested = if is_restoration {
            0
        } else {
            core.settings.untested_steps
        };
        Self {
            core,
            path,
            is_restoration,
            point: Point {
                iterate: zeros.clone(),
                values: Values::zeros(rows),
                gradient: vec![0.0; n],
                lagrangian: vec![0.0; n],
                optimality: Optimality::default(),
            },
            work: Work {
                direction: zeros.clone(),
                correction: zeros.clone(),
                trial: vec![0.0; n],
                trial_values: Values::zeros(rows),
                corrected_residual: vec![0.0; rows],
            },
            mu,
            sigma,
            globalization: Globalization {
                filter: Filter::new(f64::INFINITY),
                theta_min: 0.0,
                rejections: 0,
                resets: 0,
                last_restoration: None,
                restored_theta: f64::INFINITY,
            },
            shifts: Shifts::default(),
            level: LevelProgress {
                kept: zeros,
                iterations: 0,
                jams: 0,
                tiny_steps: 0,
            },
            progress: Progress {
                stalls: 0,
                drift_steps: 0,
                drift_theta: f64::INFINITY,
                far_steps: 0,
                far_objective: f64::INFINITY,
                untested,
                still_steps: 0,
                least_error: f64::INFINITY,
                acceptable: 0,
                degenerate: 0,
            },
            info: IterationInfo {
                acceptance: ' ',
                ..IterationInfo::default()
            },
            problem,
        }
    }

    /// Evaluates objective and residuals at the iterate.
    pub(super) fn evaluate_iterate(&mut self) -> bool {
        self.problem.evaluate(
            &mut self.core.formulation,
            &self.point.iterate.v,
            self.sigma,
            self.mu,
            &mut self.point.values,
        )
    }

    /// Evaluates gradient and Jacobian at the iterate.
    pub(super) fn evaluate_first_derivatives(&mut self) {
        self.core
            .kkt
            .evaluate_jacobian(&mut self.core.formulation, &self.point.iterate.v);
        self.problem.gradient(
            &mut self.core.formulation,
            &self.point.iterate.v,
            self.mu,
            &mut self.point.gradient,
        );
    }

    /// Multipliers of the rows that fit the gradient best, zeros if they exceed 1000.
    pub(super) fn estimate_multipliers(&mut self) {
        self.least_squares_multipliers(1e3, 0.0);
    }

    /// As [`State::estimate_multipliers`], zeros if they exceed `limit`; of those that fit where rows depend on each other the
    /// smallest.
    pub(super) fn estimate_dependent_multipliers(&mut self, limit: f64) {
        self.least_squares_multipliers(limit, DEPENDENT_SHIFT);
    }

    fn least_squares_multipliers(&mut self, limit: f64, dual_shift: f64) {
        self.core.kkt.least_squares_multipliers(
            &self.problem,
            &mut self.point.iterate,
            &self.point.gradient,
            (limit, dual_shift),
            &[],
            &mut self.work.correction,
        );
    }

    /// Puts variables on the bounds that are near; `false` where functions have no value there.
    pub(super) fn snap_to_bounds(&mut self) -> bool {
        let formulation = &self.core.formulation;
        let bounds = formulation.lower.iter().zip(&formulation.upper);
        let variables = self.point.iterate.v.iter_mut().zip(bounds).enumerate();
        for (i, (v, (lower, upper))) in variables {
            for bound in [*lower, *upper] {
                if (*v - bound).abs() <= NEAR * v.abs().max(1.0) {
                    *v = bound;
                }
            }
            self.problem.lower[i] = *lower;
            self.problem.upper[i] = *upper;
        }
        let finite = self.evaluate_iterate();
        if finite {
            self.evaluate_first_derivatives();
        }
        finite
    }

    /// The smallest multipliers that fit the gradient best where those of near bounds are free, and those of others zero.
    pub(super) fn fit_multipliers(&mut self) {
        let Iterate {
            v,
            z_lower,
            z_upper,
            ..
        } = &mut self.point.iterate;
        z_lower.fill(0.0);
        z_upper.fill(0.0);
        let bounds = self.problem.lower.iter().zip(&self.problem.upper);
        let near = v.iter().zip(bounds).map(|(v, (lower, upper))| {
            let distance = (v - lower).min(upper - v);
            distance <= NEAR * v.abs().max(1.0)
        });
        let near: Vec<bool> = near.collect();
        self.core.kkt.least_squares_multipliers(
            &self.problem,
            &mut self.point.iterate,
            &self.point.gradient,
            (f64::INFINITY, DEPENDENT_SHIFT),
            &near,
            &mut self.work.correction,
        );
        self.update_lagrangian();
        for (i, _) in near.iter().enumerate().filter(|(_, near)| **near) {
            let (v, gradient) = (self.point.iterate.v[i], self.point.lagrangian[i]);
            if v - self.problem.lower[i] < self.problem.upper[i] - v {
                self.point.iterate.z_lower[i] = gradient.max(0.0);
            } else {
                self.point.iterate.z_upper[i] = (-gradient).max(0.0);
            }
        }
        self.update_lagrangian();
    }

    /// Updates the gradient of the Lagrangian, and what the optimality error follows from.
    pub(super) fn update_lagrangian(&mut self) {
        let values = self.core.kkt.jacobian_values.iter().copied();
        lagrangian_gradient(
            &self.problem,
            &self.point.iterate,
            &self.point.gradient,
            self.core.formulation.jacobian_entries().zip(values),
            &mut self.point.lagrangian,
        );
        self.point.optimality = Optimality::new(
            &self.problem,
            &self.point.iterate,
            &self.point.values.residual,
            &self.point.lagrangian,
        );
    }

    /// Error of the optimality conditions of the barrier problem with parameter `mu`.
    pub(super) fn error(&self, mu: f64) -> OptimalityError {
        self.point.optimality.error(mu)
    }

    /// Largest violation of the explicit rows in the user's units.
    pub(super) fn unscaled_infeasibility(&self) -> f64 {
        self.point.values.residual[..self.problem.m]
            .iter()
            .zip(&self.core.formulation.row_scales)
            .fold(0.0, |a: f64, (r, scale)| a.max(r.abs() / scale))
    }

    /// Whether what each explicit row is violated by is within the tolerance, or rounding of the terms it is the sum of, by its
    /// derivatives.
    pub(super) fn is_feasible_to_rounding(&self) -> bool {
        const ROUNDING: f64 = 1e-10;
        let m = self.problem.m;
        let v = &self.point.iterate.v;
        let mut terms = vec![0.0; m];
        let values = self.core.kkt.jacobian_values.iter();
        for ((row, column), a) in self.core.formulation.jacobian_entries().zip(values) {
            terms[row] += (a * v[column]).abs();
        }
        for (slack, s) in self.problem.slacks.iter().zip(&v[self.problem.n..]) {
            if slack.row < m {
                terms[slack.row] += s.abs();
            }
        }
        let tolerance = self.core.settings.tolerance;
        let residuals = &self.point.values.residual[..m];
        let mut rows = residuals.iter().zip(&terms);
        rows.all(|(r, terms)| r.abs() <= tolerance.max(ROUNDING * terms))
    }

    /// Sets the greatest and the switching violation of the filter from the current point.
    pub(super) fn start_filter(&mut self) {
        let theta = self.point.values.theta.max(1.0);
        self.globalization.filter = Filter::new(1e4 * theta);
        self.globalization.theta_min = 1e-4 * theta;
    }

    pub(super) fn outcome(&self, status: Status) -> Outcome {
        Outcome {
            status,
            error: self.error(0.0).scaled(),
            left: false,
        }
    }

    /// Barrier function at the iterate.
    pub(super) fn barrier_function(&mut self) -> f64 {
        self.problem
            .barrier_function(&self.point.iterate.v, &mut self.point.values, self.mu)
    }

    /// Largest primal step along `direction`.
    pub(super) fn longest_step(&self, direction: &Iterate) -> f64 {
        longest_primal_step(
            &self.problem,
            &self.point.iterate.v,
            &direction.v,
            fraction_to_boundary(self.mu),
        )
    }

    /// Largest step of the bound multipliers along `direction`.
    pub(super) fn longest_dual_step(&self, direction: &Iterate) -> f64 {
        longest_dual_step(
            &self.point.iterate.z_lower,
            &direction.z_lower,
            fraction_to_boundary(self.mu),
        )
        .min(longest_dual_step(
            &self.point.iterate.z_upper,
            &direction.z_upper,
            fraction_to_boundary(self.mu),
        ))
    }
}

/// Fraction to the boundary `tau = max(0.99, 1 - mu)`.
pub(crate) fn fraction_to_boundary(mu: f64) -> f64 {
    (1.0 - mu).max(0.99)
}
