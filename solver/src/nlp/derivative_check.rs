//! Comparison of a problem's derivatives with finite differences.

use super::{Fault, InputError, NlpProblem};

/// One compared derivative.
#[derive(Debug, Clone, PartialEq)]
pub struct DerivativeEntry {
    /// What was compared, by the problem's names: gradient, Jacobian or Hessian entry.
    pub name: String,
    /// The problem's value.
    pub given: f64,
    /// The central difference.
    pub difference: f64,
    /// `|given - difference| / max(1, |given|, |difference|)`.
    pub error: f64,
    /// Whether the position is missing from the pattern.
    pub missing: bool,
}

/// Compares gradient, Jacobian and Hessian of a problem with central differences of its values,
/// `(f(x + h e_j) - f(x - h e_j)) / 2h` with `h = cbrt(eps) max(1, |x_j|)`.
///
/// The gradient is compared with differences of `f`, the Jacobian with those of `c`, the Hessian of
/// `f + sum y_i c_i`, for multipliers of alternating sign, with those of the gradient of the Lagrangian.
/// Positions outside the patterns are compared with zero. Errors of exact derivatives are about 1e-8
/// times the scale of the functions.
///
/// Returns every compared entry, the largest error first. `x` is the point, by default the starting point. Costs `2 n` evaluations and `O(n (n + m))` memory:
/// meant for tests of small problems.
///
/// # Errors
/// [`InputError`] if `x` has the wrong length or a function is not finite there.
///
/// # Examples
/// ```
/// # use hangtime_solver::nlp::NlpProblem;
/// # #[derive(Clone)]
/// # struct Problem;
/// # impl NlpProblem for Problem {
/// #     fn variables(&self) -> usize { 2 }
/// #     fn constraints(&self) -> usize { 1 }
/// #     fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) { lower.fill(0.0); upper.fill(f64::INFINITY); }
/// #     fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) { lower[0] = 1.0; upper[0] = 1.0; }
/// #     fn initial_point(&self, x: &mut [f64]) { x.fill(0.5); }
/// #     fn objective(&mut self, x: &[f64]) -> f64 { x[0] * x[0] + 2.0 * x[1] * x[1] }
/// #     fn gradient(&mut self, x: &[f64], g: &mut [f64]) { g[0] = 2.0 * x[0]; g[1] = 4.0 * x[1]; }
/// #     fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) { c[0] = x[0] + x[1]; }
/// #     fn jacobian_pattern(&self) -> Vec<(usize, usize)> { vec![(0, 0), (0, 1)] }
/// #     fn jacobian_values(&mut self, _: &[f64], values: &mut [f64]) { values.fill(1.0); }
/// #     fn hessian_pattern(&self) -> Vec<(usize, usize)> { vec![(0, 0), (1, 1)] }
/// #     fn hessian_values(&mut self, _: &[f64], weight: f64, _: &[f64], values: &mut [f64]) {
/// #         values[0] = 2.0 * weight;
/// #         values[1] = 4.0 * weight;
/// #     }
/// # }
/// use hangtime_solver::nlp;
///
/// let compared = nlp::check_derivatives(&mut Problem, Some(&[0.3, 0.7]))?;
/// assert!(compared[0].error < 1e-6, "{:?}", compared[0]);
/// # Ok::<(), nlp::InputError>(())
/// ```
pub fn check_derivatives(
    problem: &mut dyn NlpProblem,
    x: Option<&[f64]>,
) -> Result<Vec<DerivativeEntry>, InputError> {
    let n = problem.variables();
    let m = problem.constraints();
    let mut point = vec![0.0; n];
    match x {
        Some(x) if x.len() == n => point.copy_from_slice(x),
        Some(x) => {
            return Err(InputError::from(Fault::WarmStart {
                what: "the point",
                expected: n,
                found: x.len(),
            }));
        }
        None => problem.initial_point(&mut point),
    }
    let given = Derivatives::at(problem, &point);
    if !given.is_finite() {
        return Err(InputError::from(Fault::NotFiniteAtStart {
            what: String::from("a derivative"),
        }));
    }
    let hessian = given.hessian(problem, &point);
    let mut entries = Vec::new();
    for j in 0..n {
        let h = f64::EPSILON.cbrt() * point[j].abs().max(1.0);
        let centre = point[j];
        point[j] = centre + h;
        let up = Derivatives::at(problem, &point);
        point[j] = centre - h;
        let down = Derivatives::at(problem, &point);
        point[j] = centre;
        let mut compare = |name: String, value: Option<f64>, difference: f64| {
            let given = value.unwrap_or(0.0);
            let scale = given.abs().max(difference.abs()).max(1.0);
            entries.push(DerivativeEntry {
                name,
                given,
                difference,
                error: (given - difference).abs() / scale,
                missing: value.is_none() && difference != 0.0,
            });
        };
        let variable = problem.variable_name(j);
        compare(
            format!("d objective / d {variable}"),
            Some(given.gradient[j]),
            (up.objective - down.objective) / (2.0 * h),
        );
        for i in 0..m {
            compare(
                format!("d {} / d {variable}", problem.constraint_name(i)),
                given.jacobian[i * n + j],
                (up.c[i] - down.c[i]) / (2.0 * h),
            );
        }
        for i in j..n {
            compare(
                format!(
                    "d2 lagrangian / d {} d {variable}",
                    problem.variable_name(i)
                ),
                hessian[i * n + j],
                (up.lagrangian_gradient(i, n) - down.lagrangian_gradient(i, n)) / (2.0 * h),
            );
        }
    }
    entries.sort_by(|a, b| b.error.total_cmp(&a.error));
    Ok(entries)
}

/// Multiplier of constraint `i` in the Lagrangian that is compared.
fn multiplier(i: usize) -> f64 {
    if i.is_multiple_of(2) { 1.0 } else { -0.5 }
}

/// Values and first derivatives at a point; `None` where the pattern has no entry.
struct Derivatives {
    objective: f64,
    gradient: Vec<f64>,
    c: Vec<f64>,
    jacobian: Vec<Option<f64>>,
}

impl Derivatives {
    fn at(problem: &mut dyn NlpProblem, x: &[f64]) -> Self {
        let (n, m) = (x.len(), problem.constraints());
        let objective = problem.objective(x);
        let mut gradient = vec![0.0; n];
        problem.gradient(x, &mut gradient);
        let mut c = vec![0.0; m];
        problem.constraint_values(x, &mut c);
        let pattern = problem.jacobian_pattern();
        let mut values = vec![0.0; pattern.len()];
        problem.jacobian_values(x, &mut values);
        let mut jacobian = vec![None; m * n];
        for (&(i, j), value) in pattern.iter().zip(&values) {
            jacobian[i * n + j] = Some(jacobian[i * n + j].unwrap_or(0.0) + value);
        }
        Self {
            objective,
            gradient,
            c,
            jacobian,
        }
    }

    fn is_finite(&self) -> bool {
        self.objective.is_finite()
            && self.gradient.iter().all(|g| g.is_finite())
            && self.c.iter().all(|c| c.is_finite())
            && self.jacobian.iter().flatten().all(|a| a.is_finite())
    }

    fn lagrangian_gradient(&self, i: usize, n: usize) -> f64 {
        let rows = self.c.len();
        self.gradient[i]
            + (0..rows)
                .map(|row| multiplier(row) * self.jacobian[row * n + i].unwrap_or(0.0))
                .sum::<f64>()
    }

    fn hessian(&self, problem: &mut dyn NlpProblem, x: &[f64]) -> Vec<Option<f64>> {
        let n = x.len();
        let y: Vec<f64> = (0..self.c.len()).map(multiplier).collect();
        let pattern = problem.hessian_pattern();
        let mut values = vec![0.0; pattern.len()];
        problem.hessian_values(x, 1.0, &y, &mut values);
        let mut hessian = vec![None; n * n];
        for (&(i, j), value) in pattern.iter().zip(&values) {
            hessian[i * n + j] = Some(hessian[i * n + j].unwrap_or(0.0) + value);
        }
        hessian
    }
}
