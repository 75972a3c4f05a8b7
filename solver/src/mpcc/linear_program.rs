//! Linear programs of the certificate, by a primal-dual method of their own.
//!
//! Mehrotra's predictor and corrector (SIAM Journal on Optimization 2, 1992), with both blocks of the Newton matrix shifted by a
//! proximal term (Friedlander and Orban, Mathematical Programming Computation 4, 2012): rows may depend on each other, and many do at
//! a degenerate point. Every variable has two finite bounds, so that any multipliers `y` of the rows give a lower bound of the value,
//!
//! ```text
//!     sum_r min (y_r r_l, y_r r_u)  +  sum_i min over l_i <= d_i <= u_i of (g - J'y)_i d_i,
//! ```
//!
//! which ends a program early where all that is asked is whether its value is low, and proves that one has no point.

use super::watch::Watch;
use crate::linalg::norms::norm_inf;
use crate::linalg::{RefinedSolver, SymmetricPattern};
use crate::nlp::IterationInfo;
use crate::seconds::timed;

/// `min g'd` subject to `r_l <= J d <= r_u`, `d_l <= d <= d_u` with finite bounds of `d`.
#[derive(Clone)]
pub(crate) struct LinearProgram {
    pub(crate) gradient: Vec<f64>,
    pub(crate) pattern: Vec<(usize, usize)>,
    pub(crate) values: Vec<f64>,
    pub(crate) row_lower: Vec<f64>,
    pub(crate) row_upper: Vec<f64>,
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
}

/// What became of a program.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Outcome {
    /// Solution, value, and multipliers of the rows.
    Solution(Vec<f64>, f64, Vec<f64>),
    /// The value is proved to be at least what was asked for, or there is no point; by these multipliers of the rows.
    Above(Vec<f64>),
    /// Neither was found.
    Failed,
}

const MOST_ITERATIONS: usize = 80;
/// Errors of the optimality conditions of the scaled program.
const TOLERANCE: f64 = 1e-9;
const ACCEPTABLE: f64 = 1e-7;
/// Shift of both blocks.
const SHIFT: f64 = 1e-10;
/// Fraction of the way to the boundary.
const FRACTION: f64 = 0.995;
/// Least distance to a bound, relative to bounds of at least one: closer points would round to the bound itself.
const LEAST_DISTANCE: f64 = 1e-15;

impl LinearProgram {
    /// Adds a row between two bounds.
    pub(crate) fn add_row(&mut self, (lower, upper): (f64, f64), entries: &[(usize, f64)]) {
        let row = self.row_lower.len();
        for &(k, value) in entries {
            self.pattern.push((row, k));
            self.values.push(value);
        }
        self.row_lower.push(lower);
        self.row_upper.push(upper);
    }

    /// Solution and value; `None` if there is none or none was found.
    pub(crate) fn solve(&self, watch: &mut Watch<'_>) -> Option<(Vec<f64>, f64)> {
        match self.solve_below(f64::INFINITY, watch) {
            Outcome::Solution(d, value, _) => Some((d, value)),
            _ => None,
        }
    }

    /// Solution and value, unless the value is at least `limit`.
    pub(crate) fn solve_below(&self, limit: f64, watch: &mut Watch<'_>) -> Outcome {
        let mut seconds = 0.0;
        let outcome = timed(&mut seconds, || match Method::new(self) {
            Some(mut method) => {
                method.solver.work_until(watch.until());
                method.run(limit, watch)
            }
            None => Outcome::Failed,
        });
        watch.cpu.total += seconds;
        outcome
    }
}

/// An entry of the scaled rows.
struct Entry {
    row: usize,
    variable: usize,
    value: f64,
    /// Its place in the Newton matrix.
    place: usize,
}

/// The method on one program. Rows are scaled to entries of at most one, the objective to a largest entry of one. A row that is no
/// equality has a slack, which is a variable behind the others.
struct Method {
    cost: Vec<f64>,
    cost_scale: f64,
    lower: Vec<f64>,
    upper: Vec<f64>,
    entries: Vec<Entry>,
    /// Right-hand sides of `A w = b`.
    right: Vec<f64>,
    /// For each row of the program its number here, if it says anything, and its scale.
    rows: Vec<Option<(usize, f64)>>,
    /// Number of variables without slacks.
    own: usize,
    solver: RefinedSolver,
    w: Vec<f64>,
    y: Vec<f64>,
    z_lower: Vec<f64>,
    z_upper: Vec<f64>,
    /// `b - A w` and `c - A'y`.
    violation: Vec<f64>,
    reduced: Vec<f64>,
}

/// A direction of all unknowns.
struct Direction {
    w: Vec<f64>,
    y: Vec<f64>,
    z_lower: Vec<f64>,
    z_upper: Vec<f64>,
}

impl Method {
    /// The scaled program with its Newton matrix; `None` if that is too large.
    fn new(program: &LinearProgram) -> Option<Self> {
        let n = program.gradient.len();
        let m = program.row_lower.len();
        let mut largest = vec![0.0_f64; m];
        for (&(row, _), value) in program.pattern.iter().zip(&program.values) {
            largest[row] = largest[row].max(value.abs());
        }
        let (mut lower, mut upper) = (program.lower.clone(), program.upper.clone());
        let mut rows = vec![None; m];
        let mut right = Vec::new();
        let mut slacks = Vec::new();
        for row in 0..m {
            let (below, above) = (program.row_lower[row], program.row_upper[row]);
            let bounded = below.is_finite() || above.is_finite();
            if !bounded || largest[row] == 0.0 {
                continue;
            }
            rows[row] = Some((right.len(), largest[row]));
            if below == above {
                right.push(below / largest[row]);
            } else {
                slacks.push((right.len(), lower.len()));
                lower.push(below / largest[row]);
                upper.push(above / largest[row]);
                right.push(0.0);
            }
        }
        let kept = |(&(row, variable), &value): (&(usize, usize), &f64)| {
            let (row, scale): (usize, f64) = rows[row]?;
            Some((row, variable, value / scale))
        };
        let mut entries: Vec<(usize, usize, f64)> = program
            .pattern
            .iter()
            .zip(&program.values)
            .filter_map(kept)
            .collect();
        entries.extend(slacks.iter().map(|&(row, slack)| (row, slack, -1.0)));
        let count = lower.len();
        let places = entries.iter().map(|e| (count + e.0, e.1));
        let (pattern, map) = SymmetricPattern::with_map(count + right.len(), places)?;
        let places = map.into_iter().map(|place| place as usize);
        let entries = entries.into_iter().zip(places);
        let entries = entries.map(|((row, variable, value), place)| Entry {
            row,
            variable,
            value,
            place,
        });
        let largest = norm_inf(&program.gradient);
        let cost_scale = if largest > 0.0 { largest } else { 1.0 };
        let mut cost: Vec<f64> = program.gradient.iter().map(|g| g / cost_scale).collect();
        cost.resize(count, 0.0);
        let kept = right.len();
        Some(Self {
            cost,
            cost_scale,
            entries: entries.collect(),
            own: n,
            solver: RefinedSolver::new(pattern, count).ok()?,
            w: vec![0.0; count],
            y: vec![0.0; kept],
            z_lower: vec![0.0; count],
            z_upper: vec![0.0; count],
            violation: vec![0.0; kept],
            reduced: vec![0.0; count],
            lower,
            upper,
            right,
            rows,
        })
    }

    fn is_fixed(&self, i: usize) -> bool {
        self.lower[i] >= self.upper[i]
    }

    /// A point in the middle of the bounds.
    fn start(&mut self) {
        for i in 0..self.w.len() {
            let (lower, upper) = (self.lower[i], self.upper[i]);
            self.w[i] = match (lower.is_finite(), upper.is_finite()) {
                (true, true) => 0.5 * (lower + upper),
                (true, false) => lower.max(0.0) + 1.0,
                _ => upper.min(0.0) - 1.0,
            };
            if !self.is_fixed(i) {
                self.z_lower[i] = f64::from(u8::from(lower.is_finite()));
                self.z_upper[i] = f64::from(u8::from(upper.is_finite()));
            }
        }
    }

    /// Evaluates violation and reduced costs.
    fn evaluate(&mut self) {
        self.violation.copy_from_slice(&self.right);
        self.reduced.copy_from_slice(&self.cost);
        for entry in &self.entries {
            self.violation[entry.row] -= entry.value * self.w[entry.variable];
            self.reduced[entry.variable] -= entry.value * self.y[entry.row];
        }
    }

    /// Reduced costs that no multiplier of a bound balances.
    fn dual_error(&self) -> f64 {
        let free = (0..self.w.len()).filter(|&i| !self.is_fixed(i));
        let left = |i: usize| (self.reduced[i] - self.z_lower[i] + self.z_upper[i]).abs();
        free.map(left).fold(0.0, f64::max)
    }

    /// The multipliers at hand, zero in place of those whose sign says nothing of a row with one bound.
    fn telling(&self) -> Vec<f64> {
        let mut y = self.y.clone();
        let slacks = self.entries.iter().filter(|e| e.variable >= self.own);
        for &Entry { row, variable, .. } in slacks {
            // the reduced cost of a slack is the multiplier of its row
            let bound = if y[row] > 0.0 {
                self.lower[variable]
            } else {
                self.upper[variable]
            };
            if bound.is_infinite() {
                y[row] = 0.0;
            }
        }
        y
    }

    /// The value that no point falls below, by these multipliers.
    fn bound(&self, y: &[f64]) -> f64 {
        let mut reduced = self.cost.clone();
        for entry in &self.entries {
            reduced[entry.variable] -= entry.value * y[entry.row];
        }
        let rows: f64 = y.iter().zip(&self.right).map(|(y, b)| y * b).sum();
        let least = |i: usize| {
            let r = reduced[i];
            let at = if r > 0.0 {
                self.lower[i]
            } else {
                self.upper[i]
            };
            if r == 0.0 { 0.0 } else { r * at }
        };
        rows + (0..reduced.len()).map(least).sum::<f64>()
    }

    /// Multipliers of the rows of the program.
    fn in_program(&self, y: &[f64]) -> Vec<f64> {
        let multiplier = |&(row, scale): &(usize, f64)| self.cost_scale * y[row] / scale;
        let rows = self.rows.iter();
        rows.map(|row| row.as_ref().map_or(0.0, multiplier))
            .collect()
    }

    /// Average product of distances to bounds and their multipliers, after a step.
    fn average(&self, step: Option<(&Direction, f64, f64)>) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for i in (0..self.w.len()).filter(|&i| !self.is_fixed(i)) {
            let (mut w, mut below, mut above) = (self.w[i], self.z_lower[i], self.z_upper[i]);
            if let Some((d, primal, dual)) = step {
                w += primal * d.w[i];
                below += dual * d.z_lower[i];
                above += dual * d.z_upper[i];
            }
            for (distance, z) in [(w - self.lower[i], below), (self.upper[i] - w, above)] {
                if distance.is_finite() {
                    sum += distance * z;
                    count += 1.0;
                }
            }
        }
        if count > 0.0 { sum / count } else { 0.0 }
    }

    fn factorize(&mut self) -> bool {
        for i in 0..self.w.len() {
            let theta = if self.is_fixed(i) {
                1.0
            } else {
                let (below, above) = (self.w[i] - self.lower[i], self.upper[i] - self.w[i]);
                self.z_lower[i] / below + self.z_upper[i] / above
            };
            self.solver.add_to_diagonal(i, theta);
        }
        for k in 0..self.entries.len() {
            let Entry {
                variable,
                value,
                place,
                ..
            } = self.entries[k];
            let value = if self.is_fixed(variable) { 0.0 } else { value };
            self.solver.values_mut()[place] += value;
        }
        self.solver.factor(SHIFT, SHIFT).is_ok()
    }

    /// Newton direction to products `target`, less what the products of `before` add.
    fn direction(&mut self, target: f64, before: Option<&Direction>) -> Direction {
        let (n, m) = (self.w.len(), self.y.len());
        let mut right = vec![0.0; n + m];
        let mut solution = vec![0.0; n + m];
        let products = |i: usize| {
            before.map_or((0.0, 0.0), |d| {
                (d.w[i] * d.z_lower[i], -d.w[i] * d.z_upper[i])
            })
        };
        for i in (0..n).filter(|&i| !self.is_fixed(i)) {
            let (below, above) = (self.w[i] - self.lower[i], self.upper[i] - self.w[i]);
            let (lower, upper) = products(i);
            let mut r = -self.reduced[i];
            if below.is_finite() {
                r += (target - lower) / below;
            }
            if above.is_finite() {
                r -= (target - upper) / above;
            }
            right[i] = r;
        }
        right[n..].copy_from_slice(&self.violation);
        self.solver.solve(&right, &mut solution);
        let mut direction = Direction {
            y: solution[n..].iter().map(|v| -v).collect(),
            w: solution[..n].to_vec(),
            z_lower: vec![0.0; n],
            z_upper: vec![0.0; n],
        };
        for i in (0..n).filter(|&i| !self.is_fixed(i)) {
            let (below, above) = (self.w[i] - self.lower[i], self.upper[i] - self.w[i]);
            let (lower, upper) = products(i);
            let d = direction.w[i];
            if below.is_finite() {
                let z = self.z_lower[i];
                direction.z_lower[i] = (target - lower - z * d) / below - z;
            }
            if above.is_finite() {
                let z = self.z_upper[i];
                direction.z_upper[i] = (target - upper + z * d) / above - z;
            }
        }
        direction
    }

    /// Longest primal and dual steps.
    fn longest(&self, direction: &Direction) -> (f64, f64) {
        let (mut primal, mut dual) = (1.0_f64, 1.0_f64);
        let shorten = |step: &mut f64, room: f64, change: f64| {
            if change < 0.0 {
                *step = step.min(-FRACTION * room / change);
            }
        };
        for i in (0..self.w.len()).filter(|&i| !self.is_fixed(i)) {
            let d = direction.w[i];
            shorten(&mut primal, self.w[i] - self.lower[i], d);
            shorten(&mut primal, self.upper[i] - self.w[i], -d);
            shorten(&mut dual, self.z_lower[i], direction.z_lower[i]);
            shorten(&mut dual, self.z_upper[i], direction.z_upper[i]);
        }
        (primal, dual)
    }

    fn take(&mut self, d: &Direction, primal: f64, dual: f64) {
        let add = |to: &mut [f64], by: &[f64], step: f64| {
            to.iter_mut().zip(by).for_each(|(a, b)| *a += step * b);
        };
        add(&mut self.w, &d.w, primal);
        add(&mut self.y, &d.y, dual);
        add(&mut self.z_lower, &d.z_lower, dual);
        add(&mut self.z_upper, &d.z_upper, dual);
        self.stay_inside();
    }

    /// Keeps all that can move off its bounds: steps that end next to one are rounded.
    fn stay_inside(&mut self) {
        for (w, (&lower, &upper)) in self.w.iter_mut().zip(self.lower.iter().zip(&self.upper)) {
            if lower >= upper {
                continue;
            }
            let most = 0.25 * (upper - lower);
            let distance = |bound: f64| most.min(LEAST_DISTANCE * bound.abs().max(1.0));
            if lower.is_finite() {
                *w = w.max(lower + distance(lower));
            }
            if upper.is_finite() {
                *w = w.min(upper - distance(upper));
            }
        }
    }

    fn run(&mut self, limit: f64, watch: &mut Watch<'_>) -> Outcome {
        // no point within the bounds has a larger value
        let reach = |i: usize| {
            let c = self.cost[i];
            if c == 0.0 {
                0.0
            } else {
                c.abs() * self.lower[i].abs().max(self.upper[i].abs())
            }
        };
        let most = (0..self.own).map(reach).sum::<f64>() + 1e-6;
        let limit = (limit / self.cost_scale).min(most);
        self.start();
        let mut bound = f64::NEG_INFINITY;
        for iteration in 0..=MOST_ITERATIONS {
            self.evaluate();
            let y = self.telling();
            bound = bound.max(self.bound(&y));
            let value: f64 = self.cost.iter().zip(&self.w).map(|(c, w)| c * w).sum();
            let violation = norm_inf(&self.violation);
            let average = self.average(None);
            let info = IterationInfo {
                iteration,
                objective: self.cost_scale * value,
                primal_infeasibility: violation,
                complementarity: average,
                barrier_parameter: average,
                ..IterationInfo::default()
            };
            if iteration > 0 && !watch.certificate_iteration(&info) {
                return Outcome::Failed;
            }
            if bound >= limit {
                return Outcome::Above(self.in_program(&y));
            }
            let last = iteration == MOST_ITERATIONS || !average.is_finite();
            let enough = if last { ACCEPTABLE } else { TOLERANCE };
            // proximal terms leave a little of the rows, which large multipliers would make much of a gap between value and bound
            if violation.max(self.dual_error()).max(average) <= enough {
                let d = self.w[..self.own].to_vec();
                return Outcome::Solution(d, self.cost_scale * value, self.in_program(&y));
            }
            if last {
                break;
            }
            self.solver.values_mut().fill(0.0);
            if !self.factorize() {
                break;
            }
            let affine = self.direction(0.0, None);
            let (primal, dual) = self.longest(&affine);
            let rest = self.average(Some((&affine, primal, dual)));
            let centering = (rest / average).powi(3).clamp(1e-6, 1.0);
            let target = if average > 0.0 {
                centering * average
            } else {
                0.0
            };
            let direction = self.direction(target, Some(&affine));
            let (primal, dual) = self.longest(&direction);
            self.take(&direction, primal, dual);
        }
        Outcome::Failed
    }
}

#[cfg(test)]
mod tests {
    use super::super::Settings;
    use super::*;

    fn outcome(program: &LinearProgram, limit: f64) -> Outcome {
        let settings = Settings::default();
        let mut observer = |_: &IterationInfo| true;
        program.solve_below(limit, &mut Watch::new(&settings, &mut observer))
    }

    /// `min -x - 2 y` with `x + y <= 1`, the row `x - y = 0.2` given twice, and all within one of zero: `(0.6, 0.4)`, -1.4.
    fn dependent() -> LinearProgram {
        LinearProgram {
            gradient: vec![-1.0, -2.0],
            pattern: vec![(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)],
            values: vec![1.0, 1.0, 1.0, -1.0, -10.0, 10.0],
            row_lower: vec![f64::NEG_INFINITY, 0.2, -2.0],
            row_upper: vec![1.0, 0.2, -2.0],
            lower: vec![-1.0; 2],
            upper: vec![1.0; 2],
        }
    }

    #[test]
    fn solve_below_dependent_rows_finds_the_vertex() {
        let Outcome::Solution(d, value, _) = outcome(&dependent(), f64::INFINITY) else {
            panic!("there is a solution");
        };
        assert!(
            (d[0] - 0.6).abs() < 1e-8 && (d[1] - 0.4).abs() < 1e-8,
            "{d:?}"
        );
        assert!((value + 1.4).abs() < 1e-8);
    }

    #[test]
    fn solve_below_ends_where_the_bound_reaches_the_limit() {
        let Outcome::Above(y) = outcome(&dependent(), -1.5) else {
            panic!("the value is higher");
        };
        // the bound that they give: reduced costs times the better end, and rows
        let d = |k: usize, g: f64| -(g - y[0] - [1.0, -1.0][k] * (y[1] - 10.0 * y[2])).abs();
        let bound = d(0, -1.0) + d(1, -2.0) + y[0] + 0.2 * y[1] - 2.0 * y[2];
        assert!(y[0] <= 0.0 && bound >= -1.5, "{bound}");
        assert!(matches!(outcome(&dependent(), -1.3), Outcome::Solution(..)));
    }

    #[test]
    fn solve_below_without_a_point_is_above_any_limit() {
        let mut program = dependent();
        program.row_upper[2] = -1.0;
        program.row_lower[2] = -1.0;
        assert!(matches!(
            outcome(&program, f64::INFINITY),
            Outcome::Above(_)
        ));
    }

    #[test]
    fn stay_inside_leaves_room_that_does_not_round_away() {
        let mut program = dependent();
        (program.lower[0], program.upper[1]) = (-3.0, 1e-7);
        let mut method = Method::new(&program).expect("a matrix");
        // what a whole step to next to a bound rounds to
        method.w[..2].copy_from_slice(&[-3.0, 1e-7]);
        method.stay_inside();
        for i in 0..2 {
            let (below, above) = (method.w[i] - method.lower[i], method.upper[i] - method.w[i]);
            assert!(below > 0.0 && above > 0.0, "{:?}", &method.w[..2]);
        }
        assert!(method.w[0] < -3.0 + 1e-12 && method.w[1] > 1e-7 - 1e-12);
        // which the Newton matrix divides by
        method.z_lower.fill(1.0);
        method.z_upper.fill(1.0);
        assert!(method.factorize());
    }

    #[test]
    fn solve_below_fixed_variables_keep_their_values() {
        let mut program = dependent();
        (program.lower[0], program.upper[0]) = (0.5, 0.5);
        let Outcome::Solution(d, value, _) = outcome(&program, f64::INFINITY) else {
            panic!("there is a solution");
        };
        assert_eq!(d[0], 0.5);
        assert!(
            (d[1] - 0.3).abs() < 1e-8 && (value + 1.1).abs() < 1e-8,
            "{d:?}"
        );
    }
}
