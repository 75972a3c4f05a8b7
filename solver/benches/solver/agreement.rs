//! Whether two statements are the same problem.

use std::collections::HashMap;

use hangtime_solver::nlp::NlpProblem;

/// Panics if bounds, values or derivatives of two problems differ at points near the start.
///
/// The two differ in the order of operations only, so entries agree to rounding of the largest of their kind; 1e-11
/// leaves room for sums of thousands of terms and for sixth powers.
pub(crate) fn assert_same(a: &mut dyn NlpProblem, b: &mut dyn NlpProblem) {
    let (n, m) = (a.variables(), a.constraints());
    assert_eq!((n, m), (b.variables(), b.constraints()));
    let start = start(a);
    assert_eq!(start, self::start(b));
    assert_eq!(bounds(a), bounds(b));
    for shift in [0.0, 0.01] {
        let x: Vec<f64> = start
            .iter()
            .enumerate()
            .map(|(i, x)| x + shift * (1.0 + (i % 17) as f64 / 17.0))
            .collect();
        let y: Vec<f64> = (0..m).map(|i| 1.0 - (i % 7) as f64 / 3.0).collect();
        for (name, p, q) in [
            ("values", values(a, &x), values(b, &x)),
            ("gradient", gradient(a, &x), gradient(b, &x)),
        ] {
            let largest = p.iter().fold(1.0, |s: f64, v| s.max(v.abs()));
            for (i, (p, q)) in p.iter().zip(&q).enumerate() {
                assert!((p - q).abs() <= 1e-11 * largest, "{name} {i}: {p} and {q}");
            }
        }
        assert_same_matrix("jacobian", &jacobian(a, &x), &jacobian(b, &x));
        assert_same_matrix("hessian", &hessian(a, &x, &y), &hessian(b, &x, &y));
    }
}

type Matrix = HashMap<(usize, usize), f64>;

/// Entries that only one pattern has must be zero.
fn assert_same_matrix(name: &str, p: &Matrix, q: &Matrix) {
    let largest = p.values().fold(1.0, |s: f64, v| s.max(v.abs()));
    for place in p.keys().chain(q.keys()) {
        let entry = |of: &Matrix| of.get(place).copied().unwrap_or(0.0);
        let (p, q) = (entry(p), entry(q));
        assert!(
            (p - q).abs() <= 1e-11 * largest,
            "{name} {place:?}: {p} and {q}"
        );
    }
}

fn start(problem: &dyn NlpProblem) -> Vec<f64> {
    let mut x = vec![0.0; problem.variables()];
    problem.initial_point(&mut x);
    x
}

fn bounds(problem: &dyn NlpProblem) -> [Vec<f64>; 4] {
    let (n, m) = (problem.variables(), problem.constraints());
    let mut all = [vec![0.0; n], vec![0.0; n], vec![0.0; m], vec![0.0; m]];
    let [x_lower, x_upper, c_lower, c_upper] = &mut all;
    problem.variable_bounds(x_lower, x_upper);
    problem.constraint_bounds(c_lower, c_upper);
    all
}

/// Constraints, then the objective.
fn values(problem: &mut dyn NlpProblem, x: &[f64]) -> Vec<f64> {
    let mut c = vec![0.0; problem.constraints()];
    problem.constraint_values(x, &mut c);
    c.push(problem.objective(x));
    c
}

fn gradient(problem: &mut dyn NlpProblem, x: &[f64]) -> Vec<f64> {
    let mut gradient = vec![0.0; x.len()];
    problem.gradient(x, &mut gradient);
    gradient
}

fn jacobian(problem: &mut dyn NlpProblem, x: &[f64]) -> Matrix {
    let pattern = problem.jacobian_pattern();
    let mut values = vec![0.0; pattern.len()];
    problem.jacobian_values(x, &mut values);
    pattern.into_iter().zip(values).collect()
}

fn hessian(problem: &mut dyn NlpProblem, x: &[f64], y: &[f64]) -> Matrix {
    let pattern = problem.hessian_pattern();
    let mut values = vec![0.0; pattern.len()];
    problem.hessian_values(x, 0.5, y, &mut values);
    pattern.into_iter().zip(values).collect()
}
