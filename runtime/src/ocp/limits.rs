//! Bounds of coordinates and path constraints in the collocation program: at the stages, over whole intervals, and
//! where cuts ask for them.

use super::collocation::{Cut, CutKind, Phase, Setting, lagrange};
use super::cubic_bounds::{self, Cubic};
use super::frame::state_name;
use super::kernel::Kernel;
use super::program::Program;
use super::settings::{BoundsAt, ControlShape};
use super::transcribe::Builder;

impl Builder<'_, '_> {
    pub(super) fn add_cuts(&mut self, phase: &Phase) {
        let Setting {
            model,
            bounds,
            tableau,
            units,
            ..
        } = self.setting;
        let declaration = model.declaration();
        let (n, cuts) = (self.n, self.cuts);
        let here = |cut: &&Cut| cut.interval == phase.interval && cut.phase == phase.index;
        for cut in cuts.iter().filter(here) {
            let program = &mut self.program;
            let weights = lagrange(tableau, cut.theta, false);
            let at = format!(
                "between the stages of phase {} of interval {}",
                cut.phase.0, cut.interval
            );
            match cut.kind {
                CutKind::Bounds(k) => {
                    let name = format!("`{}` {at}", declaration.coordinates[k].name);
                    let row = program.row_in(units.states[k], name, bounds.0[k], bounds.1[k]);
                    combine(program, (row, k), phase, &weights);
                }
                CutKind::Gap(contact, _) | CutKind::Departure(contact)
                    if phase.closed.contains(&contact) => {}
                CutKind::Departure(contact) => {
                    let before = self.before.clone();
                    let program = &mut self.program;
                    let name =
                        format!("departure of `{}` {at}", declaration.contacts[contact].name);
                    let unit = units.gap_rows[contact];
                    let row = program.row_in(unit, name, 0.0, f64::INFINITY);
                    let slopes = lagrange(tableau, 0.0, true);
                    let stages = phase.stages.iter();
                    let stages = stages.map(|stage| (&stage.state, &stage.drive));
                    let nodes = std::iter::once((&phase.start, &before)).chain(stages);
                    for ((state, drive), slope) in nodes.zip(slopes) {
                        let (q, v) = state.split_at(n);
                        let uses = vec![(row, 1, slope)];
                        program.block(&Kernel::Contact(contact), [q, v, drive, &[]], None, uses);
                    }
                }
                CutKind::Gap(contact, margin) => {
                    let state = self.state_at(phase, cut, n, &at);
                    let drive = self.drive_within(phase, cut.theta, &at);
                    let program = &mut self.program;
                    let name = format!("gap `{}` {at}", declaration.contacts[contact].name);
                    let unit = units.gap_rows[contact];
                    let row = program.row_in(unit, name, margin, f64::INFINITY);
                    let uses = vec![(row, 0, 1.0)];
                    let kernel = Kernel::Contact(contact);
                    program.block(&kernel, [&state, &[], &drive, &[]], None, uses);
                }
                CutKind::Cone(contact, direction) => {
                    self.cone_cut(phase, contact, direction, cut, &at)
                }
                CutKind::Slip(contact) => self.slip_cut(phase, contact, cut, &at),
                CutKind::Path(constraint) => {
                    let state = self.state_at(phase, cut, 2 * n, &at);
                    let (q, v) = state.split_at(n);
                    let u = self.drive_within(phase, cut.theta, &at);
                    let (frame, problem) = (&self.frame, self.setting.problem);
                    let inputs = [q, v, &u[..]];
                    frame.path_rows_of(&mut self.program, problem, &[constraint], inputs, &at);
                }
            }
        }
    }

    /// Variables of the first `count` components of the state at a cut.
    pub(super) fn state_at(
        &mut self,
        phase: &Phase,
        cut: &Cut,
        count: usize,
        at: &str,
    ) -> Vec<usize> {
        let Setting {
            model,
            problem,
            tableau,
            units,
            ..
        } = self.setting;
        let weights = lagrange(tableau, cut.theta, false);
        let length = self.guess.horizon / problem.intervals as f64;
        let sample = self
            .guess
            .at(length * (cut.interval as f64 + cut.theta), true);
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let program = &mut self.program;
        (0..count)
            .map(|k| {
                let name = format!("{} {at}", state_name(model, k));
                let unit = units.states[k];
                let variable = program.variable(name.clone(), free, sample[k], unit);
                let row = program.row_in(unit, name, 0.0, 0.0);
                program.linear(row, variable, -1.0);
                combine(program, (row, k), phase, &weights);
                variable
            })
            .collect()
    }

    /// Bounds of the coordinates that are parabolas, or cubics under linear controls, over a whole interval.
    pub(super) fn node(&mut self, interval: usize, before: &[usize]) {
        let Setting {
            model,
            bounds,
            parabolas,
            problem,
            places,
            shape,
            ..
        } = self.setting;
        let (n, program) = (self.n, &mut self.program);
        let half = 0.5 / problem.intervals as f64;
        if places.bounds == BoundsAt::Nodes {
            return;
        }
        for k in (0..n).filter(|&k| parabolas[k]) {
            let name = model.declaration().coordinates[k].name;
            let (q0, v0, q2) = (before[k], before[n + k], self.state[k]);
            for (sign, bound) in [(1.0, bounds.0[k]), (-1.0, bounds.1[k])] {
                if !bound.is_finite() {
                    continue;
                }
                let unit = if (bounds.1[k] - bounds.0[k]).is_finite() {
                    bounds.1[k] - bounds.0[k]
                } else {
                    1.0
                };
                let inside = format!("in the bound of `{name}` over interval {interval}");
                if shape == ControlShape::Linear {
                    let cubic = Cubic {
                        from: (q0, v0),
                        to: (q2, self.state[n + k]),
                        horizon: self.frame.horizon,
                        intervals: problem.intervals,
                    };
                    cubic_bounds::bound(program, &cubic, (sign, bound, unit), &inside);
                    continue;
                }
                let size = format!("size {inside}");
                let size = program.variable(size, (0.0, f64::INFINITY), 0.1 * unit, unit);
                let place = program.variable(format!("extremum {inside}"), (0.0, 1.0), 0.5, 1.0);
                let product = program.variable(
                    format!("product {inside}"),
                    (0.0, f64::INFINITY),
                    0.05 * unit,
                    unit,
                );
                let row = program.row(format!("product {inside}"), 0.0, 0.0);
                program.linear(row, product, 1.0 / unit);
                program.bilinear(row, size, place, -1.0 / unit);
                // b_0 - p theta, b_1 + p - p theta, b_2 - s + 2 p - p theta
                for (index, [linear_size, linear_product]) in [[0.0, 0.0], [0.0, 1.0], [-1.0, 2.0]]
                    .into_iter()
                    .enumerate()
                {
                    let row = program.row(
                        format!("control point {index} {inside}"),
                        sign * bound / unit,
                        f64::INFINITY,
                    );
                    program.linear(row, if index == 2 { q2 } else { q0 }, sign / unit);
                    if index == 1 {
                        program.bilinear(row, self.frame.horizon, v0, sign * half / unit);
                    }
                    program.linear(row, size, linear_size / unit);
                    program.linear(row, product, linear_product / unit);
                    program.bilinear(row, product, place, -1.0 / unit);
                }
            }
        }
    }
}

/// Adds component `k` of the state inside a phase to a row.
fn combine(program: &mut Program, (row, k): (usize, usize), phase: &Phase, weights: &[f64]) {
    program.linear(row, phase.start[k], weights[0]);
    for (stage, weight) in phase.stages.iter().zip(&weights[1..]) {
        program.linear(row, stage.state[k], *weight);
    }
}
