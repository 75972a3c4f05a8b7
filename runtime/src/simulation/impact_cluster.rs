//! Clusters: impacts of several contacts within gaps too small for time to tell them apart.
//!
//! Bodies that collapse on each other strike ever faster one after the other. Forces do nothing in so short a time,
//! so the gaps change at constant rates between two impacts:
//!
//! 1. Of the contacts that approach, that with the least `g_i / -v_n,i` is struck, together with those that rest
//!    on their bodies, unless these are struck `in sequence`; the other gaps change by as much as they do until then.
//! 2. Each impact follows the impact law of the run; one that would raise the kinetic energy on ground at rest has no restitution.
//! 3. The cluster ends when no contact approaches, or after [`MOST_IMPACTS`] with an impact without restitution of
//!    all at once: what then still approaches does so by a share of its speed that falls with each impact.
//! 4. Contacts that are left with less than the slowest bounce, or [`SAME_VELOCITY`], come to rest: without an end of bounces infinitely many
//!    impacts would bring them there, and whether they touch decides what the next impact does.
//!
//! Velocities after the cluster depend on the order of its impacts alone. Each gap is therefore changed by its
//! rounding error in turn: where the end differs, the order is not known.

/// Impacts of one cluster before it ends without restitution.
const MOST_IMPACTS: usize = 500;
/// Kinetic energies are compared to this relative accuracy.
const SAME_ENERGY: f64 = 1e-12;
/// Velocities after a cluster that differ by more than this share of the largest before it are not the same.
const SAME_VELOCITY: f64 = 1e-6;

/// Bodies in a cluster, at one position.
pub(super) trait Bodies {
    /// Why an impact has no solution.
    type Error;

    /// The generalized velocity.
    fn velocity(&mut self) -> &mut [f64];

    /// Kinetic energy \[J\].
    fn kinetic_energy(&mut self) -> f64;

    /// Whether the ground of one of these contacts moves, so that it does work.
    fn ground_moves(&mut self, contacts: &[usize]) -> bool;

    /// Normal velocity of a contact of the cluster.
    fn normal_velocity(&mut self, contact: usize) -> f64;

    /// Normal velocity below which a contact neither approaches nor leaves.
    fn zero_velocity(&self, contact: usize) -> f64;

    /// Speed up to which the contact does not bounce; infinite without restitution.
    fn slowest_bounce(&self, contact: usize) -> f64;

    /// Takes the normal velocities of these contacts, and their gaps, unless they depend on each other.
    fn bring_to_rest(&mut self, contacts: &[usize]);

    /// Impact of the contacts `together`, with the restitution of those that bounce if `elastic`. Returns the time
    /// that it takes in numerical time \[s\].
    fn strike(&mut self, together: &[usize], elastic: bool) -> Result<f64, Self::Error>;
}

/// A contact of a cluster.
#[derive(Debug, Clone, Copy)]
pub(super) struct NearContact {
    pub(super) contact: usize,
    /// Gap, 0 for a contact that is held or has just closed.
    pub(super) gap: f64,
    /// Rounding error of the gap, 0 for a contact that is held.
    pub(super) rounding: f64,
    /// Whether it takes part only where it approaches, although it rests.
    pub(super) sequence: bool,
}

/// What a cluster did.
#[derive(Debug, Clone, Default)]
pub(super) struct Cluster {
    /// Contacts struck, increasing.
    pub(super) struck: Vec<usize>,
    /// Impacts one after the other.
    pub(super) impacts: usize,
    /// Numerical time that the impacts take \[s\].
    pub(super) numerical_time: f64,
    /// Whether rounding errors of the gaps change the velocities after it.
    pub(super) undecided: bool,
}

/// Said of a cluster whose end rounding errors change.
const UNDECIDED: &str = "impacts of several contacts follow so fast that rounding errors decide their order, and with \
    it the motion that follows: other tolerances may give another one; compare runs";
/// Said of any other cluster.
const JOINED: &str = "impacts of several contacts that follow too fast to be told apart are carried out one after the \
    other at one instant";

impl Cluster {
    /// What a user should know of it, where its impacts follow `too_fast` to be told apart. Of those that a scene wants one after the other
    /// nothing, unless rounding decides.
    pub(super) fn note(&self, too_fast: bool) -> Option<&'static str> {
        if self.undecided {
            Some(UNDECIDED)
        } else if too_fast && self.impacts > 1 {
            Some(JOINED)
        } else {
            None
        }
    }
}

/// Whether a run with these notes has carried out a cluster.
pub(super) fn is_noted_in(notes: &[String]) -> bool {
    notes.iter().any(|note| note == UNDECIDED || note == JOINED)
}

/// Carries out the cluster of the contacts `near`.
///
/// # Errors
/// That of an impact without a solution.
pub(super) fn resolve<B: Bodies>(
    bodies: &mut B,
    near: &[NearContact],
) -> Result<Cluster, B::Error> {
    let before = bodies.velocity().to_vec();
    let speeds = normal_velocities(bodies, near);
    let largest = speeds
        .iter()
        .fold(0.0_f64, |most, speed| most.max(speed.abs()));
    let mut others = Vec::new();
    for changed in 0..near.len() {
        if near[changed].rounding > 0.0 {
            let mut near = near.to_vec();
            near[changed].gap += near[changed].rounding;
            run(bodies, &mut near)?;
            others.push(normal_velocities(bodies, &near));
            bodies.velocity().copy_from_slice(&before);
        }
    }
    let mut cluster = run(bodies, &mut near.to_vec())?;
    let after = normal_velocities(bodies, near);
    cluster.undecided = others.iter().any(|other| {
        let mut pairs = other.iter().zip(&after);
        pairs.any(|(other, after)| (other - after).abs() > SAME_VELOCITY * largest)
    });
    let slowest = |&i: &usize| bodies.slowest_bounce(i);
    let finite = |speed: &f64| speed.is_finite();
    let slowest = cluster.struck.iter().map(slowest).filter(finite);
    let slowest = slowest.fold(SAME_VELOCITY * largest, f64::max);
    let mut resting = cluster.struck.clone();
    resting.retain(|&i| bodies.normal_velocity(i).abs() <= slowest);
    bodies.bring_to_rest(&resting);
    Ok(cluster)
}

/// By how much the normal velocities after the impact of all contacts `near` at once differ from those after impacts one after
/// the other; the velocities are as before.
///
/// # Errors
/// That of an impact without a solution.
pub(super) fn order_matters<B: Bodies>(
    bodies: &mut B,
    near: &[NearContact],
) -> Result<Vec<f64>, B::Error> {
    let before = bodies.velocity().to_vec();
    let sequence = run(bodies, &mut near.to_vec()).map(|_| normal_velocities(bodies, near));
    bodies.velocity().copy_from_slice(&before);
    let contacts: Vec<usize> = near.iter().map(|near| near.contact).collect();
    let together = bodies.strike(&contacts, true);
    let together = together.map(|_| normal_velocities(bodies, near));
    bodies.velocity().copy_from_slice(&before);
    let pairs = sequence?.into_iter().zip(together?);
    Ok(pairs.map(|(one, other)| (one - other).abs()).collect())
}

fn normal_velocities<B: Bodies>(bodies: &mut B, near: &[NearContact]) -> Vec<f64> {
    near.iter()
        .map(|near| bodies.normal_velocity(near.contact))
        .collect()
}

/// The impacts in their order; `near` follows the gaps.
fn run<B: Bodies>(bodies: &mut B, near: &mut [NearContact]) -> Result<Cluster, B::Error> {
    let mut cluster = Cluster::default();
    loop {
        let velocities = approaches(bodies, near);
        // The time of each is compared as it is: multiplied by the velocity again it need not give the gap.
        let after = near.iter().zip(&velocities).map(|(near, &v)| {
            if v < 0.0 {
                near.gap / -v
            } else {
                f64::INFINITY
            }
        });
        let after: Vec<f64> = after.collect();
        let time = after.iter().copied().fold(f64::INFINITY, f64::min);
        if time == f64::INFINITY {
            break;
        }
        let exhausted = cluster.impacts == MOST_IMPACTS;
        let mut together = Vec::new();
        for ((near, &velocity), after) in near.iter_mut().zip(&velocities).zip(after) {
            let struck = after <= time;
            near.gap = if struck {
                0.0
            } else {
                (near.gap + velocity * time).max(0.0)
            };
            let rests = velocity == 0.0 && !near.sequence;
            if exhausted || near.gap == 0.0 && (velocity < 0.0 || rests) {
                together.push(near.contact);
            }
            if (struck || exhausted && velocity < 0.0) && !cluster.struck.contains(&near.contact) {
                cluster.struck.push(near.contact);
            }
        }
        let present = bodies.velocity().to_vec();
        cluster.numerical_time += match strike(bodies, &together, !exhausted) {
            Ok(time) => time,
            // Some of the contacts may jam alone where all together do not.
            Err(_) if !exhausted => {
                bodies.velocity().copy_from_slice(&present);
                cluster.impacts = MOST_IMPACTS;
                continue;
            }
            Err(error) => return Err(error),
        };
        cluster.impacts += 1;
        if exhausted {
            break;
        }
    }
    cluster.struck.sort_unstable();
    Ok(cluster)
}

/// The normal velocities, 0 of contacts that neither approach nor leave.
fn approaches<B: Bodies>(bodies: &mut B, near: &[NearContact]) -> Vec<f64> {
    let velocities = near.iter().map(|near| {
        let velocity = bodies.normal_velocity(near.contact);
        let rests = velocity.abs() <= bodies.zero_velocity(near.contact);
        if rests { 0.0 } else { velocity }
    });
    velocities.collect()
}

/// An impact that does not raise the kinetic energy on ground at rest.
fn strike<B: Bodies>(bodies: &mut B, together: &[usize], elastic: bool) -> Result<f64, B::Error> {
    let before = bodies.velocity().to_vec();
    let energy = bodies.kinetic_energy();
    let passive = elastic && !bodies.ground_moves(together);
    let time = bodies.strike(together, elastic)?;
    if passive && bodies.kinetic_energy() > energy * (1.0 + SAME_ENERGY) {
        bodies.velocity().copy_from_slice(&before);
        return bodies.strike(together, false);
    }
    Ok(time)
}
