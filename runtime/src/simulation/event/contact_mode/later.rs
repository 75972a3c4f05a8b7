//! What the forces and accelerations of undecided contacts are a moment later.

use crate::contact::ContactState;
use crate::simulation::event::dop853::Dop853;
use crate::simulation::event::dynamics::{Dynamics, motion, switching};

/// Forces and accelerations below this share of the terms they are sums of may be rounding error.
const NOISE: f64 = 1e-13;

/// A closed contact at rest in its normal direction, with the states that are possible.
pub(super) struct Candidate {
    pub(super) contact: usize,
    /// In order of preference.
    pub(super) states: Vec<ContactState>,
    /// What rounding error may have left of the accelerations that decide.
    pub(super) remainder: f64,
    /// Whether its sliding velocity is zero now.
    pub(super) stops: bool,
}

/// Sign of the smallest of the forces (of held contacts) and accelerations (of released ones).
pub(super) enum Sign {
    Positive,
    Zero,
    Negative,
}

/// Accepts the forces of the mode after a time `delta`.
pub(super) fn accept_after(
    dynamics: &mut Dynamics<'_>,
    probe: &mut Dop853,
    (t, y): (f64, &[f64]),
    delta: f64,
) {
    if stepped(dynamics, probe, (t, y), delta) {
        switching::accept_forces(dynamics);
    }
}

/// Takes a step of length `delta` in the mode of `dynamics`; whether that can be held.
fn stepped(
    dynamics: &mut Dynamics<'_>,
    probe: &mut Dop853,
    (t, y): (f64, &[f64]),
    delta: f64,
) -> bool {
    let mut start = y.to_vec();
    if !motion::project(dynamics, t, &mut start) {
        return false;
    }
    probe.begin(dynamics, t, &start);
    probe.step(dynamics, t, &start, delta);
    let held = motion::project(dynamics, t + delta, probe.end_mut());
    if held {
        probe.finish(dynamics, t, delta);
    }
    held
}

/// Looks at undecided contacts after a time `delta` in the mode of `dynamics`; `multiple` of their remainders
/// count as noise.
pub(super) fn sign_after(
    dynamics: &mut Dynamics<'_>,
    probe: &mut Dop853,
    (t, y): (f64, &[f64]),
    undecided: &[&Candidate],
    delta: f64,
    multiple: f64,
) -> Sign {
    let Some(signs) = signs_after(dynamics, probe, (t, y), undecided, delta, multiple) else {
        return Sign::Negative;
    };
    let any = |what: fn(&Sign) -> bool| signs.iter().any(what);
    if any(|sign| matches!(sign, Sign::Negative)) {
        Sign::Negative
    } else if any(|sign| matches!(sign, Sign::Zero)) {
        Sign::Zero
    } else {
        Sign::Positive
    }
}

/// The sign of each; `None` where the mode cannot be held.
pub(super) fn signs_after(
    dynamics: &mut Dynamics<'_>,
    probe: &mut Dop853,
    (t, y): (f64, &[f64]),
    undecided: &[&Candidate],
    delta: f64,
    multiple: f64,
) -> Option<Vec<Sign>> {
    if !stepped(dynamics, probe, (t, y), delta) {
        return None;
    }
    let n = dynamics.n;
    let accelerations = probe.end_slope()[n..2 * n].to_vec();
    let signs = undecided.iter().map(|candidate| {
        let i = candidate.contact;
        dynamics.evaluate_sides(i);
        let (normal, tangential) = dynamics.contact_accelerations(i, &accelerations);
        // What the others hold has no acceleration that could tell.
        if dynamics.state(i).is_open() && motion::keeps_apart(dynamics, i) {
            return Sign::Positive;
        }
        let value = match dynamics.state(i) {
            ContactState::Open => normal,
            ContactState::Stick | ContactState::StickInSpace => {
                dynamics.normal_force(i).min(dynamics.friction_reserve(i))
            }
            ContactState::Slip(direction) if candidate.stops => {
                dynamics.normal_force(i).min(direction.sign() * tangential)
            }
            ContactState::Slip(_) | ContactState::Frictionless | ContactState::Held(_) => {
                dynamics.normal_force(i)
            }
        };
        let mut scale = dynamics.normal_acceleration_scale(i);
        if dynamics.has_friction(i) {
            scale = scale.max(dynamics.sliding_acceleration_scale(i));
        }
        let noise = (multiple * candidate.remainder).max(NOISE * scale);
        if value < -noise || value.is_nan() {
            Sign::Negative
        } else if value <= noise {
            Sign::Zero
        } else {
            Sign::Positive
        }
    });
    Some(signs.collect())
}
