//! Conditions at the start of the motion.

use super::builder::Builder;
use super::discretization::Setting;
use super::layout::Phase;
use super::provided;
use crate::model::held::{first_at_stages, is_held, moving};
use crate::model::{Function, Given, contact_point};
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::mode::{sliding_velocity, zero_velocity};
use crate::ocp::problem::has_free_start;
use crate::ocp::program::frame::Provided;
use crate::program::kernel::Kernel;
use crate::simulation::ContactMode;
use crate::yardstick;

/// Contacts that are pulled into slip from the start of the motion.
pub(in crate::ocp) fn pulled(builder: &Builder) -> Vec<usize> {
    let Setting { model, problem, .. } = builder.setting;
    let start = problem.start();
    let zero = zero_velocity(&start[builder.n..], builder.setting.units.slow());
    let modes = builder.modes.iter().enumerate();
    modes
        .filter(|(_, mode)| matches!(mode, ContactMode::Slip(_)) && !has_free_start(model))
        .map(|(contact, _)| contact)
        .filter(|&contact| sliding_velocity(model, contact, &start, 0.0).abs() <= zero)
        .collect()
}

/// Where initial values are free: contacts closed at the start touch and rest, the others are open.
pub(in crate::ocp) fn add(builder: &mut Builder) {
    let Setting { model, units, .. } = builder.setting;
    let free: Vec<usize> = (0..2 * builder.n)
        .filter(|&k| {
            let (lower, upper) = builder.program.bounds(builder.frame.start[k]);
            lower < upper
        })
        .collect();
    if !has_free_start(model) {
        return;
    }
    for (i, contact) in model.declaration().contacts.iter().enumerate() {
        let reads = |row: u32| {
            let mut entries = contact.jacobian.entries.iter();
            entries.any(|&(r, column)| r == row && free.contains(&(column as usize)))
        };
        let mode = builder.modes[i];
        let closed = !mode.is_open();
        let mut uses = Vec::new();
        if reads(0) && !(closed && follows_from_parameters(builder, i, 0)) {
            let acting = builder.pieces.acting(i);
            let touches = !builder.modes[acting].is_open();
            let upper = if touches { 0.0 } else { f64::INFINITY };
            let lower = if acting == i { 0.0 } else { f64::NEG_INFINITY };
            if acting == i || touches {
                let name = format!("gap `{}` at the start", contact.name);
                let row = builder
                    .program
                    .row_in(units.gap_rows[i], name, lower, upper);
                uses.push((row, 0, 1.0));
            }
        }
        let says_more = |builder: &Builder| {
            !is_level(builder, i, &free) && !follows_from_parameters(builder, i, 1)
        };
        if closed && reads(1) && !contact.dry && says_more(builder) {
            let name = format!("normal velocity of `{}` at the start", contact.name);
            let row = builder.program.row_in(units.gap_rows[i], name, 0.0, 0.0);
            uses.push((row, 1, 1.0));
        }
        let (q, v) = builder.frame.start.split_at(builder.n);
        if !uses.is_empty() {
            builder
                .program
                .block(&Kernel::Contact(i), [q, v, &[], &[]], None, uses);
        }
        let slides = contact.friction.is_some_and(|friction| {
            let mut entries = friction.jacobian.entries.iter();
            entries.any(|&(row, column)| row == 0 && free.contains(&(column as usize)))
        });
        let (sign, upper) = match mode {
            ContactMode::Slip(direction) => (direction.sign(), f64::INFINITY),
            _ => (1.0, 0.0),
        };
        if slides && matches!(mode, ContactMode::Stick | ContactMode::Slip(_)) {
            let name = format!("sliding velocity of `{}` at the start", contact.name);
            let row = builder.program.row_in(units.gap_rows[i], name, 0.0, upper);
            let uses = vec![(row, 0, sign)];
            builder
                .program
                .block(&Kernel::Sliding(i), [q, v, &[], &[]], None, uses);
        }
    }
}

/// Share of the largest entry of a normal up to which another one says nothing: a velocity of 10 in its direction strikes no faster than
/// what counts as rest at the start.
const LEVEL: f64 = 1e-10;

/// Whether a contact begins along its surface whatever the initial values in `free` (indices of the state) are: they are velocities
/// along ground that is level but for rounding. The condition that the contact does would have them vanish.
fn is_level(builder: &Builder, contact: usize, free: &[usize]) -> bool {
    let Setting { model, problem, .. } = builder.setting;
    let n = builder.n;
    let jacobian = &model.declaration().contacts[contact].jacobian;
    let mut columns = jacobian.entries.iter().filter(|entry| entry.0 == 1);
    if columns.any(|&(_, column)| (column as usize) < n && free.contains(&(column as usize))) {
        return false;
    }
    let mut input = problem.start();
    input.resize(model.declaration().inputs(), 0.0);
    let mut point = vec![0.0; contact_point::length(n)];
    model.contact(contact, &input, &mut point);
    let normal = &point[contact_point::NORMAL..][..n];
    let largest = normal.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
    let mut velocities = free.iter().filter(|&&k| k >= n);
    velocities.all(|&k| normal[k - n].abs() <= LEVEL * largest)
}

/// Whether a contact that is closed at the start stays so (row 0: its gap; row 1: its normal velocity) whatever the parameters are that
/// decide the start: the condition that it does would say again what the start says.
fn follows_from_parameters(builder: &Builder, contact: usize, row: u32) -> bool {
    let Setting { model, problem, .. } = builder.setting;
    let (Some(held), Some(declared)) = (model.held(), model.declaration().optimal_control) else {
        return false;
    };
    let n = builder.n;
    let mut input = problem.start();
    input.resize(model.declaration().inputs(), 0.0);
    let pattern = model.declaration().contacts[contact].jacobian.entries;
    let mut slopes = vec![0.0; pattern.len()];
    model.jacobian(Function::Contact(contact), &input, &mut slopes);
    let own = pattern
        .iter()
        .zip(slopes)
        .filter(|(entry, _)| entry.0 == row);
    let own: Vec<(usize, f64)> = own
        .map(|(entry, slope)| (entry.1 as usize, slope))
        .collect();
    let mut moves = own.iter().filter(|(column, _)| !is_held(model, *column));
    if moves.any(|(column, _)| declared.free_start.contains(column)) {
        return false;
    }
    let mut given = vec![0.0; held.jacobian.entries.len()];
    model.jacobian(Function::Given, &input, &mut given);
    (moving(model)..n).all(|parameter| {
        let (mut total, mut size) = (0.0, 0.0_f64);
        let mut add = |term: f64| {
            total += term;
            size = size.max(term.abs());
        };
        for &(column, slope) in &own {
            if column == parameter {
                add(slope);
            }
            let entries = held.jacobian.entries.iter().zip(&given);
            for (&(of, by), value) in entries {
                let start = held.given[of as usize] == Given::Start(column);
                if start && by as usize == parameter {
                    add(slope * value);
                }
            }
        }
        total.abs() <= yardstick::NOTHING * size
    })
}

/// The path constraints on linear controls, on forces, and on what is free at the start, at the very start, which is no stage.
pub(in crate::ocp) fn path_rows(builder: &mut Builder, phase: &Phase) {
    let declaration = builder.setting.model.declaration();
    let Some(declared) = declaration.optimal_control else {
        return;
    };
    let linear = builder.setting.shape == ControlShape::Linear;
    let first = usize::from(declared.running_cost);
    let (from, u) = (2 * builder.n, builder.frame.controls[0].clone());
    let reads = |constraint: usize, read: &dyn Fn(usize) -> bool| {
        let mut entries = declared.path_jacobian.entries.iter();
        entries.any(|&(row, column)| row as usize == first + constraint && read(column as usize))
    };
    let controls = |column: usize| (from..from + u.len()).contains(&column);
    // The start may be where a condition is violated the most.
    let free = |column: usize| declared.free_start.contains(&column);
    let forces = provided::at_start(declaration);
    let chosen: Vec<usize> = (0..first_at_stages(builder.setting.model))
        .filter(|&i| {
            let inequality = !declared.constraints[i].equality;
            linear && reads(i, &controls) || forces(i) || inequality && reads(i, &free)
        })
        .collect();
    if chosen.is_empty() {
        return;
    }
    let provided = provided::within(builder, phase, 0.0, "at the start");
    let inputs = [&phase.start[..builder.n], &phase.start[builder.n..], &u[..]];
    let (program, known) = (&mut builder.program, Provided::Known(&provided));
    builder
        .frame
        .path_rows_of(program, &chosen, inputs, known, "at the start");
}
