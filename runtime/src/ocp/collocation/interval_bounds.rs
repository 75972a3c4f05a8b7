//! Bounds at all times of coordinates that are parabolas, or cubics under linear controls, over a whole interval.

use super::builder::Builder;
use super::cubic_bounds;
use super::cubic_bounds::Cubic;
use super::discretization::Setting;
use crate::ocp::motion::control_grid::ControlShape;

/// Bounds of the coordinates that are parabolas, or cubics under linear controls, over a whole interval, whose length is `share` times the
/// variable `length`.
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
        problem,
        places,
        shape,
        ..
    } = builder.setting;
    let (n, program) = (builder.n, &mut builder.program);
    let half = 0.5 * share;
    if places.bounds_at_nodes {
        return;
    }
    for k in (0..n).filter(|&k| parabolas[k]) {
        let name = model.declaration().coordinates[k].name;
        let (q0, v0, q2) = (before[k], before[n + k], builder.state[k]);
        for (sign, bound) in [(1.0, bounds.0[k]), (-1.0, bounds.1[k])] {
            if !bound.is_finite() {
                continue;
            }
            let unit = if (bounds.1[k] - bounds.0[k]).is_finite() {
                bounds.1[k] - bounds.0[k]
            } else {
                1.0
            };
            let inside = format!("in the bound of `{name}` over interval {interval}");
            if shape == ControlShape::Linear {
                let cubic = Cubic {
                    from: (q0, v0),
                    to: (q2, builder.state[n + k]),
                    horizon: builder.frame.horizon,
                    intervals: problem.intervals,
                };
                cubic_bounds::bound(program, &cubic, (sign, bound, unit), &inside);
                continue;
            }
            let size = format!("size {inside}");
            let size = program.variable(size, (0.0, f64::INFINITY), 0.1 * unit, unit);
            let place = program.variable(format!("extremum {inside}"), (0.0, 1.0), 0.5, 1.0);
            let product = program.variable(
                format!("product {inside}"),
                (0.0, f64::INFINITY),
                0.05 * unit,
                unit,
            );
            let row = program.row(format!("product {inside}"), 0.0, 0.0);
            program.linear(row, product, 1.0 / unit);
            program.bilinear(row, size, place, -1.0 / unit);
            // b_0 - p theta, b_1 + p - p theta, b_2 - s + 2 p - p theta
            for (index, [linear_size, linear_product]) in [[0.0, 0.0], [0.0, 1.0], [-1.0, 2.0]]
                .into_iter()
                .enumerate()
            {
                let row = program.row(
                    format!("control point {index} {inside}"),
                    sign * bound / unit,
                    f64::INFINITY,
                );
                program.linear(row, if index == 2 { q2 } else { q0 }, sign / unit);
                if index == 1 {
                    program.bilinear(row, length, v0, sign * half / unit);
                }
                program.linear(row, size, linear_size / unit);
                program.linear(row, product, linear_product / unit);
                program.bilinear(row, product, place, -1.0 / unit);
            }
        }
    }
}
