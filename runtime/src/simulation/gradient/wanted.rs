//! What a motion is differentiated by.

use std::sync::Arc;

use super::matrix::Matrix;
use crate::InputError;
use crate::model::{Model, ParameterDerivatives};
use crate::simulation::InitialValueProblem;
use crate::simulation::quantity::Quantity;

/// One quantity that a motion is differentiated by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum By {
    /// The parameter that is the `k`-th of those with derivatives.
    Parameter(usize),
    /// Component `k` of the initial `(q, v)`.
    Start(usize),
    /// Control `k`, changed by the same at all times.
    Control(usize),
    /// Something of the state and of the impulses at present, which nothing else depends on.
    Present,
    /// The time, with which controls change at these rates.
    Time,
}

/// The quantities, and the derivatives of the scene by them.
#[derive(Clone)]
pub(super) struct Wanted {
    pub(super) names: Vec<String>,
    by: Vec<By>,
    /// Shares of all quantities, where the motion is differentiated along this one direction of them.
    direction: Option<Vec<f64>>,
    /// Rates of controls, where the motion goes on in time.
    control_rates: Vec<f64>,
    explicit_time: bool,
    pub(super) derivatives: Arc<dyn ParameterDerivatives>,
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
                "a gradient of `{}` is not supported: its derivatives by parameters are too large, or those of a model that was \
                 written by hand; declare it by `model!` or in a file",
                declaration.name
            ))
        })?;
        Ok(Self {
            names: wanted,
            by,
            direction: None,
            control_rates: Vec::new(),
            explicit_time: declaration.explicit_time,
            derivatives: Arc::from(derivatives),
            inputs: declaration.inputs(),
            n: declaration.coordinates.len(),
            parameters: parameters.len(),
        })
    }

    /// How many quantities there are.
    pub(super) fn count(&self) -> usize {
        self.direction.as_ref().map_or(self.by.len(), |_| 1)
    }

    /// The same quantities with derivatives that know nothing of parameters but of one, if there are more.
    pub(super) fn without_parameters(&self, model: &dyn Model) -> Option<Self> {
        if self.parameters < 2 {
            return Some(self.clone());
        }
        Some(Self {
            by: Vec::new(),
            names: Vec::new(),
            derivatives: Arc::from(model.parameter_derivatives(&[0])?),
            parameters: 1,
            ..self.clone()
        })
    }

    /// One direction in which all quantities change at once, by these shares.
    pub(super) fn along_direction(&self, shares: Vec<f64>) -> Self {
        Self {
            direction: Some(shares),
            ..self.clone()
        }
    }

    /// The same quantities behind `present` changes of the state and the impulses.
    pub(super) fn behind(&self, present: usize) -> Self {
        let mut by = vec![By::Present; present];
        by.extend(&self.by);
        Self { by, ..self.clone() }
    }

    /// The time alone, with which controls change at these rates.
    pub(super) fn in_time(&self, control_rates: Vec<f64>) -> Self {
        Self {
            by: vec![By::Time],
            direction: None,
            control_rates,
            ..self.clone()
        }
    }

    /// What controls change by with time, with derivatives by `(q, v, u)` first.
    fn through_controls(&self, by: &[f64]) -> f64 {
        let pairs = by[2 * self.n..].iter().zip(&self.control_rates);
        pairs.map(|(by, rate)| by * rate).sum()
    }

    /// What quantity `k` of these values is, or their sum along the direction.
    fn over(&self, k: usize, value: impl Fn(By) -> f64) -> f64 {
        match &self.direction {
            None => value(self.by[k]),
            Some(shares) => {
                let pairs = self.by.iter().zip(shares);
                pairs.map(|(&by, share)| share * value(by)).sum()
            }
        }
    }

    /// The size of quantity `k`: its value, or 1 where that is 0, and of controls.
    pub(super) fn size(&self, k: usize, model: &dyn Model, problem: &InitialValueProblem) -> f64 {
        let value = match self.by[k] {
            By::Parameter(_) => {
                let mut parameters = model.declaration().parameters.iter();
                let index = parameters.position(|known| known.name == self.names[k]);
                index.map_or(1.0, |index| model.parameter(index))
            }
            By::Start(i) if i < self.n => problem.q[i],
            By::Start(i) => problem.v[i - self.n],
            By::Control(_) | By::Present | By::Time => 1.0,
        };
        if value == 0.0 { 1.0 } else { value.abs() }
    }

    /// How a function with these derivatives by the input vector and the parameters changes with quantity `k` itself.
    pub(super) fn own(&self, by: &[f64], k: usize) -> f64 {
        self.over(k, |own| match own {
            By::Parameter(parameter) => by[self.inputs + parameter],
            By::Control(control) => by[2 * self.n + control],
            By::Time if self.explicit_time => by[self.inputs - 1] + self.through_controls(by),
            By::Time => self.through_controls(by),
            By::Start(_) | By::Present => 0.0,
        })
    }

    /// The same of a function with these derivatives by the parameters.
    pub(super) fn of_parameters(&self, by: &[f64], k: usize) -> f64 {
        self.over(k, |own| match own {
            By::Parameter(parameter) => by[parameter],
            By::Control(_) | By::Start(_) | By::Present | By::Time => 0.0,
        })
    }

    /// The same of a function with derivatives by `(q, v, u, t)` first, where the time is number `time`, and by the parameters from
    /// `first` on.
    pub(super) fn of_output(&self, by: &[f64], (time, first): (usize, usize), k: usize) -> f64 {
        self.over(k, |own| match own {
            By::Parameter(parameter) => by[first + parameter],
            By::Control(control) => by[2 * self.n + control],
            By::Time => by[time] + self.through_controls(by),
            By::Start(_) | By::Present => 0.0,
        })
    }

    /// Derivative at a fixed time by quantity `k` of a function with these derivatives, where the state changes by column
    /// `k` of `state`.
    pub(super) fn along(&self, by: &[f64], state: &Matrix, k: usize) -> f64 {
        let states = 0..2 * self.n;
        let through: f64 = states.map(|i| by[i] * state.row(i)[k]).sum();
        through + self.own(by, k)
    }

    /// Number of columns of the derivatives: the input vector and the parameters.
    pub(super) fn columns(&self) -> usize {
        self.inputs + self.parameters
    }

    /// The place of quantity `k` among the parameters with derivatives, if it is one and alone.
    pub(super) fn parameter(&self, k: usize) -> Option<usize> {
        match self.by[k] {
            By::Parameter(parameter) if self.direction.is_none() => Some(parameter),
            _ => None,
        }
    }

    /// Derivative of component `i` of the initial `(q, v)` by quantity `k`, if the start is that of the scene.
    pub(super) fn of_start(&self, start: &[f64], i: usize, k: usize, declared: bool) -> f64 {
        self.over(k, |own| match own {
            By::Parameter(parameter) if declared => start[i * self.parameters + parameter],
            By::Start(component) if component == i => 1.0,
            _ => 0.0,
        })
    }

    /// Derivatives of the horizon, if that is the one of the scene.
    pub(super) fn of_horizon(&self, model: &dyn Model, problem: &InitialValueProblem) -> Vec<f64> {
        let mut by_parameters = vec![0.0; self.parameters];
        if model.horizon() == Some(problem.horizon) {
            self.derivatives.horizon(&mut by_parameters);
        }
        let columns = 0..self.count();
        columns
            .map(|k| self.of_parameters(&by_parameters, k))
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
