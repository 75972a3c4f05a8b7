//! Derivatives of a simulated motion by parameters, initial values and controls: forward sensitivities.
//!
//! Between events the motion is smooth, and its derivatives solve the variational equations (`arc`, with the acceleration of a
//! contact mode and all its derivatives from `acceleration`). An event moves with what the motion is differentiated by
//! (`cause`), and with it the instant at which one mode follows the other. With the derivative `tau'` of its time, rates `f-`
//! and `f+` of the state before and after, and the derivative `J` of what happens to the state there (`jump`),
//!
//! ```text
//! S+ = J (S- + f- tau') - f+ tau'
//! ```
//!
//! Source: Aizerman, Gantmacher, *On the stability of periodic motions* (J. Appl. Math. Mech. 22, 1958).
//!
//! Where few values of many quantities are asked for, the same is multiplied from the other side (`adjoint`).
//!
//! `walk` goes along a motion that a simulator has found, `outputs` differentiates what is recorded, `wanted` knows by what.

mod acceleration;
mod adjoint;
mod arc;
mod cause;
mod cost;
mod front;
mod joint_rows;
mod jump;
mod margins;
mod matrix;
mod outputs;
mod place;
mod projection;
mod ranges;
mod reset;
mod samples;
mod sides;
mod tape;
mod walk;
mod wanted;

use super::quantity::Quantity;
use super::{InitialValueProblem, InputError, Simulation};
use crate::joints::Joints;
use crate::model::{Measured, Model, joint_rows};
use adjoint::{Value, adjoint};
use ranges::Ranges;
pub use ranges::{SequenceLimit, SequenceRange};
use samples::Samples;
pub use sides::{OneSided, Side};
use walk::Walk;
use wanted::Wanted;

/// Share of the largest coordinate, or velocity, by which joints move a start that fulfils them: rounding.
const COMPLETED: f64 = 1e-9;

/// From which side derivatives of a motion are multiplied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GradientMode {
    /// Along the motion, with a column for each quantity that it is differentiated by.
    Forward,
    /// Against it, with a row for each value at its end: its cost does not grow with the quantities.
    Adjoint,
}

impl GradientMode {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Forward => "forward",
            Self::Adjoint => "adjoint",
        }
    }
}

/// Derivatives of a simulated motion.
///
/// Every matrix has a row for each value that is differentiated, and a column for each of the quantities in
/// [`with_respect_to`](Self::with_respect_to). Units are those of the value over those of the quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    /// Names of what the motion is differentiated by: parameters; coordinates `z` and `dot(z)` for their initial values; and
    /// controls, for adding the same at all times.
    pub with_respect_to: Vec<String>,
    /// How they were computed.
    pub mode: GradientMode,
    /// Of chosen values at the end, which moves where the horizon depends on a parameter, and of chosen times of events, by their names;
    /// none unless [`differentiate_values`] was asked for them. In [`GradientMode::Adjoint`] there is nothing else.
    pub values: Vec<(String, Vec<f64>)>,
    /// Of the coordinates at the end, which moves where the horizon depends on a parameter. Not numbers without derivatives.
    pub q: Vec<Vec<f64>>,
    /// Of the velocities at the end.
    pub v: Vec<Vec<f64>>,
    /// Of the times of the events, in their order.
    pub event_times: Vec<Vec<f64>>,
    /// Of coordinates and then velocities at each instant of the trajectory, at a fixed time: of two instants at the same time
    /// the first belongs to the motion before an event there, the second to that behind it; so does a single one.
    pub states: Vec<Vec<Vec<f64>>>,
    /// Of what the scene records: for each output a row an instant of the trajectory.
    pub outputs: Vec<Vec<Vec<f64>>>,
    /// Of the objective that the scene declares with `minimize`, along this motion; none without one, without derivatives, and
    /// where it reads contact forces or impulses.
    pub objective: Option<Vec<f64>>,
    /// How far each quantity may go until the motion has another sequence of events, to first order; none without derivatives, and
    /// in [`GradientMode::Adjoint`].
    pub ranges: Vec<SequenceRange>,
    /// Why there are no derivatives from some instant on; values behind that are not numbers.
    pub obstacle: Option<String>,
    /// Derivatives to one side where there are no others, see [`add_one_sided`](super::add_one_sided).
    pub one_sided: Option<Box<OneSided>>,
}

/// Differentiates a motion that `model` has from the start of `problem`, as a simulator that locates events found it, by the
/// quantities of these names; `all` stands for all parameters.
///
/// The derivatives are those of the motion, as accurate as its states are.
///
/// # Errors
/// [`InputError`] for names that are unknown, and for scenes whose derivatives are not known.
pub fn differentiate(
    model: &dyn Model,
    problem: &InitialValueProblem,
    run: &Simulation,
    names: &[String],
) -> Result<Gradient, InputError> {
    let reduced = held_by_joints(model, (problem, run))?;
    let model = reduced.as_deref().unwrap_or(model);
    let wanted = Wanted::of(model, names)?;
    Ok(forward(model, (problem, run), &wanted, &[]))
}

/// Name of the objective among the values at the end.
const OBJECTIVE: &str = "objective";

/// Differentiates chosen values at the end of a motion, as [`differentiate`] does: `objective`, coordinates `z`, velocities
/// `dot(z)`, states, and what the scene declares in `outputs`, by their names; `event_times[k]` is the time of event `k`, from 0 on.
/// Without a `mode`, backwards where there are more
/// quantities than values; backwards there is nothing but [`Gradient::values`] and the objective, if that is among them. A motion
/// without derivatives is gone along forwards in any case, which tells why.
///
/// # Errors
/// As of [`differentiate`], and [`InputError`] for a value that the scene does not have, or that has no derivatives.
pub fn differentiate_values(
    model: &dyn Model,
    (problem, run): (&InitialValueProblem, &Simulation),
    names: &[String],
    (of, mode): (&[String], Option<GradientMode>),
) -> Result<Gradient, InputError> {
    let reduced = held_by_joints(model, (problem, run))?;
    let model = reduced.as_deref().unwrap_or(model);
    let wanted = Wanted::of(model, names)?;
    let values: Vec<(&str, Value)> = of
        .iter()
        .map(|name| Ok((name.as_str(), value(model, run, name)?)))
        .collect::<Result<_, InputError>>()?;
    let fewer = values.len() < wanted.count() && !values.is_empty();
    let backwards = mode.map_or(fewer, |mode| mode == GradientMode::Adjoint);
    let known = run.status.is_solved() && !run.trajectory.time.is_empty();
    let rows = (backwards && known)
        .then(|| {
            adjoint(
                model,
                (problem, run),
                &wanted,
                values.iter().map(|known| known.1),
            )
        })
        .flatten();
    let Some(rows) = rows else {
        let gradient = forward(model, (problem, run), &wanted, &values);
        let unknown = |row: &[f64]| row.iter().any(|by| by.is_nan());
        let open = gradient.values.iter().find(|(_, row)| unknown(row));
        return match open.filter(|_| gradient.obstacle.is_none()) {
            None => Ok(gradient),
            Some((name, _)) => Err(InputError::unsupported(format!(
                "a gradient of `{name}` at the end of `{}` is not supported: it reads forces of joints, or of contacts of a \
                 mechanism whose inertia is not a formula; take differences of two simulations",
                model.declaration().name
            ))),
        };
    };
    let objective = values
        .iter()
        .position(|(_, value)| *value == Value::Objective);
    Ok(Gradient {
        objective: objective.map(|place| rows[place].clone()),
        mode: GradientMode::Adjoint,
        values: of.iter().cloned().zip(rows).collect(),
        with_respect_to: wanted.names,
        q: Vec::new(),
        v: Vec::new(),
        event_times: Vec::new(),
        states: Vec::new(),
        outputs: Vec::new(),
        ranges: Vec::new(),
        obstacle: None,
        one_sided: None,
    })
}

/// The event whose time has this name: `k` of `event_times[k]`.
fn event(name: &str) -> Option<usize> {
    let index = name.strip_prefix("event_times[")?.strip_suffix(']')?;
    index.trim().parse().ok()
}

/// The value at the end, or the time of an event, of this name.
fn value(model: &dyn Model, run: &Simulation, name: &str) -> Result<Value, InputError> {
    let (declaration, outputs) = (model.declaration(), model.outputs());
    if let Some(k) = event(name) {
        return match run.events.len() {
            count if k < count => Ok(Value::EventTime(k)),
            0 => Err(InputError::new(format!(
                "no gradient of `{name}` along `{}`: the motion has no events",
                declaration.name
            ))),
            count => Err(InputError::new(format!(
                "no gradient of `{name}` along `{}`: the motion has {count} events, `event_times[0]` to `event_times[{}]`",
                declaration.name,
                count - 1
            ))),
        };
    }
    let n = declaration.coordinates.len();
    match Quantity::named(declaration, outputs, name) {
        Some(Quantity::Coordinate(k)) => return Ok(Value::State(k)),
        Some(Quantity::Velocity(k)) => return Ok(Value::State(n + k)),
        Some(Quantity::Output(k)) => return Ok(Value::Output(k)),
        _ => {}
    }
    let task = declaration.optimal_control;
    let declared = task.filter(|task| task.running_cost || task.final_cost);
    if let (OBJECTIVE, Some(task)) = (name, declared) {
        return if task.contacts.any() {
            Err(InputError::unsupported(format!(
                "the objective of `{}` reads contact forces or impulses, which has no derivatives along a simulation; take \
                 the gradient of an output that reads them at the end",
                declaration.name
            )))
        } else {
            Ok(Value::Objective)
        };
    }
    let mechanical = &declaration.coordinates[..declaration.mechanical()];
    let states = mechanical
        .iter()
        .flat_map(|c| [c.name.to_owned(), format!("dot({})", c.name)]);
    let first_order = declaration.states.iter().map(|known| known.name.to_owned());
    let recorded = outputs.iter().map(|output| output.name.to_owned());
    let objective = declared.map(|_| OBJECTIVE.to_owned());
    let known = states.chain(first_order).chain(recorded).chain(objective);
    let known: Vec<String> = known.collect();
    Err(InputError::new(format!(
        "no gradient of `{name}` at the end of `{}`: it has no coordinate, state or output of this name (it has: {}; \
         `event_times[0]` is the time of the first event){}",
        declaration.name,
        known.join(", "),
        if name == OBJECTIVE {
            "; `minimize` declares an objective"
        } else {
            ""
        }
    )))
}

/// Differentiates along the motion, and chooses `values` at its end.
fn forward(
    model: &dyn Model,
    (problem, run): (&InitialValueProblem, &Simulation),
    wanted: &Wanted,
    values: &[(&str, Value)],
) -> Gradient {
    let trajectory = &run.trajectory;
    let (n, columns) = (problem.q.len(), wanted.count());
    let unknown = || vec![vec![f64::NAN; columns]; n];
    let mut gradient = Gradient {
        with_respect_to: wanted.names.clone(),
        mode: GradientMode::Forward,
        values: values
            .iter()
            .map(|(name, _)| ((*name).to_owned(), vec![f64::NAN; columns]))
            .collect(),
        q: unknown(),
        v: unknown(),
        event_times: vec![vec![f64::NAN; columns]; run.events.len()],
        states: vec![vec![vec![f64::NAN; columns]; 2 * n]; trajectory.time.len()],
        outputs: vec![vec![vec![f64::NAN; columns]; trajectory.time.len()]; model.outputs().len()],
        objective: None,
        ranges: Vec::new(),
        obstacle: None,
        one_sided: None,
    };
    if !run.status.is_solved() {
        gradient.obstacle = Some(format!(
            "the motion is not known to its end: {}",
            run.status
        ));
        return gradient;
    }
    let walk = Walk::new(model, problem, run, wanted);
    let Some(mut walk) = walk.filter(|_| !trajectory.time.is_empty()) else {
        gradient.obstacle = Some("there is no motion".to_owned());
        return gradient;
    };
    walk.ranges = Some(Ranges::new(columns));
    match walk.run() {
        Ok(()) => {
            gradient.ranges = walk.ranges();
            let end = walk.end();
            (gradient.q, gradient.v) = (end.state.rows(0..n), end.state.rows(n..2 * n));
            for ((_, row), (_, value)) in gradient.values.iter_mut().zip(values) {
                *row = value.of(&end).map_or_else(Vec::new, <[f64]>::to_vec);
            }
            gradient.objective = end.objective;
        }
        Err(why) => {
            // Times of events before that are known.
            for ((_, row), (_, value)) in gradient.values.iter_mut().zip(values) {
                if let Value::EventTime(k) = *value
                    && let Some(times) = walk.event_times.get(k)
                {
                    row.clone_from(times);
                }
            }
            gradient.obstacle = Some(why);
        }
    }
    for (to, times) in gradient.event_times.iter_mut().zip(walk.event_times) {
        *to = times;
    }
    for (to, state) in gradient.states.iter_mut().zip(walk.states) {
        *to = state.rows(0..2 * n);
    }
    for (k, values) in walk.outputs.iter().enumerate() {
        for (output, rows) in gradient.outputs.iter_mut().enumerate() {
            rows[k] = values.row(output).to_vec();
        }
    }
    gradient
}

/// The scene with those equations of joints that hold the motion, where others follow from them.
///
/// # Errors
/// A start that joints have completed: how that depends on the guess is not known.
fn held_by_joints(
    model: &dyn Model,
    (problem, run): (&InitialValueProblem, &Simulation),
) -> Result<Option<Box<dyn Model>>, InputError> {
    let rows = joint_rows(model);
    let trajectory = &run.trajectory;
    let (Some(q), Some(v)) = (trajectory.q.first(), trajectory.v.first()) else {
        return Ok(None);
    };
    if rows == 0 {
        return Ok(None);
    }
    let size = |values: &[f64]| {
        values
            .iter()
            .fold(0.0_f64, |most, value| value.abs().max(most))
    };
    let moved = |given: &[f64], found: &[f64]| {
        let least = COMPLETED * size(found).max(size(given));
        let mut pairs = given.iter().zip(found);
        pairs.any(|(given, found)| (given - found).abs() > least)
    };
    if moved(&problem.q, q) || moved(&problem.v, v) {
        return Err(InputError::unsupported(format!(
            "a gradient of `{}` is not supported: joints complete its start, which is a guess; give a start that fulfils them",
            model.declaration().name
        )));
    }
    let mut joints = Joints::with_rows(model, (0..rows).collect());
    let held = joints.independent_rows(&problem.input(model));
    let held = held.map_err(|_| InputError::new("the start does not fulfil the joints"))?;
    Ok((held.len() < rows).then(|| {
        let mut reduced = model.boxed();
        for row in 0..rows {
            reduced.hold_joint_row(row, held.contains(&row));
        }
        reduced
    }))
}

/// What is measured of a motion at given times.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Observed {
    /// By time and then by quantity; fewer than there are times where the motion ends before.
    pub(crate) values: Vec<Vec<f64>>,
    /// Derivatives of each; fewer where there are none from some instant on.
    pub(crate) by: Vec<Vec<Vec<f64>>>,
    /// Why there are none from there on.
    pub(crate) obstacle: Option<String>,
}

/// Observes what is `measured` of a motion at increasing `times`, right before an event at one of them, and differentiates that
/// by the quantities of these names, as [`differentiate`] does.
///
/// # Errors
/// [`InputError`] for names that are unknown, and for scenes whose derivatives are not known.
pub(crate) fn observe(
    model: &dyn Model,
    (problem, run): (&InitialValueProblem, &Simulation),
    names: &[String],
    (measured, times): (&[Measured], &[f64]),
) -> Result<Observed, InputError> {
    let reduced = held_by_joints(model, (problem, run))?;
    let model = reduced.as_deref().unwrap_or(model);
    let wanted = Wanted::of(model, names)?;
    let mut observed = Observed {
        values: Vec::new(),
        by: Vec::new(),
        obstacle: Some("there is no motion".to_owned()),
    };
    if run.trajectory.time.is_empty() {
        return Ok(observed);
    }
    let Some(mut walk) = Walk::new(model, problem, run, &wanted) else {
        return Ok(observed);
    };
    walk.samples = Some(Samples::new(measured, times));
    observed.obstacle = walk.run().err();
    if let Some(samples) = walk.observed() {
        (observed.values, observed.by) = (samples.values, samples.by);
    }
    if observed.by.len() == times.len() {
        // What happens behind the last measurement is not seen.
        observed.obstacle = None;
    }
    Ok(observed)
}
