//! By which quantities a motion has derivatives, and where and why they end for others: what vanishes for these values only, and events that
//! happen at once and come apart.

use super::event::Cause;
use super::margins::{Least, Margin, Of};
use super::place::Place;
use super::tangent::{Layout, Tangent, add};
use crate::contact::Line;
use crate::linalg::products::largest;
use crate::model::contact_point;
use crate::simulation::Event;
use crate::yardstick;

/// Share of the largest derivative by which those of two orders of events may differ: rounding, and the error of the motion.
const SAME: f64 = 1e-8;

/// A place of a motion with the derivatives there.
type Here<'h, 'w> = (&'h mut Place<'w>, &'h Tangent);

/// Share of the motion for which a margin has to vanish until that lasts. What begins as the cube of time, as a gap behind a lift-off, is
/// larger than rounding by then.
const LASTS: f64 = 1e-2;

/// Why columns of derivatives are lost from some instant on.
pub(super) struct Existence {
    /// What the columns are by.
    names: Vec<String>,
    /// Why each of them has no derivative, if it has none.
    pub(super) lost: Vec<Option<String>>,
    /// Margins that vanished at the instant before, and since when.
    pub(super) vanished: Vec<((usize, Of), f64)>,
    /// Largest derivative of the state so far: what an event takes away leaves its rounding.
    largest: f64,
}

impl Existence {
    pub(super) fn of(names: &[String]) -> Self {
        Self {
            names: names.to_vec(),
            lost: vec![None; names.len()],
            vanished: Vec::new(),
            largest: 0.0,
        }
    }

    /// Loses a column, if it is not lost yet.
    pub(super) fn lose(&mut self, column: usize, why: impl FnOnce(&str) -> String) {
        // What is beside the columns is a part of the first one.
        let column = if column < self.lost.len() { column } else { 0 };
        let name = &self.names[column];
        self.lost[column].get_or_insert_with(|| why(name));
    }

    /// Loses all columns that are left.
    pub(super) fn lose_all(&mut self, why: &str) {
        for lost in &mut self.lost {
            lost.get_or_insert_with(|| why.to_owned());
        }
    }

    /// Whether there is none any longer.
    pub(super) fn is_over(&self) -> bool {
        self.lost.iter().all(Option::is_some)
    }

    /// What derivatives of a function with these by inputs and parameters may be of rounding alone.
    fn rounding(&self, by: &[f64]) -> f64 {
        yardstick::NOTHING * self.largest * largest(by)
    }

    /// Makes the numbers of lost columns of a row none.
    pub(super) fn mask(&self, row: &mut [f64]) {
        for (by, lost) in row.iter_mut().zip(&self.lost) {
            if lost.is_some() {
                *by = f64::NAN;
            }
        }
    }

    /// Contacts that are struck at the start are so for all neighbouring starts.
    pub(super) fn check_start(&mut self, (at, tangent): Here<'_, '_>, struck: &[usize]) {
        let x = at.input(0);
        for &contact in struck {
            at.acceleration.load_contact(contact, &x);
            self.check_zero(
                (at, tangent),
                (contact, contact_point::GAP),
                (0, yardstick::PROMISE),
            );
        }
    }

    /// What contacts hold does not change with what the motion is differentiated by.
    pub(super) fn check_holds(&mut self, (at, tangent): Here<'_, '_>, (k, share): (usize, f64)) {
        for line in at.acceleration.lines.clone() {
            let contact = line.contact();
            match line {
                Line::Normal { .. } if at.acceleration.is_dry(contact) => {}
                Line::Normal { .. } => {
                    self.check_laws((at, tangent), contact, k);
                    self.check_zero((at, tangent), (contact, contact_point::GAP), (k, share));
                    self.check_zero(
                        (at, tangent),
                        (contact, contact_point::NORMAL_VELOCITY),
                        (k, share),
                    );
                }
                _ => {
                    let by = at.acceleration.velocity(line).1.to_vec();
                    self.check_row((at, tangent), contact, &by, (k, share));
                }
            }
        }
    }

    /// No coefficient of a law stands at its limit of 0 and is moved from there: what follows differs on both sides.
    pub(super) fn check_laws(&mut self, (at, tangent): Here<'_, '_>, contact: usize, k: usize) {
        let acceleration = &at.acceleration;
        let (mu, friction_by) = acceleration.friction(contact);
        let mut restitution_by = vec![0.0; acceleration.layout.parameters];
        acceleration
            .derivatives
            .restitution(contact, &mut restitution_by);
        let e = acceleration.model.restitution(contact);
        let laws = [
            ("restitution", e, tangent.of_parameters(&restitution_by)),
            ("friction", mu, tangent.of_parameters(friction_by)),
        ];
        let (time, contact) = (at.time(k), at.name_of(contact));
        for (law, value, by) in laws {
            for column in (0..self.lost.len()).filter(|&k| value == 0.0 && by[k] != 0.0) {
                self.lose(column, |name| {
                    format!(
                        "at t = {time} s `{contact}` has a coefficient of {law} of 0, below which there is nothing: by `{name}` \
                         there is a derivative to one side only"
                    )
                });
            }
        }
    }

    fn check_zero(
        &mut self,
        (at, tangent): Here<'_, '_>,
        (contact, component): (usize, usize),
        when: (usize, f64),
    ) {
        let by = at.acceleration.point(contact, component).1.to_vec();
        self.check_row((at, tangent), contact, &by, when);
    }

    /// Loses the columns by which what vanishes at instant `k` does so for these values only.
    fn check_row(
        &mut self,
        (at, tangent): Here<'_, '_>,
        contact: usize,
        by: &[f64],
        (k, share): (usize, f64),
    ) {
        self.largest = self.largest.max(largest(tangent.state()));
        let most = self.rounding(by);
        let (changes, sizes) = (tangent.of(by), tangent.sizes(by));
        let (time, contact) = (at.time(k), at.name_of(contact));
        for column in 0..self.lost.len() {
            if changes[column].abs() > (share * sizes[column]).max(most) {
                self.lose(column, |name| {
                    format!(
                        "at t = {time} s `{contact}` is closed, or struck, for these values only: another `{name}` opens it or \
                         presses it in"
                    )
                });
            }
        }
    }

    /// Loses the columns by which the time of an event has no derivative.
    pub(super) fn check_grazes(&mut self, cause: &Cause<'_>) {
        let event = cause.event;
        for column in (0..cause.grazed.len()).filter(|&k| cause.grazed[k]) {
            self.lose(column, |_| {
                format!(
                    "at t = {} s `{}` only grazes: the time of this {} has no derivative",
                    event.time, event.contact_name, event.kind
                )
            });
        }
    }

    /// Loses the columns by which margins that vanish at instant `k` change, but for those of contacts with an event of their `own` there, and
    /// where that is right before the end of the motion, which moves by `ends`. But at the start and the end of the motion they have to
    /// vanish for a while: what does for an instant is an event of its own, or changes nothing to first order.
    pub(super) fn check_margins(
        &mut self,
        (at, tangent): Here<'_, '_>,
        margins: &[Margin],
        (k, own): (usize, &[usize]),
        ends: Option<&[f64]>,
    ) {
        self.largest = self.largest.max(largest(tangent.state()));
        let start = k == 0 || at.time(k) <= at.time(0);
        let mut vanished = Vec::new();
        // At the start what begins to slide does so from rest, whatever is said of it there.
        let has_event = |margin: &&Margin| {
            own.contains(&margin.contact) && !(start && matches!(margin.of, Of::Sliding(_)))
        };
        for margin in margins.iter().filter(|margin| !has_event(margin)) {
            let falls = match margin.of {
                Of::Sliding(sense) if margin.resets => sense * margin.rate < 0.0,
                _ => margin.rate < 0.0,
            };
            if margin.value > yardstick::NOTHING * margin.size {
                continue;
            }
            let rests =
                (margin.rate * at.problem.horizon).abs() <= yardstick::NOTHING * margin.size;
            let place = (margin.contact, margin.of);
            let known = self.vanished.iter().find(|(known, _)| *known == place);
            let since = known.map_or(at.time(k), |(_, since)| *since);
            vanished.push((place, since));
            let lasts = at.time(k) - since > LASTS * at.problem.horizon;
            let counts = match margin.of {
                Of::Force | Of::Left(_) => lasts,
                _ if ends.is_some() && falls => true,
                Of::Gap => start || lasts,
                Of::Sliding(_) if margin.resets => start && falls && !rests,
                Of::Sliding(_) if at.acceleration.passes(margin.contact) => {
                    let x = at.input(k);
                    lasts || start && at.jumps(margin.contact, &x)
                }
                Of::Sliding(_) => start || lasts,
            };
            if !counts {
                continue;
            }
            let share = if start {
                yardstick::PROMISE
            } else {
                yardstick::VISIBLE
            };
            let (mut changes, mut sizes) = (tangent.of(&margin.by), tangent.sizes(&margin.by));
            let ended = ends.filter(|_| falls);
            for (column, moves) in ended.into_iter().flatten().enumerate() {
                changes[column] += margin.rate * moves;
                sizes[column] += (margin.rate * moves).abs();
            }
            let share = if ended.is_some() {
                yardstick::NOTHING
            } else {
                share
            };
            let most = self.rounding(&margin.by);
            let changed = changes.iter().zip(&sizes);
            let changed = changed.map(|(by, size)| by.abs() > (share * size).max(most));
            let changed: Vec<bool> = changed.collect();
            self.lose_by_margin(
                at.name_of(margin.contact),
                margin,
                (at.time(k), ended.is_some()),
                &changed,
            );
        }
        self.vanished = vanished;
    }

    /// Loses the columns by which something that rests on its edge at the start begins on the other side, by the margins where the first step
    /// begins and where it ends, at instant `k`, and the derivatives `before` it.
    pub(super) fn check_edges(
        &mut self,
        at: &mut Place<'_>,
        [begin, end]: [&[Margin]; 2],
        (k, before): (usize, &Tangent),
    ) {
        let horizon = at.problem.horizon;
        let vanishes =
            |value: f64, margin: &Margin| value.abs() <= yardstick::NOTHING * margin.size;
        for (from, to) in begin.iter().zip(end) {
            let rests = vanishes(from.value, from) && vanishes(from.rate * horizon, from);
            let crosses = matches!(from.of, Of::Sliding(_)) && rests && !vanishes(to.value, to);
            // Against a condition that holds the velocity is negative.
            let matters = crosses
                && match from.resets {
                    true => to.of == Of::Sliding(-1.0),
                    false => at.jumps(from.contact, &at.input(k)),
                };
            if !matters {
                continue;
            }
            let (changes, sizes) = (before.of(&from.by), before.sizes(&from.by));
            let mut moves = vec![0.0; changes.len()];
            for (i, by) in from.by[..before.layout.n].iter().enumerate() {
                add(&mut moves, *by, before.all.row(before.layout.n + i));
            }
            let changed = (0..moves.len()).map(|column| {
                changes[column].abs() > yardstick::PROMISE * sizes[column] || moves[column] != 0.0
            });
            let changed: Vec<bool> = changed.collect();
            let name = at.name_of(from.contact);
            self.lose_by_margin(name, from, (at.time(0), false), &changed);
        }
    }

    /// Loses the columns by which a margin changes whose least value within a step vanishes; whether it does.
    pub(super) fn check_least(&mut self, at: &Place<'_>, least: &Least) -> bool {
        let margin = &least.margin;
        let matters = match margin.of {
            Of::Gap => true,
            Of::Force | Of::Left(_) => false,
            Of::Sliding(_) => margin.resets || least.jumps,
        };
        if margin.value.abs() > yardstick::NOTHING * margin.size {
            return false;
        }
        let most = self.rounding(&margin.by);
        let pairs = least.changes.iter().zip(&least.terms);
        let changed =
            pairs.map(|(by, size)| matters && by.abs() > (yardstick::PROMISE * size).max(most));
        let changed: Vec<bool> = changed.collect();
        let name = at.name_of(margin.contact);
        self.lose_by_margin(name, margin, (least.time, false), &changed);
        true
    }

    fn lose_by_margin(
        &mut self,
        contact: &str,
        margin: &Margin,
        (time, ends): (f64, bool),
        changed: &[bool],
    ) {
        for column in (0..changed.len()).filter(|&k| changed[k]) {
            self.lose(column, |name| match margin.of {
                _ if ends => ends_with(time, contact),
                Of::Gap => format!(
                    "at t = {time} s `{contact}` only grazes: it touches and is not struck, but is so for another `{name}`"
                ),
                Of::Force => format!(
                    "from t = {time} s on `{contact}` is closed without a force for these values only: another `{name}` opens it"
                ),
                Of::Left(_) => format!(
                    "from t = {time} s on `{contact}` sticks with all of its friction for these values only: with another `{name}` \
                     it slides"
                ),
                Of::Sliding(_) => format!(
                    "at t = {time} s `{contact}` is at its edge for these values only: another `{name}` changes its side"
                ),
            });
        }
    }

    /// The motion does not end with an event that moves away from its last instant.
    pub(super) fn check_end(
        &mut self,
        at: &Place<'_>,
        times: Option<&[f64]>,
        (last, ends): (usize, &[f64]),
    ) {
        let (time, begin) = (at.time(last), at.time(0));
        let late =
            |event: &&Event| event.time > begin && event.time >= time * (1.0 - yardstick::NOTHING);
        let Some(event) = at.run.events.last().filter(late) else {
            return;
        };
        let Some(times) = times else {
            return;
        };
        let least = yardstick::NOTHING * largest(times).max(largest(ends));
        for (column, (own, end)) in times.iter().zip(ends).enumerate() {
            if (own - end).abs() > least {
                self.lose(column, |_| ends_with(time, event.contact_name));
            }
        }
    }

    /// What becomes of the derivatives in a column by which the times of events that happen at once are different, if that is the same in
    /// both `orders` in which they then happen; loses it otherwise.
    pub(super) fn of_orders<'t>(
        &mut self,
        found: &[Cause<'_>],
        column: usize,
        orders: [Option<&'t Tangent>; 2],
    ) -> Option<&'t Tangent> {
        if let [Some(one), Some(other)] = orders {
            let of = |tangent: &Tangent, i: usize| tangent.all.row(i)[column];
            let mut rows = 0..one.layout.rows();
            let most = rows
                .clone()
                .fold(0.0_f64, |most, i| most.max(of(one, i).abs()));
            if rows.all(|i| (of(one, i) - of(other, i)).abs() <= SAME * most) {
                return Some(one);
            }
        }
        let (first, last) = (found[0].event, found[found.len() - 1].event);
        self.lose(column, |_| {
            format!(
                "at t = {} s `{}` and `{}` change at once, which other parameters take apart: which of them is first decides the \
                 motion",
                first.time, first.contact_name, last.contact_name
            )
        });
        None
    }

    /// Controls do not jump where an event happens that moves by `times`.
    pub(super) fn check_controls(
        &mut self,
        (x_before, x_after): (&[f64], &[f64]),
        layout: Layout,
        (time, times): (f64, &[f64]),
    ) {
        let controls = 2 * layout.n..layout.time();
        if x_before[controls.clone()] == x_after[controls] {
            return;
        }
        let least = yardstick::NOTHING * largest(times);
        for column in (0..times.len()).filter(|&k| times[k].abs() > least) {
            self.lose(column, |_| {
                format!("at t = {time} s controls jump together with an event: which of them is first for other parameters decides the motion")
            });
        }
    }
}

fn ends_with(time: f64, contact: &str) -> String {
    format!(
        "the motion ends at t = {time} s with an event at `{contact}`, so that its end has different derivatives to both sides; \
         take another horizon"
    )
}
