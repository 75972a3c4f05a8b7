//! Sequences of modes next to that of a solution.

use super::modes::{self, Mode};
use super::transcription::{SUMS, Transcription};
use crate::model::held::first_of_stages;

/// Size up to which sums count as zero at an exact point: crossovers satisfy rows of up to ten terms to 1e-9.
const SOLVED: f64 = 1e-7;

/// Choice number `index` of modes next to the one of the solution `x`: of two elements side by side in
/// different modes one takes the mode of the other, which moves a switch by one element. Writes the sides
/// that vanish and a point to start from; `false` if there is no such choice, or if there is friction,
/// restitution or an edge, whose modes are not ordered like this.
pub(super) fn shift_switch(
    transcription: &Transcription<'_>,
    index: usize,
    x: &mut [f64],
    vanishes: &mut [bool],
) -> bool {
    let contacts = transcription.field.layout.contacts();
    if transcription.groups.len() > contacts || transcription.field.layout.edges() > 0 {
        return false;
    }
    let mut modes = modes::fixed_modes(transcription, vanishes);
    let of = |e: usize| e * contacts..(e + 1) * contacts;
    let switches = (1..transcription.elements.len()).filter(|&e| modes[of(e - 1)] != modes[of(e)]);
    let Some(switch) = switches.clone().nth(index / 2) else {
        return false;
    };
    let (changed, source) = if index.is_multiple_of(2) {
        (switch - 1, switch)
    } else {
        (switch, switch - 1)
    };
    let count = transcription.task.elements;
    let first = changed - changed % count;
    // ends of the phases of the interval, counted from its first element
    let ends: Vec<usize> = (1..=count)
        .filter(|&k| k == count || modes[of(first + k)] != modes[of(first + k - 1)])
        .collect();
    let phase = ends.iter().position(|&end| first + end > changed);
    let alone = phase.is_none_or(|k| ends[k] - k.checked_sub(1).map_or(0, |k| ends[k]) == 1);
    let solution = x.to_vec();
    if source / count == changed / count && !alone {
        let moved = ends.iter().map(|&end| match first + end {
            end if end != switch => end - first,
            end if changed < source => end - first - 1,
            end => end - first + 1,
        });
        redistribute(
            transcription,
            &solution,
            first,
            (&ends, &moved.collect::<Vec<_>>()),
            x,
        );
    } else {
        // contact after flight still needs the first stage to stop
        let jumped = modes[of(changed)].contains(&Mode::Jump);
        copy_algebraics(
            transcription,
            &solution,
            (source, changed),
            usize::from(jumped),
            x,
        );
    }
    set_controls(transcription, x);
    set_sums(transcription, x);
    modes.copy_within(of(source), changed * contacts);
    vanishes.fill(false);
    modes::mark_modes(transcription, x, SOLVED, &modes, vanishes);
    true
}

/// Gives an element the algebraic variables of another one, stage by stage from stage `first` on.
fn copy_algebraics(
    transcription: &Transcription<'_>,
    from: &[f64],
    (source, target): (usize, usize),
    first: usize,
    to: &mut [f64],
) {
    let blocks = transcription.elements[target].blocks.iter();
    let blocks = blocks
        .zip(&transcription.elements[source].blocks)
        .skip(first);
    for (target, source) in blocks {
        for k in transcription.field.layout.states() + transcription.field.layout.controls()
            ..target.variables.len()
        {
            if let (Some(variable), Some(source)) = (target.variables[k], source.variables[k]) {
                to[variable] = from[source];
            }
        }
    }
}

/// Gives the controls of all blocks the values that nodes and clocks ask for.
fn set_controls(transcription: &Transcription<'_>, x: &mut [f64]) {
    let layout = &transcription.field.layout;
    let duration = transcription.horizon(x) / transcription.task.intervals as f64;
    let first = first_of_stages(transcription.field.model);
    for element in &transcription.elements {
        let interval = &transcription.intervals[element.interval];
        for block in &element.blocks {
            let Some(clock) = block.variables[layout.time()] else {
                continue;
            };
            let elapsed = x[clock] - transcription.task.time;
            let share = elapsed / duration - element.interval as f64;
            let nodes = interval.controls.iter().zip(&interval.ends).enumerate();
            for (i, (&before, &after)) in nodes.take(first) {
                if let Some(control) = block.variables[layout.states() + i] {
                    x[control] = x[before] + share * (x[after] - x[before]);
                }
            }
        }
    }
}

/// Computes the cross complementarity sums.
fn set_sums(transcription: &Transcription<'_>, x: &mut [f64]) {
    for e in 0..transcription.elements.len() {
        for contact in 0..transcription.field.layout.contacts() {
            for sum in 0..SUMS {
                x[transcription.elements[e].sums + SUMS * contact + sum] =
                    transcription.sum(x, e, contact, sum);
            }
        }
    }
}

/// Writes to `to` the motion `from` in the interval whose elements begin with `first`, with phases that end
/// at other elements: equal lengths within a phase, states interpolated, algebraic variables those of the
/// nearest stage in the same phase.
fn redistribute(
    transcription: &Transcription<'_>,
    from: &[f64],
    first: usize,
    (ends, moved): (&[usize], &[usize]),
    to: &mut [f64],
) {
    let (mut old_start, mut new_start) = (first, first);
    for (&old_end, &new_end) in ends.iter().zip(moved) {
        let old = old_start..first + old_end;
        let new = new_start..first + new_end;
        let total: f64 = old
            .clone()
            .map(|e| from[transcription.elements[e].length])
            .sum();
        let width = total / new.len() as f64;
        for (k, e) in new.clone().enumerate() {
            to[transcription.elements[e].length] = width;
            for b in 0..transcription.elements[e].blocks.len() {
                let share = (k as f64 + abscissa(transcription, b)) * width;
                copy_block(transcription, from, &old, share, (e, b), to);
            }
        }
        (old_start, new_start) = (old.end, new.end);
    }
}

/// Place of block `b` in its element, from 0 to 1.
fn abscissa(transcription: &Transcription<'_>, b: usize) -> f64 {
    transcription.tableau.c().get(b).copied().unwrap_or(1.0)
}

/// Writes the point at `share` of the phase of elements `old` to block `target`.
fn copy_block(
    transcription: &Transcription<'_>,
    from: &[f64],
    old: &std::ops::Range<usize>,
    share: f64,
    (e, b): (usize, usize),
    to: &mut [f64],
) {
    let mut start = 0.0;
    let mut source = old.start;
    for candidate in old.clone() {
        source = candidate;
        let length = from[transcription.elements[candidate].length];
        if share <= start + length || candidate + 1 == old.end {
            break;
        }
        start += length;
    }
    let length = from[transcription.elements[source].length].max(f64::MIN_POSITIVE);
    let place = ((share - start) / length).clamp(0.0, 1.0);
    let states = transcription.field.layout.states();
    let blocks = &transcription.elements[source].blocks;
    let after = (0..blocks.len())
        .find(|&j| abscissa(transcription, j) >= place)
        .unwrap_or(blocks.len() - 1);
    let begin = if after == 0 {
        0.0
    } else {
        abscissa(transcription, after - 1)
    };
    let end = abscissa(transcription, after);
    let fraction = if end > begin {
        ((place - begin) / (end - begin)).min(1.0)
    } else {
        1.0
    };
    let target = &transcription.elements[e].blocks[b];
    let value = |j: usize, k: usize| blocks[j].variables[k].map_or(0.0, |v| from[v]);
    for k in 0..states {
        let before = match after {
            0 => transcription.block_before(source).variables[k].map_or(0.0, |v| from[v]),
            _ => value(after - 1, k),
        };
        if let Some(variable) = target.variables[k] {
            to[variable] = before + fraction * (value(after, k) - before);
        }
    }
    let distance = |j: &usize| (abscissa(transcription, *j) - place).abs();
    let nearest = (0..blocks.len())
        .filter(|&j| blocks[j].boundary == target.boundary)
        .min_by(|i, j| distance(i).total_cmp(&distance(j)))
        .unwrap_or(0);
    for k in states + transcription.field.layout.controls()..target.variables.len() {
        if let (Some(variable), Some(source)) = (target.variables[k], blocks[nearest].variables[k])
        {
            to[variable] = from[source];
        }
    }
}
