//! What happens at a switch inside the collocation program: contacts let go, or slide on in another way, or strike.

use super::collocation::{Phase, Setting};
use super::frame::state_name;
use super::friction::{Turns, tangential};
use super::kernel::Kernel;
use super::mode::Mode;
use super::program::Program;
use super::sequence::Switch;
use super::transcribe::Builder;
use crate::model::contact_point;

/// Least impact velocity of a touch, relative to what the acceleration of the contact does in an interval: a motion
/// that grazes a surface is none that can be followed.
const LEAST_IMPACT: f64 = 1e-3;

impl Builder<'_, '_> {
    /// What happens at the end of a phase, the one with this (interval, index).
    pub(super) fn switch(
        &mut self,
        (index, switch): (usize, &Switch),
        companions: &[Switch],
        (interval, phase): (usize, usize),
        time: f64,
    ) {
        if switch.closes {
            let label = format!("interval {interval}, phase {phase}");
            self.close((index, switch), companions, &label, time);
            return;
        }
        if let Some(phase) = self.phases.last().filter(|_| switch.opens()) {
            vanish(&mut self.program, phase, switch.contact);
        }
        self.enter(switch, companions);
    }

    /// Sets the modes after a switch.
    pub(super) fn enter(&mut self, switch: &Switch, companions: &[Switch]) {
        for switch in std::iter::once(switch).chain(companions) {
            self.modes[switch.contact] = switch.mode;
        }
    }

    /// The impact map where a contact closes or is touched, `v_n+ = -e v_n-` for all contacts that are closed then, but
    /// for companions that it lifts.
    pub(super) fn close(
        &mut self,
        (index, switch): (usize, &Switch),
        companions: &[Switch],
        label: &str,
        time: f64,
    ) {
        let law = |contact: usize, mode: Mode| {
            let mut all = std::iter::once(switch).chain(companions);
            match all.find(|switch| switch.contact == contact) {
                Some(lifted) if lifted.opens() => Mode::Open,
                Some(switch) => switch.impulse,
                None => mode,
            }
        };
        let laws: Vec<(usize, Mode)> = (0..self.modes.len())
            .map(|contact| (contact, law(contact, self.modes[contact])))
            .filter(|(_, mode)| !mode.is_open())
            .collect();
        let (n, program, drive) = (self.n, &mut self.program, &self.before);
        let Setting { model, units, .. } = self.setting;
        let contacts = model.declaration().contacts;
        let sample = self.guess.at(time, true);
        let q = self.state[..n].to_vec();
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let mut after = q.clone();
        let mut uses = Vec::with_capacity(n);
        for k in 0..n {
            let name = format!(
                "{} after the impact that ends {label}",
                state_name(model, n + k)
            );
            let unit = units.states[n + k];
            let velocity = program.variable(name, free, sample[n + k], unit);
            let name = format!("impact on {}, end of {label}", state_name(model, n + k));
            let row = program.row_in(unit, name, 0.0, 0.0);
            program.linear(row, velocity, 1.0);
            program.linear(row, self.state[n + k], -1.0);
            uses.push((row, k, -1.0));
            after.push(velocity);
        }
        let mut impulses = Vec::new();
        for &(i, mode) in &laws {
            let name = format!("impulse of `{}` that ends {label}", contacts[i].name);
            let unit = units.gap_rows[i];
            // At the end of the motion the state before the impact is known from the guess, and the impulse with it.
            let guess = if switch.interval == self.setting.problem.intervals {
                let variables = self.state.iter().chain(drive);
                let mut x: Vec<f64> = variables.map(|&k| program.guessed(k)).collect();
                x.resize(model.declaration().inputs(), 0.0);
                let mut point = vec![0.0; contact_point::length(n)];
                model.contact(i, &x, &mut point);
                let velocity = point[contact_point::NORMAL_VELOCITY];
                (-(1.0 + model.restitution(i)) * velocity).max(0.0)
            } else {
                0.0
            };
            let impulse = program.variable(name, (0.0, f64::INFINITY), guess, unit);
            impulses.push(impulse);
            let name = format!("impact of `{}`, end of {label}", contacts[i].name);
            let row = program.row_in(unit, name, 0.0, 0.0);
            let normal = vec![(row, 1, 1.0)];
            let v = &after[n..];
            let kernel = Kernel::Contact(i);
            program.block(&kernel, [&q, v, drive, &[]], None, normal);
            let restitution = model.restitution(i);
            if restitution > 0.0 {
                let uses = vec![(row, 1, restitution)];
                let v = &self.state[n..];
                program.block(&kernel, [&q, v, drive, &[]], None, uses);
            }
            let at = format!("in the impact that ends {label}");
            if let Some(mut tangential) =
                tangential(program, model, (i, mode), (impulse, unit, unit), &at)
            {
                let turns = (&Turns::default(), false);
                tangential.push(program, model, (&q, drive), &uses);
                tangential.constrain(program, model, [&q, v, drive], turns, &at);
                self.impacts.push((index, tangential));
            }
        }
        let acting: Vec<usize> = laws.iter().map(|law| law.0).collect();
        let kernel = Kernel::Push(acting);
        program.block(&kernel, [&q, &[], drive, &impulses], None, uses);
        for touch in std::iter::once(switch).chain(companions) {
            if !touch.touches() {
                continue;
            }
            let contact = touch.contact;
            let length = self.guess.horizon / self.setting.problem.intervals as f64;
            let least = LEAST_IMPACT * self.setting.units.force[contact] * length;
            let name = format!("touch of `{}` that ends {label}", contacts[contact].name);
            let row = program.row(name, f64::NEG_INFINITY, -least);
            let v = &self.state[n..];
            let uses = vec![(row, 1, 1.0)];
            program.block(&Kernel::Contact(contact), [&q, v, drive, &[]], None, uses);
            self.touches.push((*touch, row));
        }
        self.enter(switch, companions);
        self.state = after;
    }
}

/// The force of a contact vanishes at the end of a phase.
pub(super) fn vanish(program: &mut Program, phase: &Phase, contact: usize) {
    let slot = phase.closed.iter().position(|&i| i == contact);
    if let (Some(slot), Some(stage)) = (slot, phase.stages.last()) {
        program.bound(stage.forces[slot], 0.0, 0.0);
    }
}

/// The contacts that are touched in an impact.
pub(super) fn touches(switch: &Switch, companions: &[Switch]) -> Vec<usize> {
    let struck = std::iter::once(switch).chain(companions);
    struck.filter(|s| s.touches()).map(|s| s.contact).collect()
}
