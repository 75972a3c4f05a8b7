//! Bounds at all times on a coordinate that is a polynomial on each interval: a parabola where it is driven by constant controls alone, a
//! cubic by linear ones.
//!
//! A polynomial that is nowhere negative on `[0, 1]` is its minimum, or its value at the end where that is attained, plus a double root times
//! a number or a linear function that is nowhere negative. So a bound holds at all times if and only if the shifted control points
//! `b_0 .. b_2` of a parabola are at least those of `s (t - theta)^2` for some `s >= 0` and `theta` in `[0, 1]`, and `b_0 .. b_3` of a cubic
//! those of `(t - theta)^2 (alpha (1 - t) + beta t)` for some `alpha >= 0`, `beta >= 0`:
//!
//! ```text
//! b_0 >= s theta^2               b_1 >= s theta^2 - s theta              b_2 >= s (1 - theta)^2
//!
//! b_0 >= alpha theta^2           b_1 >= (beta theta^2 - 2 alpha theta (1 - theta)) / 3
//! b_3 >= beta (1 - theta)^2      b_2 >= (alpha (1 - theta)^2 - 2 beta theta (1 - theta)) / 3
//! ```
//!
//! The rows have independent gradients also where the coordinate rests on its bound.

use super::builder::Builder;
use super::discretization::Setting;
use crate::ocp::motion::control_grid::ControlShape;
use crate::program::sparse_program::Program;

/// A control point: whether it is at the end, the share of the interval by which it is moved with the rate there, and how it is made of each
/// size, its product with `theta`, and that once more with `theta`.
type ControlPoint = (bool, f64, &'static [[f64; 3]]);

const THIRD: f64 = 1.0 / 3.0;

/// Those of a parabola with one size, and of a cubic with two.
const PARABOLA: [ControlPoint; 3] = [
    (false, 0.0, &[[0.0, 0.0, 1.0]]),
    (false, 0.5, &[[0.0, -1.0, 1.0]]),
    (true, 0.0, &[[1.0, -2.0, 1.0]]),
];
const CUBIC: [ControlPoint; 4] = [
    (false, 0.0, &[[0.0, 0.0, 1.0], [0.0; 3]]),
    (
        false,
        THIRD,
        &[[0.0, -2.0 * THIRD, 2.0 * THIRD], [0.0, 0.0, THIRD]],
    ),
    (
        true,
        -THIRD,
        &[
            [THIRD, -2.0 * THIRD, THIRD],
            [0.0, -2.0 * THIRD, 2.0 * THIRD],
        ],
    ),
    (true, 0.0, &[[0.0; 3], [1.0, -2.0, 1.0]]),
];

/// Bounds of the coordinates that are polynomials over a whole interval, whose length is `share` times the variable `length`.
pub(in crate::ocp) fn add(
    builder: &mut Builder,
    interval: usize,
    before: &[usize],
    (length, share): (usize, f64),
) {
    let Setting {
        model,
        bounds,
        parabolas,
        shape,
        ..
    } = builder.setting;
    let (n, program) = (builder.n, &mut builder.program);
    for k in (0..n).filter(|&k| parabolas[k]) {
        let name = model.declaration().coordinates[k].name;
        let inside = format!("in the bound of `{name}` over interval {interval}");
        let width = bounds.1[k] - bounds.0[k];
        let unit = if width.is_finite() { width } else { 1.0 };
        let (sizes, points): (&[&str], &[ControlPoint]) = match shape {
            ControlShape::Constant => (&["size"], &PARABOLA),
            ControlShape::Linear => (&["alpha", "beta"], &CUBIC),
        };
        let ends = [before, &builder.state].map(|state| (state[k], state[n + k]));
        for (sign, bound) in [(1.0, bounds.0[k]), (-1.0, bounds.1[k])] {
            if !bound.is_finite() {
                continue;
            }
            let (place, sizes) = unknowns(program, sizes, unit, &inside);
            for (index, &(at_end, rate, factors)) in points.iter().enumerate() {
                let name = format!("control point {index} {inside}");
                let row = program.row(name, sign * bound / unit, f64::INFINITY);
                let (q, v) = ends[usize::from(at_end)];
                program.linear(row, q, sign / unit);
                if rate != 0.0 {
                    program.bilinear(row, length, v, sign * rate * share / unit);
                }
                for (&(size, product), [linear, mixed, square]) in sizes.iter().zip(factors) {
                    program.linear(row, size, -linear / unit);
                    program.linear(row, product, -mixed / unit);
                    if *square != 0.0 {
                        program.bilinear(row, product, place, -square / unit);
                    }
                }
            }
        }
    }
}

/// Adds the place `theta` of a double root, and the sizes with these names, each with its product with that.
fn unknowns(
    program: &mut Program,
    sizes: &[&str],
    unit: f64,
    inside: &str,
) -> (usize, Vec<(usize, usize)>) {
    let place = program.variable(format!("extremum {inside}"), (0.0, 1.0), 0.5, 1.0);
    let positive = (0.0, f64::INFINITY);
    let sizes = sizes.iter().map(|name| {
        let size = program.variable(format!("{name} {inside}"), positive, 0.1 * unit, unit);
        let name = format!("product of {name} {inside}");
        let product = program.variable(name.clone(), positive, 0.05 * unit, unit);
        let row = program.row(name, 0.0, 0.0);
        program.linear(row, product, 1.0 / unit);
        program.bilinear(row, size, place, -1.0 / unit);
        (size, product)
    });
    let sizes = sizes.collect();
    (place, sizes)
}
