//! Clusters of impacts in a run from event to event.

use super::dynamics::Dynamics;
use super::impact::{Impact, LowestBounce, Undetermined, blow, lowest_speeds};
use crate::contact::View;
use crate::contact::cluster::{self, Bodies, Cluster, NearContact};

/// The contacts of a cluster at the state loaded, which do not bounce.
pub(super) fn near(dynamics: &Dynamics<'_>, closed: &[usize]) -> Vec<NearContact> {
    let near = |&contact: &usize| {
        let zeros = (
            dynamics.closed_gap(contact),
            dynamics.zero_normal_velocity(contact),
        );
        NearContact::new(dynamics, contact, dynamics.is_active(contact), zeros)
    };
    closed.iter().map(near).collect()
}

/// Carries out a cluster: changes the velocities in `y`, and adds its impulses and the contacts struck to `outcome`.
pub(super) fn resolve(
    dynamics: &mut Dynamics<'_>,
    t: f64,
    y: &mut [f64],
    near: &[NearContact],
    lowest: LowestBounce,
    outcome: &mut Impact,
) -> Result<Cluster, Undetermined> {
    let contacts: Vec<usize> = near.iter().map(|near| near.contact).collect();
    let speeds = lowest_speeds(dynamics, t, y, &contacts, lowest);
    let bouncing = near.iter().zip(speeds);
    let near: Vec<NearContact> = bouncing
        .map(|(near, speed)| near.bouncing(dynamics.laws.restitution[near.contact], speed))
        .collect();
    dynamics.load(t, y);
    let mut x = dynamics.input().to_vec();
    let zeros = dynamics.zero_velocities();
    let mut bodies = Bodies {
        view: dynamics,
        x: &mut x,
        strike: |view: &View<'_>, together: &[usize], restitution: &[f64], v: &mut [f64]| {
            let blow = blow(view, together, restitution, &zeros)?;
            blow.carry_out(view, v);
            Ok(blow.impulse())
        },
    };
    let cluster = cluster::resolve(&mut bodies, &near)?;
    let n = dynamics.n;
    y[..2 * n].copy_from_slice(&x[..2 * n]);
    outcome.struck.clone_from(&cluster.struck);
    outcome.impulse = cluster.impulse;
    Ok(cluster)
}
