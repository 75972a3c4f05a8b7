//! What the second derivatives say of a stationary point.
//!
//! On the critical cone, the directions that stay feasible and keep the objective to first order, the Hessian of the Lagrangian has to be
//! positive for the point to be a minimum. Where every multiplier is either well away from zero or zero at a bound that is well
//! away, the cone is a space. Elsewhere it lies between two spaces, with weakly active bounds held and let go. On a space
//! `A d = 0` the sign of `d' H d` is read from the inertia of
//!
//! ```text
//!     [ H + shift   A'      ]
//!     [ A          -delta I ]      n positive eigenvalues: d' (H + shift) d > 0   (Gould, Mathematical Programming 32, 1985)
//! ```
//!
//! The point is near a stationary one only. What is said of its curvature has to hold there too: more than half of it has to be left at
//! twice the Newton step from the point. At an inflection such as that of `x^3` curvature and distance vanish together.

use crate::linalg::{RefinedSolver, SymmetricPattern};
use crate::nlp::NlpProblem;

/// What is known of a stationary point by second derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SecondOrder {
    /// The curvature of the Lagrangian is positive on the critical cone: a strict local minimum (maximum of what is maximized).
    Sufficient,
    /// It is not negative, but vanishes along a direction: a minimum, one of many, or an inflection.
    Necessary,
    /// It is negative along a direction: the objective descends, and the point is none of its minima.
    Descends,
    /// Weakly active bounds leave both possible, the point has no multipliers to ask, or the curvature is no more than what the distance to
    /// the stationary point explains.
    Undecided,
}

impl SecondOrder {
    /// Name used in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sufficient => "sufficient",
            Self::Necessary => "necessary",
            Self::Descends => "descends",
            Self::Undecided => "undecided",
        }
    }

    /// What it means, in words.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Sufficient => "a strict local optimum",
            Self::Necessary => "flat along a direction: an optimum, one of many, or an inflection",
            Self::Descends => {
                "the objective improves along a curve from here: not an optimum; try another start"
            }
            Self::Undecided => "not decided by second derivatives",
        }
    }
}

/// Curvature that counts as none, relative to the entries of the Hessian in the same row: of a positive one what rounding leaves of sums of
/// products, as Newton's method says whether it is left at the stationary point; of a negative one what multipliers of 1e-4 may be
/// wrong by.
const STRICT: f64 = 1e-8;
const FLAT: f64 = 1e-4;
/// Curvature that counts as none, relative to the largest entry of all: a hundred thousand roundings of a factorization.
const ROUNDING: f64 = 1e-11;
/// Part of the gradient of the objective that a multiplier has to reach to be away from zero, and distance of a bound, relative to
/// the variable, to be away.
const AWAY: f64 = 1e-4;
/// Least unit of multipliers, relative to the largest curvature: smaller ones are what the barrier leaves of bounds that are away.
const LEAST_UNIT: f64 = 1e-4;
/// Softness of the rows, relative to the squares of their derivatives over the Hessian, which lets them depend on each other.
const SOFT: f64 = 1e-9;
/// The same where a step is asked for: rows that depend on each other and contradict each other by a residual of 1e-9 then change multipliers by
/// a thousandth.
const STEP_SOFT: f64 = 1e-6;
/// Rounding of the gradient, relative to its largest entry: a hundred roundings of one term.
const STEP_ROUNDING: f64 = 1e-14;
/// Most of Newton's steps from the end of a run to a point where curvature can be told.
const STEPS: usize = 4;
/// Longest of these, relative to the variable: farther away another stationary point may be meant.
const STEP: f64 = 1e-2;
/// Multiples of it fill the interval from 0 to 1 evenly.
const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;

/// A stationary point with its multipliers, in the variables of the program.
pub(super) struct Stationary<'a> {
    pub(super) x: &'a [f64],
    pub(super) multipliers: &'a [f64],
    pub(super) lower: &'a [f64],
    pub(super) upper: &'a [f64],
    /// Pairs of variables of which one is zero.
    pub(super) pairs: &'a [(usize, usize)],
}

/// Whether a bound, row or variable is part of the critical cone's equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Held {
    Yes,
    No,
    Weakly,
}

/// Word of a bound with distances to both ends and its multiplier; `size` is that of the value, `unit` of multipliers. Both are away from
/// zero only where the unit is next to nothing.
fn held((below, above): (f64, f64), multiplier: f64, size: f64, unit: f64) -> Held {
    let pushes = multiplier.abs() > AWAY * unit;
    let is_far = below.min(above) > AWAY * size;
    match (pushes, is_far) {
        _ if below <= 0.0 && above <= 0.0 => Held::Yes,
        (true, false) => Held::Yes,
        (false, true) => Held::No,
        _ => Held::Weakly,
    }
}

/// What second derivatives say of a point whose first-order conditions hold with its multipliers.
pub(super) fn second_order(problem: &mut dyn NlpProblem, point: &Stationary<'_>) -> SecondOrder {
    let system = System::new(problem, point);
    let [open, closed] = [false, true].map(|weak| system.space(weak));
    let strict = system.is_positive(&open, true);
    let (semi, has_weak) = (system.is_positive(&closed, false), system.has_weak());
    let (word, space, part) = match (strict, semi) {
        (Some(true), _) => (SecondOrder::Sufficient, open, 0.5),
        (Some(false), Some(false)) => (SecondOrder::Descends, closed, 0.0),
        (Some(false), Some(true)) if !has_weak => return SecondOrder::Necessary,
        _ => return SecondOrder::Undecided,
    };
    if system.stays(problem, point, &space, part) {
        word
    } else {
        SecondOrder::Undecided
    }
}

/// Entries of a matrix with their places.
type Entries = Vec<((usize, usize), f64)>;

/// Hessian and active rows at a point.
struct System {
    hessian: Entries,
    jacobian: Entries,
    variables: Vec<Held>,
    rows: Vec<Held>,
    /// Largest entry of the Hessian of each variable.
    sizes: Vec<f64>,
    largest: f64,
    /// Largest entry of the gradient of the objective, or the least unit.
    unit: f64,
}

/// The equations of a space of directions: the variables that are free in it and the rows that hold, with their numbers.
struct Space {
    free: Vec<Option<usize>>,
    active: Vec<Option<usize>>,
    n: usize,
    m: usize,
}

impl Space {
    /// The entries of a Hessian in this space.
    fn of_hessian(&self, hessian: &Entries, factor: f64) -> Entries {
        let own = |&((i, j), h): &((usize, usize), f64)| {
            Some(((self.free[i]?, self.free[j]?), factor * h))
        };
        hessian.iter().filter_map(own).collect()
    }

    /// The entries of the rows that hold.
    fn of_rows(&self, jacobian: &Entries) -> Entries {
        let own =
            |&((i, j), a): &((usize, usize), f64)| Some(((self.active[i]?, self.free[j]?), a));
        jacobian.iter().filter_map(own).collect()
    }

    /// Factors of the matrix with these entries and rows, soft by so much, and whether its first part is positive on the space of the rows.
    fn factors(
        &self,
        mut entries: Entries,
        rows: Entries,
        softness: f64,
    ) -> Option<(RefinedSolver, bool)> {
        let mut soft = vec![f64::MIN_POSITIVE; self.m];
        for ((row, _), a) in &rows {
            soft[row - self.n] = soft[row - self.n].max(a * a);
        }
        entries.extend(rows);
        let soft = soft.iter().enumerate();
        entries.extend(soft.map(|(k, square)| ((self.n + k, self.n + k), -softness * square)));
        if entries.iter().any(|(_, value)| !value.is_finite()) {
            return None;
        }
        let places = entries.iter().map(|entry| entry.0);
        let (pattern, map) = SymmetricPattern::with_map(self.n + self.m, places)?;
        let mut solver = RefinedSolver::new(pattern, self.n).ok()?;
        for (&place, (_, value)) in map.iter().zip(&entries) {
            solver.values_mut()[place as usize] += value;
        }
        let inertia = solver.factor(0.0, 0.0).ok()?;
        Some((solver, inertia.positive == self.n))
    }
}

impl System {
    fn new(problem: &mut dyn NlpProblem, point: &Stationary<'_>) -> Self {
        let (n, m) = (problem.variables(), problem.constraints());
        let (hessian, jacobian) = derivatives(problem, point.x, point.multipliers);
        let mut gradient = vec![0.0; n];
        problem.gradient(point.x, &mut gradient);
        let (mut sizes, mut largest) = (vec![0.0_f64; n], 0.0_f64);
        for &((i, j), h) in &hessian {
            largest = largest.max(h.abs());
            for k in [i, j] {
                sizes[k] = sizes[k].max(h.abs());
            }
        }
        let unit = gradient
            .iter()
            .fold(LEAST_UNIT * largest, |a, g| a.max(g.abs()));
        Self {
            rows: rows(problem, point, &jacobian, (m, unit)),
            variables: variables(problem, point, unit),
            hessian,
            jacobian,
            sizes,
            largest: if largest > 0.0 { largest } else { 1.0 },
            unit,
        }
    }

    fn has_weak(&self) -> bool {
        self.rows
            .iter()
            .chain(&self.variables)
            .any(|held| *held == Held::Weakly)
    }

    /// The space of directions in which rows and variables are held, those that are weakly active too if `weak`.
    fn space(&self, weak: bool) -> Space {
        let is_held = |held: &Held| *held == Held::Yes || weak && *held == Held::Weakly;
        let mut count = 0;
        let mut number = |is_in: bool| {
            count += usize::from(is_in);
            is_in.then(|| count - 1)
        };
        let free: Vec<_> = self.variables.iter().map(|v| number(!is_held(v))).collect();
        let active: Vec<_> = self.rows.iter().map(|row| number(is_held(row))).collect();
        let n = free.iter().flatten().count();
        Space {
            n,
            m: count - n,
            free,
            active,
        }
    }

    /// What counts as no curvature of each variable of a space, taken off where more than that is asked for, else added.
    fn none(&self, space: &Space, is_strict: bool) -> Entries {
        let factor = if is_strict { -STRICT } else { FLAT };
        let sizes = space.free.iter().zip(&self.sizes);
        let none = sizes.filter_map(|(place, size)| {
            let size = size.max(ROUNDING / factor.abs() * self.largest);
            Some((((*place)?, (*place)?), factor * size))
        });
        none.collect()
    }

    /// Whether the curvature in a space is more than none, or else at least that; `None` where there are no factors.
    fn is_positive(&self, space: &Space, is_strict: bool) -> Option<bool> {
        if space.n == 0 {
            return Some(true);
        }
        let mut entries = space.of_hessian(&self.hessian, 1.0);
        entries.extend(self.none(space, is_strict));
        let rows = space.of_rows(&self.jacobian);
        let (_, is_positive) = space.factors(entries, rows, SOFT / self.largest)?;
        Some(is_positive)
    }

    /// Whether what the Hessian says in a space holds at the stationary point: after a few of Newton's steps it holds wherever that point may
    /// be, within twice the next step and what rounding may add to it. More than `part` of the curvature is left there, or with 0 it is not
    /// positive. At an inflection nothing is left: Newton's method halves the distance to that of `x^3`, so that curvature and distance
    /// vanish together (the condition of Kantorovich, by which there is a regular stationary point within twice the step).
    fn stays(
        mut self,
        problem: &mut dyn NlpProblem,
        point: &Stationary<'_>,
        space: &Space,
        part: f64,
    ) -> bool {
        let (mut x, mut y) = (point.x.to_vec(), point.multipliers.to_vec());
        for _ in 0..STEPS {
            let point = Stationary {
                x: &x,
                multipliers: &y,
                ..*point
            };
            if space.n == 0 || self.stays_near(problem, &point, space, part) == Some(true) {
                return true;
            }
            let Some((next, multipliers)) = self.beyond(problem, &point, space, (1.0, 0.0)) else {
                return false;
            };
            let mut all = next.iter().zip(&x);
            if !all.all(|(next, x)| (next - x).abs() <= STEP * x.abs().max(1.0)) {
                return false;
            }
            (x, y) = (next, multipliers);
            (self.hessian, self.jacobian) = derivatives(problem, &x, &y);
        }
        false
    }

    /// Whether it holds near this point.
    fn stays_near(
        &self,
        problem: &mut dyn NlpProblem,
        point: &Stationary<'_>,
        space: &Space,
        part: f64,
    ) -> Option<bool> {
        let is_strict = part > 0.0;
        if self.is_positive(space, is_strict)? != is_strict {
            return Some(false);
        }
        for rounding in [-1.0, 1.0] {
            let (x, y) = self.beyond(problem, point, space, (2.0, rounding))?;
            let (hessian, jacobian) = derivatives(problem, &x, &y);
            let mut entries = space.of_hessian(&hessian, 1.0);
            entries.extend(space.of_hessian(&self.hessian, -part));
            let shift = if is_strict { part } else { 1.0 };
            let none = self.none(space, is_strict).into_iter();
            entries.extend(none.map(|(place, flat)| (place, shift * flat)));
            let rows = space.of_rows(&jacobian);
            let (_, is_positive) = space.factors(entries, rows, SOFT / self.largest)?;
            if is_positive != is_strict {
                return Some(false);
            }
        }
        Some(true)
    }

    /// The point and the multipliers of the rows some times as far as Newton's method goes, with what is held on its bound, and with a multiple
    /// of what rounding may be in the gradient. Multipliers of what is let go are what the barrier leaves of them, and none at its end.
    fn beyond(
        &self,
        problem: &mut dyn NlpProblem,
        point: &Stationary<'_>,
        space: &Space,
        (times, rounding): (f64, f64),
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let (n, m) = (self.variables.len(), self.rows.len());
        let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
        problem.variable_bounds(&mut lower, &mut upper);
        let (mut x, mut y) = (point.x.to_vec(), point.multipliers.to_vec());
        let mut z: Vec<f64> = (0..n).map(|i| point.lower[i] - point.upper[i]).collect();
        for i in 0..n {
            if space.free[i].is_none() {
                x[i] = bound((lower[i], upper[i]), z[i], x[i]);
            } else {
                z[i] = 0.0;
            }
        }
        for (y, place) in y.iter_mut().zip(&space.active) {
            if place.is_none() {
                *y = 0.0;
            }
        }
        let mut left = vec![0.0; n];
        problem.gradient(&x, &mut left);
        let (_, jacobian) = derivatives(problem, &x, &y);
        for &((row, i), a) in &jacobian {
            left[i] += a * y[row];
        }
        let mut right = vec![0.0; space.n + space.m];
        for (i, place) in space.free.iter().enumerate() {
            let Some(place) = *place else { continue };
            // some part of it along any direction
            let share = 0.5 + 0.5 * (i as f64 * GOLDEN_RATIO).fract();
            right[place] = z[i] - left[i] + rounding * share * STEP_ROUNDING * self.unit;
        }
        let (mut c, mut below, mut above) = (vec![0.0; m], vec![0.0; m], vec![0.0; m]);
        problem.constraint_values(&x, &mut c);
        problem.constraint_bounds(&mut below, &mut above);
        for (row, place) in space.active.iter().enumerate() {
            let Some(place) = *place else { continue };
            right[place] = bound((below[row], above[row]), -y[row], c[row]) - c[row];
        }
        let entries = space.of_hessian(&self.hessian, 1.0);
        let rows = space.of_rows(&self.jacobian);
        let (mut solver, _) = space.factors(entries, rows, STEP_SOFT / self.largest)?;
        let mut step = vec![0.0; right.len()];
        solver.solve(&right, &mut step);
        for (i, place) in space.free.iter().enumerate() {
            if let Some(place) = *place {
                x[i] = (x[i] + times * step[place]).max(lower[i]).min(upper[i]);
            }
        }
        for (y, place) in y.iter_mut().zip(&space.active) {
            *y += place.map_or(0.0, |place| times * step[place]);
        }
        Some((x, y))
    }
}

/// The bound that a value is held at: where the multiplier `z` pushes from, the nearer one where it does not push.
fn bound((lower, upper): (f64, f64), z: f64, value: f64) -> f64 {
    let at_lower = if z != 0.0 {
        z > 0.0
    } else {
        value - lower <= upper - value
    };
    let bound = if at_lower { lower } else { upper };
    if bound.is_finite() { bound } else { value }
}

/// Hessian of the Lagrangian and derivatives of the rows.
fn derivatives(problem: &mut dyn NlpProblem, x: &[f64], y: &[f64]) -> (Entries, Entries) {
    let mut values = vec![0.0; problem.hessian_pattern().len()];
    problem.hessian_values(x, 1.0, y, &mut values);
    let hessian = problem.hessian_pattern().into_iter().zip(values).collect();
    let mut values = vec![0.0; problem.jacobian_pattern().len()];
    problem.jacobian_values(x, &mut values);
    let jacobian = problem.jacobian_pattern().into_iter().zip(values).collect();
    (hessian, jacobian)
}

/// Which variables are held. Of a pair without multipliers of its own one side is zero, and of one that is not biactive always.
fn variables(problem: &dyn NlpProblem, point: &Stationary<'_>, unit: f64) -> Vec<Held> {
    let n = point.x.len();
    let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
    problem.variable_bounds(&mut lower, &mut upper);
    let word = |i: usize| {
        let x = point.x[i];
        let multiplier = point.lower[i] - point.upper[i];
        held(
            (x - lower[i], upper[i] - x),
            multiplier,
            x.abs().max(1.0),
            unit,
        )
    };
    let mut variables: Vec<Held> = (0..n).map(word).collect();
    for &(i, j) in point.pairs {
        let (small, large) = if point.x[i] <= point.x[j] {
            (i, j)
        } else {
            (j, i)
        };
        if point.x[large] > AWAY * point.x[large].abs().max(1.0) {
            variables[small] = Held::Yes;
        }
    }
    variables
}

/// Which rows are held, each measured by its largest derivative.
fn rows(
    problem: &mut dyn NlpProblem,
    point: &Stationary<'_>,
    jacobian: &[((usize, usize), f64)],
    (m, unit): (usize, f64),
) -> Vec<Held> {
    let mut c = vec![0.0; m];
    problem.constraint_values(point.x, &mut c);
    let (mut lower, mut upper) = (vec![0.0; m], vec![0.0; m]);
    problem.constraint_bounds(&mut lower, &mut upper);
    // largest derivative, and the largest term of the row
    let mut sizes = vec![(0.0_f64, 0.0_f64); m];
    for &((row, column), a) in jacobian {
        let (slope, term) = sizes[row];
        let next = a.abs() * point.x[column].abs().max(1.0);
        sizes[row] = (slope.max(a.abs()), term.max(next));
    }
    let word = |row: usize| {
        if lower[row] == upper[row] {
            return Held::Yes;
        }
        let (slope, term) = sizes[row];
        let room = (c[row] - lower[row], upper[row] - c[row]);
        held(room, slope * point.multipliers[row], term, unit)
    };
    (0..m).map(word).collect()
}
