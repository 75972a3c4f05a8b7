//! The frame in which a contact in space slides: along the velocity that it had, and across.
//!
//! In the plane a contact slides forward or backward, and stops where its velocity changes the sign. In space it slides along
//! `(v_1, v_2)`, whose size has no sign to change. The mode of the contact therefore knows a direction, that of the sliding at the
//! start of an element; in this frame it slides forward, with `v_1 > 0`, and stops where `v_1` falls through zero. The force acts
//! against the velocity itself,
//!
//! ```text
//! s = -mu r (e_1 + w e_2) / sqrt(1 + w^2)        w = v_2 / v_1
//! ```
//!
//! which goes on smoothly where a straight slide is followed beyond its end: `w` is that of the line, not of its direction. Within
//! rounding error of rest `w` would be a ratio of errors, and is `v_1 v_2 / (v_1^2 + soft^2)`. Where `|v_2| > |v_1|` the motion has
//! turned far from the direction of the frame and does not end there; the force acts against `(v_1, v_2)` as it is.

/// Size of the velocity beside which the direction is rounding error, relative to the largest sliding velocity so far: an error of
/// the motion of its square.
const SOFT: f64 = 1e-8;

/// A direction among two, and below which speed none is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    cos: f64,
    sin: f64,
    /// Speed below which the direction is rounding error.
    pub(crate) soft: f64,
}

impl Default for Frame {
    fn default() -> Self {
        Self {
            cos: 1.0,
            sin: 0.0,
            soft: 0.0,
        }
    }
}

impl Frame {
    /// Takes a pair of numbers, or of vectors, into the frame.
    pub(crate) fn turn(&self, first: &mut [f64], second: &mut [f64]) {
        for (a, b) in first.iter_mut().zip(second) {
            (*a, *b) = (self.cos * *a + self.sin * *b, self.cos * *b - self.sin * *a);
        }
    }

    /// A pair of numbers in the frame as they are outside of it.
    pub(crate) fn outside(&self, (first, second): (f64, f64)) -> (f64, f64) {
        (
            self.cos * first - self.sin * second,
            self.sin * first + self.cos * second,
        )
    }

    /// Turns the frame so that it points along what is `(first, second)` in it.
    pub(crate) fn align(&mut self, (first, second): (f64, f64)) {
        let size = first.hypot(second);
        if size > 0.0 {
            let (cos, sin) = self.outside((first / size, second / size));
            (self.cos, self.sin) = (cos, sin);
        }
    }

    /// Takes note of the largest sliding velocity so far, and of the speed that counts as rest.
    pub(crate) fn measure(&mut self, largest: f64, rest: f64) {
        self.soft = self.soft.max(SOFT * largest).max(10.0 * rest);
    }

    /// The direction in the frame of what slides with this velocity in it, and its derivatives by both velocities.
    pub(crate) fn direction(&self, (first, second): (f64, f64)) -> Slide {
        if second.abs() > first.abs() && first.hypot(second) > self.soft {
            // Far from the direction of the frame there is no end of a slide.
            let size = first.hypot(second);
            let (a, b) = (first / size, second / size);
            return Slide {
                along: a,
                across: b,
                by: [[b * b / size, -a * b / size], [-a * b / size, a * a / size]],
            };
        }
        let square = first * first + self.soft * self.soft;
        if square == 0.0 {
            return Slide {
                along: 1.0,
                across: 0.0,
                by: [[0.0; 2]; 2],
            };
        }
        let lean = first * second / square;
        let (by_first, by_second) = ((second - 2.0 * lean * first) / square, first / square);
        let size = lean.hypot(1.0);
        let turned = 1.0 / (size * size * size);
        Slide {
            along: 1.0 / size,
            across: lean / size,
            by: [
                [-lean * turned * by_first, -lean * turned * by_second],
                [turned * by_first, turned * by_second],
            ],
        }
    }
}

/// Size of a pair, exactly that of its first number where the second is 0.
pub(crate) fn pair_size((first, second): (f64, f64)) -> f64 {
    if second == 0.0 {
        first.abs()
    } else {
        first.hypot(second)
    }
}

/// The direction of a slide in its frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slide {
    pub(crate) along: f64,
    pub(crate) across: f64,
    /// Derivatives of both components (rows) by both velocities.
    pub(crate) by: [[f64; 2]; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn direction_is_that_of_the_velocity_and_goes_on_beyond_the_end_of_a_straight_slide() {
        let mut frame = Frame::default();
        frame.measure(1.0, 0.0);
        for (velocity, wanted) in [
            ((3.0, 0.6), (3.0, 0.6)),
            ((0.3, -0.9), (0.3, -0.9)),
            // Overshot: the line is the same, and so is the force.
            ((-1e-3, -2e-4), (1e-3, 2e-4)),
        ] {
            let slide = frame.direction(velocity);
            let size = f64::hypot(wanted.0, wanted.1);
            // soft^2 beside the square of the velocity.
            let error = 2.0 * (SOFT / velocity.0).powi(2) + 4.0 * f64::EPSILON;
            assert!((slide.along - wanted.0 / size).abs() <= error);
            assert!((slide.across - wanted.1 / size).abs() <= error);
        }
        assert_eq!(frame.direction((0.0, 0.0)).along, 1.0);
    }

    #[test]
    fn derivatives_of_the_direction_agree_with_differences() {
        let mut frame = Frame::default();
        frame.measure(1.0, 0.0);
        for velocity in [(0.8, 0.3), (0.2, -0.9), (-0.4, 0.1)] {
            let by = frame.direction(velocity).by;
            let step = 1e-6;
            for k in 0..2 {
                let moved = |sign: f64| {
                    let mut moved = [velocity.0, velocity.1];
                    moved[k] += sign * step;
                    frame.direction((moved[0], moved[1]))
                };
                let (ahead, behind) = (moved(1.0), moved(-1.0));
                let slopes = [ahead.along - behind.along, ahead.across - behind.across];
                for (row, slope) in slopes.into_iter().enumerate() {
                    // Central differences: the square of the step beside derivatives of the third order below 1e2.
                    assert!((slope / (2.0 * step) - by[row][k]).abs() < 1e-9);
                }
            }
        }
    }
}
