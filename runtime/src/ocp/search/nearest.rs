//! What a problem without a motion asks for too much: of simulated motions under random controls within their bounds the one that comes
//! nearest to the goals, changed at random to come nearer. It says nothing of what is possible at all, but names what is hard.

use super::sampled::{drawing_range, drawn};
use super::throw::{End, ends_of_changed};
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::global::guess::uniform;
use crate::ocp::misses::{Miss, Nearest};
use crate::ocp::tuning::equal::MET;
use crate::ocp::tuning::sampled::{CHANGED, CHANGES, DRAWN};
use crate::simulation::InputError;

/// The simulated motion that comes nearest to the goals; `None` where no simulation ends.
pub(in crate::ocp) fn nearest(setting: Setting) -> Result<Option<Nearest>, InputError> {
    let archive = drawn((setting, &drawing_range(setting)?), 0..DRAWN, usize::MAX)?;
    let distance = |end: &End| archive.rank(end).2;
    let nearer = |a: &End, b: &End| distance(a) < distance(b);
    let found = archive.ends().cloned();
    let Some(mut best) = found.reduce(|a, b| if nearer(&b, &a) { b } else { a }) else {
        return Ok(None);
    };
    let mut random = uniform(DRAWN);
    for k in 0..CHANGED {
        let share = CHANGES[k % CHANGES.len()];
        let child = archive.changed(setting, best.throw.clone(), share, &mut random);
        for end in ends_of_changed(setting, &child, usize::MAX) {
            if nearer(&end, &best) {
                best = end;
            }
        }
    }
    Ok(Some(Nearest {
        motions: DRAWN as usize + CHANGED,
        misses: misses(setting, &archive.units, &best.missing),
        impacts: best.impacts,
    }))
}

/// What is missing, the most in its unit first: goals, bounds of coordinates, path constraints.
fn misses(setting: Setting, units: &[f64], missing: &[f64]) -> Vec<Miss> {
    let declaration = setting.model.declaration();
    let Some(declared) = declaration.optimal_control else {
        return Vec::new();
    };
    let goals = declared.goals.iter().map(|goal| (goal.name, goal.unit));
    let coordinates = declaration.coordinates.iter();
    let bounds = coordinates.map(|coordinate| (coordinate.name, coordinate.unit));
    let constraints = declared.constraints.iter().map(|c| (c.name, c.unit));
    let names = goals.chain(bounds).chain(constraints);
    let mut found: Vec<(f64, Miss)> = names
        .zip(missing.iter().zip(units))
        .filter(|(_, (value, unit))| value.abs() > MET * **unit)
        .map(|((name, unit_name), (value, unit))| {
            let miss = Miss {
                name: name.to_owned(),
                amount: value.abs(),
                unit: unit_name.to_owned(),
            };
            (value.abs() / unit, miss)
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.into_iter().map(|(_, miss)| miss).collect()
}
