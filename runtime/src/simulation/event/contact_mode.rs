//! Which contacts are active right after an instant: the impact law, then the complementarity of gaps
//! and normal contact accelerations, then, where both vanish, of what follows a moment later.

use super::dop853::Dop853;
use super::dynamics::{Dynamics, dot, largest};
use super::lcp::{self, LcpSolution};
use crate::model::contact_point;

/// Normal contact accelerations below this share of the accelerations they balance are compared by
/// what follows a moment later: event times carry rounding error, and the force its rate times that.
const BIACTIVE: f64 = 1e-10;
/// Shares of the step size after which biactive contacts are looked at, with the multiple of the force now
/// that a force then must exceed: the earliest moment that shows more than rounding error belongs to the
/// leading derivative. If none does, force or acceleration are constant, and what there is now counts.
const MOMENTS: [(f64, f64); 7] = [
    (1e-6, 4.0),
    (1e-5, 4.0),
    (1e-4, 4.0),
    (1e-3, 4.0),
    (1e-2, 4.0),
    (1e-1, 4.0),
    (1e-1, 0.0),
];
/// Forces and accelerations below this share of the terms they are sums of may be rounding error.
const NOISE: f64 = 1e-13;
/// Flights lower than this times `max(1, |q|)` are none: a gap is known to about this. It ends the
/// geometric sequence of impacts of, for example, a rocking block.
const LOWEST_FLIGHT: f64 = 1e-14;
/// Two solutions of the impact law are one if their velocities agree to this relative accuracy.
const SAME: f64 = 1e-8;

/// Why no contact mode could be found.
#[derive(Debug, Clone)]
pub(in crate::simulation) struct Undetermined {
    pub(in crate::simulation) contact: usize,
    pub(in crate::simulation) message: String,
}

/// Outcome of the impact law.
#[derive(Debug, Clone, Default)]
pub(in crate::simulation) struct Impact {
    /// Contacts whose gap closed with a velocity, increasing.
    pub(in crate::simulation) struck: Vec<usize>,
    /// Closed contacts that are at rest afterwards, or whose next flight is too low to be one,
    /// increasing.
    pub(in crate::simulation) resting: Vec<usize>,
    /// Largest of the impulses `p_i`, in units of a normal velocity.
    pub(in crate::simulation) impulse: f64,
}

/// Applies Moreau's impact law to the velocities in `y`: for all closed contacts at once
/// `0 <= p _|_ v_n + D p >= 0`, `v+ = v- + sum_i d_i p_i`. `closing` counts as closed whatever its gap.
///
/// Source: Moreau, *Unilateral contact and dry friction in finite freedom dynamics* (1988), with
/// restitution 0.
pub(in crate::simulation) fn impact(
    dynamics: &mut Dynamics<'_>,
    t: f64,
    y: &mut [f64],
    closing: Option<usize>,
) -> Result<Impact, Undetermined> {
    let n = dynamics.n;
    let (closed_gap, zero_velocity) = (dynamics.closed_gap(y), dynamics.zero_velocity(y));
    dynamics.load(t, y);
    let mut closed = Vec::new();
    for i in 0..dynamics.contacts {
        dynamics.evaluate_contact(i);
        let gap = dynamics.point(i)[contact_point::GAP];
        if gap <= closed_gap || closing == Some(i) || dynamics.is_active(i) {
            closed.push(i);
        }
    }
    let mut velocities: Vec<f64> = closed
        .iter()
        .map(|&i| dynamics.point(i)[contact_point::NORMAL_VELOCITY])
        .collect();
    let mut outcome = Impact {
        struck: closed
            .iter()
            .zip(&velocities)
            .filter(|&(_, &velocity)| velocity < -zero_velocity)
            .map(|(&i, _)| i)
            .collect(),
        ..Impact::default()
    };
    if let Some(&contact) = outcome.struck.first() {
        for velocity in &mut velocities {
            if velocity.abs() <= zero_velocity {
                *velocity = 0.0;
            }
        }
        let solution = solve(dynamics, &closed, &velocities, "impact")
            .map_err(|message| Undetermined { contact, message })?;
        for (&i, p) in closed.iter().zip(&solution.z) {
            for (v, d) in y[n..2 * n].iter_mut().zip(dynamics.direction(i)) {
                *v += d * p;
            }
        }
        outcome.impulse = largest(&solution.z);
        velocities = solution.w;
    }
    let lowest_flight = LOWEST_FLIGHT * largest(&y[..n]).max(1.0);
    dynamics.load(t, y);
    dynamics.evaluate_free_acceleration();
    for (i, velocity) in closed.into_iter().zip(velocities) {
        dynamics.evaluate_contact(i);
        let (acceleration, _) = dynamics.free_normal_acceleration(i);
        let room = lowest_flight - dynamics.point(i)[contact_point::GAP];
        let returns = velocity > 0.0 && velocity * velocity <= -2.0 * acceleration * room;
        if velocity.abs() <= zero_velocity || returns {
            outcome.resting.push(i);
        }
    }
    Ok(outcome)
}

/// Solves `0 <= z _|_ q + D z >= 0` over `contacts` as last evaluated. Several solutions are accepted if
/// they give the same change of velocity.
pub(in crate::simulation) fn solve(
    dynamics: &Dynamics<'_>,
    contacts: &[usize],
    q: &[f64],
    what: &str,
) -> Result<LcpSolution, String> {
    if contacts.len() > lcp::LARGEST {
        return Err(format!(
            "{what} at {} closed contacts at once; at most {} can be resolved exactly",
            contacts.len(),
            lcp::LARGEST
        ));
    }
    let matrix: Vec<f64> = contacts
        .iter()
        .flat_map(|&i| contacts.iter().map(move |&j| (i, j)))
        .map(|(i, j)| dynamics.coupling(i, j))
        .collect();
    let mut found = lcp::solutions(&matrix, q).into_iter();
    let Some(solution) = found.next() else {
        return Err(format!(
            "the {what} has no solution: contact directions push each other into the ground; check \
             `along` of the impact laws"
        ));
    };
    let change = |solution: &LcpSolution| {
        let mut change = vec![0.0; dynamics.n];
        for (&i, z) in contacts.iter().zip(&solution.z) {
            for (change, d) in change.iter_mut().zip(dynamics.direction(i)) {
                *change += d * z;
            }
        }
        change
    };
    let reference = change(&solution);
    let tolerance = SAME * largest(&reference).max(largest(q));
    for other in found {
        let apart = change(&other)
            .iter()
            .zip(&reference)
            .any(|(a, b)| (a - b).abs() > tolerance);
        if apart {
            return Err(format!(
                "the {what} has several solutions with different velocities; check `along` of the \
                 impact laws, or start from a slightly different state"
            ));
        }
    }
    Ok(solution)
}

/// Chooses the active contacts among those closed and at rest: those that carry a force in
/// `0 <= r _|_ n' a + curvature + D r >= 0`; where force and acceleration both vanish, those for which the
/// same holds a moment later. On return `dynamics.active` is the new mode.
///
/// `vanished` is a contact whose force is known to vanish now, whatever rounding error has left of it;
/// `moment` is a time over which the motion is smooth, such as a step size.
pub(in crate::simulation) fn select(
    dynamics: &mut Dynamics<'_>,
    probe: &mut Dop853,
    t: f64,
    y: &[f64],
    resting: &[usize],
    vanished: Option<usize>,
    moment: f64,
) -> Result<(), Undetermined> {
    dynamics.active.clear();
    let Some(&contact) = resting.first() else {
        return Ok(());
    };
    dynamics.load(t, y);
    dynamics.evaluate_free_acceleration();
    let (mut free, mut scales) = (Vec::with_capacity(resting.len()), Vec::new());
    for &i in resting {
        dynamics.evaluate_contact(i);
        let (acceleration, terms) = dynamics.free_normal_acceleration(i);
        free.push(acceleration);
        scales.push(terms);
    }
    dynamics.set_force_floors(resting);
    let solution = solve(dynamics, resting, &free, "balance of contact forces")
        .map_err(|message| Undetermined { contact, message })?;
    let (mut pressed, mut biactive, mut remainders) = (Vec::new(), Vec::new(), Vec::new());
    for (slot, &i) in resting.iter().enumerate() {
        let (r, w) = (solution.z[slot], solution.w[slot]);
        let zero = BIACTIVE * scales[slot].max(dynamics.force_floor(i));
        if r > zero && vanished != Some(i) {
            pressed.push(i);
        } else if w <= zero || vanished == Some(i) {
            biactive.push(i);
            remainders.push(r.abs().max(w.abs()));
        }
    }
    if biactive.is_empty() {
        dynamics.active = pressed;
        return Ok(());
    }
    let mut subsets: Vec<usize> = (0..1 << biactive.len()).collect();
    subsets.sort_by_key(|subset| usize::MAX - subset.count_ones() as usize);
    let mut neutral = None;
    for (share, multiple) in MOMENTS {
        neutral = None;
        for &subset in &subsets {
            dynamics.active = pressed.clone();
            let held = |slot: usize| subset >> slot & 1 == 1;
            dynamics.active.extend(
                biactive
                    .iter()
                    .enumerate()
                    .filter(|&(slot, _)| held(slot))
                    .map(|(_, &i)| i),
            );
            dynamics.active.sort_unstable();
            let noise = remainders.iter().map(|remainder| multiple * remainder);
            match sign_after(
                dynamics,
                probe,
                t,
                y,
                biactive.iter().copied().zip(noise),
                share * moment,
            ) {
                Sign::Positive => return Ok(()),
                Sign::Zero if neutral.is_none() => neutral = Some(dynamics.active.clone()),
                Sign::Zero | Sign::Negative => {}
            }
        }
    }
    match neutral {
        Some(active) => {
            dynamics.active = active;
            Ok(())
        }
        None => Err(Undetermined {
            contact: biactive[0],
            message:
                "neither holding nor releasing the contact is consistent a moment later; start \
                      from a slightly different state"
                    .into(),
        }),
    }
}

/// Sign of the smallest of the forces (of held contacts) and accelerations (of released ones).
enum Sign {
    Positive,
    Zero,
    Negative,
}

/// Looks at the biactive contacts, each with what counts as noise, after a time `delta` in the mode
/// `dynamics.active`.
fn sign_after(
    dynamics: &mut Dynamics<'_>,
    probe: &mut Dop853,
    t: f64,
    y: &[f64],
    biactive: impl Iterator<Item = (usize, f64)>,
    delta: f64,
) -> Sign {
    let mut start = y.to_vec();
    if !dynamics.project(t, &mut start) {
        return Sign::Negative;
    }
    probe.begin(dynamics, t, &start);
    probe.step(dynamics, t, &start, delta);
    if !dynamics.project(t + delta, probe.end_mut()) {
        return Sign::Negative;
    }
    probe.finish(dynamics, t, delta);
    let n = dynamics.n;
    let accelerations = probe.end_slope()[n..2 * n].to_vec();
    let mut sign = Sign::Positive;
    for (i, noise) in biactive {
        dynamics.evaluate_contact(i);
        let curvature = dynamics.point(i)[contact_point::CURVATURE];
        let value = if dynamics.is_active(i) {
            dynamics.values[i]
        } else {
            curvature + dot(dynamics.normal(i), &accelerations)
        };
        let noise = noise.max(NOISE * dynamics.normal_acceleration_scale(i));
        if value < -noise || value.is_nan() {
            return Sign::Negative;
        }
        if value <= noise {
            sign = Sign::Zero;
        }
    }
    sign
}
