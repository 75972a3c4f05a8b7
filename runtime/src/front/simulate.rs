//! `simulate(&model)`.

use super::StartValues;
use crate::derivative::{Gradient, GradientMode, add_one_sided, differentiate_values};
use crate::model::Model;
use crate::simulation::{
    ControlSignal, Fesd, InitialValueProblem, InputError, Simulation, Simulator,
};
use crate::{Observer, Progress};

/// Simulates a scene as it declares: from its start over its horizon, without controls, by finite elements, or from event to event
/// where these fail.
/// [`Simulate`] changes any of that.
///
/// ```
/// use hangtime::prelude::*;
///
/// hangtime::model! {
///     /// A ball above a floor.
///     pub Ball {
///         parameters { m: kg = 1, g: m/s^2 = 9.81 }
///         coordinates { z: m }
///         lagrangian m/2*dot(z)^2 - m*g*z
///         surface floor: z >= 0
///         impact floor: inelastic
///         start { z: 1 [m] }
///         horizon 1 [s]
///     }
/// }
///
/// let run = simulate(&Ball::default()).run()?;
/// println!("{run}");
/// assert!((run.events[0].time - (2.0_f64 / 9.81).sqrt()).abs() < 1e-9);
/// assert!(run.at(0.9)?["z"].abs() < 1e-9);
/// # Ok::<(), InputError>(())
/// ```
pub fn simulate(model: &dyn Model) -> Simulate<'_> {
    Simulate {
        model,
        method: Box::new(Fesd {
            hands_over: true,
            ..Fesd::default()
        }),
        tolerance: None,
        max_step: None,
        steps: None,
        horizon: None,
        start: StartValues::default(),
        controls: ControlSignal::Zero,
        points: InitialValueProblem::DEFAULT_POINTS,
        gradient_of: Vec::new(),
        gradient_mode: None,
        observer: None,
    }
}

/// A simulation that is about to [`run`](Self::run); made by [`simulate`].
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A ball above a floor.
/// #     pub Ball {
/// #         parameters { m: kg = 1, g: m/s^2 = 9.81 }
/// #         coordinates { z: m }
/// #         lagrangian m/2*dot(z)^2 - m*g*z
/// #         surface floor: z >= 0
/// #         impact floor: inelastic
/// #         start { z: 1 [m] }
/// #         horizon 1 [s]
/// #     }
/// # }
/// let ball = Ball::default();
/// let run = simulate(&ball)
///     .method(EventDriven::default())
///     .tolerance(1e-12)
///     .start("dot(z)", 2.0)
///     .horizon(0.2)
///     .run()?;
/// assert!((run.at(0.2)?["dot(z)"] - (2.0 - 9.81 * 0.2)).abs() < 1e-12);
/// # Ok::<(), InputError>(())
/// ```
#[must_use = "nothing is simulated before `run`"]
pub struct Simulate<'a> {
    model: &'a dyn Model,
    method: Box<dyn Simulator + 'a>,
    tolerance: Option<f64>,
    max_step: Option<f64>,
    steps: Option<usize>,
    horizon: Option<f64>,
    start: StartValues,
    controls: ControlSignal,
    points: usize,
    gradient_of: Vec<String>,
    gradient_mode: Option<GradientMode>,
    observer: Option<Box<Observer<'a>>>,
}

impl<'a> Simulate<'a> {
    /// The method, with its settings; default [`Fesd`], and [`EventDriven`](crate::simulation::EventDriven) where that fails.
    pub fn method(mut self, method: impl Simulator + 'a) -> Self {
        self.method = Box::new(method);
        self
    }

    /// Tolerance of the method, see [`Fesd::tolerance`], [`EventDriven::tolerance`](crate::simulation::EventDriven) and
    /// [`Smooth::tolerance`](crate::baselines::Smooth); the others are refused.
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = Some(tolerance);
        self
    }

    /// Longest step \[s\] of methods that locate events; the others are refused. For doubt, not for use: no event is between the steps.
    pub fn max_step(mut self, seconds: f64) -> Self {
        self.max_step = Some(seconds);
        self
    }

    /// Number of equal steps of the method: of [`Fesd`], [`Moreau`](crate::baselines::Moreau) or
    /// [`FixedStep`](crate::baselines::FixedStep); the others are refused.
    pub fn steps(mut self, steps: usize) -> Self {
        self.steps = Some(steps);
        self
    }

    /// Length of the simulation \[s\]; default the declared one.
    pub fn horizon(mut self, seconds: f64) -> Self {
        self.horizon = Some(seconds);
        self
    }

    /// Initial value of a coordinate, `"z"`, or of a velocity, `"dot(z)"`, in the unit of the coordinate; default the
    /// declared one.
    pub fn start(mut self, name: &str, value: f64) -> Self {
        self.start.set(name, value);
        self
    }

    /// Controls over time; default all zero.
    pub fn controls(mut self, controls: ControlSignal) -> Self {
        self.controls = controls;
        self
    }

    /// Most points of the trajectory, see [`InitialValueProblem::points`].
    pub fn points(mut self, points: usize) -> Self {
        self.points = points;
        self
    }

    /// What [`gradient`](Self::gradient) is of: these values at the end alone, `"objective"`, `"z"`, `"dot(z)"`, or outputs; default
    /// the whole motion. See [`differentiate_values`].
    pub fn gradient_of<'n>(mut self, names: impl IntoIterator<Item = &'n str>) -> Self {
        self.gradient_of = names.into_iter().map(str::to_owned).collect();
        self
    }

    /// How those values are differentiated; default backwards where they are fewer than what they are differentiated by.
    pub fn gradient_mode(mut self, mode: GradientMode) -> Self {
        self.gradient_mode = Some(mode);
        self
    }

    /// Sees the progress after every step; where it returns `false`, the run ends as
    /// [`Interrupted`](crate::simulation::SimulationStatus::Interrupted).
    pub fn observer(mut self, observer: impl FnMut(&Progress) -> bool + Send + 'a) -> Self {
        self.observer = Some(Box::new(observer));
        self
    }

    /// Simulates.
    ///
    /// # Errors
    /// [`InputError`] if anything that was asked for is refused before the first step; what happens later is the
    /// [`status`](Simulation::status) of the result.
    pub fn run(self) -> Result<Simulation, InputError> {
        Ok(self.simulated()?.2)
    }

    /// Simulates, and differentiates the motion by the quantities of these names, as
    /// [`differentiate`](crate::derivative::differentiate) says, with derivatives to one side where there are no others. The method is to be one that locates events.
    ///
    /// # Errors
    /// As of [`run`](Self::run), and [`InputError`] for names that are unknown and scenes without derivatives by parameters.
    pub fn gradient<'n>(
        mut self,
        names: impl IntoIterator<Item = &'n str>,
    ) -> Result<(Simulation, Gradient), InputError> {
        let names: Vec<String> = names.into_iter().map(str::to_owned).collect();
        let model = self.model;
        let (of, mode) = (std::mem::take(&mut self.gradient_of), self.gradient_mode);
        let (method, problem, run) = self.simulated()?;
        let mut gradient = differentiate_values(model, (&problem, &run), &names, (&of, mode))?;
        let mut neighbour = |model: &dyn Model, problem: &InitialValueProblem| {
            method.simulate(model, problem, &mut |_| true)
        };
        add_one_sided(&mut gradient, (model, &problem), &run, &mut neighbour);
        Ok((run, gradient))
    }

    fn simulated(mut self) -> Result<Simulated<'a>, InputError> {
        if let Some(steps) = self.steps {
            self.method.set_steps(steps)?;
        }
        if let Some(tolerance) = self.tolerance {
            self.method.set_tolerance(tolerance)?;
        }
        if let Some(seconds) = self.max_step {
            self.method.set_max_step(seconds)?;
        }
        let mut problem = InitialValueProblem::of(self.model, self.horizon)?;
        let declaration = self.model.declaration();
        self.start
            .write(declaration, &mut problem.q, &mut problem.v)?;
        problem.controls = self.controls;
        problem.points = self.points;
        let run = match self.observer {
            Some(mut observer) => self.method.simulate(self.model, &problem, &mut *observer),
            None => self.method.simulate(self.model, &problem, &mut |_| true),
        }?;
        Ok((self.method, problem, run))
    }
}

/// How a motion was simulated, from where, and what it is.
type Simulated<'a> = (Box<dyn Simulator + 'a>, InitialValueProblem, Simulation);
