//! A motion's derivatives, by name.

use super::adjoint::{Value, adjoint, error};
use super::quantities::Quantities;
use super::ranges::{Ranges, SequenceRange};
use super::samples::Samples;
use super::sides::OneSided;
use super::start::start;
use super::tangent::Tangent;
use super::walk::Walk;
use crate::InputError;
use crate::joints::Joints;
use crate::model::{Measured, Model, joint_rows};
use crate::simulation::{InitialValueProblem, Quantity, Simulation};

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
    /// How far derivatives may be off, as a share of the largest change of each value that they tell of: by how much coarser steps change them
    /// along one direction, and the error of the motion. `None` where that is not known.
    pub error_estimate: Option<f64>,
    /// How far each quantity may go until the motion has another sequence of events, to first order; none without derivatives, and
    /// in [`GradientMode::Adjoint`].
    pub ranges: Vec<SequenceRange>,
    /// Why there are no derivatives by some quantity from some instant on, the first of [`obstacles`](Self::obstacles).
    pub obstacle: Option<String>,
    /// For each quantity why there are no derivatives by it from some instant on; values behind that are not numbers.
    pub obstacles: Vec<Option<String>>,
    /// Derivatives to one side where there are no others.
    pub one_sided: Option<Box<OneSided>>,
}

/// Differentiates a motion that `model` has from the start of `problem`, as a simulator that locates events found it, by the
/// quantities of these names; `all` stands for all parameters.
///
/// The derivatives are those of the motion, about as accurate as its states are: [`Gradient::error_estimate`].
///
/// # Errors
/// [`InputError`] for names that are unknown, and for scenes whose derivatives are not known.
pub fn differentiate(
    model: &dyn Model,
    problem: &InitialValueProblem,
    run: &Simulation,
    names: &[String],
) -> Result<Gradient, InputError> {
    differentiate_values(
        model,
        (problem, run),
        names,
        (&[], Some(GradientMode::Forward)),
    )
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
    let known = Known::of(model, (problem, run), names)?;
    let model = known.model(model);
    let quantities = &known.quantities;
    let values: Vec<(&str, Value)> = of
        .iter()
        .map(|name| Ok((name.as_str(), value(model, run, name)?)))
        .collect::<Result<_, InputError>>()?;
    let fewer = values.len() < quantities.count() && !values.is_empty();
    let backwards = mode.map_or(fewer, |mode| mode == GradientMode::Adjoint);
    let goes = run.status.is_solved() && !run.trajectory.time.is_empty();
    let chosen = || values.iter().map(|known| known.1);
    let from = (quantities, &known.start);
    let rows = (backwards && goes).then(|| adjoint(model, (problem, run), from, chosen()));
    let Some(rows) = rows.flatten() else {
        let gradient = forward(model, (problem, run), &known, &values);
        let unknown = |row: &[f64]| {
            let mut pairs = row.iter().zip(&gradient.obstacles);
            pairs.any(|(by, obstacle)| by.is_nan() && obstacle.is_none())
        };
        return match gradient.values.iter().find(|(_, row)| unknown(row)) {
            None => Ok(gradient),
            Some((name, _)) => Err(InputError::unsupported(format!(
                "a gradient of `{name}` at the end of `{}` is not supported: it reads forces of joints, or of contacts of a \
                 mechanism whose inertia is not a formula; take differences of two simulations",
                model.declaration().name
            ))),
        };
    };
    let objective = chosen().position(|value| value == Value::Objective);
    let known = chosen().zip(rows.iter().map(Vec::as_slice));
    Ok(Gradient {
        error_estimate: error(model, (problem, run), from, known),
        objective: objective.map(|place| rows[place].clone()),
        mode: GradientMode::Adjoint,
        values: of.iter().cloned().zip(rows).collect(),
        ..Gradient::without(&quantities.names)
    })
}

impl Gradient {
    /// Of nothing by these.
    fn without(names: &[String]) -> Self {
        Self {
            with_respect_to: names.to_vec(),
            mode: GradientMode::Forward,
            values: Vec::new(),
            q: Vec::new(),
            v: Vec::new(),
            event_times: Vec::new(),
            states: Vec::new(),
            outputs: Vec::new(),
            objective: None,
            error_estimate: None,
            ranges: Vec::new(),
            obstacle: None,
            obstacles: vec![None; names.len()],
            one_sided: None,
        }
    }

    /// Its rows, and what each is of.
    fn rows(&self) -> impl Iterator<Item = (Value, &[f64])> + Clone {
        let states = self.q.iter().chain(&self.v).enumerate();
        let states = states.map(|(i, by)| (Value::State(i), &by[..]));
        let times = self.event_times.iter().enumerate();
        let times = times.map(|(k, by)| (Value::EventTime(k), &by[..]));
        let objective = self.objective.iter();
        let objective = objective.map(|by| (Value::Objective, &by[..]));
        states.chain(times).chain(objective)
    }
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
    Known {
        quantities, start, ..
    }: &Known,
    values: &[(&str, Value)],
) -> Gradient {
    let trajectory = &run.trajectory;
    let (n, columns) = (problem.q.len(), quantities.count());
    let unknown = || vec![f64::NAN; columns];
    let instants = trajectory.time.len();
    let mut gradient = Gradient {
        values: (values.iter().map(|known| (known.0.to_owned(), unknown()))).collect(),
        q: vec![unknown(); n],
        v: vec![unknown(); n],
        event_times: vec![unknown(); run.events.len()],
        states: vec![vec![unknown(); 2 * n]; instants],
        outputs: vec![vec![unknown(); instants]; model.outputs().len()],
        ..Gradient::without(&quantities.names)
    };
    let motion = (problem, run);
    let begin = (start.clone(), &quantities.names[..]);
    let walk = Walk::new(model, motion, quantities, begin);
    let walk = walk.filter(|_| run.status.is_solved() && instants > 0);
    let Some(mut walk) = walk else {
        let why = match run.status.is_solved() {
            true => "there is no motion".to_owned(),
            false => format!("the motion is not known to its end: {}", run.status),
        };
        gradient.obstacles.fill(Some(why.clone()));
        gradient.obstacle = Some(why);
        return gradient;
    };
    walk.ranges = Some(Ranges::new(columns));
    let end = walk.run().then(|| walk.end());
    for ((_, row), (_, value)) in gradient.values.iter_mut().zip(values) {
        // Times of events before that are known where the end is not.
        let found = match (&end, value) {
            (Some(end), value) => value.of(end, &walk.event_times),
            (None, Value::EventTime(k)) => walk.event_times.get(*k).map(Vec::as_slice),
            (None, _) => None,
        };
        if let Some(found) = found {
            row.copy_from_slice(found);
            if !matches!(value, Value::EventTime(_)) {
                walk.existence.mask(row);
            }
        }
    }
    if let Some(end) = end {
        let ranges = walk.ranges.take();
        gradient.ranges =
            ranges.map_or_else(Vec::new, |known| known.finish(&walk.at, &walk.ends()));
        gradient.q = end.tangent.all.rows(0..n);
        gradient.v = end.tangent.all.rows(n..2 * n);
        gradient.objective = end.objective;
        let rows = gradient.q.iter_mut().chain(&mut gradient.v);
        rows.chain(&mut gradient.objective)
            .for_each(|row| walk.existence.mask(row));
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
    if !walk.existence.is_over() {
        gradient.error_estimate = error(model, motion, (quantities, start), gradient.rows());
    }
    gradient.obstacles = walk.existence.lost;
    gradient.obstacle = gradient.obstacles.iter().flatten().next().cloned();
    gradient
}

/// What a motion is differentiated by, and how it starts.
struct Known {
    /// The scene with those equations of joints that hold the motion, where others follow from them.
    reduced: Option<Box<dyn Model>>,
    quantities: Quantities,
    /// Derivatives at the start, which joints have completed.
    start: Tangent,
}

impl Known {
    /// # Errors
    /// [`InputError`] for names that are unknown, and for scenes and starts whose derivatives are not known.
    fn of(
        model: &dyn Model,
        (problem, run): (&InitialValueProblem, &Simulation),
        names: &[String],
    ) -> Result<Self, InputError> {
        let (rows, trajectory) = (joint_rows(model), &run.trajectory);
        let mut reduced = None;
        let first = trajectory.q.first().zip(trajectory.v.first());
        if let Some((q, v)) = first.filter(|_| rows > 0) {
            let closed = InitialValueProblem {
                q: q.clone(),
                v: v.clone(),
                ..problem.clone()
            };
            let mut joints = Joints::with_rows(model, (0..rows).collect());
            let held = joints.independent_rows(&closed.input(model));
            let held = held.map_err(|_| InputError::new("the start does not fulfil the joints"))?;
            reduced = (held.len() < rows).then(|| {
                let mut reduced = model.boxed();
                for row in 0..rows {
                    reduced.hold_joint_row(row, held.contains(&row));
                }
                reduced
            });
        }
        let scene = reduced.as_deref().unwrap_or(model);
        let quantities = Quantities::of(scene, names)?;
        Ok(Self {
            start: start(scene, problem, &quantities)?,
            quantities,
            reduced,
        })
    }

    fn model<'m>(&'m self, model: &'m dyn Model) -> &'m dyn Model {
        self.reduced.as_deref().unwrap_or(model)
    }
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
    let known = Known::of(model, (problem, run), names)?;
    let model = known.model(model);
    let mut observed = Observed {
        values: Vec::new(),
        by: Vec::new(),
        obstacle: Some("there is no motion".to_owned()),
    };
    if run.trajectory.time.is_empty() {
        return Ok(observed);
    }
    let quantities = &known.quantities;
    let begin = (known.start.clone(), &quantities.names[..]);
    let Some(mut walk) = Walk::new(model, (problem, run), quantities, begin) else {
        return Ok(observed);
    };
    walk.samples = Some(Samples::new(measured, times));
    walk.run();
    observed.obstacle = walk.existence.lost.iter().flatten().next().cloned();
    if let Some(samples) = walk.observed() {
        (observed.values, observed.by) = (samples.values, samples.by);
    }
    if observed.by.len() == times.len() {
        // What happens behind the last measurement is not seen.
        observed.obstacle = None;
    }
    Ok(observed)
}
