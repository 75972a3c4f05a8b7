//! The method: Newton's method on barrier problems, with a filter line search and a restoration phase.
//!
//! [`State`] holds the point and the memory of all parts; each part is a function of it, in a file of its own:
//!
//! ```text
//!     main_loop -> parameters -> direction -> line_search -> step      where no step is found: rescue, restoration
//!                  (barrier)                  (second_order_correction, trial, acceptance, filter)
//! ```

mod acceptance;
pub(crate) mod barrier;
mod direction;
mod filter;
mod last_word;
mod line_search;
mod main_loop;
mod parameters;
mod polish;
mod rescue;
mod restoration;
mod saddle;
mod safeguard;
mod second_order_correction;
mod start;
mod state;
mod step;
mod stop;
mod trial;

pub(super) use last_word::LARGEST_CURVATURE;
pub(super) use state::{Core, End};

use super::program::barrier_problem::BarrierProblem;
use super::{Fault, InputError, Products, WarmStart};
use barrier::BarrierPath;
use state::State;

/// Runs the method from the start of the formulation, or with the multipliers of `start`.
///
/// # Errors
/// [`InputError`] names a function that has no value at the start.
pub(super) fn run(
    core: &mut Core<'_, '_>,
    path: &mut dyn BarrierPath,
    start: Option<&WarmStart>,
    products: &Products,
) -> Result<End, InputError> {
    let (end, stays) = run_once(core, path, start, products)?;
    if !stays {
        return Ok(end);
    }
    saddle::perturb(&mut core.formulation);
    match run_once(core, path, None, products) {
        Ok((other, _)) if saddle::is_better(&other, &end) => Ok(other),
        // also where the functions have no value beside the start
        _ => {
            core.violation_stationarity = None;
            Ok(end)
        }
    }
}

/// A run, and whether it ends where it began at a point that is no minimum.
fn run_once(
    core: &mut Core<'_, '_>,
    path: &mut dyn BarrierPath,
    start: Option<&WarmStart>,
    products: &Products,
) -> Result<(End, bool), InputError> {
    let main = BarrierProblem::main(&core.formulation);
    let mut state = State::new(core, main, path, false);
    start::first_point(&mut state);
    if !state.evaluate_iterate() {
        let what = start::not_finite(&state);
        return Err(InputError::from(Fault::NotFiniteAtStart { what }));
    }
    start::first_multipliers(&mut state, start, products);
    state.start_filter();
    let outcome = main_loop::run(&mut state, None);
    let outcome = last_word::last_word(&mut state, outcome);
    // a start with multipliers was chosen with care
    let stays = start.is_none() && saddle::stays(&mut state, &outcome);
    let end = End {
        outcome,
        objective: state.point.values.objective,
        iterate: state.point.iterate,
        mu: state.mu,
        sigma: state.sigma,
    };
    Ok((end, stays))
}

/// Steps of the variables from a point of a central path to its end; `None` where the path is not that of a convex neighbourhood.
pub(super) fn end_of_path(core: &mut Core<'_, '_>, start: &WarmStart) -> Option<Vec<f64>> {
    let main = BarrierProblem::main(&core.formulation);
    let mut path = barrier::Monotone {
        mu: start.barrier_parameter,
        sigma: 0.0,
        tolerance: core.settings.tolerance,
    };
    let mut state = State::new(core, main, &mut path, false);
    start::first_point(&mut state);
    if !state.evaluate_iterate() {
        return None;
    }
    start::first_multipliers(&mut state, Some(start), &Products::default());
    state.evaluate_first_derivatives();
    state.update_lagrangian();
    if !direction::find_end_of_path(&mut state) {
        return None;
    }
    let mut steps = vec![0.0; start.x.len()];
    let formulation = &state.core.formulation;
    for (&user, d) in formulation.variables.iter().zip(&state.work.direction.v) {
        steps[user] = *d;
    }
    Some(steps)
}
