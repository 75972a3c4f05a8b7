//! Free parameters as unknowns: the scene with these as coordinates without motion, and its solution as one of the scene itself.
//!
//! A parameter is one variable of each program: the stages of a motion read the one at its start, and it has no rows. So it joins all
//! intervals like the final time does.

use crate::derivative::SequenceRange;
use crate::model::{Given, Model, held};
use crate::ocp::parameters::{FoundParameter, OptimumGradient};
use crate::ocp::problem::{Horizon, Problem};
use crate::ocp::settings::Settings;
use crate::ocp::solution::{Solution, Status};
use crate::refusal;
use crate::scene::TextScene;
use crate::simulation::InputError;

/// A free parameter (index) and its range.
type Free = (usize, (f64, f64));

/// A problem with free parameters.
pub(in crate::ocp) struct Unknown<'a> {
    /// The scene as it was given.
    scene: &'a dyn Model,
    /// The scene with its free parameters as coordinates.
    pub(in crate::ocp) model: TextScene,
    pub(in crate::ocp) problem: Problem,
    /// The parameters (indices) that are coordinates in it.
    held: Vec<usize>,
    /// The free ones among them with their ranges.
    free: Vec<Free>,
    /// Those that it is differentiated by, in the order that was asked for.
    gradient: Vec<usize>,
}

/// The problem with free parameters as unknowns, and with those that it is differentiated by as variables; `None` where there are
/// none.
pub(in crate::ocp) fn with_unknowns<'a>(
    scene: &'a dyn Model,
    problem: &Problem,
    settings: &Settings,
) -> Result<Option<Unknown<'a>>, InputError> {
    let free = free_parameters(scene, settings)?;
    let mut indices: Vec<usize> = free.iter().map(|free| free.0).collect();
    indices.extend(&settings.gradient);
    indices.sort_unstable();
    indices.dedup();
    let asks = !indices.is_empty()
        || !scene.structure().remembered.is_empty()
        || !scene.structure().epigraphs.is_empty();
    if !asks {
        return Ok(None);
    }
    let model = scene.with_held(&indices).map_err(InputError::unsupported)?;
    let problem = extended(scene, problem, &indices, &model);
    check_laws(&model, &problem)?;
    Ok(Some(Unknown {
        scene,
        model,
        problem,
        held: indices,
        free,
        gradient: settings.gradient.clone(),
    }))
}

/// Laws whose coefficients are unknowns begin with one above 0: a contact that neither bounces nor rubs has no equation that would
/// tell how it does.
fn check_laws(model: &dyn Model, problem: &Problem) -> Result<(), InputError> {
    let Some(known) = model.held() else {
        return Ok(());
    };
    let contacts = model.declaration().contacts;
    let values = held::given_at(model, &problem.start());
    for (given, value) in known.given.iter().zip(values) {
        let (what, contact) = match *given {
            Given::Restitution(contact) => ("restitution", contact),
            Given::Friction(contact) => ("friction", contact),
            Given::Start(_) | Given::Horizon => continue,
        };
        if value <= 0.0 {
            return Err(refusal::out_of_range(
                format!(
                    "{what} of `{}`, which depends on a parameter that is an unknown,",
                    contacts[contact].name
                ),
                value,
                "",
                "above 0 where it begins",
            ));
        }
    }
    Ok(())
}

/// The free parameters (indices) that are to be found, with their ranges.
fn free_parameters(scene: &dyn Model, settings: &Settings) -> Result<Vec<Free>, InputError> {
    let declared = scene.free_parameters();
    let (mut lower, mut upper) = (vec![0.0; declared.len()], vec![0.0; declared.len()]);
    scene.free_parameter_bounds(&mut lower, &mut upper);
    let ranges = lower.into_iter().zip(upper);
    let mut free = Vec::new();
    for (&index, (lower, upper)) in declared.iter().zip(ranges) {
        let (value, known) = (
            scene.parameter(index),
            &scene.declaration().parameters[index],
        );
        if settings.gradient.contains(&index) {
            return Err(refusal::unsupported(
                format!(
                    "the derivative of an optimum by the free parameter `{}`, where it vanishes or presses against a bound,",
                    known.name
                ),
                format!(
                    "declare it in `parameters {{ {} = ... }}`, or leave it out",
                    known.name
                ),
            ));
        }
        if settings.given_parameters.contains(&index) {
            continue;
        }
        if !(lower..=upper).contains(&value) {
            return Err(refusal::out_of_range(
                format!("free parameter `{}`", known.name),
                value,
                known.unit,
                format!("within its range {lower}..={upper}"),
            ));
        }
        free.push((index, (lower, upper)));
    }
    Ok(free)
}

/// The problem with parameters at the end of the coordinates; a horizon that depends on them is an unknown.
fn extended(
    scene: &dyn Model,
    problem: &Problem,
    parameters: &[usize],
    model: &dyn Model,
) -> Problem {
    let mut problem = problem.clone();
    let values = parameters.iter().map(|&index| scene.parameter(index));
    let start = problem.start();
    let remembered = scene.structure().remembered.iter().map(|&k| start[k]);
    problem.q.extend(values.chain(remembered));
    let largest = model.held().map_or(0, |held| held.largest);
    problem.q.resize(problem.q.len() + largest, 0.0);
    problem.v.resize(problem.q.len(), 0.0);
    if let Horizon::Fixed(horizon) = problem.horizon
        && held::place(model, Given::Horizon).is_some()
        && scene.horizon() == Some(horizon)
    {
        problem.horizon = Horizon::Free {
            guess: Some(horizon),
        };
    }
    problem
}

impl Unknown<'_> {
    /// What is said of derivatives of a solution with that status that has none.
    fn no_gradient(&self, status: Status) -> OptimumGradient {
        let declared = self.scene.declaration().parameters;
        let count = self.gradient.len();
        let status = status.name();
        let why = format!("the search left no plan with multipliers, it ended as {status}");
        OptimumGradient {
            parameters: self.gradient.clone(),
            names: self.gradient.iter().map(|&i| declared[i].name).collect(),
            objective: vec![f64::NAN; count],
            obstacles: vec![Some(why); count],
            sides: vec![None; count],
            final_time: vec![None; count],
            ranges: vec![SequenceRange::default(); count],
        }
    }

    /// A solution of the problem as one of the scene with the values that were found.
    pub(in crate::ocp) fn of_scene(&self, mut solution: Solution) -> Solution {
        let n = self.scene.declaration().coordinates.len();
        if !self.gradient.is_empty() {
            let status = solution.status;
            let gradient = solution.gradient;
            let mut gradient = gradient.unwrap_or_else(|| self.no_gradient(status));
            gradient.reorder(&self.gradient);
            solution.gradient = Some(gradient);
        }
        let Some(motion) = &mut solution.motion else {
            return solution;
        };
        let Some(start) = motion.trajectory.q.first() else {
            return solution;
        };
        let mut scene = self.scene.boxed();
        let declared = scene.declaration().parameters;
        let found = self.held.iter().zip(&start[n..]);
        solution.parameters = found
            .filter_map(|(&index, &value)| {
                let &(_, range) = self.free.iter().find(|free| free.0 == index)?;
                scene.set_parameter(index, value);
                Some(FoundParameter {
                    index,
                    name: declared[index].name,
                    value,
                    unit: declared[index].unit,
                    range,
                })
            })
            .collect();
        let controls = scene.declaration().controls.len();
        let own = solution.controls.iter_mut();
        own.for_each(|controls_then| controls_then.truncate(controls));
        motion.leave_held_out(&*scene);
        solution
    }
}

/// The parameter of that name by which an optimum is to be differentiated.
///
/// # Errors
/// [`InputError`] with the names of the parameters if the scene has none of that name.
pub fn parameter_named(model: &dyn Model, name: &str) -> Result<usize, InputError> {
    let parameters = model.declaration().parameters;
    let found = parameters.iter().position(|known| known.name == name);
    found.ok_or_else(|| {
        let names: Vec<&str> = parameters.iter().map(|known| known.name).collect();
        refusal::unsupported(
            format!("the derivative of an optimum by `{name}`, which is no parameter,"),
            format!("name one of: {}", names.join(", ")),
        )
    })
}
