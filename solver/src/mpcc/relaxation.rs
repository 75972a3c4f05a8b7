//! Paths of (barrier parameter, relaxation parameter).

use crate::nlp::{BarrierPath, Level, PathStep, next_barrier_parameter};

/// `max(floor, mu^2 / (mu^2 + 1e-6))`.
pub(crate) fn roll_off(mu: f64, floor: f64) -> f64 {
    let square = mu * mu;
    (square / (square + 1e-6)).max(floor)
}

/// `max(floor, min(1, 10 mu))`.
pub(crate) fn proportional(mu: f64, floor: f64) -> f64 {
    (10.0 * mu).min(1.0).max(floor)
}

/// `sigma` as a function of `mu`, `mu` by the monotone rule.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tied {
    pub(crate) mu: f64,
    /// Upper bound of the first `sigma`.
    pub(crate) sigma: f64,
    pub(crate) tolerance: f64,
    pub(crate) floor: f64,
    pub(crate) rule: fn(f64, f64) -> f64,
}

impl BarrierPath for Tied {
    fn first(&self) -> (f64, f64) {
        (self.mu, (self.rule)(self.mu, self.floor).min(self.sigma))
    }

    fn final_sigma(&self) -> f64 {
        self.floor
    }

    fn update(&mut self, level: &Level) -> PathStep {
        let mu = next_barrier_parameter(level.mu, self.tolerance);
        let sigma = (self.rule)(mu, self.floor).min(level.sigma);
        if level.solved && (mu < level.mu || sigma < level.sigma) {
            PathStep::Advance { mu, sigma }
        } else {
            PathStep::Stay
        }
    }
}

/// Step-controlled continuation in `sigma`.
///
/// `sigma = 1` until the problem with `mu = 1e-3` is solved. Then each solved level is followed by
/// `sigma <- rho sigma`, `mu <- min(mu, 0.1 sigma)`, where `rho` starts at 0.1 and shrinks by 0.4 (to 0.01
/// at least) after a level of at most 5 iterations and grows by 1.8 (to 0.5 at most) after one of more
/// than 12. A level of more than 25 iterations, or with 3 cut steps in a row, is given up for the
/// geometric mean of its `sigma` and the last good one, six times at most.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Continuation {
    mu: f64,
    sigma: f64,
    tolerance: f64,
    floor: f64,
    factor: f64,
    solved_sigma: f64,
    returns: usize,
}

impl Continuation {
    const FIRST_PHASE_END: f64 = 1e-3;

    /// Continuation from `(mu, sigma)` on.
    pub(crate) fn new((mu, sigma): (f64, f64), tolerance: f64, floor: f64) -> Self {
        Self {
            mu,
            sigma,
            tolerance,
            floor,
            factor: 0.1,
            solved_sigma: sigma,
            returns: 0,
        }
    }
}

impl BarrierPath for Continuation {
    fn first(&self) -> (f64, f64) {
        (self.mu, self.sigma)
    }

    fn final_sigma(&self) -> f64 {
        self.floor
    }

    fn update(&mut self, level: &Level) -> PathStep {
        let Level { mu, sigma, .. } = *level;
        if sigma >= 1.0 && mu > Self::FIRST_PHASE_END {
            let mu = next_barrier_parameter(mu, self.tolerance).max(Self::FIRST_PHASE_END);
            return if level.solved {
                PathStep::Advance { mu, sigma }
            } else {
                PathStep::Stay
            };
        }
        if level.solved {
            if sigma <= self.floor {
                let next = next_barrier_parameter(mu, self.tolerance);
                return if next < mu {
                    PathStep::Advance { mu: next, sigma }
                } else {
                    PathStep::Stay
                };
            }
            if sigma < 1.0 {
                if level.iterations <= 5 {
                    self.factor = (0.4 * self.factor).max(0.01);
                } else if level.iterations > 12 {
                    self.factor = (1.8 * self.factor).min(0.5);
                }
            }
            self.solved_sigma = sigma;
            let sigma = (self.factor * sigma).max(self.floor);
            let mu = mu.min(0.1 * sigma).max(self.tolerance / 11.0);
            return PathStep::Advance { mu, sigma };
        }
        let lost = level.iterations > 25 || level.jams >= 3;
        if lost && self.returns < 6 && sigma < 0.9 * self.solved_sigma {
            self.returns += 1;
            self.factor = self.factor.sqrt().min(0.5);
            let sigma = (sigma * self.solved_sigma).sqrt();
            let mu = (0.1 * sigma).max(self.tolerance / 11.0);
            return PathStep::Return { mu, sigma };
        }
        PathStep::Stay
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(mu: f64, sigma: f64, solved: bool, iterations: usize) -> Level {
        Level {
            mu,
            sigma,
            solved,
            iterations,
            jams: 0,
        }
    }

    #[test]
    fn roll_off_is_near_one_above_and_quadratic_below_a_thousandth() {
        assert!((roll_off(0.1, 1e-8) - 0.01 / 0.010001).abs() < 1e-15);
        assert_eq!(roll_off(1e-3, 1e-8), 0.5);
        assert!((roll_off(1e-5, 1e-8) - 1e-4).abs() < 1e-7);
        assert_eq!(roll_off(1e-9, 1e-8), 1e-8);
    }

    #[test]
    fn continuation_fast_level_shortens_and_slow_level_lengthens_the_next() {
        let mut path = Continuation::new((0.1, 1.0), 1e-8, 1e-8);
        let first = path.update(&level(1e-3, 1.0, true, 40));
        assert_eq!(
            first,
            PathStep::Advance {
                mu: 1e-3,
                sigma: 0.1
            }
        );
        let PathStep::Advance { sigma, .. } = path.update(&level(1e-3, 0.1, true, 3)) else {
            panic!("a solved level advances");
        };
        assert!((sigma - 0.1 * 0.04).abs() < 1e-15);
        let PathStep::Advance { sigma, .. } = path.update(&level(1e-4, 4e-3, true, 20)) else {
            panic!("a solved level advances");
        };
        assert!((sigma - 4e-3 * 0.072).abs() < 1e-15);
    }

    #[test]
    fn continuation_lost_level_returns_to_the_geometric_mean_at_most_six_times() {
        let mut path = Continuation::new((0.1, 1.0), 1e-8, 1e-8);
        path.update(&level(1e-3, 1.0, true, 40));
        path.update(&level(1e-3, 1e-2, true, 10));
        for _ in 0..6 {
            let PathStep::Return { sigma, .. } = path.update(&level(1e-4, 1e-4, false, 26)) else {
                panic!("a lost level returns");
            };
            assert!((sigma - 1e-3).abs() < 1e-15);
        }
        assert_eq!(path.update(&level(1e-4, 1e-4, false, 26)), PathStep::Stay);
    }

    #[test]
    fn tied_at_the_floor_of_both_stays() {
        let mut path = Tied {
            mu: 0.1,
            sigma: 1.0,
            tolerance: 1.1e-8,
            floor: 1e-8,
            rule: proportional,
        };
        assert_eq!(
            path.update(&level(1.1e-8 / 11.0, 1e-8, true, 1)),
            PathStep::Stay
        );
    }
}
