//! The elastic form of a complementarity problem: one slack for all products.

use super::finish::{End, finish};
use super::watch::{Purpose, Watch};
use super::{Mpcc, RelaxationRule, Settings, Solution};
use crate::nlp::{self, InputError, NlpProblem, Pattern, Products};

/// The smooth program
///
/// ```text
///     min f(x) + t   s.t.  c_l <= c(x) <= c_u,  x_l <= x <= x_u,  x_i x_j <= sigma t for all pairs,  t >= 0
/// ```
///
/// which is the l-infinity elastic mode `f + s / sigma`, `x_i x_j <= s`, with the slack `s = sigma t` in a unit
/// that keeps the gradient of the objective of order one (Anitescu, SIAM Journal on Optimization 15, 2005). It is
/// feasible wherever the other constraints are; `s` vanishes from some `sigma` on if the complementarity
/// problem has multipliers there.
pub(crate) struct Elastic<'a> {
    pub(crate) problem: &'a mut dyn Mpcc,
    pub(crate) sigma: f64,
    pairs: Vec<(usize, usize)>,
    /// Number of entries of the Jacobian of the problem itself.
    jacobian: usize,
    hessian: Pattern,
    /// Number of entries of the Hessian of the problem itself.
    own_hessian: usize,
}

impl<'a> Elastic<'a> {
    pub(crate) fn new(problem: &'a mut dyn Mpcc) -> Self {
        let pairs = problem.complementarities().to_vec();
        let mut hessian = problem.hessian_pattern();
        let own_hessian = hessian.len();
        hessian.extend(pairs.iter().map(|&(i, j)| (i.max(j), i.min(j))));
        Self {
            sigma: 1.0,
            jacobian: problem.jacobian_pattern().len(),
            hessian: Pattern::new(&hessian),
            own_hessian,
            pairs,
            problem,
        }
    }

    /// Takes the slack out of a solution, and the multipliers of the products into those of the paired variables.
    fn remove_products(&self, solution: &mut nlp::Solution) {
        let (n, m) = (self.problem.variables(), self.problem.constraints());
        for (&(i, j), r) in self.pairs.iter().zip(&solution.multipliers[m..]) {
            solution.multipliers_lower[i] -= r * solution.x[j];
            solution.multipliers_lower[j] -= r * solution.x[i];
        }
        solution.objective -= solution.x[n];
        solution.x.truncate(n);
        solution.multipliers.truncate(m);
        solution.multipliers_lower.truncate(n);
        solution.multipliers_upper.truncate(n);
    }
}

impl NlpProblem for Elastic<'_> {
    fn variables(&self) -> usize {
        self.problem.variables() + 1
    }

    fn constraints(&self) -> usize {
        self.problem.constraints() + self.pairs.len()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        let n = self.problem.variables();
        self.problem
            .variable_bounds(&mut lower[..n], &mut upper[..n]);
        (lower[n], upper[n]) = (0.0, f64::INFINITY);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        let m = self.problem.constraints();
        self.problem
            .constraint_bounds(&mut lower[..m], &mut upper[..m]);
        lower[m..].fill(f64::NEG_INFINITY);
        upper[m..].fill(0.0);
    }

    fn initial_point(&self, x: &mut [f64]) {
        let n = self.problem.variables();
        self.problem.initial_point(&mut x[..n]);
        x[n] = 1.0;
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        let n = self.problem.variables();
        self.problem.objective(&x[..n]) + x[n]
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        let n = self.problem.variables();
        self.problem.gradient(&x[..n], &mut gradient[..n]);
        gradient[n] = 1.0;
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        let (n, m) = (self.problem.variables(), self.problem.constraints());
        self.problem.constraint_values(&x[..n], &mut c[..m]);
        for (c, &(i, j)) in c[m..].iter_mut().zip(&self.pairs) {
            *c = x[i] * x[j] - self.sigma * x[n];
        }
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        let (n, m) = (self.problem.variables(), self.problem.constraints());
        let mut pattern = self.problem.jacobian_pattern();
        for (k, &(i, j)) in self.pairs.iter().enumerate() {
            pattern.extend([(m + k, i), (m + k, j), (m + k, n)]);
        }
        pattern
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        let n = self.problem.variables();
        let (own, products) = values.split_at_mut(self.jacobian);
        self.problem.jacobian_values(&x[..n], own);
        for (values, &(i, j)) in products.chunks_exact_mut(3).zip(&self.pairs) {
            values.copy_from_slice(&[x[j], x[i], -self.sigma]);
        }
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.hessian.entries.clone()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        let (n, m) = (self.problem.variables(), self.problem.constraints());
        // the problem's own entries come first, each position once
        let (own, added) = values.split_at_mut(self.own_hessian);
        self.problem
            .hessian_values(&x[..n], weight, &multipliers[..m], own);
        added.fill(0.0);
        let places = &self.hessian.places[self.own_hessian..];
        for (&place, multiplier) in places.iter().zip(&multipliers[m..]) {
            values[place] += multiplier;
        }
    }

    fn variable_name(&self, index: usize) -> String {
        if index == self.problem.variables() {
            return "elastic slack".into();
        }
        self.problem.variable_name(index)
    }

    fn constraint_name(&self, index: usize) -> String {
        match index.checked_sub(self.problem.constraints()) {
            Some(pair) => self.problem.complementarity_name(pair),
            None => self.problem.constraint_name(index),
        }
    }
}

/// Fraction of the last slack above which a slack counts as unchanged, and how many unchanged ones in a row show
/// infeasibility: where the pairs can be met, a tenfold weight makes the slack vanish or shrink in proportion.
const STUCK: f64 = 0.9;
const STUCK_PROGRAMS: usize = 3;

/// Decrease of the objective, relative to its first value, from which an elastic program counts as unbounded.
const UNBOUNDED: f64 = 1e6;
/// Violation up to which a stall is one of the multipliers.
const FEASIBLE: f64 = 1e-6;
/// Share of the error that a step has to leave to count as progress, and most steps without.
const PROGRESS: f64 = 0.9;
const STALLED_STEPS: usize = 100;

/// Why an elastic program is given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum GivenUp {
    /// The weight of the slack is too small: the objective falls faster than the slack costs.
    Unbounded,
    /// A feasible point whose optimality error does not fall: there are no multipliers.
    Stalled,
}

/// Watches the run of one elastic program.
#[derive(Default)]
struct Progress {
    first: Option<f64>,
    barrier_parameter: f64,
    least: f64,
    stalled: usize,
    given_up: Option<GivenUp>,
}

impl Progress {
    /// Takes in an iteration; `false` if the program is given up.
    fn goes_on(&mut self, info: &nlp::IterationInfo) -> bool {
        let error = info.dual_infeasibility.max(info.complementarity);
        let moves = error < PROGRESS * self.least
            || info.barrier_parameter != self.barrier_parameter
            || info.restoration
            || info.primal_infeasibility > FEASIBLE;
        if moves {
            (self.least, self.barrier_parameter) = (error, info.barrier_parameter);
        }
        self.stalled = if moves { 0 } else { self.stalled + 1 };
        if !info.restoration {
            let first = *self.first.get_or_insert(info.objective);
            if info.objective < first - UNBOUNDED * first.abs().max(1.0) {
                self.given_up = Some(GivenUp::Unbounded);
            }
        }
        if self.stalled >= STALLED_STEPS {
            self.given_up = Some(GivenUp::Stalled);
        }
        self.given_up.is_none()
    }
}

/// Elastic programs with `sigma = 1, 0.1, ...`, each warm from the one before, until the slack is at most the final
/// relaxation. A slack that stays as it is while its weight grows is one of local infeasibility. A program that is
/// unbounded, since its weight is too small, is followed by the next one from the first point.
pub(crate) fn elastic(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    watch: &mut Watch<'_>,
) -> Result<Solution, InputError> {
    let mut program = Elastic::new(problem);
    let mut series = Series::new(settings);
    let (mut solution, slack) = loop {
        let (solution, given_up) = series.solve(&mut program, watch)?;
        let stopped = watch.stop.is_some();
        match series.next(&mut program, solution, given_up, stopped) {
            Next::Go => {}
            Next::End(solution, slack) => break (*solution, slack),
        }
    };
    program.remove_products(&mut solution);
    solution.history = series.history;
    let (rule, end) = (
        RelaxationRule::Elastic,
        End::last(slack.max(settings.final_relaxation)),
    );
    Ok(finish(problem, settings, rule, solution, end, watch))
}

/// What follows on an elastic program.
enum Next {
    /// The next one.
    Go,
    /// The end, with the slack.
    End(Box<nlp::Solution>, f64),
}

/// A series of elastic programs.
struct Series<'s> {
    settings: &'s Settings,
    interior_point: nlp::Settings,
    warm: Option<nlp::WarmStart>,
    iterations: usize,
    history: Vec<nlp::IterationInfo>,
    /// Slack of the last program, and how many in a row left it as it was.
    last: f64,
    stuck: usize,
    /// Whether the slack has vanished, so that only accuracy is missing.
    accurate: bool,
}

impl<'s> Series<'s> {
    fn new(settings: &'s Settings) -> Self {
        Self {
            settings,
            interior_point: settings.interior_point.clone(),
            warm: None,
            iterations: 0,
            history: Vec::new(),
            last: f64::INFINITY,
            stuck: 0,
            accurate: false,
        }
    }

    /// Solves a program.
    fn solve(
        &mut self,
        program: &mut Elastic<'_>,
        watch: &mut Watch<'_>,
    ) -> Result<(nlp::Solution, Option<GivenUp>), InputError> {
        let tolerance = self.settings.interior_point.tolerance;
        self.interior_point.tolerance = if self.accurate {
            tolerance
        } else {
            tolerance.max(1e-2 * program.sigma)
        };
        let first = self.interior_point.initial_barrier_parameter;
        let mut path = nlp::Monotone {
            mu: self.warm.as_ref().map_or(first, |w| w.barrier_parameter),
            sigma: 0.0,
            tolerance: self.interior_point.tolerance,
        };
        self.interior_point.maximum_iterations = self
            .settings
            .interior_point
            .maximum_iterations
            .saturating_sub(self.iterations);
        let mut progress = Progress::default();
        let warm = self.warm.as_ref();
        let mut solution = watch.run(
            Purpose::Relaxed,
            &self.interior_point,
            &mut |info| progress.goes_on(info),
            |settings, observer| {
                let none = &mut Products::default();
                nlp::run(program, settings, none, &mut path, warm, Some(observer))
            },
        )?;
        self.iterations += solution.counts.iterations;
        self.history.append(&mut solution.history);
        Ok((solution, progress.given_up))
    }

    /// Decides what follows on a program, and prepares it.
    fn next(
        &mut self,
        program: &mut Elastic<'_>,
        mut solution: nlp::Solution,
        given_up: Option<GivenUp>,
        stopped: bool,
    ) -> Next {
        let floor = self.settings.final_relaxation;
        let tolerance = self.settings.interior_point.tolerance;
        let sigma = program.sigma;
        let n = program.problem.variables();
        let slack = sigma * solution.x[n];
        let is_last = sigma <= floor;
        let smaller = (0.1 * sigma).max(floor);
        if given_up == Some(GivenUp::Unbounded) {
            if is_last || stopped {
                solution.status = nlp::Status::Diverging;
                return Next::End(Box::new(solution), slack);
            }
            program.sigma = smaller;
            self.warm = None;
            return Next::Go;
        }
        if given_up == Some(GivenUp::Stalled) {
            solution.status = nlp::Status::Acceptable;
            if slack <= floor {
                return Next::End(Box::new(solution), slack);
            }
        }
        let solved = solution.status == nlp::Status::Solved;
        let exact = solved && slack <= floor;
        self.stuck = if slack > STUCK * self.last {
            self.stuck + 1
        } else {
            0
        };
        self.last = slack;
        let infeasible = solved && !exact && self.stuck >= STUCK_PROGRAMS;
        let goes_on = solved || solution.status == nlp::Status::Acceptable;
        let accurate = exact && self.interior_point.tolerance <= tolerance;
        if infeasible || !goes_on || is_last || accurate {
            if solved && !exact {
                solution.status = nlp::Status::Infeasible;
                // the objective is what keeps the slack from its least value
                let mut gradient = vec![0.0; n];
                program.problem.gradient(&solution.x[..n], &mut gradient);
                let largest = gradient.iter().fold(0.0, |a: f64, g| a.max(g.abs()));
                let gradient = sigma * (largest + solution.residuals.dual);
                solution.violation_stationarity = Some(gradient);
            }
            return Next::End(Box::new(solution), slack);
        }
        self.accurate = exact;
        let next = if exact { sigma } else { smaller };
        let mut start = nlp::WarmStart {
            barrier_parameter: solution.barrier_parameter.max(1e-2 * next).min(0.1),
            ..nlp::WarmStart::from_solution(&solution)
        };
        // the slack in its new unit
        start.x[n] = slack / next;
        self.interior_point.bound_push = 1e-9;
        self.interior_point.bound_fraction = 1e-9;
        program.sigma = next;
        self.warm = Some(start);
        Next::Go
    }
}
