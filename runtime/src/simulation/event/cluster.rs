//! Clusters of impacts in a run from event to event.

use super::dynamics::Dynamics;
use super::impact::{EndOfBounces, Impact, LowestBounce, Undetermined, lowest_speeds, strike};
use crate::model::contact_point;
use crate::simulation::impact_cluster::{self, Cluster, NearContact};

/// Gap within which the impacts of several contacts are a cluster, and flight since the last impact that makes them
/// one, relative to a closed gap: small beside the motion, large beside the errors of gaps, which give the order of
/// the impacts.
const COLLAPSED: f64 = 1e3;

/// The contacts of a cluster at the state loaded, if those `closed` begin one: one of them is struck again after a
/// flight that stayed near what counts as closed, since which another one as near has been struck. `last_impacts`
/// are the times of the last impacts of all contacts \[s\].
pub(super) fn collapsing(
    dynamics: &mut Dynamics<'_>,
    t: f64,
    closed: &[usize],
    last_impacts: &[f64],
) -> Vec<NearContact> {
    let near: Vec<NearContact> = (0..dynamics.contacts)
        .filter_map(|contact| {
            let gap = dynamics.point(contact)[contact_point::GAP];
            let closed_gap = dynamics.closed_gap(contact);
            let held = dynamics.is_active(contact);
            let is_near = closed.contains(&contact) || gap <= COLLAPSED * closed_gap;
            is_near.then(|| NearContact {
                contact,
                gap: if held { 0.0 } else { gap.max(0.0) },
                rounding: if held { 0.0 } else { closed_gap },
            })
        })
        .collect();
    let collapses = closed.iter().any(|&i| {
        let speed = -dynamics.point(i)[contact_point::NORMAL_VELOCITY];
        let flight = speed * (t - last_impacts[i]);
        speed > dynamics.zero_normal_velocity(i)
            && flight <= COLLAPSED * dynamics.closed_gap(i)
            && near
                .iter()
                .any(|j| j.contact != i && last_impacts[j.contact] >= last_impacts[i])
    });
    if collapses { near } else { Vec::new() }
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
    let mut lowest = vec![0.0; dynamics.contacts];
    for (&i, speed) in contacts.iter().zip(speeds) {
        lowest[i] = speed;
    }
    let mut bodies = Bodies {
        dynamics,
        t,
        y,
        lowest,
    };
    let cluster = impact_cluster::resolve(&mut bodies, near)?;
    outcome.struck.clone_from(&cluster.struck);
    outcome.impulse = cluster.numerical_time;
    Ok(cluster)
}

/// The bodies of a run in a cluster.
struct Bodies<'c, 'a> {
    dynamics: &'c mut Dynamics<'a>,
    t: f64,
    y: &'c mut [f64],
    /// Speed of each contact up to which it does not bounce.
    lowest: Vec<f64>,
}

impl impact_cluster::Bodies for Bodies<'_, '_> {
    type Error = Undetermined;

    fn velocity(&mut self) -> &mut [f64] {
        let n = self.dynamics.n;
        &mut self.y[n..2 * n]
    }

    fn kinetic_energy(&mut self) -> f64 {
        self.dynamics.kinetic_energy(self.y)
    }

    fn normal_velocity(&mut self, contact: usize) -> f64 {
        self.dynamics.load(self.t, self.y);
        self.dynamics.evaluate_contact(contact);
        self.dynamics.point(contact)[contact_point::NORMAL_VELOCITY]
    }

    fn zero_velocity(&self, contact: usize) -> f64 {
        self.dynamics.zero_normal_velocity(contact)
    }

    fn strike(&mut self, together: &[usize], elastic: bool) -> Result<f64, Undetermined> {
        self.dynamics.load(self.t, self.y);
        let mut velocities = Vec::with_capacity(together.len());
        let mut outcome = Impact {
            struck: together.to_vec(),
            ..Impact::default()
        };
        for &contact in together {
            self.dynamics.evaluate_sides(contact);
            let velocity = self.dynamics.point(contact)[contact_point::NORMAL_VELOCITY];
            let rests = velocity.abs() <= self.dynamics.zero_normal_velocity(contact);
            velocities.push(if rests { 0.0 } else { velocity });
            if !elastic || -velocity <= self.lowest[contact] {
                outcome.ended.push(EndOfBounces {
                    contact,
                    speed: -velocity,
                    height: 0.0,
                });
            }
        }
        strike(self.dynamics, self.y, together, &velocities, &mut outcome)?;
        Ok(outcome.impulse)
    }
}
