//! The start of the motion where some of its values are free: unknown states, with the switching functions that the first
//! element continues.
//!
//! ```text
//! G_i = g_i(q), >= 0       where coordinates are free: the lifted gap begins as the gap is
//! ```
//!
//! Of the pieces of an edge only the gap of that one is kept which acts at the guess.

use super::{Beginning, Transcription};
use crate::dcs;

/// Whether a row belongs to the start.
pub(super) fn owns_row(transcription: &Transcription<'_>, row: usize) -> bool {
    let beginning = transcription.beginning.as_ref();
    beginning.is_some_and(|b| (b.block.algebraic_rows..b.end).contains(&row))
}

/// Place in the local vector of a variable of the start.
pub(super) fn local_of(transcription: &Transcription<'_>, variable: usize) -> Option<usize> {
    let mut variables = transcription.beginning.as_ref()?.block.variables.iter();
    variables.position(|own| *own == Some(variable))
}

/// Writes the bounds of its variables.
pub(super) fn write_bounds(
    transcription: &Transcription<'_>,
    lower: &mut [f64],
    upper: &mut [f64],
) {
    let Some(beginning) = &transcription.beginning else {
        return;
    };
    let layout = &transcription.dcs.layout;
    let gaps = layout.lifted_gaps();
    for (place, variable) in beginning.block.variables.iter().enumerate() {
        // Lifted gaps, and the parts of switching functions. Of an edge the piece that acts where the guess starts.
        let idle = gaps.contains(&place) && is_idle(transcription, place - gaps.start);
        if let Some(variable) = variable.filter(|_| !idle) {
            lower[variable] = 0.0;
        }
    }
    for &(k, range) in &transcription.task.free_start {
        if let Some(variable) = beginning.block.variables[k] {
            (lower[variable], upper[variable]) = range;
        }
    }
}

/// Whether another piece of its edge acts in place of a contact where the guess starts.
fn is_idle(transcription: &Transcription<'_>, contact: usize) -> bool {
    let gap = |i: usize| transcription.start[transcription.dcs.layout.lifted_gap(i)];
    let declared = &transcription.dcs.system.model.declaration().contacts[contact];
    let mut others = declared.alternatives.iter();
    others.any(|&other| gap(other) > gap(contact) || gap(other) == gap(contact) && other < contact)
}

/// Evaluates the local vector and the local rows at the start.
fn evaluate(transcription: &mut Transcription<'_>, x: &[f64], beginning: &Beginning) {
    transcription.gather_from(x, 0, &beginning.block.variables);
    transcription
        .dcs
        .rows(&transcription.local, &mut transcription.rows);
}

/// Contacts whose gap at the start is an unknown, with rows and lifted gaps.
fn gaps(
    transcription: &Transcription<'_>,
    beginning: &Beginning,
) -> impl Iterator<Item = (usize, usize, Option<usize>)> + use<> {
    let first = transcription.dcs.layout.lifted_gap(0);
    let gaps = beginning.block.variables[first..].to_vec();
    let rows = beginning.gap_rows..beginning.end;
    rows.zip(gaps)
        .enumerate()
        .map(|(contact, (row, gap))| (contact, row, gap))
}

/// Writes the values of its rows.
pub(super) fn write_rows(transcription: &mut Transcription<'_>, x: &[f64], c: &mut [f64]) {
    let Some(beginning) = transcription.beginning.take() else {
        return;
    };
    evaluate(transcription, x, &beginning);
    let states = transcription.dcs.layout.states();
    for (k, value) in transcription.rows[states..].iter().enumerate() {
        if let Some(row) = transcription.algebraic_row(&beginning.block, k) {
            c[row] = *value;
        }
    }
    for (contact, row, gap) in gaps(transcription, &beginning) {
        let lifted = gap.map_or(0.0, |gap| x[gap]);
        c[row] = lifted - transcription.dcs.system.gap(contact);
    }
    transcription.beginning = Some(beginning);
}

/// Entries of the Jacobian of its rows, always in the same order.
pub(super) fn add_jacobian(
    transcription: &mut Transcription<'_>,
    x: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    let Some(beginning) = transcription.beginning.take() else {
        return;
    };
    evaluate(transcription, x, &beginning);
    let local = std::mem::take(&mut transcription.local);
    let states = transcription.dcs.layout.states();
    let mut entries = Vec::new();
    dcs::jacobian(&mut transcription.dcs, &local, |row, column, value| {
        entries.push((row, column, value));
    });
    let variables = &beginning.block.variables;
    for (row, column, value) in entries {
        let Some(row) = row.checked_sub(states) else {
            continue;
        };
        let row = transcription.algebraic_row(&beginning.block, row);
        if let (Some(row), Some(variable)) = (row, variables[column]) {
            add(row, variable, value);
        }
    }
    for (contact, row, gap) in gaps(transcription, &beginning) {
        if let Some(gap) = gap {
            add(row, gap, 1.0);
        }
        dcs::gap_gradient(&mut transcription.dcs, contact, |place, value| {
            if let Some(variable) = variables[place] {
                add(row, variable, -value);
            }
        });
    }
    transcription.local = local;
    transcription.beginning = Some(beginning);
}

/// Entries of the Hessian of its weighted rows, always in the same order.
pub(super) fn add_hessian(
    transcription: &mut Transcription<'_>,
    x: &[f64],
    multipliers: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    let Some(beginning) = transcription.beginning.take() else {
        return;
    };
    evaluate(transcription, x, &beginning);
    let local = std::mem::take(&mut transcription.local);
    let layout = transcription.dcs.layout.clone();
    let mut weights = vec![0.0; layout.states() + layout.algebraic_equations()];
    for (k, weight) in weights[layout.states()..].iter_mut().enumerate() {
        let row = transcription.algebraic_row(&beginning.block, k);
        *weight = row.map_or(0.0, |row| multipliers[row]);
    }
    let variables = &beginning.block.variables;
    dcs::hessian(&mut transcription.dcs, &local, &weights, |i, j, value| {
        if let (Some(a), Some(b)) = (variables[i], variables[j]) {
            add(a, b, value);
        }
    });
    for (contact, row, _) in gaps(transcription, &beginning) {
        let weight = -multipliers[row];
        dcs::gap_hessian(&mut transcription.dcs, contact, weight, |i, j, value| {
            if let (Some(a), Some(b)) = (variables[i], variables[j]) {
                add(a, b, value);
            }
        });
    }
    transcription.local = local;
    transcription.beginning = Some(beginning);
}
