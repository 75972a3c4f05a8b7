//! A motion with its contact sequence in numerical time: phases and jumps of each interval.
//!
//! In a phase the clock runs at the speed `theta`, at which the weights `beta_i = theta r_i / a_bar` of the contacts make up
//! for their normal accelerations `r_i`; so `theta = prod (1 - theta r_i / a_bar)`. In a jump it stands, until a contact that closes
//! at the normal velocity `v_n` has been pushed for `|v_n| / a_bar`, and, if it bounces, for `|v_n| / (e a_bar)` more.

use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::mode::{closed_mode, sets};
use crate::ocp::motion::model_input::drive;
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::tuning::equal::ROUNDING;
use crate::ocp::tuning::freezing::{HALVINGS, STEPS};
use crate::simulation::{ContactMode, Direction};
use crate::time_freezing::field::Field;
use crate::time_freezing::task::Span;

/// What happens in each of the intervals.
pub(super) fn spans(
    system: Field<'_>,
    sequence: &Sequence,
    trajectory: &Trajectory,
    intervals: usize,
) -> Vec<Vec<Span>> {
    let controls = trajectory
        .controls
        .resampled(ControlShape::Constant, intervals);
    let mut motion = Motion {
        system,
        trajectory,
        interval: trajectory.horizon / intervals as f64,
        controls: Vec::new(),
        modes: sequence.initially.clone(),
        set: Vec::new(),
    };
    let mut rest = &sequence.switches[..];
    let mut all = Vec::with_capacity(intervals);
    for k in 0..intervals {
        motion.controls.clone_from(&controls.values()[k]);
        let mut spans = Vec::new();
        let mut from = k as f64;
        let own = |s: &Switch| s.interval == k || s.interval == intervals && k + 1 == intervals;
        while rest.first().is_some_and(own) {
            let count = 1 + Sequence::companions(rest, 0).len();
            let (group, others) = rest.split_at(count);
            rest = others;
            spans.extend(motion.phase(from, group[0].time));
            from = group[0].time;
            spans.extend(motion.switch(group));
        }
        spans.extend(motion.phase(from, (k + 1) as f64));
        all.push(spans);
    }
    all
}

/// A state, and how far each contact is dipped into the ground there.
type End<'a> = (&'a [f64], &'a [f64]);

/// The motion up to some switch.
struct Motion<'a> {
    system: Field<'a>,
    trajectory: &'a Trajectory,
    /// Length of an interval \[s\].
    interval: f64,
    /// Controls of the present interval.
    controls: Vec<f64>,
    /// What the contacts do at present.
    modes: Vec<ContactMode>,
    /// Conditions that have come true since the last phase.
    set: Vec<usize>,
}

impl Motion<'_> {
    /// The phase between two times, in units of intervals; none between switches at once.
    fn phase(&mut self, from: f64, to: f64) -> Option<Span> {
        let beside = ROUNDING * self.trajectory.horizon;
        let (from, duration) = (from * self.interval, (to - from) * self.interval);
        if duration < 4.0 * beside {
            return None;
        }
        let mut points = Vec::with_capacity(STEPS + 1);
        let mut length = 0.0;
        for step in 0..=STEPS {
            let time = from + duration * step as f64 / STEPS as f64;
            let inside = time.clamp(from + beside, from + duration - beside);
            let mut state = self.trajectory.at(inside, true);
            let provided = state.split_off(2 * self.system.coordinates());
            let (shares, speed) = self.shares(&provided);
            let weight = if step % STEPS == 0 { 0.5 } else { 1.0 };
            length += weight * duration / STEPS as f64 / speed;
            points.push(self.point(&state, time, &[], shares));
        }
        Some(Span {
            length,
            jumps: false,
            weights: self.weights(&[], None),
            sets: std::mem::take(&mut self.set),
            points,
        })
    }

    /// Passes the switches of one instant: the jump that they are, if there is an impact, a fall and a rise where it is elastic.
    fn switch(&mut self, group: &[Switch]) -> Vec<Span> {
        let struck: Vec<usize> = group
            .iter()
            .filter(|s| s.closes)
            .map(|s| s.contact)
            .collect();
        let time = group[0].time * self.interval;
        let beside = ROUNDING * self.trajectory.horizon;
        let n = self.system.coordinates();
        let before = self.trajectory.at(time - beside, false)[..2 * n].to_vec();
        let after = self.trajectory.at(time + beside, true)[..2 * n].to_vec();
        self.point(&after, time, &[], Vec::new());
        for switch in group {
            // What an impact throws off has no part in it.
            let leaves = switch.opens() && self.system.normal_velocity(switch.contact) > ROUNDING;
            self.modes[switch.contact] = if leaves { switch.mode } else { switch.impulse };
        }
        let model = self.system.model;
        let set = group.iter().filter(|switch| sets(model, switch));
        self.set.extend(set.map(|switch| switch.contact));
        let jump = self.jump(&struck, time, (&before, &after));
        for switch in group {
            self.modes[switch.contact] = switch.mode;
        }
        jump
    }

    /// The jump between two states by an impact of these contacts.
    fn jump(
        &mut self,
        struck: &[usize],
        time: f64,
        (before, after): (&[f64], &[f64]),
    ) -> Vec<Span> {
        let a_bar = self.system.auxiliary_acceleration;
        let contacts = 0..self.system.layout.contacts;
        self.point(before, time, &[], Vec::new());
        let speeds: Vec<f64> = contacts
            .clone()
            .map(|i| (-self.system.normal_velocity(i)).max(0.0))
            .collect();
        let e = |&i: &usize| self.system.restitution(i);
        let rebound = struck.iter().map(e).fold(0.0, f64::max);
        let fall = struck.iter().fold(0.0, |most: f64, &i| most.max(speeds[i])) / a_bar;
        if fall < ROUNDING * self.trajectory.horizon {
            return Vec::new();
        }
        let n = self.system.coordinates();
        let lowest: Vec<f64> = before
            .iter()
            .zip(after)
            .enumerate()
            .map(|(k, (b, a))| {
                if k < n {
                    *b
                } else {
                    b + (a - b) / (1.0 + rebound)
                }
            })
            .collect();
        let depths: Vec<f64> = contacts
            .map(|i| {
                if struck.contains(&i) && self.system.layout.bounces(i) {
                    -speeds[i].powi(2) / (2.0 * a_bar)
                } else {
                    0.0
                }
            })
            .collect();
        let mut spans = Vec::new();
        let mut falls = (before.to_vec(), fall);
        if let Some((contact, while_sliding)) = self.sliding_on(struck, before, time) {
            let later = std::mem::replace(&mut self.modes[contact], while_sliding);
            if let Some((length, state)) = self.stop(contact, struck, (before, time), fall) {
                let ends = [(before, &[][..]), (&state[..], &[][..])];
                spans.push(self.push(struck, time, length, ends, true));
                falls = (state, fall - length);
            }
            self.modes[contact] = later;
        }
        let ends = [(&falls.0[..], &[][..]), (&lowest[..], &depths[..])];
        spans.push(self.push(struck, time, falls.1, ends, true));
        if rebound > 0.0 {
            let ends = [(&lowest[..], &depths[..]), (after, &[][..])];
            spans.push(self.push(struck, time, fall / rebound, ends, false));
        }
        spans
    }

    /// The one contact of an impact that slides when it begins and not when it ends, or the other way then, and how it slides.
    fn sliding_on(
        &mut self,
        struck: &[usize],
        before: &[f64],
        time: f64,
    ) -> Option<(usize, ContactMode)> {
        self.point(before, time, &[], Vec::new());
        let system = &self.system;
        let changes = struck.iter().filter_map(|&i| {
            system.layout.slip_group(i)?;
            let velocity = system.sliding_velocity(i);
            let slides = closed_mode(true, velocity, ROUNDING);
            (slides != ContactMode::Stick && slides != self.modes[i]).then_some((i, slides))
        });
        let changes: Vec<(usize, ContactMode)> = changes.collect();
        match changes[..] {
            [change] => Some(change),
            _ => None,
        }
    }

    /// When a contact that slides at the beginning of an impact stops, if it does so in the fall of this length, and the state then.
    fn stop(
        &mut self,
        contact: usize,
        struck: &[usize],
        (before, time): (&[f64], f64),
        fall: f64,
    ) -> Option<(f64, Vec<f64>)> {
        let shares = self.shares_of_jump(struck, true);
        let mut local = self.point(before, time, &[], Vec::new());
        let slid = self.system.sliding_velocity(contact);
        local.extend(&self.controls);
        local.resize(self.system.layout.local_variables(), 0.0);
        self.system.complete(&mut local, &shares);
        let rates = self.system.rates(&local);
        let at = |length: f64| -> Vec<f64> {
            let moved = before.iter().zip(&rates);
            moved.map(|(y, rate)| y + length * rate).collect()
        };
        self.point(&at(1.0), time, &[], Vec::new());
        let length = slid / (slid - self.system.sliding_velocity(contact));
        (length > 0.0 && length < fall).then(|| (length, at(length)))
    }

    /// A push at a standing clock, between two states with the depths of their dips.
    fn push(
        &mut self,
        struck: &[usize],
        time: f64,
        length: f64,
        [(from, above), (to, below)]: [End<'_>; 2],
        falling: bool,
    ) -> Span {
        let shares = self.shares_of_jump(struck, falling);
        Span {
            length,
            jumps: true,
            weights: self.weights(struck, Some(falling)),
            sets: Vec::new(),
            points: vec![
                self.point(from, time, above, shares.clone()),
                self.point(to, time, below, shares),
            ],
        }
    }

    /// Shares of the groups while these contacts are pushed.
    fn shares_of_jump(&self, struck: &[usize], falling: bool) -> Vec<f64> {
        let (mut shares, _) = self.shares(&vec![0.0; self.modes.len()]);
        let contacts = self.system.layout.contacts;
        for (i, share) in shares.iter_mut().enumerate().take(contacts) {
            if struck.contains(&i) {
                *share = 0.0;
            } else if !self.modes[i].is_open() {
                *share = 0.5;
            }
        }
        let first = contacts + self.system.layout.frictions();
        shares[first..].fill(if falling { 1.0 } else { 0.0 });
        shares
    }

    /// Which of the two weights of each group there are, while these contacts are pushed and fall or rise, or in a phase.
    fn weights(&self, struck: &[usize], falling: Option<bool>) -> Vec<[bool; 2]> {
        let layout = &self.system.layout;
        let acts = |i: usize| struck.contains(&i) || !self.modes[i].is_open();
        let of_contact = |i: usize| [!struck.contains(&i), acts(i)];
        let of_friction = |i: usize| match self.modes[i] {
            _ if !acts(i) => [false, false],
            ContactMode::Slip(direction) => {
                let forward = direction == Direction::Forward;
                [forward, !forward]
            }
            _ => [true, true],
        };
        let of_restitution = |i: usize| match falling.filter(|_| struck.contains(&i)) {
            Some(falls) => [falls, !falls],
            None => [acts(i), acts(i)],
        };
        let surfaces = 0..layout.contacts;
        let rough = (0..self.modes.len()).filter(|&i| layout.slip_group(i).is_some());
        let elastic = surfaces.clone().filter(|&i| layout.bounces(i));
        surfaces
            .map(of_contact)
            .chain(rough.map(of_friction))
            .chain(elastic.map(of_restitution))
            .collect()
    }

    /// `(q, v, t, G, D)` and shares at a state where contacts are dipped into the ground by these depths.
    fn point(&mut self, state: &[f64], time: f64, depths: &[f64], shares: Vec<f64>) -> Vec<f64> {
        let system = &mut self.system;
        let mut input = state.to_vec();
        input.extend(drive(system.model, &self.controls, time));
        system.evaluate(&input);
        let layout = &system.layout;
        let depth = |i: usize| depths.get(i).copied().unwrap_or(0.0);
        let gap = |i: usize| match layout.dip(i) {
            Some(_) => system.gap(i),
            None => system.gap(i) + depth(i),
        };
        let contacts = 0..layout.contacts;
        let dips = contacts.clone().filter(|&i| layout.dip(i).is_some());
        let mut point = state.to_vec();
        point.push(time);
        point.extend(contacts.map(gap));
        point.extend(dips.map(depth));
        point.extend(shares);
        point
    }

    /// Shares of the groups where the contacts provide these normal accelerations, and the speed of the clock.
    fn shares(&self, provided: &[f64]) -> (Vec<f64>, f64) {
        let layout = &self.system.layout;
        let a_bar = self.system.auxiliary_acceleration;
        let contacts = 0..layout.contacts;
        let weight = |i: usize| {
            if self.modes[i].is_open() {
                0.0
            } else {
                provided[i].max(0.0) / a_bar
            }
        };
        let weights: Vec<f64> = contacts.map(weight).collect();
        let speed = speed_of_clock(&weights);
        let mut shares: Vec<f64> = weights.iter().map(|w| 1.0 - speed * w).collect();
        shares.resize(layout.groups().len(), 1.0);
        for (contact, mode) in self.modes.iter().enumerate() {
            if let Some(group) = layout.slip_group(contact) {
                shares[group] = match mode {
                    ContactMode::Slip(Direction::Forward) => 1.0,
                    ContactMode::Slip(Direction::Backward) => 0.0,
                    _ => 0.5,
                };
            }
        }
        (shares, speed)
    }
}

/// The root of `theta = prod (1 - theta w_i)` in which no factor is negative.
fn speed_of_clock(weights: &[f64]) -> f64 {
    let heaviest = weights.iter().fold(1.0, |most: f64, w| most.max(*w));
    let (mut low, mut high) = (0.0, 1.0 / heaviest);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let product: f64 = weights.iter().map(|w| 1.0 - middle * w).product();
        if middle < product {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clock_runs_as_its_contacts_let_it() {
        assert!((speed_of_clock(&[]) - 1.0).abs() < 1e-15);
        // One contact: 1 / (1 + w).
        assert!((speed_of_clock(&[0.25]) - 0.8).abs() < 1e-15);
        // Two alike: theta = (1 - theta w)^2.
        let theta = speed_of_clock(&[2.0, 2.0]);
        assert!((theta - (1.0 - 2.0 * theta).powi(2)).abs() < 1e-15 && theta < 0.5);
    }
}
