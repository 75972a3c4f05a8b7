//! Functions given by points: natural quintic splines.
//!
//! Through `n >= 3` points goes one function whose square of the third derivative has the least integral. It is a quintic
//! between two points, has four continuous derivatives, and goes on beyond its ends as the parabolas that fit them, with
//! four continuous derivatives as well. Slopes and curvatures at the points follow from a linear system that is symmetric,
//! positive definite and banded.
//!
//! Source: Reinsch, *Smoothing by spline functions* (1967), for natural splines of odd degree as minimizers.

use std::cmp::Ordering;
use std::hash::{Hash, Hasher};
use std::sync::Mutex;

/// A derivative of a function given by points.
#[derive(Debug, Clone, Copy)]
pub struct Profile {
    spline: &'static Spline,
    order: u8,
}

/// A function given by points.
#[derive(Debug)]
pub struct Spline {
    /// Splines of a scene are the same if their numbers are.
    number: usize,
    name: &'static str,
    /// Places from which polynomials in the distance from there hold, constant first. The first of them holds in front of
    /// all places.
    pieces: &'static [(f64, [f64; 6])],
}

/// A spline with its points.
type Known = (Vec<(f64, f64)>, &'static Spline);

/// All splines of the program: derived functions refer to them for as long as they live, and the same points give the same
/// spline again.
static SPLINES: Mutex<Vec<Known>> = Mutex::new(Vec::new());

impl Spline {
    /// The one called `name` among those of a scene by its `number`: polynomials in the distance from the places where they begin
    /// to hold, constant first; the first of them holds in front of all places.
    #[must_use]
    pub const fn new(
        number: usize,
        name: &'static str,
        pieces: &'static [(f64, [f64; 6])],
    ) -> Self {
        Self {
            number,
            name,
            pieces,
        }
    }
}

impl Profile {
    /// The derivative of this order of a spline; 0 for the function itself.
    #[must_use]
    pub const fn of(spline: &'static Spline, order: u8) -> Self {
        Self { spline, order }
    }

    /// The function called `name` through at least three points whose first numbers increase.
    pub(crate) fn new(name: &str, points: Vec<(f64, f64)>) -> Self {
        // A thread that panics while it holds the list leaves it whole.
        let mut known = SPLINES
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        let same = known
            .iter()
            .find(|(of, spline)| spline.name == name && *of == points);
        let spline = match same {
            Some((_, spline)) => *spline,
            None => {
                let spline: &'static Spline = Box::leak(Box::new(Spline {
                    number: known.len(),
                    name: String::leak(name.to_owned()),
                    pieces: Vec::leak(pieces(&points)),
                }));
                known.push((points, spline));
                spline
            }
        };
        Self { spline, order: 0 }
    }

    /// Its derivative.
    pub(super) fn derivative(self) -> Self {
        Self {
            order: self.order.saturating_add(1),
            ..self
        }
    }

    /// Which derivative of the function it is; 0 for the function itself.
    #[must_use]
    pub fn order(self) -> u8 {
        self.order
    }

    /// The name of the function.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.spline.name
    }

    /// Places from which polynomials in the distance from there hold, constant first; the first of them holds in front of
    /// all places.
    #[must_use]
    pub fn pieces(self) -> &'static [(f64, [f64; 6])] {
        self.spline.pieces
    }

    /// The value at `x`.
    #[must_use]
    pub fn value(self, x: f64) -> f64 {
        piecewise(self.spline.pieces, usize::from(self.order), x)
    }

    fn key(self) -> (usize, u8) {
        (self.spline.number, self.order)
    }
}

/// Value of the derivative of this `order` of a function given by points: polynomials in the distance from the places where
/// they begin to hold, constant first; the first of them holds in front of all places.
#[must_use]
pub fn piecewise(pieces: &[(f64, [f64; 6])], order: usize, x: f64) -> f64 {
    let Some((_, behind)) = pieces.split_first() else {
        return f64::NAN;
    };
    let (from, coefficients) = pieces[behind.partition_point(|piece| piece.0 <= x)];
    let mut value = 0.0;
    for power in (order..coefficients.len()).rev() {
        let factor: f64 = (power - order + 1..=power).map(|k| k as f64).product();
        value = value * (x - from) + factor * coefficients[power];
    }
    value
}

impl PartialEq for Profile {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Profile {}

impl Hash for Profile {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.key().hash(state);
    }
}

impl PartialOrd for Profile {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Profile {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key().cmp(&other.key())
    }
}

/// The quintic between two points a distance `h` apart, in terms of slope and curvature at both, `(m_0, k_0, m_1, k_1, 1)`:
/// its coefficients of the third, fourth and fifth power of the share of the way.
fn leading(h: f64, rise: f64) -> [[f64; 5]; 3] {
    let square = h * h;
    [
        [-6.0 * h, -1.5 * square, -4.0 * h, 0.5 * square, 10.0 * rise],
        [8.0 * h, 1.5 * square, 7.0 * h, -square, -15.0 * rise],
        [-3.0 * h, -0.5 * square, -3.0 * h, 0.5 * square, 6.0 * rise],
    ]
}

/// Slopes and curvatures at all points, `(m_0, k_0, m_1, k_1, ...)`, for which the integral of the square of the third
/// derivative is least: third and fourth derivatives do not jump, and vanish at the ends.
fn slopes(points: &[(f64, f64)]) -> Vec<f64> {
    let n = 2 * points.len();
    // Entry `d` of row `i` belongs to column `i - d`.
    let mut matrix = vec![[0.0_f64; 4]; n];
    let mut right = vec![0.0; n];
    for (i, pair) in points.windows(2).enumerate() {
        let h = pair[1].0 - pair[0].0;
        let [c3, c4, c5] = leading(h, pair[1].1 - pair[0].1);
        let combined = |third: f64, fourth: f64, fifth: f64, k: usize| {
            third * c3[k] + fourth * c4[k] + fifth * c5[k]
        };
        let cube = h * h * h;
        // Fourth derivative in front, third in front with the other sign, and the same behind with the other signs.
        let rows = [
            (0.0, 24.0 / (cube * h), 0.0),
            (-6.0 / cube, 0.0, 0.0),
            (0.0, -24.0 / (cube * h), -120.0 / (cube * h)),
            (6.0 / cube, 24.0 / cube, 60.0 / cube),
        ];
        for (row, (third, fourth, fifth)) in rows.into_iter().enumerate() {
            for column in 0..=row {
                matrix[2 * i + row][row - column] += combined(third, fourth, fifth, column);
            }
            right[2 * i + row] -= combined(third, fourth, fifth, 4);
        }
    }
    // L D L' in place, then both substitutions.
    for i in 0..n {
        for d in (1..=i.min(3)).rev() {
            let j = i - d;
            for e in d + 1..=i.min(3) {
                let k = i - e;
                matrix[i][d] -= matrix[i][e] * matrix[k][0] * matrix[j][j - k];
            }
            matrix[i][d] /= matrix[j][0];
        }
        for d in 1..=i.min(3) {
            matrix[i][0] -= matrix[i][d] * matrix[i][d] * matrix[i - d][0];
            right[i] -= matrix[i][d] * right[i - d];
        }
    }
    for i in (0..n).rev() {
        right[i] /= matrix[i][0];
        for d in 1..4.min(n - i) {
            right[i] -= matrix[i + d][d] * right[i + d];
        }
    }
    right
}

fn pieces(points: &[(f64, f64)]) -> Vec<(f64, [f64; 6])> {
    let slopes = slopes(points);
    let parabola = |i: usize| {
        let (x, y) = points[i];
        (
            x,
            [y, slopes[2 * i], 0.5 * slopes[2 * i + 1], 0.0, 0.0, 0.0],
        )
    };
    let mut pieces = vec![parabola(0)];
    for (i, pair) in points.windows(2).enumerate() {
        let h = pair[1].0 - pair[0].0;
        let ends = &slopes[2 * i..2 * i + 4];
        let (x, mut coefficients) = parabola(i);
        let leading = leading(h, pair[1].1 - pair[0].1);
        for (power, form) in leading.iter().enumerate() {
            let value: f64 = form.iter().zip(ends).map(|(a, b)| a * b).sum();
            coefficients[3 + power] = (value + form[4]) / h.powi(3 + power as i32);
        }
        pieces.push((x, coefficients));
    }
    pieces.push(parabola(points.len() - 1));
    pieces
}

#[cfg(test)]
mod tests {
    use super::Profile;

    fn through(places: &[f64], f: impl Fn(f64) -> f64) -> Profile {
        Profile::new("h", places.iter().map(|&x| (x, f(x))).collect())
    }

    fn derivatives(mut profile: Profile, x: f64) -> [f64; 6] {
        [(); 6].map(|()| {
            let value = profile.value(x);
            profile = profile.derivative();
            value
        })
    }

    const PLACES: [f64; 7] = [-1.0, -0.7, 0.1, 0.5, 1.3, 1.5, 2.4];

    #[test]
    fn parabola_through_points_is_itself_everywhere() {
        let profile = through(&PLACES, |x| 1.0 - 2.0 * x + 0.5 * x * x);
        for x in [-3.0, -1.0, -0.3, 0.5, 1.4, 2.4, 7.0] {
            let [value, slope, curvature, third, ..] = derivatives(profile, x);
            let expected = 1.0 - 2.0 * x + 0.5 * x * x;
            assert!((value - expected).abs() < 1e-12, "{x}: {value}");
            assert!((slope - (x - 2.0)).abs() < 1e-12 && (curvature - 1.0).abs() < 1e-11);
            assert!(third.abs() < 1e-10);
        }
    }

    #[test]
    fn four_derivatives_are_continuous_at_every_point_and_the_values_are_met() {
        let profile = through(&PLACES, |x| (2.0 * x).sin() + 0.3 * x);
        for x in PLACES {
            assert!((profile.value(x) - (2.0 * x).sin() - 0.3 * x).abs() < 1e-14);
            let step = 1e-9;
            let (before, after) = (
                derivatives(profile, x - step),
                derivatives(profile, x + step),
            );
            for k in 0..5 {
                // The next derivative times the distance, and roundings of the system.
                let off = (before[k] - after[k]).abs();
                let bound = 2.1
                    * step
                    * before[k + 1..]
                        .iter()
                        .chain(&after[k + 1..])
                        .fold(1.0, |a: f64, b| a.max(b.abs()));
                assert!(off < bound + 1e-10, "derivative {k} at {x}: {off:e}");
            }
        }
        // Beyond the ends nothing but the parabolas.
        for x in [-1.5, 3.0] {
            assert_eq!(derivatives(profile, x)[3..], [0.0; 3]);
        }
    }

    #[test]
    fn error_inside_falls_with_the_sixth_power_of_the_distance_of_points() {
        let error = |count: usize| {
            let places: Vec<f64> = (0..=count).map(|i| 8.0 * i as f64 / count as f64).collect();
            let profile = through(&places, f64::sin);
            let inside = (0..200).map(|i| 3.0 + 2.0 * f64::from(i) / 200.0);
            inside.fold(0.0, |e: f64, x| e.max((profile.value(x) - x.sin()).abs()))
        };
        let (coarse, fine) = (error(20), error(40));
        assert!(coarse < 1e-4 && coarse / fine > 40.0, "{coarse:e} {fine:e}");
    }

    #[test]
    fn same_points_are_the_same_function() {
        let [one, other] = [(); 2].map(|()| through(&PLACES, f64::cos));
        assert_eq!(one, other);
        assert_ne!(one, through(&PLACES, f64::sin));
        assert_ne!(one, one.derivative());
    }
}
