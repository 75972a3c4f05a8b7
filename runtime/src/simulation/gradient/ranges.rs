//! How far each quantity may go until the motion has another sequence of events, to first order.
//!
//! A sequence stays as long as its margins do: gaps of open contacts and forces of closed ones, the friction that a sticking contact has
//! left, the velocity of one that slides, the speed of an impact, and the time between two events. A margin `m` with the derivative
//! `m'` vanishes at the distance `-m/m'`, and the smallest of these to each side ends the range. Over an arc only its least
//! values count: where a margin begins to grow, at the arc's ends, and where its rate changes its sign within a step. There the
//! instant does not matter to first order; ends of arcs move with their events.
//!
//! The speed `s` of an impact vanishes like a square root where a surface is only just reached, so that its margin is `s^2`.

use super::arc::stage_input;
use super::cause::terms;
use super::margins::{Margin, Of, margins};
use super::matrix::Matrix;
use super::place::Place;
use crate::model::{contact_point, tangent_point};
use crate::simulation::quantity::number;
use crate::simulation::{ContactMode, Event};

/// Share of its size that a margin has which an event ends.
const ENDED: f64 = 1e-5;
/// Steps of the search for the least value of a margin, whose error is the square of that of its place.
const SEARCH: usize = 8;
/// Share of the largest velocity that counts as none after an impact.
const AT_REST: f64 = 1e-8;

/// How far one quantity may go.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SequenceRange {
    /// Towards smaller values; none where nothing ends it.
    pub below: Option<SequenceLimit>,
    /// Towards larger values.
    pub above: Option<SequenceLimit>,
}

/// What ends a range.
#[derive(Debug, Clone, PartialEq)]
pub struct SequenceLimit {
    /// Change of the quantity there, in its unit; below 0 towards smaller values.
    pub change: f64,
    /// What is another then, with the contact and the time.
    pub because: String,
}

/// The ranges of all quantities, as far as a walk has come.
pub(super) struct Ranges {
    found: Vec<SequenceRange>,
    /// Margins at the start of the step that comes, and the derivatives of the state there.
    begin: Option<(Vec<Margin>, Matrix)>,
    /// Time and words of the last event, and the derivatives of that time.
    event: Option<(f64, String, Vec<f64>)>,
}

impl Ranges {
    pub(super) fn new(count: usize) -> Self {
        Self {
            found: vec![SequenceRange::default(); count],
            begin: None,
            event: None,
        }
    }

    /// Takes a margin of this value and these derivatives, by quantity, into account.
    fn consider(&mut self, value: f64, by: impl Iterator<Item = f64>, words: &dyn Fn() -> String) {
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

    /// Keeps the margins at instant `k`, from which a step begins and where the acceleration is evaluated; those that grow from the start
    /// of an arc on count.
    pub(super) fn begin(
        &mut self,
        at: &mut Place<'_>,
        (k, arc_begins): (usize, bool),
        times: &[f64],
    ) {
        let margins = margins_at(at, k);
        if arc_begins {
            let ends = margins.iter().filter(|margin| margin.rate >= 0.0);
            let ends: Vec<Margin> = ends.cloned().collect();
            self.count_at(at, k, &ends, times);
        }
        self.begin = Some((margins, at.front.state.clone()));
    }

    /// Looks at the margins of the step that ends at instant `k`, where an event or the motion may end, whose time has these derivatives.
    pub(super) fn end(
        &mut self,
        at: &mut Place<'_>,
        k: usize,
        arc_ends: Option<&[f64]>,
    ) -> Result<(), String> {
        let Some((begin, before)) = self.begin.take() else {
            return Ok(());
        };
        let end = margins_at(at, k);
        let turns =
            |(from, to): &(&Margin, &Margin)| from.of == to.of && from.rate < 0.0 && to.rate > 0.0;
        let inside: Vec<(Margin, Margin)> = begin
            .iter()
            .zip(&end)
            .filter(turns)
            .map(|(from, to)| (from.clone(), to.clone()))
            .collect();
        for (from, to) in &inside {
            self.count_within(at, k, (from, to), &before);
        }
        if !inside.is_empty() {
            at.evaluate(k)?;
        }
        if let Some(times) = arc_ends {
            let falling = end.iter().filter(|margin| margin.rate <= 0.0);
            let falling: Vec<Margin> = falling.cloned().collect();
            self.count_at(at, k, &falling, times);
        }
        Ok(())
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
        let moves = times.iter().zip(&by).map(|(own, other)| own - other);
        let both = || {
            format!(
                "{other} and {words} at t = {} s happen at once",
                number(event.time)
            )
        };
        self.consider(event.time - last, moves, &both);
        self.event = Some((event.time, words, times.to_vec()));
    }

    /// The ranges, with the time from the last event to the end of the motion.
    pub(super) fn finish(mut self, at: &Place<'_>) -> Vec<SequenceRange> {
        let moves = at.horizon_moves();
        let last = *at.run.trajectory.time.last().unwrap_or(&0.0);
        if let Some((time, words, by)) = self.event.take() {
            let by = moves.iter().zip(&by).map(|(own, other)| own - other);
            let time_of = number(time);
            let words = || format!("{words} at t = {time_of} s happens behind the end");
            self.consider(last - time, by, &words);
        }
        self.found
    }

    /// Takes what an impact of these contacts decides into account: its speeds, and whether they slide behind it. The derivatives `moved`
    /// are those of `(q, v)` before it and `after` of `v` behind it, where it happens.
    pub(super) fn strike(
        &mut self,
        at: &mut Place<'_>,
        (struck, events): (&[usize], &[Event]),
        (x_before, x_after): (&[f64], &[f64]),
        (moved, after): (&Matrix, &Matrix),
        (times, impulses): (&[f64], &Matrix),
    ) {
        let (n, wanted) = (at.acceleration.n, at.front.wanted);
        let contacts = at.acceleration.model.declaration().contacts;
        let explicit = at.acceleration.model.declaration().explicit_time;
        let time_column = at.acceleration.columns - wanted.parameters - 1;
        let time = number(events[0].time);
        let total = |by: &[f64], state: &Matrix, k: usize| {
            let moves = if explicit {
                by[time_column] * times[k]
            } else {
                0.0
            };
            wanted.along(by, state, k) + moves
        };
        let mut behind = moved.clone();
        behind.values[n * wanted.count()..].copy_from_slice(&after.values);
        let columns = || 0..wanted.count();
        for &contact in struck {
            let name = contacts[contact].name;
            at.acceleration.load_contact(contact, x_before);
            let (speed, by) = at
                .acceleration
                .point(contact, contact_point::NORMAL_VELOCITY);
            let closing = at.modes.get(contact) == Some(&ContactMode::Open);
            if closing && speed < 0.0 {
                let by = columns().map(|k| speed * total(by, moved, k));
                let words = || format!("`{name}` is not struck at t = {time} s");
                self.consider(speed * speed / 2.0, by, &words);
            }
            let (mu, mu_by) = at.acceleration.friction(contact);
            if contacts[contact].friction.is_none() || mu == 0.0 {
                continue;
            }
            let mu_by = mu_by.to_vec();
            at.acceleration.load_contact(contact, x_after);
            let component = tangent_point::SLIDING_VELOCITY;
            let (sliding, by) = at.acceleration.tangent(contact, component);
            if sliding.abs() > AT_REST * at.sizes[1] {
                let sense = sliding.signum();
                let by = columns().map(|k| sense * total(by, &behind, k));
                let words = || format!("`{name}` does not slide behind the impact at t = {time} s");
                self.consider(sliding.abs(), by, &words);
                continue;
            }
            let impulse = |of: &[f64]| of.get(contact).copied().unwrap_or_default();
            let known = events
                .iter()
                .find(|event| !event.contact_impulse.is_empty());
            let Some(known) = known else {
                continue;
            };
            let (normal, rubs) = (
                impulse(&known.contact_impulse),
                impulse(&known.friction_impulse),
            );
            for sense in [1.0, -1.0] {
                let by = columns().map(|k| {
                    let rubs_by = impulses.row(contacts.len() + contact)[k];
                    let normal_by = impulses.row(contact)[k];
                    mu * normal_by + wanted.of_parameters(&mu_by, k) * normal + sense * rubs_by
                });
                let words = || format!("`{name}` slides behind the impact at t = {time} s");
                self.consider(mu * normal + sense * rubs, by, &words);
            }
        }
    }

    /// Counts margins at an instant that moves by `times`, but for those that end there.
    fn count_at(&mut self, at: &Place<'_>, k: usize, margins: &[Margin], times: &[f64]) {
        let (state, wanted) = (&at.front.state, at.front.wanted);
        let time = number(at.run.trajectory.time[k]);
        for margin in margins
            .iter()
            .filter(|margin| margin.value > ENDED * margin.size)
        {
            let by = (0..wanted.count()).map(|column| {
                let moves = margin.rate * times.get(column).unwrap_or(&0.0);
                wanted.along(&margin.by, state, column) + moves
            });
            let declared = &at.acceleration.model.declaration().contacts[margin.contact];
            let switch = declared.switch.is_some();
            let words = || format!("{} at t = {time} s", margin.of.words(declared.name, switch));
            self.consider(margin.value, by, &words);
        }
    }

    /// Counts the least value of a margin within the step that ends at instant `k`, from the derivatives of the state at its start.
    fn count_within(
        &mut self,
        at: &mut Place<'_>,
        k: usize,
        (from, to): (&Margin, &Margin),
        before: &Matrix,
    ) {
        let controls = at.controls(at.run.trajectory.time[k - 1]);
        let step = at.step_to(k, &controls);
        let (n, h) = (at.acceleration.n, step.to.time - step.from.time);
        // The rate's zero by false position, with the weight of an end that stays halved (Illinois).
        let (mut low, mut high) = ((0.0, from.rate), (1.0, to.rate));
        let mut found = None;
        for _ in 0..SEARCH {
            let theta = low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1);
            let (q, v) = at.arc.within(step, theta);
            let time = step.from.time + theta * h;
            let x = stage_input(&at.acceleration, (&q, &v), time, &controls);
            if !at.acceleration.evaluate(&x) {
                break;
            }
            let slopes = controls.slopes();
            let margins = margins(&mut at.acceleration, &at.modes, (&x, slopes));
            let own = |margin: &Margin| margin.contact == from.contact && margin.of == from.of;
            let Some(margin) = margins.into_iter().find(own) else {
                break;
            };
            if margin.rate < 0.0 {
                (low, high.1) = ((theta, margin.rate), high.1 / 2.0);
            } else {
                (high, low.1) = ((theta, margin.rate), low.1 / 2.0);
            }
            found = Some((margin, theta, time));
        }
        if let Some((margin, theta, time)) = found.filter(|(margin, ..)| margin.value > 0.0) {
            let wanted = at.front.wanted;
            let state = at.arc.derivatives_within((n, h), before, theta);
            let by = (0..wanted.count()).map(|column| wanted.along(&margin.by, &state, column));
            let declared = &at.acceleration.model.declaration().contacts[margin.contact];
            let switch = declared.switch.is_some();
            let time = number(time);
            let words = || format!("{} at t = {time} s", margin.of.words(declared.name, switch));
            self.consider(margin.value, by, &words);
        }
    }
}

/// The margins at an instant, where the acceleration is evaluated.
fn margins_at(at: &mut Place<'_>, k: usize) -> Vec<Margin> {
    let x = at.input(k);
    let controls = at.controls(at.run.trajectory.time[k]);
    let mut margins = margins(&mut at.acceleration, &at.modes, (&x, controls.slopes()));
    for margin in &mut margins {
        margin.size = match margin.of {
            Of::Gap => at.gap_sizes[margin.contact],
            Of::Sliding(_) => margin.size.max(at.sizes[1] * ENDED),
            Of::Force => {
                let time = at.run.trajectory.time[k];
                let n = at.acceleration.n;
                margin.size.max(terms(at.sizes, n, &margin.by, (&x, time)))
            }
            Of::Left(_) => margin.size,
        };
    }
    margins
}
