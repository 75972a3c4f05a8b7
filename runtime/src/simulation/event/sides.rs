//! Which sides of switches act that are only passed, where their functions vanish.

use super::dynamics::{Dynamics, Switch};
use crate::contact::Direction;
use crate::contact::passing::{self, Follows, Place};
use crate::model::{Switching, joint_rows, pair_size};
use crate::simulation::problem::{not_unique, second_order};

/// Accelerations below this share of those they balance are compared by what follows a moment later: event
/// times carry rounding error, and the force its rate times that.
pub(super) const BIACTIVE: f64 = 1e-10;
/// Share of a smooth time after which a function is looked at that vanishes with its rate.
const LATER: f64 = 1e-3;

/// The sides of the `passed` switches under a motion: those that are known of each, or all that agree a moment later, which are `chosen` once.
pub(super) fn take_sides(
    dynamics: &mut Dynamics<'_>,
    (t, y, moment): (f64, &[f64], f64),
    (resting, passed): (&[usize], &[usize]),
    (motion, vanished): (&[f64], Option<Switch>),
    chosen: &mut Option<Vec<f64>>,
) -> Result<(), String> {
    let mut slow = false;
    for &i in passed {
        let (_, rate) = dynamics.contact_accelerations(i, motion);
        let known = known_side(dynamics, i, rate, vanished);
        slow |= known.is_none();
        let side = known.unwrap_or_else(|| side_later(dynamics, i, (t, y, moment)));
        dynamics.sides[i] = side.sign();
    }
    if let Some(chosen) = chosen {
        dynamics.sides.clone_from(chosen);
    } else if slow {
        choose_sides(dynamics, (t, y, moment), resting, vanished)?;
        *chosen = Some(dynamics.sides.clone());
    }
    Ok(())
}

/// Whether an evaluated contact with friction does not slide.
pub(super) fn rests_along(
    dynamics: &Dynamics<'_>,
    contact: usize,
    vanished: Option<Switch>,
) -> bool {
    // In space a direction may vanish while the contact slides on across it.
    let stops = matches!(vanished, Some(Switch::SlidingVelocity(other, _)) if other == contact)
        && !dynamics.is_in_space(contact);
    stops || pair_size(dynamics.sliding(contact)) <= dynamics.zero_speed(contact)
}

/// The side of a switch that is only passed, where its function vanishes: the other one of a side that has ended, else that of its
/// rate, if it has one. What a condition has set may have turned its rate, which comes first.
fn known_side(
    dynamics: &Dynamics<'_>,
    contact: usize,
    rate: f64,
    vanished: Option<Switch>,
) -> Option<Direction> {
    let ended = match vanished {
        Some(Switch::SlidingVelocity(other, direction)) if other == contact => {
            Some(direction.reversed())
        }
        _ => None,
    };
    let declared = &dynamics.model.declaration().contacts[contact];
    let sets = declared.switch == Some(Switching::Resets);
    match ended {
        Some(direction) if !sets => Some(direction),
        _ if rate.abs() > BIACTIVE * dynamics.sliding_acceleration_scale(contact) => {
            Some(Direction::of(rate))
        }
        ended => ended,
    }
}

/// The sign of the function of a switch a little later, as its two rates say.
fn side_later(
    dynamics: &mut Dynamics<'_>,
    contact: usize,
    (t, y, moment): (f64, &[f64], f64),
) -> Direction {
    let n = dynamics.n;
    let moment = LATER * moment;
    let a = dynamics.free_acceleration().to_vec();
    let mut later = y.to_vec();
    for k in 0..n {
        later[k] += moment * y[n + k] + 0.5 * moment * moment * a[k];
        later[n + k] += moment * a[k];
    }
    dynamics.load(t + moment, &later);
    dynamics.evaluate_tangent(contact);
    let direction = Direction::of(dynamics.sliding_velocity(contact));
    dynamics.load(t, y);
    dynamics.evaluate_sides(contact);
    direction
}

/// Chooses the sides of the switches that are passed by what agrees a moment later, where the rate of one of them says nothing, or finds
/// that the motion rests.
fn choose_sides(
    dynamics: &mut Dynamics<'_>,
    (t, y, moment): (f64, &[f64], f64),
    resting: &[usize],
    vanished: Option<Switch>,
) -> Result<(), String> {
    let known =
        |i: usize| matches!(vanished, Some(Switch::SlidingVelocity(other, _)) if other == i);
    let open = resting
        .iter()
        .copied()
        .filter(|&i| dynamics.passes(i) && !known(i) && rests_along(dynamics, i, None));
    let passed: Vec<usize> = open.collect();
    if passed.is_empty() || passed.len() > passing::MOST || joint_rows(dynamics.model) > 0 {
        return Ok(());
    }
    let zeros: Vec<f64> = (0..dynamics.contacts)
        .map(|i| dynamics.zero_speed(i))
        .collect();
    let x = dynamics.input().to_vec();
    let rates = rates(dynamics, (t, y));
    let place = Place {
        x: &x,
        rates: &rates,
        touching: resting,
        zeros: &zeros,
        moment: LATER * moment,
    };
    let follows = passing::follows(dynamics, &place, &passed);
    dynamics.load(t, y);
    dynamics.evaluate_free_acceleration();
    resting.iter().for_each(|&i| dynamics.evaluate_sides(i));
    let name = |contact: usize| dynamics.model.declaration().contacts[contact].name;
    match follows {
        Ok(Follows::Several(contact)) => Err(not_unique(name(contact))),
        Ok(Follows::Holds(contact)) => Err(second_order(name(contact))),
        Ok(Follows::Rest(rest)) => {
            dynamics.rest = Some(rest);
            Ok(())
        }
        // Where no force satisfies the law the balance says so.
        Ok(Follows::Sides) | Err(_) => Ok(()),
    }
}

/// Rates of what the model reads besides coordinates and velocities: controls, and the time.
pub(super) fn rates(dynamics: &mut Dynamics<'_>, (t, y): (f64, &[f64])) -> Vec<f64> {
    let n = dynamics.n;
    dynamics.load(t, y);
    let now = dynamics.input()[2 * n..].to_vec();
    dynamics.load(t + 1.0, y);
    let later = dynamics.input()[2 * n..].to_vec();
    dynamics.load(t, y);
    later
        .iter()
        .zip(&now)
        .map(|(later, now)| later - now)
        .collect()
}
