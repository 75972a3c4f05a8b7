//! E05: a coordinate that is meant as a number to be chosen, and moves.
//!
//! A number that is chosen once and for all is stated as a coordinate that begins anywhere, at rest, with an inertia that
//! stands for nothing. That is right where nothing acts on it. Where something does, it moves away from what was chosen.

use super::checker::Checker;
use crate::graph::{self, Sym, Variable};

/// Warns of each coordinate whose begin is free, that starts at rest, on which no control acts, whose kinetic energy
/// contains a parameter of default 1 that occurs nowhere else in the dynamics, and on which the Lagrangian or a force acts
/// all the same. All of it together says that it is meant to stay: an inertia of a body is the rest of a motion's data,
/// seldom 1 and most often also in its weight.
pub(super) fn coordinates(lagrangian: Sym, checker: &mut Checker<'_>) {
    if checker.task.cost.is_none() {
        return;
    }
    let n = checker.coordinates.len();
    let mut found = Vec::new();
    for free in checker.task.free.iter().filter(|free| free.index < n) {
        let i = free.index;
        let name = &checker.coordinates[i].name;
        let mut given = checker.start.iter();
        let starts = given.any(|start| start.velocity && start.target.text == name.text);
        let velocity = n + checker.states.len() + i;
        let released = checker.task.free.iter().any(|free| free.index == velocity);
        if starts || released {
            continue;
        }
        let forces = checker.forces.iter().filter(|(index, _)| *index == i);
        let forces: Vec<Sym> = forces.map(|&(_, force)| force).collect();
        let steered = graph::variables(&forces)
            .into_iter()
            .any(|known| matches!(known, Variable::Control(_)));
        let acts = graph::gradient(lagrangian, &[Variable::Coordinate(i as u16)]);
        let moves = !acts[0].is_structural_zero() || !forces.is_empty();
        if moves
            && !steered
            && let Some(inertia) = stand_in(lagrangian, i, checker)
        {
            found.push((free.place, name.text.clone(), inertia));
        }
    }
    for (place, name, inertia) in found {
        let message = format!(
            "`{name}` begins at rest anywhere, and `{inertia}` is nothing but its inertia: if it is a number that is chosen, \
             it does not stay, as the `lagrangian` or a force moves it; declare a parameter that is found in the place of the \
             coordinate, as in `free {name}: rad in 0.1..=1.2 = 0.5` with its own unit and range"
        );
        checker.diagnostics.warn("E05", place, message);
    }
}

/// The parameter of default 1 that occurs in the dynamics as an inertia of coordinate `i` alone.
fn stand_in(lagrangian: Sym, i: usize, checker: &Checker<'_>) -> Option<String> {
    let own = Variable::Velocity(i as u16);
    let others: Vec<Sym> = checker
        .forces
        .iter()
        .map(|&(_, force)| force)
        .chain(checker.surfaces.iter().map(|surface| surface.gap))
        .chain(checker.dissipation)
        .collect();
    let used = graph::variables(&others);
    checker
        .parameters
        .iter()
        .enumerate()
        .find_map(|(k, parameter)| {
            let variable = Variable::Parameter(k as u16);
            if parameter.default != 1.0 || used.contains(&variable) {
                return None;
            }
            let factor = graph::gradient(lagrangian, &[variable])[0];
            let moving: Vec<Variable> = graph::variables(&[factor])
                .into_iter()
                .filter(|known| {
                    known.is_velocity() || matches!(known, Variable::Coordinate(_) | Variable::Time)
                })
                .collect();
            (moving == [own]).then(|| parameter.name.text.clone())
        })
}
