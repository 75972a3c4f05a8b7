//! Rows of the conditions between the stages.

use super::builder::Builder;
use super::discretization::Setting;
use super::friction_rows::reserve_between;
use super::layout::{Cut, CutKind, Distance, Kept, Phase};
use super::provided;
use super::stage_inputs::drive_within;
use crate::model::held::is_held;
use crate::ocp::program::frame::{Provided, state_name};
use crate::program::kernel::Kernel;
use crate::program::sparse_program::Program;
use crate::simulation::{ContactMode, Direction};

pub(in crate::ocp) fn add(builder: &mut Builder, phase: &mut Phase) {
    let Setting {
        model,
        bounds,
        tableau,
        units,
        ..
    } = builder.setting;
    let declaration = model.declaration();
    let (n, cuts) = (builder.n, builder.cuts);
    let here = |cut: &&Cut| cut.interval == phase.interval && cut.phase == phase.index;
    for cut in cuts.iter().filter(here) {
        let program = &mut builder.program;
        let weights = tableau.values_with_start(cut.theta);
        let at = format!(
            "between the stages of phase {} of interval {}",
            cut.phase.0, cut.interval
        );
        match cut.kind {
            CutKind::Bounds(k) => {
                let name = format!("`{}` {at}", declaration.coordinates[k].name);
                let row = program.row_in(units.states[k], name, bounds.0[k], bounds.1[k]);
                combine(program, row, k, phase, &weights);
            }
            CutKind::Gap(contact, _) | CutKind::Departure(contact) | CutKind::Approach(contact)
                if phase.closed.contains(&phase.pieces.acting(contact)) => {}
            CutKind::Departure(contact) => {
                let slopes = tableau.slopes_with_start(cut.theta);
                let name = format!("departure of `{}` {at}", declaration.contacts[contact].name);
                moves(builder, phase, contact, &slopes, name, (0.0, f64::INFINITY));
            }
            CutKind::Approach(contact) => {
                let name = format!("approach to `{}` {at}", declaration.contacts[contact].name);
                let below = (f64::NEG_INFINITY, 0.0);
                moves(builder, phase, contact, &weights, name, below);
            }
            CutKind::Gap(contact, margin) => {
                let contact = phase.pieces.acting(contact);
                let state = state_at(builder, phase, cut, n, &at);
                let drive = drive_within(builder, phase, cut.theta, &at);
                let program = &mut builder.program;
                let name = format!("gap `{}` {at}", declaration.contacts[contact].name);
                let unit = units.gap_rows[contact];
                let row = program.row_in(unit, name.clone(), margin, f64::INFINITY);
                builder.distances.push(Distance {
                    name: format!("margin of the {name}"),
                    kept: Kept::Row(row),
                    amount: margin,
                    unit: declaration.contacts[contact].unit.to_owned(),
                    chosen: true,
                });
                let uses = vec![(row, 0, 1.0)];
                let kernel = Kernel::Contact(contact);
                program.block(&kernel, [&state, &[], &drive, &[]], None, uses);
            }
            CutKind::Cone(contact, direction) => {
                let row = cone(builder, phase, contact, direction, cut, &at);
                let kept = row.map(|row| (cut.theta, contact, direction, row));
                phase.between.extend(kept);
            }
            CutKind::Slip(contact) => {
                let row = slip(builder, phase, contact, cut, &at);
                let kept = row.map(|(direction, row)| (cut.theta, contact, direction, row));
                phase.between.extend(kept);
            }
            CutKind::Path(constraint) => {
                let state = state_at(builder, phase, cut, 2 * n, &at);
                let (q, v) = state.split_at(n);
                let u = drive_within(builder, phase, cut.theta, &at);
                let provided = provided::within(builder, phase, cut.theta, &at);
                let (frame, program) = (&builder.frame, &mut builder.program);
                let (inputs, known) = ([q, v, &u[..]], Provided::Known(&provided));
                frame.path_rows_of(program, &[constraint], inputs, known, &at);
            }
        }
    }
}

/// Bounds what the normal velocities of a contact at the nodes add up to with these factors.
fn moves(
    builder: &mut Builder,
    phase: &Phase,
    contact: usize,
    factors: &[f64],
    name: String,
    (lower, upper): (f64, f64),
) {
    let unit = builder.setting.units.gap_rows[contact];
    let row = builder.program.row_in(unit, name, lower, upper);
    let stages = phase.stages.iter();
    let stages = stages.map(|stage| (&stage.state, &stage.drive));
    let nodes = std::iter::once((&phase.start, &builder.before)).chain(stages);
    for ((state, drive), &factor) in nodes.zip(factors) {
        let (q, v) = state.split_at(builder.n);
        let uses = vec![(row, 1, factor)];
        let inputs = [q, v, drive, &[]];
        builder
            .program
            .block(&Kernel::Contact(contact), inputs, None, uses);
    }
}

/// Variables of the first `count` components of the state at a cut.
pub(in crate::ocp) fn state_at(
    builder: &mut Builder,
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
    } = builder.setting;
    let weights = tableau.values_with_start(cut.theta);
    let length = builder.guess.horizon / problem.intervals as f64;
    let sample = builder
        .guess
        .at(length * (cut.interval as f64 + cut.theta), true);
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    let program = &mut builder.program;
    (0..count)
        .map(|k| {
            if is_held(model, k) {
                return phase.start[k];
            }
            let name = format!("{} {at}", state_name(model, k));
            let unit = units.states[k];
            let variable = program.variable(name.clone(), free, sample[k], unit);
            let row = program.row_in(unit, name, 0.0, 0.0);
            program.linear(row, variable, -1.0);
            combine(program, row, k, phase, &weights);
            variable
        })
        .collect()
}

/// Adds component `k` of the state inside a phase to a row.
fn combine(program: &mut Program, row: usize, k: usize, phase: &Phase, weights: &[f64]) {
    program.linear(row, phase.start[k], weights[0]);
    for (stage, weight) in phase.stages.iter().zip(&weights[1..]) {
        program.linear(row, stage.state[k], *weight);
    }
}

/// Keeps the force of a contact that sticks in its cone at a cut.
fn cone(
    builder: &mut Builder,
    phase: &Phase,
    contact: usize,
    direction: Direction,
    cut: &Cut,
    at: &str,
) -> Option<usize> {
    if phase.modes[contact] != ContactMode::Stick {
        return None;
    }
    let (model, tableau) = (builder.setting.model, builder.setting.tableau);
    let name = model.declaration().contacts[contact].name;
    let mut weights = vec![0.0; phase.stages.len()];
    tableau.lagrange_values(cut.theta, &mut weights);
    let name = format!("friction cone of `{name}` {at}");
    let unit = builder.setting.units.gap_rows[contact];
    let row = builder.program.row_in(unit, name, 0.0, f64::INFINITY);
    let program = &mut builder.program;
    reserve_between(
        program,
        model,
        row,
        contact,
        direction,
        &phase.stages,
        &weights,
    );
    Some(row)
}

/// Keeps a contact that slips from slipping back at a cut.
fn slip(
    builder: &mut Builder,
    phase: &Phase,
    contact: usize,
    cut: &Cut,
    at: &str,
) -> Option<(Direction, usize)> {
    let ContactMode::Slip(direction) = phase.modes[contact] else {
        return None;
    };
    let state = state_at(builder, phase, cut, 2 * builder.n, at);
    let (q, v) = state.split_at(builder.n);
    let drive = drive_within(builder, phase, cut.theta, at);
    let name = builder.setting.model.declaration().contacts[contact].name;
    let name = format!("sliding velocity of `{name}` {at}");
    let unit = builder.setting.units.gap_rows[contact];
    let row = builder.program.row_in(unit, name, 0.0, f64::INFINITY);
    let uses = vec![(row, 0, direction.sign())];
    builder
        .program
        .block(&Kernel::Sliding(contact), [q, v, &drive, &[]], None, uses);
    Some((direction, row))
}
