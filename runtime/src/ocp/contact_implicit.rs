//! The global phase: a small contact-implicit program that finds which contacts close when.
//!
//! Implicit Euler on equal elements of length `h = T / (N M)`, contact at position level, one
//! complementarity pair an element and contact, no switch detection:
//!
//! ```text
//! q+ = q + h v+      v+ = v + h (a(q+, v+, u) + sum_i d_i(q+) r_i)      0 <= r_i  _|_  g_i(q+) >= 0
//! ```
//!
//! In the plane Coulomb's law is piecewise linear, and takes two pairs more of a contact with friction: with the parts
//! of its sliding velocity and what is left of its friction cone on either side,
//!
//! ```text
//! v_t,i(q+, v+) = w+ - w-      c+ + c- = 2 mu_i r_i      s_i = (c+ - c-) / 2
//! 0 <= w+  _|_  c+ >= 0        0 <= w-  _|_  c- >= 0
//! ```
//!
//! With one stage an element the position level performs an inelastic impact of any size within two
//! elements: it is a time-stepping scheme. Gaps are variables of their own, in units of the order of
//! one, so that the relaxed products are balanced.

use super::control_grid::ControlGrid;
use super::frame::{Frame, state_name};
use super::kernel::Kernel;
use super::mode::{Direction, Mode, is_rough, sliding_velocity};
use super::path::{Path, drive};
use super::problem::Problem;
use super::program::Program;
use super::settings::ControlShape;
use super::units::Units;
use crate::model::Model;

/// Unknowns of a contact in an element.
struct Contact {
    force: usize,
    gap: usize,
    /// (part of the sliding velocity, what is left of the cone before the contact slips that way), forward and
    /// backward, of a contact with friction.
    sliding: Option<[(usize, usize); 2]>,
}

/// The program and where its unknowns are.
pub(super) struct ContactImplicit<'a> {
    pub(super) program: Program<'a>,
    horizon: usize,
    controls: Vec<Vec<usize>>,
    /// Variables `(q, v, r)` at the end of each element.
    elements: Vec<Vec<usize>>,
    /// Unknowns of the contacts of each element.
    contacts: Vec<Vec<Contact>>,
    /// Variables `(q, v)` at the start.
    start: Vec<usize>,
}

impl<'a> ContactImplicit<'a> {
    /// The program with `per_interval` elements an interval, started at `guess`.
    pub(super) fn new(
        model: &'a dyn Model,
        problem: &Problem,
        per_interval: usize,
        guess: &Path,
        units: &Units,
        bounds: (&[f64], &[f64]),
    ) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let contacts: Vec<usize> = (0..declaration.contacts.len()).collect();
        let mut program = Program::new(model);
        let shape = ControlShape::Constant;
        let frame = Frame::add(&mut program, model, problem, (guess, shape), units, bounds);
        let horizon = frame.horizon;
        let count = problem.intervals * per_interval;
        let share = 1.0 / count as f64;
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let mut before = frame.start.clone();
        let mut elements = Vec::with_capacity(count);
        let mut unknowns = Vec::with_capacity(count);
        for element in 0..count {
            let mut u = frame.controls[element / per_interval].clone();
            let time = guess.horizon * (element + 1) as f64 * share;
            let sample = guess.at(time, true);
            if declaration.explicit_time {
                let passed = (element + 1) as f64 * share;
                let name = format!("time after element {element}");
                u.push(frame.time(&mut program, name, &[(horizon, passed)], time));
            }
            let u = &u[..];
            let mut variables = Vec::with_capacity(2 * n + contacts.len());
            for (k, &value) in sample.iter().take(2 * n).enumerate() {
                let range = if k < n {
                    (bounds.0[k], bounds.1[k])
                } else {
                    free
                };
                let name = format!("{} after element {element}", state_name(model, k));
                variables.push(program.variable(name, range, value, units.states[k]));
            }
            let (q, v): (Vec<usize>, Vec<usize>) =
                (variables[..n].to_vec(), variables[n..].to_vec());
            let mut forces = Vec::with_capacity(contacts.len());
            let mut pairs = Vec::with_capacity(contacts.len());
            for &contact in &contacts {
                let name = declaration.contacts[contact].name;
                let force = program.variable(
                    format!("force of `{name}` in element {element}"),
                    (0.0, f64::INFINITY),
                    sample[2 * n + contact],
                    units.force[contact],
                );
                let gap = program.variable(
                    format!("gap `{name}` after element {element}"),
                    (0.0, f64::INFINITY),
                    gap(model, contact, (&sample[..2 * n], time)),
                    units.gap[contact],
                );
                let label = format!("gap `{name}`, element {element}");
                let row = program.row_in(units.gap_rows[contact], label, 0.0, 0.0);
                program.linear(row, gap, -1.0);
                let block = Kernel::Contact(contact);
                program.block(&block, [&q, &[], u, &[]], None, vec![(row, 0, 1.0)]);
                program.pair(force, gap);
                forces.push(force);
                let sliding = is_rough(model, contact).then(|| {
                    let place = (contact, element, force);
                    friction(
                        &mut program,
                        model,
                        place,
                        [&q, &v, u],
                        (&sample, time),
                        units,
                    )
                });
                pairs.push(Contact {
                    force,
                    gap,
                    sliding,
                });
            }
            let mut uses = Vec::with_capacity(n);
            for k in 0..n {
                let name = declaration.coordinates[k].name;
                let label = format!("motion of `{name}`, element {element}");
                let row = program.row_in(units.states[k], label, 0.0, 0.0);
                program.linear(row, q[k], 1.0);
                program.linear(row, before[k], -1.0);
                program.bilinear(row, horizon, v[k], -share);
                let label = format!("force on `{name}`, element {element}");
                let row = program.row_in(units.states[n + k], label, 0.0, 0.0);
                program.linear(row, v[k], 1.0);
                program.linear(row, before[n + k], -1.0);
                uses.push((row, k, -share));
            }
            for (contact, pair) in pairs.iter().enumerate() {
                let Some(sliding) = pair.sliding else {
                    continue;
                };
                for (direction, (_, reserve)) in Direction::BOTH.into_iter().zip(sliding) {
                    let half = 0.5 * direction.sign();
                    let uses = uses.iter().map(|&(row, k, c)| (row, k, half * c)).collect();
                    let kernel = Kernel::Friction(vec![contact]);
                    program.block(&kernel, [&q, &[], u, &[reserve]], Some(horizon), uses);
                }
            }
            let kernel = Kernel::Acceleration(contacts.clone());
            program.block(&kernel, [&q, &v, u, &forces], Some(horizon), uses);
            frame.running_cost(&mut program, problem, [&q, &v, u], (horizon, share));
            let place = format!("after element {element}");
            frame.path_rows(&mut program, problem, [&q, &v, u], &place);
            before.clone_from(&variables);
            variables.extend(forces);
            elements.push(variables);
            unknowns.push(pairs);
        }
        frame.finish(&mut program, problem, &before);
        Self {
            program: program.finish(&frame.controls),
            horizon,
            controls: frame.controls,
            elements,
            contacts: unknowns,
            start: frame.start,
        }
    }

    /// What the contacts do in each element at a solver's point: those are closed whose force exceeds the gap, each in
    /// its unit, and those slip whose velocity exceeds what is left of the cone.
    pub(super) fn modes(&self, x: &[f64]) -> Vec<Vec<Mode>> {
        let mode = |contact: &Contact| {
            if x[contact.force] <= x[contact.gap] {
                return Mode::Open;
            }
            let Some(sliding) = contact.sliding else {
                return Mode::Frictionless;
            };
            let mut both = Direction::BOTH.into_iter().zip(sliding);
            both.find(|&(_, (velocity, reserve))| x[velocity] > x[reserve])
                .map_or(Mode::Stick, |(direction, _)| Mode::Slip(direction))
        };
        let elements = self.contacts.iter();
        elements
            .map(|contacts| contacts.iter().map(mode).collect())
            .collect()
    }

    /// The motion of a solver's point.
    pub(super) fn path(&self, x: &[f64]) -> Path {
        let x = self.program.physical(x);
        let horizon = x[self.horizon];
        let values = |variables: &Vec<usize>| variables.iter().map(|&i| x[i]).collect();
        let mut states: Vec<Vec<f64>> = self.elements.iter().map(values).collect();
        let mut first: Vec<f64> = values(&self.start);
        first.extend(&states[0][first.len()..]);
        states.insert(0, first);
        let count = self.elements.len() as f64;
        Path {
            horizon,
            controls: ControlGrid::constant(self.controls.iter().map(values).collect()),
            time: (0..states.len())
                .map(|i| horizon * i as f64 / count)
                .collect(),
            states,
        }
    }
}

/// Adds the unknowns and the law of friction of a contact in an element, with the given normal force.
fn friction(
    program: &mut Program,
    model: &dyn Model,
    (contact, element, force): (usize, usize, usize),
    [q, v, u]: [&[usize]; 3],
    (sample, time): (&[f64], f64),
    units: &Units,
) -> [(usize, usize); 2] {
    let name = model.declaration().contacts[contact].name;
    let mu = model.friction(contact);
    let n = q.len();
    let velocity = sliding_velocity(model, contact, sample, time);
    let positive = (0.0, f64::INFINITY);
    let label = format!("sliding of `{name}`, element {element}");
    let row = program.row_in(units.gap_rows[contact], label, 0.0, 0.0);
    let label = format!("friction of `{name}`, element {element}");
    let cone = program.row_in(units.gap_rows[contact], label, 0.0, 0.0);
    let uses = vec![(row, 0, -1.0)];
    program.block(&Kernel::Sliding(contact), [q, v, u, &[]], None, uses);
    program.linear(cone, force, -2.0 * mu);
    Direction::BOTH.map(|direction| {
        let sign = direction.sign();
        let side = format!("{direction:?} of `{name}` in element {element}");
        let part = program.variable(
            format!("sliding {side}"),
            positive,
            (sign * velocity).max(0.0),
            units.velocity(contact),
        );
        let reserve = program.variable(
            format!("cone {side}"),
            positive,
            mu * sample[2 * n + contact],
            mu * units.force[contact],
        );
        program.linear(row, part, sign);
        program.linear(cone, reserve, 1.0);
        program.pair(part, reserve);
        (part, reserve)
    })
}

/// Gap of a contact at `(q, v)` and a time, at least 0.
fn gap(model: &dyn Model, contact: usize, (state, time): (&[f64], f64)) -> f64 {
    let mut x = state.to_vec();
    let controls = vec![0.0; model.declaration().controls.len()];
    x.extend(drive(model, &controls, time));
    model.gap(contact, &x).max(0.0)
}
