//! What the variables and rows of a transcription are there for.

use hangtime_solver::mpcc::Mpcc as _;

use super::{SUMS, Transcription, corrections, joints, provided, ramps, start};
use crate::size::{Purpose, SizeGroup, groups_of};

/// Numbers of contacts, and of those with friction.
fn counts(transcription: &Transcription<'_>) -> (usize, usize) {
    let layout = &transcription.dcs.layout;
    (layout.contacts(), layout.frictions())
}

/// What the state `k` is there for.
fn of_state(transcription: &Transcription<'_>, k: usize) -> Purpose {
    let time = transcription.dcs.layout.time();
    match k {
        k if k < time => Purpose::State,
        k if k == time => Purpose::Clock,
        k if transcription.dcs.layout.dip_of(k).is_some() => Purpose::Restitution,
        _ => Purpose::Gap,
    }
}

/// What the local variable `k` is there for.
fn of_local(transcription: &Transcription<'_>, k: usize) -> Purpose {
    let layout = &transcription.dcs.layout;
    if k < layout.states() {
        return of_state(transcription, k);
    }
    if k < layout.states() + layout.controls() {
        return Purpose::Control;
    }
    match layout.algebraic_symbol(k) {
        Some(("alpha" | "beta" | "lp" | "ln" | "p" | "w", _)) => Purpose::StepFunction,
        Some(("f" | "r", _)) => Purpose::Restitution,
        Some(("ahead" | "behind", _)) => Purpose::Edge,
        Some(_) => Purpose::Friction,
        None => Purpose::SeveralContacts,
    }
}

/// What the sum `sum`, counted over all groups, is there for.
fn of_sum(transcription: &Transcription<'_>, sum: usize) -> Purpose {
    let (contacts, rough) = counts(transcription);
    match sum / SUMS {
        group if group < contacts => Purpose::CrossComplementarity,
        group if group < contacts + rough => Purpose::Friction,
        _ => Purpose::Restitution,
    }
}

fn of_variable(transcription: &Transcription<'_>, index: usize) -> Purpose {
    if transcription.horizon == Some(index) {
        return Purpose::FinalTime;
    }
    if start::local_of(transcription, index).is_some() {
        return Purpose::FreeStart;
    }
    if provided::owns(transcription, |own| own.0 == index) {
        return Purpose::ForceTerm;
    }
    let intervals = &transcription.intervals;
    let k = intervals.partition_point(|interval| interval.length <= index);
    let interval = &intervals[k.saturating_sub(1)];
    if interval.length == index {
        return Purpose::Clock;
    }
    if interval.controls.contains(&index) || interval.ends.contains(&index) {
        return Purpose::Control;
    }
    let elements = &transcription.elements;
    let e = elements.partition_point(|element| element.first <= index);
    let element = &elements[e.saturating_sub(1)];
    if element.length == index {
        return Purpose::ElementLength;
    }
    if let Some(sum) = index.checked_sub(element.sums) {
        return of_sum(transcription, sum);
    }
    if corrections::corrected_by(element, index).is_some() {
        return Purpose::Gap;
    }
    let mut blocks = element.blocks.iter();
    let local = blocks.find_map(|block| block.variables.iter().position(|v| *v == Some(index)));
    local.map_or(Purpose::Other, |k| of_local(transcription, k))
}

fn of_row(transcription: &Transcription<'_>, index: usize) -> Purpose {
    if provided::owns(transcription, |own| own.1 == index) {
        return Purpose::ForceTerm;
    }
    if joints::named(transcription, index).is_some() {
        return Purpose::Joint;
    }
    match index.checked_sub(transcription.goal_rows) {
        Some(goal) if goal < transcription.goals().len() => return Purpose::Goal,
        Some(_) => return Purpose::PathConstraint,
        None => {}
    }
    if start::owns_row(transcription, index) {
        return Purpose::FreeStart;
    }
    let (once, _) = transcription.path_rows();
    let intervals = &transcription.intervals;
    let k = intervals.partition_point(|interval| interval.rows <= index);
    match index - intervals[k.saturating_sub(1)].rows {
        0 => return Purpose::ElementLength,
        1 => return Purpose::Clock,
        row if row < 2 + once => return Purpose::PathConstraint,
        _ => {}
    }
    let elements = &transcription.elements;
    let e = elements.partition_point(|element| element.collocation_rows <= index);
    let element = &elements[e.saturating_sub(1)];
    if index >= element.path_rows {
        return Purpose::PathConstraint;
    }
    if let Some(sum) = index.checked_sub(element.sum_rows) {
        return of_sum(transcription, sum);
    }
    if corrections::owns_row(element, index) {
        return Purpose::Gap;
    }
    if ramps::control_of_row(transcription, index).is_some() {
        return Purpose::Control;
    }
    let blocks = &element.blocks;
    let b = blocks.partition_point(|block| block.algebraic_rows <= index);
    let Some(block) = b.checked_sub(1).map(|b| &blocks[b]) else {
        let states = transcription.dcs.layout.states();
        return of_state(transcription, (index - element.collocation_rows) % states);
    };
    // Of a contact three rows at a stage, two at an end; of friction two and one; of a bounce one at a stage; of a pair of
    // pieces one everywhere.
    let (contacts, rough) = counts(transcription);
    let (of_contact, of_friction) = if block.boundary { (2, 1) } else { (3, 2) };
    let row = index - block.algebraic_rows;
    let before_bounces = of_contact * contacts + of_friction * rough;
    let elastic = if block.boundary {
        0
    } else {
        transcription.groups.len() - contacts - rough
    };
    let before_edges = before_bounces + elastic;
    match row {
        row if row < of_contact * contacts => Purpose::StepFunction,
        row if row < before_bounces => Purpose::Friction,
        row if row < before_edges => Purpose::Restitution,
        row if row < before_edges + transcription.dcs.layout.edges() => Purpose::Edge,
        _ => Purpose::SeveralContacts,
    }
}

/// The groups of a transcription.
pub(crate) fn size_groups(transcription: &Transcription<'_>) -> Vec<SizeGroup> {
    groups_of(
        transcription,
        transcription.complementarities(),
        &|index| of_variable(transcription, index),
        &|index| of_row(transcription, index),
    )
}
