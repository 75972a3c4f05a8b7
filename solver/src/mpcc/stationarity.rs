//! What is proved about a result.

use std::fmt;

/// What is proved about a feasible point.
///
/// ```
/// use hangtime_solver::mpcc::{self, Mpcc, Settings, Stationarity};
/// # use hangtime_solver::nlp::NlpProblem;
///
/// /// The projection of (1, 1) on the cone `0 <= x_0 _|_ x_1 >= 0`: (1, 0), or (0, 1).
/// struct Projection;
///
/// # impl NlpProblem for Projection {
/// #     fn variables(&self) -> usize { 2 }
/// #     fn constraints(&self) -> usize { 0 }
/// #     fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
/// #         lower.fill(0.0);
/// #         upper.fill(f64::INFINITY);
/// #     }
/// #     fn constraint_bounds(&self, _: &mut [f64], _: &mut [f64]) {}
/// #     fn initial_point(&self, x: &mut [f64]) { x.copy_from_slice(&[1.0, 0.5]); }
/// #     fn objective(&mut self, x: &[f64]) -> f64 { (x[0] - 1.0).powi(2) + (x[1] - 1.0).powi(2) }
/// #     fn gradient(&mut self, x: &[f64], g: &mut [f64]) {
/// #         g.copy_from_slice(&[2.0 * (x[0] - 1.0), 2.0 * (x[1] - 1.0)]);
/// #     }
/// #     fn constraint_values(&mut self, _: &[f64], _: &mut [f64]) {}
/// #     fn jacobian_pattern(&self) -> Vec<(usize, usize)> { Vec::new() }
/// #     fn jacobian_values(&mut self, _: &[f64], _: &mut [f64]) {}
/// #     fn hessian_pattern(&self) -> Vec<(usize, usize)> { vec![(0, 0), (1, 1)] }
/// #     fn hessian_values(&mut self, _: &[f64], weight: f64, _: &[f64], values: &mut [f64]) {
/// #         values.fill(2.0 * weight);
/// #     }
/// # }
/// #
/// impl Mpcc for Projection {
///     fn complementarities(&self) -> &[(usize, usize)] { &[(0, 1)] }
/// }
///
/// let solution = mpcc::solve(&mut Projection, &Settings::default())?;
/// // Only one side of the pair vanishes: there is no other choice nearby.
/// assert_eq!(solution.stationarity, Stationarity::S);
/// # Ok::<(), hangtime_solver::InputError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stationarity {
    /// Strongly stationary: the optimality conditions of the program with all pairs relaxed hold.
    S,
    /// B-stationary: both sides of some pairs vanish, and no choice of the sides that stay zero is better.
    B,
    /// Nothing.
    None,
}

impl fmt::Display for Stationarity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::S => "S, no pair has another side that could vanish",
            Self::B => "B, no other choice of the sides that vanish is better",
            Self::None => "none, other choices of the sides were not compared",
        })
    }
}

impl Stationarity {
    /// Name used in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::S => "S",
            Self::B => "B",
            Self::None => "none",
        }
    }
}
