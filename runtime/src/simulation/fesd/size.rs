//! What a step of the simulation takes, before any is made.

use super::settings::{Fesd, StepFormulation};
use crate::contact::{ActiveContact, ContactState};
use crate::fesd::finite_element::size::size;
use crate::fesd::finite_element::{FiniteElement, State, newton};
use crate::model::{ContactDeclaration, ControlPiece, Model, friction_coefficients};
use crate::simulation::joints::Closed;
use crate::simulation::{InitialValueProblem, InputError, ProblemSize};
use serde::Serialize;

/// How far from the start, relative to a coordinate and at least absolute, and multiples that fill the interval from 0 to 1 evenly. Chosen:
/// far above rounding.
const BESIDE: f64 = 1e-3;
const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;

/// The size of one formulation of a scene.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct FormulationSize {
    /// Which formulation.
    pub formulation: String,
    /// On which grid.
    pub discretization: String,
    /// How much.
    pub size: ProblemSize,
}

/// The sizes of the systems that `method` solves on the way over `problem`: an element in free flight, one for each
/// contact that holds (and slips or sticks where it rubs), and one where all hold.
///
/// # Errors
/// [`InputError`] if the problem or the method's settings are refused.
///
/// # Examples
/// ```
/// use hangtime::prelude::*;
/// use hangtime::simulation::{InitialValueProblem, step_sizes};
///
/// # hangtime::model! {
/// #     /// A ball above a floor.
/// #     pub Ball {
/// #         parameters { m: kg = 1, g: m/s^2 = 9.81, height: m = 1 }
/// #         coordinates { z: m }
/// #         lagrangian m/2*dot(z)^2 - m*g*z
/// #         surface floor: z >= 0
/// #         impact floor: inelastic
/// #         start { z: height }
/// #         horizon 1 [s]
/// #     }
/// # }
/// let ball = Ball::default();
/// let sizes = step_sizes(&ball, &InitialValueProblem::of(&ball, None)?, &Fesd::default())?;
/// // Six stages: an acceleration each in flight, a force and a correction of the gap, too, where the floor holds.
/// assert_eq!(sizes[0].size.variables, 6);
/// assert_eq!(sizes[1].size.variables, 6 + 6 + 6);
/// # Ok::<(), InputError>(())
/// ```
pub fn step_sizes(
    model: &dyn Model,
    problem: &InitialValueProblem,
    method: &Fesd,
) -> Result<Vec<FormulationSize>, InputError> {
    let tableau = method.tableau()?;
    let closed = Closed::of(model, problem)?;
    let (model, problem) = closed.scene();
    let declaration = model.declaration();
    let friction = friction_coefficients(model);
    let resting = |(contact, declared): (usize, &ContactDeclaration)| {
        let across = declared.friction.and_then(|friction| friction.across);
        let state = match friction[contact] > 0.0 {
            true => ContactState::sticking(across.is_some()),
            false => ContactState::Frictionless,
        };
        ActiveContact { contact, state }
    };
    let contacts = declaration.contacts;
    let resting: Vec<ActiveContact> = contacts.iter().enumerate().map(resting).collect();
    let mut modes = vec![("free flight".to_owned(), Vec::new())];
    for (held, ContactDeclaration { name, .. }) in resting.iter().zip(contacts) {
        let mut mode = |how, state| {
            let contact = held.contact;
            modes.push((
                format!("`{name}` {how}"),
                vec![ActiveContact { contact, state }],
            ));
        };
        if held.state.rubs() {
            mode("slips", ContactState::slip(1.0));
        }
        mode(
            if held.state.rubs() { "sticks" } else { "holds" },
            held.state,
        );
    }
    if resting.len() > 1 {
        modes.push(("all contacts hold".to_owned(), resting));
    }
    let numerical = method.formulation == StepFormulation::TimeFreezing;
    let time = match numerical {
        true => "time-freezing element",
        false => "element",
    };
    let start = place(problem);
    let mut controls = ControlPiece::default();
    controls.set_constant(declaration.controls.iter().map(|_| 0.0));
    let length = problem.horizon / Fesd::DEFAULT_STEPS as f64;
    let sizes = modes.into_iter().map(|(name, active)| {
        let mut element = FiniteElement::new(model, &tableau);
        if numerical {
            element = element.in_numerical_time(method.auxiliary_acceleration);
        }
        element.set_mode(&active);
        // Where there is no such motion the first matrix is that of its stages.
        let _ = newton::solve(&mut element, &start, length, &controls);
        FormulationSize {
            formulation: format!("simulation, {time}, {name}"),
            discretization: format!("{}, {} stages", method.scheme.name(), tableau.stages()),
            size: size(&mut element),
        }
    });
    Ok(sizes.collect())
}

/// A place beside the start of a problem at which nothing vanishes by chance.
fn place(problem: &InitialValueProblem) -> State {
    let beside = |(k, value): (usize, &f64)| {
        let share = 0.5 + 0.5 * ((k + 1) as f64 * GOLDEN_RATIO).fract();
        value + BESIDE * share * value.abs().max(1.0)
    };
    let all = |values: &[f64]| values.iter().enumerate().map(beside).collect();
    State {
        time: BESIDE,
        q: all(&problem.q),
        v: all(&problem.v),
    }
}
