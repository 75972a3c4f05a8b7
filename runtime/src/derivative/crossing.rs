//! Across events: what they change of the derivatives, at once or one after the other.

use super::event::{Cause, cause};
use super::existence::Existence;
use super::jump::{Impact, ended, jump, struck_alone};
use super::place::Place;
use super::ranges::Ranges;
use super::reset;
use super::tangent::Tangent;
use crate::linalg::products::largest;
use crate::simulation::{ContactMode, Event, EventKind};
use crate::yardstick;

/// Events that happen at one instant of a motion.
pub(super) struct Crossing<'c, 'w> {
    pub(super) at: &'c mut Place<'w>,
    /// Derivatives at the instant that moves along.
    pub(super) tangent: &'c mut Tangent,
    pub(super) existence: &'c mut Existence,
    pub(super) ranges: Option<&'c mut Ranges>,
    pub(super) events: &'c [Event],
    /// The input vectors before and behind.
    pub(super) inputs: [&'c [f64]; 2],
    pub(super) control_rates: &'c [f64],
    /// The instant.
    pub(super) k: usize,
}

impl Crossing<'_, '_> {
    /// What the events change of the velocities: conditions set what they ask for, contacts are struck, and so come true what other conditions
    /// wait for.
    ///
    /// # Errors
    /// Why there are no derivatives behind them.
    pub(super) fn change(&mut self) -> Result<(), String> {
        let (events, [x_before, x_after]) = (self.events, self.inputs);
        let time = self.at.time(self.k);
        let when = |event: &&Event| event.kind == EventKind::When;
        let conditions: Vec<usize> = events.iter().filter(when).map(|e| e.contact).collect();
        let mut x = x_before.to_vec();
        let mut late = &conditions[..];
        loop {
            let mut holds = |&&condition: &&usize| self.at.holds(condition, (&x, time));
            let count = late.iter().take_while(&mut holds).count();
            if count == 0 {
                break;
            }
            self.set(&late[..count], &mut x);
            late = &late[count..];
        }
        let behind = reset::before(&self.at.acceleration, late, (&x, x_after));
        let jumps = events.iter().any(|event| event.kind == EventKind::Impact);
        if jumps || self.at.velocities_differ(&x, &behind, yardstick::NOTHING) {
            self.strike(&x, &behind)?;
            x = behind;
        }
        self.set(late, &mut x);
        if self.at.velocities_differ(&x, x_after, yardstick::PROMISE) {
            return Err(format!(
                "at t = {time} s `{}` sets something together with another event: which of them is first for other parameters is not known",
                self.at.acceleration.model.declaration().contacts[conditions[0]].name
            ));
        }
        Ok(())
    }

    /// What conditions set, all of them from `x`.
    fn set(&mut self, conditions: &[usize], x: &mut [f64]) {
        let by = (x, &mut *self.tangent);
        reset::set(&self.at.acceleration, conditions, by);
    }

    /// What an impact changes.
    fn strike(&mut self, x_before: &[f64], x_after: &[f64]) -> Result<(), String> {
        let events = self.events;
        let after_modes = events.last().map_or(&[][..], |event| &event.modes);
        let struck = self.struck(events, after_modes);
        if self.k == 0 {
            self.existence
                .check_start((&mut *self.at, &*self.tangent), &struck);
        }
        for &contact in &struck {
            let here = (&mut *self.at, &*self.tangent);
            self.existence.check_laws(here, contact, self.k);
        }
        let impact = Impact {
            before: x_before,
            after: x_after,
            struck: &struck,
            time: self.at.time(self.k),
        };
        let declared = self.at.acceleration.model.declaration().contacts;
        if let Some(contact) = struck.iter().find(|&&i| declared[i].sequence)
            && struck.len() > 1
        {
            return Err(format!(
                "at t = {} s `{}` and others are struck one after the other (`in sequence`), and derivatives know impacts at once alone; \
                 take differences of two simulations, or leave out `in sequence`",
                impact.time, declared[*contact].name
            ));
        }
        let jump = jump(&mut self.at.acceleration, self.tangent, &impact)?;
        if let Some(ranges) = &mut self.ranges {
            let by = (&*self.tangent, &jump);
            ranges.strike(self.at, (&struck, events), (x_before, x_after), by);
        }
        jump.apply(self.tangent);
        Ok(())
    }

    /// Contacts that take part in a jump: those with impulses, and those that close.
    fn struck(&self, events: &[Event], after: &[ContactMode]) -> Vec<usize> {
        let impulses = events
            .iter()
            .find(|event| !event.contact_impulse.is_empty());
        let impulses = impulses.map_or(&[][..], |event| &event.contact_impulse);
        let least = yardstick::NOTHING * largest(impulses);
        let declared = self.at.acceleration.model.declaration().contacts;
        (0..declared.len())
            .filter(|&i| {
                let closes = self.at.modes.get(i) == Some(&ContactMode::Open)
                    && after.get(i).is_some_and(|mode| *mode != ContactMode::Open);
                let strikes = impulses.get(i).is_some_and(|impulse| *impulse > least);
                !declared[i].dry && (closes || strikes)
            })
            .collect()
    }

    /// Passes events that happen at once one after the other, for the columns that take them `apart`: by what they are from `before`.
    pub(super) fn take_apart(
        &mut self,
        (found, apart): (&[Cause<'_>], &[usize]),
        before: &Tangent,
    ) {
        let mut known: Vec<(Vec<usize>, Option<Tangent>)> = Vec::new();
        for &column in apart {
            let places = [1.0, -1.0].map(|sense| {
                let mut order: Vec<usize> = (0..found.len()).collect();
                let time = |i: usize| sense * found[i].times[column];
                order.sort_by(|&i, &j| time(i).total_cmp(&time(j)));
                known
                    .iter()
                    .position(|known| known.0 == order)
                    .unwrap_or_else(|| {
                        // What follows from them is part of none.
                        let all = found.len() == self.events.len();
                        let modes = self.at.modes.clone();
                        let passed = all.then(|| self.in_order((found, &order), before));
                        self.at.modes = modes;
                        known.push((order, passed.flatten()));
                        known.len() - 1
                    })
            });
            let orders = places.map(|place| known[place].1.as_ref());
            if let Some(behind) = self.existence.of_orders(found, column, orders) {
                self.tangent.take_column(column, behind);
            }
        }
    }

    /// The derivatives behind events that happen in this order at one instant; `None` where that is another motion.
    fn in_order(
        &mut self,
        (found, order): (&[Cause<'_>], &[usize]),
        before: &Tangent,
    ) -> Option<Tangent> {
        let (events, [x_before, x_after]) = (self.events, self.inputs);
        let control_rates = self.control_rates;
        let mut tangent = before.clone();
        let mut x = x_before.to_vec();
        let after = &events.last()?.modes;
        let all = Impact {
            before: x_before,
            after: x_after,
            struck: &contacts_of(events),
            time: events[0].time,
        };
        let ended = ended(&mut self.at.acceleration, &all);
        for &place in order {
            let event = found[place].event;
            if !self.at.enter_at(&x) {
                return None;
            }
            let rates = self.at.rates(&x, control_rates);
            let cause = cause(self.at, &x, event, ([&rates, &rates], &tangent))?;
            tangent.shift(&rates, &cause.times, 1.0);
            match event.kind {
                EventKind::Impact => {
                    let closed =
                        (0..after.len()).filter(|&i| self.at.is_closed(i) || i == event.contact);
                    let struck: Vec<usize> = closed.collect();
                    let of = (&struck[..], &ended[..]);
                    let behind = struck_alone(&mut self.at.acceleration, of, &x)?;
                    let impact = Impact {
                        before: &x,
                        after: &behind,
                        struck: &struck,
                        time: event.time,
                    };
                    let jump = jump(&mut self.at.acceleration, &tangent, &impact).ok()?;
                    jump.apply(&mut tangent);
                    x = behind;
                }
                EventKind::When => {
                    reset::set(
                        &self.at.acceleration,
                        &[event.contact],
                        (&mut x, &mut tangent),
                    );
                }
                _ => {}
            }
            self.at.modes[event.contact] = after[event.contact];
            if !self.at.enter_at(&x) {
                return None;
            }
            tangent.shift(&self.at.rates(&x, control_rates), &cause.times, -1.0);
        }
        (!self.at.velocities_differ(&x, x_after, yardstick::PROMISE)).then_some(tangent)
    }
}

/// The contacts of events.
pub(super) fn contacts_of(events: &[Event]) -> Vec<usize> {
    events.iter().map(|event| event.contact).collect()
}

/// The columns by which events that happen together have different times.
pub(super) fn apart(found: &[Cause<'_>]) -> Vec<usize> {
    let Some((first, others)) = found.split_first() else {
        return Vec::new();
    };
    let most = found.iter().map(|cause| largest(&cause.times));
    let least = yardstick::PROMISE * most.fold(0.0, f64::max);
    let differs = |&column: &usize| {
        let mut others = others.iter();
        others.any(|other| (other.times[column] - first.times[column]).abs() > least)
    };
    (0..first.times.len()).filter(differs).collect()
}
