//! The global phase: a small contact-implicit program that finds which contacts close when.
//!
//! Implicit Euler on equal elements of length `h = T / (N M)`, contact at position level, one
//! complementarity pair an element and contact, no switch detection:
//!
//! ```text
//! q+ = q + h v+      v+ = v + h (a(q+, v+, u) + sum_i d_i(q+) r_i)      0 <= r_i  _|_  g_i(q+) >= 0
//! ```
//!
//! With one stage an element the position level performs an inelastic impact of any size within two
//! elements: it is a time-stepping scheme. Gaps are variables of their own, in units of the order of
//! one, so that the relaxed products are balanced.

use super::kernel::Kernel;
use super::path::{Path, Units};
use super::problem::{Component, Horizon, Problem};
use super::program::Program;
use crate::model::Model;

/// Shortest and longest horizon relative to the guess, where it is free.
const HORIZONS: (f64, f64) = (0.05, 20.0);

/// The program and where its unknowns are.
pub(super) struct ContactImplicit<'a> {
    pub(super) program: Program<'a>,
    horizon: usize,
    controls: Vec<Vec<usize>>,
    /// Variables `(q, v, r)` at the end of each element.
    elements: Vec<Vec<usize>>,
    /// Pairs (force, gap) of the contacts of each element.
    pairs: Vec<Vec<(usize, usize)>>,
    start: Vec<f64>,
}

/// What both programs have in common: the horizon, the controls, and what depends only on them and the
/// final state.
pub(super) struct Frame {
    pub(super) horizon: usize,
    pub(super) controls: Vec<Vec<usize>>,
}

impl Frame {
    pub(super) fn add(
        program: &mut Program,
        model: &dyn Model,
        problem: &Problem,
        guess: &Path,
        units: &Units,
        bounds: (&[f64], &[f64]),
    ) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let range = match problem.horizon {
            Horizon::Fixed(horizon) => (horizon, horizon),
            Horizon::Free { .. } => (HORIZONS.0 * units.time, HORIZONS.1 * units.time),
        };
        let horizon = program.variable("final time", range, guess.horizon, units.time);
        let controls = (0..problem.intervals)
            .map(|k| {
                let declared = declaration.controls.iter().enumerate();
                declared
                    .map(|(i, control)| {
                        program.variable(
                            format!("`{}` on interval {k}", control.name),
                            (bounds.0[n + i], bounds.1[n + i]),
                            guess.controls[k][i],
                            units.controls[i],
                        )
                    })
                    .collect()
            })
            .collect();
        Self { horizon, controls }
    }

    /// Adds the objective and the goals on the final state `(q, v)`.
    pub(super) fn finish(
        &self,
        program: &mut Program,
        problem: &Problem,
        n: usize,
        last: &[usize],
    ) {
        let objective = &problem.objective;
        if objective.final_time != 0.0 {
            program.objective_linear(self.horizon, objective.final_time);
        }
        for &(index, weight) in &objective.final_coordinates {
            program.objective_linear(last[index], weight);
        }
        for &(index, weight) in &objective.final_velocities {
            program.objective_linear(last[n + index], weight);
        }
        for goal in &problem.goals {
            let variable = match goal.component {
                Component::Coordinate(k) => last[k],
                Component::Velocity(k) => last[n + k],
            };
            program.bound(variable, goal.value, goal.value);
        }
        if objective.control_effort == 0.0 {
            return;
        }
        let weight = objective.control_effort / problem.intervals as f64;
        match problem.horizon {
            Horizon::Fixed(horizon) => {
                for &u in self.controls.iter().flatten() {
                    program.objective_bilinear(u, u, weight * horizon);
                }
            }
            // The sum of the squares is a variable, so that the objective stays bilinear.
            Horizon::Free { .. } => {
                let controls: Vec<usize> = self.controls.iter().flatten().copied().collect();
                let unit: f64 = controls.iter().map(|&u| program.unit(u).powi(2)).sum();
                let sum = program.variable("sum of squares", (0.0, f64::INFINITY), unit, unit);
                let row = program.row("sum of squares", 0.0, f64::INFINITY);
                program.linear(row, sum, 1.0);
                for u in controls {
                    program.bilinear(row, u, u, -1.0);
                }
                program.objective_bilinear(self.horizon, sum, weight);
            }
        }
    }
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
        let frame = Frame::add(&mut program, model, problem, guess, units, bounds);
        let horizon = frame.horizon;
        let count = problem.intervals * per_interval;
        let share = 1.0 / count as f64;
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let start: Vec<f64> = problem.q.iter().chain(&problem.v).copied().collect();
        let mut before: Vec<usize> = start
            .iter()
            .enumerate()
            .map(|(k, &value)| {
                let name = format!("initial {}", state_name(model, k));
                program.variable(name, (value, value), value, 1.0)
            })
            .collect();
        let mut elements = Vec::with_capacity(count);
        let mut pairs = Vec::with_capacity(count);
        for element in 0..count {
            let u = &frame.controls[element / per_interval];
            let time = guess.horizon * (element + 1) as f64 * share;
            let sample = guess.at(time, true);
            let mut variables = Vec::with_capacity(2 * n + contacts.len());
            for (k, &value) in sample.iter().take(2 * n).enumerate() {
                let range = if k < n {
                    (bounds.0[k], bounds.1[k])
                } else {
                    free
                };
                let name = format!("{} after element {element}", state_name(model, k));
                variables.push(program.variable(name, range, value, 1.0));
            }
            let (q, v): (Vec<usize>, Vec<usize>) =
                (variables[..n].to_vec(), variables[n..].to_vec());
            let mut forces = Vec::with_capacity(contacts.len());
            let mut gaps = Vec::with_capacity(contacts.len());
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
                    gap(model, contact, &sample[..2 * n]),
                    units.gap[contact],
                );
                let row = program.row(format!("gap `{name}`, element {element}"), 0.0, 0.0);
                program.linear(row, gap, -1.0);
                let block = Kernel::Contact(contact);
                program.block(&block, [&q, &[], &[], &[]], None, vec![(row, 0, 1.0)]);
                program.pair(force, gap);
                forces.push(force);
                gaps.push((force, gap));
            }
            let mut uses = Vec::with_capacity(n);
            for k in 0..n {
                let name = declaration.coordinates[k].name;
                let row = program.row(format!("motion of `{name}`, element {element}"), 0.0, 0.0);
                program.linear(row, q[k], 1.0);
                program.linear(row, before[k], -1.0);
                program.bilinear(row, horizon, v[k], -share);
                let row = program.row(format!("force on `{name}`, element {element}"), 0.0, 0.0);
                program.linear(row, v[k], 1.0);
                program.linear(row, before[n + k], -1.0);
                uses.push((row, k, -share));
            }
            let kernel = Kernel::Acceleration(contacts.clone());
            program.block(&kernel, [&q, &v, u, &forces], Some(horizon), uses);
            before.clone_from(&variables);
            variables.extend(forces);
            elements.push(variables);
            pairs.push(gaps);
        }
        frame.finish(&mut program, problem, n, &before);
        Self {
            program: program.finish(),
            horizon,
            controls: frame.controls,
            elements,
            pairs,
            start,
        }
    }

    /// Which contacts are closed in each element at a solver's point: those whose force exceeds the gap, each
    /// in its unit.
    pub(super) fn closed(&self, x: &[f64]) -> Vec<Vec<bool>> {
        let elements = self.pairs.iter();
        elements
            .map(|pairs| {
                pairs
                    .iter()
                    .map(|&(force, gap)| x[force] > x[gap])
                    .collect()
            })
            .collect()
    }

    /// The motion of a solver's point.
    pub(super) fn path(&self, x: &[f64]) -> Path {
        let x = self.program.physical(x);
        let horizon = x[self.horizon];
        let values = |variables: &Vec<usize>| variables.iter().map(|&i| x[i]).collect();
        let mut states: Vec<Vec<f64>> = self.elements.iter().map(values).collect();
        let mut first = self.start.clone();
        first.extend(&states[0][first.len()..]);
        states.insert(0, first);
        let count = self.elements.len() as f64;
        Path {
            horizon,
            controls: self.controls.iter().map(values).collect(),
            time: (0..states.len())
                .map(|i| horizon * i as f64 / count)
                .collect(),
            states,
        }
    }
}

/// Name of component `k` of `(q, v)`.
pub(super) fn state_name(model: &dyn Model, k: usize) -> String {
    let coordinates = model.declaration().coordinates;
    match k.checked_sub(coordinates.len()) {
        None => format!("`{}`", coordinates[k].name),
        Some(velocity) => format!("d`{}`/dt", coordinates[velocity].name),
    }
}

/// Gap of a contact at `(q, v)`, at least 0.
fn gap(model: &dyn Model, contact: usize, state: &[f64]) -> f64 {
    let mut x = state.to_vec();
    x.resize(model.declaration().inputs(), 0.0);
    model.gap(contact, &x).max(0.0)
}
