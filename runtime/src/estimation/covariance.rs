//! How well parameters are known: from the Jacobian of the residuals at an optimum.
//!
//! ```text
//! C = (J' J)^-1                                         squares
//! C = (J' D J)^-1 J' diag(psi^2) J (J' D J)^-1          a loss rho with psi = rho'/2 and D = diag(psi')
//! ```
//!
//! The second is the sandwich of Huber (*The behavior of maximum likelihood estimates under nonstandard conditions*, 1967).

use super::least_squares::Evaluation;
use super::result::Direction;
use super::svd::Svd;
use crate::linalg::products::dot;
use crate::model::ParameterDeclaration;
use crate::yardstick;

/// Share of the largest singular value below which a direction is not determined: derivatives are known to about 1e-9.
const UNDETERMINED: f64 = 1e-7;
/// Share of a direction from which on a parameter takes part in it.
const TAKES_PART: f64 = 1e-3;
/// Share of a range that stands for a change.
const CHANGE: f64 = 0.01;

/// What the measurements say of the parameters that do not end at bounds.
pub(super) struct Knowledge {
    /// By parameter; zero for those at bounds, not a number for those that are not determined.
    pub(super) covariance: Vec<Vec<f64>>,
    /// Directions, in ranges, in which nothing is determined.
    pub(super) undetermined: Vec<Vec<f64>>,
    /// The parameters whose standard deviation is above their range.
    pub(super) vague: Vec<usize>,
}

impl Knowledge {
    /// At an optimum, for the parameters that `moves` says and with these ranges.
    pub(super) fn at(at: &Evaluation, moves: &[bool], bounds: &[(f64, f64)]) -> Self {
        let n = moves.len();
        let moving: Vec<usize> = (0..n).filter(|&j| moves[j]).collect();
        let width = |j: usize| bounds[j].1 - bounds[j].0;
        let counts: Vec<bool> = at
            .residuals
            .iter()
            .zip(&at.linear_from)
            .map(|(r, &c)| r.abs() <= c)
            .collect();
        let column = |&j: &usize| -> Vec<f64> {
            let values = at.columns[j].iter().zip(&counts);
            values
                .map(|(value, counts)| if *counts { value * width(j) } else { 0.0 })
                .collect()
        };
        let svd = Svd::of(moving.iter().map(column).collect());
        let largest = svd.largest();
        let is_known = |k: usize| svd.sigma[k] > UNDETERMINED.max(yardstick::NOTHING) * largest;
        let mut covariance = vec![vec![0.0; n]; n];
        let mut undetermined = Vec::new();
        for k in 0..moving.len() {
            if !is_known(k) {
                let mut direction = vec![0.0; n];
                for (&j, v) in moving.iter().zip(&svd.v[k]) {
                    direction[j] = *v;
                }
                undetermined.push(direction);
            }
        }
        // Of each singular vector, how its scaled parameters follow from the residuals.
        let psi: Vec<f64> = at
            .residuals
            .iter()
            .zip(&at.linear_from)
            .map(|(r, &c)| r.abs().min(c))
            .collect();
        let robust = at.linear_from.iter().any(|c| c.is_finite());
        let inverse = inverse(&svd, &moving, (at, &psi, robust), (&width, &is_known));
        for (a, &i) in moving.iter().enumerate() {
            for (b, &j) in moving.iter().enumerate() {
                covariance[i][j] = inverse[a][b] * width(i) * width(j);
            }
        }
        for direction in &undetermined {
            for j in (0..n).filter(|&j| direction[j].abs() > TAKES_PART) {
                (0..n).for_each(|i| {
                    covariance[i][j] = f64::NAN;
                    covariance[j][i] = f64::NAN;
                });
            }
        }
        let vague = moving
            .iter()
            .copied()
            .filter(|&j| covariance[j][j] > width(j) * width(j));
        Self {
            vague: vague.collect(),
            covariance,
            undetermined,
        }
    }
}

/// The covariance in ranges of the parameters that move.
fn inverse(
    svd: &Svd,
    moving: &[usize],
    (at, psi, robust): (&Evaluation, &[f64], bool),
    (width, is_known): (&dyn Fn(usize) -> f64, &dyn Fn(usize) -> bool),
) -> Vec<Vec<f64>> {
    let m = moving.len();
    let known: Vec<usize> = (0..m).filter(|&k| is_known(k)).collect();
    // In the directions of the singular vectors: `S^-2`, or `S^-2 V' (J' psi^2 J) V S^-2`.
    let middle = |k: usize, l: usize| -> f64 {
        if !robust {
            return if k == l { svd.sigma[k].powi(-2) } else { 0.0 };
        }
        let along = |k: usize| -> Vec<f64> {
            let mut sum = vec![0.0; psi.len()];
            for (&j, v) in moving.iter().zip(&svd.v[k]) {
                for (sum, by) in sum.iter_mut().zip(&at.columns[j]) {
                    *sum += v * width(j) * by;
                }
            }
            sum.iter().zip(psi).map(|(sum, psi)| sum * psi).collect()
        };
        dot(&along(k), &along(l)) * (svd.sigma[k] * svd.sigma[l]).powi(-2)
    };
    let mut covariance = vec![vec![0.0; m]; m];
    for &k in &known {
        for &l in &known {
            let middle = middle(k, l);
            for (row, a) in covariance.iter_mut().zip(&svd.v[k]) {
                for (value, b) in row.iter_mut().zip(&svd.v[l]) {
                    *value += a * middle * b;
                }
            }
        }
    }
    covariance
}

/// A direction in ranges as changes of parameters, and in words.
pub(super) fn in_words(
    direction: &[f64],
    bounds: &[(f64, f64)],
    parameters: &[&ParameterDeclaration],
) -> Direction {
    let largest = direction.iter().fold(0.0_f64, |most, v| v.abs().max(most));
    let first = direction.iter().find(|v| v.abs() > TAKES_PART);
    let sense = first.map_or(1.0, |v| v.signum());
    let takes_part = |&j: &usize| direction[j].abs() > TAKES_PART * largest;
    let changes: Vec<(usize, f64)> = (0..direction.len())
        .filter(takes_part)
        .map(|j| {
            let width = bounds[j].1 - bounds[j].0;
            (j, sense * CHANGE * width * direction[j] / largest)
        })
        .collect();
    let shown = changes.iter().map(|&(j, change)| {
        let known = parameters[j];
        format!("`{}` by {change:+.3e} {}", known.name, known.unit)
            .trim_end()
            .to_owned()
    });
    let text = match &changes[..] {
        [(j, _)] => format!("no measurement changes with `{}`", parameters[*j].name),
        _ => format!(
            "no measurement changes where {} together",
            shown.collect::<Vec<_>>().join(" and ")
        ),
    };
    Direction { changes, text }
}
