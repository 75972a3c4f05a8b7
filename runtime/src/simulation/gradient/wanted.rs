//! What a motion is differentiated by.

use crate::InputError;
use crate::model::{Model, ParameterDerivatives};
use crate::simulation::InitialValueProblem;
use crate::simulation::quantity::Quantity;

/// One quantity that a motion is differentiated by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum By {
    /// The parameter that is the `k`-th of those with derivatives.
    Parameter(usize),
    /// Component `k` of the initial `(q, v)`.
    Start(usize),
    /// Control `k`, changed by the same at all times.
    Control(usize),
}

/// The quantities, and the derivatives of the scene by them.
pub(super) struct Wanted {
    pub(super) names: Vec<String>,
    by: Vec<By>,
    pub(super) derivatives: Box<dyn ParameterDerivatives>,
    /// Length of the input vector.
    inputs: usize,
    /// Number of coordinates.
    n: usize,
    /// Number of parameters with derivatives.
    pub(super) parameters: usize,
}

/// The name that stands for all parameters.
const ALL: &str = "all";

impl Wanted {
    /// Finds the quantities of these names.
    pub(super) fn of(model: &dyn Model, names: &[String]) -> Result<Self, InputError> {
        let declaration = model.declaration();
        let mut wanted: Vec<String> = Vec::with_capacity(names.len());
        for name in names {
            if name == ALL {
                let all = declaration.parameters.iter();
                wanted.extend(all.map(|known| known.name.to_owned()));
            } else {
                wanted.push(name.clone());
            }
        }
        let position = |name: &str| declaration.parameters.iter().position(|p| p.name == name);
        let mut parameters: Vec<usize> = wanted.iter().filter_map(|name| position(name)).collect();
        parameters.sort_unstable();
        parameters.dedup();
        let mut by = Vec::with_capacity(wanted.len());
        for (index, name) in wanted.iter().enumerate() {
            if wanted[..index].contains(name) {
                return Err(InputError::new(format!(
                    "the gradient by `{name}` is asked for twice; name it once"
                )));
            }
            let parameter = position(name).and_then(|p| parameters.binary_search(&p).ok());
            by.push(match parameter {
                Some(parameter) => By::Parameter(parameter),
                None => of_state(model, name)?,
            });
        }
        let remedy = "take differences of two simulations, or write a smooth function in its place, as `tanh(c/width)`";
        InitialValueProblem::check_switches(model, "gradients", remedy)?;
        let remedy = "take differences of two simulations, or give the contact one coefficient and a bound of positions";
        InitialValueProblem::check_friction(model, "gradients", remedy)?;
        if by.is_empty() {
            return Err(InputError::new(
                "a gradient by nothing is asked for; name parameters, coordinates for their start, or `all` parameters",
            ));
        }
        // Nothing else knows how normals and curvatures of contacts change along the motion.
        if parameters.is_empty() && !declaration.parameters.is_empty() {
            parameters.push(0);
        }
        let derivatives = model.parameter_derivatives(&parameters).ok_or_else(|| {
            InputError::unsupported(format!(
                "a gradient of `{}` is not supported: its derivatives by parameters are not compiled, or too large; read the \
                 scene from a file or a text (`hangtime_scene_files::of_text`)",
                declaration.name
            ))
        })?;
        Ok(Self {
            names: wanted,
            by,
            derivatives,
            inputs: declaration.inputs(),
            n: declaration.coordinates.len(),
            parameters: parameters.len(),
        })
    }

    /// How many quantities there are.
    pub(super) fn count(&self) -> usize {
        self.by.len()
    }

    /// Number of columns of the derivatives: the input vector and the parameters.
    pub(super) fn columns(&self) -> usize {
        self.inputs + self.parameters
    }

    /// The column of the derivatives that belongs to quantity `k`; none to an initial value.
    pub(super) fn column(&self, k: usize) -> Option<usize> {
        match self.by[k] {
            By::Parameter(parameter) => Some(self.inputs + parameter),
            By::Control(control) => Some(2 * self.n + control),
            By::Start(_) => None,
        }
    }

    /// The place of quantity `k` among the parameters with derivatives, if it is one.
    pub(super) fn parameter(&self, k: usize) -> Option<usize> {
        match self.by[k] {
            By::Parameter(parameter) => Some(parameter),
            By::Control(_) | By::Start(_) => None,
        }
    }

    /// The place of quantity `k` among the controls, if it is one.
    pub(super) fn control(&self, k: usize) -> Option<usize> {
        match self.by[k] {
            By::Control(control) => Some(control),
            By::Parameter(_) | By::Start(_) => None,
        }
    }

    /// Derivative of component `i` of the initial `(q, v)` by quantity `k`, if the start is that of the scene.
    pub(super) fn of_start(&self, start: &[f64], i: usize, k: usize, declared: bool) -> f64 {
        match self.by[k] {
            By::Parameter(parameter) if declared => start[i * self.parameters + parameter],
            By::Start(component) if component == i => 1.0,
            _ => 0.0,
        }
    }

    /// Derivatives of the horizon, if that is the one of the scene.
    pub(super) fn of_horizon(&self, model: &dyn Model, problem: &InitialValueProblem) -> Vec<f64> {
        let mut by_parameters = vec![0.0; self.parameters];
        if model.horizon() == Some(problem.horizon) {
            self.derivatives.horizon(&mut by_parameters);
        }
        let columns = 0..self.count();
        columns
            .map(|k| self.parameter(k).map_or(0.0, |p| by_parameters[p]))
            .collect()
    }
}

/// An initial value or a control of this name.
fn of_state(model: &dyn Model, name: &str) -> Result<By, InputError> {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    match Quantity::named(declaration, &[], name) {
        Some(Quantity::Coordinate(k)) => Ok(By::Start(k)),
        Some(Quantity::Velocity(k)) => Ok(By::Start(n + k)),
        Some(Quantity::Control(k)) => Ok(By::Control(k)),
        _ => {
            let parameters = declaration.parameters.iter().map(|p| p.name.to_owned());
            let starts = declaration.coordinates.iter();
            let starts = starts.flat_map(|c| [c.name.to_owned(), format!("dot({})", c.name)]);
            let controls = declaration.controls.iter().map(|u| u.name.to_owned());
            let known: Vec<String> = parameters.chain(starts).chain(controls).collect();
            Err(InputError::new(format!(
                "no gradient of `{}` by `{name}`: it has no parameter, coordinate or control of this name (it has: {}; `all` \
                 stands for all parameters)",
                declaration.name,
                known.join(", ")
            )))
        }
    }
}
