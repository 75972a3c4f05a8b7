//! A function that is known by its values alone, such as a contact force: polynomials through some of them, on parts that are halved
//! until each tells the values at other places.

use super::crossing::Bounded;
use super::path::Path;
use super::range::Range;
use crate::yardstick;

/// Degree of the polynomials.
const DEGREE: usize = 8;
/// Places of a part at which its polynomial is compared with the function: at no simple share of it, so that what repeats itself does
/// not look like something slow.
const ODD: [f64; 3] = [0.137, 0.484, 0.829];
/// Most parts. Chosen: a function that varies within a hundredth of a step is none of that step.
const MOST_PARTS: usize = 64;

/// A function between two places.
pub(crate) struct Interpolant<F> {
    value: F,
    parts: Vec<Part>,
}

struct Part {
    ends: [f64; 2],
    path: Path,
    /// What it misses at other places.
    error: f64,
}

impl<F: FnMut(f64) -> f64> Interpolant<F> {
    /// A function on the interval between these places.
    pub(crate) fn new(mut value: F, ends: [f64; 2]) -> Self {
        let mut parts: Vec<Part> = Vec::new();
        let mut open = vec![ends];
        while let Some([from, to]) = open.pop() {
            let width = to - from;
            let mut path = Path::new(DEGREE);
            path.follow(1, |share, out| out[0] = value(from + share * width));
            let range = path.range(0, [0.0, 1.0]);
            let missed =
                ODD.map(|share| (value(from + share * width) - path.value(0, share)).abs());
            let error = missed.into_iter().fold(0.0, f64::max);
            let resolved = error <= yardstick::PROMISE * range.size().high;
            if resolved || parts.len() + open.len() + 2 > MOST_PARTS {
                let ends = [from, to];
                parts.push(Part { ends, path, error });
            } else {
                let middle = 0.5 * (from + to);
                open.push([middle, to]);
                open.push([from, middle]);
            }
        }
        Self { value, parts }
    }

    /// What each part that overlaps another one says of that.
    fn over(&self, [from, to]: [f64; 2], of: impl Fn(&Part, [f64; 2], f64) -> Range) -> Range {
        let touched = self
            .parts
            .iter()
            .filter(|part| part.ends[0] <= to && from <= part.ends[1]);
        let ranges = touched.map(|part| {
            let width = part.ends[1] - part.ends[0];
            let share = |at: f64| ((at - part.ends[0]) / width).clamp(0.0, 1.0);
            of(part, [share(from), share(to)], width)
        });
        ranges.reduce(Range::with).unwrap_or(Range::ALL)
    }
}

impl<F: FnMut(f64) -> f64> Bounded for Interpolant<F> {
    fn value(&mut self, at: f64) -> f64 {
        (self.value)(at)
    }

    fn range(&mut self, part: [f64; 2]) -> Range {
        self.over(part, |known, shares, _| {
            known.path.range(0, shares) + Range::between(-known.error, known.error)
        })
    }

    fn slopes(&mut self, part: [f64; 2]) -> [Range; 2] {
        // Markov's inequality: slopes of an error that is a polynomial of this degree, on an interval of length 1.
        let square = (DEGREE * DEGREE) as f64;
        let factors = [2.0 * square, 4.0 * square * (square - 1.0) / 3.0];
        [1, 2].map(|order| {
            self.over(part, |known, shares, width| {
                let error = factors[order - 1] * known.error;
                let slope = known.path.derivative(0, order, shares) + Range::between(-error, error);
                slope.scaled(width.powi(-(order as i32)))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::crossing::{Crossing, Sample, first_crossing};
    use super::*;

    #[test]
    fn narrow_dip_of_a_smooth_function_is_found() {
        for (width, depth) in [(0.3, 1e-2), (0.03, 1e-3), (0.3, 1e-9)] {
            let f = move |x: f64| 1.0 - (1.0 + depth) / (1.0 + ((x - 0.3141) / width).powi(2));
            let [from, to] = [0.0, 1.0].map(|at| Sample { at, value: f(at) });
            let mut asked = 0;
            let mut known = Interpolant::new(
                |x| {
                    asked += 1;
                    f(x)
                },
                [0.0, 1.0],
            );
            let Crossing::Between(left, right) = first_crossing(&mut known, from, to, 1e-14) else {
                panic!("missed {width} {depth}");
            };
            assert!(
                left.value >= 0.0 && right.value < 0.0 && right.at < 0.3141 + width * depth.sqrt()
            );
            assert!(asked < 1000, "{asked}");
        }
    }
}
