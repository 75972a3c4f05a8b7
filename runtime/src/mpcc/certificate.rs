//! What kind of stationary point a feasible point is.

use super::Mpcc;
use super::linear_program::LinearProgram;
use super::watch::Watch;

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
    /// feasible descent direction; `None`: not decided within the limit of linear programs.
    pub b_stationary: Option<bool>,
    /// Indices of the biactive pairs.
    pub biactive: Vec<usize>,
    /// A feasible descent direction, length `n`, `|d|_inf <= 1`, if one was found.
    pub descent: Option<Vec<f64>>,
    /// Linear programs solved.
    pub programs: usize,
}

/// Rate of descent `grad f'd` for `|d|_inf <= 1` that still counts as none, relative to
/// `max(1, |grad f|_inf)`: points are accurate to about 1e-8 and their active sets to 1e-7.
const NO_DESCENT: f64 = 1e-6;

/// Distance from zero up to which a constraint is active, relative to its size.
const ACTIVE: f64 = 1e-6;

/// Sign of the multipliers of one biactive pair.
pub(crate) fn classify_pair(nu_i: f64, nu_j: f64, tolerance: f64) -> StationarityType {
    if nu_i >= -tolerance && nu_j >= -tolerance {
        StationarityType::Strong
    } else if nu_i.abs() <= tolerance || nu_j.abs() <= tolerance {
        StationarityType::Mordukhovich
    } else if nu_i * nu_j > 0.0 {
        StationarityType::Clarke
    } else {
        StationarityType::Weak
    }
}

/// A branch-and-bound problem over the sides of biactive pairs.
pub(crate) struct Certifier<'a> {
    pub(crate) problem: &'a mut dyn Mpcc,
    pub(crate) zero_tolerance: f64,
    pub(crate) maximum_programs: usize,
}

impl Certifier<'_> {
    /// Certificate of `x` with multipliers `nu` of the lower bounds of all variables.
    pub(crate) fn certify(&mut self, x: &[f64], nu: &[f64], watch: &mut Watch<'_>) -> Certificate {
        let pairs = self.problem.complementarities().to_vec();
        let mut upper = vec![0.0; x.len()];
        let mut lower = vec![0.0; x.len()];
        self.problem.variable_bounds(&mut lower, &mut upper);
        let biactive: Vec<usize> = (0..pairs.len())
            .filter(|&k| {
                let (i, j) = pairs[k];
                x[i].abs() <= self.zero_tolerance
                    && x[j].abs() <= self.zero_tolerance
                    && upper[i] > 0.0
                    && upper[j] > 0.0
            })
            .collect();
        let mut gradient = vec![0.0; x.len()];
        self.problem.gradient(x, &mut gradient);
        let scale = gradient.iter().fold(1.0, |a: f64, g| a.max(g.abs()));
        let stationarity = biactive
            .iter()
            .map(|&k| {
                let (i, j) = pairs[k];
                classify_pair(nu[i], nu[j], NO_DESCENT * scale)
            })
            .min()
            .unwrap_or(StationarityType::Strong);
        let mut certificate = Certificate {
            stationarity,
            b_stationary: Some(true),
            biactive,
            descent: None,
            programs: 0,
        };
        if stationarity != StationarityType::Strong {
            self.search_descent(x, (gradient, scale), &pairs, &mut certificate, watch);
        }
        certificate
    }

    /// Looks for a feasible descent direction: `d` solves
    /// `min grad f'd` over the linearized active constraints, `0 <= d_i _|_ d_j >= 0` for biactive pairs,
    /// `|d|_inf <= 1`, by branch and bound.
    fn search_descent(
        &mut self,
        x: &[f64],
        (gradient, scale): (Vec<f64>, f64),
        pairs: &[(usize, usize)],
        certificate: &mut Certificate,
        watch: &mut Watch<'_>,
    ) {
        let mut program = self.linearize(x, gradient, pairs, &certificate.biactive);
        let mut open: Vec<Vec<(usize, bool)>> = vec![Vec::new()];
        let free = program.upper.clone();
        while let Some(decided) = open.pop() {
            if certificate.programs >= self.maximum_programs || watch.stop.is_some() {
                certificate.b_stationary = None;
                return;
            }
            certificate.programs += 1;
            program.upper.copy_from_slice(&free);
            for &(k, first) in &decided {
                let (i, j) = pairs[k];
                program.upper[if first { i } else { j }] = 0.0;
            }
            let Some((d, value)) = program.solve(watch) else {
                certificate.b_stationary = None;
                continue;
            };
            if value >= -NO_DESCENT * scale {
                continue;
            }
            let violated = certificate
                .biactive
                .iter()
                .copied()
                .filter(|&k| !decided.iter().any(|&(other, _)| other == k))
                .map(|k| (k, d[pairs[k].0].min(d[pairs[k].1])))
                .filter(|&(_, least)| least > 1e-6)
                .max_by(|a, b| a.1.total_cmp(&b.1));
            match violated {
                None => {
                    certificate.b_stationary = Some(false);
                    certificate.descent = Some(d);
                    return;
                }
                Some((k, _)) => {
                    for first in [true, false] {
                        let mut child = decided.clone();
                        child.push((k, first));
                        open.push(child);
                    }
                }
            }
        }
    }

    /// Linearized constraints at a stationary point, active ones only.
    fn linearize(
        &mut self,
        x: &[f64],
        gradient: Vec<f64>,
        pairs: &[(usize, usize)],
        biactive: &[usize],
    ) -> LinearProgram {
        let n = x.len();
        let m = self.problem.constraints();
        let pattern = self.problem.jacobian_pattern();
        let mut values = vec![0.0; pattern.len()];
        self.problem.jacobian_values(x, &mut values);
        let mut c = vec![0.0; m];
        self.problem.constraint_values(x, &mut c);
        let (mut row_lower, mut row_upper) = (vec![0.0; m], vec![0.0; m]);
        self.problem
            .constraint_bounds(&mut row_lower, &mut row_upper);
        for row in 0..m {
            (row_lower[row], row_upper[row]) = cone(c[row], row_lower[row], row_upper[row], ACTIVE);
        }
        let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
        self.problem.variable_bounds(&mut lower, &mut upper);
        for i in 0..n {
            let (l, u) = cone(x[i], lower[i], upper[i], ACTIVE);
            lower[i] = l.max(-1.0);
            upper[i] = u.min(1.0);
        }
        for (k, &(i, j)) in pairs.iter().enumerate() {
            if biactive.binary_search(&k).is_ok() {
                lower[i] = 0.0;
                lower[j] = 0.0;
                continue;
            }
            // the vanishing side stays zero
            let side = if x[i] <= x[j] { i } else { j };
            lower[side] = 0.0;
            upper[side] = 0.0;
        }
        LinearProgram {
            gradient,
            pattern,
            values,
            row_lower,
            row_upper,
            lower,
            upper,
        }
    }
}

/// Bounds of a direction at `value`: zero where a bound is active, absent elsewhere.
fn cone(value: f64, lower: f64, upper: f64, tolerance: f64) -> (f64, f64) {
    let active = |bound: f64| (value - bound).abs() <= tolerance * bound.abs().max(1.0);
    (
        if active(lower) {
            0.0
        } else {
            f64::NEG_INFINITY
        },
        if active(upper) { 0.0 } else { f64::INFINITY },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classify_pair_by_signs() {
        let kind = |a, b| classify_pair(a, b, 1e-6);
        assert_eq!(kind(1.0, 0.0), StationarityType::Strong);
        assert_eq!(kind(-1.0, 0.0), StationarityType::Mordukhovich);
        assert_eq!(kind(-1.0, -2.0), StationarityType::Clarke);
        assert_eq!(kind(-1.0, 2.0), StationarityType::Weak);
    }

    #[test]
    fn cone_keeps_only_active_bounds() {
        assert_eq!(cone(0.0, 0.0, 1.0, 1e-6), (0.0, f64::INFINITY));
        assert_eq!(cone(5.0, 5.0, 5.0, 1e-6), (0.0, 0.0));
    }
}
