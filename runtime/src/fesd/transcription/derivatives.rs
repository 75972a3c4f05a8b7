//! Jacobian and Hessian of the program, assembled from the local ones.

use hangtime_solver::nlp::Pattern;

use super::{
    EQUILIBRATION, SUMS, Transcription, conditions, corrections, joints, provided, ramps, start,
};
use crate::dcs;

pub(super) fn set_patterns(transcription: &mut Transcription<'_>) {
    let x = transcription.guess.clone();
    let multipliers = vec![1.0; transcription.constraints];
    let mut additions = Vec::new();
    add_jacobian(transcription, &x, &mut |row, column, _| {
        additions.push((row, column))
    });
    transcription.jacobian = Pattern::new(&additions);
    additions.clear();
    add_hessian(transcription, &x, 1.0, &multipliers, &mut |i, j, _| {
        additions.push((i.max(j), i.min(j)));
    });
    transcription.hessian = Pattern::new(&additions);
}

/// Entries (row, column, value) of the Jacobian, always in the same order.
pub(super) fn add_jacobian(
    transcription: &mut Transcription<'_>,
    x: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    let replaced = transcription.joints.take_replaced();
    for e in 0..transcription.elements.len() {
        add_element_jacobian(transcription, x, e, &mut replaced.others(add));
    }
    let time = transcription.dcs.layout.time();
    let count = transcription.intervals.len() as f64;
    for (k, interval) in transcription.intervals.iter().enumerate() {
        let end = transcription.end_state((k + 1) * transcription.task.elements - 1)[time];
        if let Some(clock) = end {
            add(interval.rows + 1, clock, 1.0);
        }
        if let Some(horizon) = transcription.horizon {
            add(interval.rows + 1, horizon, -(k as f64 + 1.0) / count);
        }
    }
    start::add_jacobian(transcription, x, add);
    corrections::add_jacobian(transcription, x, &mut replaced.others(add));
    transcription.joints.give_back(replaced);
    joints::add_jacobian(transcription, x, add);
    ramps::add_jacobian(transcription, x, add);
    conditions::add_jacobian(transcription, x, add);
    provided::add_jacobian(transcription, x, add);
}

fn add_element_jacobian(
    transcription: &mut Transcription<'_>,
    x: &[f64],
    e: usize,
    add: &mut dyn FnMut(usize, usize, f64),
) {
    let states = transcription.dcs.layout.states();
    let interval = &transcription.intervals[transcription.elements[e].interval];
    let (row, scale) = (interval.rows, interval.length);
    let length = transcription.elements[e].length;
    add(row, length, 1.0);
    let (h, s) = (x[length], x[scale]);
    let rows = transcription.elements[e].collocation_rows;
    let blocks = transcription.elements[e].blocks.len();
    for m in 0..blocks {
        for k in 0..states {
            let row = rows + m * states + k;
            if let Some(variable) = transcription.elements[e].blocks[m].variables[k] {
                add(row, variable, 1.0);
            }
            if let Some(variable) = transcription.start_variable(e, k) {
                add(row, variable, -1.0);
            }
        }
    }
    for j in 0..blocks {
        transcription.gather(x, e, j);
        let local = std::mem::take(&mut transcription.local);
        let mut values = std::mem::take(&mut transcription.rows);
        transcription.dcs.rows(&local, &mut values);
        if j < transcription.tableau.stages() {
            for m in 0..blocks {
                let weight = transcription.weight(m, j);
                for (k, value) in values[..states].iter().enumerate() {
                    let row = rows + m * states + k;
                    add(row, length, -s * weight * value);
                    add(row, scale, -h * weight * value);
                }
            }
        }
        let mut entries = Vec::new();
        dcs::jacobian(&mut transcription.dcs, &local, |row, column, value| {
            entries.push((row, column, value))
        });
        let block = &transcription.elements[e].blocks[j];
        for (row, column, value) in entries {
            let Some(variable) = block.variables[column] else {
                continue;
            };
            let value = transcription.unit(column) * value;
            if row >= states {
                if let Some(row) = transcription.algebraic_row(block, row - states) {
                    add(row, variable, value);
                }
            } else if !block.boundary {
                for m in 0..blocks {
                    let weight = transcription.weight(m, j);
                    add(rows + m * states + row, variable, -h * s * weight * value);
                }
            }
        }
        transcription.local = local;
        transcription.rows = values;
    }
    for group in 0..transcription.groups.len() {
        for sum in 0..SUMS {
            let row = transcription.elements[e].sum_rows + SUMS * group + sum;
            add(
                row,
                transcription.elements[e].sums + SUMS * group + sum,
                1.0,
            );
            for variable in transcription.sum_variables(e, group, sum) {
                add(row, variable, -1.0);
            }
        }
    }
}

/// Entries (one of (i, j) and (j, i) each) of the Hessian of the Lagrangian, always in the same order.
pub(super) fn add_hessian(
    transcription: &mut Transcription<'_>,
    x: &[f64],
    weight: f64,
    multipliers: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    let collocated = transcription.joints.without(multipliers);
    for e in 0..transcription.elements.len() {
        let length = transcription.elements[e].length;
        let nominal = 1.0 / transcription.task.elements as f64;
        add(
            length,
            length,
            2.0 * EQUILIBRATION * weight / (nominal * nominal),
        );
        add_element_hessian(transcription, x, e, &collocated, add);
    }
    start::add_hessian(transcription, x, multipliers, add);
    corrections::add_hessian(transcription, x, multipliers, add);
    joints::add_hessian(transcription, x, multipliers, add);
    ramps::add_hessian(transcription, multipliers, add);
    conditions::add_hessian(transcription, x, weight, multipliers, add);
    provided::add_hessian(transcription, x, multipliers, add);
}

fn add_element_hessian(
    transcription: &mut Transcription<'_>,
    x: &[f64],
    e: usize,
    multipliers: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    let states = transcription.dcs.layout.states();
    let scale = transcription.intervals[transcription.elements[e].interval].length;
    let length = transcription.elements[e].length;
    let (h, s) = (x[length], x[scale]);
    let rows = transcription.elements[e].collocation_rows;
    let blocks = transcription.elements[e].blocks.len();
    let mut local_weights = vec![0.0; states + transcription.dcs.layout.algebraic_equations()];
    for j in 0..blocks {
        transcription.gather(x, e, j);
        let local = std::mem::take(&mut transcription.local);
        let mut values = std::mem::take(&mut transcription.rows);
        transcription.dcs.rows(&local, &mut values);
        // sensitivity of the Lagrangian to F_j, without the factor h s
        let mut by_field = vec![0.0; states];
        if j < transcription.tableau.stages() {
            for m in 0..blocks {
                for (k, sensitivity) in by_field.iter_mut().enumerate() {
                    *sensitivity -= transcription.weight(m, j) * multipliers[rows + m * states + k];
                }
            }
            let product: f64 = by_field.iter().zip(&values).map(|(w, f)| w * f).sum();
            add(length, scale, product);
            let mut entries = Vec::new();
            dcs::jacobian(&mut transcription.dcs, &local, |row, column, value| {
                entries.push((row, column, value))
            });
            for (row, column, value) in entries {
                if row < states
                    && let Some(variable) = transcription.elements[e].blocks[j].variables[column]
                {
                    let value = transcription.unit(column) * by_field[row] * value;
                    add(length, variable, s * value);
                    add(scale, variable, h * value);
                }
            }
        }
        let block = &transcription.elements[e].blocks[j];
        for (k, value) in local_weights.iter_mut().enumerate() {
            *value = if k < states {
                h * s * by_field[k]
            } else {
                transcription
                    .algebraic_row(block, k - states)
                    .map_or(0.0, |row| multipliers[row])
            };
        }
        let variables = &block.variables;
        let mut entries = Vec::new();
        dcs::hessian(
            &mut transcription.dcs,
            &local,
            &local_weights,
            |i, j, value| {
                if let (Some(a), Some(b)) = (variables[i], variables[j]) {
                    entries.push((a, b, (i, j), value));
                }
            },
        );
        for (a, b, (i, j), value) in entries {
            add(a, b, transcription.unit(i) * transcription.unit(j) * value);
        }
        transcription.local = local;
        transcription.rows = values;
    }
}
