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
//! 4. Contacts that are left with less than the slowest bounce, or [`yardstick::PROMISE`], come to rest: without an end of bounces infinitely many
//!    impacts would bring them there, and whether they touch decides what the next impact does.
//!
//! Velocities after the cluster depend on the order of its impacts alone. Each gap is therefore changed by its
//! rounding error in turn: where the end differs, the order is not known.

use super::impact;
use super::line::Line;
use super::view::View;
use crate::yardstick;

/// Impacts of one cluster before it ends without restitution.
const MOST_IMPACTS: usize = 500;
/// A contact that may be struck in a cluster.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NearContact {
    pub(crate) contact: usize,
    /// Gap, 0 for a contact that is held or has just closed.
    pub(crate) gap: f64,
    /// What counts as closed of the gap, 0 for a contact that is held.
    pub(crate) rounding: f64,
    pub(crate) held: bool,
    /// Whether it takes part only where it approaches, although it rests.
    pub(crate) sequence: bool,
    /// Normal velocity below which it neither approaches nor leaves.
    pub(crate) zero: f64,
    pub(crate) restitution: f64,
    /// Speed up to which it does not bounce; infinite without restitution.
    pub(crate) slowest: f64,
}

impl NearContact {
    /// A contact at the last evaluation of a view, which has `held` it or counts gaps below `closed` as none, and velocities below
    /// `zero`. It does not bounce.
    pub(crate) fn new(
        view: &View<'_>,
        contact: usize,
        held: bool,
        (closed, zero): (f64, f64),
    ) -> Self {
        let gap = view.gap(contact).max(0.0);
        let (gap, rounding) = if held { (0.0, 0.0) } else { (gap, closed) };
        Self {
            contact,
            gap,
            rounding,
            held,
            sequence: view.model.declaration().contacts[contact].sequence,
            zero,
            restitution: 0.0,
            slowest: f64::INFINITY,
        }
    }

    /// The cluster with a coefficient of `restitution` for what is faster than the `slowest` bounce.
    pub(crate) fn bouncing(self, restitution: f64, slowest: f64) -> Self {
        Self {
            restitution,
            slowest,
            ..self
        }
    }

    /// Whether it has left its surface and goes on leaving, so that it is not struck at the instant at which others are. At the
    /// start only its gap tells, beside its rounding `error`.
    pub(crate) fn leaves(&self, view: &View<'_>, (at_start, error): (bool, f64)) -> bool {
        !self.held
            && (!at_start || view.gap(self.contact) > error)
            && view.normal_velocity(self.contact) > self.zero
    }
}

/// Whether the scene wants contacts that touch to be struck one after the other.
pub(crate) fn in_sequence(near: &[NearContact]) -> bool {
    near.len() > 1 && near.iter().any(|near| near.sequence)
}

/// Bodies in a cluster, at one position.
pub(crate) struct Bodies<'b, 'a, S> {
    pub(crate) view: &'b mut View<'a>,
    /// Input vector of the model; the velocities in it jump.
    pub(crate) x: &'b mut [f64],
    /// Changes velocities by the impact of contacts, which are evaluated, with these coefficients of restitution. Returns the largest
    /// normal impulse.
    pub(crate) strike: S,
}

impl<'a, E, S: FnMut(&View<'a>, &[usize], &[f64], &mut [f64]) -> Result<f64, E>> Bodies<'_, 'a, S> {
    fn velocity(&mut self) -> &mut [f64] {
        let n = self.view.n;
        &mut self.x[n..2 * n]
    }

    fn normal_velocity(&mut self, contact: usize) -> f64 {
        self.view.evaluate_normal(contact, self.x);
        self.view.normal_velocity(contact)
    }

    fn normal_velocities(&mut self, near: &[NearContact]) -> Vec<f64> {
        near.iter()
            .map(|near| self.normal_velocity(near.contact))
            .collect()
    }

    /// For each coordinate the places of the contacts `near` whose normal velocities it changes, as last evaluated.
    fn movers(&self, near: &[NearContact]) -> Vec<Vec<usize>> {
        let mut movers = vec![Vec::new(); self.view.n];
        for (place, near) in near.iter().enumerate() {
            let normal = self.view.normal(near.contact).iter().enumerate();
            for (k, _) in normal.filter(|(_, component)| **component != 0.0) {
                movers[k].push(place);
            }
        }
        movers
    }

    /// Evaluates those `velocities` of the contacts `near` anew that have changed since the velocities of the bodies were `before`.
    fn follow(
        &mut self,
        near: &[NearContact],
        (before, movers): (&[f64], &[Vec<usize>]),
        velocities: &mut [f64],
    ) {
        let present = self.velocity().iter().zip(before).enumerate();
        let moved = present.filter(|(_, (now, before))| now != before);
        let mut places: Vec<usize> = moved.flat_map(|(k, _)| movers[k].iter().copied()).collect();
        places.sort_unstable();
        places.dedup();
        for place in places {
            velocities[place] = self.normal_velocity(near[place].contact);
        }
    }

    /// An impact of those of the contacts `near` at these places that does not raise the kinetic energy on ground at rest.
    fn strike(
        &mut self,
        near: &[NearContact],
        together: &[usize],
        elastic: bool,
    ) -> Result<f64, E> {
        // Without restitution nothing is sent back that could raise it.
        let elastic = elastic && together.iter().any(|&place| near[place].restitution > 0.0);
        if !elastic {
            return self.strike_once(near, together, false);
        }
        let before = self.velocity().to_vec();
        let energy = self.view.kinetic_energy(self.x);
        let impulse = self.strike_once(near, together, true)?;
        let contacts = together.iter().map(|&place| near[place].contact);
        let mut still = self.x.to_vec();
        still[self.view.n..2 * self.view.n].copy_from_slice(&before);
        for contact in contacts.clone() {
            self.view.evaluate_sides(contact, &still);
        }
        let passive = !contacts.clone().any(|i| self.view.ground_moves(i, &before));
        if passive && impact::gain(energy, self.view.kinetic_energy(self.x)).is_some() {
            self.velocity().copy_from_slice(&before);
            return self.strike_once(near, together, false);
        }
        Ok(impulse)
    }

    fn strike_once(
        &mut self,
        near: &[NearContact],
        together: &[usize],
        elastic: bool,
    ) -> Result<f64, E> {
        let mut restitution = Vec::with_capacity(together.len());
        let mut contacts = Vec::with_capacity(together.len());
        for &place in together {
            let near = &near[place];
            contacts.push(near.contact);
            self.view.evaluate_sides(near.contact, self.x);
            let speed = -self.view.normal_velocity(near.contact);
            restitution.push(if elastic && speed > near.slowest {
                near.restitution
            } else {
                0.0
            });
        }
        let n = self.view.n;
        (self.strike)(self.view, &contacts, &restitution, &mut self.x[n..2 * n])
    }
}

/// What a cluster did.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cluster {
    /// Contacts struck, increasing.
    pub(crate) struck: Vec<usize>,
    /// Impacts one after the other.
    pub(crate) impacts: usize,
    /// Sum of the largest normal impulses of the impacts.
    pub(crate) impulse: f64,
    /// Whether rounding errors of the gaps change the velocities after it.
    pub(crate) undecided: bool,
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
    pub(crate) fn note(&self, too_fast: bool) -> Option<&'static str> {
        if self.undecided {
            Some(UNDECIDED)
        } else if too_fast && self.impacts > 1 {
            Some(JOINED)
        } else {
            None
        }
    }
}

/// Carries out the cluster of the contacts `near`.
///
/// # Errors
/// That of an impact without a solution.
pub(crate) fn resolve<'a, E, S>(
    bodies: &mut Bodies<'_, 'a, S>,
    near: &[NearContact],
) -> Result<Cluster, E>
where
    S: FnMut(&View<'a>, &[usize], &[f64], &mut [f64]) -> Result<f64, E>,
{
    let before = bodies.velocity().to_vec();
    let speeds = bodies.normal_velocities(near);
    let largest = speeds
        .iter()
        .fold(0.0_f64, |most, speed| most.max(speed.abs()));
    let mut others = Vec::new();
    for changed in 0..near.len() {
        if near[changed].rounding > 0.0 {
            let mut near = near.to_vec();
            near[changed].gap += near[changed].rounding;
            run(bodies, &mut near)?;
            others.push(bodies.normal_velocities(&near));
            bodies.velocity().copy_from_slice(&before);
        }
    }
    let mut cluster = run(bodies, &mut near.to_vec())?;
    let after = bodies.normal_velocities(near);
    cluster.undecided = others.iter().any(|other| {
        let mut pairs = other.iter().zip(&after);
        pairs.any(|(other, after)| (other - after).abs() > yardstick::PROMISE * largest)
    });
    let struck = near.iter().zip(after);
    let struck = struck.filter(|(near, _)| cluster.struck.contains(&near.contact));
    let slowest = struck.clone().map(|(near, _)| near.slowest);
    let slowest = slowest.filter(|speed| speed.is_finite());
    let slowest = slowest.fold(yardstick::PROMISE * largest, f64::max);
    let resting = struck.filter(|(_, velocity)| velocity.abs() <= slowest);
    let mut resting: Vec<usize> = resting.map(|(near, _)| near.contact).collect();
    resting.sort_unstable();
    impact::bring_to_rest(bodies.view, &resting, bodies.x);
    Ok(cluster)
}

/// Whether impacts one after the other end where the impact of all at once does, whatever their order: without restitution and friction,
/// each adds to the impulse of its contact what its approach asks for. Where no impulse takes approach from another contact (`K_ij <= 0`), as
/// in a row or a tower, the impulses grow towards the least ones that leave no approach, which are those of the impact at once.
///
/// Source: Cottle, Pang, Stone, *The Linear Complementarity Problem*, sections 3.11 and 5.5, on matrices without positive entries beside the
/// diagonal.
fn lead_to_one_end<S>(bodies: &mut Bodies<'_, '_, S>, near: &[NearContact]) -> bool {
    let view = &mut *bodies.view;
    let grips = |near: &NearContact| view.has_friction(near.contact) || view.is_dry(near.contact);
    if near
        .iter()
        .any(|near| near.restitution > 0.0 || grips(near))
    {
        return false;
    }
    for near in near {
        view.evaluate_normal(near.contact, bodies.x);
    }
    let lines: Vec<Line> = near.iter().map(|near| Line::normal(near.contact)).collect();
    let couplings = view.sparse_couplings(&lines);
    let mut others = couplings.iter().filter(|(i, j, _)| i != j);
    others.all(|(.., coupling)| *coupling <= 0.0)
}

/// By how much the normal velocities after the impact of all contacts `near` at once differ from those after impacts one after
/// the other; the velocities are as before.
///
/// # Errors
/// That of an impact without a solution.
pub(crate) fn order_matters<'a, E, S>(
    bodies: &mut Bodies<'_, 'a, S>,
    near: &[NearContact],
) -> Result<Vec<f64>, E>
where
    S: FnMut(&View<'a>, &[usize], &[f64], &mut [f64]) -> Result<f64, E>,
{
    if lead_to_one_end(bodies, near) {
        return Ok(vec![0.0; near.len()]);
    }
    let before = bodies.velocity().to_vec();
    let sequence = run(bodies, &mut near.to_vec()).map(|_| bodies.normal_velocities(near));
    bodies.velocity().copy_from_slice(&before);
    let places: Vec<usize> = (0..near.len()).collect();
    let together = bodies.strike_once(near, &places, true);
    let together = together.map(|_| bodies.normal_velocities(near));
    bodies.velocity().copy_from_slice(&before);
    let pairs = sequence?.into_iter().zip(together?);
    Ok(pairs.map(|(one, other)| (one - other).abs()).collect())
}

/// The impacts in their order; `near` follows the gaps.
fn run<'a, E, S>(bodies: &mut Bodies<'_, 'a, S>, near: &mut [NearContact]) -> Result<Cluster, E>
where
    S: FnMut(&View<'a>, &[usize], &[f64], &mut [f64]) -> Result<f64, E>,
{
    let mut cluster = Cluster::default();
    let mut known = bodies.normal_velocities(near);
    let movers = bodies.movers(near);
    loop {
        // 0 of contacts that neither approach nor leave.
        let mut velocities = known.clone();
        for (velocity, near) in velocities.iter_mut().zip(&*near) {
            if velocity.abs() <= near.zero {
                *velocity = 0.0;
            }
        }
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
        for (place, near) in near.iter_mut().enumerate() {
            let (velocity, struck) = (velocities[place], after[place] <= time);
            near.gap = if struck {
                0.0
            } else {
                (near.gap + velocity * time).max(0.0)
            };
            let rests = velocity == 0.0 && !near.sequence;
            if exhausted || near.gap == 0.0 && (velocity < 0.0 || rests) {
                together.push(place);
            }
            if (struck || exhausted && velocity < 0.0) && !cluster.struck.contains(&near.contact) {
                cluster.struck.push(near.contact);
            }
        }
        let present = bodies.velocity().to_vec();
        cluster.impulse += match bodies.strike(near, &together, !exhausted) {
            Ok(impulse) => impulse,
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
        bodies.follow(near, (&present, &movers), &mut known);
    }
    cluster.struck.sort_unstable();
    Ok(cluster)
}

#[cfg(test)]
mod tests {
    use crate::linalg::lcp;
    use crate::random_cases::same_in_every_run;
    use proptest::prelude::*;

    /// Velocities after impacts without restitution one after the other, the fastest approach first, of contacts with these couplings,
    /// row-major with ones on the diagonal.
    fn one_after_the_other(couplings: &[f64], mut velocities: Vec<f64>) -> Vec<f64> {
        let n = velocities.len();
        for _ in 0..20_000 {
            let fastest = (0..n).min_by(|&i, &j| velocities[i].total_cmp(&velocities[j]));
            let struck = fastest.expect("contacts");
            let impulse = -velocities[struck];
            if impulse <= 1e-14 {
                break;
            }
            for (i, velocity) in velocities.iter_mut().enumerate() {
                *velocity += couplings[i * n + struck] * impulse;
            }
        }
        velocities
    }

    proptest! {
        #![proptest_config(same_in_every_run())]
        /// What [`lead_to_one_end`](super::lead_to_one_end) says, against Lemke's method for the impact at once.
        #[test]
        fn impacts_that_take_no_approach_from_others_end_as_at_once(
            sizes in proptest::collection::vec(0.0..0.16_f64, 36),
            before in proptest::collection::vec(-1.0..1.0_f64, 6),
        ) {
            let n = before.len();
            let entry = |at: usize| if at.is_multiple_of(n + 1) { 1.0 } else { -sizes[at] };
            let couplings: Vec<f64> = (0..n * n).map(entry).collect();
            let mut impulses = vec![0.0; n];
            prop_assert!(lcp::solve(&couplings, &before, &mut impulses).is_ok());
            let at_once = (0..n).map(|i| {
                let row = couplings[i * n..][..n].iter().zip(&impulses);
                before[i] + row.map(|(k, p)| k * p).sum::<f64>()
            });
            let in_turn = one_after_the_other(&couplings, before.clone());
            for (at_once, in_turn) in at_once.zip(in_turn) {
                // Row sums are above 0.2: what is left of approaches counts five times at most.
                prop_assert!((at_once - in_turn).abs() < 1e-12, "{at_once} and {in_turn}");
            }
        }
    }
}
