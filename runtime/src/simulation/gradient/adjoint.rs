//! Derivatives of a few values at the end of a motion, or of times of its events, by many quantities, backwards.
//!
//! A value at the end is linear in the derivatives of the state there, those are linear in the ones before, and so on: what
//! forward sensitivities multiply from the right, by a column a quantity, is multiplied here from the left, by a row a value. Steps
//! are the transposes of the same collocation with the same factors ([`Arc::back`](super::arc::Arc::back)), events those of the
//! same jumps. So both ways give the same numbers up to rounding, and the backward one costs the same for one quantity and for a
//! thousand.
//!
//! One direction of all quantities is carried forward on the way. What has no derivative is found by it, and the derivative along
//! it has to be what the rows give: where it is not, there is no answer, and forward sensitivities are taken.

use super::front::start;
use super::matrix::add;
use super::tape::Tape;
use super::walk::{End, Walk};
use super::wanted::Wanted;
use crate::model::Model;
use crate::simulation::{InitialValueProblem, Simulation};

/// Share of the sum of its terms by which a derivative may differ forwards and backwards: rounding, grown along the motion.
const ROUNDING: f64 = 1e-8;
/// Steps of the shares of quantities in the direction that is carried forward: the golden ratio, whose multiples keep apart.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// A value at the end of a motion, or the time of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Value {
    /// The objective that the scene declares.
    Objective,
    /// Component of `(q, v)`.
    State(usize),
    /// Output, by its index.
    Output(usize),
    /// Time of an event, by its place among all events.
    EventTime(usize),
}

impl Value {
    /// Its row; none where the objective has no derivatives.
    pub(super) fn of(self, end: &End) -> Option<&[f64]> {
        match self {
            Self::Objective => end.objective.as_deref(),
            Self::State(i) => Some(end.state.row(i)),
            Self::Output(i) => Some(end.outputs.row(i)),
            Self::EventTime(i) => end.event_times.get(i).map(Vec::as_slice),
        }
    }
}

/// Derivatives of some values, a row a value; none where there are none or they cannot be had backwards.
pub(super) fn adjoint(
    model: &dyn Model,
    (problem, run): (&InitialValueProblem, &Simulation),
    asked: &Wanted,
    values: impl Iterator<Item = Value>,
) -> Option<Vec<Vec<f64>>> {
    let changes = Tape::present_changes(model);
    let lean = asked.without_parameters(model)?;
    let shares = shares(asked.count(), |k| asked.size(k, model, problem));
    let (direction, present) = (asked.along_direction(shares.clone()), asked.behind(changes));
    let mut walk = Walk::new(model, problem, run, &direction)?;
    walk.at.asked = asked;
    walk.tape = Some(Tape::new(model, (asked, &present), &lean));
    walk.run().ok()?;
    let forward = walk.end();
    let tape = walk.tape.take()?;
    walk.at.front = tape.present();
    let end = walk.end();
    let at_start = start(model, problem, asked);
    let row = |value: Value| {
        let (behind, mut covector) = match value {
            Value::EventTime(event) => tape.at_event(event)?,
            _ => {
                let cost = f64::from(u8::from(value == Value::Objective));
                tape.at_end(value.of(&end)?, cost)
            }
        };
        tape.back(&walk.at.arc, behind, &mut covector);
        for (i, factor) in covector.state.iter().enumerate() {
            add(&mut covector.by, *factor, at_start.row(i));
        }
        let terms = || {
            covector
                .by
                .iter()
                .zip(&shares)
                .map(|(by, share)| by * share)
        };
        let size: f64 = terms().map(f64::abs).sum();
        let same = (terms().sum::<f64>() - value.of(&forward)?[0]).abs() <= ROUNDING * size;
        same.then_some(covector.by)
    };
    values.map(row).collect()
}

/// Shares of quantities of these sizes in one direction, which no relation between them is likely to have.
fn shares(count: usize, size: impl Fn(usize) -> f64) -> Vec<f64> {
    let quantities = 0..count;
    quantities
        .map(|k| size(k) * (0.5 + ((k + 1) as f64 * GOLDEN).fract()))
        .collect()
}
