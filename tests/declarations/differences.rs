//! Numerical derivatives that know how far they are off.

/// Steps of differences, each a quarter of the one before.
const STEPS: u32 = 11;

/// A number, and how far it may be off.
#[derive(Clone, Copy)]
pub(crate) struct Near {
    pub(crate) value: f64,
    pub(crate) off: f64,
    /// Of the values that it is a difference of.
    size: f64,
}

impl Near {
    /// Whether numbers are those wanted; false where these are not known to six digits, as at a kink or where there are no values.
    ///
    /// # Errors
    /// The first disagreement.
    pub(crate) fn compared(what: &str, found: &[f64], wanted: &[Self]) -> Result<bool, String> {
        let larger = |size: f64, near: &Self| size.max(near.size).max(near.value.abs());
        let size = wanted.iter().fold(1e-7, larger);
        if !wanted.iter().all(|near| near.off <= 1e-6 * size) {
            return Ok(false);
        }
        assert_eq!(found.len(), wanted.len(), "{what}");
        let is_near = |(found, near): &(&f64, &Self)| (*found - near.value).abs() <= near.off;
        let mut pairs = found.iter().zip(wanted).enumerate();
        let apart = pairs.find(|(_, pair)| !is_near(pair));
        apart.map_or(Ok(true), |(i, (found, Self { value, off, .. }))| {
            Err(format!(
                "{what}[{i}]: {found:e} instead of {value:e} within {off:e}"
            ))
        })
    }
}

/// Derivatives at 0 by central differences of sixth order, each by the step at which it changes least from the one before. What it changes
/// by there is truncation of the larger step and rounding of this one, and may be small by chance, though not twice.
pub(crate) fn slopes(f: impl Fn(f64) -> Vec<f64>) -> Vec<Near> {
    let mut best: Vec<Near> = Vec::new();
    let mut last: Vec<[f64; 2]> = Vec::new();
    for k in 0..STEPS {
        let step = 0.1 * 0.25_f64.powi(k as i32);
        let sides = [1.0, 2.0, 3.0].map(|i| (f(i * step), f(-i * step)));
        let rows = sides[0].0.len();
        last.resize(rows, [f64::INFINITY; 2]);
        best.resize(
            rows,
            Near {
                value: f64::NAN,
                off: f64::INFINITY,
                size: 0.0,
            },
        );
        for (row, (best, last)) in best.iter_mut().zip(&mut last).enumerate() {
            let apart = |i: usize| sides[i].0[row] - sides[i].1[row];
            let value = (45.0 * apart(0) - 9.0 * apart(1) + apart(2)) / (60.0 * step);
            let sizes = sides.iter().map(|(a, b)| a[row].abs() + b[row].abs());
            let size = sizes.fold(0.0, f64::max);
            let change = (value - last[0]).abs();
            let rounding = f64::EPSILON * (64.0 + 8.0 * size / step);
            let off = (32.0 * change).max(4.0 * last[1]) + rounding;
            *last = [value, change];
            if off < best.off {
                *best = Near { value, off, size };
            }
        }
    }
    best
}

/// Rates of functions of coordinates and of the time, which is the last input, at an input vector `(q, v, ..)`.
pub(crate) fn rates(n: usize, x: &[f64], functions: impl Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
    let slopes = slopes(|s| {
        let ahead = x.iter().enumerate();
        let ahead = ahead.map(|(i, x_i)| x_i + s * if i < n { x[n + i] } else { 1.0 });
        functions(&ahead.collect::<Vec<f64>>())
    });
    slopes.iter().map(|near| near.value).collect()
}

/// Whether numbers agree but for roundings of terms of this size, times the condition of what is solved for, and of numbers near one.
///
/// # Errors
/// They do not.
pub(crate) fn equal(what: &str, found: f64, wanted: f64, size: f64) -> Result<(), String> {
    let off = 1e-12 * size + 64.0 * f64::EPSILON;
    match (found - wanted).abs() <= off {
        true => Ok(()),
        false => Err(format!(
            "{what}: {found:e} instead of {wanted:e} within {off:e}"
        )),
    }
}
