//! The global phase: a small contact-implicit program that finds which contacts close when.
//!
//! Euler steps on equal elements of length `h = T / (N M)`, contact at position level, one
//! complementarity pair an element and contact, no switch detection:
//!
//! ```text
//! q+ = q + h v+      v+ = v + h (a(q', v+, u) + sum_i d_i(q') r_i)      0 <= r_i  _|_  g_i(q+) >= 0
//! ```
//!
//! Forces act at `q' = q+`, which damps, or at `q' = q`, which does not: then the step is that of SHAKE, half an element
//! late in its velocities.
//!
//! In the plane Coulomb's law is piecewise linear, and takes two pairs more of a contact with friction: with the parts
//! of its sliding velocity and what is left of its friction cone on either side,
//!
//! ```text
//! v_t,i(q+, v+) = w+ - w-      c+ + c- = 2 mu_i r_i      s_i = (c+ - c-) / 2
//! 0 <= w+  _|_  c+ >= 0        0 <= w-  _|_  c- >= 0
//! ```
//!
//! The gap of an edge is the largest `m` of those of its pieces, and only a piece that is as large carries a force:
//!
//! ```text
//! s_j = m - g_j(q+)      sum_j w_j = 1      0 <= w_j  _|_  s_j >= 0      0 <= r_j  _|_  m + s_j >= 0
//! ```
//!
//! With one stage an element the position level performs an inelastic impact of any size within two
//! elements: it is a time-stepping scheme. Gaps are variables of their own, in units of the order of
//! one, so that the relaxed products are balanced.

use crate::model::Model;
use crate::model::held::{is_held, moving};
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::collocation::friction_rows::direction_reads;
use crate::ocp::collocation::layout::FREE;
use crate::ocp::motion::control_grid::{ControlGrid, ControlShape};
use crate::ocp::motion::mode::{is_frictional, is_passed, sliding_velocity};
use crate::ocp::motion::model_input::drive;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::frame::{Frame, Provided, force_name, state_name};
use crate::program::joint_rows::Decided;
use crate::program::kernel::Kernel;
use crate::program::sparse_program::Program;
use crate::simulation::{ContactMode, Direction};

/// Unknowns of a contact in an element.
struct Contact {
    force: usize,
    /// What vanishes where there is a force: the gap, or `m + s_j` of a piece of an edge. None of dry friction, whose
    /// force is given.
    gap: Option<usize>,
    /// Forward and backward, of a contact with friction.
    sliding: Option<[Side; 2]>,
}

/// What the pieces of an edge share in an element.
#[derive(Clone, Copy)]
struct Edge {
    /// Variable of the largest of their gaps.
    largest: usize,
    /// Row of the weights.
    weights: usize,
}

/// Unknowns of a contact with friction in one direction.
#[derive(Clone, Copy)]
struct Side {
    /// Part of the sliding velocity.
    velocity: usize,
    /// What is left of the cone before the contact slips that way.
    reserve: usize,
}

/// The program and where its unknowns are.
pub(in crate::ocp) struct ContactImplicit<'a> {
    pub(in crate::ocp) program: Program<'a>,
    horizon: usize,
    controls: Vec<Vec<usize>>,
    /// Variables `(q, v, r)` at the end of each element.
    elements: Vec<Vec<usize>>,
    /// Unknowns of the contacts of each element.
    contacts: Vec<Vec<Contact>>,
    /// Variables `(q, v)` at the start.
    start: Vec<usize>,
    /// Whether each contact is a switch that is only passed.
    passed: Vec<bool>,
    /// The other pieces of the edge of each contact.
    edges: Vec<&'static [usize]>,
}

/// An element under construction.
struct Element<'e> {
    index: usize,
    /// Its share of the motion.
    share: f64,
    /// Guess of its end \[s\], and of `(q, v, r)` there.
    time: f64,
    sample: &'e [f64],
    /// Variables of the state at its end, and of what drives it.
    q: &'e [usize],
    v: &'e [usize],
    u: &'e [usize],
}

impl<'a> ContactImplicit<'a> {
    /// The program with `per_interval` elements an interval, started at `guess`.
    pub(in crate::ocp) fn new(
        setting: Setting<'a>,
        per_interval: usize,
        guess: &Trajectory,
    ) -> Self {
        let Setting {
            model,
            problem,
            units,
            bounds,
            ..
        } = setting;
        let known = model.declaration().contacts;
        let n = model.declaration().coordinates.len();
        let mut program = Program::new(model);
        let shape = ControlShape::Constant;
        let frame = Frame::add(&mut program, model, problem, guess, shape, units, bounds);
        let count = problem.intervals * per_interval;
        let share = 1.0 / count as f64;
        let mut before = frame.start.clone();
        let mut elements = Vec::with_capacity(count);
        let mut unknowns = Vec::with_capacity(count);
        for index in 0..count {
            let mut u = frame.controls[index / per_interval].clone();
            let time = guess.horizon * (index + 1) as f64 * share;
            let sample = guess.at(time, true);
            if model.declaration().explicit_time {
                let passed = (index + 1) as f64 * share;
                let name = format!("time after element {index}");
                u.push(frame.time(&mut program, name, &[(frame.horizon, passed)], time));
            }
            let mut variables = states(&mut program, setting, index, (&sample, &before));
            let (q, v) = variables.split_at(n);
            let element = Element {
                index,
                share,
                time,
                sample: &sample,
                q,
                v,
                u: &u,
            };
            let contacts = contacts(&mut program, setting, &element);
            let forces: Vec<usize> = contacts.iter().map(|contact| contact.force).collect();
            motion(
                &mut program,
                setting,
                &element,
                &contacts,
                &before,
                frame.horizon,
            );
            // An impact is a force of one element here, which neither costs nor conditions mean.
            declared(&mut program, &frame, &element, Provided::Unknown);
            before.clone_from(&variables);
            variables.extend(forces);
            elements.push(variables);
            unknowns.push(contacts);
        }
        frame.finish(&mut program, &before, Provided::Unknown, setting.elastic);
        Self {
            program: program
                .finish(&frame.controls, |largest| setting.units.objective(largest))
                .hasten(frame.horizon, setting.haste),
            horizon: frame.horizon,
            controls: frame.controls,
            elements,
            contacts: unknowns,
            start: frame.start,
            passed: (0..known.len()).map(|i| is_passed(model, i)).collect(),
            edges: known.iter().map(|c| c.alternatives).collect(),
        }
    }

    /// What the contacts do in each element at a solver's point: those are closed whose force exceeds the gap, each in
    /// its unit, and those slip whose velocity exceeds what is left of the cone.
    pub(in crate::ocp) fn modes(&self, x: &[f64]) -> Vec<Vec<ContactMode>> {
        let mode = |(index, contact): (usize, &Contact)| {
            if contact.gap.is_some_and(|gap| x[contact.force] <= x[gap]) {
                return ContactMode::Open;
            }
            let Some(sliding) = contact.sliding else {
                return ContactMode::Frictionless;
            };
            let mut both = Direction::BOTH.into_iter().zip(sliding);
            if self.passed[index] {
                let [forward, backward] = sliding.map(|side| x[side.reserve]);
                return ContactMode::Slip(Direction::of(backward - forward));
            }
            both.find(|(_, side)| x[side.velocity] > x[side.reserve])
                .map_or(ContactMode::Stick, |(direction, _)| {
                    ContactMode::Slip(direction)
                })
        };
        let elements = self.contacts.iter();
        let modes = elements.map(|contacts| contacts.iter().enumerate().map(mode).collect());
        let mut modes: Vec<Vec<ContactMode>> = modes.collect();
        self.part_pieces(&mut modes, x);
        modes
    }

    /// Leaves one piece of an edge closed where several carry a force: in the element in which the motion passes the edge.
    /// That is the one which was closed before, or else the one with the largest force.
    fn part_pieces(&self, modes: &mut [Vec<ContactMode>], x: &[f64]) {
        for element in 0..modes.len() {
            let edges = self.edges.iter().enumerate();
            for (contact, alternatives) in edges.filter(|(_, others)| !others.is_empty()) {
                let closed = |piece: &usize| !modes[element][*piece].is_open();
                let mut pieces: Vec<usize> =
                    alternatives.iter().copied().chain([contact]).collect();
                pieces.retain(closed);
                let weight = |&piece: &usize| {
                    let earlier = element.checked_sub(1).map(|before| &modes[before][piece]);
                    let stays = earlier.is_some_and(|mode| !mode.is_open());
                    (stays, x[self.contacts[element][piece].force])
                };
                let strongest = pieces.iter().copied().max_by(|a, b| {
                    let (a, b) = (weight(a), weight(b));
                    a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
                });
                for piece in pieces {
                    if Some(piece) != strongest {
                        modes[element][piece] = ContactMode::Open;
                    }
                }
            }
        }
    }

    /// The motion of a solver's point.
    pub(in crate::ocp) fn trajectory(&self, x: &[f64]) -> Trajectory {
        let x = self.program.physical(x);
        let horizon = x[self.horizon];
        let values = |variables: &Vec<usize>| variables.iter().map(|&i| x[i]).collect();
        let mut states: Vec<Vec<f64>> = self.elements.iter().map(values).collect();
        let mut first: Vec<f64> = values(&self.start);
        first.extend(&states[0][first.len()..]);
        states.insert(0, first);
        let count = self.elements.len() as f64;
        Trajectory {
            horizon,
            controls: ControlGrid::constant(self.controls.iter().map(values).collect()),
            time: (0..states.len())
                .map(|i| horizon * i as f64 / count)
                .collect(),
            states,
        }
    }
}

/// Adds the variables of the state at the end of an element, where it is not that `before`.
fn states(
    program: &mut Program,
    setting: Setting,
    element: usize,
    (sample, before): (&[f64], &[usize]),
) -> Vec<usize> {
    let Setting {
        model,
        units,
        bounds,
        ..
    } = setting;
    let n = model.declaration().coordinates.len();
    let states = sample.iter().take(2 * n).enumerate();
    states
        .map(|(k, &value)| {
            if is_held(model, k) {
                return before[k];
            }
            let range = if k < n {
                (bounds.0[k], bounds.1[k])
            } else {
                FREE
            };
            let name = format!("{} after element {element}", state_name(model, k));
            program.variable(name, range, value, units.states[k])
        })
        .collect()
}

/// Adds forces and gaps of the contacts of an element, their complementarity, and their friction.
fn contacts(program: &mut Program, setting: Setting, element: &Element) -> Vec<Contact> {
    let Setting { model, units, .. } = setting;
    let &Element {
        index,
        time,
        sample,
        q,
        v,
        u,
        ..
    } = element;
    let n = q.len();
    let declared = model.declaration().contacts.iter().enumerate();
    let mut edges: Vec<Option<Edge>> = vec![None; declared.len()];
    declared
        .map(|(contact, declared)| {
            let name = declared.name;
            let pieces = declared.alternatives.iter().copied().chain([contact]);
            let force = program.variable(
                format!("{} in element {index}", force_name(declared)),
                (0.0, f64::INFINITY),
                sample[2 * n + contact],
                units.force[contact],
            );
            let gap = if declared.dry {
                let label = format!("{}, element {index}", force_name(declared));
                let row = program.row_in(units.gap_rows[contact], label, 0.0, 0.0);
                program.linear(row, force, -1.0);
                let block = Kernel::Contact(contact);
                program.block(&block, [q, v, u, &[]], None, vec![(row, 1, 1.0)]);
                None
            } else if let Some(first) = pieces.min().filter(|_| !declared.alternatives.is_empty()) {
                let new = |program: &mut Program| edge(program, setting, element, contact);
                let edge = *edges[first].get_or_insert_with(|| new(program));
                Some(piece_gap(program, setting, element, (contact, force), edge))
            } else {
                let gap = program.variable(
                    format!("gap `{name}` after element {index}"),
                    (0.0, f64::INFINITY),
                    gap(model, contact, &sample[..2 * n], time).max(0.0),
                    units.gap[contact],
                );
                let label = format!("gap `{name}`, element {index}");
                let row = program.row_in(units.gap_rows[contact], label, 0.0, 0.0);
                program.linear(row, gap, -1.0);
                let block = Kernel::Contact(contact);
                program.block(&block, [q, &[], u, &[]], None, vec![(row, 0, 1.0)]);
                program.pair(force, gap);
                Some(gap)
            };
            let sliding = is_frictional(model, contact)
                .then(|| friction(program, setting, element, contact, force));
            Contact {
                force,
                gap,
                sliding,
            }
        })
        .collect()
}

/// Adds the running cost and the path constraints of an element.
fn declared(program: &mut Program, frame: &Frame, element: &Element, known: Provided) {
    let &Element {
        index,
        share,
        q,
        v,
        u,
        ..
    } = element;
    frame.running_cost(program, [q, v, u], known, [frame.horizon], share);
    let place = format!("after element {index}");
    frame.path_rows(program, [q, v, u], known, &place);
}

/// Adds what the pieces of the edge of a contact share in an element.
fn edge(program: &mut Program, setting: Setting, element: &Element, contact: usize) -> Edge {
    let Setting { model, units, .. } = setting;
    let state = &element.sample[..2 * element.q.len()];
    let declared = &model.declaration().contacts[contact];
    let pieces = declared.alternatives.iter().chain([&contact]);
    let gaps = pieces.map(|&piece| gap(model, piece, state, element.time));
    let place = format!(
        "gap `{}` as the largest, element {}",
        declared.name, element.index
    );
    let largest = program.variable(
        place.clone(),
        (0.0, f64::INFINITY),
        gaps.fold(0.0, f64::max),
        units.gap[contact],
    );
    let weights = program.row(format!("{place}, weights"), 1.0, 1.0);
    Edge { largest, weights }
}

/// Adds what a piece of an edge is away from carrying its force.
fn piece_gap(
    program: &mut Program,
    setting: Setting,
    element: &Element,
    (contact, force): (usize, usize),
    edge: Edge,
) -> usize {
    let Setting { model, units, .. } = setting;
    let &Element { index, q, u, .. } = element;
    let (unit, row_unit) = (units.gap[contact], units.gap_rows[contact]);
    let declared = &model.declaration().contacts[contact];
    let positive = (0.0, f64::INFINITY);
    let state = &element.sample[..2 * q.len()];
    let below = program.guessed(edge.largest) - gap(model, contact, state, element.time);
    let label = format!("gap `{}` below its edge, element {index}", declared.name);
    let row = program.row_in(row_unit, label.clone(), 0.0, 0.0);
    let slack = program.variable(label, positive, below, unit);
    program.linear(row, edge.largest, 1.0);
    program.linear(row, slack, -1.0);
    let kernel = Kernel::Contact(contact);
    program.block(&kernel, [q, &[], u, &[]], None, vec![(row, 0, -1.0)]);
    let share = 1.0 / (1 + declared.alternatives.len()) as f64;
    let label = format!("gap `{}`, weight in element {index}", declared.name);
    let weight = program.variable(label, positive, share, 1.0);
    program.linear(edge.weights, weight, 1.0);
    program.pair(weight, slack);
    let label = format!("gap `{}` away, element {index}", declared.name);
    let row = program.row_in(row_unit, label.clone(), 0.0, 0.0);
    let away = program.variable(label, positive, program.guessed(edge.largest) + below, unit);
    program.linear(row, edge.largest, 1.0);
    program.linear(row, slack, 1.0);
    program.linear(row, away, -1.0);
    program.pair(force, away);
    away
}

/// Adds the step of an element from the state `before`, with forces at the coordinates at its end.
fn motion(
    program: &mut Program,
    setting: Setting,
    element: &Element,
    contacts: &[Contact],
    before: &[usize],
    horizon: usize,
) {
    let Setting { model, units, .. } = setting;
    let &Element {
        index,
        share,
        q,
        v,
        u,
        ..
    } = element;
    let n = q.len();
    let decided = Decided::at(model, &units.states, element.sample, element.time);
    decided.add_rows(program, [q, v, u], &format!("element {index}"));
    let mut uses = Vec::with_capacity(n);
    for k in 0..moving(model) {
        let name = model.declaration().coordinates[k].name;
        if !decided.contains(k) {
            let label = format!("motion of `{name}`, element {index}");
            let row = program.row_in(units.states[k], label, 0.0, 0.0);
            program.linear(row, q[k], 1.0);
            program.linear(row, before[k], -1.0);
            program.bilinear(row, horizon, v[k], -share);
        }
        if decided.contains(n + k) {
            continue;
        }
        let label = format!("force on `{name}`, element {index}");
        let row = program.row_in(units.states[n + k], label, 0.0, 0.0);
        program.linear(row, v[k], 1.0);
        program.linear(row, before[n + k], -1.0);
        uses.push((row, k, -share));
    }
    for (contact, unknowns) in contacts.iter().enumerate() {
        let Some(sliding) = unknowns.sliding else {
            continue;
        };
        for (direction, side) in Direction::BOTH.into_iter().zip(sliding) {
            let half = 0.5 * direction.sign();
            let uses = uses.iter().map(|&(row, k, c)| (row, k, half * c)).collect();
            let kernel = Kernel::Friction(vec![contact]);
            let v = direction_reads(model, contact, v);
            let inputs = [q, v, u, &[side.reserve]];
            program.block(&kernel, inputs, Some(horizon), uses);
        }
    }
    // Dry friction, which has no normal, stands behind the surfaces.
    let surfaces = contacts.iter().filter(|contact| contact.gap.is_some());
    let forces: Vec<usize> = surfaces.map(|contact| contact.force).collect();
    let kernel = Kernel::Acceleration((0..forces.len()).collect());
    program.block(&kernel, [q, v, u, &forces], Some(horizon), uses);
}

/// Adds the unknowns and the law of friction of a contact in an element, with the given normal force.
fn friction(
    program: &mut Program,
    setting: Setting,
    element: &Element,
    contact: usize,
    force: usize,
) -> [Side; 2] {
    let Setting { model, units, .. } = setting;
    let &Element {
        index,
        time,
        sample,
        q,
        v,
        u,
        ..
    } = element;
    let name = model.declaration().contacts[contact].name;
    let mu = model.friction(contact);
    let velocity = sliding_velocity(model, contact, sample, time);
    let positive = (0.0, f64::INFINITY);
    let label = format!("sliding of `{name}`, element {index}");
    let row = program.row_in(units.gap_rows[contact], label, 0.0, 0.0);
    let label = format!("friction of `{name}`, element {index}");
    let cone = program.row_in(units.gap_rows[contact], label, 0.0, 0.0);
    let uses = vec![(row, 0, -1.0)];
    program.block(&Kernel::Sliding(contact), [q, v, u, &[]], None, uses);
    match program.laws().friction(contact) {
        Some(mu) => program.bilinear(cone, mu, force, -2.0),
        None => program.linear(cone, force, -2.0 * mu),
    }
    Direction::BOTH.map(|direction| {
        let sign = direction.sign();
        let side = format!("{direction:?} of `{name}` in element {index}");
        let part = program.variable(
            format!("sliding {side}"),
            positive,
            (sign * velocity).max(0.0),
            units.velocity(contact),
        );
        let reserve = program.variable(
            format!("cone {side}"),
            positive,
            mu * sample[2 * q.len() + contact],
            mu * units.force[contact],
        );
        program.linear(row, part, sign);
        program.linear(cone, reserve, 1.0);
        program.pair(part, reserve);
        Side {
            velocity: part,
            reserve,
        }
    })
}

/// Gap of a contact at `(q, v)` and a time.
fn gap(model: &dyn Model, contact: usize, state: &[f64], time: f64) -> f64 {
    let mut x = state.to_vec();
    let controls = vec![0.0; model.declaration().controls.len()];
    x.extend(drive(model, &controls, time));
    model.gap(contact, &x)
}
