//! How barrier and relaxation parameter fall.

/// What a path is told in each iteration.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Level {
    /// Barrier parameter and relaxation parameter of the current problem.
    pub(crate) mu: f64,
    pub(crate) sigma: f64,
    /// Whether the current problem is solved to `10 mu`, or cannot be improved further.
    pub(crate) solved: bool,
    /// Iterations spent on the current problem, and how many of them in a row were cut short at an
    /// infeasible point.
    pub(crate) iterations: usize,
    pub(crate) jams: usize,
}

/// What a path decides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PathStep {
    /// Go on with the current problem.
    Stay,
    /// Go on to the next problem; the current point is kept for a return.
    Advance { mu: f64, sigma: f64 },
    /// Go back to the kept point and try these parameters.
    Return { mu: f64, sigma: f64 },
}

/// A rule for (mu, sigma).
pub(crate) trait BarrierPath {
    /// First parameters.
    fn first(&self) -> (f64, f64);
    /// Value of `sigma` at which a point may be called a solution.
    fn final_sigma(&self) -> f64;
    /// Decision at a level.
    fn update(&mut self, level: &Level) -> PathStep;
}

/// Next barrier parameter of the monotone rule, `max(tol / 11, min(0.2 mu, mu^1.5))`.
pub(crate) fn next_barrier_parameter(mu: f64, tolerance: f64) -> f64 {
    (tolerance / 11.0).max((0.2 * mu).min(mu.powf(1.5)))
}

/// The monotone rule with a fixed `sigma`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Monotone {
    pub(crate) mu: f64,
    pub(crate) sigma: f64,
    pub(crate) tolerance: f64,
}

impl BarrierPath for Monotone {
    fn first(&self) -> (f64, f64) {
        (self.mu, self.sigma)
    }

    fn final_sigma(&self) -> f64 {
        self.sigma
    }

    fn update(&mut self, level: &Level) -> PathStep {
        let mu = next_barrier_parameter(level.mu, self.tolerance);
        if level.solved && mu < level.mu {
            PathStep::Advance {
                mu,
                sigma: level.sigma,
            }
        } else {
            PathStep::Stay
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn next_barrier_parameter_is_linear_then_superlinear_then_floored() {
        assert!((next_barrier_parameter(0.1, 1e-8) - 0.02).abs() < 1e-17);
        assert!((next_barrier_parameter(1e-4, 1e-8) - 1e-6).abs() < 1e-18);
        assert_eq!(next_barrier_parameter(1e-9, 1e-8), 1e-8 / 11.0);
    }

    #[test]
    fn monotone_at_the_floor_stays() {
        let mut path = Monotone {
            mu: 0.1,
            sigma: 0.0,
            tolerance: 1.1e-8,
        };
        let level = Level {
            mu: 1.1e-8 / 11.0,
            sigma: 0.0,
            solved: true,
            iterations: 3,
            jams: 0,
        };
        assert_eq!(path.update(&level), PathStep::Stay);
    }
}
