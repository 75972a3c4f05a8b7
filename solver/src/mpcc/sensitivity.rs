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
//!
//! That asks for multipliers which are unique, and for none that vanishes together with the distance to its bound. Where rows and bounds
//! that hold depend on each other, or some of them hold without a multiplier, the objective has a derivative to each side (Gauvin and
//! Dubeau, *Differential properties of the marginal function in mathematical programming*, Mathematical Programming Study 19, 1982): the
//! value of the linear program of directions
//!
//! ```text
//! V'(+-1) = min f_x d +- f_p   subject to   c_x d +- c_p = 0 or >= 0 of the rows that hold,  d >= 0 of the bounds that do
//! ```
//!
//! whose dual asks all multipliers. Where both are the same it is the derivative after all.

use super::Settings;
use super::linear_program::LinearProgram;
use super::watch::Watch;
use crate::linalg::{RefinedSolver, SymmetricPattern};
use crate::nlp::{NlpProblem, Solution};

/// Relative residual of the linear system up to which its solution counts.
const SOLVED: f64 = 1e-8;
/// Shift of rows that depend on each other.
const SHIFT: f64 = 1e-11;

/// How a solution moves with one of its fixed variables.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Moved {
    /// Derivatives of the objective towards smaller and towards larger values: the same where there is one. Not a number to a side on
    /// which no solution is near, or where none was found.
    pub objective: [f64; 2],
    /// Derivatives of all variables, 1 for the fixed one; `None` where the held rows and bounds leave them undetermined.
    pub x: Option<Vec<f64>>,
    /// How far the fixed variable may move, to first order, until other rows or bounds hold: down and up; `None` where nothing ends that,
    /// or nothing is known of it.
    pub range: [Option<RangeEnd>; 2],
}

/// What ends the range in which the same rows and bounds hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeEnd {
    /// Change of the fixed variable.
    pub change: f64,
    /// What is another then.
    pub at: RangeLimit,
}

/// A row or bound that holds, or ceases to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RangeLimit {
    /// The row comes to one of its bounds.
    RowReached(usize),
    /// The row leaves its bound.
    RowLeft(usize),
    /// The variable comes to one of its bounds.
    BoundReached(usize),
    /// The variable leaves its bound.
    BoundLeft(usize),
}

/// Derivatives below this share of the largest one are rounding, and end nothing.
const MOVES: f64 = 1e-7;
/// Distance and multiplier up to which a bound or row may hold without one: what an interior point method leaves of both where their product
/// is at its tolerance.
const WEAK: f64 = 1e-4;
/// Share of a derivative by which those to both sides may differ: the tolerance of the linear program.
const SAME: f64 = 1e-5;
/// Largest change of a variable for one of the fixed variable: beyond it no solution is near.
const FARTHEST: f64 = 1e4;

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
    let found = directions([&hessian, &jacobian], [&free, &held], fixed);
    let ranges = Ranges::of(problem, solution, [&hessian, &jacobian], [&free, &held]);
    let independent = found.as_ref().is_some_and(|(_, independent)| *independent);
    let program = (!independent || ranges.any_weak()).then(|| ranges.program(problem));
    let mut directions = found.map(|(directions, _)| directions);
    let mut moved = |(k, &p): (usize, &usize)| {
        let direction = directions.as_mut().map(|all| std::mem::take(&mut all[k]));
        let own = [gradient[p]; 2];
        let sides = program.as_ref().map_or(own, |program| sides(program, p));
        let least = SAME * sides[0].abs().max(sides[1].abs()).max(gradient[p].abs());
        let exists = (sides[1] - sides[0]).abs() <= least;
        let direction = direction.filter(|_| exists);
        let known = direction.as_ref();
        Moved {
            objective: if exists { own } else { sides },
            range: known.map_or([None; 2], |(x, y)| ranges.range(x, y, p)),
            x: direction.map(|(x, _)| x),
        }
    };
    fixed.iter().enumerate().map(&mut moved).collect()
}

/// Derivatives of the objective by a fixed variable to both sides, from the program of directions.
fn sides(program: &LinearProgram, fixed: usize) -> [f64; 2] {
    [-1.0, 1.0].map(|sense| {
        let mut program = program.clone();
        (program.lower[fixed], program.upper[fixed]) = (sense, sense);
        let mut observer = |_: &crate::nlp::IterationInfo| true;
        let found = program.solve(&mut Watch::new(&Settings::default(), &mut observer));
        found.map_or(f64::NAN, |(_, value)| sense * value)
    })
}

/// What the rows and bounds of a solution have left.
struct Ranges<'r> {
    solution: &'r Solution,
    /// Lower and upper bounds of variables and of rows.
    bounds: [Vec<f64>; 2],
    row_bounds: [Vec<f64>; 2],
    rows: Vec<f64>,
    hessian: &'r Entries,
    jacobian: &'r Entries,
    free: &'r [Option<usize>],
    held: &'r [Option<usize>],
}

impl<'r> Ranges<'r> {
    fn of(
        problem: &mut dyn NlpProblem,
        solution: &'r Solution,
        [hessian, jacobian]: [&'r Entries; 2],
        [free, held]: [&'r [Option<usize>]; 2],
    ) -> Self {
        let (n, m) = (free.len(), held.len());
        let mut bounds = [vec![0.0; n], vec![0.0; n]];
        let [lower, upper] = &mut bounds;
        problem.variable_bounds(lower, upper);
        let mut row_bounds = [vec![0.0; m], vec![0.0; m]];
        let [lower, upper] = &mut row_bounds;
        problem.constraint_bounds(lower, upper);
        let mut rows = vec![0.0; m];
        problem.constraint_values(&solution.x, &mut rows);
        Self {
            solution,
            bounds,
            row_bounds,
            rows,
            hessian,
            jacobian,
            free,
            held,
        }
    }

    /// Distances of a variable from its bounds, of one that is not fixed.
    fn room(&self, i: usize) -> Option<[f64; 2]> {
        let [lower, upper] = [self.bounds[0][i], self.bounds[1][i]];
        let x = self.solution.x[i];
        (lower < upper).then_some([x - lower, upper - x])
    }

    /// How far a row that is no equation is from its bounds.
    fn row_room(&self, row: usize) -> Option<[f64; 2]> {
        let [lower, upper] = [self.row_bounds[0][row], self.row_bounds[1][row]];
        let c = self.rows[row];
        (lower < upper).then_some([c - lower, upper - c])
    }

    /// Whether some row or bound holds without a multiplier.
    fn any_weak(&self) -> bool {
        let multipliers = [
            &self.solution.multipliers_lower,
            &self.solution.multipliers_upper,
        ];
        let mut variables = (0..self.free.len()).filter_map(|i| Some((i, self.room(i)?)));
        let weak = |room: f64, multiplier: f64| room <= WEAK && multiplier.abs() <= WEAK;
        let mut rows = (0..self.held.len()).filter_map(|row| Some((row, self.row_room(row)?)));
        variables.any(|(i, room)| (0..2).any(|side| weak(room[side], multipliers[side][i])))
            || rows.any(|(row, room)| weak(room[0].min(room[1]), self.solution.multipliers[row]))
    }

    /// The linear program of directions, in which no fixed variable moves: rows and bounds that do not hold are left out.
    fn program(&self, problem: &mut dyn NlpProblem) -> LinearProgram {
        let (n, m) = (self.free.len(), self.held.len());
        let mut gradient = vec![0.0; n];
        problem.gradient(&self.solution.x, &mut gradient);
        let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
        for i in 0..n {
            let Some(room) = self.room(i) else { continue };
            let held = self.free[i].is_none();
            let sides = [
                self.solution.multipliers_lower[i],
                self.solution.multipliers_upper[i],
            ];
            let holds = |side: usize| room[side] <= WEAK || held && sides[side] >= room[side];
            lower[i] = if holds(0) { 0.0 } else { -FARTHEST };
            upper[i] = if holds(1) { 0.0 } else { FARTHEST };
        }
        let mut largest = vec![0.0_f64; m];
        for (&(row, _), value) in self.jacobian.places.iter().zip(&self.jacobian.values) {
            largest[row] += value.abs() * FARTHEST;
        }
        let (mut row_lower, mut row_upper) = (vec![0.0; m], vec![0.0; m]);
        for row in 0..m {
            let Some(room) = self.row_room(row) else {
                continue;
            };
            let held = self.held[row].is_some();
            let nearer = usize::from(room[1] < room[0]);
            let holds = |side: usize| room[side] <= WEAK || held && side == nearer;
            row_lower[row] = if holds(0) { 0.0 } else { -largest[row] };
            row_upper[row] = if holds(1) { 0.0 } else { largest[row] };
            if !holds(0) && !holds(1) {
                (row_lower[row], row_upper[row]) = (f64::NEG_INFINITY, f64::INFINITY);
            }
        }
        LinearProgram {
            gradient,
            pattern: self.jacobian.places.clone(),
            values: self.jacobian.values.clone(),
            row_lower,
            row_upper,
            lower,
            upper,
        }
    }

    /// The smallest changes of the fixed variable `p` by which a distance or a multiplier vanishes, where variables and multipliers of
    /// rows move by these.
    fn range(&self, dx: &[f64], dy: &[f64], p: usize) -> [Option<RangeEnd>; 2] {
        let mut range = [None; 2];
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
        let mut end = |value: f64, rate: f64, least: f64, at: RangeLimit| {
            let change = -value.max(0.0) / rate;
            if rate.abs() <= least || !change.is_finite() {
                return;
            }
            let side: &mut Option<RangeEnd> = &mut range[usize::from(rate < 0.0)];
            if side.is_none_or(|known| known.change.abs() > change.abs()) {
                *side = Some(RangeEnd { change, at });
            }
        };
        let mut d_rows = vec![0.0; self.rows.len()];
        let mut d_gradient = vec![0.0; dx.len()];
        for (&(row, column), value) in self.jacobian.places.iter().zip(&self.jacobian.values) {
            d_rows[row] += value * dx[column];
            d_gradient[column] += value * dy[row];
        }
        for (&(i, j), value) in self.hessian.places.iter().zip(&self.hessian.values) {
            d_gradient[i] += value * dx[j];
            if i != j {
                d_gradient[j] += value * dx[i];
            }
        }
        let (least, least_dual) = (MOVES * largest(dx), MOVES * largest(&d_gradient));
        for (i, free) in self.free.iter().enumerate() {
            let [lower, upper] = [self.bounds[0][i], self.bounds[1][i]];
            let x = self.solution.x[i];
            if i == p || lower >= upper {
                continue;
            }
            if free.is_some() {
                end(x - lower, dx[i], least, RangeLimit::BoundReached(i));
                end(upper - x, -dx[i], least, RangeLimit::BoundReached(i));
            } else {
                // Of the stationarity of the Lagrangian: what pushes up from the lower bound is its gradient.
                let [low, high] = [
                    self.solution.multipliers_lower[i],
                    self.solution.multipliers_upper[i],
                ];
                let (value, sense) = if low >= high {
                    (low, 1.0)
                } else {
                    (high, -1.0)
                };
                let rate = sense * d_gradient[i];
                end(value, rate, least_dual, RangeLimit::BoundLeft(i));
            }
        }
        let least_dual = MOVES * largest(dy);
        for (row, held) in self.held.iter().enumerate() {
            let [lower, upper] = [self.row_bounds[0][row], self.row_bounds[1][row]];
            if lower >= upper {
                continue;
            }
            let (c, y) = (self.rows[row], self.solution.multipliers[row]);
            if held.is_some() {
                let rate = y.signum() * dy[row];
                end(y.abs(), rate, least_dual, RangeLimit::RowLeft(row));
            } else {
                end(c - lower, d_rows[row], least, RangeLimit::RowReached(row));
                end(upper - c, -d_rows[row], least, RangeLimit::RowReached(row));
            }
        }
        range
    }
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

/// Derivatives of all variables, and of the multipliers of all rows.
type Direction = (Vec<f64>, Vec<f64>);

/// These by each fixed variable, and whether the rows that hold are independent; `None` where the system has no solution.
fn directions(
    [hessian, jacobian]: [&Entries; 2],
    [free, held]: [&[Option<usize>]; 2],
    fixed: &[usize],
) -> Option<(Vec<Direction>, bool)> {
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
    let (solutions, independent) = solve(&places, &values, (size, count), &right)?;
    let whole = solutions.iter().zip(fixed).map(|(solution, &p)| {
        let values = free.iter().map(|place| place.map_or(0.0, |i| solution[i]));
        let mut values: Vec<f64> = values.collect();
        values[p] = 1.0;
        let multipliers = held.iter();
        let multipliers = multipliers.map(|place| place.map_or(0.0, |row| solution[count + row]));
        (values, multipliers.collect())
    });
    Some((whole.collect(), independent))
}

/// Solutions of a symmetric system, given by the entries of one triangle, whose first `primal` rows belong to variables, and whether it is
/// regular.
fn solve(
    places: &[(usize, usize)],
    values: &[f64],
    (size, primal): (usize, usize),
    right: &[Vec<f64>],
) -> Option<(Vec<Vec<f64>>, bool)> {
    let (pattern, map) = SymmetricPattern::with_map(size, places.iter().copied())?;
    let mut solver = RefinedSolver::new(pattern, primal).ok()?;
    for (&place, value) in map.iter().zip(values) {
        solver.values_mut()[place as usize] += value;
    }
    let solutions = |solver: &mut RefinedSolver| {
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
        return Some((found, true));
    }
    // Rows that say the same twice leave their multipliers open, not the variables.
    solver.factor(0.0, SHIFT).ok()?;
    Some((solutions(&mut solver)?, false))
}
