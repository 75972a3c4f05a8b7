//! What kind of stationary point a feasible point is.

use super::Mpcc;
use super::branch_and_cut::{End, NONE, PairedProgram};
use super::linear_program::{LinearProgram, Outcome};
use super::parts::{Part, let_go, of_part, parts};
use super::watch::Watch;
use crate::linalg::norms::norm_inf;
use crate::nlp::{self, Astray, Cone, OFF_CONE};

/// Kinds of stationary points, from the multipliers `nu_i`, `nu_j` of biactive pairs
/// (`x_i = x_j = 0`); each kind implies those below it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum StationarityType {
    /// Multipliers exist; those of biactive pairs may have any signs. A descent direction may exist.
    Weak,
    /// Clarke: `nu_i nu_j >= 0`.
    Clarke,
    /// Mordukhovich: both positive, or one of them zero.
    Mordukhovich,
    /// Strong: both `>= 0`; the optimality conditions of the relaxed nonlinear program hold.
    Strong,
}

/// What is known of a point. Strong stationarity, or a point without biactive pairs, implies
/// B-stationarity: no feasible first-order descent.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Certificate {
    /// Kind of the point by the signs of its multipliers.
    pub stationarity: StationarityType,
    /// `Some(true)`: proved to be without feasible descent to first order; `Some(false)`: `descent` is a
    /// feasible descent direction; `None`: not decided within the limit of linear programs, or because it hangs on a pair of
    /// which it could not be decided whether both sides vanish.
    pub b_stationary: Option<bool>,
    /// Indices of the biactive pairs, among them those whose sides may both vanish to the accuracy of the point.
    pub biactive: Vec<usize>,
    /// A descent direction, length `n`, `|d|_inf <= 1`, if one was found.
    pub descent: Option<Vec<f64>>,
    /// Linear programs solved.
    pub programs: usize,
}

/// Rate of descent `grad f'd` for `|d|_inf <= 1` that still counts as none, relative to the sizes of the terms: points
/// are accurate to about 1e-8.
const NO_DESCENT: f64 = 1e-6;

/// Part of a gradient beyond which rates of descent are compared with it: the accuracy of the linear programs.
const GRADIENT: f64 = 1e-2;

/// Gradient of the Lagrangian from which on the multipliers of a point are too rough for a certificate.
pub(crate) const ROUGH: f64 = 1e-6;

/// Most linear programs of a part of a certificate.
const MOST_PROGRAMS: usize = 200;

/// Part of a direction that a row has to leave at least to be let go: it only shortens steps then.
const FAR: f64 = 1e-2;

/// Sign of the multipliers of one biactive pair, each with its tolerance.
fn classify_pair(nu: [f64; 2], tolerance: [f64; 2]) -> StationarityType {
    let [i, j] = [0, 1].map(|k| nu[k] / tolerance[k]);
    if i >= -1.0 && j >= -1.0 {
        StationarityType::Strong
    } else if i.abs() <= 1.0 || j.abs() <= 1.0 {
        StationarityType::Mordukhovich
    } else if i * j > 0.0 {
        StationarityType::Clarke
    } else {
        StationarityType::Weak
    }
}

/// Multipliers that balance the gradient of the Lagrangian and hold nothing, as [`Cone`] tells them, if it is not balanced without them;
/// `rows` are the values of the rows and their bounds.
fn astray(
    point: &nlp::Solution,
    gradient: &[f64],
    (c, (row_lower, row_upper)): (&[f64], &(Vec<f64>, Vec<f64>)),
    entries: impl Iterator<Item = ((usize, usize), f64)> + Clone,
) -> Option<Astray> {
    let mut lagrangian = gradient.to_vec();
    for ((row, column), a) in entries.clone() {
        lagrangian[column] += a * point.multipliers[row];
    }
    let bounds = point.multipliers_lower.iter().zip(&point.multipliers_upper);
    for (entry, (below, above)) in lagrangian.iter_mut().zip(bounds) {
        *entry -= below - above;
    }
    let distance = |(row, &y): (usize, &f64)| {
        let (below, above) = (c[row] - row_lower[row], row_upper[row] - c[row]);
        if row_lower[row] == row_upper[row] {
            0.0
        } else if y > 0.0 {
            above
        } else {
            below
        }
    };
    let distances: Vec<f64> = point.multipliers.iter().enumerate().map(distance).collect();
    let size = norm_inf(gradient).max(1.0);
    let cone = Cone {
        x: &point.x,
        lagrangian: &lagrangian,
        y: &point.multipliers,
        distances: &distances,
        none: OFF_CONE * size,
    };
    let astray = cone.astray(entries.clone())?;
    (cone.left_without(&astray, entries) > OFF_CONE * size).then_some(astray)
}

/// The derivatives of a problem at a point, and the pairs that count as biactive there.
pub(crate) struct Certifier<'a> {
    point: &'a nlp::Solution,
    /// Whether the multipliers of the point are too rough for their signs to count.
    is_rough: bool,
    pairs: &'a [(usize, usize)],
    gradient: Vec<f64>,
    /// Rate of descent of the linear programs that counts as none.
    least: f64,
    /// What counts as zero of the multiplier of each variable.
    tolerance: Vec<f64>,
    pattern: Vec<(usize, usize)>,
    values: Vec<f64>,
    /// Unit in which each variable moves: its own size where it measures a row of huge value, else 1. Derivatives are in these units.
    sizes: Vec<f64>,
    /// Distances to the bounds of rows and variables, in units of the radius of the linear programs.
    row_lower: Vec<f64>,
    row_upper: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl<'a> Certifier<'a> {
    /// Derivatives at `point`, whose multipliers of lower bounds are those of the complementarity problem. The linear
    /// programs look for descent within `radius`.
    pub(crate) fn new(
        problem: &mut dyn Mpcc,
        pairs: &'a [(usize, usize)],
        point: &'a nlp::Solution,
        radius: f64,
    ) -> Self {
        let x = &point.x;
        let (n, m) = (x.len(), problem.constraints());
        let mut gradient = vec![0.0; n];
        problem.gradient(x, &mut gradient);
        let pattern = problem.jacobian_pattern();
        let mut values = vec![0.0; pattern.len()];
        problem.jacobian_values(x, &mut values);
        let mut c = vec![0.0; m];
        problem.constraint_values(x, &mut c);
        let mut rows = (vec![0.0; m], vec![0.0; m]);
        problem.constraint_bounds(&mut rows.0, &mut rows.1);
        // a multiplier is a sum of these terms
        let mut tolerance: Vec<f64> = gradient.iter().map(|g| g.abs()).collect();
        for (&(row, column), value) in pattern.iter().zip(&values) {
            tolerance[column] += (value * point.multipliers[row]).abs();
        }
        for tolerance in &mut tolerance {
            *tolerance = NO_DESCENT * tolerance.max(1.0);
        }
        let largest = norm_inf(&gradient);
        let mut sizes = vec![1.0; n];
        let entries = pattern.iter().copied().zip(values.iter().copied());
        let astray = astray(point, &gradient, (&c, &rows), entries);
        if let Some(astray) = &astray {
            for &i in &astray.variables {
                sizes[i] = x[i].abs();
            }
        }
        for (gradient, size) in gradient.iter_mut().zip(&sizes) {
            *gradient *= size;
        }
        let mut reach = vec![0.0; m];
        for (&(row, column), value) in pattern.iter().zip(&mut values) {
            *value *= sizes[column];
            reach[row] += value.abs();
        }
        let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
        problem.variable_bounds(&mut lower, &mut upper);
        for i in 0..n {
            (lower[i], upper[i]) = room(x[i], (lower[i], upper[i]), radius * sizes[i]);
            lower[i] = lower[i].max(-1.0);
            upper[i] = upper[i].min(1.0);
        }
        let (mut row_lower, mut row_upper) = rows;
        for row in 0..m {
            let (below, above) = room(c[row], (row_lower[row], row_upper[row]), radius);
            // what no direction reaches is no constraint
            let reached = |room: f64, none: f64| if room.abs() > reach[row] { none } else { room };
            row_lower[row] = reached(below, f64::NEG_INFINITY);
            row_upper[row] = reached(above, f64::INFINITY);
        }
        Self {
            least: NO_DESCENT * (GRADIENT * largest).max(1.0),
            is_rough: point.residuals.dual > ROUGH || astray.is_some(),
            point,
            pairs,
            gradient,
            tolerance,
            pattern,
            values,
            sizes,
            row_lower,
            row_upper,
            lower,
            upper,
        }
    }

    /// Kind of one pair by the signs of its multipliers.
    pub(crate) fn classify(&self, pair: usize) -> StationarityType {
        let (i, j) = self.pairs[pair];
        let nu = &self.point.multipliers_lower;
        classify_pair([nu[i], nu[j]], [self.tolerance[i], self.tolerance[j]])
    }

    /// Whether a direction from the point moves variable `i` off zero.
    pub(crate) fn moves(&self, i: usize, direction: &[f64]) -> bool {
        direction[i] - self.lower[i] > NONE
    }

    /// Whether variable `i`, which is fixed at zero but belongs to no pair, can stay there: it has a multiplier of the right sign,
    /// or no room.
    fn stays(&self, i: usize) -> bool {
        let nu = self.point.multipliers_lower[i] - self.point.multipliers_upper[i];
        nu >= -self.tolerance[i] || self.upper[i] <= 0.0
    }

    /// Certificate of the point if the pairs `biactive` are those whose sides both vanish; of the others the smaller side
    /// vanishes. The variables `forced` are fixed at zero besides, by linear rows with vanishing sides: their multipliers count as
    /// well, but are one choice of many, so that a wrong sign says nothing until a linear program does.
    pub(crate) fn certify(
        &self,
        biactive: Vec<usize>,
        forced: &[usize],
        watch: &mut Watch<'_>,
    ) -> Certificate {
        let kinds = biactive.iter().map(|&k| self.classify(k));
        let stationarity = kinds.min().unwrap_or(StationarityType::Strong);
        let mut certificate = Certificate {
            stationarity,
            b_stationary: Some(true),
            biactive,
            descent: None,
            programs: 0,
        };
        let stay = forced.iter().all(|&i| self.stays(i));
        if stationarity != StationarityType::Strong || !stay || self.is_rough {
            self.search_descent(&mut certificate, watch);
            // the first program leaves the pairs out: without descent there, multipliers of the right signs exist
            let relaxed = certificate.b_stationary == Some(true) && certificate.programs == 1;
            if self.is_rough || !stay {
                certificate.stationarity = match relaxed {
                    true if self.is_rough => StationarityType::Strong,
                    true => stationarity,
                    false => StationarityType::Weak,
                };
            }
        }
        certificate
    }

    /// Looks for a feasible descent direction: `d` solves
    ///
    /// ```text
    ///     min grad f'd  s.t.  c_l <= c + r J d <= c_u,  x_l <= x + r d <= x_u,  0 <= x_i + r d_i  _|_  x_j + r d_j >= 0,  |d|_inf <= 1
    /// ```
    ///
    /// with the radius `r` and the pairs that count as biactive, by branch and bound over their sides, part by part. Bounds count with their
    /// distances, so that none has to be called active or not; but for rows that leave a good part of any such direction.
    fn search_descent(&self, certificate: &mut Certificate, watch: &mut Watch<'_>) {
        let mut program = self.linear_program(&certificate.biactive);
        let let_go = let_go(&mut program, FAR);
        certificate.programs = 1;
        let d = match program.solve_below(-self.least, watch) {
            Outcome::Solution(d, value, _) if value < -self.least => d,
            Outcome::Failed => {
                certificate.b_stationary = None;
                return;
            }
            _ => return,
        };
        let mut direction = vec![0.0; d.len()];
        let pairs = certificate.biactive.iter().map(|&k| self.pairs[k]);
        for part in parts(&program, &pairs.collect::<Vec<_>>()) {
            let own: Vec<f64> = part.variables.iter().map(|&i| d[i]).collect();
            let share: f64 = part
                .variables
                .iter()
                .map(|&i| self.gradient[i] * d[i])
                .sum();
            if share >= -self.least {
                continue;
            }
            match self.search_part(of_part(&program, &part), &part, own, certificate, watch) {
                End::Point(own) => {
                    for (&i, d) in part.variables.iter().zip(&own) {
                        direction[i] = *d;
                    }
                    certificate.b_stationary = Some(false);
                }
                End::Absent => {}
                End::Open if certificate.b_stationary == Some(false) => {}
                End::Open => certificate.b_stationary = None,
            }
        }
        if certificate.b_stationary == Some(false) {
            let whole = let_go.longest(&direction);
            let moved = direction.iter().zip(&self.sizes);
            certificate.descent = Some(moved.map(|(d, size)| whole * d * size).collect());
        }
    }

    /// A descent direction of a part, from one of its program without the pairs.
    fn search_part(
        &self,
        whole: LinearProgram,
        part: &Part,
        first: Vec<f64>,
        certificate: &mut Certificate,
        watch: &mut Watch<'_>,
    ) -> End {
        // the sides that the program without the pairs leaves the smaller ones come first: most descents keep them
        let smaller = |&(i, j): &(usize, usize)| {
            if first[i] - whole.lower[i] <= first[j] - whole.lower[j] {
                i
            } else {
                j
            }
        };
        let nearest: Vec<usize> = part.pairs.iter().map(smaller).collect();
        let mut search = PairedProgram {
            program: whole,
            pairs: &part.pairs,
            limit: -self.least,
            programs: 0,
            most_programs: MOST_PROGRAMS,
        };
        let end = search.search(vec![(Vec::new(), Some(first)), (nearest, None)], watch);
        certificate.programs += search.programs;
        end
    }

    /// Multipliers of rows and variables that prove a point whose own are too rough to be stationary in its branch, with
    /// what is left of optimality: the largest multiplier of a bound times the distance to it, in units of the radius.
    pub(crate) fn multipliers(&self, watch: &mut Watch<'_>) -> Option<(Vec<f64>, Vec<f64>, f64)> {
        if !self.is_rough {
            return None;
        }
        let program = self.linear_program(&[]);
        let Outcome::Above(y) = program.solve_below(-self.least, watch) else {
            return None;
        };
        let mut reduced = self.gradient.clone();
        for (&(row, column), value) in self.pattern.iter().zip(&self.values) {
            reduced[column] -= value * y[row];
        }
        let rooms = (program.lower.iter().zip(&program.upper)).zip(&reduced);
        let rows = (program.row_lower.iter().zip(&program.row_upper)).zip(&y);
        let left = rooms.chain(rows).map(|((lower, upper), z)| {
            let room = if *z > 0.0 { -lower } else { *upper };
            if *z == 0.0 { 0.0 } else { z.abs() * room }
        });
        let left = left.fold(0.0, f64::max);
        for (reduced, size) in reduced.iter_mut().zip(&self.sizes) {
            *reduced /= size;
        }
        Some((y.iter().map(|y| -y).collect(), reduced, left))
    }

    /// The linear program without the complementarity of the biactive pairs.
    pub(crate) fn linear_program(&self, biactive: &[usize]) -> LinearProgram {
        let (mut lower, mut upper) = (self.lower.clone(), self.upper.clone());
        let x = &self.point.x;
        for (k, &(i, j)) in self.pairs.iter().enumerate() {
            if biactive.binary_search(&k).is_err() {
                // the vanishing side stays zero
                let side = if x[i] <= x[j] { i } else { j };
                lower[side] = 0.0;
                upper[side] = 0.0;
            }
        }
        LinearProgram {
            gradient: self.gradient.clone(),
            pattern: self.pattern.clone(),
            values: self.values.clone(),
            row_lower: self.row_lower.clone(),
            row_upper: self.row_upper.clone(),
            lower,
            upper,
        }
    }
}

/// How far a value may move down and up, in units of `radius`, never less than not at all; what is next to nothing is
/// nothing. An absent bound leaves infinite room.
fn room(value: f64, (lower, upper): (f64, f64), radius: f64) -> (f64, f64) {
    if lower == upper {
        return (0.0, 0.0);
    }
    let whole = |room: f64| if room > NONE { room } else { 0.0 };
    (
        -whole((value - lower) / radius),
        whole((upper - value) / radius),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classify_pair_by_signs() {
        let kind = |a, b| classify_pair([a, b], [1e-6, 1e-6]);
        assert_eq!(kind(1.0, 0.0), StationarityType::Strong);
        assert_eq!(kind(-1.0, 0.0), StationarityType::Mordukhovich);
        assert_eq!(kind(-1.0, -2.0), StationarityType::Clarke);
        assert_eq!(kind(-1.0, 2.0), StationarityType::Weak);
    }

    #[test]
    fn classify_pair_measures_each_multiplier_by_its_own_terms() {
        // -0.5 is nothing beside terms of 1e6, and much beside terms of 1
        assert_eq!(
            classify_pair([-0.5, 2.0], [1.0, 1e-6]),
            StationarityType::Strong
        );
        assert_eq!(
            classify_pair([-0.5, 2.0], [1e-6, 1.0]),
            StationarityType::Weak
        );
    }

    #[test]
    fn room_is_the_distance_and_infinite_without_a_bound() {
        assert_eq!(room(0.0, (0.0, 1.0), 0.5), (0.0, 2.0));
        assert_eq!(room(5.0, (5.0, 5.0), 0.5), (0.0, 0.0));
        assert_eq!(
            room(3.0, (f64::NEG_INFINITY, f64::INFINITY), 0.5),
            (f64::NEG_INFINITY, f64::INFINITY)
        );
        // outside by rounding
        assert_eq!(room(-1e-12, (0.0, f64::INFINITY), 1e-2).0, 0.0);
    }
}
