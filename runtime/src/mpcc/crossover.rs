//! From the relaxed solution to an exact one: fix one side of each pair and solve the smooth program.

use super::branch::{Attempt, solve_branch};
use super::certificate::Certifier;
use super::forced::mark_forced;
use super::watch::Watch;
use super::{Certificate, Mpcc, Residuals, Settings, Solution, Status};
use crate::nlp;

/// An exact point.
#[derive(Debug, Clone)]
pub(crate) struct Exact {
    point: nlp::Solution,
    certificate: Certificate,
    /// The sides that are fixed at zero.
    vanishes: Vec<bool>,
    pub(crate) repairs: usize,
}

impl Exact {
    /// A solved branch with its certificate.
    fn new(
        problem: &mut dyn Mpcc,
        settings: &Settings,
        vanishes: Vec<bool>,
        mut point: nlp::Solution,
        watch: &mut Watch<'_>,
    ) -> Self {
        clean(problem, &vanishes, &mut point);
        Self {
            certificate: certify(problem, settings, &point, watch),
            point,
            vanishes,
            repairs: 0,
        }
    }

    /// Writes the point to a solution and returns the choice of sides.
    pub(crate) fn describe(self, problem: &dyn Mpcc, solution: &mut Solution) -> Vec<bool> {
        let point = self.point;
        let pairs = problem.complementarities().iter();
        solution.residuals = Residuals {
            primal: point.residuals.primal,
            dual: point.residuals.dual,
            complementarity: pairs.fold(0.0, |most: f64, &(i, j)| {
                most.max(point.x[i].min(point.x[j]))
            }),
        };
        solution.status = match self.certificate.b_stationary {
            Some(true) => Status::Solved,
            Some(false) => Status::NotStationary,
            None => Status::Uncertified,
        };
        solution.objective = point.objective;
        solution.x = point.x;
        solution.multipliers = point.multipliers;
        solution.multipliers_lower = point.multipliers_lower;
        solution.multipliers_upper = point.multipliers_upper;
        solution.violations = point.violations;
        solution.certificate = Some(self.certificate);
        self.vanishes
    }
}

/// From a run that goes on if this fails.
pub(crate) const PAUSED: [Attempt; 1] = [Attempt::new(1e-6, 1e-5)];
/// From the end of a relaxed run.
pub(crate) const FINAL: [Attempt; 3] = [
    Attempt::new(1e-6, 1e-5),
    Attempt::new(1e-6, 1e-7),
    Attempt::new(1e-3, 1e-8),
];
/// After a step along a descent direction, the first also from another choice of sides.
const NEAR: [Attempt; 3] = [
    Attempt::new(1e-4, 1e-5),
    Attempt::new(1e-6, 1e-7),
    Attempt::new(1e-2, 1e-8),
];

/// Which variables to fix at zero: the choice of the problem if it has one, else the smaller side of each
/// pair.
fn vanishing_sides(problem: &dyn Mpcc, x: &[f64], nu: &[f64], zero: f64) -> Vec<bool> {
    let mut vanishes = vec![false; x.len()];
    if problem.vanishing_sides(x, &mut vanishes) {
        let covered = problem
            .complementarities()
            .iter()
            .all(|&(i, j)| vanishes[i] || vanishes[j]);
        if covered {
            return vanishes;
        }
        vanishes.fill(false);
    }
    // decided pairs first, so that a variable shared with an undecided pair settles that pair too
    for undecided in [false, true] {
        for &(i, j) in problem.complementarities() {
            let both_small = x[i].max(x[j]) <= 1e3 * zero;
            if both_small != undecided || vanishes[i] || vanishes[j] {
                continue;
            }
            let first = if both_small {
                nu[i] >= nu[j]
            } else {
                x[i] <= x[j]
            };
            vanishes[if first { i } else { j }] = true;
        }
    }
    vanishes
}

/// Crossover from a relaxed solution, with repairs while the certificate finds descent.
pub(crate) fn cross_over(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    relaxed: &nlp::Solution,
    attempts: &[Attempt],
    watch: &mut Watch<'_>,
) -> Option<Exact> {
    let mut vanishes = vanishing_sides(
        problem,
        &relaxed.x,
        &relaxed.multipliers_lower,
        settings.zero_tolerance,
    );
    mark_forced(problem, &relaxed.x, &mut vanishes);
    let start = nlp::WarmStart::from_solution(relaxed);
    let point = attempts
        .iter()
        .find_map(|&attempt| solve_branch(problem, settings, &vanishes, &start, attempt, watch))?;
    let mut exact = Exact::new(problem, settings, vanishes, point, watch);
    while exact.repairs < settings.maximum_repairs {
        let Some(next) = repair(problem, settings, &exact, watch) else {
            break;
        };
        exact = Exact {
            repairs: exact.repairs + 1,
            ..next
        };
    }
    Some(exact)
}

/// A lower point of the branch that contains the descent direction of the certificate.
fn repair(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    exact: &Exact,
    watch: &mut Watch<'_>,
) -> Option<Exact> {
    let descent = exact.certificate.descent.as_ref()?;
    let mut vanishes = exact.vanishes.clone();
    for &k in &exact.certificate.biactive {
        let (i, j) = problem.complementarities()[k];
        let first = descent[i] <= descent[j];
        vanishes[i] = first;
        vanishes[j] = !first;
    }
    for &(i, j) in problem.complementarities() {
        if !vanishes[i] && !vanishes[j] {
            let first = exact.point.x[i] <= exact.point.x[j];
            vanishes[if first { i } else { j }] = true;
        }
    }
    mark_forced(problem, &exact.point.x, &mut vanishes);
    let mut start = nlp::WarmStart::from_solution(&exact.point);
    for (x, d) in start.x.iter_mut().zip(descent) {
        *x += 1e-3 * d;
    }
    let point = NEAR.iter().find_map(|&attempt| {
        solve_branch(problem, settings, &vanishes, &start, attempt, watch)
            .filter(|next| next.objective < exact.point.objective)
    })?;
    Some(Exact::new(problem, settings, vanishes, point, watch))
}

/// Iterations that neighbours may take at least, and at most as a part of those before: a step of a scene has few
/// and cheap ones, and in a long motion each of many may cost as much as the others without a gain.
const NEIGHBOUR_ITERATIONS: usize = 150;
const NEIGHBOUR_PART: usize = 4;

/// Tries the neighbours of a certified point that the problem knows of, in their order, and goes on from each that
/// is certified and better, until none is, [`Settings::maximum_neighbours`] are tried, or their iterations are used up.
pub(crate) fn improve(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    solution: &mut Solution,
    vanishes: &mut Vec<bool>,
    watch: &mut Watch<'_>,
) {
    let before = watch.iterations;
    let limit = before + NEIGHBOUR_ITERATIONS.max(before / NEIGHBOUR_PART);
    loop {
        let mut improved = false;
        for index in 0.. {
            let spent =
                solution.neighbours >= settings.maximum_neighbours || watch.iterations >= limit;
            if spent || watch.stop.is_some() {
                return;
            }
            let mut start = nlp::WarmStart {
                x: solution.x.clone(),
                multipliers: solution.multipliers.clone(),
                multipliers_lower: solution.multipliers_lower.clone(),
                multipliers_upper: solution.multipliers_upper.clone(),
                barrier_parameter: settings.interior_point.tolerance,
            };
            let mut sides = vanishes.clone();
            if !problem.neighbour(index, &mut start.x, &mut sides) {
                break;
            }
            solution.neighbours += 1;
            mark_forced(problem, &start.x, &mut sides);
            let point = solve_branch(problem, settings, &sides, &start, NEAR[0], watch);
            let least =
                10.0 * settings.interior_point.tolerance * solution.objective.abs().max(1.0);
            let Some(point) = point.filter(|p| p.objective < solution.objective - least) else {
                continue;
            };
            let next = Exact::new(problem, settings, sides, point, watch);
            if next.certificate.b_stationary == Some(true) {
                *vanishes = next.describe(problem, solution);
                improved = true;
            }
        }
        if !improved {
            return;
        }
    }
}

/// Multipliers of fixed sides have either sign; one number says it.
fn clean(problem: &dyn Mpcc, vanishes: &[bool], solution: &mut nlp::Solution) {
    for &(i, j) in problem.complementarities() {
        for k in [i, j] {
            if vanishes[k] {
                solution.multipliers_lower[k] -= solution.multipliers_upper[k];
                solution.multipliers_upper[k] = 0.0;
            }
        }
    }
}

fn certify(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    solution: &nlp::Solution,
    watch: &mut Watch<'_>,
) -> Certificate {
    Certifier {
        problem,
        zero_tolerance: settings.zero_tolerance,
        maximum_programs: settings.maximum_certificate_programs,
    }
    .certify(&solution.x, &solution.multipliers_lower, watch)
}
