//! How far each quantity may go until the motion has another sequence of events, to first order.
//!
//! A sequence stays as long as its margins do: gaps of open contacts and forces of closed ones, the friction that a sticking contact has
//! left, the velocity of one that slides, the speed of an impact, and the time between two events. A margin `m` with the derivative
//! `m'` vanishes at the distance `-m/m'`, and the smallest of these to each side ends the range. Over an arc only its least
//! values count: where a margin begins to grow, at the arc's ends, and where its rate changes its sign within a step. There the
//! instant does not matter to first order; ends of arcs move with their events.
//!
//! The speed `s` of an impact vanishes like a square root where a surface is only just reached, so that its margin is `s^2`.

use super::jump::Jump;
use super::margins::Margin;
use super::place::Place;
use super::tangent::{Tangent, add};
use crate::model::tangent_point;
use crate::simulation::{ContactMode, Event, number};
use serde::Serialize;

/// Share of its size that a margin has which an event ends.
const ENDED: f64 = 1e-5;
/// Share of the largest velocity that counts as none after an impact.
const AT_REST: f64 = 1e-8;

/// How far one quantity may go, to first order.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct SequenceRange {
    /// Towards smaller values; none, in JSON null, where nothing ends it.
    pub below: Option<SequenceLimit>,
    /// Towards larger values.
    pub above: Option<SequenceLimit>,
}

/// What ends a range.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SequenceLimit {
    /// Change of the quantity there, in its unit; below 0 towards smaller values.
    pub change: f64,
    /// What is another then, with the contact and the time.
    pub because: String,
}

/// The ranges of all quantities, as far as a walk has come.
pub(super) struct Ranges {
    found: Vec<SequenceRange>,
    /// Time and words of the last event, and the derivatives of that time.
    event: Option<(f64, String, Vec<f64>)>,
}

impl Ranges {
    pub(super) fn new(count: usize) -> Self {
        Self {
            found: vec![SequenceRange::default(); count],
            event: None,
        }
    }

    /// Takes a margin of this value and these derivatives, by quantity, into account.
    fn consider(&mut self, value: f64, by: &[f64], words: &dyn Fn() -> String) {
        for (found, by) in self.found.iter_mut().zip(by) {
            let change = -value / by;
            if !change.is_finite() || change == 0.0 {
                continue;
            }
            let side = if change > 0.0 {
                &mut found.above
            } else {
                &mut found.below
            };
            if side
                .as_ref()
                .is_none_or(|known| known.change.abs() > change.abs())
            {
                *side = Some(SequenceLimit {
                    change,
                    because: words(),
                });
            }
        }
    }

    /// Takes the time from the last event to `events` at instant `k` into account, and the speeds of impacts.
    pub(super) fn pass(&mut self, at: &Place<'_>, events: &[Event], times: &[f64]) {
        let Some(event) = events.first() else {
            return;
        };
        let words = format!("the {} at `{}`", event.kind, event.contact_name);
        let begin = at.run.trajectory.time[0];
        let (last, other, by) = self
            .event
            .take()
            .unwrap_or_else(|| (begin, "the start".to_owned(), vec![0.0; times.len()]));
        let moves: Vec<f64> = times.iter().zip(&by).map(|(own, by)| own - by).collect();
        let both = || {
            format!(
                "{other} and {words} at t = {} s happen at once",
                number(event.time)
            )
        };
        self.consider(event.time - last, &moves, &both);
        self.event = Some((event.time, words, times.to_vec()));
    }

    /// The ranges, with the time from the last event to the end of the motion, which moves by `ends`.
    pub(super) fn finish(mut self, at: &Place<'_>, ends: &[f64]) -> Vec<SequenceRange> {
        let last = *at.run.trajectory.time.last().unwrap_or(&0.0);
        if let Some((time, words, by)) = self.event.take() {
            let by: Vec<f64> = ends.iter().zip(&by).map(|(own, by)| own - by).collect();
            let time_of = number(time);
            let words = || format!("{words} at t = {time_of} s happens behind the end");
            self.consider(last - time, &by, &words);
        }
        self.found
    }

    /// Takes what an impact of these contacts decides into account: its speeds, and whether they slide behind it. The derivatives `moved`
    /// are those before it, and `jump` what it leaves, at the instant that moves along.
    pub(super) fn strike(
        &mut self,
        at: &mut Place<'_>,
        (struck, events): (&[usize], &[Event]),
        (x_before, x_after): (&[f64], &[f64]),
        (moved, jump): (&Tangent, &Jump),
    ) {
        let contacts = at.acceleration.model.declaration().contacts;
        let time = number(events[0].time);
        let mut behind = moved.clone();
        jump.apply(&mut behind);
        let known = events
            .iter()
            .find(|event| !event.contact_impulse.is_empty());
        for &contact in struck {
            let name = contacts[contact].name;
            let closing = at.modes.get(contact) == Some(&ContactMode::Open);
            let (speed, by) = at.acceleration.normal_velocity(contact, x_before);
            if closing && speed < 0.0 {
                let by: Vec<f64> = moved.of(by).iter().map(|by| speed * by).collect();
                let words = || format!("`{name}` is not struck at t = {time} s");
                self.consider(speed * speed / 2.0, &by, &words);
            }
            let (mu, mu_by) = at.acceleration.friction(contact);
            if contacts[contact].friction.is_none() || mu == 0.0 {
                continue;
            }
            let mu_by = moved.of_parameters(mu_by);
            at.acceleration.load_contact(contact, x_after);
            let component = tangent_point::SLIDING_VELOCITY;
            let (sliding, by) = at.acceleration.tangent(contact, component);
            if sliding.abs() > AT_REST * at.sizes[1] {
                let sense = sliding.signum();
                let by: Vec<f64> = behind.of(by).iter().map(|by| sense * by).collect();
                let words = || format!("`{name}` does not slide behind the impact at t = {time} s");
                self.consider(sliding.abs(), &by, &words);
                continue;
            }
            let impulse = |of: &[f64]| of.get(contact).copied().unwrap_or_default();
            let Some(known) = known else {
                continue;
            };
            let normal = impulse(&known.contact_impulse);
            for sense in [1.0, -1.0] {
                let mut by = vec![0.0; mu_by.len()];
                add(&mut by, mu, jump.impulses.row(contact));
                add(&mut by, normal, &mu_by);
                add(&mut by, sense, jump.impulses.row(contacts.len() + contact));
                let words = || format!("`{name}` slides behind the impact at t = {time} s");
                let left = mu * normal + sense * impulse(&known.friction_impulse);
                self.consider(left, &by, &words);
            }
        }
    }

    /// Counts margins at instant `k`, which moves by `times`, but for those that end there.
    pub(super) fn count_at<'m>(
        &mut self,
        at: &Place<'_>,
        tangent: &Tangent,
        k: usize,
        margins: impl Iterator<Item = &'m Margin>,
        times: &[f64],
    ) {
        for margin in margins.filter(|margin| margin.value > ENDED * margin.size) {
            let mut by = tangent.of(&margin.by);
            add(&mut by, margin.rate, times);
            self.count(at, margin, &by, at.run.trajectory.time[k]);
        }
    }

    /// Counts a margin that changes by these at a time.
    pub(super) fn count(&mut self, at: &Place<'_>, margin: &Margin, by: &[f64], time: f64) {
        let declared = &at.acceleration.model.declaration().contacts[margin.contact];
        let switch = declared.switch.is_some();
        let words = || {
            let what = margin.of.words(declared.name, switch);
            format!("{what} at t = {} s", number(time))
        };
        self.consider(margin.value, by, &words);
    }
}
