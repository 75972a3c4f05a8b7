//! Joints in a transcription.
//!
//! Accelerations and fields of contacts are those with which joints hold, so that `g = 0` and `w = 0` follow from a start that fulfils
//! them, in flight, in contact and in jumps, but for the error of the scheme. So that nothing drifts, rows of joints stand at each block in the place of as many
//! rows of collocation: those of the components of `(q, v)` that they [decide](crate::joints::partition), chosen at the guess for each
//! element by itself, in the metric of the mass matrix. That is the scheme in minimal coordinates, without a variable or a row more.
//!
//! Where the start is free, it fulfils the joints by rows of its own, which the task names.

use super::Transcription;
use super::numbered::{At, JointSite, Replaced, Use};
use crate::joints::partition::{Jacobian, deciding};
use crate::model::JointsDeclaration;

/// Chooses the components that joints decide, at a guess.
pub(super) fn choose(transcription: &mut Transcription<'_>, guess: &[f64]) {
    let Some(declared) = transcription.dcs.system.model.declaration().joints else {
        return;
    };
    let mut joints = std::mem::take(&mut transcription.joints);
    joints.replaced = Replaced(vec![false; transcription.constraints]);
    if transcription.beginning.is_some() {
        let state = gather(transcription, guess, At::Start);
        let jacobian = jacobian_at(transcription, declared, &state);
        let outputs = transcription.task.joints_at_start.iter().enumerate();
        let uses = outputs.map(|(place, &output)| {
            let entries = jacobian.of(output).iter();
            let size = entries.fold(0.0_f64, |most, entry| most.max(entry.abs()));
            let row = joints.first_at_start + place;
            Use { row, output, size }
        });
        let (uses, at) = (uses.collect(), At::Start);
        joints.sites.push(JointSite { at, uses });
    }
    let states = transcription.dcs.layout.states();
    for element in 0..transcription.elements.len() {
        let first = At::Block { element, block: 0 };
        let state = gather(transcription, guess, first);
        let decided = decided(transcription, declared, &state);
        let begin = transcription.elements[element].collocation_rows;
        for block in 0..transcription.elements[element].blocks.len() {
            let place = begin + block * states;
            let uses = decided.iter().map(|&(component, output, size)| {
                let row = place + component;
                joints.replaced.0[row] = true;
                Use { row, output, size }
            });
            let uses = uses.collect();
            let at = At::Block { element, block };
            joints.sites.push(JointSite { at, uses });
        }
    }
    transcription.joints = joints;
}

/// The components that joints decide at an input vector, each with the row of `(g, w)` that does, and what that row changes by where the
/// component changes by one.
fn decided(
    transcription: &Transcription<'_>,
    declared: JointsDeclaration,
    input: &[f64],
) -> Vec<(usize, usize, f64)> {
    let model = transcription.dcs.system.model;
    let n = transcription.dcs.system.coordinates();
    let mut mass = vec![0.0; n * n];
    model.mass_matrix(input, &mut mass);
    let units: Vec<f64> = (0..n).map(|k| mass[k * n + k].sqrt().recip()).collect();
    let jacobian = jacobian_at(transcription, declared, input);
    let pairs = deciding(model, declared, &jacobian, &units);
    let of_pair = pairs.iter().flat_map(|pair| {
        let velocities = &jacobian.of(jacobian.count + pair.row)[n..];
        let terms = velocities.iter().zip(&units);
        let most = terms.fold(0.0_f64, |most, (entry, unit)| {
            most.max((entry * unit).abs())
        });
        let size = most / units[pair.column];
        let position = pair.holonomic.then_some((pair.column, pair.row, size));
        let velocity = (n + pair.column, jacobian.count + pair.row, size);
        position.into_iter().chain([velocity])
    });
    of_pair.collect()
}

/// Derivatives of `(g, w)` at an input vector.
fn jacobian_at(
    transcription: &Transcription<'_>,
    declared: JointsDeclaration,
    input: &[f64],
) -> Jacobian {
    let n = transcription.dcs.system.coordinates();
    let model = transcription.dcs.system.model;
    let time = input.last().copied().unwrap_or(0.0);
    Jacobian::at(model, declared, &input[..2 * n], time)
}

/// Input vector of the model at a site. Joints read no controls.
fn gather(transcription: &mut Transcription<'_>, x: &[f64], at: At) -> Vec<f64> {
    match at {
        At::Start => {
            let beginning = transcription.beginning.as_ref();
            let variables = beginning.map(|own| own.block.variables.clone());
            transcription.gather_from(x, 0, &variables.unwrap_or_default());
        }
        At::Block { element, block } => transcription.gather(x, element, block),
    }
    let layout = &transcription.dcs.layout;
    let inputs = transcription.dcs.system.model.declaration().inputs();
    let local = &transcription.local;
    (0..inputs)
        .map(|k| local[layout.local_of_input(k)])
        .collect()
}

/// Variable that an input of the model is at a site.
fn variable(transcription: &Transcription<'_>, at: At, input: u32) -> Option<usize> {
    let place = transcription.dcs.layout.local_of_input(input as usize);
    let block = match at {
        At::Start => &transcription.beginning.as_ref()?.block,
        At::Block { element, block } => &transcription.elements[element].blocks[block],
    };
    block.variables[place]
}

/// Writes the values of the rows, in the place of collocation.
pub(super) fn write_rows(transcription: &mut Transcription<'_>, x: &[f64], c: &mut [f64]) {
    let joints = std::mem::take(&mut transcription.joints);
    for JointSite { at, uses } in &joints.sites {
        let input = gather(transcription, x, *at);
        let model = transcription.dcs.system.model;
        let rows = model.declaration().joints.map_or(0, |own| own.rows());
        let mut values = vec![0.0; 2 * rows];
        model.joints(&input, &mut values);
        for used in uses {
            c[used.row] = values[used.output] / used.size;
        }
    }
    transcription.joints = joints;
}

/// Entries of the Jacobian of the rows, always in the same order.
pub(super) fn add_jacobian(
    transcription: &mut Transcription<'_>,
    x: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    let joints = std::mem::take(&mut transcription.joints);
    for JointSite { at, uses } in &joints.sites {
        let input = gather(transcription, x, *at);
        let model = transcription.dcs.system.model;
        let entries = model.declaration().joints;
        let entries = entries.map_or(&[][..], |own| own.jacobian.entries);
        let mut values = vec![0.0; entries.len()];
        model.joints_jacobian(&input, &mut values);
        for (&(output, column), value) in entries.iter().zip(&values) {
            let used = uses.iter().find(|used| used.output == output as usize);
            if let (Some(used), Some(variable)) = (used, variable(transcription, *at, column)) {
                add(used.row, variable, value / used.size);
            }
        }
    }
    transcription.joints = joints;
}

/// Entries of the Hessian of the weighted rows, always in the same order.
pub(super) fn add_hessian(
    transcription: &mut Transcription<'_>,
    x: &[f64],
    multipliers: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    let joints = std::mem::take(&mut transcription.joints);
    for JointSite { at, uses } in &joints.sites {
        let input = gather(transcription, x, *at);
        let model = transcription.dcs.system.model;
        let Some(declared) = model.declaration().joints else {
            continue;
        };
        let mut weights = vec![0.0; 2 * declared.rows()];
        for used in uses {
            weights[used.output] = multipliers[used.row] / used.size;
        }
        let entries = declared.hessian.entries;
        let mut values = vec![0.0; entries.len()];
        model.joints_hessian(&input, &weights, &mut values);
        for (&(i, j), value) in entries.iter().zip(&values) {
            let variable = |input: u32| variable(transcription, *at, input);
            if let (Some(a), Some(b)) = (variable(i), variable(j)) {
                add(a, b, *value);
            }
        }
    }
    transcription.joints = joints;
}

/// The name of a row of a joint, and the element and block where it stands, which are none at the start.
pub(super) fn named(
    transcription: &Transcription<'_>,
    row: usize,
) -> Option<(String, Option<(usize, usize)>)> {
    let declared = transcription.dcs.system.model.declaration().joints?;
    let mut uses = transcription.joints.sites.iter().flat_map(|site| {
        let uses = site.uses.iter();
        uses.map(|used| (site.at, used))
    });
    let (at, used) = uses.find(|(_, used)| used.row == row)?;
    let mut equations = declared.equations();
    let (joint, own) = equations.nth(used.output % declared.rows())?;
    let rate = if used.output < declared.rows() {
        ""
    } else {
        "velocity of "
    };
    let place = match at {
        At::Start => None,
        At::Block { element, block } => Some((element, block)),
    };
    Some((format!("{rate}joint {}", joint.equation(own)), place))
}
