//! The size of a scene: how far its goals ask coordinates to go.
//!
//! Motions that programs start from have sizes of their own, some none at all: one that rests says nothing of the lengths in which a
//! scene is meant, and one under random controls may go a million times as far as the goal. Goals say it for all of them.

use crate::model::Model;
use crate::ocp::motion::targets::targets;
use crate::ocp::problem::Problem;

/// What goals ask of each coordinate, in its unit.
#[derive(Debug, Clone)]
pub(in crate::ocp) struct Scale {
    /// The larger of where it starts and where it has to end; 0 where no goal moves it.
    pub(in crate::ocp) sizes: Vec<f64>,
    /// How far that is from where it starts; 0 where no goal moves it.
    pub(in crate::ocp) ways: Vec<f64>,
}

impl Scale {
    /// The scale of a problem, which no guess changes.
    pub(in crate::ocp) fn of(model: &dyn Model, problem: &Problem) -> Self {
        let targets = targets(problem, model);
        let both = || targets.iter().zip(&problem.q);
        let asked = |of: fn(f64, f64) -> f64| {
            let asked =
                both().map(move |(target, start)| target.map_or(0.0, |target| of(target, *start)));
            asked.collect()
        };
        Self {
            sizes: asked(|target, start| target.abs().max(start.abs())),
            ways: asked(|target, start| (target - start).abs()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Scale;
    use crate::ocp::problem::Problem;

    crate::model! {
        /// A cart that is to be somewhere, beside one that is not.
        Sent {
            parameters { far: m = 1 }
            coordinates { x: m, y: m }
            controls { u: N in -1..=1 }
            lagrangian (dot(x)^2 + dot(y)^2)/2*1[kg]
            forces { x: u }
            minimize integral(u^2)
            finally { x == far, dot(x) == 0 }
            start { y: 5 [m] }
            horizon 1 [s]
        }
    }

    #[test]
    fn goals_say_how_far_a_coordinate_goes_however_near_that_is() {
        for far in [3e-14, 7e-9, 2e-3, 0.5, 40.0, 6e9] {
            let sent = Sent { far };
            let scale = Scale::of(&sent, &Problem::of(&sent, 4));
            assert!(
                (scale.ways[0] / far - 1.0).abs() < 1e-9,
                "{far}: {:?}",
                scale.ways
            );
            assert_eq!(scale.ways[1], 0.0);
            assert_eq!(scale.sizes[1], 0.0);
        }
    }
}
