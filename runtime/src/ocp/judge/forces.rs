//! Conditions on forces and impulses, in the re-simulation of a plan.
//!
//! The plan keeps them at its stages, and the forces there are less accurate than the motion. So they are looked at once more
//! with the forces and impulses of the event-driven simulation.

use crate::model::{ConstraintDeclaration, Model, contact_point};
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::model_input::drive;
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::simulation::Simulation;

/// Violation relative to the size of the condition up to which plan and re-simulation agree.
const AGREES: f64 = 1e-4;

/// A condition, what it came to, and its size: its largest value, with and without what contacts do.
struct Looked {
    declared: ConstraintDeclaration,
    violation: f64,
    time: f64,
    size: f64,
}

impl Looked {
    fn at(&mut self, time: f64, value: f64, without: f64) {
        let violation = match self.declared.equality {
            true => value.abs(),
            false => -value,
        };
        if violation > self.violation {
            (self.violation, self.time) = (violation, time);
        }
        self.size = self.size.max(value.abs()).max(without.abs());
    }
}

/// The first condition on forces or impulses that the re-simulation violates, in words.
pub(super) fn violated(setting: Setting, plan: &Sequence, replay: &Simulation) -> Option<String> {
    let Setting { model, problem, .. } = setting;
    let declared = model.declaration().optimal_control?;
    if !declared.contacts.any() {
        return None;
    }
    let (mut sums, impacts) = in_impacts(model, replay);
    let conditions = along(model, replay).into_iter().chain(impacts);
    let mut all: Vec<Looked> = conditions.collect();
    // An impact at the end is one of the plan; the simulation ends right before or right after it.
    let impact = |switch: &Switch| switch.interval == problem.intervals;
    if !plan.switches.iter().any(impact) {
        all.extend(at_the_end(model, replay, &mut sums));
    }
    let worse = |looked: &&Looked| looked.violation > AGREES * looked.size;
    all.iter().find(worse).map(|looked| {
        format!(
            "`{}` is violated by {:.1e} {} at {:.6} s of the re-simulation",
            looked.declared.name, looked.violation, looked.declared.unit, looked.time
        )
    })
}

/// Those of some conditions whose functions, from `first` on, read what stands from `inputs` on.
fn chosen(
    conditions: &[ConstraintDeclaration],
    reads: impl Fn(usize) -> bool,
) -> Vec<(usize, Looked)> {
    let conditions = conditions.iter().enumerate();
    conditions
        .filter(|(i, _)| reads(*i))
        .map(|(i, &declared)| {
            let looked = Looked {
                declared,
                violation: 0.0,
                time: 0.0,
                size: 0.0,
            };
            (i, looked)
        })
        .collect()
}

/// The input vector of the model at an instant.
fn input(model: &dyn Model, replay: &Simulation, k: usize) -> Vec<f64> {
    let motion = &replay.trajectory;
    let drive = drive(model, &motion.u[k], motion.time[k]);
    [&motion.q[k][..], &motion.v[k], &drive].concat()
}

/// What contacts provide by forces or impulses, the normal and then the tangential ones.
fn provided(model: &dyn Model, x: &[f64], forces: &[f64]) -> Vec<f64> {
    let declaration = model.declaration();
    let count = declaration.contacts.len();
    let mut point = vec![0.0; contact_point::length(declaration.coordinates.len())];
    let mut provided = forces.to_vec();
    provided.resize(2 * count, 0.0);
    for contact in 0..count {
        model.contact(contact, x, &mut point);
        let inertia = point[contact_point::INVERSE_INERTIA];
        for k in [contact, count + contact] {
            // Without a force there is none, wherever that is.
            if provided[k] != 0.0 {
                provided[k] *= inertia;
            }
        }
    }
    provided
}

/// What contacts provide at an instant.
fn forces(model: &dyn Model, replay: &Simulation, k: usize, x: &[f64]) -> Vec<f64> {
    let motion = &replay.trajectory;
    let friction = motion.friction_force.get(k).map_or(&[][..], Vec::as_slice);
    let normal = &motion.contact_force[k];
    provided(model, x, &[normal, friction].concat())
}

/// The last instant before an impact at the end.
fn last(replay: &Simulation) -> usize {
    let times = &replay.trajectory.time;
    let end = times.last().copied().unwrap_or_default();
    let before = times.iter().rposition(|&time| time < end).unwrap_or(0);
    (before + 1).min(times.len().saturating_sub(1))
}

/// Path constraints that read forces, over the motion.
fn along(model: &dyn Model, replay: &Simulation) -> Vec<Looked> {
    let declaration = model.declaration();
    let Some(declared) = declaration.optimal_control.filter(|d| d.contacts.path) else {
        return Vec::new();
    };
    let (first, plain) = (usize::from(declared.running_cost), declaration.inputs());
    let pattern = declared.path_jacobian;
    let mut conditions = chosen(declared.constraints, |i| pattern.reads(first + i, plain));
    let mut values = [
        vec![0.0; declared.path_functions()],
        vec![0.0; declared.path_functions()],
    ];
    for k in 0..=last(replay) {
        let mut x = input(model, replay, k);
        let forces = forces(model, replay, k, &x);
        x.extend(forces);
        model.path_functions(&x, &mut values[0]);
        x[plain..].fill(0.0);
        model.path_functions(&x, &mut values[1]);
        for (i, looked) in &mut conditions {
            let time = replay.trajectory.time[k];
            looked.at(time, values[0][first + *i], values[1][first + *i]);
        }
    }
    conditions.into_iter().map(|(_, looked)| looked).collect()
}

/// The sums over impacts, and the conditions on impacts.
fn in_impacts(model: &dyn Model, replay: &Simulation) -> (Vec<f64>, Vec<Looked>) {
    let declaration = model.declaration();
    let terms = declaration.optimal_control.map(|d| d.contacts);
    let Some(terms) = terms.filter(|terms| terms.impact_functions() > 0) else {
        return (Vec::new(), Vec::new());
    };
    let mut sums = vec![0.0; terms.sums];
    let mut conditions = chosen(terms.constraints, |_| true);
    let mut values = vec![0.0; terms.impact_functions()];
    let mut without = values.clone();
    let motion = &replay.trajectory;
    for k in 1..motion.time.len() {
        let (before, after) = (motion.impulses(k - 1), motion.impulses(k));
        let impulses: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
        if impulses.iter().all(|&impulse| impulse == 0.0) {
            continue;
        }
        let mut x = input(model, replay, k);
        let plain = x.len();
        let impulses = provided(model, &x, &impulses);
        x.extend(&impulses);
        model.impact_functions(&x, &mut values);
        x[plain..].fill(0.0);
        model.impact_functions(&x, &mut without);
        let added = values.iter().zip(&without);
        let summed = sums.iter_mut().zip(added);
        summed.for_each(|(sum, (with, without))| *sum += with - without);
        for (i, looked) in &mut conditions {
            let reads = |&(row, column): &(u32, u32)| {
                let contact = (column as usize).checked_sub(plain);
                row as usize == terms.sums + *i && contact.is_some_and(|c| impulses[c] != 0.0)
            };
            if terms.impact_jacobian.entries.iter().any(reads) {
                let function = terms.sums + *i;
                looked.at(motion.time[k], values[function], without[function]);
            }
        }
    }
    let conditions = conditions.into_iter().map(|(_, looked)| looked);
    (sums, conditions.collect())
}

/// Goals that read sums over impacts or forces at the end.
fn at_the_end(model: &dyn Model, replay: &Simulation, sums: &mut Vec<f64>) -> Vec<Looked> {
    let declaration = model.declaration();
    let Some(declared) = declaration.optimal_control else {
        return Vec::new();
    };
    let motion = &replay.trajectory;
    let (Some(q), Some(v), Some(&time)) = (motion.q.last(), motion.v.last(), motion.time.last())
    else {
        return Vec::new();
    };
    let (first, plain) = (usize::from(declared.final_cost), q.len() + v.len() + 1);
    let pattern = declared.terminal_jacobian;
    let mut conditions = chosen(declared.goals, |i| pattern.reads(first + i, plain));
    let mut z = [&q[..], v, &[time]].concat();
    z.append(sums);
    if declared.contacts.terminal {
        let k = last(replay);
        z.extend(forces(model, replay, k, &input(model, replay, k)));
    }
    let mut values = vec![0.0; declared.terminal_functions()];
    let mut without = values.clone();
    model.terminal_functions(&z, &mut values);
    z[plain..].fill(0.0);
    model.terminal_functions(&z, &mut without);
    for (i, looked) in &mut conditions {
        looked.at(time, values[first + *i], without[first + *i]);
    }
    conditions.into_iter().map(|(_, looked)| looked).collect()
}
