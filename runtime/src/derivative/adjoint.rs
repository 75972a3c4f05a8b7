//! Derivatives of a few values at the end of a motion, or of times of its events, by many quantities, backwards.
//!
//! A value at the end is linear in the derivatives of the state there, those are linear in the ones before, and so on: what
//! forward sensitivities multiply from the right, by a column a quantity, is multiplied here from the left, by a row a value. Steps
//! are the transposes of the same collocation with the same factors ([`Steps::back`](super::step::Steps::back)), events those of the
//! same jumps. So both ways give the same numbers up to rounding, and the backward one costs the same for one quantity and for a
//! thousand.
//!
//! One direction of all quantities is carried forward on the way. What has no derivative is found by it, and the derivative along
//! it has to be what the rows give: where it is not, there is no answer, and forward sensitivities are taken.

use super::quantities::Quantities;
use super::step::Steps;
use super::tangent::{Tangent, add};
use super::tape::Tape;
use super::walk::{End, Walk};
use crate::linalg::products::dot;
use crate::model::Model;
use crate::simulation::{InitialValueProblem, Simulation};
use crate::yardstick;

/// Share of the sum of its terms by which a derivative may differ forwards and backwards: rounding, grown along the motion.
const ROUNDING: f64 = 1e-8;
/// Steps of the shares of quantities in the direction that is carried forward: the golden ratio, whose multiples keep apart.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Stages of the coarser steps that tell the error: few enough that what their order takes away is far above rounding. Chosen.
const COARSE: usize = 5;
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
    /// Its row; `None` where the objective has no derivatives.
    pub(super) fn of<'e>(self, end: &'e End, event_times: &'e [Vec<f64>]) -> Option<&'e [f64]> {
        match self {
            Self::Objective => end.objective.as_deref(),
            Self::State(i) => Some(end.tangent.all.row(i)),
            Self::Output(i) => Some(end.outputs.row(i)),
            Self::EventTime(i) => event_times.get(i).map(Vec::as_slice),
        }
    }
}

/// Derivatives of some values, a row a value; `None` where there are none or they cannot be had backwards.
pub(super) fn adjoint(
    model: &dyn Model,
    motion: (&InitialValueProblem, &Simulation),
    (quantities, start): (&Quantities, &Tangent),
    values: impl Iterator<Item = Value>,
) -> Option<Vec<Vec<f64>>> {
    let layout = start.layout;
    let shares = shares(&quantities.sizes(model, motion.0));
    let mut walk = along(model, motion, (quantities, start), &shares)?;
    walk.tape = Some(Tape::default());
    if !walk.run() {
        return None;
    }
    let end = walk.end();
    let tape = walk.tape.take()?;
    let row = |value: Value| {
        // The first column is the one direction.
        let (forward, by) = value.of(&end, &walk.event_times)?.split_first()?;
        let event = match value {
            Value::EventTime(event) => Some(event),
            _ => None,
        };
        let covector = tape.back(&walk.at.steps, layout, (by, event))?;
        let mut by = vec![0.0; quantities.count()];
        for (i, factor) in covector.iter().enumerate() {
            add(&mut by, *factor, start.all.row(i));
        }
        let size: f64 = by
            .iter()
            .zip(&shares)
            .map(|(by, share)| (by * share).abs())
            .sum();
        ((dot(&by, &shares) - forward).abs() <= ROUNDING * size).then_some(by)
    };
    values.map(row).collect()
}

/// How far derivatives of `values`, a row each, are off along one direction of those quantities by which there are all, as a share of the sum of
/// the sizes of their terms, if that is seen in the value: by where coarser steps lead. `None` where these lead nowhere.
pub(super) fn error<'v>(
    model: &dyn Model,
    motion: (&InitialValueProblem, &Simulation),
    (quantities, start): (&Quantities, &Tangent),
    values: impl Iterator<Item = (Value, &'v [f64])> + Clone,
) -> Option<f64> {
    let mut shares = shares(&quantities.sizes(model, motion.0));
    for (k, share) in shares.iter_mut().enumerate() {
        if values.clone().any(|(_, by)| !by[k].is_finite()) {
            *share = 0.0;
        }
    }
    let mut walk = along(model, motion, (quantities, start), &shares)?;
    walk.at.steps = Steps::of(COARSE)?;
    if !walk.run() {
        return None;
    }
    let end = walk.end();
    let off = values.map(|(value, by)| {
        let terms = by.iter().zip(&shares).filter(|(_, share)| **share > 0.0);
        let terms = terms.map(|(by, share)| by * share);
        let size: f64 = terms.clone().map(f64::abs).sum();
        let least = match value {
            Value::State(i) => walk.at.sizes[i / start.layout.n],
            Value::EventTime(_) => motion.0.horizon,
            Value::Objective | Value::Output(_) => 0.0,
        };
        let coarse = value.of(&end, &walk.event_times)?[0];
        Some((coarse - terms.sum::<f64>()).abs() / size.max(yardstick::PROMISE * least))
    });
    // What is 0 of 0 is exact.
    let off = off
        .collect::<Option<Vec<f64>>>()?
        .into_iter()
        .fold(0.0, f64::max);
    Some(off + motion.1.error_estimate.unwrap_or_default().max(walk.missed))
}

/// A walk with the one direction in which quantities change by these shares.
fn along<'w>(
    model: &'w dyn Model,
    (problem, run): (&'w InitialValueProblem, &'w Simulation),
    (quantities, start): (&Quantities, &Tangent),
    shares: &[f64],
) -> Option<Walk<'w>> {
    let direction = ["one direction of all".to_owned()];
    let begin = (start.along(shares), &direction[..]);
    Walk::new(model, (problem, run), quantities, begin)
}

/// Shares of quantities of these sizes in one direction, which no relation between them is likely to have.
fn shares(sizes: &[f64]) -> Vec<f64> {
    let sizes = sizes.iter().enumerate();
    sizes
        .map(|(k, size)| size * (0.5 + ((k + 1) as f64 * GOLDEN).fract()))
        .collect()
}
