//! Conditions on forces and impulses, and the cost of them, in the re-simulation of a plan.
//!
//! The plan keeps conditions at its stages, and the forces there are less accurate than the motion. So they are looked at
//! once more with the forces and impulses of the event-driven simulation, and so is the objective that contains them.

use super::at_bounds::add;
use crate::model::held::complete_largest;
use crate::model::{ConstraintDeclaration, Function, Model, contact_point};
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::model_input::drive;
use crate::ocp::solution::Excess;
use crate::simulation::Simulation;

/// Violation relative to the size of the condition up to which plan and re-simulation agree.
const AGREES: f64 = 1e-4;

/// Difference of the objectives, relative to the integral of what is added up: the trapezoids over the points of the
/// simulation are good to about a tenth of that.
const SAME_COST: f64 = 1e-2;

/// A condition, what it came to, and its size: its largest value, with and without what contacts do.
pub(super) struct Looked {
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

    fn excess(&self) -> Excess {
        Excess {
            name: self.declared.name.to_owned(),
            amount: self.violation,
            unit: self.declared.unit.to_owned(),
            time: self.time,
        }
    }
}

/// The first condition that is violated by more than plan and re-simulation may differ, in words.
pub(super) fn violated(conditions: &[Looked]) -> Option<String> {
    let worse = |looked: &&Looked| looked.violation > AGREES * looked.size;
    let first = conditions.iter().find(worse);
    first.map(|looked| looked.excess().words())
}

/// The violations at limits with those of forces and impulses.
pub(super) fn excess(conditions: &[Looked], mut all: Vec<Excess>) -> Vec<Excess> {
    for looked in conditions.iter().filter(|looked| looked.violation > 0.0) {
        add(&mut all, looked.excess());
    }
    all
}

/// The conditions on forces and impulses in the re-simulation of a plan; none for scenes without.
pub(super) fn looked(model: &dyn Model, replay: &Simulation) -> Vec<Looked> {
    let declared = model.declaration().optimal_control;
    let simulated = !replay.trajectory.time.is_empty();
    if !simulated || declared.is_none_or(|declared| !declared.contacts.any()) {
        return Vec::new();
    }
    let (sums, impacts) = in_impacts(model, replay);
    let conditions = along(model, replay).into_iter().chain(impacts);
    conditions.chain(at_the_end(model, replay, &sums)).collect()
}

/// Where an objective that contains forces or impulses is another one in the re-simulation than in the plan, in words.
pub(super) fn other_cost(setting: Setting, planned: f64, replay: &Simulation) -> Option<String> {
    let Setting { model, problem, .. } = setting;
    let declaration = model.declaration();
    let declared = declaration.optimal_control?;
    let inputs = 2 * problem.q.len() + 1;
    let runs = declared.running_cost && declared.path_jacobian.reads(0, declaration.inputs());
    let ends = declared.final_cost && declared.terminal_jacobian.reads(0, inputs);
    let simulated = !replay.trajectory.time.is_empty();
    if !simulated || !(runs || ends) {
        return None;
    }
    let (mut cost, mut size) = (0.0, 0.0);
    if declared.running_cost {
        let times = &replay.trajectory.time;
        let mut values = vec![0.0; declared.path_functions()];
        let mut rate = |k: usize| {
            model.values(Function::Path, &path_input(model, replay, k), &mut values);
            values[0]
        };
        let mut before = rate(0);
        for k in 1..times.len() {
            let (length, now) = (times[k] - times[k - 1], rate(k));
            cost += 0.5 * length * (before + now);
            size += 0.5 * length * (before.abs() + now.abs());
            before = now;
        }
    }
    if declared.final_cost {
        let (sums, _) = in_impacts(model, replay);
        let mut values = vec![0.0; declared.terminal_functions()];
        model.values(
            Function::Terminal,
            &end_input(model, replay, &sums)?,
            &mut values,
        );
        cost += values[0];
        size += values[0].abs();
    }
    let differs = (cost - planned).abs() > SAME_COST * size;
    differs.then(|| {
        format!("the objective is {planned:.6} in the plan, {cost:.6} in the re-simulation")
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

/// What path functions read at an instant.
fn path_input(model: &dyn Model, replay: &Simulation, k: usize) -> Vec<f64> {
    let mut x = input(model, replay, k);
    if model.declaration().path_inputs() > x.len() {
        x.extend(forces(model, replay, k, &x));
    }
    complete_largest(model, &mut x);
    x
}

/// What terminal functions read after these sums over impacts.
fn end_input(model: &dyn Model, replay: &Simulation, sums: &[f64]) -> Option<Vec<f64>> {
    let motion = &replay.trajectory;
    let mut z = [
        &motion.q.last()?[..],
        motion.v.last()?,
        &[*motion.time.last()?],
        sums,
    ]
    .concat();
    if model.declaration().terminal_inputs() > z.len() {
        let k = last(replay);
        z.extend(forces(model, replay, k, &input(model, replay, k)));
    }
    Some(z)
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
        let mut x = path_input(model, replay, k);
        model.values(Function::Path, &x, &mut values[0]);
        x[plain..].fill(0.0);
        model.values(Function::Path, &x, &mut values[1]);
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
    let Some(terms) = terms.filter(|terms| terms.of_impacts() > 0) else {
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
        model.values(Function::Impact, &x, &mut values);
        x[plain..].fill(0.0);
        model.values(Function::Impact, &x, &mut without);
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
fn at_the_end(model: &dyn Model, replay: &Simulation, sums: &[f64]) -> Vec<Looked> {
    let declaration = model.declaration();
    let (Some(declared), Some(mut z)) =
        (declaration.optimal_control, end_input(model, replay, sums))
    else {
        return Vec::new();
    };
    let (first, plain) = (
        usize::from(declared.final_cost),
        2 * declaration.coordinates.len() + 1,
    );
    let pattern = declared.terminal_jacobian;
    let mut conditions = chosen(declared.goals, |i| pattern.reads(first + i, plain));
    let mut values = vec![0.0; declared.terminal_functions()];
    let mut without = values.clone();
    model.values(Function::Terminal, &z, &mut values);
    let time = z[plain - 1];
    z[plain..].fill(0.0);
    model.values(Function::Terminal, &z, &mut without);
    for (i, looked) in &mut conditions {
        looked.at(time, values[first + *i], without[first + *i]);
    }
    conditions.into_iter().map(|(_, looked)| looked).collect()
}
