//! The smooth program that remains when some variables are fixed at zero, and its solution.

use super::watch::{Purpose, Watch};
use super::{Mpcc, Settings};
use crate::linalg::norms::norm_inf;
use crate::nlp::{self, Variant, WarmStart};

/// Dual shift below which convergence is fast even for dependent rows.
const LEAST_SHIFT: f64 = 1e-12;
/// Steps in a row that leave more than this share of the violation ask for a smaller dual shift.
const SLOW: f64 = 0.5;
const SLOW_STEPS: usize = 4;
/// Steps in a row at a feasible point that leave the optimality error as it is end a barrier problem of a patient run: there are
/// no multipliers to converge to, and later steps lead away. The last barrier problem is one that leaves sides clear.
const HELD_STEPS: usize = 16;
const HELD_BARRIER: f64 = 1e-10;
/// Violation below which slow steps are those of the shift, not those of a program that is far from linear.
const NEAR: f64 = 1e-1;
/// Steps cut below 0.05 in a row that end a run.
const SHORT: f64 = 0.05;
const SHORT_STEPS: usize = 6;
/// Violation up to which a point is accepted.
const FEASIBLE: f64 = 1e-9;
/// Most iterations of an attempt; it gets as many again if its violation is below `ALMOST` then, as multipliers of
/// dependent rows converge slowly.
const ITERATIONS: usize = 40;
const PATIENT_ITERATIONS: usize = 300;
const ALMOST: f64 = 1e-6;
/// Size of multipliers up to which the optimality error has to be within tolerance, not only relative to them, and
/// what complementarity may be relative to the tolerance: multipliers of a branch without a constraint qualification
/// grow without bound, and would let any point pass.
const LARGE_MULTIPLIERS: f64 = 100.0;
const COMPLEMENTARITY: f64 = 10.0;

/// Multipliers of rows that exceed the gradient of the objective by this factor seem to have no limit; gradient of the Lagrangian
/// relative to them up to which a point of a patient run is one to certify.
const ABSENT: f64 = 1e3;
const ROUGHLY: f64 = 1e-4;

/// How a program is solved.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Attempt {
    barrier_parameter: f64,
    /// Damps the steps of programs with dependent rows or more equations than variables: the larger, the fewer
    /// iterations most of them take. It is reduced where it makes convergence slow.
    dual_shift: f64,
    patience: Patience,
}

/// What ends an attempt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Patience {
    /// Few iterations, or short steps.
    Little,
    /// Many iterations.
    Much,
    /// Many iterations, or a feasible point, optimal or not.
    UntilFeasible,
}

impl Attempt {
    pub(crate) const fn new(barrier_parameter: f64, dual_shift: f64) -> Self {
        Self {
            barrier_parameter,
            dual_shift,
            patience: Patience::Little,
        }
    }

    /// An attempt that only its iterations end.
    pub(crate) const fn patient(barrier_parameter: f64, dual_shift: f64) -> Self {
        Self {
            patience: Patience::Much,
            ..Self::new(barrier_parameter, dual_shift)
        }
    }

    /// This attempt with any feasible point as its aim.
    pub(crate) fn until_feasible(self) -> Self {
        Self {
            patience: Patience::UntilFeasible,
            ..self
        }
    }

    fn iterations(self) -> usize {
        match self.patience {
            Patience::Little => ITERATIONS,
            _ => PATIENT_ITERATIONS,
        }
    }
}

/// Watches the steps of a run.
struct Progress {
    patience: Patience,
    /// Whether the dual shift can be reduced.
    can_reduce: bool,
    /// Steps in a row cut to nothing: a wrong choice of sides.
    short: usize,
    /// Steps in a row that hardly reduced the violation: the dual shift is too large.
    slow: usize,
    /// Whole steps in a row at a feasible point that hardly reduced the optimality error: multipliers grow, and the shift
    /// holds them back.
    held: usize,
    violation: f64,
    error: f64,
    barrier_parameter: f64,
}

impl Progress {
    fn new(patience: Patience, can_reduce: bool) -> Self {
        Self {
            patience,
            can_reduce,
            short: 0,
            slow: 0,
            held: 0,
            violation: 0.0,
            error: 0.0,
            barrier_parameter: 0.0,
        }
    }

    /// Takes in an iteration; `false` if the run shall stop.
    fn goes_on(&mut self, info: &nlp::IterationInfo) -> bool {
        let step = info.step_length_primal;
        let short = info.iteration > 0 && step < SHORT;
        let same = info.iteration > 0 && info.barrier_parameter == self.barrier_parameter;
        let slow = same && step > 0.3 && info.primal_infeasibility > SLOW * self.violation;
        let held = same
            && step > 0.3
            && info.primal_infeasibility <= FEASIBLE
            && info.dual_infeasibility > SLOW * self.error;
        self.short = if short { self.short + 1 } else { 0 };
        self.slow = if slow { self.slow + 1 } else { 0 };
        self.held = if held { self.held + 1 } else { 0 };
        self.violation = info.primal_infeasibility;
        self.error = info.dual_infeasibility;
        self.barrier_parameter = info.barrier_parameter;
        let enough = self.patience == Patience::UntilFeasible && self.violation <= 1e-1 * FEASIBLE;
        let jams = self.patience == Patience::Little && self.short >= SHORT_STEPS;
        !enough && !jams && !self.is_held() && !self.is_slow()
    }

    fn is_held(&self) -> bool {
        self.patience == Patience::Much && self.held >= HELD_STEPS
    }

    fn is_slow(&self) -> bool {
        let violation = self.slow >= SLOW_STEPS && (FEASIBLE..NEAR).contains(&self.violation);
        match self.patience {
            Patience::Little => violation,
            _ => self.can_reduce && (violation || self.held >= SLOW_STEPS),
        }
    }
}

/// Solves the program in which the variables `vanishes` are zero, from a point with multipliers; `None` if that
/// fails.
pub(crate) fn solve_branch(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    vanishes: &[bool],
    start: &WarmStart,
    attempt: Attempt,
    watch: &mut Watch<'_>,
) -> Option<nlp::Solution> {
    // without its pairs
    let mut branch = Variant {
        fixed: vanishes.to_vec(),
        ..Variant::of(problem)
    };
    let mut warm = WarmStart {
        barrier_parameter: attempt.barrier_parameter,
        ..start.clone()
    };
    let mut dual_shift = attempt.dual_shift;
    let mut left = attempt.iterations();
    let mut extended = false;
    let tolerance = settings.interior_point.tolerance;
    let solution = loop {
        if watch.stop.is_some() {
            return None;
        }
        let barrier_parameter = warm.barrier_parameter;
        let interior_point = nlp::Settings {
            tolerance: (1e-2 * tolerance).max(1e-11),
            constraint_tolerance: FEASIBLE,
            acceptable_tolerance: tolerance,
            acceptable_iterations: 5,
            initial_barrier_parameter: barrier_parameter,
            maximum_iterations: left,
            bound_push: 1e-2 * barrier_parameter,
            bound_fraction: 1e-2 * barrier_parameter,
            permanent_dual_shift: dual_shift,
            ..settings.interior_point.clone()
        };
        let mut progress = Progress::new(attempt.patience, dual_shift > LEAST_SHIFT);
        let solution = watch
            .run(
                Purpose::Crossover,
                &interior_point,
                &mut |info| progress.goes_on(info),
                |settings, observer| {
                    nlp::solve_from(&mut branch, settings, Some(&warm), Some(observer))
                },
            )
            .ok()?;
        left = left.saturating_sub(solution.counts.iterations);
        if left == 0 && !extended && solution.residuals.primal < ALMOST {
            (extended, left) = (true, attempt.iterations());
        } else if left == 0
            || !(progress.is_slow() && dual_shift > LEAST_SHIFT
                || progress.is_held() && solution.barrier_parameter > HELD_BARRIER)
        {
            break solution;
        }
        if progress.is_slow() {
            dual_shift = (1e-2 * dual_shift).max(LEAST_SHIFT);
        }
        warm = WarmStart::from_solution(&solution);
        if progress.is_held() {
            warm.barrier_parameter = (1e-2 * warm.barrier_parameter).max(HELD_BARRIER);
        }
    };
    accepts(branch.problem, &solution, attempt, tolerance).then_some(solution)
}

/// Whether a point is one to certify. Residuals decide, not the status: a program with as many equations as variables may end with
/// a failed line search at an exact solution.
fn accepts(
    problem: &mut dyn Mpcc,
    solution: &nlp::Solution,
    attempt: Attempt,
    tolerance: f64,
) -> bool {
    let nlp::Residuals {
        primal,
        dual,
        complementarity,
    } = solution.residuals;
    if primal > FEASIBLE || attempt.patience == Patience::UntilFeasible {
        return primal <= FEASIBLE;
    }
    let scale = norm_inf(&solution.multipliers).max(1.0);
    let optimal = dual <= tolerance * (scale / LARGE_MULTIPLIERS).max(1.0);
    // where there are no multipliers, the linear programs of the certificate decide, and give some
    let mut rough = || {
        let mut gradient = vec![0.0; solution.x.len()];
        problem.gradient(&solution.x, &mut gradient);
        let absent = scale > ABSENT * norm_inf(&gradient).max(1.0);
        attempt.patience == Patience::Much && absent && dual <= ROUGHLY * scale
    };
    complementarity <= COMPLEMENTARITY * tolerance * solution.objective.abs().max(1.0)
        && (optimal || rough())
}
