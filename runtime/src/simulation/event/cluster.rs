//! Clusters of impacts in a run from event to event.

use super::dynamics::{Dynamics, dot};
use super::impact::{EndOfBounces, Impact, LowestBounce, Undetermined, lowest_speeds, strike};
use crate::linalg::small_system;
use crate::model::contact_point;
use crate::simulation::impact_cluster::{self, Cluster, NearContact};

/// Whether the impact of those `closed` at the state loaded is one of several that follow too fast
/// to be told apart: a contact among them has left its surface and goes on leaving, so it is not struck at the same
/// instant. At the start only its gap tells.
pub(super) fn collapses(dynamics: &Dynamics<'_>, t: f64, closed: &[usize]) -> bool {
    let velocity = |i: usize| dynamics.point(i)[contact_point::NORMAL_VELOCITY];
    let gap = |i: usize| dynamics.point(i)[contact_point::GAP];
    let leaves = |&i: &usize| {
        !dynamics.is_active(i)
            && (t > 0.0 || gap(i) > dynamics.gap_rounding(i))
            && velocity(i) > dynamics.zero_normal_velocity(i)
    };
    closed.iter().any(leaves)
}

/// Whether the scene wants contacts that touch to be struck one after the other.
pub(super) fn in_sequence(dynamics: &Dynamics<'_>, closed: &[usize]) -> bool {
    let contacts = dynamics.model.declaration().contacts;
    closed.len() > 1 && closed.iter().any(|&i| contacts[i].sequence)
}

/// The contacts of a cluster at the state loaded.
pub(super) fn near(dynamics: &Dynamics<'_>, closed: &[usize]) -> Vec<NearContact> {
    let contacts = dynamics.model.declaration().contacts;
    let near = |&contact: &usize| {
        let (gap, rounding) = if dynamics.is_active(contact) {
            (0.0, 0.0)
        } else {
            let gap = dynamics.point(contact)[contact_point::GAP];
            (gap.max(0.0), dynamics.closed_gap(contact))
        };
        NearContact {
            contact,
            gap,
            rounding,
            sequence: contacts[contact].sequence,
        }
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

    fn ground_moves(&mut self, contacts: &[usize]) -> bool {
        self.dynamics.load(self.t, self.y);
        contacts.iter().any(|&contact| {
            self.dynamics.evaluate_sides(contact);
            self.dynamics.ground_moves(contact)
        })
    }

    fn normal_velocity(&mut self, contact: usize) -> f64 {
        self.dynamics.load(self.t, self.y);
        self.dynamics.evaluate_contact(contact);
        self.dynamics.point(contact)[contact_point::NORMAL_VELOCITY]
    }

    fn zero_velocity(&self, contact: usize) -> f64 {
        self.dynamics.zero_normal_velocity(contact)
    }

    fn slowest_bounce(&self, contact: usize) -> f64 {
        self.lowest[contact]
    }

    fn bring_to_rest(&mut self, contacts: &[usize]) {
        let (n, order) = (self.dynamics.n, contacts.len());
        self.dynamics.load(self.t, self.y);
        for &contact in contacts {
            self.dynamics.evaluate_contact(contact);
        }
        for (quantity, at) in [(contact_point::GAP, 0), (contact_point::NORMAL_VELOCITY, n)] {
            let normal = |i: usize| &self.dynamics.point(i)[contact_point::NORMAL..][..n];
            let coupling = |(&i, &j): (&usize, &usize)| dot(normal(i), self.dynamics.direction(j));
            let pairs = contacts
                .iter()
                .flat_map(|i| contacts.iter().map(move |j| (i, j)));
            let mut matrix: Vec<f64> = pairs.map(coupling).collect();
            let value = |&i: &usize| self.dynamics.point(i)[quantity];
            let mut impulses: Vec<f64> = contacts.iter().map(value).collect();
            if order == 0 || small_system::solve(&mut matrix, &mut impulses).is_none() {
                return;
            }
            for (&i, impulse) in contacts.iter().zip(impulses) {
                let direction = self.dynamics.direction(i);
                for (y, d) in self.y[at..at + n].iter_mut().zip(direction) {
                    *y -= impulse * d;
                }
            }
        }
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
