//! Problems of scenes with joints: a start that fulfils them, and rows of joints that say something.
//!
//! Free initial values are guesses and are moved first, so that what is given stays as it is where they can fulfil the joints by
//! themselves.

use super::problem::{CompletedStart, Problem, has_free_start};
use super::program::start_joints::at_start;
use super::solution::Solution;
use crate::derivative::{completed, differences};
use crate::model::held::{complete_start, is_held, moving};
use crate::model::{Function, Given, Model};
use crate::refusal;
use crate::simulation::{ClosedStart, ControlSignal, InputError};
use crate::yardstick;
use nalgebra::{DMatrix, DVector};

/// Newton steps of the free initial values.
const STEPS: usize = 50;
/// Singular values, to the largest, below which free initial values do not move a row.
const DEPENDENT: f64 = 1e-10;

/// A problem whose start fulfils the joints.
pub(in crate::ocp) struct Joined {
    /// The scene without rows that follow from others.
    pub(in crate::ocp) model: Box<dyn Model>,
    pub(in crate::ocp) problem: Problem,
    notes: Vec<String>,
}

/// The problem with a start that fulfils the joints of its scene; none without joints.
///
/// # Errors
/// [`InputError`] where the start cannot be completed or a parameter that is found would be decided by it.
pub(in crate::ocp) fn joined(
    model: &dyn Model,
    problem: &Problem,
) -> Result<Option<Joined>, InputError> {
    let Some(declared) = model.declaration().joints else {
        return Ok(None);
    };
    let mut start = problem.start();
    if has_free_start(model) {
        move_what_is_free(model, problem, &mut start);
    }
    let given = problem.initial_value_problem(&start, 1.0, ControlSignal::Zero);
    let closed = ClosedStart::of(model, &given)?;
    let (scene, complete) = closed.scene();
    let problem = Problem {
        q: complete.q.clone(),
        v: complete.v.clone(),
        completed: how_completed(scene, problem, &start)?,
        ..problem.clone()
    };
    let units = vec![1.0; start.len()];
    let found = at_start(scene, &problem, &units, &problem.start());
    if let Some((row, parameter)) = found.decides_parameter {
        let named = declared.equations().nth(row);
        let joint = named.map_or(String::new(), |(joint, row)| joint.equation(row));
        let name = model.declaration().coordinates[parameter].name;
        return Err(refusal::unsupported(
            format!(
                "the start, which fulfils joint {joint} at one value of `{name}` alone, that is to be found,"
            ),
            "let what the joint moves be free at the start, or give it by the parameter",
        ));
    }
    Ok(Some(Joined {
        model: scene.boxed(),
        notes: closed.notes().to_vec(),
        problem,
    }))
}

/// How joints move a start with the given parameters that are variables.
fn how_completed(
    model: &dyn Model,
    problem: &Problem,
    start: &[f64],
) -> Result<Vec<CompletedStart>, InputError> {
    let Some(held) = model.held() else {
        return Ok(Vec::new());
    };
    let (n, first) = (problem.q.len(), moving(model));
    let ranges = problem.start_ranges(model);
    let is_given = |k: &usize| ranges[*k].0 >= ranges[*k].1;
    let parameters = first..first + held.count().min(held.parameters.len());
    let (given, unknown): (Vec<usize>, Vec<usize>) = parameters.partition(is_given);
    let declared = model.declaration().optimal_control;
    let free = |k: &usize| declared.is_some_and(|declared| declared.free_start.contains(k));
    let by_unknown = |k: &usize| {
        let own = held
            .given
            .iter()
            .position(|known| *known == Given::Start(*k));
        let mut entries = held.jacobian.entries.iter();
        own.is_some_and(|own| {
            entries.any(|&(of, by)| of as usize == own && unknown.contains(&(by as usize)))
        })
    };
    let components = (0..2 * n).filter(|k| !is_held(model, *k) && !free(k) && !by_unknown(k));
    let mut found: Vec<CompletedStart> = components
        .map(|component| CompletedStart {
            component,
            by: Vec::new(),
        })
        .collect();
    for parameter in given {
        let size = if start[parameter] == 0.0 {
            1.0
        } else {
            start[parameter].abs()
        };
        let by = differences(size, &mut |way| {
            let mut moved = start.to_vec();
            moved[parameter] += way;
            complete_start(model, &mut moved);
            completed(
                model,
                &problem.initial_value_problem(&moved, 1.0, ControlSignal::Zero),
            )
        })?;
        for known in &mut found {
            known.by.push((parameter, by[known.component]));
        }
    }
    found.retain(|known| known.by.iter().any(|(_, by)| *by != 0.0));
    Ok(found)
}

impl Joined {
    /// Says of a solution what was said of the start.
    pub(in crate::ocp) fn note(&self, mut solution: Solution) -> Solution {
        if let Some(motion) = &mut solution.motion {
            let own = self
                .notes
                .iter()
                .filter(|note| !motion.notes.contains(note));
            let own: Vec<String> = own.cloned().collect();
            motion.notes.splice(0..0, own);
        }
        solution
    }
}

/// Moves free initial values onto the joints, as far as Newton's method in them alone gets there; positions, and then velocities.
fn move_what_is_free(model: &dyn Model, problem: &Problem, start: &mut [f64]) {
    let n = problem.q.len();
    let ranges = problem.start_ranges(model);
    for first in [0, n] {
        let columns = first..first + n;
        let free: Vec<usize> = columns.filter(|&k| ranges[k].0 < ranges[k].1).collect();
        let mut moved = start.to_vec();
        for _ in 0..STEPS {
            let Some((step, off)) = newton(model, &moved, first == 0, &free) else {
                break;
            };
            if off <= yardstick::ROUNDING {
                start.copy_from_slice(&moved);
                break;
            }
            for (&k, step) in free.iter().zip(&step) {
                moved[k] -= step;
            }
        }
    }
}

/// A Newton step of some components of `(q, v)` towards the positions or the velocities of joints, the smallest one, and how far the rows
/// are from holding, as a share of their terms.
fn newton(
    model: &dyn Model,
    start: &[f64],
    positions: bool,
    free: &[usize],
) -> Option<(Vec<f64>, f64)> {
    let declaration = model.declaration();
    let joints = declaration.joints?;
    let count = joints.rows();
    let first = if positions { 0 } else { count };
    let mut x = start.to_vec();
    x.resize(declaration.inputs(), 0.0);
    let mut values = vec![0.0; 2 * count];
    model.values(Function::Joints, &x, &mut values);
    let mut slopes = vec![0.0; joints.jacobian.entries.len()];
    model.jacobian(Function::Joints, &x, &mut slopes);
    let mut matrix = DMatrix::zeros(count, free.len());
    let mut sizes = vec![0.0_f64; count];
    for (&(row, column), slope) in joints.jacobian.entries.iter().zip(slopes) {
        let Some(row) = (row as usize).checked_sub(first).filter(|row| *row < count) else {
            continue;
        };
        let column = column as usize;
        // One of the unit of the scene at least.
        sizes[row] += slope.abs() * x[column].abs().max(1.0);
        if let Ok(place) = free.binary_search(&column) {
            matrix[(row, place)] = slope;
        }
    }
    let values = &values[first..first + count];
    let shares = values
        .iter()
        .zip(&sizes)
        .filter(|(value, _)| **value != 0.0);
    let off = shares.fold(0.0_f64, |most, (value, size)| most.max(value.abs() / size));
    if !off.is_finite() || free.is_empty() {
        return None;
    }
    let decomposed = matrix.svd(true, true);
    let least = DEPENDENT * decomposed.singular_values.max();
    let step = decomposed.solve(&DVector::from_column_slice(values), least);
    Some((step.ok()?.as_slice().to_vec(), off))
}
