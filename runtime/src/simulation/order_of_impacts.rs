//! Impacts whose order decides the motion: a contact touches, or nearly so, while another one is struck.
//!
//! At once by Moreau's law or one after the other, as a gap too small to be seen has it: for rigid bodies both are right, and
//! which of them a real body follows is a matter of its elasticity. A light ball on a heavy one leaves with three times the
//! speed in the one case and with its own in the other. Where the two differ the run says so, once.

use super::impact_cluster::{self, NearContact};
use super::{ContactMode, Event, EventKind, Simulation, number};
use crate::contact::impact;
use crate::fesd::contacts::{Contacts, ModeError, dot};
use crate::model::{ImpactLaw, Model};

/// Share of the range of a gap below which it is not told from touching: the error that runs promise.
const TOUCHES: f64 = 1e-6;
/// Share of the fastest approach so far by which the velocities after the two differ: what a curve in a figure shows.
const DIFFERS: f64 = 1e-3;

/// Share of the terms of a normal velocity that is rounding error.
const ROUNDING: f64 = 1e-12;

/// Notes the first impact of a run whose order decides, of contacts for which the scene does not say which.
pub(super) fn note(model: &dyn Model, result: &mut Simulation) {
    let contacts = model.declaration().contacts;
    let open = |i: &usize| !contacts[*i].dry && !contacts[*i].sequence;
    let open: Vec<usize> = (0..contacts.len()).filter(open).collect();
    if open.len() < 2 {
        return;
    }
    let mut bodies = Bodies::new(model);
    let ranges = ranges(&mut bodies, result);
    let mut fastest = 0.0_f64;
    let mut before: &[ContactMode] = &result.initial_modes;
    let mut first = 0;
    while let Some(event) = result.events.get(first) {
        let together = |other: &&Event| other.kind == event.kind && other.time == event.time;
        let end = first + result.events[first..].iter().take_while(together).count();
        if event.kind == EventKind::Impact {
            let struck: Vec<usize> = result.events[first..end]
                .iter()
                .map(|event| event.contact)
                .collect();
            bodies.place(event);
            for &i in &struck {
                fastest = fastest.max(-bodies.contacts.normal_velocity(i));
            }
            let closed =
                |i: usize| struck.contains(&i) || before.get(i).is_some_and(|mode| !mode.is_open());
            let near = near(&bodies, &open, &ranges, closed);
            if let Some(other) = decided_by_order(&mut bodies, &near, &struck, fastest) {
                let text = text(model, event, (struck[0], other));
                result.notes.push(text);
                return;
            }
        }
        before = &result.events[end - 1].modes;
        first = end;
    }
}

/// Largest size of each gap at the start, at the impacts and at the end; of one that never opens what its rounding error is told from.
fn ranges(bodies: &mut Bodies<'_>, result: &Simulation) -> Vec<f64> {
    let mut ranges = vec![0.0_f64; bodies.restitution.len()];
    let path = &result.trajectory;
    let ends = [path.q.first(), path.q.last()].into_iter().flatten();
    let ends = ends.zip([path.time.first(), path.time.last()].into_iter().flatten());
    let events = result.events.iter().map(|event| (&event.q, &event.time));
    for (q, time) in ends.chain(events) {
        bodies.x[..q.len()].copy_from_slice(q);
        bodies.at(*time);
        bodies.contacts.remember_sizes(&bodies.x);
        for (range, i) in ranges.iter_mut().zip(0..bodies.contacts.surfaces) {
            let rounding = bodies.contacts.size(i, *time).touching_gap();
            *range = range
                .max(bodies.contacts.gap(i).abs())
                .max(rounding / TOUCHES);
        }
    }
    ranges
}

/// The contacts that touch at the impact that is loaded, or are nearer than is told from touching.
fn near(
    bodies: &Bodies<'_>,
    open: &[usize],
    ranges: &[f64],
    closed: impl Fn(usize) -> bool,
) -> Vec<NearContact> {
    let near = open.iter().filter_map(|&contact| {
        let gap = bodies.contacts.gap(contact);
        let acts = !bodies.contacts.pieces.is_idle(contact);
        let touches = closed(contact);
        let near = touches || gap <= TOUCHES * ranges[contact];
        (acts && near).then_some(NearContact {
            contact,
            gap: if touches { 0.0 } else { gap.max(0.0) },
            rounding: 0.0,
            sequence: true,
        })
    });
    near.collect()
}

/// A contact that is `near` and not `struck`, or struck as well, without which the impact would lead elsewhere: where the impact of all at
/// once differs from impacts one after the other.
fn decided_by_order(
    bodies: &mut Bodies<'_>,
    near: &[NearContact],
    struck: &[usize],
    fastest: f64,
) -> Option<usize> {
    if near.len() < 2 || !near.iter().any(|near| struck.contains(&near.contact)) {
        return None;
    }
    let apart = impact_cluster::order_matters(bodies, near).ok()?;
    if apart.iter().all(|apart| *apart <= DIFFERS * fastest) {
        return None;
    }
    let others = near.iter().map(|near| near.contact);
    let mut others = others.filter(|&i| i != struck[0]);
    others
        .clone()
        .find(|i| !struck.contains(i))
        .or_else(|| others.next())
}

fn text(model: &dyn Model, event: &Event, (struck, other): (usize, usize)) -> String {
    let contacts = model.declaration().contacts;
    let (struck, other) = (contacts[struck].name, contacts[other].name);
    format!(
        "`{other}` touches, or nearly so, where `{struck}` is struck at {} s, and the order of impacts decides the motion: contacts \
         that touch are struck at once (Moreau's law); `impact {other}: ..., in sequence` strikes them one after the other, as a gap \
         too small to be seen would",
        number(event.time)
    )
}

/// The bodies of a scene at an impact.
struct Bodies<'a> {
    model: &'a dyn Model,
    contacts: Contacts<'a>,
    restitution: Vec<f64>,
    /// Input vector of the model.
    x: Vec<f64>,
    v: Vec<f64>,
}

impl<'a> Bodies<'a> {
    fn new(model: &'a dyn Model) -> Self {
        let declaration = model.declaration();
        let restitution = |(i, law)| match law {
            ImpactLaw::Inelastic => 0.0,
            ImpactLaw::Restitution => model.restitution(i),
        };
        let laws = declaration.contacts.iter().map(|known| known.law);
        Self {
            model,
            contacts: Contacts::new(model),
            restitution: laws.enumerate().map(restitution).collect(),
            x: vec![0.0; declaration.inputs()],
            v: vec![0.0; declaration.coordinates.len()],
        }
    }

    /// Loads the state right before an impact.
    fn place(&mut self, event: &Event) {
        self.x[..event.q.len()].copy_from_slice(&event.q);
        self.v.copy_from_slice(&event.v_before);
        self.at(event.time);
        self.contacts.pieces.choose(self.model, &self.x);
    }

    /// Evaluates all surfaces at a time \[s\].
    fn at(&mut self, time: f64) {
        if self.model.declaration().explicit_time
            && let Some(last) = self.x.last_mut()
        {
            *last = time;
        }
        self.evaluate(0..self.contacts.surfaces);
    }

    /// Evaluates these surfaces under the present velocities.
    fn evaluate(&mut self, surfaces: impl IntoIterator<Item = usize>) {
        let n = self.v.len();
        self.x[n..2 * n].copy_from_slice(&self.v);
        self.contacts.evaluate_contacts(&self.x, surfaces);
    }
}

impl impact_cluster::Bodies for Bodies<'_> {
    type Error = ModeError;

    fn velocity(&mut self) -> &mut [f64] {
        &mut self.v
    }

    fn kinetic_energy(&mut self) -> f64 {
        let n = self.v.len();
        let mut mass = vec![0.0; n * n];
        self.model.mass_matrix(&self.x, &mut mass);
        let momentum = mass.chunks_exact(n).map(|row| dot(row, &self.v));
        0.5 * momentum.zip(&self.v).map(|(p, v)| p * v).sum::<f64>()
    }

    fn ground_moves(&mut self, contacts: &[usize]) -> bool {
        self.evaluate(contacts.iter().copied());
        contacts
            .iter()
            .any(|&i| self.contacts.ground_moves(i, &self.v))
    }

    fn normal_velocity(&mut self, contact: usize) -> f64 {
        self.evaluate([contact]);
        self.contacts.normal_velocity(contact)
    }

    fn zero_velocity(&self, contact: usize) -> f64 {
        let normal = self.contacts.normal(contact);
        let terms = normal.iter().zip(&self.v).map(|(n, v)| (n * v).abs());
        ROUNDING * terms.sum::<f64>()
    }

    fn slowest_bounce(&self, contact: usize) -> f64 {
        if self.restitution[contact] > 0.0 {
            0.0
        } else {
            f64::INFINITY
        }
    }

    fn bring_to_rest(&mut self, contacts: &[usize]) {
        let restitution = vec![0.0; contacts.len()];
        let mut impulses = Vec::new();
        self.evaluate(contacts.iter().copied());
        // What cannot rest goes on as it is.
        let _ = impact::strike(
            &self.contacts,
            contacts,
            &restitution,
            &mut impulses,
            &mut self.v,
        );
    }

    fn strike(&mut self, together: &[usize], elastic: bool) -> Result<f64, ModeError> {
        self.evaluate(together.iter().copied());
        let restitution = together
            .iter()
            .map(|&i| if elastic { self.restitution[i] } else { 0.0 });
        let restitution: Vec<f64> = restitution.collect();
        let mut impulses = Vec::new();
        impact::strike(
            &self.contacts,
            together,
            &restitution,
            &mut impulses,
            &mut self.v,
        )?;
        Ok(0.0)
    }
}
