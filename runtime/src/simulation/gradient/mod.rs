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
//! `walk` goes along a motion that a simulator has found, `outputs` differentiates what is recorded, `wanted` knows by what.

mod acceleration;
mod arc;
mod cause;
mod cost;
mod jump;
mod matrix;
mod outputs;
mod projection;
mod samples;
mod sides;
mod walk;
mod wanted;

use super::{InitialValueProblem, InputError, Simulation, joints};
use crate::model::{Measured, Model};
use samples::Samples;
pub use sides::{OneSided, Side};
use walk::Walk;
use wanted::Wanted;

/// Derivatives of a simulated motion.
///
/// Every matrix has a row for each value that is differentiated, and a column for each of the quantities in
/// [`with_respect_to`](Self::with_respect_to). Units are those of the value over those of the quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    /// Names of what the motion is differentiated by: parameters; coordinates `z` and `dot(z)` for their initial values; and
    /// controls, for adding the same at all times.
    pub with_respect_to: Vec<String>,
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
    refuse_joints(model)?;
    let wanted = Wanted::of(model, names)?;
    let trajectory = &run.trajectory;
    let (n, columns) = (problem.q.len(), wanted.count());
    let unknown = || vec![vec![f64::NAN; columns]; n];
    let mut gradient = Gradient {
        with_respect_to: wanted.names.clone(),
        q: unknown(),
        v: unknown(),
        event_times: vec![vec![f64::NAN; columns]; run.events.len()],
        states: vec![vec![vec![f64::NAN; columns]; 2 * n]; trajectory.time.len()],
        outputs: vec![vec![vec![f64::NAN; columns]; trajectory.time.len()]; model.outputs().len()],
        objective: None,
        obstacle: None,
        one_sided: None,
    };
    if !run.status.is_solved() {
        gradient.obstacle = Some(format!(
            "the motion is not known to its end: {}",
            run.status
        ));
        return Ok(gradient);
    }
    let walk = Walk::new(model, problem, run, &wanted);
    let Some(mut walk) = walk.filter(|_| !trajectory.time.is_empty()) else {
        gradient.obstacle = Some("there is no motion".to_owned());
        return Ok(gradient);
    };
    match walk.run() {
        Ok(()) => {
            let (end, objective) = walk.end();
            gradient.objective = objective;
            (gradient.q, gradient.v) = (end.rows(0..n), end.rows(n..2 * n));
        }
        Err(why) => gradient.obstacle = Some(why),
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
    Ok(gradient)
}

/// Derivatives along equations of joints are not known.
fn refuse_joints(model: &dyn Model) -> Result<(), InputError> {
    joints::refuse(
        model,
        "derivatives of a motion",
        "compare two motions, or describe the mechanism by coordinates that need no joint",
    )
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
    refuse_joints(model)?;
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
