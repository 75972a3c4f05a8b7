//! Collocation nodes on `[0, 1]`, computed to rounding error as roots of Legendre combinations.

/// Values of the Legendre polynomials `P_n` and `P_{n-1}` at `x` in `[-1, 1]`.
pub(crate) fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut previous, mut current) = (0.0, 1.0);
    for k in 0..n {
        let k = k as f64;
        let next = ((2.0 * k + 1.0) * x * current - k * previous) / (k + 1.0);
        previous = current;
        current = next;
    }
    (current, previous)
}

/// Derivative of `P_n` at `x` in `(-1, 1)`.
pub(crate) fn legendre_derivative(n: usize, x: f64) -> f64 {
    let (p, previous) = legendre(n, x);
    n as f64 * (previous - x * p) / (1.0 - x * x)
}

/// Newton's method from a guess that lies in the basin of its root.
fn polish(mut x: f64, value: impl Fn(f64) -> f64, derivative: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..20 {
        let step = value(x) / derivative(x);
        x -= step;
        if step.abs() < 1e-16 {
            break;
        }
    }
    x
}

/// Gauss-Legendre nodes on `[0, 1]`: the roots of the shifted `P_s`, increasing.
pub(crate) fn gauss_legendre(s: usize) -> Vec<f64> {
    (0..s)
        .map(|i| {
            let guess = -(std::f64::consts::PI * (i as f64 + 0.75) / (s as f64 + 0.5)).cos();
            let root = polish(guess, |x| legendre(s, x).0, |x| legendre_derivative(s, x));
            0.5 * (1.0 + root)
        })
        .collect()
}

/// Radau IIA nodes on `[0, 1]`: the roots of the shifted `P_s - P_{s-1}`, increasing; the last is 1.
pub(crate) fn radau_iia(s: usize) -> Vec<f64> {
    let value = |x: f64| {
        let (p, previous) = legendre(s, x);
        p - previous
    };
    let derivative = |x: f64| legendre_derivative(s, x) - legendre_derivative(s - 1, x);
    // The roots inside (-1, 1) interlace with the extrema of a cosine grid: bracket by sampling.
    let mut nodes = Vec::with_capacity(s);
    let samples = 40 * s;
    let grid = |k: usize| -(std::f64::consts::PI * k as f64 / samples as f64).cos();
    for k in 0..samples {
        let (left, right) = (grid(k), grid(k + 1));
        if nodes.len() + 1 < s && value(left) * value(right) < 0.0 {
            nodes.push(0.5 * (1.0 + polish(0.5 * (left + right), value, derivative)));
        }
    }
    nodes.push(1.0);
    nodes
}
