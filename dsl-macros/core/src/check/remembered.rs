//! `start(...)` in what is judged of a motion: which components of the start are to be found and remembered, and which are given.

use super::checker::Checker;
use crate::diagnostics::Place;
use crate::graph::{self, Sym, Variable};
use crate::scene::{Condition, OptimalControl};

/// Puts the given start `(q, v)` in the place of those of its components that are not free, which is said; the others are
/// indices into `(q, v)`, increasing.
pub(super) fn starts(
    checker: &mut Checker<'_>,
    task: Option<&mut OptimalControl>,
    start: &(Vec<Sym>, Vec<Sym>),
) -> Vec<usize> {
    let read = std::mem::take(&mut checker.scope.starts);
    // What has no text is read by the language itself.
    let said_to_read = |known: &&(u16, String, Place)| !known.1.is_empty();
    let Some(task) = task.filter(|_| !read.is_empty()) else {
        return Vec::new();
    };
    let n = start.0.len();
    let free: Vec<usize> = task.free_start.iter().map(|free| free.0).collect();
    let given = |k: u16| {
        let k = usize::from(k);
        (!free.contains(&k)).then(|| if k < n { start.0[k] } else { start.1[k - n] })
    };
    let replace = |value: Sym| {
        graph::substitute(&[value], |variable| match variable {
            Variable::Start(k) => given(k),
            _ => None,
        })[0]
    };
    task.map_functions(replace);
    let mut said = false;
    for (k, shown, place) in &read {
        if given(*k).is_some() && !said && !shown.is_empty() {
            said = true;
            let name = checker.component(usize::from(*k));
            let message = format!(
                "`{shown}` is the value that `start` gives, as `{name}` is not free there; write `free {{ {name} }}` if it is \
                 to be found, or the value itself"
            );
            checker.diagnostics.warn("E15", *place, message);
        }
    }
    let same = |condition: &&Condition| {
        !graph::depends_on(condition.function, Variable::moves)
            && checker.free_parameter_in(condition.function).is_none()
    };
    let mut conditions = task.constraints.iter().chain(&task.goals);
    if let Some(condition) = conditions.find(same)
        && let Some((_, _, place)) = read.iter().find(said_to_read)
    {
        let message = format!(
            "`{}` is the same for every motion, as nothing in it is free at the start; list what is to be found in `free {{ ... \
             }}`",
            condition.name
        );
        checker.diagnostics.report("E15", *place, message);
    }
    let mut remembered: Vec<usize> = read.into_iter().map(|(k, ..)| usize::from(k)).collect();
    remembered.retain(|k| free.contains(k));
    remembered.sort_unstable();
    remembered.dedup();
    remembered
}
