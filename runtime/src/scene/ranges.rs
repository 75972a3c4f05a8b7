//! The range of a kernel of one value where its inputs lie in ranges, by interval arithmetic.
//!
//! Each operation gives all values that it has for any numbers of the ranges of its operands, so that the last one contains all that
//! the kernel has, and mostly some more: operands count as independent of each other but for squares. Source: Moore, *Interval
//! analysis* (1966). Rounding errors of the bounds, some `1e-16` of the numbers they consist of, are left to who compares them.

use hangtime_dsl::description::{Kernel, Operation};

/// From a least to a greatest number.
type Range = [f64; 2];

/// All numbers.
const ALL: Range = [f64::NEG_INFINITY, f64::INFINITY];

/// The range of the first output of a kernel, with these `parameters`, where its inputs lie between `low` and `high`. What it does not
/// follow, such as functions of the library, may have any value.
pub(super) fn of(kernel: &Kernel, parameters: &[f64], (low, high): (&[f64], &[f64])) -> Range {
    let mut values: Vec<Range> = Vec::with_capacity(kernel.operations.len());
    for &operation in &kernel.operations {
        let at = |part: u32| values[part as usize];
        values.push(match operation {
            Operation::Parameter(i) => [parameters[i as usize]; 2],
            Operation::Constant(value) => [value; 2],
            Operation::Input(i) => [low[i as usize], high[i as usize]],
            Operation::Add(a, b) => known([at(a)[0] + at(b)[0], at(a)[1] + at(b)[1]]),
            Operation::Subtract(a, b) => known([at(a)[0] - at(b)[1], at(a)[1] - at(b)[0]]),
            Operation::Multiply(a, b) if a == b => square(at(a)),
            Operation::Multiply(a, b) => product(at(a), at(b)),
            Operation::Divide(a, b) => quotient(at(a), at(b)),
            Operation::Negate(a) => [-at(a)[1], -at(a)[0]],
            Operation::Root(a) => known(at(a).map(|end| end.max(0.0).sqrt())),
            Operation::Weight(_) | Operation::Call(..) | Operation::Call2(..) => ALL,
        });
    }
    let last = kernel.outputs.first();
    last.map_or(ALL, |&output| values[output as usize])
}

/// A range with ends that are numbers, otherwise all numbers.
fn known(range: Range) -> Range {
    if range.iter().any(|end| end.is_nan()) {
        ALL
    } else {
        range
    }
}

fn square([low, high]: Range) -> Range {
    let least = if low <= 0.0 && high >= 0.0 {
        0.0
    } else {
        low.abs().min(high.abs())
    };
    let most = low.abs().max(high.abs());
    known([least * least, most * most])
}

fn product(a: Range, b: Range) -> Range {
    let products = [a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]];
    if products.iter().any(|product| product.is_nan()) {
        return ALL;
    }
    [
        products.iter().copied().fold(f64::INFINITY, f64::min),
        products.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    ]
}

fn quotient(a: Range, b: Range) -> Range {
    if b[0] <= 0.0 && b[1] >= 0.0 {
        return ALL;
    }
    product(a, [1.0 / b[1], 1.0 / b[0]])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `sqrt(x^2 + y^2) - p / z`.
    fn kernel() -> Kernel {
        Kernel {
            name: "gap".into(),
            listed: true,
            operations: vec![
                Operation::Input(0),
                Operation::Input(1),
                Operation::Input(2),
                Operation::Parameter(0),
                Operation::Multiply(0, 0),
                Operation::Multiply(1, 1),
                Operation::Add(4, 5),
                Operation::Root(6),
                Operation::Divide(3, 2),
                Operation::Subtract(7, 8),
            ],
            outputs: vec![9],
        }
    }

    #[test]
    fn range_of_a_distance_is_that_of_its_nearest_and_farthest_places() {
        let range = of(&kernel(), &[2.0], (&[-1.0, 3.0, 1.0], &[2.0, 4.0, 4.0]));
        // Nearest (0, 3) less 2 / 1, farthest (2, 4) less 2 / 4.
        assert_eq!(range[0], 1.0);
        assert!((range[1] - (20.0_f64.sqrt() - 0.5)).abs() < 1e-15);
    }

    #[test]
    fn division_by_what_may_vanish_has_any_value() {
        let range = of(&kernel(), &[2.0], (&[0.0, 0.0, -1.0], &[1.0, 1.0, 1.0]));
        assert_eq!(range, ALL);
    }

    #[test]
    fn signs_of_products_are_all_looked_at() {
        assert_eq!(product([-2.0, 3.0], [-5.0, 4.0]), [-15.0, 12.0]);
        assert_eq!(quotient([-2.0, 4.0], [-4.0, -2.0]), [-2.0, 1.0]);
        assert_eq!(square([-2.0, 1.0]), [0.0, 4.0]);
        assert_eq!(square([-3.0, -1.0]), [1.0, 9.0]);
    }
}
