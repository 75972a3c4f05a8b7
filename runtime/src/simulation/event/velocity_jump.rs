//! The jump of the velocities where gaps close: one impact of all closed contacts, or a cluster of impacts.

use super::cluster;
use super::dynamics::Dynamics;
use super::impact::{
    Impact, LowestBounce, Undetermined, closed_contacts, ended_bounces, rests, strike,
};
use crate::contact::cluster::{NearContact, in_sequence};
use crate::contact::edge::{self, Zeros};
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
    let (closed, dry): (Vec<usize>, Vec<usize>) = closed_contacts(dynamics, t, y, closing)
        .into_iter()
        .partition(|&i| !dynamics.is_dry(i));
    let mut outcome = match pass_edges(dynamics, t, y, &closed, (closing, lowest)) {
        Some(outcome) => outcome,
        None => strike_together(dynamics, t, y, closed, (closing, lowest))?,
    };
    outcome.resting.extend(dry);
    Ok(outcome)
}

/// The impact of those `closed` contacts that are at no edge, if the motion that it leads to is free at the edges, as
/// [`edge`] says: the contact of an edge acts only against motions that leave none of its pieces. Those that lead from
/// there on act. None, with everything as it was, where it is not.
fn pass_edges(
    dynamics: &mut Dynamics<'_>,
    t: f64,
    y: &mut [f64],
    closed: &[usize],
    (closing, lowest): (Option<usize>, LowestBounce),
) -> Option<Impact> {
    let zeros = |dynamics: &Dynamics<'_>, contact: usize| Zeros {
        gap: dynamics.closed_gap(contact),
        rounding: dynamics.zero_normal_velocity(contact),
        velocity: dynamics.zero_normal_velocity(contact),
    };
    for piece in edge::pieces(dynamics, closed) {
        dynamics.evaluate_contact(piece);
    }
    let edges = edge::at_edges(dynamics, closed, |i| zeros(dynamics, i))?;
    let mut after = y.to_vec();
    let others = edges.others.clone();
    let struck = strike_together(dynamics, t, &mut after, others, (closing, lowest));
    dynamics.load(t, &after);
    let own = edges.edges.iter().copied();
    for piece in own.chain(edge::pieces(dynamics, &edges.edges)) {
        dynamics.evaluate_sides(piece);
    }
    let leads = edges.leads(dynamics, |i| zeros(dynamics, i));
    let passes = |impact: &Impact| edges.blocked || !impact.struck.is_empty();
    if let (Some(mut outcome), Some(leads)) = (struck.ok().filter(passes), leads) {
        y.copy_from_slice(&after);
        dynamics.evaluate_free_acceleration();
        for (piece, velocity) in leads {
            let model = dynamics.model;
            dynamics.pieces.let_act(model, piece);
            if rests(dynamics, piece, velocity, false) {
                outcome.resting.push(piece);
            }
        }
        outcome.resting.sort_unstable();
        return Some(outcome);
    }
    dynamics.load(t, y);
    for &i in closed {
        dynamics.evaluate_sides(i);
    }
    None
}

/// The impact of all `closed` contacts, which are evaluated, whatever pieces of edges they are; they rest or not.
fn strike_together(
    dynamics: &mut Dynamics<'_>,
    t: f64,
    y: &mut [f64],
    mut closed: Vec<usize>,
    (closing, lowest): (Option<usize>, LowestBounce),
) -> Result<Impact, Undetermined> {
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
    let near = cluster::near(dynamics, &closed);
    let leaves = |near: &NearContact| {
        let error = dynamics.gap_rounding(near.contact);
        near.leaves(dynamics, (t <= 0.0, error))
    };
    let too_fast = !outcome.struck.is_empty() && near.iter().any(leaves);
    if too_fast || !outcome.struck.is_empty() && in_sequence(&near) {
        let carried_out = cluster::resolve(dynamics, t, y, &near, lowest, &mut outcome)?;
        outcome.cluster = carried_out.note(too_fast);
        outcome.in_turn = true;
        dynamics.load(t, y);
        closed = near.iter().map(|near| near.contact).collect();
        velocities.clear();
        for &i in &closed {
            dynamics.evaluate_sides(i);
            velocities.push(dynamics.point(i)[contact_point::NORMAL_VELOCITY]);
        }
    } else if !outcome.struck.is_empty() {
        outcome.ended = ended_bounces(dynamics, t, y, &outcome.struck, lowest);
        velocities = strike(dynamics, y, &closed, &mut outcome)?;
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
    Ok(outcome)
}
