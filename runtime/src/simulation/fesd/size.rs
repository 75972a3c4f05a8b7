//! What a step of the simulation takes, before any is made.

use super::settings::{Fesd, StepFormulation};
use crate::contact::{ActiveContact, ContactState};
use crate::fesd::finite_element::groups as groups_of_element;
use crate::model::{Model, friction_coefficients};
use crate::rk::ButcherTableau;
use crate::simulation::joints::Closed;
use crate::simulation::{FormulationSize, InitialValueProblem, InputError};
use crate::size::kernels;

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
/// assert_eq!(sizes[0].size().variables, 6);
/// let mut groups = sizes[1].groups.iter();
/// let forces = groups.find(|group| group.name == "contact force");
/// assert_eq!(forces.map(|group| group.size.variables), Some(6));
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
    Ok(elements(model, problem, method, &tableau))
}

/// The elements of the modes in which at most one contact holds, and of that in which all do.
fn elements(
    model: &dyn Model,
    problem: &InitialValueProblem,
    method: &Fesd,
    tableau: &ButcherTableau,
) -> Vec<FormulationSize> {
    let declaration = model.declaration();
    let friction = friction_coefficients(model);
    let held = |contact, state| ActiveContact { contact, state };
    let across = |i: usize| {
        declaration.contacts[i]
            .friction
            .and_then(|known| known.across)
    };
    let resting = |i: usize| match (friction[i] > 0.0, across(i)) {
        (true, across) => held(i, ContactState::sticking(across.is_some())),
        (false, _) => held(i, ContactState::Frictionless),
    };
    let contacts = declaration.contacts.iter().enumerate();
    let mut modes = vec![("free flight".to_owned(), Vec::new())];
    for (i, contact) in contacts {
        let name = contact.name;
        if friction[i] > 0.0 {
            let slips = vec![held(i, ContactState::slip(1.0))];
            modes.push((format!("`{name}` slips"), slips));
            modes.push((format!("`{name}` sticks"), vec![resting(i)]));
        } else {
            modes.push((format!("`{name}` holds"), vec![resting(i)]));
        }
    }
    if declaration.contacts.len() > 1 {
        let all = (0..declaration.contacts.len()).map(resting).collect();
        modes.push(("all contacts hold".to_owned(), all));
    }
    let numerical = method.formulation == StepFormulation::TimeFreezing;
    let time = if numerical {
        "time-freezing element"
    } else {
        "element"
    };
    let stages = tableau.stages();
    let x = problem.input(model);
    let sizes = modes.into_iter().map(|(name, active)| {
        let mut prefixes = vec!["free_", "gap_", "contact_"];
        if declaration.joints.is_some() {
            prefixes.push("joints");
        }
        if active.iter().any(|held| held.state.rubs()) {
            prefixes.push("tangent_");
            prefixes.push("across_");
        }
        let mut called = kernels(declaration, &prefixes, false);
        if active.is_empty() {
            called.retain(|kernel| !kernel.name.starts_with("contact_jacobian_"));
        }
        FormulationSize {
            formulation: format!("simulation, {time}, {name}"),
            discretization: format!("{}, {stages} stages", method.scheme.name()),
            groups: groups_of_element(model, &active, stages, numerical, &x),
            kernels: called,
        }
    });
    sizes.collect()
}
