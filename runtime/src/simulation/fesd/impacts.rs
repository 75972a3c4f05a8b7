//! The velocity jumps of a run: impacts of all touching contacts at once, or of a cluster one after the other.

use super::bounces::slowest_bounce;
use super::driver::{Driver, EnergyGains};
use crate::contact::cluster::{self, Bodies, NearContact};
use crate::contact::impact;
use crate::contact::{View, find};
use crate::fesd::contacts::ModeError;
use crate::simulation::impulse;
use crate::time_freezing::clock;

/// Share of the largest velocity of a contact with which it closes at the end of many bounces.
const SLOW: f64 = 1e-3;

/// What an impact has been.
#[derive(Default)]
pub(super) struct Impact {
    /// Contacts that closed.
    pub(super) struck: Vec<usize>,
    /// Those with restitution among them that do not bounce, with their speed.
    pub(super) ended: Vec<(usize, f64)>,
    /// The contacts of a cluster, where the impacts were carried out one after the other.
    pub(super) cluster: Option<Vec<usize>>,
}

/// Carries out the impact of all `touching` contacts at the present state, whose velocities are evaluated, whatever pieces of
/// edges they are.
pub(super) fn carry_out(driver: &mut Driver<'_>, touching: &[usize]) -> Result<Impact, ModeError> {
    let closes = |&i: &usize| {
        let limit = driver.now.size(i).touching_velocity();
        driver.now.contacts.normal_velocity(i) < -limit
    };
    let closing: Vec<usize> = touching.iter().copied().filter(closes).collect();
    if closing.is_empty() {
        return Ok(Impact::default());
    }
    let near: Vec<NearContact> = touching.iter().map(|&i| near(driver, i)).collect();
    let at_start = driver.now.state.time <= 0.0;
    let too_fast = near.iter().any(|near| {
        let error = driver.now.size(near.contact).gap_rounding();
        near.leaves(&driver.now.contacts, (at_start, error))
    });
    if too_fast || cluster::in_sequence(&near) {
        return carry_out_cluster(driver, &near, too_fast);
    }
    match strike(driver, touching, &closing) {
        Ok(ended) => Ok(Impact {
            struck: closing,
            ended,
            cluster: None,
        }),
        // At the end of bounces contacts may strike one after the other where together they jam.
        Err(ModeError::Jammed) if touching.len() > 1 && are_slow(driver, &closing) => {
            carry_out_cluster(driver, &near, true)
        }
        Err(error) => Err(error),
    }
}

/// Whether contacts close with little of what their velocities have been.
fn are_slow(driver: &Driver<'_>, closing: &[usize]) -> bool {
    closing
        .iter()
        .all(|&i| -driver.now.contacts.normal_velocity(i) <= SLOW * driver.now.size(i).speed())
}

/// A contact that touches, as one of a cluster.
fn near(driver: &Driver<'_>, contact: usize) -> NearContact {
    let (now, size) = (&driver.now, driver.now.size(contact));
    let held = find(&now.active, contact).is_some();
    let zeros = (size.touching_gap(), size.touching_velocity());
    let slowest = slowest_bounce(driver, contact, false);
    NearContact::new(&now.contacts, contact, held, zeros)
        .bouncing(driver.setup.restitution[contact], slowest)
}

/// Carries out the impacts of a cluster.
fn carry_out_cluster(
    driver: &mut Driver<'_>,
    near: &[NearContact],
    too_fast: bool,
) -> Result<Impact, ModeError> {
    driver.now.write_input();
    let now = &mut driver.now;
    let mut bodies = Bodies {
        view: &mut now.contacts,
        x: &mut now.x,
        strike: |view: &View<'_>, together: &[usize], restitution: &[f64], v: &mut [f64]| {
            let impulses = impact::strike(view, together, restitution, v);
            impulses.map(|impulses| impulses.into_iter().fold(0.0, f64::max))
        },
    };
    let struck = cluster::resolve(&mut bodies, near)?;
    let (q, v) = now.x[..2 * now.state.q.len()].split_at(now.state.q.len());
    now.state.q.copy_from_slice(q);
    now.state.v.copy_from_slice(v);
    let contacts = driver.setup.contacts();
    driver.now.evaluate_contacts(contacts);
    driver.now.numerical_time += struck.impulse / driver.setup.settings.auxiliary_acceleration;
    if let Some(note) = struck.note(too_fast) {
        driver.note(note);
    }
    Ok(Impact {
        struck: struck.struck,
        ended: Vec::new(),
        cluster: Some(near.iter().map(|near| near.contact).collect()),
    })
}

/// The velocity jump of an impact of the `closing` contacts in which all `touching` ones take part.
/// Returns those with restitution among them that do not bounce, with their speed.
fn strike(
    driver: &mut Driver<'_>,
    touching: &[usize],
    closing: &[usize],
) -> Result<Vec<(usize, f64)>, ModeError> {
    let alone = touching.len() == 1;
    let mut ended = Vec::new();
    let mut restitution = vec![0.0; touching.len()];
    for (e, &i) in restitution.iter_mut().zip(touching) {
        let speed = -driver.now.contacts.normal_velocity(i);
        if speed > slowest_bounce(driver, i, alone) {
            *e = driver.setup.restitution[i];
        } else if driver.setup.restitution[i] > 0.0 && closing.contains(&i) {
            ended.push((i, speed));
        }
    }
    let elastic = restitution.iter().any(|e| *e > 0.0);
    let now = &mut driver.now;
    let still = |&i: &usize| !now.contacts.ground_moves(i, &now.state.v);
    let passive = elastic && touching.iter().all(still);
    let before = now.contacts.kinetic_energy(&now.x);
    let impulses = impact::strike(&now.contacts, touching, &restitution, &mut now.state.v)?;
    now.numerical_time += clock::jump(&impulses, driver.setup.settings.auxiliary_acceleration);
    now.write_input();
    let gain = impact::gain(before, now.contacts.kinetic_energy(&now.x)).filter(|_| passive);
    if let (Some(energies), Some(&contact)) = (gain, closing.first()) {
        let first = (driver.now.state.time, contact);
        let gains = driver.record.energy_gains.get_or_insert(EnergyGains {
            count: 0,
            first,
            energies,
        });
        gains.count += 1;
    }
    if touching.len() > 1 {
        driver.note("simultaneous impacts follow Moreau's law (all touching contacts in one linear complementarity problem)");
    }
    Ok(ended)
}

/// Moves the present positions onto the surfaces of `close` contacts, along their directions.
pub(super) fn project(driver: &mut Driver<'_>, close: &[usize]) -> Result<(), ModeError> {
    let now = &mut driver.now;
    for _ in 0..3 {
        now.evaluate_contacts(close.iter().copied());
        impact::close_gaps(&now.contacts, close, &mut now.state.q)?;
    }
    Ok(())
}

/// Says whether impacts raised the kinetic energy.
pub(super) fn note_energy_gains(driver: &mut Driver<'_>) {
    let Some(gains) = driver.record.energy_gains else {
        return;
    };
    let ((time, contact), (before, after)) = (gains.first, gains.energies);
    driver.note(&format!(
        "{} the kinetic energy, the first of `{}` at {time:.6} s from {before:.6e} to \
         {after:.6e}: restitution in the normal direction alone does so where friction or several \
         contacts couple; lower the restitution",
        impulse::that_raise(gains.count),
        driver.setup.name(contact)
    ));
}
