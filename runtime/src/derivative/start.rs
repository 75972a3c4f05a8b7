//! Derivatives of the start of a motion, which joints complete.
//!
//! Where joints move a start onto what they hold, what they move it to is a smooth function of the guess and of the parameters: an algebraic
//! one, that needs no motion. Its derivatives are differences of sixth order,
//!
//! ```text
//! f' = (45 (f_1 - f_-1) - 9 (f_2 - f_-2) + (f_3 - f_-3)) / (60 h)
//! ```
//!
//! with an error of `h^6` and rounding over `h`. Where the start fulfils them as it is given, they are those of a step of Newton's method
//! ([`JointRows::project`](super::joint_rows::JointRows::project)), which the walk takes at its first instant.

use super::quantities::Quantities;
use super::tangent::Tangent;
use crate::InputError;
use crate::model::Model;
use crate::simulation::{ClosedStart, InitialValueProblem};
use crate::yardstick;

/// Step of the differences, as a share of the quantity: `h^6` and the rounding of double precision over it are alike.
const STEP: f64 = 2e-3;
/// Weights of the differences, over the step.
const WEIGHTS: [(f64, f64); 3] = [(1.0, 0.75), (2.0, -0.15), (3.0, 1.0 / 60.0)];

/// Derivatives at the start of a motion of the scene from `problem`.
///
/// # Errors
/// [`InputError`] where neighbours of the start cannot be completed.
pub(super) fn start(
    model: &dyn Model,
    problem: &InitialValueProblem,
    quantities: &Quantities,
) -> Result<Tangent, InputError> {
    let mut start = quantities.start(model, problem);
    if model.declaration().joints.is_none() {
        return Ok(start);
    }
    let own = completed(model, problem)?;
    let given: Vec<f64> = problem.q.iter().chain(&problem.v).copied().collect();
    let n = problem.q.len();
    let moves = |range: std::ops::Range<usize>| {
        let size = |values: &[f64]| values.iter().fold(0.0_f64, |most, x| x.abs().max(most));
        let least = yardstick::NOTHING * size(&own[range.clone()]).max(size(&given[range.clone()]));
        let mut pairs = own[range.clone()].iter().zip(&given[range]);
        pairs.any(|(own, given)| (own - given).abs() > least)
    };
    if !moves(0..n) && !moves(n..2 * n) {
        return Ok(start);
    }
    let sizes = quantities.sizes(model, problem);
    for (column, size) in sizes.iter().enumerate() {
        let by = differences(*size, &mut |way| {
            let (scene, guess) = quantities.by[column].moved(model, problem, way);
            completed(&*scene, &guess)
        })?;
        for (i, by) in by.into_iter().enumerate() {
            start.all.row_mut(i)[column] = by;
        }
    }
    Ok(start)
}

/// Derivatives of smooth values, at 0, by a quantity of this size that may be changed.
///
/// # Errors
/// Those of the values.
pub(crate) fn differences(
    size: f64,
    values: &mut dyn FnMut(f64) -> Result<Vec<f64>, InputError>,
) -> Result<Vec<f64>, InputError> {
    let step = STEP * size;
    let mut by = Vec::new();
    for (way, weight) in WEIGHTS {
        for sense in [1.0, -1.0] {
            let values = values(sense * way * step)?;
            by.resize(values.len(), 0.0);
            for (by, value) in by.iter_mut().zip(values) {
                *by += sense * weight / step * value;
            }
        }
    }
    Ok(by)
}

/// The start `(q, v)` that joints complete.
///
/// # Errors
/// [`InputError`] where they do not.
pub(crate) fn completed(
    model: &dyn Model,
    problem: &InitialValueProblem,
) -> Result<Vec<f64>, InputError> {
    let closed = ClosedStart::of(model, problem)?;
    let (_, problem) = closed.scene();
    Ok(problem.q.iter().chain(&problem.v).copied().collect())
}
