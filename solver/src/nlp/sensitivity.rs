//! How a solution moves with variables that are fixed.
//!
//! The bounds and rows that hold with a multiplier stay held, the others stay off them. Where a fixed variable `p` moves, the other
//! variables `x` and the multipliers `y` of the held rows move by
//!
//! ```text
//! [ W  A' ] [ dx ]     [ W e_p ]
//! [ A  0  ] [ dy ] = - [ A e_p ]      W = (f + y' c)_xx,  A = c_x of the held rows
//! ```
//!
//! and the objective by the derivative of the Lagrangian, `f_p + y' c_p` (Fiacco, *Introduction to sensitivity and stability
//! analysis in nonlinear programming*, 1983).

use super::{NlpProblem, Solution};
use crate::linalg::{MultifrontalLdl, RefinedSolver, SymmetricPattern};

/// Relative residual of the linear system up to which its solution counts.
const SOLVED: f64 = 1e-8;
/// Shift of rows that depend on each other.
const SHIFT: f64 = 1e-11;

/// How a solution moves with one of its fixed variables.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Moved {
    /// Derivative of the objective.
    pub objective: f64,
    /// Derivatives of all variables, 1 for the fixed one; none where the held rows and bounds leave them undetermined.
    pub x: Option<Vec<f64>>,
}

/// A matrix by its entries.
struct Entries {
    places: Vec<(usize, usize)>,
    values: Vec<f64>,
}

/// How a solution moves with each of the `fixed` variables, whose bounds are equal.
pub fn moved(problem: &mut dyn NlpProblem, solution: &Solution, fixed: &[usize]) -> Vec<Moved> {
    let (n, m) = (problem.variables(), problem.constraints());
    let mut gradient = vec![0.0; n];
    problem.gradient(&solution.x, &mut gradient);
    let mut jacobian = Entries {
        places: problem.jacobian_pattern(),
        values: Vec::new(),
    };
    jacobian.values.resize(jacobian.places.len(), 0.0);
    problem.jacobian_values(&solution.x, &mut jacobian.values);
    for (&(row, column), value) in jacobian.places.iter().zip(&jacobian.values) {
        gradient[column] += solution.multipliers[row] * value;
    }
    let mut hessian = Entries {
        places: problem.hessian_pattern(),
        values: Vec::new(),
    };
    hessian.values.resize(hessian.places.len(), 0.0);
    problem.hessian_values(&solution.x, 1.0, &solution.multipliers, &mut hessian.values);
    let free = numbered(&free_variables(problem, solution, n));
    let held = numbered(&held_rows(problem, solution, m));
    let mut directions = directions([&hessian, &jacobian], [&free, &held], fixed);
    let moved = fixed.iter().enumerate().map(|(k, &p)| Moved {
        objective: gradient[p],
        x: directions.as_mut().map(|all| std::mem::take(&mut all[k])),
    });
    moved.collect()
}

/// Which variables lie off their bounds: those that are nearer to them than their multipliers are to zero do not.
fn free_variables(problem: &dyn NlpProblem, solution: &Solution, n: usize) -> Vec<bool> {
    let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
    problem.variable_bounds(&mut lower, &mut upper);
    let is_free = |i: usize| {
        let x = solution.x[i];
        lower[i] < upper[i]
            && x - lower[i] > solution.multipliers_lower[i]
            && upper[i] - x > solution.multipliers_upper[i]
    };
    (0..n).map(is_free).collect()
}

/// Which rows hold with a multiplier: equations, and those that are nearer to a bound than their multipliers are to zero.
fn held_rows(problem: &mut dyn NlpProblem, solution: &Solution, m: usize) -> Vec<bool> {
    let (mut lower, mut upper, mut c) = (vec![0.0; m], vec![0.0; m], vec![0.0; m]);
    problem.constraint_bounds(&mut lower, &mut upper);
    problem.constraint_values(&solution.x, &mut c);
    let is_held = |row: usize| {
        let slack = (c[row] - lower[row]).min(upper[row] - c[row]);
        lower[row] >= upper[row] || slack < solution.multipliers[row].abs()
    };
    (0..m).map(is_held).collect()
}

/// The place of each that is chosen among those that are.
fn numbered(chosen: &[bool]) -> Vec<Option<usize>> {
    let mut next = 0;
    let number = |&chosen: &bool| {
        next += usize::from(chosen);
        chosen.then(|| next - 1)
    };
    chosen.iter().map(number).collect()
}

/// Derivatives of all variables by each fixed one; none where the system has no solution.
fn directions(
    [hessian, jacobian]: [&Entries; 2],
    [free, held]: [&[Option<usize>]; 2],
    fixed: &[usize],
) -> Option<Vec<Vec<f64>>> {
    let count = free.iter().flatten().count();
    let size = count + held.iter().flatten().count();
    let mut places = Vec::new();
    let mut values = Vec::new();
    let mut right = vec![vec![0.0; size]; fixed.len()];
    let mut add = |row: Option<usize>, column: usize, value: f64| {
        let Some(row) = row else { return };
        if let Some(column) = free[column] {
            places.push((row, column));
            values.push(value);
        }
        if let Some(k) = fixed.iter().position(|&p| p == column) {
            right[k][row] -= value;
        }
    };
    for (&(i, j), &value) in hessian.places.iter().zip(&hessian.values) {
        // The other half of what a fixed variable and another one share.
        if i != j && free[i].is_none() && free[j].is_some() {
            add(free[j], i, value);
        } else {
            add(free[i], j, value);
        }
    }
    for (&(row, column), &value) in jacobian.places.iter().zip(&jacobian.values) {
        add(held[row].map(|row| count + row), column, value);
    }
    let solutions = solve(&places, &values, (size, count), &right)?;
    let whole = solutions.iter().zip(fixed).map(|(solution, &p)| {
        let values = free.iter().map(|place| place.map_or(0.0, |i| solution[i]));
        let mut values: Vec<f64> = values.collect();
        values[p] = 1.0;
        values
    });
    Some(whole.collect())
}

/// Solutions of a symmetric system, given by the entries of one triangle, whose first `primal` rows belong to variables.
fn solve(
    places: &[(usize, usize)],
    values: &[f64],
    (size, primal): (usize, usize),
    right: &[Vec<f64>],
) -> Option<Vec<Vec<f64>>> {
    let (pattern, map) = SymmetricPattern::with_map(size, places.iter().copied())?;
    let factors = MultifrontalLdl::new(&pattern, primal).ok()?;
    let mut solver = RefinedSolver::new(pattern, primal, factors);
    for (&place, value) in map.iter().zip(values) {
        solver.values_mut()[place as usize] += value;
    }
    let solutions = |solver: &mut RefinedSolver<MultifrontalLdl>| {
        let each = right.iter().map(|right| {
            let mut solution = vec![0.0; size];
            let residual = solver.solve(right, &mut solution);
            (residual <= SOLVED && solution.iter().all(|x| x.is_finite())).then_some(solution)
        });
        each.collect::<Option<Vec<_>>>()
    };
    let exact = solver
        .factor(0.0, 0.0)
        .ok()
        .filter(|inertia| inertia.zero == 0);
    if exact.is_some()
        && let Some(found) = solutions(&mut solver)
    {
        return Some(found);
    }
    // Rows that say the same twice leave their multipliers open, not the variables.
    solver.factor(0.0, SHIFT).ok()?;
    solutions(&mut solver)
}
