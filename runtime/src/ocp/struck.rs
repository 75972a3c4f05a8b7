//! Problems whose motion begins with an impact: a contact is closed at the start, and the velocities there lead into it.
//!
//! The impact is decided by the start alone, as no force changes velocities in an instant. So the motion that is looked for begins after it, where that
//! can be known beforehand: with all velocities given, and nothing that counts impulses.

use super::problem::{Problem, has_free_start};
use super::solution::Solution;
use crate::model::Model;
use crate::simulation::{ControlSignal, EventDriven, EventKind, simulate_once};

/// Share of the horizon that is simulated to see the impacts of the start.
const MOMENT: f64 = 1e-9;

/// The problem that begins after the impact of its start, and what is to be said of that.
pub(in crate::ocp) struct Struck {
    pub(in crate::ocp) problem: Problem,
    notes: Vec<String>,
}

/// The problem after the impact of its start; `None` where nothing is struck there, or where it cannot be known beforehand what is.
pub(in crate::ocp) fn after_impact(model: &dyn Model, problem: &Problem) -> Option<Struck> {
    let declaration = model.declaration();
    let control = declaration.optimal_control;
    let counted = control.is_some_and(|control| {
        control.contacts.sums > 0 || !control.contacts.constraints.is_empty()
    });
    let smooth = declaration.contacts.iter().all(|contact| contact.dry);
    if smooth || counted || has_free_start(model) || model.held().is_some() {
        return None;
    }
    let moment = MOMENT * problem.length(model);
    let start = problem.initial_value_problem(&problem.start(), moment, ControlSignal::Zero);
    let run = simulate_once(&EventDriven::default(), model, &start).ok()?;
    let mut events = run.events.iter();
    let impact = events.rfind(|event| event.time == 0.0 && event.kind == EventKind::Impact)?;
    Some(Struck {
        problem: Problem {
            v: impact.v_after.clone(),
            ..problem.clone()
        },
        notes: run.notes,
    })
}

impl Struck {
    /// Says of a solution what was said of the start.
    pub(in crate::ocp) fn note(&self, mut solution: Solution) -> Solution {
        if let Some(motion) = &mut solution.motion {
            motion.notes.splice(0..0, self.notes.iter().cloned());
        }
        solution
    }
}
