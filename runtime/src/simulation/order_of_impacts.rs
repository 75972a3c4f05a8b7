//! Impacts whose order decides the motion: a contact touches, or nearly so, while another one is struck.
//!
//! At once by Moreau's law or one after the other, as a gap too small to be seen has it: for rigid scene both are right, and
//! which of them a real body follows is a matter of its elasticity. A light ball on a heavy one leaves with three times the
//! speed in the one case and with its own in the other. Where the two differ the run says so, once.

use super::{ContactMode, Event, EventKind, Simulation, number};
use crate::contact::cluster::{self, Bodies, NearContact};
use crate::contact::{View, impact, sum_of_sizes};
use crate::fesd::contacts::Contacts;
use crate::model::{ImpactLaw, Model};
use crate::yardstick;

/// Share of the range of a gap, or of the largest coordinate, up to which it is looked at closer. Chosen: far above [`yardstick::PROMISE`], so that what is
/// left out could be nearly touching only by the rounding of terms 1e9 times as large as the gap.
const LOOKED_AT: f64 = 1e-3;

/// Notes the first impact of a run whose order decides, of contacts for which the scene does not say which.
pub(super) fn note(model: &dyn Model, result: &mut Simulation) {
    let contacts = model.declaration().contacts;
    let open = |i: &usize| !contacts[*i].dry && !contacts[*i].sequence;
    let open: Vec<usize> = (0..contacts.len()).filter(open).collect();
    if open.len() < 2 {
        return;
    }
    let mut scene = Scene::new(model);
    scene.look(result);
    let open: Vec<usize> = open
        .into_iter()
        .filter(|i| scene.looked_at.binary_search(i).is_ok())
        .collect();
    if open.len() < 2 {
        return;
    }
    let ranges = ranges(&mut scene, result);
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
            scene.place(event);
            for &i in struck
                .iter()
                .filter(|i| scene.looked_at.binary_search(i).is_ok())
            {
                fastest = fastest.max(-scene.contacts.normal_velocity(i));
            }
            let closed =
                |i: usize| struck.contains(&i) || before.get(i).is_some_and(|mode| !mode.is_open());
            let near = near(&scene, &open, &ranges, closed);
            if let Some(other) = decided_by_order(&mut scene, &near, &struck, fastest) {
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
fn ranges(scene: &mut Scene<'_>, result: &Simulation) -> Vec<f64> {
    let mut ranges = vec![0.0_f64; scene.restitution.len()];
    for (q, time) in instants(result) {
        scene.x[..q.len()].copy_from_slice(q);
        scene.at(time);
        scene
            .contacts
            .remember_sizes(&scene.x, scene.looked_at.iter().copied());
        for &i in &scene.looked_at {
            let rounding = scene.contacts.size(i, time).touching_gap();
            ranges[i] = ranges[i]
                .max(scene.contacts.gap(i).abs())
                .max(rounding / yardstick::PROMISE);
        }
    }
    ranges
}

/// Positions and times of the start, the end, and the events of a run.
fn instants(result: &Simulation) -> impl Iterator<Item = (&Vec<f64>, f64)> {
    let path = &result.trajectory;
    let ends = [path.q.first(), path.q.last()].into_iter().flatten();
    let ends = ends.zip([path.time.first(), path.time.last()].into_iter().flatten());
    let events = result.events.iter().map(|event| (&event.q, &event.time));
    ends.chain(events).map(|(q, time)| (q, *time))
}

/// The contacts that touch at the impact that is loaded, or are nearer than is told from touching.
fn near(
    scene: &Scene<'_>,
    open: &[usize],
    ranges: &[f64],
    closed: impl Fn(usize) -> bool,
) -> Vec<NearContact> {
    let near = open.iter().filter_map(|&contact| {
        let gap = scene.contacts.gap(contact);
        let acts = !scene.contacts.pieces.is_idle(contact);
        let touches = closed(contact);
        let near = touches || gap <= yardstick::PROMISE * ranges[contact];
        let terms = sum_of_sizes(scene.contacts.normal(contact), &scene.v);
        let restitution = scene.restitution[contact];
        let slowest = if restitution > 0.0 {
            0.0
        } else {
            f64::INFINITY
        };
        let known = NearContact {
            sequence: true,
            ..NearContact::new(
                &scene.contacts,
                contact,
                touches,
                (0.0, yardstick::ROUNDING * terms),
            )
        };
        (acts && near).then_some(known.bouncing(restitution, slowest))
    });
    near.collect()
}

/// A contact that is `near` and not `struck`, or struck as well, without which the impact would lead elsewhere: where the impact of all at
/// once differs from impacts one after the other.
fn decided_by_order(
    scene: &mut Scene<'_>,
    near: &[NearContact],
    struck: &[usize],
    fastest: f64,
) -> Option<usize> {
    if near.len() < 2 || !near.iter().any(|near| struck.contains(&near.contact)) {
        return None;
    }
    let mut struck_together = Bodies {
        view: &mut scene.contacts,
        x: &mut scene.x,
        strike: |view: &View<'_>, together: &[usize], restitution: &[f64], v: &mut [f64]| {
            impact::strike(view, together, restitution, v).map(|_| 0.0)
        },
    };
    let apart = cluster::order_matters(&mut struck_together, near).ok()?;
    if apart
        .iter()
        .all(|apart| *apart <= yardstick::VISIBLE * fastest)
    {
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

/// A scene at an impact.
struct Scene<'a> {
    model: &'a dyn Model,
    contacts: Contacts<'a>,
    restitution: Vec<f64>,
    /// Surfaces that come near to touching.
    looked_at: Vec<usize>,
    /// Input vector of the model.
    x: Vec<f64>,
    v: Vec<f64>,
}

impl<'a> Scene<'a> {
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
            looked_at: Vec::new(),
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

    /// Finds the surfaces that come near to touching at an instant of a run.
    fn look(&mut self, result: &Simulation) {
        let mut least = vec![f64::INFINITY; self.contacts.surfaces];
        let mut most = vec![0.0_f64; self.contacts.surfaces];
        let mut size = 0.0_f64;
        for (q, time) in instants(result) {
            self.x[..q.len()].copy_from_slice(q);
            self.set_time(time);
            size = q.iter().fold(size, |size, q| size.max(q.abs()));
            for (i, (least, most)) in least.iter_mut().zip(&mut most).enumerate() {
                let gap = self.model.gap(i, &self.x).abs();
                (*least, *most) = (least.min(gap), most.max(gap));
            }
        }
        let near = |i: &usize| least[*i] <= LOOKED_AT * most[*i].max(size);
        self.looked_at = (0..self.contacts.surfaces).filter(near).collect();
    }

    /// Evaluates the surfaces that come near at a time \[s\].
    fn at(&mut self, time: f64) {
        self.set_time(time);
        self.evaluate(self.looked_at.clone());
    }

    fn set_time(&mut self, time: f64) {
        if self.model.declaration().explicit_time
            && let Some(last) = self.x.last_mut()
        {
            *last = time;
        }
    }

    /// Evaluates these surfaces under the present velocities.
    fn evaluate(&mut self, surfaces: impl IntoIterator<Item = usize>) {
        let n = self.v.len();
        self.x[n..2 * n].copy_from_slice(&self.v);
        self.contacts.evaluate_contacts(&self.x, surfaces);
    }
}
