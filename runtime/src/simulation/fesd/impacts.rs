//! The velocity jumps of a run: impacts of all touching contacts at once, or of a cluster one after the other.

use super::bounces::slowest_bounce;
use super::driver::{Driver, EnergyGains};
use crate::contact::impact;
use crate::contact::{ActiveContact, ContactState, find};
use crate::fesd::contacts::{ModeError, dot};
use crate::simulation::impact_cluster::{self, NearContact};
use crate::simulation::impulse;
use crate::time_freezing::clock;

/// Share of the largest velocity of a contact with which it closes at the end of many bounces.
const SLOW: f64 = 1e-3;

/// Kinetic energies are compared to this relative accuracy.
const SAME_ENERGY: f64 = 1e-12;

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
    let too_fast = collapses(driver, touching);
    if too_fast || in_sequence(driver, touching) {
        return cluster(driver, touching, too_fast);
    }
    match strike(driver, touching, &closing) {
        Ok(ended) => Ok(Impact {
            struck: closing,
            ended,
            cluster: None,
        }),
        // At the end of bounces contacts may strike one after the other where together they jam.
        Err(ModeError::Jammed) if touching.len() > 1 && are_slow(driver, &closing) => {
            cluster(driver, touching, true)
        }
        Err(error) => Err(error),
    }
}

/// Whether the impact of `touching` contacts is one of several that follow too fast to be told apart: a contact that
/// touches has left its surface and goes on leaving, so it is not struck at the same instant. At the start only its gap
/// tells.
fn collapses(driver: &Driver<'_>, touching: &[usize]) -> bool {
    let now = &driver.now;
    touching.iter().any(|&i| {
        let size = now.size(i);
        find(&now.active, i).is_none()
            && (now.state.time > 0.0 || now.contacts.gap(i) > size.gap_rounding())
            && now.contacts.normal_velocity(i) > size.touching_velocity()
    })
}

/// Whether the scene wants contacts that touch to be struck one after the other.
fn in_sequence(driver: &Driver<'_>, touching: &[usize]) -> bool {
    let contacts = driver.setup.model.declaration().contacts;
    touching.len() > 1 && touching.iter().any(|&i| contacts[i].sequence)
}

/// Whether contacts close with little of what their velocities have been.
fn are_slow(driver: &Driver<'_>, closing: &[usize]) -> bool {
    closing
        .iter()
        .all(|&i| -driver.now.contacts.normal_velocity(i) <= SLOW * driver.now.size(i).speed())
}

/// The gaps of contacts that may strike one after the other.
fn near(driver: &Driver<'_>, touching: &[usize]) -> Vec<NearContact> {
    let contacts = driver.setup.model.declaration().contacts;
    let near = |&contact: &usize| {
        let held = find(&driver.now.active, contact).is_some();
        let (gap, touching) = (
            driver.now.contacts.gap(contact).max(0.0),
            driver.now.size(contact).touching_gap(),
        );
        let (gap, rounding) = if held { (0.0, 0.0) } else { (gap, touching) };
        NearContact {
            contact,
            gap,
            rounding,
            sequence: contacts[contact].sequence,
        }
    };
    touching.iter().map(near).collect()
}

/// Carries out the impacts of a cluster.
fn cluster(
    driver: &mut Driver<'_>,
    touching: &[usize],
    too_fast: bool,
) -> Result<Impact, ModeError> {
    let near = near(driver, touching);
    let cluster = impact_cluster::resolve(&mut Bodies(driver), &near)?;
    let contacts = driver.setup.contacts();
    driver.now.evaluate_contacts(contacts);
    driver.now.numerical_time += cluster.numerical_time;
    if let Some(note) = cluster.note(too_fast) {
        driver.note(note);
    }
    Ok(Impact {
        struck: cluster.struck,
        ended: Vec::new(),
        cluster: Some(touching.to_vec()),
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
    let passive = elastic && !ground_moves(driver, touching);
    let before = if passive { kinetic_energy(driver) } else { 0.0 };
    driver.now.numerical_time += jump(driver, touching, &restitution)?;
    driver.now.write_input();
    if passive {
        compare_energies(driver, before, closing);
    }
    if touching.len() > 1 {
        driver.note("simultaneous impacts follow Moreau's law (all touching contacts in one linear complementarity problem)");
    }
    Ok(ended)
}

/// Changes the velocity by the impact law; returns the numerical time \[s\] that the jump takes.
fn jump(
    driver: &mut Driver<'_>,
    together: &[usize],
    restitution: &[f64],
) -> Result<f64, ModeError> {
    let mut impulses = Vec::new();
    let now = &mut driver.now;
    let v = &mut now.state.v;
    impact::strike(&now.contacts, together, restitution, &mut impulses, v)?;
    let acceleration = driver.setup.settings.auxiliary_acceleration;
    Ok(clock::jump(&impulses, acceleration))
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

/// Kinetic energy at the present state \[J\], `v' M v / 2`, at the position last written to the input vector.
fn kinetic_energy(driver: &Driver<'_>) -> f64 {
    let (v, x) = (&driver.now.state.v, &driver.now.x);
    let n = v.len();
    let mut mass = vec![0.0; n * n];
    driver.setup.model.mass_matrix(x, &mut mass);
    let momentum = mass.chunks_exact(n).map(|row| dot(row, v));
    0.5 * momentum.zip(v).map(|(p, v)| p * v).sum::<f64>()
}

/// Whether the ground of one of the contacts moves, which are evaluated at the present state.
fn ground_moves(driver: &Driver<'_>, contacts: &[usize]) -> bool {
    let now = &driver.now;
    let moves = |&i: &usize| now.contacts.ground_moves(i, &now.state.v);
    contacts.iter().any(moves)
}

/// Remembers an impact of the `closing` contacts that raised the kinetic energy.
fn compare_energies(driver: &mut Driver<'_>, before: f64, closing: &[usize]) {
    let after = kinetic_energy(driver);
    let Some(&contact) = closing.first() else {
        return;
    };
    if after > before * (1.0 + SAME_ENERGY) {
        let first = (driver.now.state.time, contact);
        let gains = driver.record.energy_gains.get_or_insert(EnergyGains {
            count: 0,
            first,
            energies: (before, after),
        });
        gains.count += 1;
    }
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

/// The bodies of a run in a cluster.
struct Bodies<'d, 'a>(&'d mut Driver<'a>);

impl impact_cluster::Bodies for Bodies<'_, '_> {
    type Error = ModeError;

    fn velocity(&mut self) -> &mut [f64] {
        &mut self.0.now.state.v
    }

    fn kinetic_energy(&mut self) -> f64 {
        kinetic_energy(self.0)
    }

    fn ground_moves(&mut self, contacts: &[usize]) -> bool {
        self.0.now.evaluate_contacts(contacts.iter().copied());
        ground_moves(self.0, contacts)
    }

    fn normal_velocity(&mut self, contact: usize) -> f64 {
        self.0.now.evaluate_contacts([contact]);
        self.0.now.contacts.normal_velocity(contact)
    }

    fn zero_velocity(&self, contact: usize) -> f64 {
        self.0.now.size(contact).touching_velocity()
    }

    fn slowest_bounce(&self, contact: usize) -> f64 {
        slowest_bounce(self.0, contact, false)
    }

    fn bring_to_rest(&mut self, contacts: &[usize]) {
        let resting = contacts.iter().map(|&contact| ActiveContact {
            contact,
            state: ContactState::Frictionless,
        });
        let resting: Vec<ActiveContact> = resting.collect();
        let now = &mut self.0.now;
        now.evaluate_contacts(contacts.iter().copied());
        if impact::hold(&now.contacts, &resting, &mut now.state.v).is_ok() {
            let q = now.state.q.clone();
            if project(self.0, contacts).is_err() {
                self.0.now.state.q = q;
            }
        }
    }

    fn strike(&mut self, together: &[usize], elastic: bool) -> Result<f64, ModeError> {
        let driver = &mut *self.0;
        driver.now.evaluate_contacts(together.iter().copied());
        let restitution: Vec<f64> = together
            .iter()
            .map(|&i| {
                let speed = -driver.now.contacts.normal_velocity(i);
                if elastic && speed > slowest_bounce(driver, i, false) {
                    driver.setup.restitution[i]
                } else {
                    0.0
                }
            })
            .collect();
        jump(driver, together, &restitution)
    }
}
