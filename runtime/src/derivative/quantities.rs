//! What a motion is differentiated by.

use std::sync::Arc;

use super::tangent::{Layout, Tangent};
use crate::InputError;
use crate::model::{Model, ParameterDerivatives};
use crate::simulation::{ControlSignal, InitialValueProblem, Quantity};

/// One quantity that a motion is differentiated by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum By {
    /// A parameter, by its index.
    Parameter(usize),
    /// Component `k` of the initial `(q, v)`.
    Start(usize),
    /// Control `k`, changed by the same at all times.
    Control(usize),
}

impl By {
    /// The quantity of this name.
    pub(super) fn named(model: &dyn Model, name: &str) -> Result<Self, InputError> {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        if let Some(index) = declaration.parameters.iter().position(|p| p.name == name) {
            return Ok(Self::Parameter(index));
        }
        match Quantity::named(declaration, &[], name) {
            Some(Quantity::Coordinate(k)) => Ok(Self::Start(k)),
            Some(Quantity::Velocity(k)) => Ok(Self::Start(n + k)),
            Some(Quantity::Control(k)) => Ok(Self::Control(k)),
            _ => {
                let parameters = declaration.parameters.iter().map(|p| p.name.to_owned());
                let starts = declaration.coordinates.iter();
                let starts = starts.flat_map(|c| [c.name.to_owned(), format!("dot({})", c.name)]);
                let controls = declaration.controls.iter().map(|u| u.name.to_owned());
                let known: Vec<String> = parameters.chain(starts).chain(controls).collect();
                Err(InputError::new(format!(
                    "no gradient of `{}` by `{name}`: it has no parameter, coordinate or control of this name (it has: {}; \
                     `all` stands for all parameters)",
                    declaration.name,
                    known.join(", ")
                )))
            }
        }
    }

    /// Its size: its value, of a control the largest one, or 1 where that is 0.
    pub(super) fn size(self, model: &dyn Model, problem: &InitialValueProblem) -> f64 {
        let value = match self {
            Self::Parameter(index) => model.parameter(index),
            Self::Start(k) => problem
                .q
                .iter()
                .chain(&problem.v)
                .nth(k)
                .map_or(0.0, |x| *x),
            Self::Control(k) => match &problem.controls {
                ControlSignal::PiecewiseConstant { values, .. }
                | ControlSignal::PiecewiseLinear { values, .. } => {
                    values.iter().fold(0.0, |most, u| u[k].abs().max(most))
                }
                _ => 0.0,
            },
        };
        if value == 0.0 { 1.0 } else { value.abs() }
    }

    /// The scene and the problem where it is another by `way`. What is that of the scene of start and horizon moves with it.
    pub(super) fn moved(
        self,
        model: &dyn Model,
        problem: &InitialValueProblem,
        way: f64,
    ) -> (Box<dyn Model>, InitialValueProblem) {
        let (mut scene, mut problem) = (model.boxed(), problem.clone());
        let mut start = problem.q.iter_mut().chain(&mut problem.v);
        match self {
            Self::Parameter(index) => {
                let (before, horizon) = (start_of(model), model.horizon());
                scene.set_parameter(index, model.parameter(index) + way);
                for (own, (before, after)) in start.zip(before.iter().zip(start_of(&*scene))) {
                    *own = if own == before { after } else { *own };
                }
                if horizon == Some(problem.horizon) {
                    problem.horizon = scene.horizon().unwrap_or(problem.horizon);
                }
            }
            Self::Start(k) => {
                if let Some(own) = start.nth(k) {
                    *own += way;
                }
            }
            Self::Control(k) => {
                let controls = &mut problem.controls;
                if matches!(controls, ControlSignal::Zero) {
                    let count = model.declaration().controls.len();
                    *controls = ControlSignal::constant(&vec![0.0; count]);
                }
                if let ControlSignal::PiecewiseConstant { values, .. }
                | ControlSignal::PiecewiseLinear { values, .. } = controls
                {
                    values.iter_mut().for_each(|u| u[k] += way);
                }
            }
        }
        (scene, problem)
    }
}

/// The start `(q, v)` that a scene declares.
fn start_of(model: &dyn Model) -> Vec<f64> {
    let n = model.declaration().coordinates.len();
    let mut start = vec![0.0; 2 * n];
    let (q, v) = start.split_at_mut(n);
    model.start(q, v);
    start
}

/// The quantities, and the derivatives of the scene by them.
pub(super) struct Quantities {
    pub(super) names: Vec<String>,
    pub(super) by: Vec<By>,
    /// Indices of the parameters with derivatives.
    pub(super) parameters: Vec<usize>,
    pub(super) derivatives: Arc<ParameterDerivatives>,
}

/// The name that stands for all parameters.
const ALL: &str = "all";

impl Quantities {
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
        let twice = (1..wanted.len()).find(|&index| wanted[..index].contains(&wanted[index]));
        if let Some(index) = twice {
            return Err(InputError::new(format!(
                "the gradient by `{}` is asked for twice; name it once",
                wanted[index]
            )));
        }
        let by = wanted.iter().map(|name| By::named(model, name));
        let by: Vec<By> = by.collect::<Result<_, InputError>>()?;
        let mut parameters: Vec<usize> = (by.iter())
            .filter_map(|by| match by {
                By::Parameter(index) => Some(*index),
                _ => None,
            })
            .collect();
        parameters.sort_unstable();
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
                "a gradient of `{}` is not supported: its derivatives by parameters are too large; split the mechanism into \
                 smaller scenes",
                declaration.name
            ))
        })?;
        Ok(Self {
            names: wanted,
            by,
            parameters,
            derivatives: Arc::from(derivatives),
        })
    }

    /// How many quantities there are.
    pub(super) fn count(&self) -> usize {
        self.by.len()
    }

    /// The layout of derivatives by them.
    pub(super) fn layout(&self, model: &dyn Model) -> Layout {
        Layout::of(model, self.parameters.len())
    }

    /// Derivatives that know nothing of parameters but of one, if there are more parameters than components of the state, which would cost
    /// more than to know the others only where a step is solved.
    pub(super) fn lean(&self, model: &dyn Model) -> Option<Arc<ParameterDerivatives>> {
        let many = self.parameters.len() > 2 * model.declaration().coordinates.len();
        let lean = many.then(|| model.parameter_derivatives(&[0])).flatten();
        lean.map(Arc::from)
    }

    /// The sizes of the quantities.
    pub(super) fn sizes(&self, model: &dyn Model, problem: &InitialValueProblem) -> Vec<f64> {
        self.by.iter().map(|by| by.size(model, problem)).collect()
    }

    /// Derivatives at the start of a motion, before joints complete it: what is that of the scene moves with it.
    pub(super) fn start(&self, model: &dyn Model, problem: &InitialValueProblem) -> Tangent {
        let layout = self.layout(model);
        let n = layout.n;
        let mut by_parameters = vec![0.0; 2 * n * layout.parameters];
        self.derivatives.start(&mut by_parameters);
        let declared = start_of(model);
        let given = problem.q.iter().chain(&problem.v);
        let of_scene: Vec<bool> = given
            .zip(&declared)
            .map(|(own, known)| own == known)
            .collect();
        let mut start = Tangent::zeros(layout, self.count());
        for (column, by) in self.by.iter().enumerate() {
            let mut set = |row: usize, value: f64| start.all.row_mut(row)[column] = value;
            match *by {
                By::Parameter(index) => {
                    let place = self.parameters.binary_search(&index);
                    let parameter = place.unwrap_or_default();
                    set(layout.first_parameter() + parameter, 1.0);
                    for (i, _) in of_scene.iter().enumerate().filter(|(_, own)| **own) {
                        set(i, by_parameters[i * layout.parameters + parameter]);
                    }
                }
                By::Start(component) => set(component, 1.0),
                By::Control(control) => set(2 * n + control, 1.0),
            }
        }
        start
    }

    /// Derivatives of the horizon by the parameters, 0 if that is not the one of the scene.
    pub(super) fn horizon(&self, model: &dyn Model, problem: &InitialValueProblem) -> Vec<f64> {
        let mut by_parameters = vec![0.0; self.parameters.len()];
        if model.horizon() == Some(problem.horizon) {
            self.derivatives.horizon(&mut by_parameters);
        }
        by_parameters
    }
}
