//! The jump of the velocities where gaps close: one impact of all contacts that touch, or a cluster of impacts.
//!
//! ```text
//! v+ = v- + sum_i d_i p_i + e_i s_i
//! 0 <= p_i  _|_  v_n,i+ + e_i min(v_n,i-, 0) >= 0          e_i: coefficient of restitution
//! |s_i| <= mu_i p_i,   s_i v_t,i+ = -mu_i p_i |v_t,i+|
//! ```
//!
//! Contacts that strike too fast one after the other do so in one cluster. Where bodies are at edges those contacts are struck first that are at
//! none: if the motion after that leaves the edges, they have no impact of their own ([`edge`]).
//!
//! Source: Moreau, *Unilateral contact and dry friction in finite freedom dynamics* (1988); restitution in the normal direction alone, as
//! Newton's law.

use super::instant::{Bounce, Instant};
use crate::contact::cluster::{self, Bodies, NearContact, in_sequence};
use crate::contact::impact::{self, Blow};
use crate::contact::{Balance, Line, View, edge};

/// A bounce that was left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EndOfBounces {
    pub(crate) contact: usize,
    /// Normal velocity before the impact, not negative.
    pub(crate) speed: f64,
    /// How high the bounce would have been; infinite if nothing pulls the contact back.
    pub(crate) height: f64,
}

/// Outcome of the impact law.
#[derive(Debug, Clone, Default)]
pub(crate) struct Impact {
    /// Contacts whose gap closed with a velocity, increasing.
    pub(crate) struck: Vec<usize>,
    /// Contacts that touch afterwards, with their normal velocities.
    pub(crate) after: Vec<(usize, f64)>,
    /// Of those the pieces that lead on from edges, which were not struck.
    pub(crate) edges: usize,
    /// Largest of the impulses `p_i`, in units of a normal velocity.
    pub(crate) impulse: f64,
    /// Contacts with restitution that were struck and stay.
    pub(crate) ended: Vec<EndOfBounces>,
    /// Whether the impacts have been carried out one after the other.
    pub(crate) in_turn: bool,
    /// Whether several contacts took part at once.
    pub(crate) simultaneous: bool,
    /// What a user should know of a cluster of impacts.
    pub(crate) cluster: Option<&'static str>,
    /// Kinetic energy before and after, if the law has raised it on ground at rest.
    pub(crate) energy_gain: Option<(f64, f64)>,
}

/// Carries out the impact of the `touching` contacts at the present state, where they are evaluated. At edges other pieces may act afterwards.
///
/// # Errors
/// Where the law has no solution, or several.
pub(crate) fn carry_out<'a, I: Instant<'a>>(
    now: &mut I,
    touching: &[usize],
) -> Result<Impact, I::Error> {
    match pass_edges(now, touching) {
        Some(impact) => Ok(impact),
        None => strike(now, touching),
    }
}

/// The impact of those `touching` contacts that are at no edge, if the motion that it leads to is free at the edges. The
/// pieces that lead from there on act. None, with everything as it was, where it is not.
fn pass_edges<'a, I: Instant<'a>>(now: &mut I, touching: &[usize]) -> Option<Impact> {
    let x = now.input();
    let pieces: Vec<usize> = edge::pieces(now.view(), touching).collect();
    for piece in pieces {
        now.view_mut().evaluate_normal(piece, &x);
    }
    let edges = edge::at_edges(now.view(), touching, |i| now.zeros(i))?;
    let struck = strike(now, &edges.others);
    let own: Vec<usize> = edge::pieces(now.view(), &edges.edges).collect();
    let after = now.input();
    evaluate(now, edges.edges.iter().copied().chain(own), &after);
    let leads = edges.leads(now.view(), |i| now.zeros(i));
    let passes = |impact: &Impact| edges.blocked || !impact.struck.is_empty();
    if let (Some(mut outcome), Some(leads)) = (struck.ok().filter(passes), leads) {
        let model = now.view().model;
        for &(piece, _) in &leads {
            now.view_mut().pieces.let_act(model, piece);
        }
        outcome.edges = leads.len();
        outcome.after.extend(leads);
        return Some(outcome);
    }
    now.put(&x);
    evaluate(now, touching.iter().copied(), &x);
    None
}

fn evaluate<'a>(now: &mut impl Instant<'a>, contacts: impl IntoIterator<Item = usize>, x: &[f64]) {
    for contact in contacts {
        now.view_mut().evaluate_sides(contact, x);
    }
}

/// The impact of all `touching` contacts, which are evaluated, whatever pieces of edges they are.
fn strike<'a, I: Instant<'a>>(now: &mut I, touching: &[usize]) -> Result<Impact, I::Error> {
    let velocity = |&i: &usize| (i, now.view().normal_velocity(i));
    let before: Vec<(usize, f64)> = touching.iter().map(velocity).collect();
    let closing = before.iter();
    let closing = closing.filter(|&&(i, velocity)| velocity < -now.zeros(i).velocity);
    let struck: Vec<usize> = closing.map(|(i, _)| *i).collect();
    if struck.is_empty() {
        return Ok(Impact {
            after: before,
            ..Impact::default()
        });
    }
    let near = |&i: &usize| {
        let zeros = now.zeros(i);
        let held = !now.state(i).is_open();
        NearContact::new(now.view(), i, held, (zeros.gap, zeros.velocity))
    };
    let near: Vec<NearContact> = touching.iter().map(near).collect();
    let at_start = now.time() <= 0.0;
    let too_fast = near.iter().any(|near| {
        let error = now.zeros(near.contact).gap_rounding;
        near.leaves(now.view(), (at_start, error))
    });
    if too_fast || in_sequence(&near) {
        return strike_in_turn(now, &near, too_fast);
    }
    match strike_together(now, touching, &struck) {
        // At the end of bounces contacts may strike one after the other where together they jam.
        Err(error) if touching.len() > 1 && now.may_follow(&error, &struck) => {
            strike_in_turn(now, &near, true)
        }
        outcome => outcome,
    }
}

/// The only impact of the contacts `together`, which are evaluated, and the velocities that restitution sends back; `still` are the
/// normal and sliding velocities of all contacts that are none.
fn blow<'a, I: Instant<'a>>(
    view: &View<'a>,
    (together, restitution): (&[usize], &[f64]),
    still: &[(f64, f64)],
    v: &mut [f64],
) -> Result<(Balance, Vec<f64>), I::Error> {
    let blow = Blow::new(view, together, restitution, |line| match line {
        Line::Normal { contact, .. } => still[contact].0,
        _ => still[line.contact()].1,
    });
    let balance = I::solve(view, blow.touching, &blow.offsets)?;
    let mut change = vec![0.0; v.len()];
    balance.push(view, &balance.forces, &mut change);
    for (v, change) in v.iter_mut().zip(change) {
        *v += change;
    }
    Ok((balance, blow.returned))
}

/// The largest normal impulse.
fn largest(balance: &Balance) -> f64 {
    balance
        .normals()
        .iter()
        .fold(0.0, |most, p| most.max(p.abs()))
}

/// One impact of all `touching` contacts at once, of which some are `struck`.
fn strike_together<'a, I: Instant<'a>>(
    now: &mut I,
    touching: &[usize],
    struck: &[usize],
) -> Result<Impact, I::Error> {
    let mut outcome = Impact {
        struck: struck.to_vec(),
        simultaneous: touching.len() > 1,
        ..Impact::default()
    };
    let mut restitution = vec![0.0; touching.len()];
    if struck.iter().any(|&i| now.restitution(i) > 0.0) {
        let bounces = now.bounces(touching, touching.len() == 1);
        for (k, (&contact, bounce)) in touching.iter().zip(bounces).enumerate() {
            let e = now.restitution(contact);
            let speed = -now.view().normal_velocity(contact);
            if speed > bounce.slowest {
                restitution[k] = e;
            } else if e > 0.0 && struck.contains(&contact) {
                outcome
                    .ended
                    .push(end_of_bounces(contact, (e, speed), bounce));
            }
        }
    }
    let mut x = now.input();
    let n = now.view().n;
    let v = x[n..2 * n].to_vec();
    let moves = |&i: &usize| now.view().ground_moves(i, &v);
    let elastic = restitution.iter().any(|e| *e > 0.0);
    let passive = elastic && !touching.iter().any(moves);
    let energy = |x: &[f64]| match passive {
        true => now.view().kinetic_energy(x),
        false => 0.0,
    };
    let before = energy(&x);
    let together = (touching, &restitution[..]);
    let (balance, returned) = blow::<I>(now.view(), together, &now.still(), &mut x[n..2 * n])?;
    outcome.energy_gain = impact::gain(before, energy(&x)).filter(|_| passive);
    outcome.impulse = largest(&balance);
    let velocities = impact::velocities_after(&balance, &returned);
    outcome.after = touching.iter().copied().zip(velocities).collect();
    now.put(&x);
    Ok(outcome)
}

fn end_of_bounces(contact: usize, (e, speed): (f64, f64), bounce: Bounce) -> EndOfBounces {
    EndOfBounces {
        contact,
        speed,
        height: if bounce.press > 0.0 {
            (e * speed).powi(2) / (2.0 * bounce.press)
        } else {
            f64::INFINITY
        },
    }
}

/// The impacts of a cluster, which may follow `too_fast` to be told apart.
fn strike_in_turn<'a, I: Instant<'a>>(
    now: &mut I,
    near: &[NearContact],
    too_fast: bool,
) -> Result<Impact, I::Error> {
    let contacts: Vec<usize> = near.iter().map(|near| near.contact).collect();
    let bounces = now.bounces(&contacts, false);
    let bouncing = near.iter().zip(bounces);
    let near: Vec<NearContact> = bouncing
        .map(|(near, bounce)| near.bouncing(now.restitution(near.contact), bounce.slowest))
        .collect();
    let mut x = now.input();
    let still = now.still();
    let mut bodies = Bodies {
        view: now.view_mut(),
        x: &mut x,
        strike: |view: &View<'a>, together: &[usize], restitution: &[f64], v: &mut [f64]| {
            let (balance, _) = blow::<I>(view, (together, restitution), &still, v)?;
            Ok(largest(&balance))
        },
    };
    let cluster = cluster::resolve(&mut bodies, &near)?;
    now.put(&x);
    evaluate(now, contacts.iter().copied(), &x);
    let velocity = |&i: &usize| (i, now.view().normal_velocity(i));
    Ok(Impact {
        after: contacts.iter().map(velocity).collect(),
        impulse: cluster.impulse,
        in_turn: true,
        cluster: cluster.note(too_fast),
        struck: cluster.struck,
        ..Impact::default()
    })
}
