//! Bounds at all times on a coordinate that is a cubic on each interval: one that is driven by linear controls alone.
//!
//! A cubic that is nowhere negative on `[0, 1]` is its minimum, or its value at the end where that is attained, plus a
//! double root times a linear function that is nowhere negative. So a bound holds at all times if and only if the
//! shifted control points `b_0 .. b_3` of the cubic are at least those of
//! `(t - theta)^2 (alpha (1 - t) + beta t)` for some `alpha >= 0`, `beta >= 0` and `theta` in `[0, 1]`:
//!
//! ```text
//! b_0 >= alpha theta^2                   b_1 >= (beta theta^2 - 2 alpha theta (1 - theta)) / 3
//! b_3 >= beta (1 - theta)^2              b_2 >= (alpha (1 - theta)^2 - 2 beta theta (1 - theta)) / 3
//! ```
//!
//! As for parabolas, the rows have independent gradients also where the coordinate rests on its bound.

use crate::program::sparse_program::Program;

/// A cubic by values and rates at both ends of an interval, of which there are `intervals` in the horizon.
pub(in crate::ocp) struct Cubic {
    pub(in crate::ocp) from: (usize, usize),
    pub(in crate::ocp) to: (usize, usize),
    pub(in crate::ocp) horizon: usize,
    pub(in crate::ocp) intervals: usize,
}

/// Adds the rows of `sign (q - bound) >= 0` at all times, divided by `unit`.
pub(in crate::ocp) fn bound(
    program: &mut Program,
    cubic: &Cubic,
    (sign, bound, unit): (f64, f64, f64),
    inside: &str,
) {
    let infinity = f64::INFINITY;
    let place = program.variable(format!("extremum {inside}"), (0.0, 1.0), 0.5, 1.0);
    let sizes = ["alpha", "beta"].map(|name| {
        let size = program.variable(
            format!("{name} {inside}"),
            (0.0, infinity),
            0.1 * unit,
            unit,
        );
        let name = format!("product of {name} {inside}");
        let product = program.variable(name.clone(), (0.0, infinity), 0.05 * unit, unit);
        let row = program.row(name, 0.0, 0.0);
        program.linear(row, product, 1.0 / unit);
        program.bilinear(row, size, place, -1.0 / unit);
        (size, product)
    });
    // (state, rate with the factor of a third of the interval), then (size, product, product theta) of alpha and beta.
    let ends = [cubic.from, cubic.from, cubic.to, cubic.to];
    let third = 1.0 / 3.0;
    let points: [(f64, [[f64; 3]; 2]); 4] = [
        (0.0, [[0.0, 0.0, 1.0], [0.0; 3]]),
        (third, [[0.0, -2.0 * third, 2.0 * third], [0.0, 0.0, third]]),
        (
            -third,
            [
                [third, -2.0 * third, third],
                [0.0, -2.0 * third, 2.0 * third],
            ],
        ),
        (0.0, [[0.0; 3], [1.0, -2.0, 1.0]]),
    ];
    for (index, ((rate, coefficients), (q, v))) in points.into_iter().zip(ends).enumerate() {
        let row = program.row(
            format!("control point {index} {inside}"),
            sign * bound / unit,
            infinity,
        );
        program.linear(row, q, sign / unit);
        if rate != 0.0 {
            let factor = rate / cubic.intervals as f64;
            program.bilinear(row, cubic.horizon, v, sign * factor / unit);
        }
        for ((size, product), [linear, mixed, square]) in sizes.into_iter().zip(coefficients) {
            program.linear(row, size, -linear / unit);
            program.linear(row, product, -mixed / unit);
            if square != 0.0 {
                program.bilinear(row, product, place, -square / unit);
            }
        }
    }
}
