//! Parameters that optimal control is to find, `free name: unit in lower..=upper = value`.

use super::checker::Checker;
use super::values::{self, DECLARED, Target};
use crate::ast::Quantity;
use crate::diagnostics::{Checked, Diagnostics};
use crate::graph::{self, Sym, Variable};
use crate::scene::{CheckedScene, Contact, OptimalControl};

/// E17: the ranges of free parameters, which hold the values that these begin with.
pub(super) fn bounds(checker: &mut Checker<'_>, quantities: &[Quantity]) -> Checked<()> {
    let before = checker.diagnostics.mistakes();
    for quantity in quantities.iter().filter(|quantity| quantity.free) {
        let name = &quantity.name;
        let index = checker
            .parameters
            .iter()
            .position(|known| known.name.text == name.text);
        let (Some(index), Some(range)) = (index, &quantity.bounds) else {
            continue;
        };
        let of = Target::declared(name, quantity.unit.as_ref());
        let Ok(range) = values::range(checker, range, &of, DECLARED) else {
            continue;
        };
        let default = checker.parameters[index].default;
        if !default.is_nan() {
            checker.within(Sym::number(default), range, name.place(), &name.text);
        }
        for free in &mut checker.free_parameters {
            if usize::from(free.index) == index {
                free.bounds = range;
            }
        }
    }
    checker.diagnostics.none_since(before)
}

/// Free parameters belong to a scene with an objective (`judged`), and something that it judges reads each of them.
pub(super) fn finish(
    checker: &mut Checker<'_>,
    (dynamics, judged): (&[Sym], bool),
    contacts: &[Contact],
    task: Option<&OptimalControl>,
) {
    if checker.free_parameters.is_empty() {
        return;
    }
    let mut functions = dynamics.to_vec();
    for contact in contacts {
        functions.extend(contact.restitution);
        functions.extend(contact.friction.iter().map(|known| known.coefficient));
        functions.extend(contact.friction.iter().filter_map(|known| known.kinetic));
    }
    functions.extend(checker.horizon);
    if let Some(mut task) = task.cloned() {
        functions.extend(task.functions_mut().map(|function| *function));
    }
    let read = graph::variables(&functions);
    for free in &checker.free_parameters {
        let name = &checker.parameters[usize::from(free.index)].name;
        let message = if !judged {
            format!(
                "free parameter `{0}` in a scene without `minimize`, so that nothing says which value is best; add an \
                 objective, or write `parameters {{ {0} = ... }}`",
                name.text
            )
        } else if !read.contains(&Variable::Parameter(free.index)) {
            format!(
                "nothing in the motion, its conditions or its objective reads the free parameter `{}`, so that all its \
                 values are as good; use it or leave it out",
                name.text
            )
        } else {
            continue;
        };
        checker.diagnostics.report("E15", name.place(), message);
    }
}

/// Reports what of a scene depends on parameters that are to become coordinates without motion, but has to be the same for
/// all of their values: bounds.
pub(crate) fn without_free_bounds(
    scene: &CheckedScene,
    chosen: &[u16],
    diagnostics: &mut Diagnostics,
) -> Checked<()> {
    let quantities = scene.coordinates.iter().chain(&scene.controls);
    let mut declared: Vec<(&str, (Sym, Sym))> = quantities
        .filter_map(|known| Some((known.name.text.as_str(), known.bounds?)))
        .collect();
    let n = scene.coordinates.len();
    let free_start = scene
        .optimal_control
        .iter()
        .flat_map(|task| &task.free_start);
    declared.extend(free_start.filter_map(|&(index, bounds)| {
        Some((scene.coordinates[index % n].name.text.as_str(), bounds?))
    }));
    for (of, (lower, upper)) in declared {
        let read = graph::variables(&[lower, upper]);
        let mut chosen = chosen.iter();
        if let Some(&index) = chosen.find(|&&index| read.contains(&Variable::Parameter(index))) {
            let name = &scene.parameters[usize::from(index)].name;
            return Err(diagnostics.syntax(
                name.place(),
                format!(
                    "a bound of `{of}` depends on `{0}`, so that nothing is differentiated by `{0}`; write the bound \
                     as a condition, such as `constraint limit: {of} <= {0}`",
                    name.text
                ),
            ));
        }
    }
    Ok(())
}
