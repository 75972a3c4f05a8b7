//! The impulses of impacts, as the jumps of the velocities tell them.
//!
//! Positions stay in an impact, and the velocities jump along the directions of the contacts that are closed, so that
//!
//! ```text
//! v+ - v- = sum_i d_i p_i + e_i s_i        P_i = p_i / D_i,  S_i = s_i / D_i
//! ```
//!
//! with the normal impulse `P_i` and the tangential one `S_i` \[N s for a gap in metres\]. A contact that slides
//! afterwards has `s_i = -mu p_i sign(v_t,i+)`, see [`Contacts`]. Where the directions are dependent, so that many impulses
//! give the same jump, the smallest are taken: those of equal contacts are equal, and those
//! that stick share friction by their loads.

use super::recorder::Impulses;
use super::{ContactMode, Event, EventKind, Simulation, Trajectory};
use crate::fesd::contacts::{Contacts, Line};
use crate::linalg::least_norm::LeastNorm;
use crate::model::{Model, friction_share};
use crate::yardstick;

/// Sliding velocity after an impact, as a share of the velocities of its contact before, that counts as none.
const STICKS: f64 = 1e-8;
/// Records the impulses of all impacts of a run, at their events and along its trajectory.
pub(super) fn record(model: &dyn Model, result: &mut Simulation) {
    if result.counts.events > result.events.len() {
        // What those gave that are left out is not known.
        return;
    }
    let contacts = model.declaration().contacts.len();
    let mut declared = model.declaration().contacts.iter();
    let rubs = declared.any(|known| known.friction.is_some());
    let mut sums = vec![vec![0.0; 2 * contacts]];
    let mut impacts: Vec<(f64, Vec<f64>)> = Vec::new();
    let mut at_start = true;
    let mut evaluated = Contacts::new(model);
    let mut first = 0;
    while let Some(event) = result.events.get(first) {
        let together = |other: &&Event| {
            other.kind == event.kind && other.time == event.time && other.v_before == event.v_before
        };
        let end = first + result.events[first..].iter().take_while(together).count();
        if event.kind == EventKind::Impact {
            let before = match first {
                0 => &result.initial_modes,
                _ => &result.events[first - 1].modes,
            };
            let group = &result.events[first..end];
            let is_start = at_start && event.time == 0.0;
            let impulses = of_impact(&mut evaluated, before, group, is_start);
            let sum: Vec<f64> = sums
                .last()
                .into_iter()
                .flatten()
                .zip(&impulses)
                .map(|(sum, own)| sum + own)
                .collect();
            sums.push(sum);
            impacts.push((event.time, event.v_before.clone()));
            for event in &mut result.events[first..end] {
                event.contact_impulse = impulses[..contacts].to_vec();
                if rubs {
                    event.friction_impulse = impulses[contacts..].to_vec();
                }
            }
        }
        at_start = false;
        first = end;
    }
    let done = done(&impacts, &result.trajectory);
    result.trajectory.impulses = Some(Impulses { done, sums });
}

/// How many of the `impacts`, each by its time and the velocities before it, are over at each instant.
fn done(impacts: &[(f64, Vec<f64>)], trajectory: &Trajectory) -> Vec<usize> {
    let mut over = 0;
    let instants = 0..trajectory.time.len();
    instants
        .map(|k| {
            let now = trajectory.time[k];
            // Both sides of a jump stand at the same time: the last of them with the velocities before is before it.
            let is_before = |velocities: &Vec<f64>| {
                (k..trajectory.time.len())
                    .take_while(|&later| trajectory.time[later] == now)
                    .any(|later| trajectory.v[later] == *velocities)
            };
            while let Some((time, before)) = impacts.get(over)
                && (*time < now || *time == now && !is_before(before))
            {
                over += 1;
            }
            over
        })
        .collect()
}

/// Normal impulses of all contacts, then tangential ones, of an impact by its `events`; not a number where its equations
/// have no solution. `before` are the modes before it.
fn of_impact(
    contacts: &mut Contacts<'_>,
    before: &[ContactMode],
    events: &[Event],
    at_start: bool,
) -> Vec<f64> {
    let model = contacts.model;
    let count = model.declaration().contacts.len();
    let mut impulses = vec![0.0; 2 * count];
    let Some(event) = events.first() else {
        return impulses;
    };
    let surfaces = 0..contacts.surfaces;
    let mut input = [&event.q[..], &event.v_before[..]].concat();
    input.resize(model.declaration().inputs(), 0.0);
    if model.declaration().explicit_time
        && let Some(time) = input.last_mut()
    {
        *time = event.time;
    }
    let closed = |modes: &[ContactMode], i: usize| modes.get(i).is_some_and(|mode| !mode.is_open());
    let struck = |i: usize| events.iter().any(|event| event.contact == i);
    // What touched before the start is told by its gap alone.
    let gaps = events.iter();
    let gaps = gaps.map(|event| model.gap(event.contact, &input).abs());
    let largest = at_start.then(|| gaps.fold(0.0, f64::max));
    let touches = |i: usize| largest.is_some_and(|largest| model.gap(i, &input) <= largest);
    let takes_part =
        |&i: &usize| struck(i) || closed(before, i) || closed(&event.modes, i) || touches(i);
    let together: Vec<usize> = surfaces.filter(takes_part).collect();
    let n = event.q.len();
    let mut jump = Jump {
        tangential: vec![(0.0, 0.0); count],
        normal: vec![0.0; count],
        shares: vec![(1.0, 1.0); count],
        contacts,
        together,
    };
    for (velocities, sign) in [(&event.v_before, -1.0), (&event.v_after, 1.0)] {
        input[n..2 * n].copy_from_slice(velocities);
        jump.add_velocities(&input, sign);
        for &contact in &jump.together {
            let share = friction_share(model, contact, &input);
            let shares = &mut jump.shares[contact];
            *shares = (shares.1, share);
        }
    }
    jump.align();
    let mut across = vec![0.0; count];
    let found = jump.impulses(false).or_else(|| jump.impulses(true));
    for (line, impulse) in found.unwrap_or_else(|| jump.unknown()) {
        match line {
            Line::Normal { contact, slope } => {
                impulses[contact] += impulse;
                impulses[count + contact] += slope * impulse * jump.shares[contact].1;
            }
            Line::Tangent { contact, .. } => {
                impulses[count + contact] += impulse * jump.shares[contact].1;
            }
            Line::Across { contact } => across[contact] += impulse * jump.shares[contact].1,
        }
    }
    for contact in (0..count).filter(|&i| jump.contacts.is_in_space(i)) {
        impulses[count + contact] = impulses[count + contact].hypot(across[contact]);
    }
    impulses
}

/// The jump of the velocities of the contacts that take part.
struct Jump<'c, 'a> {
    /// Evaluated with the velocities after the impact.
    contacts: &'c mut Contacts<'a>,
    together: Vec<usize>,
    /// Jump of the normal and of the sliding velocities of each contact, of which there are two in space.
    normal: Vec<f64>,
    tangential: Vec<(f64, f64)>,
    /// What the friction directions carry before the impact, which its law reads, and after it, where they are evaluated.
    shares: Vec<(f64, f64)>,
}

impl Jump<'_, '_> {
    /// Adds the velocities at `input`, multiplied by `sign`.
    fn add_velocities(&mut self, input: &[f64], sign: f64) {
        let together = self.together.iter().copied();
        self.contacts.evaluate_contacts(input, together);
        for &i in &self.together {
            self.normal[i] += sign * self.contacts.normal_velocity(i);
            if self.contacts.friction(i) > 0.0 {
                let (along, across) = self.contacts.sliding(i);
                self.tangential[i].0 += sign * along;
                self.tangential[i].1 += sign * across;
            }
        }
    }

    /// Lets the frames of contacts in space point along the sliding after the impact.
    fn align(&mut self) {
        for k in 0..self.together.len() {
            let i = self.together[k];
            if !self.contacts.is_in_space(i) {
                continue;
            }
            let (along, across) = self.contacts.sliding(i);
            let size = along.hypot(across);
            if size > 0.0 {
                let jump = self.tangential[i];
                self.tangential[i] = (
                    (along * jump.0 + across * jump.1) / size,
                    (along * jump.1 - across * jump.0) / size,
                );
                self.contacts.align(i, Some((along, across)));
            }
        }
    }

    /// Size of the jump of the sliding velocity of a contact.
    fn sliding_jump(&self, contact: usize) -> f64 {
        let (along, across) = self.tangential[contact];
        if across == 0.0 {
            along.abs()
        } else {
            along.hypot(across)
        }
    }

    /// The lines of the impulses, and the weights of their sizes: one of a contact that slides afterwards, unless it
    /// `may_stick`, two of one that sticks under a share of the `loads`.
    fn lines(&self, may_stick: bool, loads: &[f64]) -> Vec<(Line, f64)> {
        let contacts = &*self.contacts;
        let mut lines = Vec::with_capacity(2 * self.together.len());
        for (&contact, &load) in self.together.iter().zip(loads) {
            let friction = contacts.friction(contact);
            let after = match friction {
                0.0 => 0.0,
                _ => contacts.sliding_velocity(contact),
            };
            let size = self.sliding_jump(contact) + self.normal[contact].abs();
            let sticks = friction > 0.0 && (may_stick || after.abs() <= STICKS * size);
            let slope = if sticks || friction == 0.0 {
                0.0
            } else {
                let (before, now) = self.shares[contact];
                -contacts.kinetic(contact) * (before / now) * after.signum()
            };
            lines.push((Line::Normal { contact, slope }, 1.0));
            if sticks && load > yardstick::NOTHING {
                let sense = 1.0;
                lines.push((Line::Tangent { contact, sense }, load.sqrt()));
                if contacts.is_in_space(contact) {
                    lines.push((Line::Across { contact }, load.sqrt()));
                }
            }
        }
        lines
    }

    /// The impulses; `None` where they miss the jump of a sliding velocity.
    fn impulses(&self, may_stick: bool) -> Option<Vec<(Line, f64)>> {
        // Contacts that stick together share their friction by their loads, so that it lies within the law.
        let mut loads = vec![1.0; self.together.len()];
        let first = self.along(&self.lines(may_stick, &loads))?;
        let largest = first.iter().fold(0.0_f64, |largest, (line, impulse)| {
            largest.max(match line {
                Line::Normal { .. } => *impulse,
                Line::Tangent { .. } | Line::Across { .. } => 0.0,
            })
        });
        let normal = first.iter().filter_map(|(line, impulse)| match line {
            Line::Normal { .. } => Some(*impulse),
            Line::Tangent { .. } | Line::Across { .. } => None,
        });
        for (load, impulse) in loads.iter_mut().zip(normal) {
            *load = (impulse / largest).max(0.0);
        }
        let impulses = self.along(&self.lines(may_stick, &loads))?;
        (may_stick || self.explains(&impulses)).then_some(impulses)
    }

    /// The smallest impulses along these lines, each size divided by its weight.
    fn along(&self, weighted: &[(Line, f64)]) -> Option<Vec<(Line, f64)>> {
        let lines: Vec<Line> = weighted.iter().map(|&(line, _)| line).collect();
        // Measured by the inertia of its contact, each equation weighs the same: 1.
        let unit = |line: Line| self.contacts.force(line.contact(), 1.0).sqrt();
        let jump = |line: Line| match line {
            Line::Normal { contact, .. } => self.normal[contact],
            Line::Tangent { contact, .. } => self.tangential[contact].0,
            Line::Across { contact } => self.tangential[contact].1,
        };
        let rows = weighted
            .iter()
            .map(|&(line, weight)| weight * unit(line) * jump(line));
        let rows: Vec<f64> = rows.collect();
        let couplings = self.contacts.couplings(&lines);
        let mut matrix = Vec::with_capacity(couplings.len());
        for (row, &(line, weight)) in couplings.chunks_exact(lines.len()).zip(weighted) {
            let columns = row.iter().zip(weighted);
            matrix.extend(columns.map(|(coupling, &(column, its))| {
                weight * unit(line) * coupling * its / unit(column)
            }));
        }
        let found = LeastNorm::of(&matrix, rows.len())?.solve(&rows).0;
        let impulses = weighted.iter().zip(found);
        let impulses = impulses.map(|(&(line, weight), value)| (line, weight * unit(line) * value));
        Some(impulses.collect())
    }

    /// Whether the impulses make the sliding velocities jump as they do.
    fn explains(&self, impulses: &[(Line, f64)]) -> bool {
        let rubbing = self.together.iter().copied();
        let mut rubbing = rubbing.filter(|&i| self.contacts.friction(i) > 0.0);
        rubbing.all(|contact| {
            let sense = 1.0;
            let along = Line::Tangent { contact, sense };
            let rows = [along, Line::Across { contact }];
            let count = if self.contacts.is_in_space(contact) {
                2
            } else {
                1
            };
            let size = self.sliding_jump(contact) + self.normal[contact].abs();
            let jumps = [self.tangential[contact].0, self.tangential[contact].1];
            rows[..count].iter().zip(jumps).all(|(&row, jump)| {
                let made = impulses.iter().map(|&(line, impulse)| {
                    let velocity = impulse / self.contacts.force(line.contact(), 1.0);
                    self.contacts.coupling(row, line) * velocity
                });
                (made.sum::<f64>() - jump).abs() <= yardstick::PROMISE * size
            })
        })
    }

    /// Not a number for every contact that takes part.
    fn unknown(&self) -> Vec<(Line, f64)> {
        let lines = self.lines(true, &vec![1.0; self.together.len()]);
        let lines = lines.into_iter();
        lines.map(|(line, _)| (line, f64::NAN)).collect()
    }
}
