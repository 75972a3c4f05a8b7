//! The jump of the velocities where gaps close: one impact of all closed contacts, or a cluster of impacts.

use super::cluster;
use super::dynamics::Dynamics;
use super::impact::{
    Impact, LowestBounce, Undetermined, closed_contacts, ended_bounces, rests, strike,
};
use crate::model::contact_point;

/// Applies the impact law to the velocities in `y`, for all closed contacts at once:
///
/// ```text
/// v+ = v- + sum_i d_i p_i + e_i s_i
/// 0 <= p_i  _|_  v_n,i+ + e_i min(v_n,i-, 0) >= 0          e_i: coefficient of restitution
/// |s_i| <= mu_i p_i,   s_i v_t,i+ = -mu_i p_i |v_t,i+|
/// ```
///
/// `closing` counts as closed whatever its gap. Contacts that strike too fast one after the other do so in one cluster.
///
/// Source: Moreau, *Unilateral contact and dry friction in finite freedom dynamics* (1988); restitution in
/// the normal direction alone, as Newton's law.
pub(in crate::simulation) fn impact(
    dynamics: &mut Dynamics<'_>,
    t: f64,
    y: &mut [f64],
    closing: Option<usize>,
    lowest: LowestBounce,
) -> Result<Impact, Undetermined> {
    // Dry friction has no impulses; it acts before and after.
    let (mut closed, dry): (Vec<usize>, Vec<usize>) = closed_contacts(dynamics, t, y, closing)
        .into_iter()
        .partition(|&i| !dynamics.is_dry(i));
    let mut velocities: Vec<f64> = closed
        .iter()
        .map(|&i| dynamics.point(i)[contact_point::NORMAL_VELOCITY])
        .collect();
    let mut outcome = Impact {
        struck: closed
            .iter()
            .zip(&velocities)
            .filter(|&(&i, &velocity)| velocity < -dynamics.zero_normal_velocity(i))
            .map(|(&i, _)| i)
            .collect(),
        ..Impact::default()
    };
    let near = cluster::collapsing(dynamics, t, &closed);
    if !near.is_empty() {
        let carried_out = cluster::resolve(dynamics, t, y, &near, lowest, &mut outcome)?;
        outcome.cluster = carried_out.note();
        dynamics.load(t, y);
        closed = near.iter().map(|near| near.contact).collect();
        velocities.clear();
        for &i in &closed {
            dynamics.evaluate_sides(i);
            velocities.push(dynamics.point(i)[contact_point::NORMAL_VELOCITY]);
        }
    } else if !outcome.struck.is_empty() {
        for (&i, velocity) in closed.iter().zip(&mut velocities) {
            if velocity.abs() <= dynamics.zero_normal_velocity(i) {
                *velocity = 0.0;
            }
        }
        outcome.ended = ended_bounces(dynamics, t, y, &outcome.struck, lowest);
        velocities = strike(dynamics, y, &closed, &velocities, &mut outcome)?;
    }
    dynamics.load(t, y);
    dynamics.evaluate_free_acceleration();
    for (i, velocity) in closed.into_iter().zip(velocities) {
        // A gap that falls through zero at once, although it grows, has been negative all the time.
        let never_open = closing == Some(i) && outcome.struck.is_empty();
        if rests(dynamics, i, velocity, never_open) {
            outcome.resting.push(i);
        }
    }
    outcome.resting.extend(dry);
    Ok(outcome)
}
