//! Bounds and their multipliers kept apart from zero.

use super::state::State;
use crate::nlp::program::iterate::{Iterate, safeguarded};

/// Bound multipliers near `mu / distance`; bounds moved away from points that reached them by
/// rounding.
pub(super) fn safeguard(state: &mut State<'_, '_, '_, '_>) {
    let mu = state.mu;
    let Iterate {
        v,
        z_lower,
        z_upper,
        ..
    } = &mut state.point.iterate;
    let mut moved = false;
    let lower = state.problem.lower.iter_mut().zip(z_lower);
    let upper = state.problem.upper.iter_mut().zip(z_upper);
    for ((&v, (lower, z_lower)), (upper, z_upper)) in v.iter().zip(lower).zip(upper) {
        if lower.is_finite() {
            let room = room(*lower, v - *lower, mu);
            if room > 0.0 {
                *lower = v - room;
                moved = true;
            }
            *z_lower = safeguarded(*z_lower, v - *lower, mu);
        }
        if upper.is_finite() {
            let room = room(*upper, *upper - v, mu);
            if room > 0.0 {
                *upper = v + room;
                moved = true;
            }
            *z_upper = safeguarded(*z_upper, *upper - v, mu);
        }
    }
    if moved {
        state.point.values.barrier = None;
    }
    if !state.is_restoration {
        for (k, slack) in state.problem.slacks.iter().enumerate() {
            if slack.row >= state.problem.m {
                state.point.iterate.y[slack.row] = state.point.iterate.z_lower[state.problem.n + k];
            }
        }
    }
}

/// Distance that a bound is moved away from a point which reached it by rounding; 0 if it did not.
fn room(bound: f64, distance: f64, mu: f64) -> f64 {
    let smallest = f64::EPSILON * bound.abs().max(mu.min(1.0) * 1e-4);
    if distance <= smallest {
        (f64::EPSILON.powf(0.75) * bound.abs().max(1.0)).max(smallest)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_is_left_where_rounding_reached_the_bound_and_nowhere_else() {
        assert_eq!(room(3.0, 1e-12, 0.1), 0.0);
        // closer than the spacing of the numbers: eps^(3/4) of the bound
        let moved = room(3.0, 1e-16, 0.1);
        assert!((moved / (3.0 * f64::EPSILON.powf(0.75)) - 1.0).abs() < 1e-12);
        assert_eq!(room(0.0, 1e-25, 1e-9), 0.0);
        assert!(room(0.0, 0.0, 1e-9) > 0.0);
    }
}
