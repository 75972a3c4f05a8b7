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

use crate::linalg::{KktFactorization as _, MultifrontalLdl, SymmetricPattern};
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
    /// Weakly active bounds leave both possible, or the point has no multipliers to ask.
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

/// Curvature that counts as none, relative to the entries of the Hessian in the same row: points are accurate to about the square root of
/// the tolerance, 1e-4, where curvature vanishes.
const FLAT: f64 = 1e-4;
/// Curvature that counts as none, relative to the largest entry of all: a hundred thousand roundings of a factorization.
const ROUNDING: f64 = 1e-11;
/// Part of the gradient of the objective that a multiplier has to reach to be away from zero, and distance of a bound, relative to
/// the variable, to be away.
const AWAY: f64 = 1e-4;
/// Softness of the rows, relative to the squares of their derivatives over the Hessian, which lets them depend on each other.
const SOFT: f64 = 1e-9;

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

/// Word of a bound with distances to both ends and its multiplier; `size` is that of the value, `unit` of multipliers.
fn held((below, above): (f64, f64), multiplier: f64, size: f64, unit: f64) -> Held {
    if below <= 0.0 && above <= 0.0 || multiplier.abs() > AWAY * unit {
        Held::Yes
    } else if below.min(above) > AWAY * size {
        Held::No
    } else {
        Held::Weakly
    }
}

/// What second derivatives say of a point whose first-order conditions hold with its multipliers.
pub(super) fn second_order(problem: &mut dyn NlpProblem, point: &Stationary<'_>) -> SecondOrder {
    let system = System::new(problem, point);
    let ask = |weak, sign| system.is_positive(weak, sign);
    match (ask(false, -1.0), ask(true, 1.0)) {
        (Some(true), _) => SecondOrder::Sufficient,
        (_, Some(false)) => SecondOrder::Descends,
        (Some(false), Some(true)) if !system.has_weak() => SecondOrder::Necessary,
        _ => SecondOrder::Undecided,
    }
}

/// Hessian and active rows at a point.
struct System {
    hessian: Vec<((usize, usize), f64)>,
    jacobian: Vec<((usize, usize), f64)>,
    variables: Vec<Held>,
    rows: Vec<Held>,
    /// Curvature of each variable that counts as none.
    flat: Vec<f64>,
    largest: f64,
}

impl System {
    fn new(problem: &mut dyn NlpProblem, point: &Stationary<'_>) -> Self {
        let (n, m) = (problem.variables(), problem.constraints());
        let mut values = vec![0.0; problem.hessian_pattern().len()];
        problem.hessian_values(point.x, 1.0, point.multipliers, &mut values);
        let hessian: Vec<_> = problem.hessian_pattern().into_iter().zip(values).collect();
        let mut values = vec![0.0; problem.jacobian_pattern().len()];
        problem.jacobian_values(point.x, &mut values);
        let jacobian: Vec<_> = problem.jacobian_pattern().into_iter().zip(values).collect();
        let mut gradient = vec![0.0; n];
        problem.gradient(point.x, &mut gradient);
        let unit = gradient.iter().fold(0.0, |a: f64, g| a.max(g.abs()));
        let (mut flat, mut largest) = (vec![0.0_f64; n], 0.0_f64);
        for &((i, j), h) in &hessian {
            largest = largest.max(h.abs());
            for k in [i, j] {
                flat[k] = flat[k].max(FLAT * h.abs());
            }
        }
        for flat in &mut flat {
            // where nothing is curved, any shift tells flat from held
            *flat = flat.max(if largest > 0.0 {
                ROUNDING * largest
            } else {
                1.0
            });
        }
        Self {
            rows: rows(problem, point, &jacobian, (m, unit)),
            variables: variables(problem, point, unit),
            hessian,
            jacobian,
            flat,
            largest,
        }
    }

    fn has_weak(&self) -> bool {
        self.rows
            .iter()
            .chain(&self.variables)
            .any(|held| *held == Held::Weakly)
    }

    /// Whether the Hessian with `sign` times what counts as none is positive where rows and variables are held, those that are
    /// weakly active too if `weak`; `None` where there are no factors.
    fn is_positive(&self, weak: bool, sign: f64) -> Option<bool> {
        let is_held = |held: Held| held == Held::Yes || weak && held == Held::Weakly;
        let mut free = vec![None; self.variables.len()];
        let mut n = 0;
        for (place, _) in free
            .iter_mut()
            .zip(&self.variables)
            .filter(|(_, held)| !is_held(**held))
        {
            *place = Some(n);
            n += 1;
        }
        if n == 0 {
            return Some(true);
        }
        let mut active = vec![None; self.rows.len()];
        let mut m = 0;
        for (place, _) in active
            .iter_mut()
            .zip(&self.rows)
            .filter(|(_, held)| is_held(**held))
        {
            *place = Some(n + m);
            m += 1;
        }
        let second = self
            .hessian
            .iter()
            .filter_map(|&((i, j), h)| Some(((free[i]?, free[j]?), h)));
        let first = self
            .jacobian
            .iter()
            .filter_map(|&((i, j), a)| Some(((active[i]?, free[j]?), a)));
        let shifts = free.iter().zip(&self.flat);
        let shifts = shifts.filter_map(|(i, flat)| Some((((*i)?, (*i)?), sign * flat)));
        let mut soft = vec![0.0_f64; m];
        for ((row, _), a) in first.clone() {
            soft[row - n] = soft[row - n].max(a * a);
        }
        let scale = if self.largest > 0.0 {
            self.largest
        } else {
            1.0
        };
        let soft = soft.iter().enumerate();
        let soft = soft.map(|(row, square)| {
            (
                (n + row, n + row),
                -SOFT * square.max(f64::MIN_POSITIVE) / scale,
            )
        });
        let entries: Vec<_> = second.chain(first).chain(shifts).chain(soft).collect();
        let places = entries.iter().map(|entry| entry.0);
        let (pattern, map) = SymmetricPattern::with_map(n + m, places)?;
        let mut values = vec![0.0; pattern.stored()];
        for (&place, (_, value)) in map.iter().zip(&entries) {
            values[place as usize] += value;
        }
        let mut factors = MultifrontalLdl::new(&pattern, n).ok()?;
        let inertia = factors.factor(&values, 0.0, 0.0).ok()?;
        Some(inertia.positive == n)
    }
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
