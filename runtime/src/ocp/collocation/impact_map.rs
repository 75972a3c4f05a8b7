//! What happens at a switch inside the collocation program: contacts let go, or slide on in another way, or strike.

use super::builder::Builder;
use super::discretization::Setting;
use super::friction_rows::Normal;
use super::layout::{Distance, FREE, Kept};
use super::turns::Turns;
use super::{friction_rows, provided};
use crate::model::held::is_held;
use crate::model::{
    ContactDeclaration, Function, Model, contact_point, switching_terms, tangent_point,
};
use crate::ocp::motion::mode::sets;
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::ocp::program::frame::state_name;
use crate::program::kernel::Kernel;
use crate::simulation::{ContactMode, per_second};
use crate::yardstick;

/// Least impact velocity of a touch, relative to what the acceleration of the contact does in an interval: a motion
/// that grazes a surface is none that can be followed.
const LEAST_IMPACT: f64 = 1e-3;

/// The switches of one instant: the first one and those that accompany it.
pub(super) struct Instant<'s> {
    /// Index of the first one in the sequence.
    pub(super) index: usize,
    pub(super) first: &'s Switch,
    companions: &'s [Switch],
}

impl<'s> Instant<'s> {
    /// The switches of the instant that begins with this index.
    pub(super) fn at(switches: &'s [Switch], index: usize) -> Self {
        Self {
            index,
            first: &switches[index],
            companions: Sequence::companions(switches, index),
        }
    }

    pub(super) fn all(&self) -> impl Iterator<Item = &'s Switch> {
        std::iter::once(self.first).chain(self.companions)
    }

    /// The contacts that are touched.
    pub(super) fn touched(&self) -> Vec<usize> {
        let touched = self.all().filter(|s| s.touches());
        touched.map(|s| s.contact).collect()
    }

    /// Whether its contact opens because it ends at an edge, or another one takes over there.
    pub(super) fn ends_at_edge(&self) -> bool {
        let mut companions = self.companions.iter();
        self.first.opens() && companions.any(|switch| switch.passes || switch.stays())
    }

    /// How a contact, with the given mode until then, takes part in an impact: not if the impact lifts it.
    fn law(&self, contact: usize, before: ContactMode) -> ContactMode {
        match self.all().find(|switch| switch.contact == contact) {
            Some(lifted) if lifted.opens() => ContactMode::Open,
            Some(switch) => switch.impulse,
            None => before,
        }
    }
}

/// A contact that opens has no force at the end of the phase before, unless it ends there; the others slide on in another way.
pub(super) fn let_go(builder: &mut Builder, instant: &Instant) {
    let released = instant.first.opens() && !instant.ends_at_edge();
    if let Some(phase) = builder.phases.last().filter(|_| released) {
        let slot = phase
            .closed
            .iter()
            .position(|&i| i == instant.first.contact);
        if let (Some(slot), Some(stage)) = (slot, phase.stages.last()) {
            builder.program.bound(stage.forces[slot], 0.0, 0.0);
        }
    }
    enter(builder, instant);
}

/// Sets the modes after a switch, and the velocities that conditions set there which come true: those that come true together from the same
/// velocities, and behind them those that what these set makes true.
pub(super) fn enter(builder: &mut Builder, instant: &Instant) {
    modes_after(builder, instant);
    let model = builder.setting.model;
    let set = instant.all().filter(|switch| sets(model, switch));
    let mut waiting: Vec<usize> = set.map(|switch| switch.contact).collect();
    while let Some(&first) = waiting.first() {
        let before = builder.state.clone();
        let x = guessed(builder, &before, model.declaration().inputs());
        let follows = |&i: &usize| i != first && is_false(model, i, &x);
        let (late, now): (Vec<usize>, Vec<usize>) = waiting.iter().partition(|i| follows(i));
        for contact in now {
            set_from(builder, contact, &before);
        }
        waiting = late;
    }
}

/// Whether the function of a condition is below zero at the input vector of a guess.
fn is_false(model: &dyn Model, contact: usize, x: &[f64]) -> bool {
    let n = model.declaration().coordinates.len();
    let mut point = vec![0.0; tangent_point::length(n)];
    model.tangent(contact, x, &mut point);
    let against = point[tangent_point::SLIDING_VELOCITY];
    against > yardstick::PROMISE * switching_terms(model, contact, x)
}

/// The guess of a state and of the inputs behind it.
fn guessed(builder: &Builder, state: &[usize], length: usize) -> Vec<f64> {
    let read = state.iter().chain(&builder.before);
    let mut x: Vec<f64> = read.map(|&i| builder.program.guessed(i)).collect();
    x.resize(length, 0.0);
    x
}

/// The velocities that a condition sets: those `before` as it says, in the place of the present ones.
fn set_from(builder: &mut Builder, contact: usize, before: &[usize]) {
    let Setting { model, units, .. } = builder.setting;
    let (n, declaration) = (builder.n, model.declaration());
    let Some(declared) = declaration.optimal_control else {
        return;
    };
    let terms = declared.contacts;
    let x = guessed(builder, before, declaration.impact_inputs());
    let mut values = vec![0.0; terms.impact_functions()];
    model.values(Function::Impact, &x, &mut values);
    let mut uses = Vec::new();
    for (index, &(of, velocity)) in terms.resets.iter().enumerate() {
        if of != contact {
            continue;
        }
        let (function, k) = (terms.of_impacts() + index, n + velocity);
        let name = format!(
            "set of {} by `{}`",
            state_name(model, k),
            declaration.contacts[contact].name
        );
        let program = &mut builder.program;
        let variable = program.variable(name.clone(), FREE, values[function], units.states[k]);
        let row = program.row_in(units.states[k], name, 0.0, 0.0);
        program.linear(row, variable, 1.0);
        uses.push((row, function, -1.0));
        builder.state[k] = variable;
    }
    let (q, v) = before.split_at(n);
    let nothing = vec![None; 2 * declaration.contacts.len()];
    let inputs = [q, v, &builder.before[..]];
    builder.program.block_behind(
        &Kernel::Whole(Function::Impact),
        inputs,
        &nothing,
        None,
        uses,
    );
}

/// Sets the modes after a switch.
fn modes_after(builder: &mut Builder, instant: &Instant) {
    for switch in instant.all() {
        builder.modes[switch.contact] = switch.mode;
        if switch.passes {
            builder.pieces.pass_to(switch.contact);
        }
    }
}

/// The impact map where a contact closes or is touched, `v_n+ = -e v_n-` for all contacts that are closed then, but
/// for companions that it lifts. The impact ends the part of the motion that `label` names, at a time of the guess.
pub(super) fn close(builder: &mut Builder, instant: &Instant, label: &str, time: f64) {
    let contacts = builder.setting.model.declaration().contacts;
    let modes = builder.modes.iter().enumerate();
    let laws: Vec<(usize, ContactMode)> = modes
        .map(|(contact, &mode)| (contact, instant.law(contact, mode)))
        // Dry friction has no impulses.
        .filter(|&(contact, mode)| !mode.is_open() && !contacts[contact].dry)
        .collect();
    let (after, rows) = velocities_after(builder, label, time);
    let uses = |rows: &[usize]| -> Vec<(usize, usize, f64)> {
        let rows = rows.iter().enumerate();
        rows.map(|(k, &row)| (row, k, -1.0)).collect()
    };
    let (n, model) = (builder.n, builder.setting.model);
    let (q, v) = after.split_at(n);
    let drive = builder.before.clone();
    let mut impulses = Vec::new();
    let first = builder.impacts.len();
    for &(contact, mode) in &laws {
        let impulse = impulse_rows(builder, instant, contact, &after, label);
        impulses.push(impulse);
        let unit = builder.setting.units.gap_rows[contact];
        let normal = Normal {
            contact,
            mode,
            force: impulse,
            force_unit: unit,
            row_unit: unit,
        };
        let at = format!("in the impact that ends {label}");
        let program = &mut builder.program;
        if let Some(mut tangential) = friction_rows::tangential(program, model, &normal, &at) {
            let (turns, last) = (&Turns::default(), false);
            friction_rows::push(&tangential, program, model, [q, &[], &drive], &uses(&rows));
            let inputs = [q, v, &drive];
            friction_rows::constrain(&mut tangential, program, model, inputs, turns, last, &at);
            builder.impacts.push((instant.index, tangential));
        }
    }
    let acting: Vec<usize> = laws.iter().map(|law| law.0).collect();
    let kernel = Kernel::Push(acting.clone());
    let program = &mut builder.program;
    program.block(&kernel, [q, &[], &drive, &impulses], None, uses(&rows));
    let of_contacts: Vec<(usize, usize)> = acting.into_iter().zip(impulses).collect();
    provided::in_impact(builder, first, &of_contacts, label);
    touch_rows(builder, instant, label);
    builder.state = after;
    enter(builder, instant);
}

/// Adds the velocities after an impact; the state after it, and the rows that the impulses act on.
fn velocities_after(builder: &mut Builder, label: &str, time: f64) -> (Vec<usize>, Vec<usize>) {
    let (n, program) = (builder.n, &mut builder.program);
    let Setting { model, units, .. } = builder.setting;
    let sample = builder.guess.at(time, true);
    let mut after = builder.state[..n].to_vec();
    let mut rows = Vec::with_capacity(n);
    for (k, &guess) in sample.iter().enumerate().take(2 * n).skip(n) {
        if is_held(model, k) {
            after.push(builder.state[k]);
            continue;
        }
        let name = format!(
            "{} after the impact that ends {label}",
            state_name(model, k)
        );
        let unit = units.states[k];
        let velocity = program.variable(name, FREE, guess, unit);
        let name = format!("impact on {}, end of {label}", state_name(model, k));
        let row = program.row_in(unit, name, 0.0, 0.0);
        program.linear(row, velocity, 1.0);
        program.linear(row, builder.state[k], -1.0);
        rows.push(row);
        after.push(velocity);
    }
    (after, rows)
}

/// Adds the normal impulse of a contact and Newton's law for it.
fn impulse_rows(
    builder: &mut Builder,
    instant: &Instant,
    contact: usize,
    after: &[usize],
    label: &str,
) -> usize {
    let model = builder.setting.model;
    let restitution = model.restitution(contact);
    let unit = builder.setting.units.gap_rows[contact];
    let guess = if instant.first.interval == builder.setting.problem.intervals {
        final_impulse(builder, contact)
    } else {
        0.0
    };
    let (n, drive, program) = (builder.n, &builder.before, &mut builder.program);
    let name = model.declaration().contacts[contact].name;
    let label = format!("`{name}` that ends {label}");
    let (q, v) = after.split_at(n);
    let impulse = program.variable(
        format!("impulse of {label}"),
        (0.0, f64::INFINITY),
        guess,
        unit,
    );
    let row = program.row_in(unit, format!("impact of {label}"), 0.0, 0.0);
    let kernel = Kernel::Contact(contact);
    program.block(&kernel, [q, v, drive, &[]], None, vec![(row, 1, 1.0)]);
    let found = program.laws().restitution(contact);
    if found.is_some() || restitution > 0.0 {
        let v = &builder.state[n..];
        let uses = vec![(row, 1, if found.is_some() { 1.0 } else { restitution })];
        program.block(&kernel, [q, v, drive, &[]], found, uses);
    }
    impulse
}

/// The impulse at the end of the motion, where the guess tells the state before the impact.
fn final_impulse(builder: &Builder, contact: usize) -> f64 {
    let model = builder.setting.model;
    let x = guessed(builder, &builder.state, model.declaration().inputs());
    let mut point = vec![0.0; contact_point::length(builder.n)];
    model.contact(contact, &x, &mut point);
    let velocity = point[contact_point::NORMAL_VELOCITY];
    (-(1.0 + model.restitution(contact)) * velocity).max(0.0)
}

/// Adds the least impact velocities of the contacts that are touched.
fn touch_rows(builder: &mut Builder, instant: &Instant, label: &str) {
    let n = builder.n;
    let Setting {
        model, units, kept, ..
    } = builder.setting;
    let length = builder.interval_length();
    for touch in instant.all().filter(|switch| switch.touches()) {
        let contact = touch.contact;
        let least = LEAST_IMPACT * kept * units.force[contact] * length;
        let ContactDeclaration { name, unit, .. } = model.declaration().contacts[contact];
        let name = format!("touch of `{name}` that ends {label}");
        let program = &mut builder.program;
        let row = program.row(name.clone(), f64::NEG_INFINITY, -least);
        builder.distances.push(Distance {
            name: format!("least velocity of the {name}"),
            kept: Kept::Row(row),
            amount: least,
            unit: per_second(unit),
            chosen: false,
        });
        let (q, v) = builder.state.split_at(n);
        let (drive, uses) = (&builder.before, vec![(row, 1, 1.0)]);
        program.block(&Kernel::Contact(contact), [q, v, drive, &[]], None, uses);
        builder.touches.push((*touch, row));
    }
}
