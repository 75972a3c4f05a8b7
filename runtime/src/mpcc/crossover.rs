//! From the relaxed solution to an exact one: fix one side of each pair and solve the smooth program.

use super::branch::Branch;
use super::certificate::Certifier;
use super::{Certificate, Mpcc, Settings};
use crate::nlp::{self, WarmStart};

/// An exact point.
#[derive(Debug, Clone)]
pub(crate) struct Exact {
    pub(crate) solution: nlp::Solution,
    pub(crate) certificate: Certificate,
    pub(crate) repairs: usize,
}

/// Totals of the crossovers.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Work {
    pub(crate) iterations: usize,
    pub(crate) factorizations: usize,
}

/// Most iterations of one crossover.
const ITERATIONS: usize = 30;
/// Attempts (barrier parameter, dual shift) from a relaxed point. The shift damps the steps of programs with
/// dependent rows or more equations than variables: with 1e-5 most crossovers take 3 to 6 iterations, with
/// 1e-8 six to ten, but a few need the smaller one.
const FROM_RELAXED: [(f64, f64); 3] = [(1e-6, 1e-5), (1e-6, 1e-8), (1e-3, 1e-8)];
/// Attempts after a step along a descent direction.
const FROM_DESCENT: [(f64, f64); 2] = [(1e-4, 1e-5), (1e-2, 1e-8)];
/// Steps cut below 0.05 in a row that end a crossover.
const SHORT_STEPS: usize = 6;
/// Violation up to which a crossover is accepted.
const FEASIBLE: f64 = 1e-9;

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

/// Solves the program with the given sides fixed, from a point with multipliers.
fn solve_branch(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    vanishes: &[bool],
    start: &nlp::Solution,
    (barrier_parameter, dual_shift): (f64, f64),
    work: &mut Work,
) -> Option<nlp::Solution> {
    let interior_point = nlp::Settings {
        tolerance: (1e-2 * settings.interior_point.tolerance).max(1e-11),
        constraint_tolerance: FEASIBLE,
        acceptable_tolerance: settings.interior_point.tolerance,
        acceptable_iterations: 5,
        initial_barrier_parameter: barrier_parameter,
        maximum_iterations: ITERATIONS,
        bound_push: 1e-2 * barrier_parameter,
        bound_fraction: 1e-2 * barrier_parameter,
        bound_relaxation: 0.0,
        permanent_dual_shift: dual_shift,
        ..settings.interior_point.clone()
    };
    let warm = WarmStart {
        barrier_parameter,
        ..WarmStart::from_solution(start)
    };
    let mut branch = Branch {
        problem,
        fixed: vanishes,
    };
    // a wrong choice of sides shows as a row of steps cut to nothing
    let mut short_steps = 0;
    let mut observer = |info: &nlp::IterationInfo| {
        let short = info.iteration > 0 && info.step_length_primal < 0.05;
        short_steps = if short { short_steps + 1 } else { 0 };
        short_steps < SHORT_STEPS
    };
    let solution = nlp::solve_from(
        &mut branch,
        &interior_point,
        Some(&warm),
        Some(&mut observer),
    )
    .ok()?;
    work.iterations += solution.counts.iterations;
    work.factorizations += solution.counts.factorizations;
    // residuals decide, not the status: a program with as many equations as variables may end with a
    // failed line search at an exact solution
    let tolerance = settings.interior_point.tolerance;
    let scale = solution
        .multipliers
        .iter()
        .fold(1.0, |a: f64, y| a.max(y.abs()));
    let accepted = solution.residuals.primal <= FEASIBLE
        && solution.residuals.dual <= tolerance * scale
        && solution.residuals.complementarity <= tolerance * scale;
    accepted.then_some(solution)
}

/// Crossover from a relaxed solution, with repairs while the certificate finds descent.
pub(crate) fn cross_over(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    relaxed: &nlp::Solution,
    work: &mut Work,
) -> Option<Exact> {
    let mut vanishes = vanishing_sides(
        problem,
        &relaxed.x,
        &relaxed.multipliers_lower,
        settings.zero_tolerance,
    );
    let found = FROM_RELAXED
        .into_iter()
        .find_map(|attempt| solve_branch(problem, settings, &vanishes, relaxed, attempt, work));
    let mut solution = found?;
    clean(problem, &vanishes, &mut solution);
    let mut certificate = certify(problem, settings, &solution);
    let mut repairs = 0;
    while repairs < settings.maximum_repairs {
        let Some(descent) = &certificate.descent else {
            break;
        };
        // the branch that contains the descent direction
        for &k in &certificate.biactive {
            let (i, j) = problem.complementarities()[k];
            let first = descent[i] <= descent[j];
            vanishes[i] = first;
            vanishes[j] = !first;
        }
        for k in 0..problem.complementarities().len() {
            let (i, j) = problem.complementarities()[k];
            if !vanishes[i] && !vanishes[j] {
                let side = if solution.x[i] <= solution.x[j] { i } else { j };
                vanishes[side] = true;
            }
        }
        let mut start = solution.clone();
        for (x, d) in start.x.iter_mut().zip(descent) {
            *x += 1e-3 * d;
        }
        repairs += 1;
        let next = FROM_DESCENT
            .into_iter()
            .find_map(|attempt| solve_branch(problem, settings, &vanishes, &start, attempt, work));
        let Some(mut next) = next else { break };
        clean(problem, &vanishes, &mut next);
        if next.objective >= solution.objective {
            break;
        }
        solution = next;
        certificate = certify(problem, settings, &solution);
    }
    Some(Exact {
        solution,
        certificate,
        repairs,
    })
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

fn certify(problem: &mut dyn Mpcc, settings: &Settings, solution: &nlp::Solution) -> Certificate {
    Certifier {
        problem,
        zero_tolerance: settings.zero_tolerance,
        maximum_programs: settings.maximum_certificate_programs,
    }
    .certify(&solution.x, &solution.multipliers_lower)
}
