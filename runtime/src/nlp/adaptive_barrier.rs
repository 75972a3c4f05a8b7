//! The adaptive barrier parameter: free mode by the quality function, monotone mode where that makes no progress
//! (Nocedal, Waechter and Waltz, SIAM Journal on Optimization 19, 2009, section 3).
//!
//! In free mode the barrier parameter changes in every iteration and the filter holds nothing to return to, so progress
//! is measured by the optimality error alone: it has to fall below 0.9999 times one of its last four values. Where it
//! does not, the barrier parameter is fixed at 0.8 times the average complementarity and falls by the monotone rule
//! until the error is below the references again.

use super::Status;
use super::quality_function::{MeanSquares, best_centring, mean_square, products};
use super::solver::{Loop, fraction_to_boundary};
use crate::linalg::SolveQuality;

/// Number of errors that progress is measured by.
const REFERENCES: usize = 4;

/// Memory of the adaptive rule.
#[derive(Debug, Clone)]
pub(crate) struct AdaptiveBarrier {
    /// Errors at the last accepted points of the free mode, at most [`REFERENCES`].
    references: Vec<f64>,
    pub(crate) is_free: bool,
    /// Least and greatest barrier parameter; the greatest follows from the first point.
    least: f64,
    greatest: Option<f64>,
}

impl AdaptiveBarrier {
    /// A rule that has seen nothing; `keeps_first` holds on to the first barrier parameter until the error at the first
    /// point is beaten, as a warm start wants it.
    pub(crate) fn new(tolerance: f64, keeps_first: bool) -> Self {
        Self {
            references: Vec::with_capacity(REFERENCES),
            is_free: !keeps_first,
            least: tolerance / 11.0,
            greatest: None,
        }
    }

    /// Whether `error` is below 0.9999 times one of the references, or there are too few of them to tell.
    fn progresses(&self, error: f64) -> bool {
        self.references.len() < REFERENCES || self.references.iter().any(|r| error <= 0.9999 * r)
    }

    fn remember(&mut self, error: f64) {
        if self.references.len() == REFERENCES {
            self.references.remove(0);
        }
        self.references.push(error);
    }

    /// `mu` within the admissible range.
    fn clamped(&self, mu: f64) -> f64 {
        mu.min(self.greatest.unwrap_or(f64::INFINITY))
            .max(self.least)
    }
}

impl Loop<'_, '_, '_, '_> {
    /// Mean squares of the optimality conditions with `mu = 0`.
    pub(crate) fn mean_squares(&self) -> MeanSquares {
        MeanSquares {
            dual: mean_square(self.lagrangian.iter().copied()),
            primal: mean_square(self.values.residual.iter().copied()),
            complementarity: mean_square(products(&self.problem, &self.iterate)),
        }
    }

    /// Average of `distance z` over all bounds; 0 without bounds.
    fn average_complementarity(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0_usize);
        for product in products(&self.problem, &self.iterate) {
            sum += product;
            count += 1;
        }
        if count == 0 { 0.0 } else { sum / count as f64 }
    }

    /// Chooses the mode of the iteration; in free mode the barrier parameter follows in [`Loop::choose_centring`].
    pub(crate) fn update_adaptive_barrier(&mut self) -> Option<Status> {
        let Some(mut adaptive) = self.adaptive.take() else {
            return self.update_barrier();
        };
        let average = self.average_complementarity();
        if adaptive.greatest.is_none() {
            adaptive.greatest = Some((1e3 * average).max(adaptive.least).min(1e5));
        }
        let error = self.mean_squares().sum();
        if !adaptive.is_free && adaptive.references.is_empty() {
            adaptive.references.resize(REFERENCES, error);
        }
        let progresses = adaptive.progresses(error);
        // steps below the resolution of the numbers are the monotone mode's business
        let tiny = self.tiny_steps > 0;
        let mut status = None;
        if progresses && !tiny {
            adaptive.is_free = true;
            adaptive.remember(error);
        } else if adaptive.is_free {
            adaptive.is_free = false;
            self.change_parameters(adaptive.clamped(0.8 * average), self.sigma);
        } else {
            status = self.update_barrier();
        }
        self.adaptive = Some(adaptive);
        status
    }

    /// In free mode, sets the barrier parameter from the factorized Newton matrix and combines its direction from those of
    /// the search; `None` if there is no such direction.
    pub(crate) fn choose_centring(&mut self) -> Option<SolveQuality> {
        let adaptive = self.adaptive.as_ref().filter(|adaptive| adaptive.is_free)?;
        let average = self.average_complementarity();
        if average <= 0.0 {
            return None;
        }
        let squares = self.mean_squares();
        let mut worst: Option<SolveQuality> = None;
        for (mu, direction) in [(0.0, &mut self.correction), (average, &mut self.direction)] {
            let solved = self.core.kkt.direction(
                &self.problem,
                &self.iterate,
                &self.lagrangian,
                &self.values.residual,
                mu,
                direction,
            );
            if solved.residual.is_nan() || solved.residual > 1e-5 {
                return None;
            }
            worst = Some(worst.map_or(solved, |worst| worst.worse(&solved)));
        }
        // the direction is linear in mu
        let (affine, centring) = (&self.correction, &mut self.direction);
        let parts = [
            (&mut centring.v, &affine.v),
            (&mut centring.y, &affine.y),
            (&mut centring.z_lower, &affine.z_lower),
            (&mut centring.z_upper, &affine.z_upper),
        ];
        for (c, a) in parts {
            for (c, a) in c.iter_mut().zip(a) {
                *c -= a;
            }
        }
        let quality = &mut self.quality;
        quality.update(&self.problem, &self.iterate, (affine, centring), squares);
        let clamped = |sigma: f64| adaptive.clamped(sigma * average);
        let mu = clamped(best_centring(|sigma| {
            quality.value(sigma, fraction_to_boundary(clamped(sigma)))
        }));
        let sigma = mu / average;
        let parts = [
            (&mut centring.v, &affine.v),
            (&mut centring.y, &affine.y),
            (&mut centring.z_lower, &affine.z_lower),
            (&mut centring.z_upper, &affine.z_upper),
        ];
        for (c, a) in parts {
            for (c, a) in c.iter_mut().zip(a) {
                *c = a + sigma * *c;
            }
        }
        if mu != self.mu {
            self.change_parameters(mu, self.sigma);
        }
        worst
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progresses_needs_one_of_the_last_four_errors_to_be_beaten() {
        let mut adaptive = AdaptiveBarrier::new(1e-8, false);
        for error in [8.0, 4.0, 2.0, 1.0] {
            assert!(adaptive.progresses(100.0));
            adaptive.remember(error);
        }
        assert!(adaptive.progresses(7.9));
        assert!(!adaptive.progresses(8.0));
        adaptive.remember(1.0);
        // the 8 is forgotten
        assert!(!adaptive.progresses(7.9));
        assert!(adaptive.progresses(3.9));
    }

    #[test]
    fn clamped_keeps_the_floor_and_the_first_ceiling() {
        let mut adaptive = AdaptiveBarrier::new(1.1e-7, false);
        assert_eq!(adaptive.clamped(1e9), 1e9);
        adaptive.greatest = Some(10.0);
        assert_eq!(adaptive.clamped(1e9), 10.0);
        assert!((adaptive.clamped(0.0) - 1e-8).abs() < 1e-20);
    }
}
